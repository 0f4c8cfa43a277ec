"""Pairs the statements of two programs without running them.

Both programs are printed as pseudo-program text in which places are numbers, tools and frames are
poses, paired signals have one name, and data is numbered in order of use. Names and vendor words
make no difference; order and structure do.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from difflib import SequenceMatcher
from itertools import zip_longest
from typing import Any, Final

from assistant.compiler.motion_sides import ProgramPair
from assistant.compiler.source_map import Place, Places
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import BASE, FLANGE, Pose, Target
from assistant.program.program import Procedure, Program, walk
from assistant.program.pseudo.printer import block_text
from assistant.program.pseudo.statements import statement_text
from assistant.program.rewriting import head, rewrite
from assistant.program.statement_index import records_in_procedures

STATEMENTS_LEFT_OUT: Final = (p.Comment, p.Label)
NUMBER_TEXT: Final = re.compile(r"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
CLOSE_NUMBERS: Final = 0.02
"""Mm and degrees that numbers may be apart, as typed with two decimals."""
CLOSE_SMALL_NUMBERS: Final = 5e-4
"""The same of numbers up to 1, as the parts of a quaternion are."""


@dataclass(frozen=True, slots=True)
class StatementRow:
    """A pair of statements, None where a program has no counterpart. alike: both say the same."""

    first: Place | None
    second: Place | None
    alike: bool


PrintedStatement = tuple[str, Any]
"""A statement without names of its own, and its span."""


def statement_rows(pair: ProgramPair, first: Places, second: Places) -> Iterator[StatementRow]:
    """Yield the pairs in order. first, second: where the texts of the programs are."""
    own, others = (
        list(_NamelessPrinter(program, pair, is_second).all())
        for program, is_second in ((pair.first, False), (pair.second, True))
    )
    for one, other in _paired_rows(own, others):
        alike = one is not None and other is not None and _are_alike(one[0], other[0])
        yield StatementRow(_statement_place(one, first), _statement_place(other, second), alike)


def _paired_rows(
    own: list[PrintedStatement], others: list[PrintedStatement], *, by_numbers: bool = True
) -> Iterator[tuple[PrintedStatement | None, PrintedStatement | None]]:
    """Those that say the same; between them those of the same words, whatever the numbers."""
    mine, theirs = (
        [text if by_numbers else NUMBER_TEXT.sub("#", text) for text, _ in told]
        for told in (own, others)
    )
    for what, a, b, c, d in SequenceMatcher(None, mine, theirs, autojunk=False).get_opcodes():
        if what == "equal":
            yield from zip(own[a:b], others[c:d], strict=True)
        elif what == "replace" and by_numbers:
            yield from _paired_rows(own[a:b], others[c:d], by_numbers=False)
        else:
            yield from zip_longest(own[a:b], others[c:d])


def _statement_place(told: PrintedStatement | None, places: Places) -> Place | None:
    found = None if told is None or told[1] is None else places.of(told[1])
    return None if found is None else replace(found, text=found.text.strip())


def _are_alike(one: str, other: str) -> bool:
    """Whether two statements have the same words, and numbers that are close."""
    if NUMBER_TEXT.sub("#", one) != NUMBER_TEXT.sub("#", other):
        return False
    numbers = zip(NUMBER_TEXT.findall(one), NUMBER_TEXT.findall(other), strict=True)
    return all(_are_close(float(a), float(b)) for a, b in numbers)


def _are_close(one: float, other: float) -> bool:
    return abs(one - other) <= (
        CLOSE_SMALL_NUMBERS if max(abs(one), abs(other)) <= 1.0 else CLOSE_NUMBERS
    )


@dataclass
class _NamelessPrinter:
    """Prints the statements of a program without its own names."""

    program: Program
    pair: ProgramPair
    is_second: bool
    data: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.signals = {
            name.lower(): str(one.number)
            for name, one in self.pair.signals.items()
            if one.number is not None
        }
        self.own_name = {other: own for own, other in self.pair.names.items()}
        known = (self.pair.first.variables, self.pair.second.variables)
        self.common = set.intersection(*({name.lower() for name in names} for names in known))
        self.places = {name.lower(): one for name, one in self.program.targets.items()}
        self.joints = {name.lower(): one for name, one in self.program.joint_targets.items()}
        self.speeds = {name.lower(): one for name, one in self.program.speeds.items()}
        self.blends = {name.lower(): one for name, one in self.program.blends.items()}

    def all(self) -> Iterator[tuple[str, Any]]:
        for at, procedure in enumerate(self._in_order()):
            if at:
                yield "procedure", procedure.span
            for statement in walk(procedure.body):
                if not isinstance(statement, STATEMENTS_LEFT_OUT):
                    yield self._text(statement), statement.span

    def _in_order(self) -> Sequence[Procedure]:
        """The procedure that begins, then the others as they are called."""
        entry = self.program.procedure(self.program.entry) if self.program.entry else None
        calls = [one.procedure.lower() for one in records_in_procedures(self.program, p.Call)]
        order = {name: at for at, name in enumerate(dict.fromkeys(calls))}
        others = [one for one in self.program.procedures if one is not entry]
        others.sort(key=lambda one: order.get(one.name.lower(), len(order)))
        return [entry, *others] if entry is not None else others

    def _text(self, statement: Any) -> str:
        plain = rewrite(head(statement), self._plain)
        text = statement_text(plain)
        return block_text(plain) if text is None else text

    def _plain(self, part: Any) -> Any:
        match part:
            case e.Name(name):
                return self._value(name)
            case p.WaitSignal() | p.SetSignal() | p.Trigger():
                return replace(part, signal=self._signal(part.signal))
            case p.Call():
                return replace(part, procedure="called")
            case p.Motion():
                return self._motion(part)
            case p.Move("joint", motion=motion):
                return replace(part, motion=replace(motion, speed=NO_SPEED))
            case Target(pose):
                return Target(_rounded_pose(pose))
            case p.For(variable):
                return replace(part, variable=self._data(variable))
        return part

    def _value(self, name: str) -> e.Expression:
        low = name.lower()
        if low in self.places:
            return e.TargetValue(Target(_rounded_pose(self.places[low].pose)))
        if low in self.joints:
            return e.JointValue(self.joints[low])
        if low in self.signals or low in (one.lower() for one in self.program.signals):
            return e.Name(self._signal(name))
        return e.Name(self._data(name))

    def _signal(self, name: str) -> str:
        low = name.lower()
        number = self.signals.get(low)
        shown = self.own_name.get(low, low) if self.is_second else low
        return f"signal_{shown if number is None else number}"

    def _data(self, name: str) -> str:
        low = self.own_name.get(name.lower(), name.lower()) if self.is_second else name.lower()
        if low in self.common or low in self.pair.names:
            return f"data_{low}"
        return self.data.setdefault(low, f"data_{len(self.data) + 1}")

    def _motion(self, motion: p.Motion) -> p.Motion:
        speed, blend = motion.speed, motion.blend
        if isinstance(speed, e.Name):
            speed = self.speeds.get(speed.name.lower(), speed)
        if isinstance(blend, e.Name):
            blend = self.blends.get(blend.name.lower(), blend)
        tool = self.program.tools.get(motion.tool)
        frame = self.program.frames.get(motion.frame)
        return p.Motion(
            speed,
            blend,
            motion.tool if tool is None else _pose_name(FLANGE, tool.tip),
            motion.frame if frame is None else _pose_name(BASE, frame.pose),
        )


NO_SPEED: Final = e.Name("speed")
"""Of joint moves, which are percentages of an arm's own."""


def _pose_name(word: str, pose: Pose) -> str:
    """A name for what stands at a place."""
    numbers = [*pose.position, *_positive_quaternion(pose)]
    shown = "_".join(f"{value:.1f}" for value in numbers).replace("-", "m").replace(".", "p")
    return word if pose == Pose() else f"{word}_{shown}"


def _rounded_pose(pose: Pose) -> Pose:
    x, y, z = (round(value, 2) + 0.0 for value in pose.position)
    w, a, b, c = (round(value, 4) + 0.0 for value in _positive_quaternion(pose))
    return Pose((x, y, z), (w, a, b, c))


def _positive_quaternion(pose: Pose) -> tuple[float, ...]:
    """The quaternion of two whose largest part is positive."""
    largest = max(pose.quaternion, key=abs)
    return tuple(value if largest > 0.0 else -value for value in pose.quaternion)

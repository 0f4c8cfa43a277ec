"""Programs of a proof: how a program of each language is run, and put into another cell.

A program in another cell is its text with the tools and frames that differ there.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Final

from assistant import languages
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span
from assistant.base.source_text import SourceText
from assistant.languages.rapid.tree import syntax as rapid
from assistant.languages.rapid.tree.literals import carrying_unit, still_frame_name
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.geometry import Frame, Pose
from assistant.program.passes.operator_texts import is_operators
from assistant.virtual.events import Branches
from assistant.virtual.kernel import Kernel
from assistant.virtual.proving.comparison import Printed
from assistant.virtual.proving.driver import Wiring

if TYPE_CHECKING:
    from assistant.robots import Robot
    from assistant.virtual.kernel.script import Script
    from assistant.virtual.rapid.controller import Controller as RapidController


PLAIN_START: Final = Pose((400.0, 0.0, 500.0), (0.0, 0.0, 1.0, 0.0))
"""Flange before the first motion of a program without a robot: the same in both."""
PLAIN_JOINTS: Final = (0.0, 0.0, 90.0, 0.0, 90.0, 0.0)
"""Degrees of its joints there, on an arm of which nothing else is known."""
PSEUDO: Final = "pseudo"
STATEMENT_TIME: Final = 0.002
"""Seconds that a statement takes, so that a loop which looks at a clock comes to its end."""


_LONG_AGO: Final = 1_000_000
"""Milliseconds that timers show before a program sets them."""
Held = dict[str, float | str]
"""Values of shared data, by the names of the source."""

CYCLES: Final = 3
"""That are compared where one leaves values to the next: in many a number grows beyond bounds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Side:
    """A program that is run. family: that of its language, PSEUDO for a pseudo-program. trees:
    those of its files, the first one first, or the pseudo-program.

    start: pose of the flange. joints: degrees there, None if unknown. entry: the routine that it
    begins with. wiring: its names of the inputs. outputs: its names of one-bit outputs, by their
    names in the other program. shared: names in the source of numbers, truths and texts that
    outlive a run, by their names here in lower case. repeats: it begins again after its end.
    lenient: unset numbers are 0, where the manuals leave open whether a controller reports them or
    ends: the translation reports each.
    """

    family: str
    trees: Sequence[Any]
    robot: Robot | None = None
    start: Pose = PLAIN_START
    joints: tuple[float, ...] | None = None
    entry: str = "main"
    wiring: Wiring = field(default_factory=Wiring)
    outputs: Mapping[str, str] = field(default_factory=dict)
    lenient: bool = False
    repeats: bool = False
    shared: Mapping[str, str] = field(default_factory=dict)

    @property
    def answers(self) -> bool:
        """True if inputs answer the program's questions."""
        return any(map(is_operators, self.wiring.named))

    def begin(self, kernel: Kernel) -> None:
        """Has the program run as soon as the kernel does."""
        _LANGUAGE_KINDS[self.family].begin(self, kernel)

    def scripted(self, script: Script) -> Script:
        """A script that may name outputs as the other program does."""
        from assistant.virtual.kernel.script import When

        changes = [
            one
            if not isinstance(one.when, When) or one.when.is_input
            else replace(one, when=replace(one.when, name=self._own(one.when.name)))
            for one in script.changes
        ]
        return replace(script, changes=tuple(changes))

    def _own(self, name: str) -> str:
        return self.outputs.get(name, name)

    def branches(self) -> Branches:
        return _LANGUAGE_KINDS[self.family].branches(self.trees)

    def constants(self) -> Iterator[tuple[Pose, Printed]]:
        """Poses that its text holds, and what it prints of them; none where it is all the same."""
        return _LANGUAGE_KINDS[self.family].constants(self.text())

    def sources(self) -> list[SourceText]:
        """Return the sources of all files; a pseudo-program has none."""
        found = [getattr(tree, "source", None) for tree in self.trees]
        return [source for source in found if source is not None]

    def text(self) -> str:
        """Return the text of all files."""
        return "\n".join(source.text for source in self.sources())


def can_run(family: str) -> bool:
    """True if a family of languages has an interpreter."""
    return family in _LANGUAGE_KINDS


def counts_signals(family: str) -> bool:
    """True if programs of a family use signals by their numbers."""
    return _LANGUAGE_KINDS[family].counts_signals


@dataclass(frozen=True, slots=True)
class _LanguageKind:
    begin: Callable[[Side, Kernel], None]
    branches: Callable[[Sequence[Any]], Branches]
    counts_signals: bool
    constants: Callable[[str], Iterator[tuple[Pose, Printed]]]


def _begin_rapid(side: Side, kernel: Kernel) -> None:
    from assistant.virtual.rapid.controller import Controller, Options
    from assistant.virtual.rapid.interpreter import again_and_again, start_task

    controller = Controller(Options(sockets=False))  # to prove a program is not to trust it
    cell = {name.lower() for name in side.outputs.values()}  # also those that are only read
    controller.outputs |= cell
    controller.known |= cell
    if side.shared:
        kernel.kept = lambda: _held_in_rapid(controller, side.shared)
    there, loaded = _separate_loaded(side.trees)
    # Files that a program loads are on the disk of the controller, not in its memory.
    for tree in loaded:
        name = _file_name(tree)
        controller.disk.path(name).write_text(tree.source.text, encoding="utf-8")
    start_task(
        kernel,
        there,
        robot=side.robot,
        entry=side.entry,
        start=side.start,
        joints=side.joints,
        controller=controller,
        cycles=again_and_again(side.entry, CYCLES) if side.repeats else None,
    )


def _held_in_rapid(controller: RapidController, names: Mapping[str, str]) -> Held:
    from assistant.virtual.rapid.scopes import Cell

    found: Held = {}
    for loaded, _ in controller.programs:
        for known in (loaded.named, *(unit.names for unit in loaded.units.values())):
            for own, name in names.items():
                cell = known.get(own)
                if isinstance(cell, Cell) and isinstance(cell.value, float | str | bool):
                    found[name] = cell.value if isinstance(cell.value, str) else float(cell.value)
    return found


def _separate_loaded(trees: Sequence[Any]) -> tuple[tuple[Any, ...], list[Any]]:
    """Return the files that are present from the start, and those that a program loads while it
    runs.

    Files named in a list of modules are present from the start.
    """
    rapid = languages.get("rapid")
    called = (name for tree in trees if tree.modules for name in rapid.called_files(tree))
    names = {PurePath(name.replace("\\", "/")).name.lower() for name in called}
    # The first tree is the entry, and is there from the start whatever loads it.
    loaded = [tree for tree in trees[1:] if tree.source and _file_name(tree).lower() in names]
    there = tuple(tree for tree in trees if not any(tree is one for one in loaded))
    return there, loaded


def _file_name(tree: Any) -> str:
    return PurePath((tree.source and tree.source.path) or "").name


def _begin_melfa(side: Side, kernel: Kernel) -> None:
    from assistant.virtual.melfa import start_slot
    from assistant.virtual.melfa.options import Options

    names = [PurePath((tree.source and tree.source.path) or "").stem for tree in side.trees]
    # What is written here is the same if they turn; a timer that nothing sets shows any time.
    options = Options(slides=True, shared="zero", timers=_LONG_AGO)
    start_slot(
        kernel,
        list(side.trees),
        robot=side.robot,
        start=side.start,
        joints=side.joints,
        names=names,
        options=replace(options, unset="zero", signed=False) if side.lenient else options,
        shared=side.shared,
    )


def _begin_pseudo(side: Side, kernel: Kernel) -> None:
    from assistant.virtual.pseudo import start_program

    (program,) = side.trees
    start_program(
        kernel, program, robot=side.robot, start=side.start, cycles=CYCLES if side.repeats else 1
    )


def _no_branches(_: Sequence[Any]) -> Branches:
    """Those of a pseudo-program are not told."""
    return {}


def _rapid_branches(trees: Sequence[Any]) -> Branches:
    from assistant.virtual.rapid.statements import branches

    return branches(trees)


def _melfa_branches(trees: Sequence[Any]) -> Branches:
    from assistant.virtual.melfa.code import branches

    return branches(trees)


def _no_constants(_: str) -> Iterator[tuple[Pose, Printed]]:
    yield from ()


def _melfa_constants(text: str) -> Iterator[tuple[Pose, Printed]]:
    """Positions with the decimals that they have, as `P1=(+400.00,...)`."""
    from assistant.virtual.melfa.arm_state import pose_of
    from assistant.virtual.melfa.values import Position, eight

    for written in re.findall(r"\(((?:[-+]?\d+\.\d+,){5}[-+]?\d+\.\d+)\)", text):
        numbers = written.split(",")
        # A printed decimal is at most half a unit of its last digit away from the value.
        halves = [0.5 * 10.0 ** -len(number.partition(".")[2]) for number in numbers]
        pose = pose_of(Position(eight(tuple(map(float, numbers)))))
        yield pose, Printed(max(halves[:3]), sum(halves[3:]))


_LANGUAGE_KINDS: Final[Mapping[str, _LanguageKind]] = {
    "RA": _LanguageKind(
        _begin_rapid, _rapid_branches, counts_signals=False, constants=_no_constants
    ),
    PSEUDO: _LanguageKind(
        _begin_pseudo, _no_branches, counts_signals=False, constants=_no_constants
    ),
    "MB": _LanguageKind(
        _begin_melfa, _melfa_branches, counts_signals=True, constants=_melfa_constants
    ),
}
"""By the family of a language."""


@dataclass(frozen=True, slots=True)
class Cell:
    """tools: their tips, by name in lower case. frames: of work pieces. standing: of what
    mechanical units carry, which stand still.
    """

    tools: Mapping[str, Pose] = field(default_factory=dict)
    frames: Mapping[str, Frame] = field(default_factory=dict)
    standing: Mapping[str, Pose] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.tools or self.frames or self.standing)


def with_equipment(family: str, tree: object, cell: Cell) -> tuple[SourceText, set[str]]:
    """The text of a file with the values of a cell, and the names of those that it declares."""
    assert isinstance(tree, rapid.File) or hasattr(tree, "source")
    source = getattr(tree, "source", None) or SourceText("")
    changes, found = _FAMILIES[family](tree, source.text, cell)
    text = source.text
    # From the end to the start: earlier spans stay valid.
    for span, value in sorted(changes, key=lambda change: -change[0].start):
        text = text[: span.start] + value + text[span.end :]
    return replace(source, text=text), found


Change = tuple[Span, str]


def _unchanged_text(value: rapid.Expression) -> str:
    """A value that is written out, as text."""
    match value:
        case rapid.AggregateNode(items):
            return f"[{','.join(map(_unchanged_text, items))}]"
        case rapid.Prefix(operator, operand):
            return operator + _unchanged_text(operand)
        case rapid.BoolLiteral(truth):
            return str(truth).upper()
        case rapid.StringLiteral(text):
            return f'"{text}"'
        case rapid.NumberLiteral(number):
            return number
    raise AssertionError(value)


def _equip_rapid(tree: object, text: str, cell: Cell) -> tuple[list[Change], set[str]]:
    """The second part of a tool is its tip, the last two of a work object are its frames."""
    changes: list[Change] = []
    found: set[str] = set()
    for node in nodes(tree.parts if isinstance(tree, rapid.File) else ()):
        # A unit that carries a work piece stands still in
        # the other cell: its frame becomes a fixed one.
        stands = cell.standing.get(still_frame_name(carrying_unit(node)).lower())
        if stands is not None and isinstance(node, rapid.AggregateNode):
            values = zip(node.items[1:4], ("TRUE", '""', _listed_numbers(stands)), strict=True)
            changes += ((item.span, value) for item, value in values if item.span is not None)
        if not isinstance(node, rapid.Data) or not isinstance(node.value, rapid.AggregateNode):
            continue
        name, items = node.name.lower(), node.value.items
        given: list[tuple[int, Pose]] = []
        if node.type.lower() == "tooldata" and name in cell.tools and len(items) == 3:
            given = [(1, cell.tools[name])]
        elif node.type.lower() == "wobjdata" and name in cell.frames and len(items) == 5:
            given = [(3, cell.frames[name].user), (4, cell.frames[name].object)]
        if node.value.span is None and node.span is not None:  # the cell file alone states it
            parts = [_unchanged_text(item) for item in items]
            for place, pose in given:
                parts[place] = _listed_numbers(pose)
                found.add(name)
            # The value belongs before the semicolon, if the span holds it.
            end = node.span.end - text[node.span.start : node.span.end].endswith(";")
            changes.append((Span(end, end), f":=[{','.join(parts)}]"))
            continue
        for place, pose in given:
            span = items[place].span
            if span is not None:
                changes.append((span, _listed_numbers(pose)))
                found.add(name)
    return changes, found


def _listed_numbers(pose: Pose) -> str:
    position, turned = (
        ",".join(map(_number_text, part)) for part in (pose.position, pose.quaternion)
    )
    return f"[[{position}],[{turned}]]"


def _number_text(value: float) -> str:
    # No exponent, which positions may not have; 12 decimals keep a quaternion exact enough.
    return f"{value:.12f}".rstrip("0").rstrip(".")


_TOOL_PARAMETER: Final = re.compile(r"wk\d+cord|mextl\d+", re.IGNORECASE)
"""Names of parameters whose values are in positions with a P before the name."""


def _equip_melfa(tree: object, text: str, cell: Cell) -> tuple[list[Change], set[str]]:  # noqa: ARG001
    """A frame is a base, from which the robot is seen, or a factor of positions."""
    from assistant.virtual.melfa.arm_state import position_of

    short = {name.lower(): own for own, name in re.findall(r"(\w+) = (\w+)", text)}
    changes: list[Change] = []
    found: set[str] = set()
    for name in (*cell.tools, *cell.frames):
        own = short.get(name, f"P?{name}" if _TOOL_PARAMETER.fullmatch(name) else name)
        pose = cell.tools[name] if name in cell.tools else cell.frames[name].pose
        # Base takes the robot as seen from the frame: the inverse of the frame's pose.
        if name not in cell.tools and re.search(rf"(?i)\bBase\s+{own}\b", text):
            pose = pose.inverse()
        values = ",".join(f"{v:+.9f}" for v in position_of(pose).values[:6] if v is not None)
        for match in re.finditer(rf"(?im)^\s*{own}\s*=\s*\(((?:[^,()]*,){{5}}[^,()]*)", text):
            changes.append((Span(match.start(1), match.end(1)), values))
            found.add(name)
    return changes, found


_FAMILIES: Final[Mapping[str, Callable[[object, str, Cell], tuple[list[Change], set[str]]]]] = {
    "RA": _equip_rapid,
    "MB": _equip_melfa,
}
"""By the family of a language."""

"""Calls of RAPID's instructions that the pseudo-program has a statement for."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Final

from assistant.languages.patterns import Called, Read, Slot
from assistant.languages.rapid.lift.expressions import Expressions, frame_name, tool_name
from assistant.languages.rapid.tables.hands import hand_of
from assistant.languages.rapid.tables.motions import BLENDS, SPEEDS, speed_of, zone_of
from assistant.languages.rapid.tables.statements import ROWS
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import called
from assistant.languages.rapid.tree.gather import literal_number
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Blend, Speed
from assistant.program.passes.messages import chained
from assistant.program.program import Signal

EMPTY: Final = MappingProxyType[str, Any]({})


class Meaning:
    """What the names in instructions stand for.

    original: gives a shortened name back. speeds, blends: the declared ones by lower-case name.
    numbers: values of constants whose names mean nothing else anywhere, by lower-case name.
    timers: lower-case names of the clocks that are timers. alone: joint targets without external
    axes, by lower-case names that mean nothing else anywhere.
    used: signals as instructions use them, filled as statements are lifted.
    """

    def __init__(
        self,
        original: Callable[[str], str] = str,
        speeds: Mapping[str, Speed] = EMPTY,
        blends: Mapping[str, Blend] = EMPTY,
        numbers: Mapping[str, e.Number] = EMPTY,
        timers: Collection[str] = (),
        alone: Collection[str] = (),
    ) -> None:
        self.original, self.timers = original, timers
        self.speeds, self.blends, self.numbers, self.alone = speeds, blends, numbers, alone
        self.used: list[tuple[str, Signal]] = []
        expressions = Expressions(original, timers)
        self.expression = expressions.of
        kinds: dict[str, Read[s.Expression]] = {
            **expressions.reading.kinds,
            "target": lambda node, _: self._place(node),
            "hand": lambda node, _: self._hand(node),
            "signal": lambda node, _: self._name(node),
            **dict.fromkeys(("digital", "analog", "group"), self._signal),
        }
        self.reading = replace(expressions.reading, kinds=kinds)

    def _name(self, node: s.Expression) -> str | None:
        return self.original(node.name) if isinstance(node, s.NameRef) else None

    def _signal(self, node: s.Expression, slot: Slot) -> str | None:
        """A signal, which is of the kind and direction that the slot tells."""
        name, kind, direction = self._name(node), slot.kind, slot.of or "output"
        if name is not None:
            self.used.append((name, Signal(kind, direction)))  # type: ignore[arg-type]
        return name

    def _hand(self, node: s.Expression) -> int | None:
        name = self._name(node)
        return None if name is None else hand_of(name)

    def _place(self, node: s.Expression) -> e.Expression | None:
        variable = isinstance(node, s.NameRef | s.Element | s.Component)
        return self.expression(node) if variable else None

    def known(self, value: e.Expression) -> e.Expression:
        """The number that a constant stands for; anything else as it is."""
        return self.numbers.get(value.name.lower(), value) if isinstance(value, e.Name) else value

    def moves_axes(self, joints: e.Expression) -> bool:
        """Whether a joint target may say where external axes go."""
        match joints:
            case e.JointValue(target):
                return any(v == v for v in target.external)
            case e.Name(name):
                return name.lower() not in self.alone
        return True

    def motion(self, speed: str, zone: str, tool: str, frame: str) -> p.Motion:
        """frame: empty for none."""
        return p.Motion(
            SPEEDS.meant(speed, self.speeds) or e.Name(self.original(speed)),
            BLENDS.meant(zone, self.blends) or e.Name(self.original(zone)),
            tool_name(self.original(tool)),
            frame_name(self.original(frame)),
        )


def instruction(node: s.ProcedureCall, meaning: Meaning) -> p.Statement | None:
    """The statement that a call of an instruction is, None if there is none in this form."""
    call = called(node)
    return None if call is None else of_call(call, meaning)


def of_call(call: Called[s.Expression], meaning: Meaning) -> p.Statement | None:
    """The same of a call as the rows of tables have it."""
    form = FORMS.get(call.word.lower())
    if form is None:
        said: p.Statement | None = ROWS.read(call, meaning.reading)
        return said
    given = [argument for argument in call.given if argument is not None]
    if len(given) != form.count or not call.options.keys() <= set(form.options):
        return None
    return form.lifted(meaning, given, call.options)


Given = Sequence[s.Expression]
Options = Mapping[str, s.Expression | None]
"""Values by lower-case name, None for an option that has none."""

Lifted = Callable[[Meaning, Given, Options], p.Statement | None]


@dataclass(frozen=True, slots=True)
class Form:
    """How many positional arguments an instruction must have, which options it may have."""

    count: int
    lifted: Lifted
    options: tuple[str, ...] = ()


def _motion(m: Meaning, names: Given, options: Options) -> p.Motion | None:
    """A `TLoad` of load0 leaves the load to the tool (RAPID reference manual, MoveL)."""
    speed, zone, tool = names
    frame, load = options.get("wobj"), options.get("tload", NO_LOAD)
    if not isinstance(tool, s.NameRef) or not isinstance(frame, s.NameRef | None):
        return None
    if not isinstance(load, s.NameRef) or load.name.lower() != NO_LOAD.name:
        return None
    values = _speed(speed), _zone(zone)
    named = [n.name if isinstance(n, s.NameRef) else "" for n in (speed, zone)]
    if not all(name or value for name, value in zip(named, values, strict=True)):
        return None
    where = "" if frame is None else frame.name
    motion = m.motion(named[0], named[1], tool.name, where)
    stated = {k: v for k, v in zip(("speed", "blend"), values, strict=True) if v is not None}
    return replace(motion, **stated)  # type: ignore[arg-type]


NO_LOAD: Final = s.NameRef("load0")


def _speed(node: s.Expression) -> Speed | None:
    """A speed that is written out."""
    values = _values(node)
    return speed_of(values) if len(values) == 4 and not isinstance(node, s.NameRef) else None


def _zone(node: s.Expression) -> Blend | None:
    """A zone that is written out; a stop point has no sizes."""
    match node:
        case s.AggregateNode((s.BoolLiteral(fine), *sizes)):
            values = _values(s.AggregateNode(tuple(sizes)))
            zone = zone_of(fine, values) if len(values) == 6 else None
            return None if zone is None or (zone.radius is None and any(values)) else zone
    return None


def _values(node: s.Expression) -> list[float]:
    """The numbers in brackets, none if there is anything else in them."""
    items = node.items if isinstance(node, s.AggregateNode) else ()
    numbers = [literal_number(item) for item in items]
    return [] if None in numbers else [float(n) for n in numbers if n is not None]


def _move(kind: Any) -> Lifted:
    def lifted(m: Meaning, given: Given, options: Options) -> p.Statement | None:
        motion = _motion(m, given[1:], options)
        return None if motion is None else p.Move(kind, m.expression(given[0]), motion)

    return lifted


def _circular(m: Meaning, given: Given, options: Options) -> p.Statement | None:
    motion = _motion(m, given[2:], options)
    if motion is None:
        return None
    return p.MoveCircular(m.expression(given[0]), m.expression(given[1]), motion)


def _joints(m: Meaning, given: Given, options: Options) -> p.Statement | None:
    motion, joints = _motion(m, given[1:], options), m.expression(given[0])
    if motion is None or ("noeoffs" in options and m.moves_axes(joints)):
        return None
    return p.MoveJoints(joints, motion)


def _message(m: Meaning, given: Given, options: Options) -> p.Statement | None:
    parts = [*chained((m.expression(given[0]),), lambda _: True)]
    value = options.get("num")
    if value is not None:
        parts.append(e.Apply("text", (m.expression(value),)))
    return p.Message(tuple(parts))


REASONS: Final[Mapping[str, e.Reason]] = {
    "pulsedo": e.Reason(
        r"without \High the pulse is the other value than that which the signal has",
        r"write `\High`, or set the signal, wait and set it back",
    ),
}
"""Why calls of instructions stay as their text, by lower-case name."""

FORMS: Final[Mapping[str, Form]] = {
    "movej": Form(4, _move("joint"), ("wobj", "tload")),
    "movel": Form(4, _move("linear"), ("wobj", "tload")),
    "movec": Form(5, _circular, ("wobj", "tload")),
    "moveabsj": Form(4, _joints, ("wobj", "tload", "noeoffs")),
    "tpwrite": Form(1, _message, ("num",)),
}
"""Instructions that are more than a row of `tables.statements`, by lower-case name."""

"""Calls of RAPID's instructions that the pseudo-program has a statement for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

from assistant.languages.rapid.lift.expressions import frame_name, lift, tool_name
from assistant.languages.rapid.lift.signals import gripper
from assistant.languages.rapid.tables.motions import BLENDS, SPEEDS, speed_of, zone_of
from assistant.languages.rapid.tables.words import SPEED_CAP
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Blend, Speed
from assistant.program.program import Signal


@dataclass(frozen=True, slots=True)
class Meaning:
    """What the names in instructions stand for.

    original: gives a shortened name back. speeds, blends: the declared ones by lower-case name.
    numbers: values of constants whose names mean nothing else anywhere, by lower-case name.
    timers: lower-case names of the clocks that are timers. alone: joint targets without external
    axes, by lower-case names that mean nothing else anywhere.
    used: signals as instructions use them, filled as statements are lifted.
    """

    original: Callable[[str], str] = str
    speeds: Mapping[str, Speed] = field(default_factory=dict)
    blends: Mapping[str, Blend] = field(default_factory=dict)
    numbers: Mapping[str, e.Number] = field(default_factory=dict)
    timers: frozenset[str] = frozenset()
    alone: frozenset[str] = frozenset()
    used: list[tuple[str, Signal]] = field(default_factory=list)

    def expression(self, node: s.Expression) -> e.Expression:
        return lift(node, self.original)

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
    form = INSTRUCTIONS.get(str(node.name).lower())
    given = None if form is None else plain_arguments(node, form.options)
    if form is None or given is None or len(given) != form.count:
        return None
    options: dict[str, s.Expression | None] = {}
    for argument in node.arguments:
        if isinstance(argument, s.Option):
            options.setdefault(argument.name.lower(), argument.value)
    return form.lifted(meaning, given, options)


def plain_arguments(
    node: s.ProcedureCall, options: Sequence[str] = ()
) -> list[s.Expression] | None:
    """The positional arguments, None if there are others than those and the options."""
    plain = []
    for argument in node.arguments:
        match argument:
            case s.Positional(value, None):
                plain.append(value)
            case s.Option(name) if name.lower() in options:
                pass
            case _:
                return None
    return plain


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


def _wait(m: Meaning, given: Given, _: Options) -> p.Statement | None:
    return p.Wait(m.expression(given[0]))


def _timeout(m: Meaning, options: Options) -> e.Expression | None:
    value = options.get("maxtime")
    return None if value is None else m.expression(value)


def _wait_signal(kind: Any, direction: Any) -> Lifted:
    def lifted(m: Meaning, given: Given, options: Options) -> p.Statement | None:
        signal, value = given
        if not isinstance(signal, s.NameRef):
            return None
        name = m.original(signal.name)
        m.used.append((name, Signal(kind, direction)))
        return p.WaitSignal(name, m.expression(value), _timeout(m, options))

    return lifted


def _wait_until(m: Meaning, given: Given, options: Options) -> p.Statement | None:
    return p.WaitUntil(m.expression(given[0]), _timeout(m, options))


def _set(kind: Any) -> Lifted:
    def lifted(m: Meaning, given: Given, _: Options) -> p.Statement | None:
        if not isinstance(given[0], s.NameRef):
            return None
        name, value = m.original(given[0].name), m.expression(given[1])
        if kind == "digital" and (hand := gripper(name, value)):
            return hand
        m.used.append((name, Signal(kind, "output")))
        return p.SetSignal(name, value)

    return lifted


def _set_to(value: int) -> Lifted:
    def lifted(m: Meaning, given: Given, _: Options) -> p.Statement | None:
        if not isinstance(given[0], s.NameRef):
            return None
        name = m.original(given[0].name)
        return gripper(name, e.Number(value)) or p.SetSignal(name, e.Number(value))

    return lifted


def _pulse(m: Meaning, given: Given, options: Options) -> p.Statement | None:
    if not isinstance(given[0], s.NameRef) or "high" not in options:
        return None
    length = options.get("plength")
    seconds = e.Number(0.2) if length is None else m.expression(length)
    return p.SetSignal(m.original(given[0].name), e.Number(1), seconds)


def _acceleration(m: Meaning, given: Given, _: Options) -> p.Statement | None:
    if literal_number(given[1]) != 100:
        return None
    percent = m.expression(given[0])
    return p.SetAcceleration(percent, percent)


def _override(m: Meaning, given: Given, _: Options) -> p.Statement | None:
    if literal_number(given[1]) != SPEED_CAP:
        return None
    return p.SetOverride(m.expression(given[0]))


def _added(operator: Any, one: bool) -> Lifted:
    """one: by 1; else by what the second argument says."""

    def lifted(m: Meaning, given: Given, _: Options) -> p.Statement | None:
        if not isinstance(given[0], s.NameRef | s.Element | s.Component):
            return None
        place = m.expression(given[0])
        by = e.Number(1) if one else m.expression(given[1])
        return p.Assign(place, e.Binary(operator, place, by))

    return lifted


def _clear(m: Meaning, given: Given, _: Options) -> p.Statement | None:
    if not isinstance(given[0], s.NameRef | s.Element | s.Component):
        return None
    return p.Assign(m.expression(given[0]), e.Number(0))


def _stop(_: Meaning, _given: Given, _options: Options) -> p.Statement | None:
    return p.Stop()


def _message(m: Meaning, given: Given, options: Options) -> p.Statement | None:
    parts: list[e.Expression] = []
    pending = [given[0]]
    while pending:
        part = pending.pop()
        if isinstance(part, s.Infix) and part.operator == "+":
            pending += [part.right, part.left]
        else:
            parts.append(m.expression(part))
    value = options.get("num")
    if value is not None:
        parts.append(e.Apply("text", (m.expression(value),)))
    return p.Message(tuple(parts))


INSTRUCTIONS: Final[Mapping[str, Form]] = {
    "movej": Form(4, _move("joint"), ("wobj", "tload")),
    "movel": Form(4, _move("linear"), ("wobj", "tload")),
    "movec": Form(5, _circular, ("wobj", "tload")),
    "moveabsj": Form(4, _joints, ("wobj", "tload", "noeoffs")),
    "waittime": Form(1, _wait),
    "waitdi": Form(2, _wait_signal("digital", "input"), ("maxtime",)),
    "waitdo": Form(2, _wait_signal("digital", "output"), ("maxtime",)),
    "waitgi": Form(2, _wait_signal("group", "input"), ("maxtime",)),
    "waitgo": Form(2, _wait_signal("group", "output"), ("maxtime",)),
    "waituntil": Form(1, _wait_until, ("maxtime",)),
    "setdo": Form(2, _set("digital")),
    "setao": Form(2, _set("analog")),
    "setgo": Form(2, _set("group")),
    "set": Form(1, _set_to(1)),
    "reset": Form(1, _set_to(0)),
    "pulsedo": Form(1, _pulse, ("high", "plength")),
    "accset": Form(2, _acceleration),
    "velset": Form(2, _override),
    "incr": Form(1, _added("+", one=True)),
    "decr": Form(1, _added("-", one=True)),
    "add": Form(2, _added("+", one=False)),
    "clear": Form(1, _clear),
    "stop": Form(0, _stop),
    "tpwrite": Form(1, _message, ("num",)),
}
"""Instructions that the pseudo-program has a statement for, by lower-case name."""

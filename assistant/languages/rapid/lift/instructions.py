"""Calls of RAPID's instructions that the pseudo-program has a statement for."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final

from assistant.languages.patterns import Called, Read, Slot
from assistant.languages.rapid.lift.expressions import Expressions, frame_name, tool_name
from assistant.languages.rapid.tables.hands import hand_of
from assistant.languages.rapid.tables.motions import (
    BLENDS,
    SPEED_PARTS,
    SPEEDS,
    ZONE_SIZES,
    computed_zone,
    speed_of,
    zone_of,
)
from assistant.languages.rapid.tables.statements import ROWS
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import called
from assistant.languages.rapid.tree.gather import literal_number
from assistant.languages.vendor_statements import INTERRUPTS
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Blend, Speed
from assistant.program.program import Signal

EMPTY: Final = MappingProxyType[str, Any]({})


class NameResolver:
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
        expressions = Expressions(original, timers)
        self.used = expressions.used
        self.expression, self.oriented = expressions.of, expressions.oriented
        kinds: dict[str, Read[s.Expression]] = {
            **expressions.reading.kinds,
            "target": lambda node, _: self._place(node),
            "speed": lambda node, _: self._speed(node),
            "blend": lambda node, _: self._blend(node),
            "other": expressions.reading.kinds["frame"],
            "load": lambda node, _: node if _is_no_load(node) else None,
            "robot": lambda node, _: self._robot_alone(self.expression(node)),
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

    def _robot_alone(self, joints: e.Expression) -> e.Expression | None:
        """A joint target that says nothing of external axes."""
        match joints:
            case e.JointValue(target) if not any(v == v for v in target.external):
                return joints
            case e.Name(name) if name.lower() in self.alone:
                return joints
        return None

    def _speed(self, node: s.Expression) -> Speed | p.ComputedSpeed | e.Name | None:
        """By its name, or written out in numbers or in what is worked out."""
        match node:
            case s.NameRef(name):
                return self.speed(name)
            case s.AggregateNode(items) if len(items) == len(SPEED_PARTS):
                values = _aggregate_numbers(node)
                return speed_of(values) if values else p.ComputedSpeed(*map(self._part, items))
        return None

    def _part(self, node: s.Expression) -> e.Expression:
        return self.known(self.expression(node))

    def _blend(self, node: s.Expression) -> Blend | p.ComputedBlend | e.Name | None:
        """By its name, or written out; a stop point has no sizes."""
        match node:
            case s.NameRef(name):
                return self.blend(name)
            case s.AggregateNode((stop, *sizes)) if len(sizes) == len(ZONE_SIZES) and not (
                isinstance(stop, s.BoolLiteral)
                and _aggregate_numbers(s.AggregateNode(tuple(sizes)))
            ):
                return computed_zone(self.expression(stop), tuple(map(self._part, sizes)))
            case s.AggregateNode((s.BoolLiteral(fine), *sizes)):
                values = _aggregate_numbers(s.AggregateNode(tuple(sizes)))
                zone = zone_of(fine, values) if len(values) == 6 else None
                return None if zone is None or (zone.radius is None and any(values)) else zone
        return None

    def speed(self, name: str) -> Speed | e.Name:
        return SPEEDS.meant(name, self.speeds) or e.Name(self.original(name))

    def blend(self, name: str) -> Blend | e.Name:
        return BLENDS.meant(name, self.blends) or e.Name(self.original(name))

    def motion(self, speed: str, zone: str, tool: str, frame: str) -> p.Motion:
        """frame: empty for none."""
        named = tool_name(self.original(tool)), frame_name(self.original(frame))
        return p.Motion(self.speed(speed), self.blend(zone), *named)


def lift_instruction(node: s.ProcedureCall, meaning: NameResolver) -> p.Statement | None:
    """The statement that a call of an instruction is, None if there is none in this form."""
    call = called(node)
    return None if call is None else lift_call(call, meaning)


def lift_call(call: Called[s.Expression], meaning: NameResolver) -> p.Statement | None:
    """The same of a call as the rows of tables have it."""
    said: p.Statement | None = ROWS.read(call, meaning.reading)
    return said


def _is_no_load(node: s.Expression) -> bool:
    return isinstance(node, s.NameRef) and node.name.lower() == "load0"


def _aggregate_numbers(node: s.Expression) -> list[float]:
    """The numbers in brackets, none if there is anything else in them."""
    items = node.items if isinstance(node, s.AggregateNode) else ()
    numbers = [literal_number(item) for item in items]
    return [] if None in numbers else [float(n) for n in numbers if n is not None]


_INTERRUPT_INSTRUCTIONS: Final = (
    *("isignaldi", "isignaldo", "isignalgi", "isignalgo", "isignalai", "isignalao", "itimer"),
    *("idelete", "isleep", "iwatch", "ienable", "idisable", "ipers", "ierror", "triggint"),
)
_SYNCHRONISED_MOVES: Final = ("syncmoveon", "syncmoveoff", "syncmovesuspend", "syncmoveresume")
_SEVERAL_ARMS: Final = e.Reason(
    "arms of several tasks move together there, which no program of one arm does",
    "move them one after the other, each in its own program",
)
INSTRUCTION_REASONS: Final[Mapping[str, e.Reason]] = {
    "pulsedo": e.Reason(
        r"without \High the pulse is the other value than that which the signal has",
        r"write `\High`, or set the signal, wait and set it back",
    ),
    **dict.fromkeys(_INTERRUPT_INSTRUCTIONS, INTERRUPTS),
    **dict.fromkeys(_SYNCHRONISED_MOVES, _SEVERAL_ARMS),
}
"""Why calls of instructions stay as their text, by lower-case name."""

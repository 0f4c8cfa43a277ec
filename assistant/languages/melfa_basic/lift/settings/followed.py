"""Settings that differ with the way that leads to a move: variables hold them for other languages.

In MELFA-BASIC `Spd` holds until the next one. Where no value is certain at a move, each `Spd` that
may lead there sets a variable as well, and the move takes its speed from that.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, Final

from assistant.languages.melfa_basic.lift.settings.held import (
    BLEND,
    FRAME,
    JOINT,
    TCP,
    TOOL,
    Settings,
    setting_number,
)
from assistant.languages.melfa_basic.lift.values.expressions import Expressions
from assistant.languages.melfa_basic.lift.values.symbols import Symbols, Unliftable
from assistant.languages.melfa_basic.tables.words import OPTIMUM_SPEED
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.settings.flow import UNKNOWN
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import BASE, FLANGE, IDENTITY, Frame, Tool
from assistant.program.motion import FINE, Blend
from assistant.program.program import Variable

NO_CORNER: Final = -1.0
"""No corner: the move ends at its target."""
OPEN_CORNER: Final = 10.0
"""mm of a corner whose size the controller chooses (`Cnt 1`)."""
_FOLLOWED_NAMES: Final = {
    TCP: "current_speed",
    JOINT: "current_percent",
    BLEND: "current_corner",
    TOOL: "current_tool",
    FRAME: "current_base",
}
_FIRST_VALUES: Final = {TCP: OPTIMUM_SPEED, JOINT: 100.0, BLEND: NO_CORNER}
"""Settings at the start of a program."""


@dataclass(frozen=True, slots=True)
class Followed:
    """A setting that a variable, or a tool or frame of that name, holds."""

    name: str


def with_followed_settings(values: tuple[Any, ...], names: Mapping[int, str]) -> tuple[Any, ...]:
    """The settings of a move with the names of those that are followed for the unknown ones."""
    return tuple(
        Followed(names[k]) if value is UNKNOWN and k in names else value
        for k, value in enumerate(values)
    )


def mount_text(value: Any) -> Any:
    """The name of a tool or frame."""
    return value.name if isinstance(value, Followed) else value


def declare_followed(
    slots: Collection[int],
    known: dict[int, str],
    symbols: Symbols,
    settings: Settings,
    written: Collection[str],
) -> None:
    """Declares what holds some settings.

    known: takes their names, the same in all files of a program. written: names of the file, in
    upper case, which none of them gets.
    """
    for slot in sorted(slots):
        if slot not in known:
            wanted, number = _FOLLOWED_NAMES[slot], 2
            while wanted.upper() in written:
                wanted, number = f"{_FOLLOWED_NAMES[slot]}_{number}", number + 1
            known[slot] = symbols.free(wanted)
        name = known[slot]
        symbols.taken.add(name.lower())
        if slot == TOOL:
            settings.tools.setdefault(name, Tool())
        elif slot == FRAME:
            settings.frames.setdefault(name, Frame())
        else:
            symbols.variables.setdefault(name, Variable("number", e.number_of(_FIRST_VALUES[slot])))


def followed_assignment(
    node: s.Statement, value: Any, names: Mapping[int, str], lift: Expressions
) -> p.Assign | None:
    """Return the value that a setting statement gives its variable, None if that is not followed.

    value: what is known of it. Raises Unliftable where it has no other words.
    """
    slot = setting_number(node)
    if slot is None or slot not in names:
        return None
    arguments: tuple[Any, ...] = (node.value,) if isinstance(node, s.Assign) else ()
    arguments = node.arguments if isinstance(node, s.Command) else arguments
    target = e.Name(names[slot])
    if slot in (TOOL, FRAME):
        return p.Assign(target, _followed_mount(slot, arguments, value, lift))
    if slot == BLEND:
        return p.Assign(target, _followed_corner(arguments, value, lift))
    return p.Assign(target, _followed_number(arguments, value, lift))


def _followed_number(arguments: tuple[Any, ...], value: Any, lift: Expressions) -> e.Expression:
    if isinstance(value, float):
        return e.number_of(OPTIMUM_SPEED if math.isinf(value) else value)
    if len(arguments) != 1 or arguments[0] is None:
        raise Unliftable
    return lift.number(arguments[0])


def _followed_corner(arguments: tuple[Any, ...], value: Any, lift: Expressions) -> e.Expression:
    if value == FINE:
        return e.number_of(NO_CORNER)
    if isinstance(value, Blend) and value.radius is not None:
        radius = min(value.radius, math.inf if value.exit is None else value.exit)
        return e.number_of(OPEN_CORNER if math.isinf(radius) else radius)
    match arguments:
        case (s.Number(1), near) if near is not None:
            return lift.number(near)
        case (s.Number(1), near, far) if near is not None and near == far:
            return lift.number(near)
    raise Unliftable


def _followed_mount(
    slot: int, arguments: tuple[Any, ...], value: Any, lift: Expressions
) -> e.Expression:
    if value in (FLANGE, BASE):
        return e.PoseValue(IDENTITY)
    if isinstance(value, str):
        return e.Name(value)
    (argument,) = arguments
    if argument is None or lift.type_of(argument) != "position":
        raise Unliftable
    place = lift.plain(argument)
    return place if slot == TOOL else e.inverse(place)

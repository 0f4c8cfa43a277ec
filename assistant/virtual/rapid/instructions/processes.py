r"""Moves with a process: arc and spot welding, dispensing, painting.

The equipment is outside of a run: it is told by outputs, and answers by inputs, whose names are
those that a translation gives them too. An arc burns from the end of ArcLStart to that of ArcLEnd,
and those moves stop (application manual Arc, 3HAC050988); a spot is welded where SpotL stands, by
the program of the timer that its data begin with, until the gun is ready; a bead lasts from
`DispL\On` to `DispL\Off`. Those two and painting are by memory of their manuals.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Final

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.rapid import motion
from assistant.virtual.rapid.ends import Fault, NotSimulated
from assistant.virtual.rapid.expressions import evaluate
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.poses import number
from assistant.virtual.rapid.scopes import Cell, Meaning
from assistant.virtual.rapid.values import Record

_FINE_ZONE: Final = s.NameRef("fine")
_TURNING: Final = tuple(map(s.NumberLiteral, ("500", "5000", "1000")))
"""deg/s and the speeds of external axes that weld data do not state: those of `v100`."""
Move = Callable[[Given], None]


def _welding(move: Move, points: int, part: str) -> Move:
    """points: before the speed, behind which are the seam, the weld, the zone and the tool."""

    def does(given: Given) -> None:
        weld = given.required.pop(points + 2)
        given.required.pop(points + 1)
        if part != "Start":
            given.required[points] = s.AggregateNode((_process_speed(weld), *_TURNING))
        if part:
            given.required[points + 1] = _FINE_ZONE
        move(given)
        if part:
            given.machine.signals.set("arc_on", float(part == "Start"))

    return does


def _process_speed(weld: s.Expression) -> s.Expression:
    match weld:
        case s.AggregateNode(items=(first, *_)):
            return first
        case s.NameRef() | s.Component() | s.Element():
            return s.Component(weld, "weld_speed")
    raise NotSimulated("a weld that is worked out")


def _spotting(move: Move, *, several: bool) -> Move:
    def does(given: Given) -> None:
        spots = dict(_several_guns(given) if several else [_single_gun(given)])
        given.required.insert(2, _FINE_ZONE)
        numbers = {gun: _weld_program(given, spot) for gun, spot in spots.items()}
        move(given)
        signals = given.machine.signals
        for gun, program in numbers.items():
            signals.set(f"{gun}_program", program)
        wide = [f"{gun}_retract" for gun in spots if given.has("retract")]
        starts = [f"{gun}_start" for gun in spots]
        for name in (*wide, *starts):
            signals.set(name, 1.0)
        for gun in spots:
            ready = f"{gun}_ready"
            given.machine.task.wait(
                lambda ready=ready: signals.read(ready) == 1.0,  # type: ignore[misc]
                None,
                f"`{ready}` is 0, 1 is waited for",
            )
        for name in (*starts, *wide):
            signals.set(name, 0.0)

    return does


def _single_gun(given: Given) -> tuple[str, s.Expression]:
    gun, spot = given.required.pop(2), given.required.pop(2)
    if isinstance(gun, s.NameRef):
        return gun.name.lower(), spot
    return f"gun{number(evaluate(given.machine, gun)):g}", spot


def _several_guns(given: Given) -> Iterator[tuple[str, s.Expression]]:
    for name in [name for name in given.options if name in GUNS]:
        spot = given.options.pop(name)
        if spot is None:
            raise Fault(f"no data of a spot for `{name}`")
        yield f"gun{name[1:]}", spot


def _weld_program(given: Given, spot: s.Expression) -> float:
    if isinstance(spot, s.AggregateNode) and spot.items:
        return number(evaluate(given.machine, spot.items[0]))
    value = evaluate(given.machine, spot)
    if not isinstance(value, Record) or not value.parts:
        raise NotSimulated("data of a spot whose components are not known")
    return number(next(iter(value.parts.values())))


def _dispensing(move: Move, points: int) -> Move:
    def does(given: Given) -> None:
        bead = given.required.pop(points + 1)
        move(given)
        signals = given.machine.signals
        if given.has("off"):
            signals.set("dispense_on", 0.0)
            return
        signals.set("dispense_bead", float(_bead_options(given, bead)))
        if given.has("on"):
            signals.set("dispense_on", 1.0)

    return does


def _bead_options(given: Given, bead: s.Expression) -> int:
    """Beads count in the order of their declarations."""
    known = [name for name, one in given.machine.named.items() if _is_bead(one)]
    if not isinstance(bead, s.NameRef) or bead.name.lower() not in known:
        raise NotSimulated("a bead that no module declares")
    return known.index(bead.name.lower()) + 1


def _is_bead(known: Meaning) -> bool:
    if not isinstance(known, Cell):
        return False
    type = known.shape.type if known.pending is None else known.pending.node.type
    return type.lower() == "beaddata"


def _set_brush(given: Given) -> None:
    given.machine.signals.set("paint_brush", given.number(0))


GUNS: Final = ("g1", "g2", "g3", "g4")
_ARC_MOVES: Final = f"{motion.MOVE_OPTIONS} weave track seamname corr preprocesstracking"
_SPOT_MOVES: Final = f"{motion.MOVE_OPTIONS} noconc retract"
_PROCESS_MOVES: Final[Mapping[str, tuple[Move, int]]] = {
    "L": (motion.move_linear, 1),
    "C": (motion.move_circular, 2),
    "J": (motion.move_joint, 1),
}
PROCESS_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        *(
            table_row(f"Arc{x}{part}", points + 5, _welding(move, points, part), _ARC_MOVES)
            for x, (move, points) in _PROCESS_MOVES.items()
            for part in ("", "Start", "End")
        ),
        *(
            table_row(f"Spot{x}", 5, _spotting(_PROCESS_MOVES[x][0], several=False), _SPOT_MOVES)
            for x in ("L", "J")
        ),
        *(
            table_row(
                f"SpotM{x}",
                3,
                _spotting(_PROCESS_MOVES[x][0], several=True),
                f"{_SPOT_MOVES} {' '.join(GUNS)}",
            )
            for x in ("L", "J")
        ),
        *(
            table_row(
                f"Disp{x}",
                _PROCESS_MOVES[x][1] + 4,
                _dispensing(*_PROCESS_MOVES[x]),
                f"{motion.MOVE_OPTIONS} on off",
            )
            for x in ("L", "C")
        ),
        *(
            table_row(
                f"Paint{x}", _PROCESS_MOVES[x][1] + 3, _PROCESS_MOVES[x][0], motion.MOVE_OPTIONS
            )
            for x in ("L", "C")
        ),
        table_row("SetBrush", 1, _set_brush),
    )
)

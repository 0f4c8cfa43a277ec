"""Moves with a process, searching moves, and stops on the path.

Welding, dispensing, painting: the equipment is outside of a run: outputs command it, inputs answer,
with the names that a translation gives them too. An arc burns from the end of ArcLStart to that of
ArcLEnd, and those moves stop (application manual Arc, 3HAC050988); a spot is welded where SpotL
ends, by the program of the timer that its data begin with, until the gun is ready; a bead lasts
from DispL with `On` to DispL with `Off`. Dispensing and painting are by memory of their manuals.
SearchL: without a switch it searches for the positive edge, and a signal that is active before ends
it with ERR_SIGSUPSEARCH; `HighLevel` and `LowLevel` also find a level at its start. Nothing found,
or more than once with `Sup`, is ERR_WHLSEARCH. The arm stops at once: its braking distance is not
simulated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Final

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.kernel import Instant
from assistant.virtual.rapid import motion
from assistant.virtual.rapid.call_arguments import Given, table_row
from assistant.virtual.rapid.control_flow import Fault, NotSimulated
from assistant.virtual.rapid.expressions import evaluate, signal
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.positions import present_target
from assistant.virtual.rapid.records import number, truth
from assistant.virtual.rapid.scopes import Cell, Meaning
from assistant.virtual.rapid.values import Record
from assistant.virtual.triggers import move_until, watched_move

_FINE_ZONE: Final = s.NameRef("fine")
_TURNING: Final = tuple(map(s.NumberLiteral, ("500", "5000", "1000")))
"""deg/s and the speeds of external axes that weld data do not state: those of `v100`."""
Move = Callable[[Given], None]


def _welding(move: Move, points: int, part: str) -> Move:
    """points: before the speed, behind which are the seam, the weld, the zone and the tool."""

    # The weld first: removing the seam would shift its index.
    def does(given: Given) -> None:
        weld = given.required.pop(points + 2)
        given.required.pop(points + 1)
        # The start move approaches at its own speed; the
        # others weld, at the speed of the weld data.
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
        # Evaluated before the move, as all arguments of an instruction are.
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
                # The default binds each name now: all lambdas
                # would wait for the last gun otherwise.
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
    for name in [name for name in given.options if name in _GUNS]:
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


_GUNS: Final = ("g1", "g2", "g3", "g4")
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
                f"{_SPOT_MOVES} {' '.join(_GUNS)}",
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


_STOP_SWITCHES: Final = ("stop", "pstop", "sstop")
_EDGE_SWITCHES: Final = ("flanks", "posflank", "negflank", "highlevel", "lowlevel")
_SEARCH_OPTIONS: Final = " ".join((*_STOP_SWITCHES, "sup", *_EDGE_SWITCHES, "wobj tload id v t"))


def _search(move: Callable[[Given], None]) -> Callable[[Given], None]:
    """A motion that looks; move: the same without."""

    def does(given: Given) -> None:
        node, _, *targets, speed, tool = given.required
        place = given.place(1)
        flank = next((one for one in _EDGE_SWITCHES if given.has(one)), "")
        options = {name: x for name, x in given.options.items() if name in ("wobj", "v", "t")}
        # The move inside is a plain one to a stop point:
        # a corner would cut off the place searched for.
        plain = Given(given.machine, [*targets, speed, _FINE_ZONE, tool], options)
        asks = _SearchWatch(_search_condition(given, node), flank)
        # With an edge as condition, an active signal at the
        # start could never be found (ERR_SIGSUPSEARCH).
        if not flank and asks.last:
            raise Fault("a search whose signal is active at its start", "ERR_SIGSUPSEARCH")
        seen = {"tool": tool} | {x: node for x, node in options.items() if x == "wobj"}
        here = partial(present_target, Given(given.machine, [], seen))
        hits = 0
        if any(map(given.has, _STOP_SWITCHES)):
            if move_until(given.machine.task, asks.hit, lambda: move(plain)):
                hits = 1
                _is_level(given)
                place.set(here())
        else:

            def look() -> None:
                nonlocal hits
                if asks.hit():
                    hits += 1
                    if hits == 1:
                        place.set(here())

            look()
            watched_move(given.machine.task, look, lambda: move(plain))
        if not hits or (hits > 1 and given.has("sup")):
            found = "nothing is found" if not hits else "more than one place is found"
            raise Fault(f"a search in which {found}", "ERR_WHLSEARCH")

    return does


def _search_condition(given: Given, node: s.Expression) -> Callable[[], bool]:
    """Return a function that checks whether the search condition is active: a signal, or a
    persistent truth.
    """
    machine = given.machine
    found = machine.meaning(node.name) if isinstance(node, s.NameRef) else None
    if found is not None and given.place(0).storage == "PERS":
        return lambda: truth(given.value(0))
    name = signal(machine, node)
    return lambda: machine.signals.read(name) != 0.0


class _SearchWatch:
    """last: what was seen last."""

    def __init__(self, active: Callable[[], bool], flank: str) -> None:
        self.active, self.flank, self.last = active, flank or "posflank", active()

    def hit(self) -> bool:
        now, before = self.active(), self.last
        self.last = now
        match self.flank:
            case "highlevel":
                return now
            case "lowlevel":
                return not now
            case "flanks":
                return now is not before
            case "negflank":
                return before and not now
        return now and not before


def _is_level(given: Given) -> None:
    """The arm is where it was stopped."""
    arm, standing = given.machine.arm, given.machine.task.kernel.motion.where()
    if standing is not None:
        arm.flange, arm.joints = standing[0], standing[1][:6]


SEARCH_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("SearchL", 5, _search(motion.move_linear), _SEARCH_OPTIONS),
        table_row("SearchC", 6, _search(motion.move_circular), _SEARCH_OPTIONS),
    )
)


_NO_PATH: Final = "`{}`: motions take no time here, so that none is stopped on its way"


def _stop_motion(given: Given) -> None:
    """Motions that come later wait too, until StartMove."""
    kernel = given.machine.task.kernel
    given.machine.controller.held = given.machine.task
    kernel.motion.hold(kernel)


def _start_motion(given: Given) -> None:
    kernel = given.machine.task.kernel
    given.machine.controller.held = None
    kernel.motion.resume(kernel)


def _clear_path(given: Given) -> None:
    """The arm stays where it is; it is still stopped."""
    machine = given.machine
    standing = machine.task.kernel.motion.cut(machine.task)
    if standing is not None:
        machine.arm.flange, machine.arm.joints = standing[0], standing[1][:6]
        machine.task.kernel.motion.hold(machine.task.kernel)


def _store_path(given: Given) -> None:
    """Stop the arm; the motions that follow use a separate path."""
    kernel = given.machine.task.kernel
    kernel.motion.store(kernel)


def _restore_path(given: Given) -> None:
    """The path that was kept goes on with StartMove."""
    task = given.machine.task
    task.kernel.motion.restore(task)


def _is_stopped(given: Given) -> bool:
    """True if the motions are stopped; tasks count as those that move the arm, like the calling
    one.
    """
    held = given.machine.controller.held
    if held not in (None, given.machine.task):
        raise NotSimulated("whether another task moves an arm")
    return held is not None and not given.has("fromnonmovetask")


def _stop_row(name: str, does: Callable[[Given], None], options: str = "") -> tuple[str, Function]:
    """An instruction that does nothing, and says so, where motions take no time."""

    def checked(given: Given) -> None:
        kernel = given.machine.task.kernel
        if isinstance(kernel.motion, Instant):
            kernel.note(_NO_PATH.format(name))
        does(given)

    return table_row(name, 0, checked, options)


STOP_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        _stop_row("StopMove", _stop_motion, "quick allmotiontasks"),
        _stop_row("StartMove", _start_motion, "allmotiontasks"),
        _stop_row("StopMoveReset", _start_motion, "allmotiontasks"),
        _stop_row("ClearPath", _clear_path),
        _stop_row("StorePath", _store_path, "keepsync"),
        _stop_row("RestoPath", _restore_path),
    )
)
STOP_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (table_row("IsStopMoveAct", 0, _is_stopped, "frommovetask fromnonmovetask"),)
)

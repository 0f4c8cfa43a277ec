"""Segments: motion statements ready to be timed, and the states of a program between them.

A state holds the elapsed time, the position of the arm, what was done, and what the arm carries
for those who ask (`Carried`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from typing import Final, Protocol

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.program.expressions import Expression
from assistant.program.geometry import BASE, FLANGE, Frame, Tool
from assistant.program.motion import UNSTATED, Kind, configuration_row
from assistant.program.program import Procedure, walk
from assistant.program.pseudo.expressions import expression_text
from assistant.program.statements import (
    Follow,
    Gripper,
    Motion,
    Move,
    MoveCircular,
    MoveJoints,
    Moving,
    SetSignal,
    Statement,
    Trigger,
)
from assistant.robots.configurations import BACK
from assistant.robots.motion.run import SpeedsAndBlends
from assistant.robots.program_values import Names, Place, Values
from assistant.robots.solved_program import Leg, SolvedProgram
from assistant.robots.timing.course import Mount, Moves, Settings, moves_of, targets_out_of_frames
from assistant.robots.timing.plan import Plan

JointValues = tuple[float, ...]

_MOST_PLACES: Final = 4
"""Places where the arm may be, each timed, before it counts as not known."""


@dataclass(frozen=True, slots=True)
class Duration:
    """Seconds at least and at most; branches of a program make them differ."""

    least: float
    most: float


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """History of a program, the last entry first: a plan, seconds of waiting, or another history as
    often as its count states.

    start: seconds of all before it. seconds: of all with it. last: the last plan of all.
    """

    before: History | None
    done: Plan | float | tuple[History, int]
    start: float = field(init=False)
    seconds: float = field(init=False)
    last: Plan | None = field(init=False)

    def __post_init__(self) -> None:
        start, last = (
            (0.0, None) if self.before is None else (self.before.seconds, self.before.last)
        )
        if isinstance(self.done, Plan):
            took, last = self.done.seconds, self.done
        elif isinstance(self.done, tuple):
            took, last = self.done[0].seconds * self.done[1], self.done[0].last or last
        else:
            took = self.done
        object.__setattr__(self, "start", start)
        object.__setattr__(self, "seconds", start + took)
        object.__setattr__(self, "last", last)

    def chain(self) -> list[History]:
        """Return the history with the first entry first."""
        nodes = []
        node: History | None = self
        while node is not None:
            nodes.append(node)
            node = node.before
        return nodes[::-1]


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """State of a program after one branch through it, or after several that met again.

    places: joints where the arm may be; empty if they are not known. known: values of variables in
    lower case, None for one that is not known. history: of the branch that takes the longest.
    carried: the bodies that the arm carries, None if they are not needed.
    """

    least: float = 0.0
    most: float = 0.0
    places: tuple[JointValues, ...] = ()
    settings: Settings = field(default_factory=Settings)
    known: Mapping[str, Expression | None] = field(default_factory=dict)
    history: History | None = None
    carried: Carried | None = None

    def waited(self, seconds: float) -> State:
        if seconds <= 0.0:
            return self
        history = History(self.history, seconds)
        return replace(self, least=self.least + seconds, most=self.most + seconds, history=history)

    def under(self, **settings: float) -> State:
        """The state with other settings from here on."""
        return replace(self, settings=replace(self.settings, **settings))

    def without(self, names: set[str]) -> State:
        """The state with the values of some variables, in lower case, not known."""
        changed = {name: None for name in names if self.known.get(name) is not None}
        return replace(self, known={**self.known, **changed}) if changed else self

    def begun(self) -> State:
        """Return a state from which a separate branch begins."""
        return replace(self, least=0.0, most=0.0, history=None)

    def then(self, other: State, times: int = 1) -> State:
        """On from here, so often, by what has begun here."""
        history = self.history
        if other.history is not None and times > 0:
            history = History(history, (other.history, times))
        return replace(
            other,
            least=self.least + times * other.least,
            most=self.most + times * other.most,
            history=history,
        )

    def same_state(self, other: State) -> bool:
        """True if the arm, the settings and the variables are as in another state."""
        return (
            self.places == other.places
            and self.settings == other.settings
            and self.known == other.known
            and self.carried == other.carried
        )


def merged_state(states: Sequence[State]) -> State | None:
    """Return the state at which branches meet again; None if no state is given."""
    if len(states) < 2:
        return states[0] if states else None
    longest = max(states, key=lambda state: state.most)
    places = tuple(dict.fromkeys(place for state in states for place in state.places))
    if len(places) > _MOST_PLACES or not all(state.places for state in states):
        places = ()
    names = {name for state in states for name in state.known}
    known = {
        name: longest.known.get(name)
        if all(state.known.get(name) == longest.known.get(name) for state in states)
        else None
        for name in names
    }
    carried = longest.carried
    for state in states:
        if carried is not None and state.carried is not None and state.carried != carried:
            carried = carried.met(state.carried)
    least = min(state.least for state in states)
    return replace(longest, least=least, places=places, known=known, carried=carried)


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """One motion statement, ready for timing.

    number: of the motion statement in its procedure, counted from 1. key: the same for pieces that
    are alike in everything. triggers: outputs that it sets during the motion. carried: by the arm
    meanwhile. lines: whether each of its moves has a separate line in the text.
    """

    procedure: str
    number: int
    moves: Moves
    key: tuple[object, ...]
    triggers: tuple[Trigger, ...] = ()
    carried: Carried | None = None
    lines: bool = False


class Segments:
    """The motion statements of a solved program.

    numbers: id of a statement → its number in its procedure and its leg. labels: procedure and
    number → what it moves to. external: ids of the statements that move external axes. bare:
    of moves to joints with a tool or frame that is not known, timed for the flange in the base.
    """

    def __init__(self, solution: SolvedProgram, names: Names, values: Values) -> None:
        self.solution, self.names, self.values = solution, names, values
        program = solution.program
        self.tables = (
            {name.lower(): speed for name, speed in program.speeds.items()},
            {name.lower(): blend for name, blend in program.blends.items()},
        )
        self.numbers: dict[int, tuple[int, Leg]] = {}
        self.labels: dict[tuple[str, int], str] = {}
        self.external: set[int] = set()
        self.bare: set[int] = set()
        for procedure in program.procedures:
            self._number(procedure, solution.legs[procedure.name])
        self.made: dict[tuple[object, ...], Moves] = {}

    def _number(self, procedure: Procedure, legs: tuple[Leg, ...]) -> None:
        moving = [s for s in walk(procedure.body) if isinstance(s, Moving)]
        for number, (statement, leg) in enumerate(zip(moving, legs, strict=True), start=1):
            if _empty(statement):
                continue
            self.numbers[id(statement)] = number, leg
            self.labels[procedure.name, number] = label_of(statement)
            if _moves_external(leg):
                self.external.add(id(statement))
            if isinstance(statement, MoveJoints) and self._mount(statement.motion) is None:
                self.bare.add(id(statement))

    def piece(
        self, statement: Moving, procedure: str, settings: Settings, near: JointValues | None
    ) -> Segment | None:
        """The statement with what the names stand for now; None if that is not known.

        near: where the arm is, as far as is known, for the turns of a computed target.
        """
        number, leg = self.numbers[id(statement)]
        key: tuple[object, ...] = (id(statement), settings)
        if leg.solved_run is None and len(leg.joints) == 0:
            joints = self._computed(statement, near)
            if joints is None:
                return None
            key = (*key, joints.tobytes())
            if key not in self.made:
                self.made[key] = self._to_joints(statement, joints, settings)
        elif key not in self.made:
            if not np.isfinite(leg.joints).all():
                return None
            self.made[key] = (
                self._to_joints(statement, leg.joints, settings)
                if leg.solved_run is None
                else _of_run(leg, self.tables, settings)
            )
        triggers = () if isinstance(statement, Follow) else statement.triggers
        lines = isinstance(statement, Follow) and statement.path.places is not None
        return Segment(procedure, number, self.made[key], key, triggers, lines=lines)

    def _to_joints(self, statement: Moving, joints: Floats, settings: Settings) -> Moves:
        """Moves to joints (m, a), whatever they are the joints of."""
        assert not isinstance(statement, Follow)
        motion = statement.motion
        mount = self._mount(motion) or Mount(Tool(), Frame())
        n = len(joints)
        speed, blend = motion.fixed
        kinds = {Move: [Kind.LINEAR], MoveCircular: [Kind.VIA, Kind.END]}.get(
            type(statement), [Kind.JOINT]
        )
        if isinstance(statement, Move) and statement.kind == "joint":
            kinds = [Kind.JOINT]
        index = np.zeros(n, dtype=np.int32)
        return moves_of(
            np.array(kinds, dtype=np.uint8),
            joints,
            mount.tip(self.solution.robot, joints),
            (index, (mount,)),
            SpeedsAndBlends(index, index, [speed], [blend]),
            slice(0, n),
            self.tables,
            settings,
        )

    def _computed(self, statement: Moving, near: JointValues | None) -> Floats | None:
        """(m, a) joints of the targets that a statement computes."""
        match statement:
            case Move(target=target):
                targets: tuple[Expression, ...] = (target,)
            case MoveCircular(via=via, target=target):
                targets = (via, target)
            case _:
                return None
        mount = self._mount(statement.motion)
        if mount is None:
            return None
        found = []
        for target in targets:
            place = self.values.place(target)
            joints = None if place is None else self._reached(place, mount, near)
            if joints is None:
                return None
            found.append(joints)
            near = tuple(joints.tolist())
        return np.array(found)

    def _mount(self, motion: Motion) -> Mount | None:
        tool = self.names.tool(motion.tool) or (Tool() if motion.tool == FLANGE else None)
        frame = self.names.frame(motion.frame) or (Frame() if motion.frame == BASE else None)
        if tool is None or frame is None or frame.mechanism:
            return None
        return Mount(tool, frame)

    def _reached(self, place: Place, mount: Mount, near: JointValues | None) -> Floats | None:
        """(a,) in the branch of the target that a place comes from, turned as little as can be."""
        robot = self.solution.robot
        p = np.array([place.pose.position], dtype=np.float64)
        q = np.array([place.pose.quaternion], dtype=np.float64)
        no_row = np.zeros(1, dtype=np.int32)
        flange = mount.to_flange(*targets_out_of_frames([mount.frame.pose], no_row, p, q))
        row = np.array([configuration_row(place.target.configuration)], dtype=np.int8)
        stated = robot.arm.named and row[0, BACK] != UNSTATED
        branches = (int(robot.branch_of(row)[0]),) if stated else None
        found, _ = robot.solve(*flange, branches)
        at = robot.home if near is None else np.array(near)
        best: Floats | None = None
        for joints in found[:, :, 0].T:
            turned = at + robot.wound(joints - at)
            for one in (turned, joints):
                good = robot.inside(one) and robot.closes(one[None], *flange)[0]
                if good and (best is None or _travel(one, at) < _travel(best, at)):
                    best = one
        return best


def label_of(statement: Moving) -> str:
    """Return the target of a statement, in words of the pseudo-program."""
    if isinstance(statement, Follow):
        return f"path {statement.path.name}"
    return f"`{expression_text(statement.target)}`"


def _travel(joints: Floats, at: Floats) -> float:
    return float(np.abs(joints - at).max())


def _empty(statement: Moving) -> bool:
    return isinstance(statement, Follow) and not len(statement.path)


def _moves_external(leg: Leg) -> bool:
    if leg.solved_run is None:
        return False
    external = leg.solved_run.run.external[max(leg.rows.start - 1, 0) : leg.rows.stop]
    used = np.isfinite(external).all(axis=0)
    return bool((np.ptp(external[:, used], axis=0) > 0.0).any())


def _of_run(leg: Leg, tables: tuple, settings: Settings) -> Moves:  # type: ignore[type-arg]
    assert leg.solved_run is not None
    run, rows = leg.solved_run.run, leg.rows
    mounting = run.mounting
    p, q = run.targets(rows)
    tool, frame = mounting.tool[rows], mounting.frame[rows]
    many = len(mounting.frames)
    both = tool.astype(np.intp) * many + frame
    used = np.flatnonzero(np.bincount(both))
    mounts = tuple(
        Mount(mounting.tools[one // many], mounting.frames[one % many]) for one in used.tolist()
    )
    return moves_of(
        run.kinds[rows],
        leg.joints,
        targets_out_of_frames([f.pose for f in mounting.frames], frame, p, q),
        (np.searchsorted(used, both).astype(np.int32), mounts),
        run.pace,
        rows,
        tables,
        settings,
    )


class Carried(Protocol):
    """Bodies that an arm carries, as far as known; states that are alike compare equal."""

    def switched(self, name: str, value: float | None, joints: JointValues | None) -> Carried:
        """The same after an output, or `hand 1` (1 for closed), is set where the arm stands.

        value, joints: None for what is not known.
        """

    def met(self, other: Carried) -> Carried:
        """Merge the carried bodies where two branches of a program meet."""


def with_carried(
    statement: Statement, state: State, waiting: Sequence[Segment], values: Values
) -> State:
    """Return the state after a statement, with the bodies that the arm carries then.

    An output that a move sets during its motion counts from the end of the move, a pulse as if it
    stayed.
    """
    carried = state.carried
    assert carried is not None
    joints: JointValues | None = None
    if waiting:
        joints = tuple(waiting[-1].moves.joints[-1].tolist())
    elif len(state.places) == 1:
        joints = state.places[0]
    for name, value in _switches(statement, values):
        carried = carried.switched(name, value, joints)
    return state if carried == state.carried else replace(state, carried=carried)


def _switches(statement: Statement, values: Values) -> Iterator[tuple[str, float | None]]:
    match statement:
        case SetSignal(signal=signal, value=value):
            settings = [(signal, value)]
        case Gripper(action=action, hand=hand):
            yield f"hand {hand}", float(action == "close")
            return
        case Follow():
            return
        case _ if isinstance(statement, Moving):
            settings = [(trigger.signal, trigger.value) for trigger in statement.triggers]
        case _:
            return
    for signal, value in settings:
        number = values.number(value)
        if number is None and (truth := values.truth(value)) is not None:
            number = float(truth)
        yield signal, number

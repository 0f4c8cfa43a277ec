"""Comparison of what two programs do to the world, each as its own interpreter reports it.

Two runs may differ because the text of one of them prints a limited number of decimals. A text
holds constants: targets, frames, tools. Each value of one is off by half of its last decimal at
most, three values of a position by √3 of that; an orientation is off by an angle, which moves a
point by the angle times its lever. The tip of a motion depends on few constants:

- the target; a position that is a constant of the text depends on nothing else but its frame;
- the frame of the target: its angle counts with the distance from the frame to the tip;
- where the target is computed: what it is moved by or was read from, and the tool. When a position
  is read, the flange follows from both, so that its angle counts with the tool's length.

A frame or tool that is not stated (the base, the flange) is no constant. Joint values are off by
half of their last decimal each; that moves the tip by at most their sum times the reach of the arm.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import field, replace
from itertools import zip_longest
from typing import Final, Literal

import numpy as np

from assistant.base import rotations
from assistant.base.data_classes import dataclass
from assistant.program.geometry import IDENTITY, Pose
from assistant.virtual.events import (
    Awaited,
    Event,
    Kept,
    Logged,
    Moved,
    Noted,
    OnWay,
    Place,
    Reported,
    Run,
    Said,
    Sent,
    Stopped,
    Switched,
    Waited,
    Why,
    event_text,
)

_CALCULATION_ERROR: Final = 1e-6
"""mm and degrees that working numbers out may add."""
_KEY_DECIMALS: Final = 4
"""Decimals of mm by which a place is known again."""


@dataclass(frozen=True, slots=True)
class Allowed:
    """Mm and degrees that the tips, and the tools on their flanges, may be apart."""

    tip: float
    angle: float
    tool: float
    tool_angle: float


@dataclass(frozen=True, slots=True)
class Printed:
    """Rounding of one constant in the text, if it differs from that of most.

    value: mm, half of the last decimal of a coordinate. angle: degrees, of the orientation, whose
    three angles are off by half of their last decimal each.
    """

    value: float
    angle: float


@dataclass(frozen=True, slots=True)
class Rounding:
    """Rounding of any constant in a text. joint: degrees, of a joint value.

    constants: rounding of the constants in the text, by their position. The text may contain a
    frame as its inverse.
    """

    value: float
    angle: float
    joint: float
    constants: dict[tuple[float, ...], Printed] = field(default_factory=dict)

    def of(self, poses: Iterable[tuple[Pose, Printed]]) -> Rounding:
        """With the constants that a text holds."""
        found = dict(self.constants)
        for pose, printed in poses:
            # A text may hold a frame as its inverse, which is as exact.
            found |= {_position_key(pose): printed, _position_key(pose.inverse()): printed}
        return Rounding(self.value, self.angle, self.joint, found)

    def allowed(self, move: Moved, reach: float) -> Allowed:
        """Return the tolerance of a motion around its intended target. reach: mm, the farthest of
        all tips.
        """
        far, turned, tip = _CALCULATION_ERROR, _CALCULATION_ERROR, _tip_of(move)
        target = None if tip is None else move.frame.inverse() @ tip
        known = None if target is None else self.constants.get(_position_key(target))
        for printed in (known or self._any, self._any):  # the target, and what may turn it
            turned += printed.angle
        far += _position_error(known or self._any)
        # A computed target depends on a second constant, and on the tool that was read with it.
        if known is None:
            far += _position_error(self._any)
            if move.tool != IDENTITY:
                printed = self._printed(move.tool)
                turned += printed.angle
                length = math.hypot(*move.tool.position)
                far += _position_error(printed) + math.radians(printed.angle) * length
        if move.frame != IDENTITY and tip is not None:
            printed = self._printed(move.frame)
            turned += printed.angle
            lever = math.dist(tip.position, move.frame.position)
            far += _position_error(printed) + math.radians(printed.angle) * lever
        if move.joints is not None:
            joints = len(move.joints) * (self.joint + _CALCULATION_ERROR)
            far += math.radians(joints) * reach
            turned += joints
        tool = self._printed(move.tool)
        return Allowed(
            far, turned, _position_error(tool) + _CALCULATION_ERROR, tool.angle + _CALCULATION_ERROR
        )

    @property
    def _any(self) -> Printed:
        return Printed(self.value, self.angle)

    def _printed(self, pose: Pose) -> Printed:
        return self.constants.get(_position_key(pose), self._any)


def _position_error(printed: Printed) -> float:
    return math.sqrt(3.0) * printed.value


def _position_key(pose: Pose) -> tuple[float, ...]:
    # + 0.0 makes -0.0 and 0.0 the same key.
    return tuple(round(value, _KEY_DECIMALS) + 0.0 for value in pose.position)


def _tip_of(move: Moved) -> Pose | None:
    """The tip of the tool where a motion ends, None where only its joints are known."""
    return None if move.flange is None else move.flange @ move.tool


def _reach_of(moves: Sequence[Moved]) -> float:
    """Return the distance of the farthest tip from the base, in mm."""
    tips = [tip for tip in map(_tip_of, moves) if tip is not None]
    return max((float(np.linalg.norm(tip.position)) for tip in tips), default=0.0)


POSITION: Final = 0.02
"""mm. MELFA-BASIC has two decimals of a millimetre, so that a place is off by 0.009 at most, and
a tool or a frame by as much again; one that was read wrongly is off by far more."""
_ANGLE: Final = 0.02
"""Degrees, for the same reason. Both where nothing tells what is printed, see `Rounding`."""
JOINT: Final = 0.02
SPEED: Final = 1e-3
"""Tolerance as a part of the speed."""
_SINGLE: Final = 2.0**-22
"""Part of the farthest position: error of a few steps in single precision, as RAPID computes
positions.
"""
BLEND: Final = 0.01
TIME: Final = 1e-3
_SINGLE_TURN: Final = math.degrees(4.0 * 2.0**-24)
"""Degrees that the same does to orientations: the four components of a quaternion are each off by
half of their last bit, 2 to the power of -25, which turns by twice their length; twice, for the
target and for what the program moves it by."""
_LIMIT: Final = 0.1
_LATE: Final = 0.2
"""Part of the longest time of a wait, and seconds, that statements around it may take."""
_STATEMENTS: Final = 5.0
"""Times as long as those of one program the statements of another may take."""
_SHARED: Final = 1e-5
"""Part of a value that shared data may be off: some controllers use single precision."""
_BROKEN_OFF: Final[Set[Why]] = frozenset({"steps", "unknown"})
"""Endings of runs that were cut off."""

Uncompared = Literal[
    "speeds of joint moves",
    "accelerations",
    "narrower corners",
    "stops for interrupts",
    "other moments of interrupts",
    "waits for timers behind inputs",
    "what goes on during delays",
    "times in shared data",
    "texts for people",
    "texts over lines",
]
"""Kinds of effects that two programs may have without the same being asked of both."""

COMPARED: Final[Mapping[str, str]] = {
    "a motion": "kind, tool, place, speed along a line; a corner may not be wider",
    "an output": "its value, where on a move it changes, and after which time: a pulse's length",
    "a wait for inputs": "where it is, and which inputs end it",
    "a longest time of a wait, a condition with a timer": (
        f"seconds, to {_LIMIT:.0%} and {_LATE:g} s; a wait that is tried again runs out up to "
        "five times"
    ),
    "a delay": "seconds",
    "shared data": "a number, truth or text that outlives the program, before each other effect",
    "an interrupt": (
        "where it may come (once in a run, or as its input comes, goes and comes again), and "
        "what it does"
    ),
    "a stop, an end, an error": "where it is",
}
"""Effects by their kinds, and what of each has to be the same."""
NOT_COMPARED: Final[Mapping[Uncompared, str]] = {
    "speeds of joint moves": "each arm has percentages of its own",
    "accelerations": "each arm has others",
    "narrower corners": "they stay nearer to the target",
    "stops for interrupts": "motions take no time here, so no arm is stopped on its way",
    "other moments of interrupts": "each is tried at the first and the last five",
    "waits for timers behind inputs": "the input comes to either at another time",
    "what goes on during delays": (
        "one language waits until it sets the output that another sets later while it goes on"
    ),
    "times in shared data": "statements of two languages take different times",
    "texts for people": "people read them, the cell does not",
    "texts over lines": "one language sends through a gateway what another sends itself",
}
"""Effects that are not compared, with the reason."""

Bits = Mapping[str, Sequence[int] | str]
"""Numbers of a signal's bits, the lowest first, or its other name, by its name in lower case."""


@dataclass(frozen=True, slots=True)
class Unlike:
    """The first thing that two runs do differently. event: its number, 0 for how they end.

    first, second: what either does there, None where it does nothing more. places: files and lines
    where either does it, or ends.
    """

    event: int
    what: str
    first: Logged | None = None
    second: Logged | None = None
    places: tuple[Place | None, Place | None] = (None, None)

    def __str__(self) -> str:
        return f"event {self.event}: {self.what}" if self.event else self.what


@dataclass(frozen=True, slots=True)
class Likeness:
    """Result of the comparison of two runs. visits: motions. changes: signals that were set. waits:
    those that inputs end. values: those of shared data. left: kinds of effects that were not
    compared.

    apart: largest distance in mm between the tips of the tools where motions end. turned: degrees.
    differences: empty if both do the same; after one that is not just another value of the same
    effect, nothing was compared.
    """

    visits: int = 0
    changes: int = 0
    apart: float = 0.0
    turned: float = 0.0
    differences: tuple[Unlike, ...] = ()
    waits: int = 0
    values: int = 0
    left: frozenset[Uncompared] = frozenset()

    @property
    def unlike(self) -> Unlike | None:
        """The first difference, None if both do the same."""
        return next(iter(self.differences), None)


def difference(
    first: Run, second: Run, signals: Bits | None = None, rounding: Rounding | None = None
) -> str | None:
    """Return the first difference between two runs; None if they agree."""
    unlike = likeness(first, second, signals, rounding).unlike
    return None if unlike is None else str(unlike)


def likeness(
    first: Run,
    second: Run,
    signals: Bits | None = None,
    rounding: Rounding | None = None,
    most: int = 1,
    measured: Set[str] = frozenset(),
) -> Likeness:
    """Compare two runs, as far as they agree.

    most: differences that are reported; after them nothing is compared. signals: numbers in one run
    of names in the other. A signal that is set to its present value does nothing; nor do texts, and
    delays of no time. A corner of the second may be narrower. Joints are compared where their
    flange is unknown: two arms in the same pose have different joints. Speeds of joint motions are
    not compared: they are percentages of an arm's limits. A run of the first that waits for ever,
    or ends for good, may be one without end in the second. Where the first ends with an error, the
    second may stop. Of a run that was cut off only the reported events are compared, and the other
    one has to do as much. rounding: rounding in one of the texts; without it positions may be apart
    by POSITION and ANGLE. measured: shared data that depends on how long statements take, which is
    not compared.
    """
    ours = list(_compared_events(first, signals or {}, measured))
    others = list(_compared_events(second, signals or {}, measured))
    halted = bool(ours) and ours[-1].what == Stopped(end=True)
    if halted:  # a program that must not go on may stop again and again
        ours[-1] = _wired_event(ours[-1], Stopped())
        if others and others[-1].what == Stopped(end=True):
            others[-1] = _wired_event(others[-1], Stopped())
        while len(others) > len(ours) and others[-1].what == Stopped():
            others.pop()
    both = (first.ended, second.ended)
    # A run that was cut off did nothing afterwards that could be compared.
    if both[0] in _BROKEN_OFF:
        others = others[: len(ours)]
    if both[1] in _BROKEN_OFF and both != ("stopped", "steps"):
        ours = ours[: len(others)]
    if first.ended == "error" and all(
        isinstance(x.what, Stopped | Kept) for x in others[len(ours) :]
    ):
        # where a controller would stop with an error, another one may just stop; what shared data
        # holds then is told before the stop, and not told of the first
        if len(others) > len(ours):
            others, halted = others[: len(ours)], True
    told = (*first.events, *second.events)
    reach = _reach_of([row.what for row in ours if isinstance(row.what, Moved)])
    comparing = _Comparing((first, second), rounding, reach)
    limits = _Limits((_expired(first), _expired(second)), comparing.left)
    if len(later := _with_delays(ours, others)) < len(others):
        others = later
        comparing.left.add("what goes on during delays")
    if any(isinstance(event, Said | Reported) for event in told):
        comparing.left.add("texts for people")
    if any(isinstance(event, Sent) for event in told):
        comparing.left.add("texts over lines")
    if any(isinstance(event, Kept) and event.name in measured for event in told):
        comparing.left.add("times in shared data")
    for number, (one, two) in enumerate(zip_longest(ours, others), 1):
        if one is None:
            comparing.note(number, f"{_end(first)}, and {event_text(two.what)}", one, two)
            return comparing.found()
        if two is None:
            comparing.note(number, f"{event_text(one.what)}, and {_end(second)}", one, two)
            return comparing.found()
        wrong = comparing.unlike(one.what, two.what) or limits.unlike(one, two)
        if wrong is not None:
            what = f"{wrong}: {event_text(one.what)}, and {event_text(two.what)}"
            comparing.note(number, what, one, two)
            # After an event of another kind all further pairs would be shifted.
            if len(comparing.differences) == most or not _same_effect(one.what, two.what):
                return comparing.found()
    if not halted and not _end_alike(*both):
        comparing.note(0, f"{_end(first)}, and {_end(second)}")
    return comparing.found()


def _with_delays(ours: Sequence[Logged], others: Sequence[Logged]) -> list[Logged]:
    """The events of the second run, with a delay and an output as one that is set later where the
    first run has that.
    """
    found: list[Logged] = []
    place = 0
    while place < len(others):
        row = others[place]
        one = ours[len(found)].what if len(found) < len(ours) else None
        two = others[place + 1].what if place + 1 < len(others) else None
        match one, row.what, two:
            case (
                Switched(after=float(after)),
                Waited(seconds=seconds),
                Switched(signal, value, at=None, after=None),
            ) if abs(seconds - after) <= TIME and (one.signal, one.value) == (signal, value):
                place += 1
                row = _wired_event(others[place], replace(two, after=after))
        found.append(row)
        place += 1
    return found


def _same_effect(one: Event, two: Event) -> bool:
    """True if two effects are the same one with different values: the comparison can continue after
    it.
    """
    match one, two:
        case (Moved(), Moved()) | (Waited(), Waited()):
            return True
        case Switched(), Switched():
            return one.signal == two.signal
        case Kept(), Kept():
            return one.name == two.name
    return False


_BY_SPEED: Final = {("time", "end"), ("end", "end")}
"""Measures of a position on the path, in the first run and in the second, that the speed converts
into each other.
"""


_START: Final = OnWay("start", 0.0)
_ENDS: Final = (_START, OnWay("end", 0.0))
"""Places on the path at which a statement before or after the move does the same."""


def _expired(run: Run) -> dict[float, float]:
    """Longest times of waits that were over, in seconds, by when they were."""
    rows = run.log
    return {r.time: r.what.seconds for r in rows if isinstance(r.what, Waited) and r.what.limit}


def _over(row: Logged) -> float:
    """When an event is over: a delay takes its time, all others none."""
    return row.time + (row.what.seconds if isinstance(row.what, Waited) else 0.0)


@dataclass(slots=True)
class _Limits:
    """Compares how long waits with a limit take: one language states it, another counts a timer.

    expired: of either run, see `_expired`. left: gets what is not compared. since: when the events
    before were over. within: whether these were inputs, which may have come while such a wait
    lasted: nothing tells when in it.
    """

    expired: tuple[Mapping[float, float], Mapping[float, float]]
    left: set[Uncompared]
    since: tuple[float, float] = (0.0, 0.0)
    within: bool = False

    def unlike(self, first: Logged, second: Logged) -> str | None:
        """Return the difference in the time that both took from the previous events, which agree,
        to these.
        """
        before, ends, within = self.since, (first.time, second.time), self.within
        self.since = _over(first), _over(second)
        self.within = isinstance(first.what, Awaited)
        stated = [0.0, 0.0]
        for side, (known, start, end) in enumerate(zip(self.expired, before, ends, strict=True)):
            for when, seconds in known.items():
                if start < when <= end:
                    # The input may have come at any time within
                    # the wait: its length cannot be compared.
                    if within and when - seconds < start + TIME:
                        self.left.add("waits for timers behind inputs")
                    else:
                        stated[side] += seconds
        longest = max(stated)
        if longest <= 0.0:
            return None
        took = [end - start for start, end in zip(before, ends, strict=True)]
        side = stated.index(longest)
        # The other language may take several times as long as statements of the first.
        spare = _STATEMENTS * max(took[side] - longest, 0.0)
        if abs(took[0] - took[1]) <= _LIMIT * longest + _LATE + spare:
            return None
        return f"another longest time of a wait, {took[0]:.3g} s and {took[1]:.3g} s"


class _Comparing:
    """Compares one event of either run after the other, and keeps how far they were apart."""

    def __init__(self, runs: tuple[Run, Run], rounding: Rounding | None, reach: float) -> None:
        self.runs, self.rounding, self.reach = runs, rounding, reach
        self.visits = self.changes = self.waits = self.values = 0
        self.apart = self.turned = 0.0
        self.left: set[Uncompared] = set()
        self.differences: list[Unlike] = []
        self.place = POSITION
        self.speed: float | None = None

    def found(self) -> Likeness:
        return Likeness(
            visits=self.visits,
            changes=self.changes,
            apart=self.apart,
            turned=self.turned,
            differences=tuple(self.differences),
            waits=self.waits,
            values=self.values,
            left=frozenset(self.left),
        )

    def note(
        self, event: int, what: str, one: Logged | None = None, two: Logged | None = None
    ) -> None:
        places = tuple(
            run.place if row is None else row.place
            for row, run in zip((one, two), self.runs, strict=True)
        )
        self.differences.append(Unlike(event, what, one, two, (places[0], places[1])))

    def unlike(self, one: Event, two: Event) -> str | None:
        """Return the difference of two events, None if they are the same."""
        match one, two:
            case Moved(), Moved():
                self.visits += 1
                return self._motion(one, two)
            case Switched(), Switched():
                self.changes += 1
                if (one.signal, one.value) != (two.signal, two.value):
                    return "another event"
                if not _same_time(one.after, two.after):
                    return "another time"
                return None if self._same_place(one.at, two.at) else "another place on the way"
            case Awaited(), Awaited():
                self.waits += 1
            case Kept(), Kept():
                self.values += 1
                return None if _same_value(one, two) else "another value"
            case Waited(), Waited():
                return None if abs(one.seconds - two.seconds) <= TIME else "another delay"
        return None if one == two else "another event"

    def _external(self, one: Moved, two: Moved) -> bool:
        """True if the external axes whose positions both motions state agree."""
        # Both texts round: twice the rounding of one.
        most = JOINT if self.rounding is None else 2.0 * self.rounding.joint
        stated = (
            (a, b)
            for a, b in zip(one.external, two.external, strict=False)
            if a is not None and b is not None
        )
        return all(abs(a - b) <= most for a, b in stated)

    def _motion(self, one: Moved, two: Moved) -> str | None:
        if one.kind != two.kind:
            return "another kind of motion"
        allowed = self._allowed(two)
        self.place = 2.0 * allowed.tip
        self.speed = None if one.kind == "joint" else one.speed
        if one.flange is None or two.flange is None:
            if one.joints is None or two.joints is None:
                return "joints, and a position"
            joint = JOINT if self.rounding is None else 2.0 * self.rounding.joint
            if not _is_near(one.joints, two.joints, joint):
                return "other joints"
        elif wrong := self._tips(one, two, allowed):
            return wrong
        if not self._external(one, two):
            return "other places of external axes"
        if (one.via is None) != (two.via is None):
            return "no place on the way"
        if one.via is not None and two.via is not None:
            far, turned = _angle_between(one.via @ one.tool, two.via @ two.tool)
            if far > allowed.tip or turned > allowed.angle:
                return f"another place on the way, {_offset_text(far, turned)}"
        far, turned = _angle_between(one.tool, two.tool)
        if far > allowed.tool or turned > allowed.tool_angle:
            return f"another tool, {_offset_text(far, turned)}"
        self._leave(one, two)
        if one.kind != "joint" and one.speed is not None:
            if two.speed is None or abs(one.speed - two.speed) > SPEED * one.speed:
                return "another speed"
        return "a wider corner" if two.blend > one.blend + BLEND else None

    def _leave(self, one: Moved, two: Moved) -> None:
        if one.kind == "joint":
            self.left.add("speeds of joint moves")
        factors = {one.how.acceleration, one.how.deceleration}
        if factors | {two.how.acceleration, two.how.deceleration} != {1.0}:
            self.left.add("accelerations")
        if two.blend < one.blend - BLEND:
            self.left.add("narrower corners")

    def _tips(self, one: Moved, two: Moved, allowed: Allowed) -> str | None:
        """Compare the tips of the tools, and the flanges: a different tool may hide a
        difference.
        """
        first, second = _tip_of(one), _tip_of(two)
        assert first is not None and second is not None
        assert one.flange is not None and two.flange is not None
        # Without a known rounding the flange is compared, which does not depend on the tool.
        if self.rounding is None:
            first, second = one.flange, two.flange
        far, turned = _angle_between(first, second)
        self.apart, self.turned = max(self.apart, far), max(self.turned, turned)
        if far > allowed.tip or turned > allowed.angle:
            return f"another flange, {_offset_text(far, turned)}"
        return None

    def _allowed(self, move: Moved) -> Allowed:
        allowed = Allowed(POSITION, _ANGLE, POSITION, _ANGLE)
        if self.rounding is not None:
            allowed = self.rounding.allowed(move, self.reach)
        single = _SINGLE * self.reach
        return replace(
            allowed,
            tip=allowed.tip + single,
            tool=allowed.tool + single,
            angle=allowed.angle + _SINGLE_TURN,
            tool_angle=allowed.tool_angle + _SINGLE_TURN,
        )

    def _same_place(self, one: OnWay | None, two: OnWay | None) -> bool:
        """True if two positions on the path are equivalent. An output at the very end of a move
        with a corner may be set after it, one at its start before it, and one set by time at the
        position that the programmed speed gives.
        """
        if one is None or two is None:
            return one is two or (two is None and one in _ENDS)
        near = TIME if one.measure == "time" else self.place
        if one.measure == two.measure and abs(one.ahead - two.ahead) <= TIME:
            return abs(one.amount - two.amount) <= near
        if self.speed is None or two.ahead or (one.measure, two.measure) not in _BY_SPEED:
            return False
        seconds = one.ahead + (one.amount if one.measure == "time" else 0.0)
        before = one.amount if one.measure == "end" else 0.0
        return abs(before + seconds * self.speed - two.amount) <= self.place


def _end_alike(first: Why, second: Why) -> bool:
    return first == second or bool(_BROKEN_OFF & {first, second})


def _end(run: Run) -> str:
    return f"ended as `{run.ended}` {run.message}".rstrip()


def _compared_events(run: Run, signals: Bits, measured: Set[str]) -> Iterator[Logged]:
    """Yield the events that count, with signals as changed bits, and new values of shared data.

    measured: shared data without those of these names.
    """
    kept: dict[str, Logged] = {}
    held: dict[str, Kept] = {}
    for row in _effects(run, signals):
        if isinstance(row.what, Kept):
            if row.what.name not in measured:
                kept[row.what.name] = row
            continue
        yield from _new_events(kept, held)
        yield row
    if run.ended == "end":  # else the last values hang on where it was broken off
        yield from _new_events(kept, held)


def _new_events(kept: dict[str, Logged], held: dict[str, Kept]) -> Iterator[Logged]:
    """Values of shared data that differ from those before."""
    for name in sorted(kept):
        row = kept.pop(name)
        assert isinstance(row.what, Kept)
        before = held.get(name)
        if before is None or not _same_value(before, row.what):
            held[name] = row.what
            yield row


def _effects(run: Run, signals: Bits) -> Iterator[Logged]:
    """The events that count, signals as the bits that change."""
    state: dict[str, float] = {}
    counted = [numbers for numbers in signals.values() if not isinstance(numbers, str)]
    named = {str(number) for numbers in counted for number in numbers}
    for row in _ordered_triggers(run.log or [Logged(0.0, "", None, event) for event in run.events]):
        match row.what:
            case Said() | Sent() | Reported() | Noted() | Waited(seconds=0.0) | Waited(limit=True):
                continue
            case Switched(signal, value, at, after):
                for bit, on in _bits(signal, value, signals):
                    # A byte is written with what its other bits have, which are 0 at first.
                    before = None if bit in named or not bit.isdecimal() else 0.0
                    if state.get(bit, before) != on:
                        yield _wired_event(row, Switched(bit, on, at, after))
                    state[bit] = on
            case _:
                yield row


def _ordered_triggers(rows: Sequence[Logged]) -> Iterator[Logged]:
    """Yield the outputs set at the start of a move before it, whether or not a statement sets them
    there.
    """
    place = 0
    while place < len(rows):
        last = place + 1
        if isinstance(rows[place].what, Moved):
            while last < len(rows) and _trigger_of(rows[last].what) is not None:
                last += 1
            yield from (row for row in rows[place + 1 : last] if _trigger_of(row.what) == _START)
        yield rows[place]
        yield from (row for row in rows[place + 1 : last] if _trigger_of(row.what) != _START)
        place = last


def _trigger_of(event: Event) -> OnWay | None:
    return event.at if isinstance(event, Switched) else None


def _wired_event(row: Logged, event: Event) -> Logged:
    return Logged(row.time, row.task, row.place, event)


def _bits(signal: str, value: float, signals: Bits) -> Iterator[tuple[str, float]]:
    numbers = signals.get(signal)
    if numbers is None or isinstance(numbers, str):
        yield numbers or signal, value
        return
    for place, number in enumerate(numbers):
        yield str(number), float(int(value) >> place & 1)


def _same_time(one: float | None, two: float | None) -> bool:
    return one is two if one is None or two is None else abs(one - two) <= TIME


def _same_value(one: Kept, two: Kept) -> bool:
    if one.name != two.name or isinstance(one.value, str) or isinstance(two.value, str):
        return one == two
    return math.isclose(one.value, two.value, rel_tol=_SHARED, abs_tol=_SHARED)


def _is_near(one: Sequence[float], two: Sequence[float], most: float) -> bool:
    return len(one) == len(two) and bool(np.all(np.abs(np.subtract(one, two)) <= most))


def _angle_between(one: Pose, two: Pose) -> tuple[float, float]:
    """Return the distance and angle between two poses, in mm and degrees."""
    far = float(np.linalg.norm(np.subtract(one.position, two.position)))
    return far, float(rotations.angle_between(one.quaternion, two.quaternion))


def _offset_text(far: float, turned: float) -> str:
    return f"{far:.2f} mm and {turned:.2f} degrees off"

"""Events: what a program does to the world while it runs, the same records for every language.

Two programs do the same if their events agree: a translation is judged by its events, without the
reader that it was made with. A `Branch` is a way on which a run can go on at a decision of a
program; interpreters report those that are taken to `Kernel.branch`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

from assistant.program.geometry import Pose


@dataclass(frozen=True, slots=True)
class How:
    """What a motion tells its controller beside where it leads; it is no part of what is compared.

    configuration: neutral columns as of a `Path`, None where any arm branch will do. rotation:
    degrees/s of the tool. acceleration, deceleration: factors. behind: mm behind the target where
    the corner ends, None for as many as before it. seconds: that the motion is to take, None
    where its speed tells. mass: kg of the tool, None where it is not known.
    """

    configuration: tuple[int, ...] | None = None
    rotation: float = 500.0
    acceleration: float = 1.0
    deceleration: float = 1.0
    behind: float | None = None
    seconds: float | None = None
    mass: float | None = None


PLAIN: Final = How()


@dataclass(frozen=True, slots=True)
class Moved:
    """A motion that was commanded.

    flange: its pose in the robot's own base, mm and unit quaternions, where the motion ends.
    tool: the tool on the flange. via: the flange on the way of an arc. joints: degrees, where
    the motion names them. speed: of the tool in mm/s where the motion states one, percent of the
    axes' own where it states that. blend: mm, 0 for a motion that ends at its target. frame: in the
    base, what the target is told in: where a program says it does not change what the robot does,
    but how far the place is off if the frame is rounded. external: where external axes stand at the
    end, mm or degrees, None for those that the motion states no place of.
    """

    kind: Literal["joint", "linear", "circular"]
    flange: Pose | None
    tool: Pose
    via: Pose | None = None
    joints: tuple[float, ...] | None = None
    speed: float | None = None
    percent: float | None = None
    blend: float = 0.0
    frame: Pose = field(default=Pose(), compare=False)
    how: How = field(default=PLAIN, compare=False, repr=False)
    external: tuple[float | None, ...] = field(default=(), compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class OnWay:
    """Where on the way of the motion before it something happens.

    amount: mm before the end of the way or behind its start, seconds before its end, or percent of
    it that is done. ahead: seconds earlier than there.
    """

    measure: Literal["start", "end", "time", "share"]
    amount: float
    ahead: float = 0.0


@dataclass(frozen=True, slots=True)
class Switched:
    """A signal that was set. signal: its name or number, as the language says it, lower case.

    at: None for where the robot is when the program gets there. after: seconds until it is set, as
    at the end of a pulse, where that is told at once.
    """

    signal: str
    value: float
    at: OnWay | None = None
    after: float | None = None


@dataclass(frozen=True, slots=True)
class Called(Switched):
    """What a motion does on its way but setting an output: an interrupt. act: does it.

    It is no event: what the interrupt does is told.
    """

    signal: str = ""
    value: float = 0.0
    act: Callable[[], None] = field(default=lambda: None, compare=False)


@dataclass(frozen=True, slots=True)
class Waited:
    """A delay that the program states, in seconds.

    limit: it is the longest time of a wait that was over, or the time of a wait for a timer, which
    another program may do in another way.
    """

    seconds: float
    limit: bool = False


@dataclass(frozen=True, slots=True)
class Awaited:
    """A wait for inputs, which came to be these: wires and their values. Proofs alone tell it."""

    inputs: tuple[tuple[str, float], ...]


@dataclass(frozen=True, slots=True)
class Kept:
    """What shared data holds from now on. Proofs alone tell it."""

    name: str
    value: float | str


@dataclass(frozen=True, slots=True)
class Sent:
    """Bytes that go out over a line. Proofs alone tell it."""

    data: bytes


@dataclass(frozen=True, slots=True)
class Said:
    """A text on the teach pendant."""

    text: str


@dataclass(frozen=True, slots=True)
class Reported:
    """A message in the event log. kind: `error`, `warning` or `information`."""

    kind: str
    header: str
    lines: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Stopped:
    """The program waits for a person. end: for good."""

    end: bool = False


@dataclass(frozen=True, slots=True)
class Noted:
    """Something about the motion that a controller tells, or that is only assumed."""

    text: str


Event = Moved | Switched | Waited | Awaited | Kept | Sent | Said | Reported | Stopped | Noted

Place = tuple[str, int]
"""A file's name, and a line from 1."""


def event_text(event: Event) -> str:
    """An event in a line."""
    match event:
        case Moved():
            where = event.joints if event.flange is None else event.flange.position
            stated = "" if where is None else ", ".join(f"{v:.2f}" for v in where)
            return f"{event.kind} to ({stated}) at {event.speed} blend {event.blend}"
        case Switched(signal, value, at, after):
            length = "" if after is None else f" after {after:g} s"
            place = "" if at is None else f" at {at.amount:g} of {at.measure}, {at.ahead:g} s ahead"
            return f"signal {signal} = {value:g}{place}{length}"
        case Waited(seconds):
            return f"{seconds:g} s"
        case Awaited(inputs):
            return "a wait that ends with " + ", ".join(f"{n}={v:g}" for n, v in inputs)
        case Kept(name, value):
            return f"`{name}` is {value if isinstance(value, str) else f'{value:g}'}"
        case Sent(data):
            return f"{data!r} over a line"
        case Stopped(end):
            return "an end for good" if end else "a stop"
        case Said(text):
            return f"text `{text}`"
    raise TypeError(event)


Why = Literal["end", "stopped", "steps", "time", "error", "unknown", "until"]
"""Why a run is over: `end` where the program came to its end, `stopped` where it waits for what
never comes, `steps` and `time` where it took more of them than it may, `until` where it was to be
ended from outside."""


@dataclass(slots=True)
class Logged:
    """What happened when: simulated seconds, the name of the task, a file's name and a line."""

    time: float
    task: str
    place: Place | None
    what: Event


@dataclass(frozen=True, slots=True)
class Run:
    """What happened, in order. ended: why it is over. log: the events with their times.

    task, place: where the task was that ended it, None if it was none of them. seconds: simulated,
    when it was over. steps: statements that ran.
    """

    events: tuple[Event, ...] = field(default=())
    ended: Why = "end"
    message: str = ""
    """Of `error`: what the controller would say; of `unknown`: what is not simulated."""
    log: tuple[Logged, ...] = field(default=(), repr=False)
    task: str = field(default="", compare=False)
    place: Place | None = field(default=None, compare=False)
    seconds: float = field(default=0.0, compare=False)
    steps: int = field(default=0, compare=False)
    notes: tuple[str, ...] = field(default=(), compare=False)
    """What the program asks for that the run takes without any effect, each once."""


BranchKey = tuple[str, int, int]
"""A file, where a statement stands in it, and which way it goes on, as `Kernel.branch` is told."""


@dataclass(frozen=True, slots=True)
class Branch:
    """One way. file, line: of its statement. said: the word of the statement and what it finds."""

    file: str
    line: int
    said: str


Branches = Mapping[BranchKey, Branch]
"""Those that a run can go. Of a condition that is a constant there are none."""

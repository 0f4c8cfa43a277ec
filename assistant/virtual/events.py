"""Events: effects of a running program on the world, the same records for every language.

Two programs are equivalent if their events agree: a translation is judged by its events, without
the reader that produced it. A `Branch` is one outcome of a decision in a program; interpreters
report the branches taken to `Kernel.branch`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Final, Literal

from assistant.base.data_classes import dataclass
from assistant.program.geometry import Pose


@dataclass(frozen=True, slots=True)
class How:
    """Further data of a motion for its controller, apart from its target; it is not compared.

    configuration: neutral columns as of a `Path`, None where any arm branch will do. rotation:
    degrees/s of the tool. acceleration, deceleration: factors. behind: mm after the target where
    the corner ends, None for as many as before it. seconds: duration of the motion, None where its
    speed sets it. mass: kg of the tool, None where it is unknown.
    """

    configuration: tuple[int, ...] | None = None
    rotation: float = 500.0
    acceleration: float = 1.0
    deceleration: float = 1.0
    behind: float | None = None
    seconds: float | None = None
    mass: float | None = None


_PLAIN: Final = How()


@dataclass(frozen=True, slots=True)
class Moved:
    """A motion that was commanded.

    flange: its pose in the robot base, mm and unit quaternions, where the motion ends. tool: the
    tool on the flange. via: the flange at the middle point of an arc. joints: degrees, if the
    motion names them. speed: that of the tool in mm/s if the motion states one, percent of the
    axes' maximum if it states that. blend: mm, 0 for a motion that ends at its target. frame: frame
    of the target, in the base: its choice does not change the motion, but it determines how far the
    position is off if the frame is rounded. external: positions of external axes at the end, mm or
    degrees, None for those that the motion leaves open.
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
    how: How = field(default=_PLAIN, compare=False, repr=False)
    external: tuple[float | None, ...] = field(default=(), compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class OnWay:
    """Position on the path of the preceding motion at which something happens.

    amount: mm before the end of the path or after its start, seconds before its end, or percent of
    the path covered. ahead: seconds earlier than that.
    """

    measure: Literal["start", "end", "time", "share"]
    amount: float
    ahead: float = 0.0


@dataclass(frozen=True, slots=True)
class Switched:
    """A signal that was set. signal: its name or number in the language, lower case.

    at: None for the robot's position when the program reaches the statement. after: seconds until
    it is set, as at the end of a pulse that is reported at once.
    """

    signal: str
    value: float
    at: OnWay | None = None
    after: float | None = None


@dataclass(frozen=True, slots=True)
class Called(Switched):
    """Action of a motion on its path other than setting an output: an interrupt. act: performs it.

    It is not an event: the effects of the interrupt are reported instead.
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
    """New value of shared data. Only proofs report it."""

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
    """An event with its simulated seconds, the name of the task, and a file's name and line."""

    time: float
    task: str
    place: Place | None
    what: Event


@dataclass(frozen=True, slots=True)
class Run:
    """Events of a run, in order. ended: reason of its end. log: the events with their times.

    task, place: position of the task that ended the run, None if no task did. seconds: simulated,
    at the end. steps: statements that ran.
    """

    events: tuple[Event, ...] = field(default=())
    ended: Why = "end"
    message: str = ""
    """For `error`: the message of the controller; for `unknown`: the feature that is not
    simulated.
    """
    log: tuple[Logged, ...] = field(default=(), repr=False)
    task: str = field(default="", compare=False)
    place: Place | None = field(default=None, compare=False)
    seconds: float = field(default=0.0, compare=False)
    steps: int = field(default=0, compare=False)
    notes: tuple[str, ...] = field(default=(), compare=False)
    """Requests of the program that have no effect on the run, each once."""


BranchKey = tuple[str, int, int]
"""File, position of a statement in it, and number of its branch, as `Kernel.branch` gets them."""


@dataclass(frozen=True, slots=True)
class Branch:
    """One way. file, line: of its statement. said: the word of the statement and what it finds."""

    file: str
    line: int
    said: str


Branches = Mapping[BranchKey, Branch]
"""Branches that a run can take. A condition that is a constant has none."""

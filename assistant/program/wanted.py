"""What a program uses and nobody declares: a cell has to say it before the program is whole."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from assistant.program.channels import ChannelLine
from assistant.program.geometry import Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.program import Signal

WantedKind = Literal[
    "tool",
    "frame",
    "speed",
    "blend",
    "position",
    "joints",
    "signal",
    "data",
    "routine",
    "record",
    "arm",
    "line",
]
"""What it is: as in a process file, `data` for any other value, `routine` for what is called,
`record` for a type of data, whose value is a text with type and name for each component,
`arm` for the one that joint angles were taught on, `line` for a line of the controller by its
number."""
Plain: TypeAlias = float | bool | str | tuple["Plain", ...]
"""A value as its language writes it: a number, truth, text, or values in brackets."""
SuppliedValue: TypeAlias = Tool | Frame | Speed | Blend | Target | JointTarget | ChannelLine | Plain
"""What a cell says of a wanted name; of a routine one of ROUTINES, or the name of its file."""
ROUTINES: Final = ("stop", "empty")
"""What may stand for a routine that was not read: it stops there, or does nothing."""
SAME_ARM: Final = "same"
"""What may be said of the arm that joint angles were taught on: the one that runs the program."""
BASE_FRAME_SUFFIX: Final = "_stands"
"""Follows the name of a mechanical unit in that of the frame where it stands."""
TAUGHT_ON: Final = "taught_on"


@dataclass(frozen=True, slots=True)
class CallArgument:
    """One argument of a call of a routine that was not read.

    type: as its language names it. option: the name that the call gives it, empty for one by its
    place. dimensions: of an array.
    """

    type: str
    option: str = ""
    dimensions: int = 0


@dataclass(frozen=True, slots=True)
class Wanted:
    """One name that is declared nowhere in what was read.

    type: as its language names it, empty where the uses do not tell; of a routine that of its
    result, empty for a procedure. size: of an array, as large as the uses need. arguments: of a
    routine. signal: what is known of a signal. uses: `file:line` of each statement that uses it,
    in order, each once. assigned: the program itself gives it values. nothing: of data, the value
    that says least, None where its type has no values.
    """

    name: str
    kind: WantedKind
    type: str = ""
    size: tuple[int, ...] = ()
    arguments: tuple[CallArgument, ...] = ()
    signal: Signal | None = None
    uses: tuple[str, ...] = ()
    assigned: bool = False
    nothing: Plain | None = None


Supplied: TypeAlias = Sequence[tuple[Wanted, SuppliedValue | None]]
"""Names with what a cell says of each, None for data whose type has no values."""

JOINT_SPEED: Final = "joint_speed"
"""Name of the speed that joint moves have which state no more than a percentage."""
LINE_NAME: Final = "line_{}"
"""Name of a line by its number."""
SLOW_SPEED: Final = Speed(100.0)
TOOL_DOWN: Final = Target(Pose((400.0, 0.0, 400.0), (0.0, 0.0, 1.0, 0.0)))
"""A place that most arms reach: mm in the frame of the move, the tool down."""
FOLDED_ARM: Final = JointTarget((0.0, 0.0, 0.0, 0.0, 30.0, 0.0))
NEUTRAL_LINE: Final = ChannelLine("client", 10000, "127.0.0.1")
_NEUTRAL: Final[Mapping[WantedKind, SuppliedValue]] = {
    "tool": Tool(), "frame": Frame(), "speed": SLOW_SPEED, "blend": FINE, "position": TOOL_DOWN,
    "joints": FOLDED_ARM, "routine": "stop", "arm": SAME_ARM,
    "line": NEUTRAL_LINE,
}  # fmt: skip


STATE_TYPE: Final = "state"
"""Type of a position that is what something measures, and no place that a robot goes to."""


def neutral_value(wanted: Wanted) -> SuppliedValue | None:
    """What stands for a name until the cell says it: the flange, the base, 100 mm/s, a stop.

    None of data whose type has no values.
    """
    if wanted.kind == "position" and wanted.type == STATE_TYPE:
        return Target(Pose())
    return _NEUTRAL.get(wanted.kind, wanted.nothing)

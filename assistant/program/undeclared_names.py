"""Names that a program uses and does not declare: timers, channels, interrupts, and missing data.

Statements start and read timers, and open, write and read channels, without declaring them; a
language that counts timers, channels or interrupts gets a number for each. Any other name that
is declared nowhere is a `Wanted`: the cell has to define it before the program is complete.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, Literal, TypeAlias

from assistant.base.data_classes import dataclass
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.program import Program, Signal
from assistant.program.rewriting import rewrite
from assistant.program.statement_index import (
    records_in_body,
    statements_with,
    statements_with_vendor_text,
)


@dataclass(frozen=True, slots=True)
class ChannelLine:
    """Kind of a communication line of the source's controller.

    port: of TCP, its own or the other computer's; of a `serial` line the number of the port.
    address: its own on the network as `server`, the other computer's as `client`.
    """

    role: Literal["server", "client", "serial"]
    port: int
    address: str = ""


_CHANNEL_FUNCTIONS: Final = ("connected", *e.TAKING)
"""Functions of a channel, which they have by its name as a text."""
_NUMBERED_CHANNEL: Final = re.compile(r"channel_([1-9][0-9]?)")


def channels(program: Program) -> tuple[str, ...]:
    """Names as they are spelled first, in order of the text."""
    found: dict[str, str] = {}
    for _, parts in statements_with(program, p.Attach, p.Detach, p.Send, e.Apply):
        for name in sorted(name for part in parts if (name := channel_named(part))):
            found.setdefault(name.lower(), name)
    return tuple(found.values())


def channel_named(part: Any) -> str:
    """The channel that a record names, empty if it names none."""
    match part:
        case p.Attach(name) | p.Detach(name) | p.Send(name):
            return name
        case e.Apply(function, (e.Text(name), *_)) if function in _CHANNEL_FUNCTIONS:
            return name
    return ""


def numbered_channels(
    program: Program,
    numbers: Sequence[int],
    together: Callable[[Program], Collection[Collection[str]]],
) -> dict[str, int]:
    """Return a number for each channel by lower-case name; channels for which no number is free are
    missing.

    A channel whose name contains its number keeps it. One beyond the numbers shares that of others,
    if no two of them are `together`.
    """
    wanted = [name.lower() for name in channels(program)]
    said = ((name, _NUMBERED_CHANNEL.fullmatch(name)) for name in wanted)
    given = {name: int(match[1]) for name, match in said if match and int(match[1]) in numbers}
    free = [n for n in numbers if n not in given.values()]
    others = [name for name in wanted if name not in given]
    given.update(zip(others, free, strict=False))
    left = others[len(free) :]
    apart = together(program) if left else ()
    for name in left:
        beside = {other for pair in apart if name in pair for other in pair}
        shared = (n for n in numbers if not any(given.get(one) == n for one in beside))
        if (number := next(shared, None)) is not None:
            given[name] = number
    return given


def name_of_channel(number: int) -> str:
    """The name of a channel that has but a number."""
    return f"channel_{number}"


def with_channels_renamed(program: Program, names: Mapping[str, str]) -> Program:
    """The program with other names for its channels. names: by lower-case name."""

    def change(part: Any) -> Any:
        new = names.get(channel_named(part).lower())
        match part:
            case p.Attach() | p.Detach() | p.Send() if new is not None:
                return replace(part, channel=new)
            case e.Apply(_, (_, *rest)) if new is not None:
                return replace(part, arguments=(e.Text(new), *rest))
        return part

    return rewrite(program, change) if names else program


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
"""Kind of a name: as in a process file, `data` for any other value, `routine` for a called routine,
`record` for a type of data, whose value is a text with type and name for each component, `arm` for
the one that joint angles were taught on, `line` for a line of the controller by its number.
"""
Plain: TypeAlias = float | bool | str | tuple["Plain", ...]
"""A value as its language writes it: a number, truth, text, or values in brackets."""
SuppliedValue: TypeAlias = Tool | Frame | Speed | Blend | Target | JointTarget | ChannelLine | Plain
"""Value that a cell gives a wanted name; for a routine, one of ROUTINES, or the name of its
file.
"""
ROUTINES: Final = ("stop", "empty")
"""Replacements of a routine that was not read: it stops there, or does nothing."""
SAME_ARM: Final = "same"
"""Name of the arm that joint angles were taught on if it is the one that runs the program."""
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
    """One name without a declaration in the files that were read.

    type: as its language names it, empty if the uses do not show it; for a routine that of its
    result, empty for a procedure. size: of an array, as large as the uses need. arguments: of a
    routine. signal: known properties of a signal. uses: `file:line` of each statement that uses it,
    in order, each once. assigned: True if the program itself gives it values. nothing: of data, the
    plainest value, None if its type has no values. perhaps: another kind that the uses allow as
    well, `type` if they show no type of data, None if they show the kind; what the cell states
    counts. sets: data of the program that a routine gives values to, if that is known of it.
    numbers: of a signal, the numbers that its controller has for such. tip: of a tool that
    the program declares without a load, which is what is wanted.
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
    perhaps: Literal["signal", "data", "type"] | None = None
    sets: tuple[str, ...] = ()
    numbers: str = ""
    tip: Pose | None = None


Supplied: TypeAlias = Sequence[tuple[Wanted, SuppliedValue | None]]
"""Names with what a cell says of each, None for data whose type has no values."""

JOINT_SPEED: Final = "joint_speed"
"""Name of the speed that joint moves have which state no more than a percentage."""
LINE_NAME: Final = "line_{}"
"""Name of a line by its number."""
SLOW_SPEED: Final = Speed(100.0)
_TOOL_DOWN: Final = Target(Pose((400.0, 0.0, 400.0), (0.0, 0.0, 1.0, 0.0)))
"""A place that most arms reach: mm in the frame of the move, the tool down."""
_FOLDED_ARM: Final = JointTarget((0.0, 0.0, 0.0, 0.0, 30.0, 0.0))
NEUTRAL_LINE: Final = ChannelLine("client", 10000, "127.0.0.1")
_NEUTRAL: Final[Mapping[WantedKind, SuppliedValue]] = {
    "tool": Tool(), "frame": Frame(), "speed": SLOW_SPEED, "blend": FINE, "position": _TOOL_DOWN,
    "joints": _FOLDED_ARM, "routine": "stop", "arm": SAME_ARM,
    "line": NEUTRAL_LINE,
}  # fmt: skip


STATE_TYPE: Final = "state"
"""Type of a position that is what something measures, and no place that a robot goes to."""


def neutral_value(wanted: Wanted) -> SuppliedValue | None:
    """Return the default value of a name until the cell supplies it: the flange, the base, 100
    mm/s, a stop.

    Return None for data whose type has no values.
    """
    if wanted.kind == "position" and wanted.type == STATE_TYPE:
        return Target(Pose())
    return _NEUTRAL.get(wanted.kind, wanted.nothing)


def timers(program: Program) -> tuple[str, ...]:
    """Names as they are spelled first, in order of the text."""
    found: dict[str, str] = {}
    for _, parts in statements_with(program, *_TIMER_RECORDS):
        for name in sorted(part.timer for part in parts if isinstance(part, _TIMER_RECORDS)):
            found.setdefault(name.lower(), name)
    return tuple(found.values())


def numbered_timers(
    program: Program, numbers: Sequence[int], kept: re.Pattern[str]
) -> tuple[dict[str, int], int]:
    """Return a number for each timer by lower-case name, and one that no timer has, 0 if all are
    used.

    A timer whose name contains its number keeps it; among the others the first number is given
    last. Timers beyond the numbers have no number. kept: finds the number of a timer in vendor
    texts.
    """
    texts = [declaration.text for declaration in program.declarations]
    texts += [part.text for _, parts in statements_with_vendor_text(program) for part in parts]
    taken = {int(n) for text in texts for n in kept.findall(text)}
    wanted = [name.lower() for name in timers(program)]
    said = ((name, _NUMBERED_TIMER.fullmatch(name)) for name in wanted)
    given = {name: int(match[1]) for name, match in said if match and int(match[1]) in numbers}
    taken.update(given.values())
    free = [n for n in (*numbers[1:], numbers[0]) if n not in taken]
    left = [name for name in wanted if name not in given]
    given.update(zip(left, free, strict=False))
    taken.update(given.values())
    return given, next((n for n in numbers if n not in taken), 0)


def timer_in_seconds(
    operator: str, left: e.Expression, right: e.Expression, parts: int
) -> e.Binary | e.Elapsed:
    """An operation; a timer that counts parts of seconds becomes seconds beside a number.

    parts: of a second. What counts them is `Elapsed` multiplied by their number.
    """
    unit = e.Number(parts)
    match left, right:
        case e.Binary("*", e.Elapsed() as timer, factor), e.Number(value) if factor == unit:
            if operator == "/" and value == parts:
                return timer
            if operator in e.RELATIONS:
                right, left = e.number_of(value / parts), timer
        case e.Number(value), e.Binary("*", e.Elapsed() as timer, factor) if factor == unit:
            if operator in e.RELATIONS:
                left, right = e.number_of(value / parts), timer
    return e.Binary(operator, left, right)  # type: ignore[arg-type]


_NUMBERED_TIMER: Final = re.compile(r"timer_(0|[1-9][0-9]{0,3})")
_TIMER_RECORDS: Final = (p.StartTimer, e.Elapsed)


def interrupts(program: Program) -> tuple[p.Interrupt, ...]:
    """Wherever they are defined, in order of the text."""
    return tuple(one for q in program.procedures for one in records_in_body(q, p.Interrupt))


def numbered_interrupts(program: Program, numbers: Sequence[int]) -> dict[str, int]:
    """The number of each by its lower-case name; those beyond the numbers have none."""
    names = dict.fromkeys(node.name.lower() for node in interrupts(program))
    return dict(zip(names, numbers, strict=False))


def interrupt_names(program: Program, numbers: Mapping[str, int]) -> dict[str, str]:
    """The name that each number stands for."""
    known = {node.name.lower(): node.name for node in interrupts(program)}
    return {str(number): known[key] for key, number in numbers.items()}

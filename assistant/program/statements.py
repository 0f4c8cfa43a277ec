"""Statements of the pseudo-program: small frozen records, one for each construct.

The span of a statement is its source location; it does not count when statements are compared.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import Final, Literal

import numpy as np

from assistant.base.arrays import Rows
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span
from assistant.program.expressions import Effect, Expression, Name, Number
from assistant.program.expressions import Reason as Reason
from assistant.program.geometry import BASE, FLANGE
from assistant.program.motion import COMPUTED as COMPUTED
from assistant.program.motion import Blend, Kind, Path, Speed
from assistant.program.motion import ComputedBlend as ComputedBlend
from assistant.program.motion import ComputedSpeed as ComputedSpeed


@dataclass(frozen=True, slots=True, kw_only=True)
class Spanned:
    """Position of a statement in a source text; not part of its meaning."""

    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Call(Spanned):
    """Calls a procedure.

    unit: the program unit that holds it if that is loaded for the call (see Procedure).
    """

    procedure: str
    arguments: tuple[Expression, ...] = ()
    unit: str | None = None


State = Literal["on", "off"]


@dataclass(frozen=True, slots=True)
class Interrupt(Spanned):
    """From here on what an interrupt is: `call` is made while `condition` holds and it is on.

    It is off until it is switched on. call: of a procedure without parameters. ends: if that holds
    behind the call, the cycle of the program ends there, and the arm stays where it is.
    """

    name: str
    condition: Expression
    call: Call
    ends: Expression | None = None


@dataclass(frozen=True, slots=True)
class SwitchInterrupt(Spanned):
    """Lets one interrupt come, or not; what held meanwhile and does no more, is lost."""

    name: str
    state: State


@dataclass(frozen=True, slots=True)
class SwitchInterrupts(Spanned):
    """Lets those come that are on, or none of them; they may at the start of a program."""

    state: State


Interrupting = Interrupt | SwitchInterrupt | SwitchInterrupts


@dataclass(frozen=True, slots=True)
class Motion:
    """Parameters of a move: speed, blend at its end, tool and frame by name."""

    speed: Speed | ComputedSpeed | Name
    blend: Blend | ComputedBlend | Name
    tool: str = FLANGE
    frame: str = BASE

    @property
    def fixed(self) -> tuple[Speed | Name, Blend | Name]:
        """Speed and blend; in the place of those that are worked out a name of nothing."""
        speed, blend = self.speed, self.blend
        return (
            COMPUTED if isinstance(speed, ComputedSpeed) else speed,
            COMPUTED if isinstance(blend, ComputedBlend) else blend,
        )


Measure = Literal["start", "end", "time", "share"]
"""Position at which a move sets an output: mm after the start, mm before the end, seconds before
the end, or percent of the path.
"""


@dataclass(frozen=True, slots=True)
class Trigger:
    """Sets an output at a place on the way of a move.

    amount: of what `measure` says. ahead: seconds by which it is set earlier than there, for
    equipment that takes that long; less than 0 for later. pulse: see `SetSignal`.
    """

    signal: str
    value: Expression
    amount: Expression
    measure: Measure
    pulse: Expression | None = None
    ahead: Expression | None = None


@dataclass(frozen=True, slots=True)
class Move(Spanned):
    """To a Cartesian target: `joint` interpolated or `linear`.

    until: breaks the move off as soon as it holds, at its start too: the arm stops on its way, and
    the program goes on with the next statement. `broken_off` tells whether that happened.
    """

    kind: Literal["joint", "linear"]
    target: Expression
    motion: Motion
    triggers: tuple[Trigger, ...] = ()
    until: Expression | None = None


@dataclass(frozen=True, slots=True)
class MoveCircular(Spanned):
    """On the arc from the present position through `via` to `target`. until: see `Move`."""

    via: Expression
    target: Expression
    motion: Motion
    triggers: tuple[Trigger, ...] = ()
    until: Expression | None = None


@dataclass(frozen=True, slots=True)
class MoveJoints(Spanned):
    """To a joint target, every axis on its own way (MoveAbsJ). until: see `Move`."""

    target: Expression
    motion: Motion
    triggers: tuple[Trigger, ...] = ()
    until: Expression | None = None


@dataclass(frozen=True, slots=True)
class Travel(Spanned):
    """Move to a target or joints on a path without contact in the cell, which is planned before the
    program is lowered: `compiler/travel.py`.

    motion: blend at the end of the path; the blends on it are chosen with it. tilt: degrees by
    which the z axis of the tool may turn away from its final direction, None for any. search:
    largest number of seconds for the search of the path, None for the default.
    """

    target: Expression
    motion: Motion
    tilt: Expression | None = None
    search: Expression | None = None


@dataclass(frozen=True, slots=True)
class Follow(Spanned):
    """Along a path of the program's own."""

    path: Path

    def row_span(self, row: int) -> Span | None:
        """Span of the move to a row in the source text; the whole statement if that is all
        there is.
        """
        if self.span is None or self.path.places is None:
            return self.span
        start, end = self.path.places[row].tolist()
        return Span(self.span.start + start, self.span.start + end)

    @property
    def lines(self) -> Rows | None:
        """Return (m, 2) positions of the path's moves in the source text, an arc once; None if the
        rows have no separate lines.
        """
        if self.span is None or self.path.places is None or not len(self.path):
            return None
        ends = np.append(self.path.kinds[1:], 0) != Kind.END
        return np.asarray(self.path.places[ends] + self.span.start)


@dataclass(frozen=True, slots=True)
class Wait(Spanned):
    seconds: Expression


@dataclass(frozen=True, slots=True)
class WaitSignal(Spanned):
    """Until a signal has a value; timeout in seconds, None for ever."""

    signal: str
    value: Expression
    timeout: Expression | None = None


@dataclass(frozen=True, slots=True)
class WaitUntil(Spanned):
    """Until a condition holds; timeout in seconds, None for ever."""

    condition: Expression
    timeout: Expression | None = None


@dataclass(frozen=True, slots=True)
class StartTimer(Spanned):
    """Sets a timer to zero and lets it run; `Elapsed` reads it. Timers are not declared."""

    timer: str


@dataclass(frozen=True, slots=True)
class SetSignal(Spanned):
    """Sets an output; its declaration says whether it is digital, analog or a group.

    pulse: seconds after which a digital output goes back, None to stay.
    """

    signal: str
    value: Expression
    pulse: Expression | None = None


@dataclass(frozen=True, slots=True)
class Gripper(Spanned):
    """Opens or closes a hand, counted from 1."""

    action: Literal["open", "close"]
    hand: int = 1


@dataclass(frozen=True, slots=True)
class SetAcceleration(Spanned):
    """Acceleration and deceleration of the moves that follow, percent of the most."""

    acceleration: Expression
    deceleration: Expression


@dataclass(frozen=True, slots=True)
class SetOverride(Spanned):
    """Percent of the programmed speed at which the moves that follow run."""

    percent: Expression


@dataclass(frozen=True, slots=True)
class Assign(Spanned):
    """target: a Name, Member or Index."""

    target: Expression
    value: Expression


@dataclass(frozen=True, slots=True)
class Branch:
    condition: Expression
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class If(Spanned):
    branches: tuple[Branch, ...]
    otherwise: tuple[Statement, ...] = ()


@dataclass(frozen=True, slots=True)
class While(Spanned):
    condition: Expression
    body: tuple[Statement, ...]


ONE: Final = Number(1)


@dataclass(frozen=True, slots=True)
class For(Spanned):
    """Counts `variable` from `first` to `last`, both included.

    step: None for one towards `last`, downwards if that is less than `first`.
    """

    variable: str
    first: Expression
    last: Expression
    body: tuple[Statement, ...]
    step: Expression | None = ONE


@dataclass(frozen=True, slots=True)
class Case:
    """values: any of them selects the body."""

    values: tuple[Expression, ...]
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Switch(Spanned):
    subject: Expression
    cases: tuple[Case, ...]
    otherwise: tuple[Statement, ...] = ()


@dataclass(frozen=True, slots=True)
class Stop(Spanned):
    """Stops and waits for a person to start again.

    end: for good; a start is refused until the program is begun anew from its top.
    """

    end: bool = False


@dataclass(frozen=True, slots=True)
class Return(Spanned):
    """Goes back to the caller; out of the entry it ends the cycle, which the next may follow."""

    value: Expression | None = None


class OwnText(str):
    """Text of a comment that the compiler wrote itself: how a language spells it is no finding."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class Comment(Spanned):
    """One line of comment, without its mark and without outer blanks.

    One that stood at the end of another statement's line has the span of that statement.
    """

    text: str

    def stands_at_end_of(self, other: Statement | None) -> bool:
        """True if the comment was at the end of the line of another statement."""
        if other is None or isinstance(other, Comment):
            return False
        return self.span is not None and self.span == other.span


@dataclass(frozen=True, slots=True)
class Label(Spanned):
    name: str


@dataclass(frozen=True, slots=True)
class Goto(Spanned):
    label: str


@dataclass(frozen=True, slots=True)
class Message(Spanned):
    """Shows the parts, one after the other, on the teach pendant."""

    parts: tuple[Expression, ...]


ChannelKind = Literal["line", "serial", "server", "client", "file"]
"""Partner of a channel: a communication line of the controller by its number; a serial port by its
number; a client that connects to a port of the controller (the port, and the controller's address
if that is known); a port of another computer (its address and the port); a file by its name.
"""
ChannelMode = Literal["both", "read", "write", "append"]


@dataclass(frozen=True, slots=True)
class Attach(Spanned):
    """Opens a channel for texts; to a server or a line it may be connected later, see `connected`.

    Channels are not declared. mode: of a file; of the others it is `both`.
    """

    channel: str
    kind: ChannelKind
    place: tuple[Expression, ...]
    mode: ChannelMode = "both"


@dataclass(frozen=True, slots=True)
class Detach(Spanned):
    """Closes a channel."""

    channel: str


@dataclass(frozen=True, slots=True)
class Send(Spanned):
    """Write the parts one after the other to a channel.

    kind: `line` with the controller's line end after them, else `piece`.
    """

    channel: str
    kind: Literal["line", "piece"]
    parts: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Opaque(Spanned):
    """A statement that only one vendor language can express, as its text.

    reason: why it is not translated, None if unknown. effect: its effect, None if it was not
    analysed. told: its form for other languages. These three are not part of its meaning.
    """

    language: str
    text: str
    reason: Reason | None = field(default=None, compare=False, repr=False, kw_only=True)
    effect: Effect | None = field(default=None, compare=False, repr=False, kw_only=True)
    told: tuple[Statement, ...] = field(default=(), compare=False, repr=False, kw_only=True)


MoveStatement = Move | MoveCircular | MoveJoints
"""Moves to one target."""
Moving = MoveStatement | Follow
"""Moves the robot, on a way that the statement says."""

Statement = (
    Move
    | MoveCircular
    | MoveJoints
    | Travel
    | Follow
    | Wait
    | WaitSignal
    | WaitUntil
    | StartTimer
    | SetSignal
    | Gripper
    | SetAcceleration
    | SetOverride
    | Call
    | Assign
    | If
    | While
    | For
    | Switch
    | Stop
    | Return
    | Comment
    | Label
    | Goto
    | Message
    | Attach
    | Detach
    | Send
    | Interrupt
    | SwitchInterrupt
    | SwitchInterrupts
    | Opaque
)

Trait = Literal[
    "moves", "waits", "sets", "calls", "jumps", "marks", "ends", "holds", "says", "kept"
]
"""Main effect of a statement: moves the robot; waits, for a time or until an event; sets a signal,
variable, timer or a setting of moves; calls a procedure; jumps to a label; marks the target of a
jump; ends or stops the procedure or program; holds other statements; only informs people; or is a
vendor statement, which may do any of them.
"""

TRAITS: Final[Mapping[type, Trait]] = {
    **dict.fromkeys((Move, MoveCircular, MoveJoints, Travel, Follow), "moves"),
    **dict.fromkeys((Wait, WaitSignal, WaitUntil), "waits"),
    **dict.fromkeys((StartTimer, SetSignal, Gripper, Assign), "sets"),
    **dict.fromkeys((SetAcceleration, SetOverride, Attach, Detach, Send), "sets"),
    **dict.fromkeys((Interrupt, SwitchInterrupt, SwitchInterrupts), "sets"),
    Call: "calls",
    Goto: "jumps",
    Label: "marks",
    **dict.fromkeys((Return, Stop), "ends"),
    **dict.fromkeys((If, While, For, Switch), "holds"),
    **dict.fromkeys((Comment, Message), "says"),
    Opaque: "kept",
}


def trait(statement: Statement) -> Trait:
    """Return the main effect of a statement, which every traversal of a program must handle."""
    return TRAITS[type(statement)]


def outputs(statement: Statement) -> tuple[SetSignal | Trigger, ...]:
    """Return the parts of a statement that set outputs, without its inner bodies."""
    match statement:
        case SetSignal():
            return (statement,)
        case (
            Move(triggers=triggers)
            | MoveCircular(triggers=triggers)
            | MoveJoints(triggers=triggers)
        ):
            return triggers
    return ()

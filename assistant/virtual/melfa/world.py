"""The world of a program: arm, signals, clock, variables of all programs, and added commands.

Commands, functions and status variables can be added to a run; they come before what is simulated,
and any name may be one that the language lacks:

    run(tree, commands={
        "Rnd": lambda given: 0.5,                            # a function
        "M_Uar": lambda given: 1,                            # a status variable that is read
        "P_FsGn0=": lambda given: print(given.arguments),    # one that is set: indices, the value
        "Fsc On": lambda given: given.task.switch("force", 1.0),    # a command
    })
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import field
from typing import TYPE_CHECKING, Final

from assistant.base.data_classes import dataclass
from assistant.program.geometry import Pose
from assistant.virtual.events import Moved, Sent, Stopped, Switched
from assistant.virtual.kernel.kernel import Source
from assistant.virtual.kernel.task import Task
from assistant.virtual.melfa.arm_state import Arm, Settings
from assistant.virtual.melfa.communication_lines import SimulatedClient
from assistant.virtual.melfa.options import Options
from assistant.virtual.melfa.values import Failed, Memory, Scope, Unknown, Value
from assistant.virtual.melfa.values import number as number_of
from assistant.virtual.triggers import ordered_triggers

if TYPE_CHECKING:
    from assistant.virtual.kernel import Task
    from assistant.virtual.kernel.kernel import Timer
    from assistant.virtual.melfa.communication import Channel
    from assistant.virtual.melfa.communication_lines import Line
    from assistant.virtual.melfa.controller import Slot
    from assistant.virtual.melfa.machine import Machine


@dataclass(frozen=True, slots=True)
class Given:
    """Call of a plug-in.

    name: upper case, without `$`. arguments: their values, None for one that is left out; a bare
    word is a text. task: reports events, sets outputs, waits. arm: its present state. files: names
    of the open files as in `Open`, by their numbers.
    """

    name: str
    arguments: tuple[Value | None, ...]
    task: Task
    arm: Arm
    files: Mapping[int, str] = field(default_factory=dict)


Command = Callable[[Given], Value | None]
"""Runs a command, or gives the value of a function or status variable. It may raise `Failed`."""
Commands = Mapping[str, Command]


def commands_by_name(commands: Commands | None) -> dict[str, Command]:
    """Plug-ins by upper-case name without `$`; a command of two words has one blank in it."""
    found = {" ".join(name.upper().split()): command for name, command in (commands or {}).items()}
    return {name.removesuffix("$"): command for name, command in found.items()}


STEP_TIME: Final = 0.001
"""Seconds that a statement takes on the clock of M_Timer."""

_MOST_PULSES: Final = 4
"""At once (COSIROP: DLY)."""
_REGISTER: Final = 1 << 15

Inputs = Callable[[int], int]
"""The state of an input, 0 or 1, by its number."""


@dataclass(slots=True)
class World:
    """task: what the program runs in. timers: the clock, in ms, when each was at 0.

    options: what the manuals leave open. commands: plug-ins by name. running: the programs that
    run, each called by the one before it.
    """

    task: Task
    arm: Arm
    settings: Settings = field(default_factory=Settings)
    options: Options = field(default_factory=Options)
    commands: Mapping[str, Command] = field(default_factory=dict)
    timers: dict[int, float] = field(default_factory=dict)
    running: list[Machine] = field(default_factory=list)
    shared: Memory = field(default_factory=lambda: Memory(Scope()))
    on_way: list[Switched] | None = None
    """Outputs to set on the path of the next motion, None if nothing is appended to it."""
    appended: bool = False
    """True if the appended outputs have been added to a motion."""
    held: list[Switched] | None = None
    """List that collects outputs which are evaluated only, to be set on the path of a motion."""
    left: bool = False
    """True if `Break` left the last block (M_BrkCq)."""
    skipped: bool = False
    """True if the last motion that may be skipped was (M_SkipCq)."""
    files: dict[int, Channel] = field(default_factory=dict)
    """Open files by their numbers."""
    paused: bool = False
    """True while an interrupt holds the arm on its path."""
    monitor: Callable[[], None] | None = None
    """Looks whether a condition of the motion at hand is met."""
    slot: Slot | None = None
    """The slot of a controller; None where a program runs alone, as in slot 1."""

    stored: dict[str, bytearray] = field(default_factory=dict)
    """Files of a program that runs alone."""
    error: int = 0
    """The number of the caution that holds (M_ErrNo), 0 for none."""
    pulses: list[Timer] = field(default_factory=list)
    """Pulses whose end is to come."""

    def of_slot(self, number: int | None = None) -> World:
        """The world of a slot's program, its own without a number."""
        if number is None or (self.slot is None and number == 1):
            return self
        world = None if self.slot is None else self.slot.controller.slot(number).world
        if world is None:
            raise Unknown(f"what holds for slot {number}, where no program ran")
        return world

    def halt(self) -> None:
        """`Hlt`: waits for a start, which comes at once where a program runs alone."""
        self.task.tell(Stopped())
        if self.slot is not None:
            self.slot.hold()

    def needs_mechanism(self, what: str) -> None:
        """Only the slot that has the arm moves it, or switches its motors (COSIROP: GETM)."""
        if self.slot is not None and self.slot.controller.owner is not self.slot:
            raise Failed(3280, f"{what} without GetM")

    def line(self, name: str) -> Line:  # noqa: ARG002
        """A line of a program that runs alone, at whose other end somebody says what is known."""
        said = self.task.kernel.peers
        if said is None:
            raise Unknown("lines of a program that runs without a controller")
        peer = SimulatedClient(said)
        peer.heard = lambda data: self.task.tell(Sent(data))
        return peer

    def uses(self, line: Line) -> bool:
        return any(file.line is line for file in self.files.values())

    def close_files(self, numbers: Iterable[int] | None = None) -> None:
        """Closes files, all without their numbers (COSIROP: CLOSE, END)."""
        for number in tuple(self.files if numbers is None else numbers):
            channel = self.files.pop(number, None)
            if channel is not None:
                channel.line.close()
                self.task.kernel.attached -= channel.line.outside

    @property
    def clock(self) -> float:
        """Milliseconds."""
        return 1000.0 * self.task.kernel.now

    def given(self, name: str, arguments: tuple[Value | None, ...]) -> Value | None:
        """Return the value of the plug-in of a name, which must exist."""
        files = {number: channel.name for number, channel in self.files.items()}
        return self.commands[name](Given(name, arguments, self.task, self.arm, files))

    def note(self, what: str) -> None:
        """Says once for the run what is taken without any effect."""
        self.task.kernel.note(what)

    def read(self, output: bool, first: int, width: int) -> int:
        """Inputs or outputs of a width as one number, the first as the lowest bit."""
        if first < 0:
            raise Failed(6600, f"there is no signal {first}")
        numbers = range(first, first + width)
        board = self.task.kernel.board
        read = (board.outputs if output else board.inputs).read
        return sum(bool(read(str(n))) << i for i, n in enumerate(numbers))

    def switch(
        self, first: int, width: int, value: int, mask: int = -1, after: float | None = None
    ) -> None:
        """Sets outputs; each bit is an event. mask: bits that are set. after: see `Switched`."""
        if first < 0:
            raise Failed(6600, f"there is no signal {first}")
        if not 0 <= value < 1 << width:
            raise Unknown(f"{value} in a signal of {width} bits")
        for at in range(width):
            if mask >> at & 1:
                name, bit = str(first + at), float(value >> at & 1)
                if self.held is None:
                    self.task.switch(name, bit, after=after)
                else:
                    self.held.append(Switched(name, bit, after=after))

    def set_register(self, number: int, value: Value) -> None:
        """A register of a field bus, which holds a whole number of 16 bits."""
        if not float(number_of(value)).is_integer():
            raise Unknown(f"what a register makes of {value}, which is no whole number")
        if not -_REGISTER <= number_of(value) < _REGISTER:
            raise Unknown(f"{value} in a register of 16 bits")
        changed = Switched(register(number), float(number_of(value)))
        if self.held is None:
            self.task.switch(changed.signal, changed.value)
        else:
            self.held.append(changed)

    def register(self, output: bool, number: int) -> int:
        board = self.task.kernel.board
        return int((board.outputs if output else board.inputs).read(register(number)))

    def go(self, moved: Moved, before: Pose | None) -> None:
        """Commands a motion. before: the flange where it begins, None if that is not known."""
        if self.on_way is not None and self.appended:
            raise Unknown("which of two motions something is appended to")
        self.appended = True
        self.task.kernel.motion.go(
            self.task, moved, ordered_triggers(moved, before, self.on_way or ())
        )

    def warn(self, number: int) -> None:
        """A caution holds from now on, or with 0 none does any more."""
        self.error = number
        if self.slot is not None:
            self.slot.controller.error = Failed(number, "raised by the program") if number else None

    def stand(self) -> None:
        """Before a statement that may have the last move end at its target."""
        if self.options.waits_end_corners:
            self.task.kernel.motion.settle(self.task)

    def pulse(self, number: int, value: int, back: int, seconds: float) -> None:
        """Sets an output for a time; it stays if the program ends before (COSIROP: DLY)."""
        if self.options.pulses == "at once":
            self.switch(number, 1, value)
            self.switch(number, 1, back, after=seconds)
            return
        now = self.task.kernel.now
        self.pulses = [pulse for pulse in self.pulses if pulse.time > now]
        if len(self.pulses) >= _MOST_PULSES:
            raise Failed(None, f"more than {_MOST_PULSES} pulses at once")
        if self.held is None:
            self.switch(number, 1, value)
            self._end_pulse(number, back, seconds)
            return
        outputs = self.task.kernel.board.outputs

        # The pulse begins as the motion sets the output, which its listener waits for.
        def begun(name: str, _: float, level: float) -> None:
            """The motion sets the output on its way."""
            if name == str(number) and level == value:
                outputs.listeners.remove(begun)
                self._end_pulse(number, back, seconds)

        outputs.listeners.append(begun)
        self.switch(number, 1, value)

    def _end_pulse(self, number: int, back: int, seconds: float) -> None:
        kernel = self.task.kernel
        end = kernel.now + seconds
        self.pulses.append(kernel.at(end, lambda: self.task.switch(str(number), float(back))))

    def end(self) -> None:
        """Carry out `End` of the main program."""
        self.settings.reset()
        self.close_files()
        for timer in self.pulses:
            timer.cancelled = True

    def timer(self, number: int) -> float:
        return self.clock - self.timers.get(number, -self.options.timers)

    def set_timer(self, number: int, value: float) -> None:
        self.timers[number] = self.clock - value
        # Waits for a timer look again.
        if self.task.kernel.timed is not None:
            self.task.kernel.timed()


def inputs_of(given: Mapping[int, int] | Inputs | None) -> Source:
    """Inputs by their numbers as texts; those that are not given are 0."""
    if given is None:
        return {}
    if callable(given):
        return lambda name: given(int(name))
    return {str(number): float(bool(value)) for number, value in given.items()}


def register(number: int) -> str:
    """Return the board's name of a field bus register."""
    return f"register{number}"

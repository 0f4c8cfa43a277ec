"""What runs in a virtual CR controller: its slots, its arm, its signals, in a kernel of their own.

Everything that touches them is done in the thread of the kernel, between two statements; methods
here may be called from any thread.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, Protocol, TypeVar

import numpy as np

from assistant.virtual.cr import cells
from assistant.virtual.cr.arm import CrArm
from assistant.virtual.cr.direct import UNKNOWN, DirectCommands, error_number
from assistant.virtual.cr.jogging import Jogging
from assistant.virtual.cr.library import Library
from assistant.virtual.cr.stepping import Stepping
from assistant.virtual.cr.store import CrProgram, CrRefusal
from assistant.virtual.kernel import Board, Ending, Kernel, Live, Task
from assistant.virtual.kernel.lock_step import Stepped
from assistant.virtual.melfa.controller import Controller
from assistant.virtual.melfa.options import Options
from assistant.virtual.melfa.stops import Failed, Unknown
from assistant.virtual.melfa.world import STEP_TIME

if TYPE_CHECKING:
    from assistant.base.arrays import Floats
    from assistant.robots import Robot
    from assistant.virtual.melfa.lines import Line
    from assistant.virtual.melfa.plugins import Commands

T = TypeVar("T")

MOST_STEPS: Final = 10**15
"""A controller runs its programs for ever."""
HAND: Final = re.compile(r"hand(\d+)")
REFUSALS: Final[Mapping[int | None, int]] = {3360: 5120, 3310: 5640, 3320: 5100, 3350: 5640}
"""Errors of statements about slots → those of the commands that do the same."""


class EventListener(Protocol):
    """Who is told what happens, in the thread of the kernel."""

    def failed(self, number: int, program: str, line: int, text: str) -> None:
        """A program or a command of a slot ended with an error."""

    def cycle_over(self, program: str, milliseconds: int) -> None: ...

    def hand_moved(self, hand: int, opens: bool) -> None: ...


CONTACT_PERIOD: Final = 0.02
"""Real seconds between two tests for contact."""


@dataclass(frozen=True, slots=True)
class Contact:
    """The source of contacts. signal: the input that is on in contact. touching: returns True if
    the arm touches something at joints (a,), degrees or mm.
    """

    signal: str
    touching: Callable[[Floats], bool]


@dataclass(slots=True)
class Equipment:
    """What programs meet beside the controller itself. rate: simulated seconds for each real one.
    lock_step: time passes only as far as it is let. lines, commands, options: see
    `melfa.Controller`. contact: sets an input while the arm touches something.
    """

    rate: float = 1.0
    lines: Mapping[str, Line] = field(default_factory=dict)
    commands: Commands | None = None
    options: Options = field(default_factory=Options)
    lock_step: bool = False
    contact: Contact | None = None


class Powered:
    """joints: (a,) degrees, where the arm stands. slots: how many, that for editing counted.

    source: a stored program by its name, None if there is none.
    """

    def __init__(
        self,
        robot: Robot,
        language: str,
        joints: Sequence[float],
        slots: int,
        source: Callable[[str], CrProgram | None],
        board: Board,
        equipment: Equipment,
        told: EventListener,
    ) -> None:
        self.robot, self.language, self.told = robot, language, told
        self.arm = CrArm(robot, joints)
        self.library = Library(language, source)
        self._slots = slots
        self._board, self._equipment = board, equipment
        self._began: dict[str, float] = {}
        self._first: dict[int, int] = {}
        self._servo_asked = False
        self._ends_cycle: set[int] = set()
        name = "virtual-cr-kernel"
        self._live = (
            Stepped(self._make, ended=self._ended, name=name)
            if equipment.lock_step
            else Live(self._make, rate=equipment.rate, ended=self._ended, name=name)
        )

    def start(self) -> None:
        self._live.start()

    def stop(self) -> None:
        self._live.stop()

    @property
    def stepped(self) -> Stepped:
        """Lets time pass; only with `lock_step`."""
        assert isinstance(self._live, Stepped), "time passes as real time does"
        return self._live

    @property
    def executing(self) -> bool:
        """Whether a single statement is under way, or waits for its turn."""
        return self.do(lambda: self.direct.running)

    def do(self, action: Callable[[], T]) -> T:
        """Has something done between two statements; raises OSError if the controller is off."""
        try:
            return self._live.do(lambda _: action())
        except RuntimeError:
            raise ConnectionAbortedError from None
        except Failed as failed:
            number = REFUSALS.get(failed.number, failed.number)
            raise CrRefusal(number or UNKNOWN) from None
        except Unknown:
            raise CrRefusal(UNKNOWN) from None

    def _make(self) -> Kernel:
        kernel = Kernel(
            self._board, motion=self.arm, most_steps=MOST_STEPS, statement_time=STEP_TIME
        )
        self.arm.kernel = kernel
        self.controller = Controller(
            kernel,
            {},
            robot=self.robot,
            slots=self._slots,
            lines=self._equipment.lines,
            options=self._equipment.options,
            commands=self._equipment.commands,
            library=self.library.file,
            made=self.library.ready,
        )
        self.controller.arm.servo = False
        rate = self._equipment.rate
        self.jogging = Jogging(kernel, self.robot, self.arm, self.controller.arm, rate)
        self.direct = DirectCommands(self.controller)
        self.stepping = Stepping(self.controller)
        kernel.watch = self.stepping.watch
        self._board.outputs.listeners.append(self._switched)
        if self._equipment.contact is not None:
            self._look_for_contact(kernel)
        return kernel

    def _look_for_contact(self, kernel: Kernel) -> None:
        self._feel()
        later = kernel.now + CONTACT_PERIOD * self._equipment.rate
        kernel.at(later, lambda: self._look_for_contact(kernel))

    def feel(self) -> None:
        """Set the input of contacts to its present value."""
        if self._equipment.contact is not None:
            self.do(self._feel)

    def _feel(self) -> None:
        contact = self._equipment.contact
        if contact is not None:
            there = self.arm.where()[1]
            joints = np.array([there[place] for place in self.robot.places])
            self._board.inputs.set(contact.signal, float(contact.touching(joints)))

    # -------------------------------------------------------------------------- programs

    def forget(self, name: str) -> None:
        """A program was changed, or is gone."""

        def act() -> None:
            self.library.forget(name)
            self.controller.forget(name)

        self.do(act)

    def program_now(self, name: str, program: CrProgram) -> CrProgram:
        """A stored program with the values that its variables have by now."""

        def act() -> CrProgram:
            memory = self.controller.variables(name)
            return program if memory is None else cells.with_values(program, memory)

        return self.do(act)

    def shared_now(self) -> CrProgram:
        return self.do(lambda: cells.with_values(CrProgram(), self.controller.shared))

    def set_variable(self, program: str | None, name: str, value: str) -> None:
        """Of a program that is ready to run, or None of all programs; raises CrRefusal."""

        def act() -> None:
            memory = (
                self.controller.shared if program is None else self.controller.variables(program)
            )
            if memory is not None:
                cells.set_variable(memory, name, value)

        self.do(act)

    # --------------------------------------------------------------------- what happens

    def _ended(self, task: Task, ending: Ending) -> None:
        """A task is over; an error of one stops the others."""
        slot = self.controller.slot(int(task.name)) if task.name.isdigit() else None
        if slot is not None:
            self.stepping.all_statements(slot)
            if slot.number in self._ends_cycle:
                self._ends_cycle.discard(slot.number)
                slot.mode = "REP"
            if ending.ended == "end" and task.name in self._began:
                passed = self.controller.kernel.now - self._began[task.name]
                self.told.cycle_over(slot.program, round(1000.0 * passed))
        if ending.ended not in ("error", "unknown"):
            return
        for other in self.controller.slots:
            if other.condition == "START":
                other.stop()
        number = error_number(ending)
        program = "" if slot is None else slot.program
        self.told.failed(number, program, self.library.line(ending.place), ending.message)

    def _switched(self, name: str, before: float, value: float) -> None:
        """An output has another value: of a hand, its two valves follow."""
        del before
        if found := HAND.fullmatch(name):
            self.told.hand_moved(int(found[1]), value > 0.0)

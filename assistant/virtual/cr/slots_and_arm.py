"""Slots, arm and signals of a virtual CR controller, in a kernel thread.

Everything that touches them runs in the thread of the kernel, between two statements; the methods
here may be called from any thread: commands of the link run, stop and step programs, set
breakpoints, read positions and variables, and jog.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import field
from typing import TYPE_CHECKING, Final, Literal, NamedTuple, Protocol, TypeVar

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.program.geometry import Pose
from assistant.virtual.cr import program_library
from assistant.virtual.cr.jogging import Jogging
from assistant.virtual.cr.program_library import (
    UNKNOWN,
    DirectCommands,
    Library,
    Waiting,
    error_number,
    is_motion,
    parse_statement,
)
from assistant.virtual.cr.store import CrProgram, CrRefusal
from assistant.virtual.kernel import Board, Ending, Kernel, Live, Task
from assistant.virtual.kernel.kernel_thread import Stepped
from assistant.virtual.kernel.timed_arm import CrArm
from assistant.virtual.melfa import arm_state
from assistant.virtual.melfa.controller import Controller, Slot
from assistant.virtual.melfa.options import Options
from assistant.virtual.melfa.values import Failed, Position, Unknown, eight
from assistant.virtual.melfa.world import STEP_TIME

if TYPE_CHECKING:
    from assistant.base.arrays import Floats
    from assistant.robots import Robot
    from assistant.virtual.melfa.communication_lines import Line
    from assistant.virtual.melfa.world import Commands


class _Stepping:
    """Single steps and breakpoints. breakpoints: program and line number → whether it is removed
    once reached. All of this runs in the thread of the kernel.
    """

    def __init__(self, controller: Controller) -> None:
        self.breakpoints: dict[tuple[str, int], bool] = {}
        self._controller = controller
        self._left: dict[str, int] = {}

    def one_statement(self, slot: Slot) -> None:
        """A slot that is about to run holds behind its next statement.

        One that was stopped stands before a statement that is counted already.
        """
        self._left[str(slot.number)] = 1 if slot.state == "reset" else 0

    def all_statements(self, slot: Slot) -> None:
        self._left.pop(str(slot.number), None)

    def no_break(self, program: str, line: int) -> None:
        """line: 0 for all of the program."""
        for key in list(self.breakpoints):
            if key[0] == program and line in (0, key[1]):
                del self.breakpoints[key]

    def watch(self, task: Task) -> None:
        """Before each statement: whether its slot is to hold there."""
        # Tasks with other names are commands of the link, which do not stop.
        if not (self._left or self.breakpoints) or not task.name.isdigit():
            return
        slot = self._controller.slot(int(task.name))
        left = self._left.get(task.name)
        if left:
            self._left[task.name] = left - 1
        # None left: this is the statement behind the one that was asked for.
        elif left is not None:
            del self._left[task.name]
            slot.hold()
        elif slot.world is not None and slot.world.running:
            machine = slot.world.running[-1]
            key = machine.code.path, machine.code.rows[machine.here].number or 0
            if key in self.breakpoints:
                if self.breakpoints[key]:
                    del self.breakpoints[key]
                slot.hold()


T = TypeVar("T")

MOST_STEPS: Final = 10**15
"""A controller runs its programs for ever."""
HAND: Final = re.compile(r"hand(\d+)")
_REFUSALS: Final[Mapping[int | None, int]] = {3360: 5120, 3310: 5640, 3320: 5100, 3350: 5640}
"""Errors of statements about slots → those of the commands that do the same."""


class EventListener(Protocol):
    """Listener to events of the controller, called in the thread of the kernel."""

    def failed(self, number: int, program: str, line: int, text: str) -> None:
        """A program or a command of a slot ended with an error."""

    def cycle_over(self, program: str, milliseconds: int) -> None: ...

    def hand_moved(self, hand: int, opens: bool) -> None: ...


_CONTACT_PERIOD: Final = 0.02
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
    """Surroundings of the programs beside the controller itself. rate: simulated seconds for each
    real one. lock_step: time passes only as far as it is allowed. lines, commands, options: see
    `melfa.Controller`. contact: sets an input while the arm touches something.
    """

    rate: float = 1.0
    lines: Mapping[str, Line] = field(default_factory=dict)
    commands: Commands | None = None
    options: Options = field(default_factory=Options)
    lock_step: bool = False
    contact: Contact | None = None


class Machinery:
    """A controller that is switched on: its slots and its arm.

    joints: (a,) degrees, those of the arm. slots: their
    number, including the one for editing.

    source: returns a stored program by its name, None if it is missing.
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
        """True if a single statement is running or waits for its turn."""
        return self.do(lambda: self.direct.running)

    def do(self, action: Callable[[], T]) -> T:
        """Has something done between two statements; raises OSError if the controller is off."""
        try:
            return self._live.do(lambda _: action())
        # The thread of the kernel has ended.
        except RuntimeError:
            raise ConnectionAbortedError from None
        except Failed as failed:
            number = _REFUSALS.get(failed.number, failed.number)
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
        self.stepping = _Stepping(self.controller)
        kernel.watch = self.stepping.watch
        self._board.outputs.listeners.append(self._switched)
        if self._equipment.contact is not None:
            self._look_for_contact(kernel)
        return kernel

    def _look_for_contact(self, kernel: Kernel) -> None:
        self._feel()
        # The period is real time, the kernel's clock is simulated.
        later = kernel.now + _CONTACT_PERIOD * self._equipment.rate
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
            return program if memory is None else program_library.with_values(program, memory)

        return self.do(act)

    def shared_now(self) -> CrProgram:
        return self.do(lambda: program_library.with_values(CrProgram(), self.controller.shared))

    def set_variable(self, program: str | None, name: str, value: str) -> None:
        """Set a variable of a program that is ready to run, or of all programs if None; raises
        CrRefusal.
        """

        def act() -> None:
            memory = (
                self.controller.shared if program is None else self.controller.variables(program)
            )
            if memory is not None:
                program_library.set_variable(memory, name, value)

        self.do(act)

    # --------------------------------------------------------------------- what happens

    def _ended(self, task: Task, ending: Ending) -> None:
        """A task is over; an error of one stops the others."""
        # Commands of the link are tasks without a slot.
        slot = self.controller.slot(int(task.name)) if task.name.isdigit() else None
        if slot is not None:
            self.stepping.all_statements(slot)
            if slot.number in self._ends_cycle:
                self._ends_cycle.discard(slot.number)
                slot.mode = "REP"
            # Only a cycle that came to its end has a cycle time.
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

    # ----------------------------------------------------------------------------- slots

    def slot_now(self, number: int) -> SlotNow:
        return self.do(lambda: self._slot_now(number))

    def _slot_now(self, number: int) -> SlotNow:
        slot = self.controller.slot(max(number, 1))
        steps = self.library.steps(slot.program)
        line = self._line(slot, steps)
        return SlotNow(
            program=slot.program,
            line=line,
            step=steps.index(line) + 1 if line in steps else 1,
            mode=slot.mode,
            runs=slot.state == "runs",
            waits=slot.state == "waits",
            ends_cycle=slot.number in self._ends_cycle,
            # Without an owner the arm is that of slot 1.
            moves=self.controller.owner is slot or (number <= 1 and self.controller.owner is None),
            is_task=1 <= number < self._slots,
        )

    def _line(self, slot: Slot, steps: Sequence[int]) -> int:
        """The number of the line that runs, or that comes first."""
        if slot.state == "reset" or slot.world is None or not slot.world.running:
            return self._first.get(slot.number, steps[0] if steps else 0)
        machine = slot.world.running[-1]
        rows = machine.code.rows
        number = rows[machine.here].number if machine.here < len(rows) else None
        return number or 0

    def selected(self) -> dict[int, str]:
        """Slot → program."""
        return self.do(lambda: {s.number: s.program for s in self.controller.slots if s.program})

    def set_up(self, number: int, program: str, mode: str, condition: str, lines: int) -> None:
        """A slot as its row of the slot table says; one that always runs begins."""

        def act() -> None:
            slot = self.controller.slot(number)
            slot.load(program)
            slot.mode = "CYC" if mode == "CYC" else "REP"
            slot.rank(lines)
            if condition in ("ALWAYS", "ERROR"):
                slot.condition = "ALWAYS" if condition == "ALWAYS" else "ERROR"
            if slot.condition == "ALWAYS":
                slot.run()

        self.do(act)

    def clear_slots(self) -> None:
        """No slot has a program any more."""

        def act() -> None:
            self.halt_direct()
            for slot in self.controller.slots:
                slot.end()
                slot.program, slot.condition, slot.mode, slot.lines = "", "START", "REP", 1
            self._first.clear()
            self._ends_cycle.clear()
            self.stepping.breakpoints.clear()

        self.do(act)

    def select(self, number: int, program: str) -> None:
        self.library.prepare(program)

        def act() -> None:
            self.controller.slot(number).load(program)
            self._first.pop(number, None)

        self.do(act)

    def go_to_line(self, number: int, line: int) -> None:
        """The program of a slot begins with a line; one that was stopped is reset."""

        def act() -> None:
            slot = self.controller.slot(number)
            if slot.state == "runs":
                raise CrRefusal(5640)
            slot.reset()
            self._first[number] = line

        self.do(act)

    def run(self, number: int, mode: Literal["REP", "CYC"] | None) -> None:
        """Starts the program of a slot, or has it go on; mode: None as it is."""
        self.library.prepare(self.controller.slot(number).program)

        def act() -> None:
            slot = self.controller.slot(number)
            self._may_run(slot)
            self.stepping.all_statements(slot)
            self._run(slot, mode)

        self.do(act)

    def _may_run(self, slot: Slot) -> None:
        if slot.state == "runs" or self.direct.running or self.jogging.running:
            raise CrRefusal(5640)
        if not slot.program:
            raise CrRefusal(5100)
        if self.library.source(slot.program) is None:
            raise CrRefusal(4140)

    def _run(self, slot: Slot, mode: Literal["REP", "CYC"] | None) -> None:
        if slot.state == "reset":
            slot.mode = mode or slot.mode
            self._ends_cycle.discard(slot.number)
            # For this start only: the next cycle begins at the top.
            slot.first_line = self._first.pop(slot.number, None)
            self._began[str(slot.number)] = self.controller.kernel.now
            self.controller.error = None
        slot.run()

    def step(self, number: int) -> None:
        """Runs one statement of the program of a slot."""
        self.library.prepare(self.controller.slot(number).program)

        def act() -> None:
            slot = self.controller.slot(number)
            self._may_run(slot)
            self.stepping.one_statement(slot)
            self._run(slot, None)

        self.do(act)

    def stop_all(self) -> None:
        """All programs that begin with the start signal stop, and what moves without one."""

        def act() -> None:
            for slot in self.controller.slots:
                if slot.condition == "START":
                    slot.stop()
            self.halt_direct()

        self.do(act)

    def halt_direct(self) -> None:
        """Jogging and single commands end where they are."""
        self.jogging.stop()
        if self.direct.running:
            self.direct.stop()
            if not self.arm.stands():
                self.arm.halt()
            # The next motion begins where the arm stands, and not at the goal that it was sent to.
            self.controller.arm.at_joints(self.arm.where()[1])

    def stop_cycles(self) -> None:
        """Programs that repeat end with the cycle that they are in."""

        def act() -> None:
            for slot in self.controller.slots:
                if slot.state != "reset" and slot.mode == "REP":
                    slot.mode = "CYC"
                    self._ends_cycle.add(slot.number)

        self.do(act)

    def reset(self, number: int) -> None:
        """A program that was stopped will begin at its top."""

        def act() -> None:
            self._first.pop(number, None)
            self.controller.slot(number).reset()

        self.do(act)

    # --------------------------------------------------------------------------- the arm

    @property
    def servo(self) -> bool:
        return self.controller.arm.servo

    def switch_servo(self, on: bool, seconds: float = 0.0) -> None:
        """seconds: real ones, until they are on."""

        def act() -> None:
            kernel = self.controller.kernel
            # Off may be asked before the servos have come on.
            self._servo_asked = on
            if on:
                later = kernel.now + seconds * self._equipment.rate
                kernel.at(later, self._servo_on)
                return
            for slot in self.controller.slots:
                if slot.condition == "START":  # others run before the servos are on, too
                    slot.stop()
            self.halt_direct()
            self.controller.arm.servo = False

        self.do(act)

    def _servo_on(self) -> None:
        if self._servo_asked:
            self.controller.arm.servo = True

    def execute(self, number: int, text: str, edit: CrProgram | None = None) -> Future[int | None]:
        """Has a single command run; raises CrRefusal. Gives the number of its error, or None.

        edit: the program whose variables it has, None for the one of the slot.
        """
        # In the caller's thread: parsing takes time, in which programs would stand still.
        code = parse_statement(self.language, text)

        def act() -> Future[int | None]:
            slot = self.controller.slot(max(number, 1))
            if slot.state != "reset":
                raise CrRefusal(5640 if slot.state == "runs" else 5650)
            if is_motion(code):
                self._may_move()
            return self.direct.add(slot.number, Waiting(code, edit))

        return self.do(act)

    def _may_move(self) -> None:
        """Without a program."""
        if not self.controller.arm.servo:
            raise CrRefusal(2000)
        if any(slot.state == "runs" for slot in self.controller.slots if slot.condition == "START"):
            raise CrRefusal(5640)

    def move(self, how: Callable[[Jogging], None]) -> None:
        """Jogs, aligns, and so on; raises CrRefusal."""

        def act() -> None:
            self._may_move()
            if self.direct.running:
                raise CrRefusal(5640)
            self.controller.end_motion(self.controller.paused)
            how(self.jogging)

        self.do(act)

    def joints(self) -> tuple[float, ...]:
        """(a,) degrees, where the arm is now."""
        return self.do(lambda: tuple(self._own(self.arm.where()[1])))

    def _goal(self) -> tuple[float, ...]:
        """(a,) degrees, where the arm is sent; empty if that is not known."""
        try:
            found = self.controller.arm.shown_joints().values
        except (Failed, Unknown):
            return ()
        return tuple(self._own([v or 0.0 for v in found]))

    def _own(self, joints: Sequence[float]) -> list[float]:
        return [float(joints[place]) for place in self.robot.places]

    def put(self, joints: Sequence[float]) -> None:
        """The arm stands at joints (a,) from now on, however it came there."""

        def act() -> None:
            # Positions have at least six joints, an arm with fewer leaves some at 0.
            numbered = [0.0] * max(6, *(place + 1 for place in self.robot.places))
            for place, value in zip(self.robot.places, joints, strict=True):
                numbered[place] = value
            self.arm.lead(self.controller.kernel, numbered)
            self.controller.arm.at_joints(tuple(numbered))

        self.do(act)

    def set_tool(self, values: Sequence[float]) -> None:
        """X, Y, Z in mm and A, B, C in degrees on the flange."""

        def act() -> None:
            tool = Position(eight(tuple(values)), (0, 0))
            arm = self.controller.arm
            arm.tool, arm.tip, arm.tool_number = tool, arm_state.pose_of(tool), None

        self.do(act)

    def break_at(self, program: str, line: int, *, once: bool) -> None:
        self.do(lambda: self.stepping.breakpoints.__setitem__((program, line), once))

    def no_break(self, program: str, line: int) -> None:
        """line: 0 for all of the program."""
        self.do(lambda: self.stepping.no_break(program, line))

    def breakpoints(self) -> list[tuple[str, int, bool]]:
        """Return program, line, and whether the breakpoint is removed once reached."""
        found = self.do(lambda: sorted(self.stepping.breakpoints.items()))
        return [(program, line, once) for (program, line), once in found]

    def standing(self, *, goal: bool = False) -> Standing:
        """goal: with the joints that the arm is sent to."""

        def act() -> Standing:
            arm, moving = self.controller.arm, not self.arm.stands()
            now = tuple(self._own(self.arm.where()[1]))
            speed = self.arm.progress().speed if moving else 0.0
            return Standing(now, self._goal() or now if goal else now, speed, arm.tip, arm.foot)

        return self.do(act)


@dataclass(frozen=True, slots=True)
class SlotNow:
    """Present state of a slot. line: number of the next line. step: its position, from 1.

    runs, waits: both False if its program is reset. ends_cycle: True if it stops at the end of the
    cycle. moves: True if it has the arm. is_task: False for the slot for editing.
    """

    program: str = ""
    line: int = 0
    step: int = 1
    mode: str = "REP"
    runs: bool = False
    waits: bool = False
    ends_cycle: bool = False
    moves: bool = False
    is_task: bool = True


class Standing(NamedTuple):
    """Present state of the arm. now, joints: (a,) degrees, actual and commanded joints. speed: that
    of the tool in mm/s. tool: pose on the flange. foot: frame of the positions.
    """

    now: tuple[float, ...]
    joints: tuple[float, ...]
    speed: float
    tool: Pose
    foot: Pose

"""What runs in a virtual CR controller: its slots and its arm, as commands act upon them.

Everything is done in the thread of the kernel, between two statements; methods here may be called
from any thread.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Literal, NamedTuple

from assistant.program.geometry import Pose
from assistant.virtual.cr.direct import Waiting, is_motion, parse_statement
from assistant.virtual.cr.jogging import Jogging
from assistant.virtual.cr.powered import Powered
from assistant.virtual.cr.slot_now import SlotNow
from assistant.virtual.cr.store import CrProgram, CrRefusal
from assistant.virtual.melfa import poses
from assistant.virtual.melfa.slots import Slot
from assistant.virtual.melfa.stops import Failed, Unknown
from assistant.virtual.melfa.values import Position, eight


class Standing(NamedTuple):
    """now, joints: (a,) degrees, where the arm is, and those that are asked for. speed: of the tool
    in mm/s. tool: on the flange. foot: what positions are counted in.
    """

    now: tuple[float, ...]
    joints: tuple[float, ...]
    speed: float
    tool: Pose
    foot: Pose


class Machinery(Powered):
    """Commands that run, stop and move."""

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
            arm.tool, arm.tip, arm.tool_number = tool, poses.pose_of(tool), None

        self.do(act)

    def break_at(self, program: str, line: int, *, once: bool) -> None:
        self.do(lambda: self.stepping.breakpoints.__setitem__((program, line), once))

    def no_break(self, program: str, line: int) -> None:
        """line: 0 for all of the program."""
        self.do(lambda: self.stepping.no_break(program, line))

    def breakpoints(self) -> list[tuple[str, int, bool]]:
        """Program, line, and whether it goes once it was come to."""
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

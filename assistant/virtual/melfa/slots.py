"""A slot of a controller: its program, and whether that runs, waits or is reset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from assistant.virtual.kernel import Ending, Task
from assistant.virtual.melfa import pausing
from assistant.virtual.melfa.looking import call_levels, statement_place
from assistant.virtual.melfa.stops import Failed, Unknown
from assistant.virtual.melfa.world import World

if TYPE_CHECKING:
    from assistant.virtual.melfa.controller import Controller, Entry

State = Literal["reset", "runs", "waits"]


class Slot:
    """program: upper-case name, empty for none. mode, condition, lines: see Entry.

    world: of the program that runs, or of the one that ran last. first_line: the number of the line
    that the program begins with when it is run next, None for its top.
    """

    def __init__(self, controller: Controller, number: int, entry: Entry) -> None:
        self.controller: Controller = controller
        self.number = number
        self.program, self.mode = entry.program.upper(), entry.mode
        self.condition, self.lines = entry.condition, entry.lines
        self.world: World | None = None
        self.first_line: int | None = None
        self._task: Task | None = None
        self._stops = self._held = False

    @property
    def state(self) -> State:
        """`reset` also where no program is loaded; `waits` where one was stopped on its way."""
        if self._task is None:
            return "reset"
        return "waits" if self._held else "runs"

    # ---------------------------------------------------------------------- what others say

    def load(self, program: str) -> None:
        """`XLoad`: selects a program; raises Failed."""
        name = program.upper()
        if self.state != "reset":
            raise Failed(3360, f"slot {self.number} is not reset")
        if not self.controller.exists(name):
            raise Failed(4140, f"there is no program {program}")
        other = self.controller.selected(name)
        if other not in (None, self):
            raise Failed(4190, f"the program {program} is selected for another slot")
        self.program = name

    def run(self) -> None:
        """`XRun`: from the top, or on from where the program was stopped."""
        if self.state == "runs":
            raise Failed(3310, f"slot {self.number} runs")
        if not self.program:
            raise Failed(3320, f"slot {self.number} has no program")
        if self.state == "waits":
            self._held = False
            return
        kernel = self.controller.kernel
        essential = self.condition == "START"
        self._task = kernel.task(str(self.number), self._body, self.lines, essential)
        self._task.prompt()

    def stop(self) -> None:
        """`XStp`: before the next statement of the program, or in its wait."""
        if self.state == "runs" and not self._stops and self._task is not None:
            self._stops = True
            self._task.post(self.hold)

    def reset(self) -> None:
        """`XRst`: a program that was stopped will begin at its top."""
        if self.state == "runs":
            raise Failed(3350, f"slot {self.number} runs")
        if self._task is not None:
            task, self._task = self._task, None
            self.controller.kernel.drop(task)

    def end(self) -> None:
        """The power goes off: the program is where it is no more."""
        task, self._task = self._task, None
        if task is not None:
            self.controller.kernel.drop(task)

    def clear(self) -> None:
        """`XClr`: no program is selected."""
        if not self.program:
            raise Failed(3370, f"slot {self.number} has no program")
        if self.state != "reset":
            raise Failed(3380, f"slot {self.number} is not reset")
        self.program = ""

    def rank(self, lines: int) -> None:
        """`Priority`: statements until the next slot has its turn."""
        self.lines = lines
        if self._task is not None:
            self._task.lines = lines

    # ------------------------------------------------------------------------- in its task

    def hold(self) -> None:
        """Waits until the program is started again; a stopped one gives the arm up meanwhile."""
        task = self._task
        assert task is not None
        controller, world = self.controller, self.world
        assert world is not None
        paused = pausing.pause_arm(world, late=False)
        controller.paused = self if paused else controller.paused
        had = controller.release(self)
        self._held, self._stops, task.essential = True, False, False
        task.wait(lambda: not self._held, what=f"slot {self.number} waits for its start")
        task.essential = self.condition == "START"
        if had:
            controller.get(self, 1)
        if paused:
            if controller.paused is not self:
                raise Unknown("how a stopped motion goes on that another slot has ended")
            controller.paused = None
            pausing.resume_arm(world)

    def _body(self, task: Task) -> Ending:
        controller = self.controller
        world = World(task, controller.arm, timers=controller.timers, shared=controller.shared)
        world.options, world.commands = controller.options, controller.commands
        world.slot, self.world = self, world
        task.where, task.levels = (lambda: statement_place(world)), (lambda: call_levels(world))
        try:
            self._cycles(world)
        except Failed as failed:
            return self._failed(task, failed)
        except Unknown as unknown:
            return Ending("unknown", f"slot {self.number}: {unknown}", task.where())
        finally:
            self._leave(world)
        return Ending()

    def _cycles(self, world: World) -> None:
        controller = self.controller
        machine = controller.machine(self.program, world)
        if machine is None:
            raise Failed(4140, f"there is no program {self.program}")
        if self.number == 1 and controller.owner is None:
            controller.get(self, 1)
        if self.first_line is not None:
            machine.first, self.first_line = machine.code.numbers.get(self.first_line, 0), None
        while True:
            before = controller.kernel.steps
            machine.run()
            if self.mode == "CYC":
                return
            if controller.kernel.steps == before:
                raise Failed(3286, f"the program {self.program} is empty")

    def _failed(self, task: Task, failed: Failed) -> Ending:
        """The others stop; programs for errors run to their end before the run is over."""
        place = task.where()
        if self.condition != "ERROR":
            self.controller.fail(self, failed)
            task.wait(lambda: not self.controller.handles, what="a program that begins with errors")
        return Ending("error", f"slot {self.number}: {failed}", place)

    def _leave(self, world: World) -> None:
        """The program is reset; slot 1 keeps the arm, as it has it from the beginning.

        When the whole run is over, the slot stays as it is, to be looked at.
        """
        world.close_files()
        if self.controller.kernel.ending is not None:
            return
        self._task, self._held, self._stops = None, False, False
        self.controller.end_motion(self)
        if self.number != 1:
            self.controller.release(self)
        for machine in world.running:
            machine.depth = 0
        world.running.clear()

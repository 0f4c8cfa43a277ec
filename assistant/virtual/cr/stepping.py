"""Programs that run a statement at a time, or up to a breakpoint."""

from __future__ import annotations

from assistant.virtual.kernel import Task
from assistant.virtual.melfa.controller import Controller
from assistant.virtual.melfa.slots import Slot


class Stepping:
    """breakpoints: program and line number → whether it goes once it was come to. Everything here
    runs in the thread of the kernel.
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
        if not (self._left or self.breakpoints) or not task.name.isdigit():
            return
        slot = self._controller.slot(int(task.name))
        left = self._left.get(task.name)
        if left:
            self._left[task.name] = left - 1
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

"""Single commands of a slot (EXEC, EXEC2=), which run beside programs."""

from __future__ import annotations

import re
from collections import deque
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from assistant import languages
from assistant.base.diagnostics import Severity, has_errors
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.cr import cells
from assistant.virtual.cr.store import CrProgram, CrRefusal
from assistant.virtual.kernel import Broken, Ending, Task
from assistant.virtual.melfa.arm import Settings
from assistant.virtual.melfa.code import Code, code_of, nodes
from assistant.virtual.melfa.machine import Frame, Machine
from assistant.virtual.melfa.memory import Memory, Scope
from assistant.virtual.melfa.stops import Ended, Failed, Redirected, Unknown
from assistant.virtual.melfa.world import World

if TYPE_CHECKING:
    from assistant.virtual.melfa.controller import Controller
    from assistant.virtual.melfa.slots import Slot

UNKNOWN: Final = 3930
"""Number of what a program asks for that is not simulated: `This command cannot be executed`."""
NAME: Final = "direct "
"""Before the number of the slot, in the names of tasks."""
MOST_WAITING: Final = 16
AFTER_ERROR: Final = 5600
"""Of commands behind one that ended with an error."""
NUMBER: Final = re.compile(r"error (\d+)")


@dataclass(slots=True)
class Waiting:
    """A command that is still to run. edit: the program whose variables it has, None for those of
    the slot. done: the error number that it ended with, None for none.
    """

    code: Code
    edit: CrProgram | None = None
    done: Future[int | None] = field(default_factory=Future)

    @property
    def names(self) -> frozenset[str]:
        """Of the variables that it speaks of."""
        found = (node for row in self.code.rows for node in nodes(row.statement))
        return frozenset(node.key for node in found if isinstance(node, s.Variable))


@dataclass(slots=True)
class Direct:
    """What a slot keeps from command to command, and those that are still to run."""

    settings: Settings = field(default_factory=Settings)
    memory: Memory = field(default_factory=lambda: Memory(Scope()))
    waiting: deque[Waiting] = field(default_factory=deque)
    task: Task | None = None


def error_number(ending: Ending) -> int:
    """The error that a task ended with."""
    found = NUMBER.search(ending.message)
    return int(found[1]) if found and ending.ended == "error" else UNKNOWN


def parse_statement(language: str, text: str) -> Code:
    """A single command; raises CrRefusal with the place of what is wrong."""
    file = languages.get(language).parse(f"1 {text.strip()}")
    assert isinstance(file, s.File)
    if has_errors(file.findings):
        wrong = next(f for f in file.findings if f.severity is Severity.ERROR)
        raise CrRefusal(4220, max((wrong.column or 3) - 2, 1))
    try:
        return code_of(file)
    except Failed as failed:
        raise CrRefusal(failed.number or 4220, 1) from None


def is_motion(code: Code) -> bool:
    return any(isinstance(row.statement, s.Motion) for row in code.rows)


class DirectCommands:
    """Of all slots of a controller; everything here runs in the thread of its kernel."""

    def __init__(self, controller: Controller) -> None:
        self._controller = controller
        self._slots: dict[int, Direct] = {}

    @property
    def running(self) -> bool:
        return any(direct.task is not None for direct in self._slots.values())

    def add(self, number: int, command: Waiting) -> Future[int | None]:
        """Has a command run behind those that wait; raises CrRefusal 5640 if too many do."""
        direct = self._slots.setdefault(number, Direct())
        if len(direct.waiting) >= MOST_WAITING:
            raise CrRefusal(5640)
        direct.waiting.append(command)
        if direct.task is None:
            kernel = self._controller.kernel
            direct.task = kernel.task(
                f"{NAME}{number}", lambda task: self._body(task, number, direct), essential=False
            )
        return command.done

    def stop(self) -> None:
        """Ends them all where they are."""
        for direct in self._slots.values():
            task, direct.task = direct.task, None
            if task is not None and task.ended is None:
                self._controller.kernel.drop(task)
            while direct.waiting:
                direct.waiting.popleft().done.set_result(5650)

    def _body(self, task: Task, number: int, direct: Direct) -> Ending:
        controller = self._controller
        slot = controller.slot(number)
        world = World(
            task,
            controller.arm,
            direct.settings,
            controller.options,
            controller.commands,
            controller.timers,
            shared=controller.shared,
        )
        world.slot = slot
        before = controller.owner
        takes = before is not slot and (before is None or before.state == "reset")
        if takes:  # a slot whose program is over keeps the arm, but does not need it
            controller.owner = None
            controller.get(slot, 1)
        ending = Ending()
        try:
            while direct.waiting and ending.ended == "end":
                ending = self._run(world, slot, direct, direct.waiting.popleft())
        finally:
            direct.task = None
            while direct.waiting:
                direct.waiting.popleft().done.set_result(AFTER_ERROR)
            world.close_files()
            if takes and controller.release(slot):
                controller.owner = before
        return ending

    def _memory(self, world: World, slot: Slot, direct: Direct) -> Memory:
        """The variables of the slot's program, or those that only single commands have."""
        with suppress(Failed):  # of a program that cannot run
            machine = self._controller.machine(slot.program, world) if slot.program else None
            if machine is not None:
                return machine.main
        return direct.memory

    def _run(self, world: World, slot: Slot, direct: Direct, command: Waiting) -> Ending:
        number: int | None = 5650
        ending = Ending()
        machine = Machine(command.code, world, {})
        try:
            machine.main = self._memory(world, slot, direct)
            machine.frames = [Frame("", machine.main)]
            world.running.append(machine)
            if command.edit is not None:
                cells.give_variables(command.edit, machine.main, command.names)
            with suppress(Ended, Redirected):
                machine.go_on(machine.frame)
            world.task.kernel.motion.settle(world.task)
            number = None
        except Broken as broken:
            number = error_number(broken.ending)
            raise
        except Failed as failed:
            number = failed.number or UNKNOWN
            ending = Ending("error", f"error {number}: {failed}")
        except Unknown as unknown:
            number = UNKNOWN
            ending = Ending("unknown", str(unknown))
        finally:
            world.running.clear()
            if command.edit is not None:
                cells.take_back_variables(command.edit, machine.main, command.names)
            command.done.set_result(number)
        return ending

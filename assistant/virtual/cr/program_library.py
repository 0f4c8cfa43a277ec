"""Stored programs and single statements of a controller, as the interpreter runs them.

A program is read when it is first needed. Listings hold the values of variables as text, `M1=+3`:
they are given to a memory when a program starts, and taken back from it afterwards. Single
statements of a slot (EXEC, EXEC2=) run beside its program.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import field, replace
from typing import TYPE_CHECKING, Final

from assistant import languages
from assistant.base.budgets import STORED, within
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, Severity, has_errors
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.cr.store import ENCODING, CrProgram, CrRefusal
from assistant.virtual.events import Place
from assistant.virtual.kernel import Broken, Ending, Task
from assistant.virtual.melfa.arm_state import Settings
from assistant.virtual.melfa.code import Code, code_of, nodes
from assistant.virtual.melfa.machine import Frame, Machine
from assistant.virtual.melfa.values import (
    Cell,
    Elements,
    Ended,
    Failed,
    Joints,
    Memory,
    Position,
    Redirected,
    Scope,
    Unknown,
    Value,
    eight,
)
from assistant.virtual.melfa.world import World

if TYPE_CHECKING:
    from assistant.virtual.melfa.controller import Controller, Slot


_VARIABLE_LINE: Final = re.compile(r"\(([^()]*)\)(?:\(([^()]*)\))?")
_VARIABLE_NAME: Final = re.compile(r"([A-Z]\w*)[$%&!#]?(?:\(([\d,]+)\))?", re.ASCII)


def _listed_variables(memory: Memory) -> Iterator[tuple[str, str]]:
    """Name and value, as a controller lists them, of each variable that has one."""
    for name, place in memory.places.items():
        if not isinstance(place, Cell):
            continue
        # A text variable carries its mark in listings.
        mark = "$" if place.kind == "text" else ""
        for index, value in sorted(place.values.items()):
            at = f"({','.join(map(str, index))})" if index else ""
            yield f"{name}{mark}{at}", _value_text(value)


def _value_text(value: Value) -> str:
    """`+3`, `"a text"`, `(+1.00,…)(7,0)`."""
    match value:
        case str():
            return f'"{value}"'
        case Position(values=values, flags=flags):
            return f"{_elements_text(values)}({flags[0] or 0},{flags[1] or 0})"
        case Joints(values=values):
            return _elements_text(values)
        case int() | float():
            return f"{float(value):+.10g}"
    return _elements_text(value.values)


def _elements_text(values: Elements) -> str:
    count = max([6, *(i + 1 for i, v in enumerate(values) if v is not None)])
    return "(" + ",".join("" if v is None else f"{v + 0.0:+.2f}" for v in values[:count]) + ")"


def _listed_value(text: str) -> Value:
    """The value that a line of a listing tells behind its `=`."""
    if text.startswith('"'):
        return text[1:-1]
    place = _VARIABLE_LINE.fullmatch(text)
    if place is None:
        number = float(text)
        return int(number) if number.is_integer() else number
    values = eight(tuple(float(v) if v.strip() else None for v in place[1].split(",")))
    if place[2] is None:
        return Joints(values)
    one, _, two = place[2].partition(",")
    return Position(values, (int(one or 0), int(two or 0)))


def set_variable(memory: Memory, name: str, value: str) -> None:
    """Sets a variable; raises Failed where it does not take the value."""
    found = _VARIABLE_NAME.fullmatch(name.upper())
    assert found is not None, name
    index = tuple(int(part) for part in found[2].split(",")) if found[2] else ()
    memory.place(found[1]).set(_listed_value(value), index)


def with_values(program: CrProgram, memory: Memory) -> CrProgram:
    """A program with the values that its variables have by now."""
    made = program.copy()
    # Protection is for clients: the run itself may change variables.
    made.protected = set()
    for name, value in _listed_variables(memory):
        made.keep(name, value)
    made.protected = set(program.protected)
    return made


def _give_variables(program: CrProgram, memory: Memory, names: Collection[str]) -> None:
    """Gives a memory the variables of some names that a program has; raises Failed."""
    for line in (program.variables | program.values).values():
        name, _, value = line.partition("=")
        if _base_name(name) in names:
            set_variable(memory, name, value)


def _take_back_variables(program: CrProgram, memory: Memory, names: Collection[str]) -> None:
    """Gives a program the variables of some names as they are by now."""
    for name, value in _listed_variables(memory):
        # `q` protects the values of variables as well.
        if _base_name(name) in names and "q" not in program.protected:
            program.keep(name, value)


def _base_name(name: str) -> str:
    """Without its mark and its subscripts."""
    found = _VARIABLE_NAME.fullmatch(name.upper())
    return found[1] if found else name


class Library:
    """Parsed programs of a controller. source: returns a stored program by its name, None if it is
    missing.
    """

    def __init__(self, language: str, source: Callable[[str], CrProgram | None]) -> None:
        self.source = source
        self._language = languages.get(language)
        self._files: dict[str, s.File] = {}

    def file(self, name: str) -> s.File | None:
        """A program by its name in capitals."""
        if name not in self._files:
            program = self.source(name)
            if program is None:
                return None
            text = self._language.decode(program.text().encode(ENCODING), name)
            try:
                with within(STORED, name, len(text.text)):
                    file = self._language.parse(text)
            except Refused as refused:  # told as what is wrong in it when it is to run
                file = replace(self._language.parse(""), findings=refused.findings)
            assert isinstance(file, s.File)
            self._files[name] = file
        return self._files[name]

    def prepare(self, name: str) -> None:
        """Reads a program and those that it calls, so that no program that runs waits for that."""
        waiting, seen = [name], set[str]()
        while waiting:
            one = waiting.pop()
            file = None if one in seen else self.file(one)
            seen.add(one)
            if file is not None:
                called = self._language.called_files(file)
                waiting += [other.partition(".")[0].upper() for other in called]

    def ready(self, name: str, machine: Machine) -> None:
        """A program begins with the values that its variables have in the store."""
        program = self.source(name)
        for line in program.values.values() if program is not None else ():
            variable, _, value = line.partition("=")
            set_variable(machine.main, variable, value)

    def forget(self, name: str) -> None:
        self._files.pop(name, None)

    def steps(self, name: str) -> list[int]:
        """The line numbers of a program, none if there is no such program."""
        program = self.source(name) if name else None
        return sorted(program.steps) if program is not None else []

    def line(self, place: Place | None) -> int:
        """The number of the line at a place of a program, 0 for none."""
        name, at = place or ("", 0)
        steps = self.steps(name)
        return steps[at - 1] if 1 <= at <= len(steps) else 0


UNKNOWN: Final = 3930
"""Number of what a program asks for that is not simulated: `This command cannot be executed`."""
NAME: Final = "direct "
"""Before the number of the slot, in the names of tasks."""
_MOST_WAITING: Final = 16
_AFTER_ERROR: Final = 5600
"""Error number of commands that follow one that ended with an error."""
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
        """Names of the variables that the command uses."""
        found = (node for row in self.code.rows for node in nodes(row.statement))
        return frozenset(node.key for node in found if isinstance(node, s.Variable))


@dataclass(slots=True)
class _Direct:
    """State of a slot from command to command, and the commands that are still to run."""

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
        # The statement is parsed behind the step number `1 `, which its columns do not count.
        wrong = next(f for f in file.findings if f.severity is Severity.ERROR)
        raise CrRefusal(4220, max((wrong.column or 3) - 2, 1))
    try:
        return code_of(file)
    except Failed as failed:
        raise CrRefusal(failed.number or 4220, 1) from None


def is_motion(code: Code) -> bool:
    return any(isinstance(row.statement, s.Motion) for row in code.rows)


class DirectCommands:
    """Direct commands of all slots of a controller; all of this runs in the thread of its
    kernel.
    """

    def __init__(self, controller: Controller) -> None:
        self._controller = controller
        self._slots: dict[int, _Direct] = {}

    @property
    def running(self) -> bool:
        return any(direct.task is not None for direct in self._slots.values())

    def add(self, number: int, command: Waiting) -> Future[int | None]:
        """Has a command run behind those that wait; raises CrRefusal 5640 if too many do."""
        direct = self._slots.setdefault(number, _Direct())
        if len(direct.waiting) >= _MOST_WAITING:
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
            # Taken first: dropping the task runs its `finally`, which would otherwise clear it.
            task, direct.task = direct.task, None
            if task is not None and task.ended is None:
                self._controller.kernel.drop(task)
            while direct.waiting:
                direct.waiting.popleft().done.set_result(5650)

    def _body(self, task: Task, number: int, direct: _Direct) -> Ending:
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
            # After an error the commands behind it are refused.
            while direct.waiting and ending.ended == "end":
                ending = self._run(world, slot, direct, direct.waiting.popleft())
        finally:
            direct.task = None
            # Clients wait for each of these: none may be forgotten.
            while direct.waiting:
                direct.waiting.popleft().done.set_result(_AFTER_ERROR)
            world.close_files()
            if takes and controller.release(slot):
                controller.owner = before
        return ending

    def _memory(self, world: World, slot: Slot, direct: _Direct) -> Memory:
        """The variables of the slot's program, or those that only single commands have."""
        with suppress(Failed):  # of a program that cannot run
            machine = self._controller.machine(slot.program, world) if slot.program else None
            if machine is not None:
                return machine.main
        return direct.memory

    def _run(self, world: World, slot: Slot, direct: _Direct, command: Waiting) -> Ending:
        # In case the task is dropped in mid-command.
        number: int | None = 5650
        ending = Ending()
        machine = Machine(command.code, world, {})
        try:
            machine.main = self._memory(world, slot, direct)
            machine.frames = [Frame("", machine.main)]
            world.running.append(machine)
            if command.edit is not None:
                _give_variables(command.edit, machine.main, command.names)
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
        # Also after an error: variables that the command has set are taken over.
        finally:
            world.running.clear()
            if command.edit is not None:
                _take_back_variables(command.edit, machine.main, command.names)
            command.done.set_result(number)
        return ending

"""The task T_ROB1: its modules, its program pointer, and how it runs in real time.

All of this happens in the thread of the kernel. A task of the kernel is made whenever the set of
modules or the pointer changes; it waits until the program is started, and keeps its data until
another one replaces it. As the overview of RAPID has it, VAR data gets its first value when the
pointer is moved to main, and stays after a stop and from cycle to cycle; PERS data stays always.

After an error or EXIT the pointer is lost, and has to be set before the next start; a real
controller would let the failed instruction be tried again. While a program is stopped, the time of
a WaitTime goes on.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Final, Literal

from assistant import languages
from assistant.base.budgets import STORED, within
from assistant.base.diagnostics import has_errors
from assistant.languages.rapid.tree import syntax as s
from assistant.robots import Robot
from assistant.virtual.events import Logged, Reported, Stopped
from assistant.virtual.irc5.panel import EventLog
from assistant.virtual.irc5.printing import printed_anew
from assistant.virtual.kernel import Ending, Kernel, Task
from assistant.virtual.rapid.controller import Controller, Options
from assistant.virtual.rapid.disk import Disk
from assistant.virtual.rapid.ends import Fault, NotSimulated
from assistant.virtual.rapid.given import Ability
from assistant.virtual.rapid.loading import load_modules
from assistant.virtual.rapid.machine import Machine
from assistant.virtual.rapid.persistent import saved
from assistant.virtual.rapid.running import start_task
from assistant.virtual.rapid.scopes import Cell
from assistant.virtual.rapid.types import Types
from assistant.virtual.rapid.values import copied

TASK: Final = "T_ROB1"
MAIN: Final = "main"
Cycle = Literal["once", "forever"]
EVENT_NUMBERS: Final = {"error": 80001, "warning": 80002, "information": 80003}
"""Of events that ErrWrite logs."""
FAILURE_EVENTS: Final = (
    ("41822", 41822),
    ("reach", 50050),
    ("range", 50027),
    ("limit", 50027),
    ("", 40228),
)
"""What the words of an error hold, and the number of its event; the first that fits."""


class NotPossible(Exception):
    """What the state of the controller, or the program, does not allow."""


@dataclass(frozen=True, slots=True)
class Module:
    """A module in the program memory. file: where it came from."""

    name: str
    tree: s.File
    file: str = ""

    @property
    def system(self) -> bool:
        return "SYSMODULE" in self._attributes

    @property
    def hidden(self) -> bool:
        """Whether nobody is shown its text."""
        return "NOVIEW" in self._attributes

    @property
    def _attributes(self) -> tuple[str, ...]:
        return next(part.attributes for part in self.tree.modules if part.name == self.name)


@dataclass(frozen=True, slots=True)
class Pointer:
    """The program pointer. row, column: from 1."""

    module: str
    routine: str
    row: int
    column: int


@dataclass(eq=False)
class Programs:
    """kernel: that its task runs in. abilities: instructions of its options. cycle: of the next
    start. running: whether it does. changes: counts changes of the program. ready: whether the
    pointer is set. anew: whether modules are printed from memory without their layout. keep: is
    told when modules were taken in or out, as a real controller keeps them over a loss of power.
    """

    kernel: Kernel
    disk: Disk
    log: EventLog
    robot: Robot | None = None
    abilities: Mapping[str, Ability] = field(default_factory=dict)
    cycle: Cycle = "forever"
    running: bool = False
    ready: bool = False
    active: bool = True
    changes: int = 0
    anew: bool = False
    keep: Callable[[Programs], None] = lambda _: None
    modules: dict[str, Module] = field(default_factory=dict)
    machine: Machine | None = None
    stopped: list[Callable[[], None]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.kernel.watch = self._hold
        self.kernel.told.append(self._told)
        self._task: Task | None = None
        self._entry = MAIN
        self._inside = False
        self._after_cycle = False
        self._where: Pointer | None = None
        self.shared = Controller(Options(), self.disk)

    # --------------------------------------------------------------------------- modules

    def load(self, read: Sequence[Module], replace: bool = False) -> None:
        """Puts modules into the program memory; the pointer is lost if they change the program.

        Raises NotPossible if they do not go together with the others, and changes nothing.
        """
        self._standing("a module is loaded")
        new = dict(self.modules)
        for one in read:
            key = one.name.lower()
            if key in new and not replace:
                raise NotPossible(f"the module {one.name} is loaded already")
            new[key] = one
        self._check(new)
        self._take(new)

    def unload(self, name: str) -> None:
        self._standing("a module is unloaded")
        new = dict(self.modules)
        if new.pop(name.lower(), None) is None:
            raise KeyError(name)
        self._take(new)

    def restore(self, read: Sequence[Module]) -> None:
        """Has these modules instead of all others; raises NotPossible, and changes nothing."""
        self._standing("a backup is restored")
        new = {one.name.lower(): one for one in read}
        self._check(new)
        self._take(new)

    def unload_all(self) -> None:
        """The program, but not the system modules."""
        self._standing("the program is unloaded")
        self._take({key: one for key, one in self.modules.items() if one.system})

    def _standing(self, what: str) -> None:
        if self.running:
            raise NotPossible(f"{what} while the program runs")

    def _check(self, modules: dict[str, Module]) -> None:
        try:
            load_modules([one.tree for one in modules.values()], Types(), {})
        except (Fault, NotSimulated) as wrong:
            self.log.add(40160, str(wrong))
            raise NotPossible(str(wrong)) from None

    def _take(self, modules: dict[str, Module]) -> None:
        self.modules = modules
        self.changes += 1
        self.ready = False
        self._prepare()
        self.keep(self)

    def text(self, module: Module) -> str:
        """With the values that its persistent data has now."""
        try:
            said = saved(self.shared, module.tree)
        except (ValueError, KeyError):
            source = module.tree.source
            said = "" if source is None else source.text
        return printed_anew(said) if self.anew else said

    def teach(self, module: str, name: str, value: str) -> None:
        """Somebody corrects a position at the pendant: its declaration gets the value.

        Constants as well. Raises NotPossible if there is no such data with a value.
        """
        one = self.modules.get(module.lower())
        if one is None:
            raise NotPossible(f"there is no module {module}")
        said = self.text(one)
        for read in read_module(one.file, said.encode()):
            for item in (i for part in read.tree.modules for i in part.items):
                stated = item.value.span if isinstance(item, s.Data) and item.value else None
                if isinstance(item, s.Data) and item.name.lower() == name.lower() and stated:
                    new = f"{said[: stated.start]}{value}{said[stated.end :]}"
                    self.load(read_module(one.file, new.encode()), replace=True)
                    return
        if row := re.search(rf"(?im)^[ \t]*CONST[ \t]+\w+[ \t]+{re.escape(name)}:=([^;]*);", said):
            new = f"{said[: row.start(1)]}{value}{said[row.end(1) :]}"  # of a table of like rows
            self.load(read_module(one.file, new.encode()), replace=True)
            return
        raise NotPossible(f"there is no data {name} in {module}")

    # -------------------------------------------------------------------------- the task

    def _prepare(self) -> None:
        """A task for the modules at hand, which waits to be started; what PERS holds goes over."""
        before = self.machine
        self._drop()
        self.shared = Controller(Options(), self.disk)
        self.machine = None
        self._entry, self._inside, self._where = MAIN, False, None
        if not self.modules:
            return
        self._task = start_task(
            self.kernel,
            [one.tree for one in self.modules.values()],
            name=TASK,
            robot=self.robot,
            controller=self.shared,
            abilities=self.abilities,
            made=self._made,
            cycles=self._next_cycle,
        )
        if before is not None and self.machine is not None:
            _carry_over(before, self.machine)

    def _made(self, machine: Machine) -> None:
        self.machine = machine

    def _drop(self) -> None:
        if self._task is not None and self._task in self.kernel.tasks:
            task, self._task = self._task, None
            if not self.kernel.motion.stands():
                self.kernel.motion.cut(task)
            self.kernel.drop(task)

    def _next_cycle(self, machine: Machine) -> str | None:
        """The routine that the next cycle begins with; waits for the start of the first one."""
        if self._inside and (self.cycle == "once" or not self.running):
            machine.settle()
            self._halted(10125, "the cycle has come to its end")
        self._inside = False
        machine.task.wait(lambda: self.running and self.ready, None, "the start")
        standing = self.kernel.motion.where()
        if standing is not None and not self._after_cycle:
            machine.arm.flange, machine.arm.joints = standing[0], standing[1][:6]
        entry, self._entry = self._entry, MAIN
        self._inside = self._after_cycle = True
        return entry

    def _hold(self, task: Task) -> None:
        """Before each statement: it waits while the program is stopped."""
        if task is self._task and self._inside and not self.running:
            task.wait(lambda: self.running, None, "the start")

    # -------------------------------------------------------------------------- commands

    def start(self, cycle: Cycle | None = None) -> None:
        if self.running:
            raise NotPossible("the program runs already")
        if not self.ready or self._task is None:
            raise NotPossible("the program pointer is not set")
        self.cycle = cycle or self.cycle
        self.running = True
        self.kernel.motion.resume(self.kernel)
        self.log.add(10151, f"The task {TASK} has been started")

    def stop(self, at: Literal["once", "cycle", "instruction"] = "once") -> None:
        """Between two statements and with the arm on its way, or at the end of either."""
        if not self.running:
            return
        if at == "cycle":
            self.cycle = "once"
            return
        if at == "once":
            self.kernel.motion.hold(self.kernel)
            if self._task is not None:
                self._task.post(partial(self._hold, self._task))
        self._halted(10125, "the program was stopped from outside")

    def fail(self, why: str) -> None:
        """Something outside of the program stops it, as an emergency stop."""
        if self.running:
            self.stop()
            self.log.add(10126, why)

    def reset(self, routine: str = MAIN, module: str = "") -> None:
        """Moves the program pointer to a routine; to main all data but persistent one is new."""
        self._standing("the program pointer is moved")
        found = self._place_of(routine, module)
        if found is None:
            raise NotPossible(f"there is no routine {routine}")
        self._prepare()
        self._entry, self.ready, self._where, self._after_cycle = routine, True, found, False
        self.log.add(10002, f"The task {TASK} was pointed at {routine}")

    def _place_of(self, routine: str, module: str = "") -> Pointer | None:
        for one in self.modules.values():
            for part in one.tree.modules:
                for item in part.items:
                    if not isinstance(item, s.Routine) or item.name.lower() != routine.lower():
                        continue
                    if module and part.name.lower() != module.lower():
                        continue
                    if item.kind == "PROC" and not (item.local and not module):
                        first = item.body[0] if item.body else item
                        row, column = _pointer_position(one, first)
                        return Pointer(part.name, item.name, row, column)
        return None

    def pointer(self) -> Pointer | None:
        """None if it is not set."""
        if not self.ready:
            return None
        if not self._inside or self.machine is None or self.machine.at is None:
            return self._where or self._place_of(self._entry)
        unit, span = self.machine.at
        names = [f.routine.name for f in self.machine.frames if f.routine is not None]
        if unit.source is None or span is None or not names:
            return self._where
        row, column = unit.source.line_column(span.start)
        return Pointer(unit.name, names[-1], row + self.machine.row, column)

    # ------------------------------------------------------------------------ what happens

    def _halted(self, code: int, text: str) -> None:
        self.running = False
        self.log.add(code, text)

    def _told(self, row: Logged) -> None:
        match row.what:
            case Stopped(end=False) if self.running:
                self._halted(10125, "an instruction stopped the program")
            case Reported(kind, header, lines):
                self.log.add(
                    EVENT_NUMBERS.get(kind, 80003), "\n".join(lines), header, (header, *lines)
                )

    def ended(self, task: Task, ending: Ending) -> None:
        """The kernel tells that a task is over: EXIT, or an error."""
        if task is not self._task:
            return
        self._task, self.ready, self._inside = None, False, False
        if not self.kernel.motion.stands():
            self.kernel.motion.cut(task)
        if ending.ended in ("error", "unknown"):
            code = next(number for words, number in FAILURE_EVENTS if words in ending.message)
            self.log.add(code, ending.message, arguments=(TASK, ending.message))
            self._halted(10126, ending.message)
        elif self.running:
            self._halted(10125, "the program has come to its end")


def read_module(file: str, data: bytes) -> list[Module]:
    """The modules of a file; raises NotPossible for what a controller would not load."""
    rapid = languages.get("rapid")
    try:
        with within(STORED, file, len(data)):
            tree = rapid.parse(rapid.decode(data, file))
    except ValueError as wrong:
        raise NotPossible(str(wrong)) from None
    if has_errors(tree.findings):
        first = next(one for one in tree.findings if one.severity.value == "error")
        raise NotPossible(f"{file}:{first.line}: {first.message}")
    if not tree.modules:
        raise NotPossible(f"{file}: the file holds no module")
    return [Module(part.name, tree, file) for part in tree.modules]


def _carry_over(before: Machine, after: Machine) -> None:
    """Persistent data of the modules that are the same keeps its values."""
    for key, unit in after.modules.items():
        old = before.modules.get(key)
        if old is None or old.source is not unit.source:
            continue
        for names, others in ((unit.names, old.names), (after.named, before.named)):
            for name, cell in names.items():
                was = others.get(name)
                if not isinstance(cell, Cell) or not isinstance(was, Cell):
                    continue
                if cell.storage == "PERS" and was.value is not None and cell.pending is not None:
                    if was.shape.type and cell.pending.unit is unit:
                        cell.shape, cell.first = was.shape, was.first
                        cell.value, cell.pending = copied(was.value), None


def _pointer_position(module: Module, node: s.Node) -> tuple[int, int]:
    source, span = module.tree.source, node.span
    if source is None or span is None:
        return 1, 1
    return source.line_column(span.start)

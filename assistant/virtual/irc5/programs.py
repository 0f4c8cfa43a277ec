"""The programs of a virtual IRC5: the task T_ROB1, its modules, and checks of module files.

The task runs in the thread of the kernel. A task of the kernel is made whenever the set of modules
or the program pointer changes; it waits until the program is started, and keeps its data until
another one replaces it. As the overview of RAPID has it, VAR data gets its first value when the
pointer is moved to main, and stays after a stop and from cycle to cycle; PERS data stays always.
After an error or EXIT the pointer is lost, and has to be set before the next start; a real
controller would let the failed instruction be tried again. The time of a WaitTime runs on while a
program is stopped. A module is printed as controllers save it: values with six digits at most,
whole numbers without a point, `9E+09`, no comments.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import field, replace
from functools import partial
from pathlib import Path as FilePath
from pathlib import PurePosixPath
from typing import Final, Literal
from xml.etree import ElementTree

from assistant import languages
from assistant.base.budgets import STORED, within
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Severity, error, has_errors, warning
from assistant.base.file_access import read_file
from assistant.base.source_text import lines_of
from assistant.languages import Tree
from assistant.languages.rapid import Rapid, rules
from assistant.languages.rapid.tree import syntax as s
from assistant.robots import Robot
from assistant.virtual.events import Logged, Reported, Stopped
from assistant.virtual.irc5.panel import EventLog
from assistant.virtual.kernel import Ending, Kernel, Task
from assistant.virtual.rapid.call_arguments import Ability
from assistant.virtual.rapid.control_flow import Fault, NotSimulated
from assistant.virtual.rapid.controller import Controller, Options, load_modules
from assistant.virtual.rapid.disk import Disk
from assistant.virtual.rapid.interpreter import start_task
from assistant.virtual.rapid.machine import Machine
from assistant.virtual.rapid.scopes import Cell, Types
from assistant.virtual.rapid.value_text import saved
from assistant.virtual.rapid.values import copied

COMMENT_LINE: Final = re.compile(r'("[^"\n]*")|[ \t]*!.*')
DATA_LINE: Final = re.compile(
    r"^[ \t]*(?:(?:LOCAL|TASK)[ \t]+)?(?:CONST|PERS|VAR)[ \t].*", re.I | re.M
)
PRINTED_NUMBER: Final = re.compile(r'"[^"]*"|(?<![\w.])\d+(?:\.\d*)?(?:E[+-]?\d+)?(?![\w.])', re.I)


def printed_anew(text: str) -> str:
    """A module in the controller's own layout; data that runs over lines stays as it is."""
    rapid = Rapid()
    # Comments go; quoted texts match first, so that an exclamation mark in one stays.
    lines = COMMENT_LINE.sub(lambda found: found[1] or "", rapid.format(rapid.parse(text)))
    # Numbers of data alone are printed anew; those of statements stay as written.
    anew = DATA_LINE.sub(lambda found: PRINTED_NUMBER.sub(_printed_number, found[0]), lines)
    return "\n".join(line.strip() for line in lines_of(anew) if line.strip()) + "\n"


def _printed_number(found: re.Match[str]) -> str:
    text = found[0]
    return text if text.startswith('"') or text.isdecimal() else f"{float(text):.6G}"


TASK: Final = "T_ROB1"
MAIN: Final = "main"
Cycle = Literal["once", "forever"]
EVENT_NUMBERS: Final = {"error": 80001, "warning": 80002, "information": 80003}
"""Numbers of the events that ErrWrite logs."""
FAILURE_EVENTS: Final = (
    ("41822", 41822),
    ("reach", 50050),
    ("range", 50027),
    ("limit", 50027),
    ("", 40228),
)
"""Part of an error's text, and the number of its event; the first match counts."""


class NotPossible(Exception):
    """An action that the state of the controller or the program does not allow."""


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
        """True if no one may see its text."""
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
            # Checked with empty types: the memory in use stays as it is.
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
        # PERS data outlives changes of the program.
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
        # The last corner is not open any more: the arm goes to the target.
        if self._inside and (self.cycle == "once" or not self.running):
            machine.settle()
            self._halted(10125, "the cycle has come to its end")
        self._inside = False
        machine.task.wait(lambda: self.running and self.ready, None, "the start")
        standing = self.kernel.motion.where()
        if standing is not None and not self._after_cycle:
            machine.arm.flange, machine.arm.joints = standing[0], standing[1][:6]
        # Only the first cycle begins at the routine that the pointer was set to.
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
        # Prepared anew first: `_prepare` resets the entry.
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
            # The last row, "", matches any text.
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
        # Another text of the module: its declarations may be others.
        if old is None or old.source is not unit.source:
            continue
        for names, others in ((unit.names, old.names), (after.named, before.named)):
            for name, cell in names.items():
                was = others.get(name)
                if not isinstance(cell, Cell) or not isinstance(was, Cell):
                    continue
                # Only data that has not been evaluated yet takes the earlier value.
                if cell.storage == "PERS" and was.value is not None and cell.pending is not None:
                    if was.shape.type and cell.pending.unit is unit:
                        cell.shape, cell.first = was.shape, was.first
                        cell.value, cell.pending = copied(was.value), None


def _pointer_position(module: Module, node: s.Node) -> tuple[int, int]:
    source, span = module.tree.source, node.span
    if source is None or span is None:
        return 1, 1
    return source.line_column(span.start)


MODULE_SUFFIXES: Final = (".mod", ".sys", ".prg")
PROGRAM_SUFFIX: Final = ".pgf"
PROGRAM_HEADING: Final = re.compile(
    r"^[ \t]*MODULE[ \t]+([A-Za-z]\w*)", re.IGNORECASE | re.MULTILINE
)

NO_MODULE = error("VC101", "the file holds no module", "write `MODULE name … ENDMODULE`")
PROGRAM_FILE = error(
    "VC102",
    "the program file cannot be read: {reason}",
    "write `<Program><Module>name.mod</Module></Program>`",
)
MISSING_MODULE = error(
    "VC103",
    "the program file names `{name}`, which is not beside it",
    "send the modules before the program file",
)
TWICE = warning(
    "VC104",
    "module `{name}` is in `{first}` as well: only one of the two can be loaded",
    "delete one of the files or rename its module",
)


@dataclass(frozen=True, slots=True)
class LoadedModule:
    """A module of task T_ROB1: its name, the file in HOME: it came from, what is wrong."""

    name: str
    file: str
    findings: tuple[Diagnostic, ...] = ()


def is_checked(file: str) -> bool:
    return file.lower().endswith((*MODULE_SUFFIXES, PROGRAM_SUFFIX))


def check_file(
    file: str, data: bytes, folder: FilePath, leaving: str = ""
) -> tuple[Diagnostic, ...]:
    """The findings of a file that is to get that name in a folder; other kinds have none.

    leaving: a file of the folder that goes away by the same act.
    """
    lower = file.lower()
    beside = [f for f in folder.iterdir() if f.name not in (file, leaving) and f.is_file()]
    if lower.endswith(PROGRAM_SUFFIX):
        return _program_findings(file, data, frozenset(f.name for f in beside))
    if not lower.endswith(MODULE_SUFFIXES):
        return ()
    module, tree = _read_file(file, data)
    if tree is None or has_errors(module.findings):
        return module.findings
    loaded = [f for f in beside if f.suffix.lower() in MODULE_SUFFIXES]
    try:
        with within(STORED, file, len(data)):
            found = _rule_findings(module, tree, loaded)
    except Refused as error:
        found = error.findings
    return (*module.findings, *found)


def load_module_file(file: str, data: bytes) -> LoadedModule:
    """A module file as the controller's load reads it."""
    return _read_file(file, data)[0]


def _read_file(file: str, data: bytes) -> tuple[LoadedModule, Tree | None]:
    """The module with its tree, None for what is no text or no module."""
    rapid = languages.get("rapid")
    stem = PurePosixPath(file).stem
    try:
        source = rapid.decode(data, file)
    except Refused as error:
        return LoadedModule(stem, file, error.findings), None
    try:
        with within(STORED, file, len(data)):
            tree = rapid.parse(source)
    except Refused as error:
        return LoadedModule(stem, file, error.findings), None
    findings = tuple(finding.within(file) for finding in tree.findings)
    named = PROGRAM_HEADING.search(source.text)
    if named is None:
        return LoadedModule(stem, file, (*findings, NO_MODULE(path=file))), None
    return LoadedModule(named[1], file, findings), tree


def _rule_findings(
    module: LoadedModule, tree: Tree, loaded: list[FilePath]
) -> tuple[Diagnostic, ...]:
    """Return the rule findings of a module, except those that the other modules resolve.

    HOME: holds files of many programs, so two of them may well declare one name.
    """
    rapid = languages.get("rapid")
    alone = [
        finding for finding in _refused_finding(rapid.check([tree])) if finding not in tree.findings
    ]
    if not has_errors(alone):
        return tuple(alone)
    trees = [tree]
    for file in loaded:
        other, other_tree = _read_file(file.name, read_file(file))
        if other_tree is None or has_errors(other.findings):
            continue
        if other.name.lower() != module.name.lower():  # else it is this one's own old self
            trees.append(other_tree)
    together = set(_refused_finding(rapid.check(trees)))
    # Only findings that remain among all modules count; new ones are of other files.
    return tuple(finding for finding in alone if finding in together)


UNDECLARED: Final = frozenset({rules.UNKNOWN_SPEED.code, rules.UNKNOWN_ZONE.code})
"""Names that other modules may declare, but none does: here all that is loaded is known."""


def _refused_finding(findings: Iterable[Diagnostic]) -> list[Diagnostic]:
    """The findings as severe as they are where no module is missing."""
    return [
        replace(finding, severity=Severity.ERROR) if finding.code in UNDECLARED else finding
        for finding in findings
    ]


def _program_findings(file: str, data: bytes, beside: frozenset[str]) -> tuple[Diagnostic, ...]:
    if b"<!" in data.replace(b"<!--", b""):  # no entity of a stranger is ever expanded
        return (PROGRAM_FILE(path=file, reason="it declares a document type"),)
    try:
        root = ElementTree.fromstring(data)  # noqa: S314 - without document type, see above
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        return (PROGRAM_FILE(path=file, reason=str(error)),)
    named = [(element.text or "").strip() for element in root.iter("Module")]
    if root.tag != "Program" or not named:
        return (PROGRAM_FILE(path=file, reason="it names no modules"),)
    there = {name.lower() for name in beside}
    return tuple(
        MISSING_MODULE(path=file, name=name) for name in named if name.lower() not in there
    )

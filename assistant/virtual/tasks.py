"""Tasks and slots: programs that run together on one controller, and the files that each one loads.

RAPID: the modules of a folder belong to one task. A backup has the modules of a task in
`RAPID/TASKn/PROGMOD` and `SYSMOD`, modules that all tasks share in `RAPID/TASK0`, the names of the
tasks in `BACKINFO/backinfo.txt`, and how they start in `SYSPAR/SYS.cfg`. MELFA-BASIC: the first
program goes into slot 1, the next one into slot 2, and so on.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path
from typing import Any, Final

from assistant import languages
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error
from assistant.base.file_access import read_text
from assistant.base.source_text import SourceText
from assistant.languages import Language
from assistant.program.program import Program, Signal
from assistant.virtual.events import Logged, Switched
from assistant.virtual.kernel.script import Change, InputChange, Script, When

_NOT_RUN: Final = error(
    "VC201", "programs in {language} cannot be run here", "choose a program in {languages}"
)


@dataclass(frozen=True, slots=True)
class Group:
    """Files that are loaded together. name: of their task or slot.

    essential: whether the run goes on until it ends. beside: whether files that it calls are
    looked for in the folder of the first.
    """

    name: str
    files: tuple[str, ...]
    essential: bool = True
    beside: bool = True


@dataclass(frozen=True, slots=True)
class Part:
    """A task or slot with what is loaded in it.

    trees: of one language, the program first. names: of the programs, where they call each other.
    """

    name: str
    trees: tuple[Any, ...]
    names: tuple[str, ...] = ()
    essential: bool = True


@dataclass(frozen=True, slots=True)
class SignalNames:
    """Names that people read for the keys that a run has of its signals.

    inputs, outputs: by key. groups: numbers and bits of group inputs, by name in lower case.
    numbered: True if the keys are numbers.
    """

    inputs: Mapping[str, str]
    outputs: Mapping[str, str]
    groups: Mapping[str, range] = field(default_factory=dict)
    numbered: bool = False

    def shown(self, row: Logged | InputChange) -> Logged | InputChange:
        """An event, or a change of an input, with the name that people read."""
        return self.changed(row) if isinstance(row, InputChange) else self.logged(row)

    def changed(self, row: InputChange) -> InputChange:
        """A change of an input with the name that people read."""
        return replace(row, name=self.inputs.get(row.name, row.name))

    def logged(self, row: Logged) -> Logged:
        """An event with the name that people read."""
        match row.what:
            case Switched(signal) if signal in self.outputs:
                return replace(row, what=replace(row.what, signal=self.outputs[signal]))
        return row

    def input_key(self, name: str) -> str:
        """The key of an input by its name in any case, else the name itself in lower case."""
        low = name.lower()
        return next((key for key, shown in self.inputs.items() if shown.lower() == low), low)

    def keyed(self, script: Script) -> Script:
        """A script with the keys of the signals that it names; a group is one for each bit."""
        inputs, outputs = (
            {name.lower(): key for key, name in names.items()}
            for names in (self.inputs, self.outputs)
        )

        def change(one: Change) -> Change:
            when = one.when
            if isinstance(when, When):
                when = replace(
                    when, name=(inputs if when.is_input else outputs).get(when.name, when.name)
                )
            return replace(one, name=inputs.get(one.name, one.name), when=when)

        def bits(one: Change) -> Iterator[Change]:
            for at, number in enumerate(self.groups.get(one.name, ())):
                yield replace(one, name=str(number), value=float(int(one.value) >> at & 1))

        changes = (tuple(bits(one)) or (one,) for one in map(change, script.changes))
        return replace(script, changes=tuple(one for group in changes for one in group))


@dataclass(frozen=True, slots=True)
class Programs:
    """Programs that run together: parts in one language, or a pseudo-program.

    title: its name from the user. language: None for the pseudo-program. text: that of the
    pseudo-program, None if it comes from another source. findings: those of the reader. stated:
    signals that files beside the programs, or their headings, name.
    """

    title: str
    language: Language[Any] | None = None
    parts: tuple[Part, ...] = ()
    program: Program | None = None
    text: SourceText | None = None
    findings: tuple[Diagnostic, ...] = ()
    stated: Mapping[str, Signal] = field(default_factory=dict)

    def names(self) -> SignalNames:
        """The names of signals in the spelling of the programs, else of the files beside them."""
        if self.language is not None and self.language.family in _NUMBERED:
            digital = [(n, s) for n, s in self.stated.items() if s.kind == "digital"]
            inputs, outputs = (
                {str(s.number): name for name, s in digital if s.direction == way}
                for way in ("input", "output")
            )
            groups = {
                name.lower(): range(s.number, s.number + s.bits)
                for name, s in self.stated.items()
                if (s.kind, s.direction) == ("group", "input") and s.number is not None
            }
            return SignalNames(inputs, outputs, groups, numbered=True)
        names = {name.lower(): name for name in self.stated}
        if self.program is not None:
            names |= {name.lower(): name for name in self.program.signals}
        elif self.language is not None:
            names |= _rapid_spellings(self)
        return SignalNames(names, names)

    def known_inputs(self) -> dict[str, float]:
        """Inputs that the files beside the programs state, each 0 until something sets it."""
        if self.language is not None and self.language.family in _NUMBERED:
            return {}
        return {name.lower(): 0.0 for name, one in self.stated.items() if one.direction == "input"}

    def sources(self) -> list[SourceText]:
        """The texts that places are in."""
        trees = (tree for part in self.parts for tree in part.trees)
        found = [tree.source for tree in trees if tree.source is not None]
        return found if self.text is None else [self.text]

    def signals(self) -> frozenset[str] | None:
        """Names that the programs use for signals, and may use, in lower case; None for any."""
        if self.program is not None:
            return frozenset(name.lower() for name in self.program.signals)
        if self.language is None or self.language.family not in _SIGNALS:
            return None
        return _SIGNALS[self.language.family](self)


def groups(language: Language[Any], files: Sequence[str], folder: str | None) -> list[Group]:
    """The tasks or slots that files are loaded into; raises Refused where that is not clear.

    folder: that the files were found in, None where each was named.
    """
    return _grouping_of(language, _GROUPS)(files, folder)


def _grouping_of(language: Language[Any], table: Mapping[str, _Grouping]) -> _Grouping:
    if language.family not in table:
        spoken = ", ".join(table)
        raise Refused(_NOT_RUN(language=language.title, languages=spoken), exit_status=2)
    return table[language.family]


_Grouping = Callable[[Sequence[str], str | None], list[Group]]


def _tasks(files: Sequence[str], folder: str | None) -> list[Group]:

    return _rapid_tasks(files, folder)


def _slots(files: Sequence[str], folder: str | None) -> list[Group]:

    return melfa_slots(files, folder)


def _rapid_signals(programs: Programs) -> frozenset[str] | None:
    """All names that are used: what only an expression reads may be a signal as well."""
    from assistant.languages.rapid.tree import syntax
    from assistant.languages.rapid.tree.walk import nodes
    from assistant.virtual.rapid.controller import used_signals, works_signals_out

    if any(works_signals_out(part.trees) for part in programs.parts):
        return None
    files = tuple(tree.parts for part in programs.parts for tree in part.trees)
    used = {one.name.lower() for one in nodes(files) if isinstance(one, syntax.NameRef)}
    return frozenset(used.union(*(used_signals(part.trees)[1] for part in programs.parts)))


def _rapid_spellings(programs: Programs) -> dict[str, str]:
    """Names by their lower case, as they are spelled first."""
    from assistant.languages.rapid.tree import syntax
    from assistant.languages.rapid.tree.walk import nodes

    found: dict[str, str] = {}
    for part in programs.parts:
        for one in nodes(tuple(tree.parts for tree in part.trees)):
            if isinstance(one, syntax.NameRef):
                found.setdefault(one.name.lower(), one.name)
    return found


_NUMBERED: Final = ("MB",)
"""Families of the languages whose signals are numbers."""
_SIGNALS: Final[Mapping[str, Callable[[Programs], frozenset[str] | None]]] = {"RA": _rapid_signals}
"""By the family of a language whose signals have names."""
_GROUPS: Final[Mapping[str, _Grouping]] = {"RA": _tasks, "MB": _slots}
"""By the family of a language."""


_SEVERAL_FOLDERS: Final = error(
    "VC204",
    "the folder holds programs in several folders: {names}",
    "name the folder of one task, a backup, or the modules that one task loads",
)
_SEVERAL_LISTS: Final = error(
    "VC205",
    "the folder holds several lists of programs: {names}",
    "name the one that the task loads",
)
_DEFAULT_TASK: Final = "T_ROB1"
_PROGRAM_LIST: Final = ".pgf"
_SHARED_TASK: Final = "TASK0"
_BACKUP_FOLDER: Final = re.compile(r"(?i)(?:^|/)RAPID/(TASK\d+)$")
_TASK_NAME: Final = re.compile(r"(?im)^>>\s*(TASK\d+)\s*:\s*\(\s*([A-Za-z]\w*)")
_TASK_TABLE: Final = re.compile(r"(?ims)^CAB_TASKS:(.*?)(?:^\S|\Z)")
_ATTRIBUTE: Final = re.compile(r'-(\w+)(?:\s+"([^"]*)")?')


def _rapid_tasks(files: Sequence[str], folder: str | None) -> list[Group]:
    """The task that moves the robot first. Files that were named are all of one task."""
    if folder is None:
        return [Group(_DEFAULT_TASK, tuple(files))]
    language = languages.get("rapid")
    inside: dict[Path, list[str]] = {}
    for file in files:
        inside.setdefault(language.program_of(Path(file)), []).append(file)
    backup = {found[1].upper(): path for path in inside if (found := _backup_task(path))}
    if backup:
        return list(_backup_groups(backup, inside))
    if len(inside) > 1:
        names = ", ".join(f"`{path}`" for path in inside)
        raise Refused(_SEVERAL_FOLDERS(path=folder, names=names), exit_status=2)
    return [Group(_DEFAULT_TASK, _folder_modules(folder, files), beside=False)]


def _backup_task(path: Path) -> re.Match[str] | None:
    return _BACKUP_FOLDER.search(path.absolute().as_posix())


def _folder_modules(folder: str, files: Sequence[str]) -> tuple[str, ...]:
    """The modules of a folder, without the list that names them."""
    lists = [file for file in files if file.lower().endswith(_PROGRAM_LIST)]
    if len(lists) > 1:
        names = ", ".join(f"`{Path(file).name}`" for file in lists)
        raise Refused(_SEVERAL_LISTS(path=folder, names=names), exit_status=2)
    return tuple(file for file in files if file not in lists) or tuple(lists)


def _backup_groups(backup: dict[str, Path], inside: dict[Path, list[str]]) -> Iterator[Group]:
    root = next(iter(backup.values())).absolute().parents[1]
    names = {key.upper(): name for key, name in _TASK_NAME.findall(_backup_text(root, "BACKINFO"))}
    rows = list(_task_rows(_backup_text(root, "SYSPAR")))
    moving = {row["Name"] for row in rows if "MotionTask" in row and "Name" in row}
    beside = {
        row.get("Name", "") for row in rows if row.get("Type", "").upper() in _BACKGROUND_TYPES
    }
    shared = [f for key, path in backup.items() if key == _SHARED_TASK for f in inside[path]]
    found = []
    for key, path in sorted(backup.items()):
        if key == _SHARED_TASK:
            continue
        # Without a name in the backup the first task has the usual one.
        name = names.get(key) or (_DEFAULT_TASK if key == "TASK1" else key)
        modules = (*_folder_modules(str(path), inside[path]), *shared)
        found.append(Group(name, modules, essential=name not in beside, beside=False))
    # The task that moves the robot comes first; sorted() keeps the order of the others.
    yield from sorted(found, key=lambda group: group.name not in moving)


_BACKGROUND_TYPES: Final = ("STATIC", "SEMISTATIC")
"""Types of tasks that run all the time, whether or not the others have ended."""
_BACKUP_FILES: Final = {"BACKINFO": "backinfo.txt", "SYSPAR": "SYS.cfg"}


def _backup_text(root: Path, folder: str) -> str:
    """A file of a backup, empty where it is not there or may not be read."""
    try:
        return read_text(root / folder / _BACKUP_FILES[folder], "latin-1")
    except OSError:
        return ""


def _task_rows(text: str) -> Iterator[dict[str, str]]:
    """The tasks that the system parameters state, by their attributes."""
    table = _TASK_TABLE.search(text)
    if table is None:
        return
    # A backslash at the end of a line continues it; each row begins with its name.
    for row in re.split(r"(?m)^\s*(?=-Name\b)", table[1].replace("\\\n", " ")):
        if attributes := dict(_ATTRIBUTE.findall(row)):
            yield attributes


_SEVERAL_PROGRAMS: Final = error(
    "VC202",
    "the folder holds {count} programs: {names}",
    "name the one of slot 1 first, then those of the other slots",
)
_TOO_MANY: Final = error(
    "VC203", "there are {count} programs for the {most} slots of a controller", "name fewer"
)
_MOST_SLOTS: Final = 32
"""The most that the parameter TASKMAX may say; it is 8 at first (CR1D 4.2)."""


def melfa_slots(files: Sequence[str], folder: str | None) -> list[Group]:
    """The first program in slot 1, the next one in slot 2, and so on."""
    if folder is not None and len(files) > 1:
        names = ", ".join(f"`{Path(file).name}`" for file in files)
        raise Refused(_SEVERAL_PROGRAMS(path=folder, count=len(files), names=names), exit_status=2)
    if len(files) > _MOST_SLOTS:
        raise Refused(_TOO_MANY(count=len(files), most=_MOST_SLOTS), exit_status=2)
    return [Group(str(slot), (file,)) for slot, file in enumerate(files, 1)]

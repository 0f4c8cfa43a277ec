"""Programs in files and folders: which files make up one program, and which do not, and why.

A task is the set of files that a controller loads as one program; it is found by folders, lists of
tasks, data and calls. `load` returns the pseudo-program of a path, be it a file or a folder that
holds one program.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from difflib import SequenceMatcher
from itertools import takewhile
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant import languages, sources
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import (
    Diagnostic,
    Refused,
    Unreadable,
    error,
    has_errors,
    info,
    warning,
)
from assistant.base.source_text import is_folder, path_of, read_bytes
from assistant.compiler import loader
from assistant.compiler.loader import (
    Loaded,
    configured_beside,
    files_in,
    language_of,
    lift_trees,
    missing_files,
    whole_programs,
    with_called,
    with_process,
)
from assistant.languages import Language
from assistant.languages.language_types import SharedData

if TYPE_CHECKING:
    from assistant.languages.language_types import TaskLoading
    from assistant.robots import Robot
    from assistant.sources.process import SurroundingsByRobot
    from assistant.sources.process.placement import DrawingPlacement


_FILE_CHOSEN: Final = warning(
    "CO042",
    "`{name}` is declared in {files}; the program is read with {chosen}",
    "name the files of the program, if it is another one",
)
_SHARED_FILE: Final = info(
    "CO049",
    "`{file}` of `{task}` is read in this task too, which declares no `{name}`",
    "name the files of the program, if its task has another one",
)


@dataclass(frozen=True, slots=True)
class Task:
    """Files that are one program.

    name: the path that it is known by: of its list, of its folder or of the file it begins in.
    files: in the order in which they are read. begins: whether one of them holds what the task
    begins with, where its language has such a thing. language: None for what is no program.
    trees: of the files, if they were parsed to find that out.
    """

    name: str
    files: tuple[str, ...]
    language: str | None = None
    begins: bool = True
    findings: tuple[Diagnostic, ...] = ()
    trees: tuple[Any, ...] = ()


def tasks_of(files: Sequence[str], language: str | None = None) -> tuple[Task, ...]:
    """Return the programs that files make up, in the order of their first files.

    A file that is named twice, or beside one that loads it, is not another program. An unreadable
    file becomes a separate task, to be refused in its turn. language: of the files, if neither
    suffix nor text identifies it.
    """
    once: dict[FilePath, str] = {}
    for file in files:
        once.setdefault(FilePath(file).absolute(), file)
    several: dict[str, list[_Unit]] = {}
    alone, found = list[str](), list[Task]()
    for file in once.values():
        try:
            spoken = language_of(language) if language else _language_of_file(file)
            if spoken is None or spoken.loading is None or len(once) == 1:
                alone.append(file)
            else:
                several.setdefault(spoken.name, []).append(
                    _unit_of_file(spoken, spoken.loading, file)
                )
        except Refused:
            alone.append(file)
    for name, units in several.items():
        spoken = language_of(name)
        assert spoken.loading is not None
        found += _Grouping(name, spoken.loading, units).tasks()
    found += [Task(file, (file,), language) for file in whole_programs(alone, language)]
    order = {file: place for place, file in enumerate(once.values())}
    return tuple(sorted(found, key=lambda task: min(order[file] for file in task.files)))


def load_task(
    task: Task, *, process: str | FilePath | None = None, robot: Robot | None = None
) -> Loaded:
    """The pseudo-program of a task of several files; raises Unreadable or Refused."""
    assert task.language is not None
    spoken = language_of(task.language)
    trees = list(task.trees) or [spoken.parse(spoken.read(file)) for file in task.files]
    beside = FilePath(task.files[0]).parent
    loaded = lift_trees(spoken, with_called(spoken, trees, task.files, beside), robot)
    findings = (*task.findings, *missing_files(spoken, trees), *loaded.findings)
    loaded = replace(loaded, findings=findings)
    loaded = configured_beside(loaded, spoken, FilePath(task.files[0]))
    return loaded if process is None else with_process(loaded, process)


_CONTENTS_WITHOUT_CODE: Final = frozenset(("type", "shared data", "data"))
"""Contents of files that run nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class _Unit:
    """A file that is a part of programs. room: the folder of its task.

    listed: the files that a list names, None if it is not a list. declares: for the complete task.
    routines: those of its names that are not data local to a task. mentions: names of others, in
    lower case. inert: it has no routines. broken: it cannot be parsed completely; only a list or
    its own `main` makes it a part of a program.
    """

    path: str
    tree: Any
    room: FilePath
    declares: frozenset[str]
    routines: frozenset[str]
    mentions: frozenset[str]
    listed: tuple[str, ...] | None
    begins: bool
    loads: frozenset[str]
    inert: bool
    broken: bool

    @property
    def file(self) -> str:
        return FilePath(self.path).name.lower()


def _text_of(unit: _Unit) -> str:
    return "" if unit.tree.source is None else str(unit.tree.source.text)


def _language_of_file(file: str) -> Language[Any] | None:
    return languages.of_file(file, read_bytes(file))


def _unit_of_file(language: Language[Any], loading: TaskLoading, file: str) -> _Unit:
    tree = language.parse(language.read(file))
    shared = [(name.lower(), kind) for name, kind in language.shared_names(tree)]
    is_list = FilePath(file).suffix.lower() in loading.lists
    called = language.called_files(tree)
    return _Unit(
        file,
        tree,
        language.program_of(FilePath(file).absolute()),
        frozenset(name for name, _ in shared),
        frozenset(name for name, kind in shared if kind != "data"),
        language.mentions(tree),
        called if is_list else None,
        any(name == loading.entry for name, _ in shared),
        frozenset() if is_list else frozenset(name.lower() for name in called),
        bool(shared) and all(kind in _CONTENTS_WITHOUT_CODE for _, kind in shared),
        has_errors(tree.findings),
    )


@dataclass(slots=True)
class _Group:
    """A task that grows. name: see `Task`."""

    name: str
    units: list[_Unit] = field(default_factory=list)
    declared: set[str] = field(default_factory=set)
    findings: list[Diagnostic] = field(default_factory=list)

    def add(self, unit: _Unit) -> None:
        self.units.append(unit)
        self.declared |= unit.declares

    def takes(self, unit: _Unit) -> bool:
        """True if a controller could load the file as well: none of its names is declared yet."""
        if unit.broken or unit in self.units:
            return False
        return self.declared.isdisjoint(unit.declares)


class _Grouping:
    """The tasks of all files of one language."""

    def __init__(self, language: str, loading: TaskLoading, units: Sequence[_Unit]) -> None:
        self.language, self.loading = language, loading
        self.units = units
        self.rooms: dict[FilePath, list[_Unit]] = {}
        self.owners: dict[str, list[_Unit]] = {}
        self.files: dict[str, list[_Unit]] = {}
        for unit in units:
            self.files.setdefault(unit.file, []).append(unit)
            self.rooms.setdefault(unit.room, []).append(unit)
            for name in unit.declares:
                self.owners.setdefault(name, []).append(unit)

    def tasks(self) -> Iterator[Task]:
        groups: list[_Group] = []
        spread = {room for room in self.rooms if self.loading.shared(room)}
        # Nothing but shared folders: they hold tasks as others do.
        if spread == set(self.rooms):
            spread = set()
        for room, units in self.rooms.items():
            if room not in spread:
                groups += self._of_room(room, units)
        taken = {unit for group in groups for unit in group.units}
        rest = [unit for unit in self.units if unit not in taken and unit.room not in spread]
        # A backup keeps the files that its tasks load beside them as well.
        loaded = {_text_of(unit) for unit in self.units if self.loading.closed(unit.room)}
        rest = [u for u in rest if self.loading.closed(u.room) or _text_of(u) not in loaded]
        groups += self._libraries(rest)
        shared = self._shared(groups)
        for group in groups:
            known = shared.get(id(group)) or SharedData(tuple(unit.tree for unit in group.units))
            begins = any(unit.begins for unit in group.units)
            files = tuple(unit.path for unit in group.units)
            said = (*group.findings, *known.findings)
            yield Task(group.name, files, self.language, begins, said, known.trees)

    def _shared(self, groups: Sequence[_Group]) -> dict[int, SharedData]:
        """Return the data that tasks of one controller share, by the identity of the task."""
        beside: dict[FilePath, list[_Group]] = {}
        for group in groups:
            rooms = {one.room for one in group.units if not self.loading.shared(one.room)}
            if len(rooms) == 1 and all(map(self.loading.closed, rooms)):
                beside.setdefault(rooms.pop().parent, []).append(group)
        found: dict[int, SharedData] = {}
        for several in beside.values():
            if len(several) > 1:
                told = [(FilePath(g.name).name, [u.tree for u in g.units]) for g in several]
                made = self.loading.sharing(told)
                found |= {id(group): one for group, one in zip(several, made, strict=True)}
        return found

    def _of_room(self, room: FilePath, units: Sequence[_Unit]) -> Iterator[_Group]:
        """The tasks that begin in a folder, and all of a folder that is one."""
        lists = [unit for unit in units if unit.listed is not None]
        parts = [unit for unit in units if unit.listed is None]
        groups = [self._listed(one, parts) for one in lists]
        inside = {unit for group in groups for unit in group.units}
        groups += [
            _group_of_unit(one.path, one) for one in parts if one.begins and one not in inside
        ]
        whole = self.loading.closed(room) or any(
            FilePath(unit.path).absolute().parent != room for unit in units
        )
        if whole and not groups and parts:
            groups = [_Group(_folder_text(parts[0], room))]
        for group in groups:
            if whole and len(groups) == 1 and not lists:
                group.name = _folder_text(parts[0], room)
                for unit in parts:
                    if group.takes(unit):
                        group.add(unit)
            if self.loading.closed(room):
                for other in self._shared_with(room):
                    if group.takes(other):
                        group.add(other)
            self._grow(group, room)
        if len(groups) == 1:
            self._join(groups[0], parts)
        yield from (group for group in groups if group.units)

    def _join(self, group: _Group, parts: Sequence[_Unit]) -> None:
        """Takes in what uses the data and routines of the only task of a folder.

        A task loads such files by names that it works out, or its operator loads them.
        """
        pending = list(group.units)
        while pending:
            declared = pending.pop(0).declares
            for unit in parts:
                if unit.mentions & declared and group.takes(unit):
                    group.add(unit)
                    pending.append(unit)

    def _listed(self, one: _Unit, parts: Sequence[_Unit]) -> _Group:
        """The task of a list, with system modules that are loaded beside it."""
        group = _Group(one.path)
        group.add(one)
        there = {unit.file: unit for unit in parts}
        for name in dict.fromkeys(one.listed or ()):
            file = name.replace("\\", "/").rsplit("/", 1)[-1].lower()
            if file in there:
                group.add(there[file])
        for unit in parts:
            if self.loading.loaded(FilePath(unit.path)) and group.takes(unit):
                group.add(unit)
        return group

    def _shared_with(self, room: FilePath) -> Iterator[_Unit]:
        for other, units in self.rooms.items():
            if other != room and other.parent == room.parent and self.loading.shared(other):
                yield from (unit for unit in units if unit.listed is None)

    def _grow(self, group: _Group, room: FilePath) -> None:
        """Takes in what declares the names that the files of a group mention."""
        open_ended = not self.loading.closed(room)
        pending = list(group.units)
        while pending:
            one = pending.pop(0)
            for unit in self._loaded_by(one):
                if group.takes(unit):
                    group.add(unit)
                    pending.append(unit)
            for name in sorted(one.mentions - group.declared):
                # A file with a start of its own is another task.
                found = [u for u in self.owners.get(name, ()) if not u.begins and group.takes(u)]
                near = [u for u in found if u.room == room]
                # Outside of closed tasks only routines are looked for elsewhere, and only if one
                # file has them.
                if not near and open_ended:
                    near = [
                        u for u in found if name in u.routines and not self.loading.closed(u.room)
                    ]
                    near = near if len(near) == 1 else []
                elif not near:
                    near = self._beside(found, name, room)
                    told = (_is_beside(name, unit) for unit in near)
                    group.findings += told
                if near and name not in group.declared:
                    chosen = max(near, key=lambda unit: _likeness(unit, group, one.mentions))
                    if len(near) > 1:
                        group.findings.append(_choice_finding(name, near, chosen))
                    group.add(chosen)
                    pending.append(chosen)

    def _beside(self, found: Sequence[_Unit], name: str, room: FilePath) -> list[_Unit]:
        """The file of another task that declares a type or shared data, and runs nothing.

        A backup may hold modules of all tasks with one of them only.
        """
        near = [u for u in found if u.inert and name in u.routines and u.room.parent == room.parent]
        return near if len({u.file for u in near}) == 1 else []

    def _loaded_by(self, one: _Unit) -> Iterator[_Unit]:
        """The files that one loads by their names: those that stand nearest to it."""
        for name in sorted(one.loads):
            found = [unit for unit in self.files.get(name, ()) if unit is not one]
            near = [_folder_distance(unit, one) for unit in found]
            # If two files are equally near, neither is certain to be the one.
            if near and near.count(min(near)) == 1:
                yield found[near.index(min(near))]

    def _libraries(self, rest: Sequence[_Unit]) -> Iterator[_Group]:
        """Files that no task has, those of a folder that use each other together."""
        left = list(rest)
        while left:
            group = _group_of_unit(left[0].path, left.pop(0))
            joined = True
            while joined:
                joined = False
                for unit in list(left):
                    if (
                        unit.room == group.units[0].room
                        and group.takes(unit)
                        and any(
                            unit.mentions & one.declares or one.mentions & unit.declares
                            for one in group.units
                        )
                    ):
                        group.add(unit)
                        left.remove(unit)
                        joined = True
            self._grow(group, group.units[0].room)
            yield group


def _folder_distance(unit: _Unit, other: _Unit) -> int:
    """Return the number of folders between two files."""
    one, two = (FilePath(u.path).absolute().parent.parts for u in (unit, other))
    shared = sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(one, two, strict=False)))
    return len(one) + len(two) - 2 * shared


def _group_of_unit(name: str, unit: _Unit) -> _Group:
    group = _Group(name)
    group.add(unit)
    return group


def _folder_text(unit: _Unit, room: FilePath) -> str:
    """Return a folder of a file, as the user wrote it."""
    path = FilePath(unit.path)
    return next((str(p) for p in path.parents if p.absolute() == room), str(room))


def _likeness(unit: _Unit, group: _Group, mentions: frozenset[str]) -> tuple[int, float]:
    """Return how well a file fits: its names that are mentioned, and the similarity of the first
    file name.
    """
    first = SequenceMatcher(None, group.units[0].file, unit.file)
    return len(mentions & unit.declares), first.ratio()


def _is_beside(name: str, unit: _Unit) -> Diagnostic:
    path = FilePath(unit.path)
    return _SHARED_FILE(name=name, file=path.name, task=unit.room.name, path=unit.path)


def _choice_finding(name: str, units: Sequence[_Unit], chosen: _Unit) -> Diagnostic:
    files = ", ".join(f"`{FilePath(unit.path).name}`" for unit in units)
    word = f"`{FilePath(chosen.path).name}`"
    return _FILE_CHOSEN(name=name, files=files, chosen=word, path=chosen.path)


_NO_PROGRAMS: Final = error(
    "CO403",
    "the folder `{name}` holds no robot programs",
    "name the files, and their language with --from",
)
_LEFT_OUT: Final = info("CO308", "{files} left out: {why}", "{cure}")
_WHY_EMPTY: Final = "empty"
_WHY_NO_PROGRAM: Final = "no line there looks like one of a robot program"
_WHY_COPY: Final = "a copy of a program, kept by the project"
_WHY_NO_TEXT: Final = "what a controller makes of a program, and no text"
_WHY_OUTPUT: Final = "in the folder that is written to, where an earlier run may have left it"
_CURES_OF_LEFT: Final[Mapping[str, str]] = {
    _WHY_EMPTY: "export or save it again if a program should be in it",
    _WHY_NO_PROGRAM: "if it is a program, name it by itself, with its language (--from)",
    _WHY_COPY: "name it by itself if the copy is meant",
    _WHY_NO_TEXT: "export the program as text, if that is not among the files that are read",
    _WHY_OUTPUT: "name it by itself, or write to another folder, if it is a source",
}
_MOST_FILES_NAMED: Final = 3
"""Files of one reason that are named."""

Report = Callable[[Diagnostic], None]


@dataclass(frozen=True, slots=True)
class OutputFolder:
    """Output folder of programs in a language, with the files of an earlier run."""

    folder: str
    language: str

    def holds(self, file: str, language: Language[Any], searched: str) -> bool:
        """True if a file of any version of the language is in this folder, inside the searched
        one.
        """
        here, whole = FilePath(self.folder).resolve(), FilePath(searched).resolve()
        inside = whole in here.parents and here in FilePath(file).resolve().parents
        suffixes = languages.get(self.language).suffixes
        return inside and not set(suffixes).isdisjoint(language.suffixes)


def programs_in(
    path: str,
    language: str | None = None,
    told: Report | None = None,
    output: OutputFolder | None = None,
) -> Iterator[str]:
    """Yield the file itself, or the robot programs of a folder and its subfolders.

    Hidden folders are skipped, and so are files that do not look like a program, and copies of
    texts in a folder that has them; told: receives a finding for each reason. output: its files are
    not sources, as they were written there. Raises Refused if no program is found.
    """
    if not is_folder(path):
        yield path
        return
    spoken = [language_of(language)] if language else list(map(languages.get, languages.names()))
    suffixes = {suffix for one in spoken for suffix in one.suffixes}
    found, left = list[str](), dict[str, str]()
    for file in files_in(path, suffixes):
        why = "" if language else _why_not(file, spoken, path, output)
        if why:
            left[file] = why
        else:
            found.append(file)
    # Copies, and files that are no text, are taken if there is nothing else.
    if not found:
        found = [file for file, why in left.items() if why in (_WHY_COPY, _WHY_NO_TEXT)]
        left = {file: why for file, why in left.items() if file not in found}
    for why in dict.fromkeys(left.values()):
        if told is not None:
            shown = _left_out_finding(path, left, why)
            told(_LEFT_OUT(why=why, files=shown, cure=_CURES_OF_LEFT[why], path=path))
    if not found:
        raise Refused(_NO_PROGRAMS(path=path, name=path), exit_status=2)
    yield from found


def _left_out_finding(folder: str, left: Mapping[str, str], why: str) -> str:
    files = [FilePath(file).relative_to(folder) for file, one in left.items() if one == why]
    shown = ", ".join(f"`{file.as_posix()}`" for file in files[:_MOST_FILES_NAMED])
    more = len(files) - _MOST_FILES_NAMED
    return f"{shown} and {more} more" if more > 0 else shown


def _why_not(
    file: str, spoken: list[Language[Any]], searched: str, output: OutputFolder | None
) -> str:
    """Why a file of a folder is no program of it, empty if it is one."""
    try:
        data = read_bytes(file, allow_empty=True)
    except Unreadable:
        return ""  # to be said when it is read
    language = languages.of_file(file, data)
    if language is None:
        return _WHY_NO_PROGRAM if data.strip() else _WHY_EMPTY
    if any(one.begins and data.startswith(one.begins) for one in spoken):
        return _WHY_NO_TEXT
    if output is not None and output.holds(file, language, searched):
        return _WHY_OUTPUT
    return _WHY_COPY if language.is_copy(FilePath(file)) else ""


_SEVERAL_PROGRAMS: Final = error(
    "CO047",
    "the folder `{name}` holds {count} programs",
    "name one of them: {names}",
)
_MOST_TASKS_NAMED: Final = 8


def load(
    path: str | FilePath,
    *,
    process: str | FilePath | None = None,
    robot: Robot | None = None,
    language: str | None = None,
    unit: str | None = None,
    around: SurroundingsByRobot | None = None,
    placement: DrawingPlacement | None = None,
) -> Loaded:
    """Return the pseudo-program of a file, see `loader.load`, or of a folder with one robot
    program.

    A folder may be a controller's backup or a project; if only one of several programs can start
    alone, it is used, as the others are unused. Raises Unreadable or Refused.
    """
    path_of(path)
    if not is_folder(path) or FilePath(path).suffix.lower() in sources.READERS:
        return loader.load(
            path,
            process=process,
            robot=robot,
            language=language,
            unit=unit,
            around=around,
            placement=placement,
        )
    if placement is not None:
        from assistant.sources.process.placement import check_drawn

        check_drawn(FilePath(path))
    left = list[Diagnostic]()
    tasks = tasks_of(list(programs_in(str(path), language, left.append)), language)
    task = _only_task(tasks)
    if task is None:
        shown = ", ".join(f"`{one.name}`" for one in tasks[:_MOST_TASKS_NAMED])
        names = (
            f"{shown} and {len(tasks) - _MOST_TASKS_NAMED} more"
            if len(tasks) > _MOST_TASKS_NAMED
            else shown
        )
        raise Refused(
            _SEVERAL_PROGRAMS(name=path, count=len(tasks), names=names, path=str(path)),
            exit_status=2,
        )
    if len(task.files) > 1:
        loaded = load_task(task, process=process, robot=robot)
    else:
        file = task.files[0]
        loaded = loader.load(file, process=process, robot=robot, language=language, unit=unit)
    return replace(loaded, findings=(*left, *loaded.findings))


def _only_task(tasks: tuple[Task, ...]) -> Task | None:
    begun = [task for task in tasks if task.begins]
    return tasks[0] if len(tasks) == 1 else begun[0] if len(begun) == 1 else None

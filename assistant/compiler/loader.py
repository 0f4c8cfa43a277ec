"""Loader: the pseudo-program of any file or text that can be read.

A vendor program is loaded with the files that it calls, in a language with the settings of its
project file:

[melfa-basic]        # in assistant.toml; `[tool.robot-assistant.melfa-basic]` in pyproject.toml
name-length = 16

`with_entry` lets a program begin with a procedure that the user names.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import field, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant import languages, sources
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error, has_errors, warning
from assistant.base.length_units import unit_stated
from assistant.base.source_text import SourceText, decode, folders_of, read_bytes
from assistant.languages.language_types import Choice
from assistant.program import pseudo
from assistant.program.analysis.uses import called
from assistant.program.program import Procedure, Program, Signal
from assistant.program.project_file import Project, project_of
from assistant.program.statements import Follow, MoveStatement, OwnText
from assistant.program.vendor_statements import with_effects
from assistant.sources.seen_settings import NO_SEEN_SETTINGS, SeenSettings

if TYPE_CHECKING:
    from assistant.languages import Language, Tree
    from assistant.program.undeclared_names import Supplied, Wanted
    from assistant.robots import Robot
    from assistant.sources.process import ProgramStyle, SurroundingsByRobot
    from assistant.sources.process.placement import DrawingPlacement


PSEUDO_ENCODINGS: Final = ("utf-8-sig", "utf-8")

_LISTED_FILE_MISSING: Final = warning(
    "CO041",
    "the list names `{name}`, which is not beside it",
    "copy the file there, or see whether what it declares is missing",
)


@dataclass(frozen=True, slots=True)
class Loaded:
    """A pseudo-program, the language it was written in (None: no robot language), and the findings.

    joint_speed, joint_percent, seen: see `Process`. wanting: names that the program uses and
    neither it nor a cell file states; each has a stand-in. arm: name of the arm that joint angles
    were taught on, or SAME_ARM; None if a cell file does not state it. told_arm: the arm that files
    of its controller name, in its maker's words; known_arm: the same in the catalogue, None if that
    lacks it. signals: stated by files of
    its controller. held: names that these files give a value; bare: the trees without those. text:
    of a pseudo-program. form: style of a program that was made from a drawing or table, None for
    any other.
    """

    program: Program
    language: str | None = None
    findings: tuple[Diagnostic, ...] = ()
    joint_speed: float | None = None
    joint_percent: float | None = None
    wanting: tuple[Wanted, ...] = ()
    arm: str | None = None
    told_arm: str = ""
    known_arm: str | None = None
    signals: Mapping[str, Signal] = field(default_factory=dict)
    held: Supplied = ()
    bare: tuple[Any, ...] = ()
    text: SourceText | None = None
    seen: SeenSettings = NO_SEEN_SETTINGS
    form: ProgramStyle | None = None


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
    """The pseudo-program of a drawing, table, `.pseudo` text or vendor program.

    process: process file of a drawing or table; of any other program, whose tools, frames and
    signals of those names it says anew. robot: the arm that a vendor program was
    written for, where its own header does not say. language: of a vendor program, if neither
    suffix nor text tell. Other units that a vendor program calls are read from beside it.
    unit: of length, that a drawing is in. around: what stands around the work of one. placement:
    where a drawing stands, instead of what its process file says; nothing else can be placed.
    Raises Unreadable or Refused.
    """
    source = FilePath(path)
    stated = () if unit is None else (unit_stated(path, unit),)
    if placement is not None:
        from assistant.sources.process.placement import check_drawn

        check_drawn(source)
    if source.suffix.lower() == pseudo.SUFFIX:
        text = read_pseudo(path)
        loaded = Loaded(parse_pseudo(text, source.parent), None, stated, text=text)
        return loaded if process is None else with_process(loaded, process)
    data = None if source.suffix.lower() in sources.READERS else read_bytes(source)
    spoken = _language_of_data(source, data, language)
    if spoken is None:
        from assistant.compiler.style import style_of
        from assistant.sources.process import NO_STYLE

        style = style_of(source.absolute().parent).form
        reading = sources.read(source, process, unit, around, placement, merging=True, style=style)
        percent = reading.joint_percent
        program = reading.program
        if source.suffix.lower() != ".dxf" and (reading.style or NO_STYLE).commented:
            program = replace(
                program, comments=(*program.comments, *map(OwnText, _facts(program, source)))
            )
        read = program, None, reading.findings
        return Loaded(*read, joint_percent=percent, seen=reading.seen, form=reading.style)
    loaded = lift_texts(spoken, [spoken.read(source)], robot, beside=source.parent)
    origin = loaded.program.origin
    missing = missing_files(spoken, origin.trees if origin is not None else ())
    loaded = replace(loaded, findings=(*missing, *loaded.findings, *stated))
    loaded = configured_beside(loaded, spoken, source)
    return loaded if process is None else with_process(loaded, process)


def _facts(program: Program, source: FilePath) -> Iterator[str]:
    """Yield comments for the program of a table: its file, tools and frames."""
    yield f"table {source.name}"
    yield from equipment_facts(program)


def equipment_facts(program: Program) -> Iterator[str]:
    """Yield a comment that names the tools and frames that a program moves with."""
    tools: dict[str, None] = {}
    frames: dict[str, None] = {}
    for node in program.statements():
        if isinstance(node, MoveStatement):
            tools[node.motion.tool] = frames[node.motion.frame] = None
        elif isinstance(node, Follow):
            tools |= dict.fromkeys(node.path.tools)
            frames |= dict.fromkeys(node.path.frames)
    if tools:
        yield f"tool {', '.join(tools)}, frame {', '.join(frames)}"


def configured_beside(loaded: Loaded, language: Language[Any], file: FilePath) -> Loaded:
    """Return a program with the values that files of its controller beside it state."""
    from assistant.compiler.cell_equipment import (
        controller_configuration,
        with_controller_configuration,
    )

    given, found = controller_configuration(language, file)
    placed = with_controller_configuration(loaded.program, language, given)
    origin = loaded.program.origin
    return replace(
        loaded,
        held=placed.held,
        bare=() if origin is None else tuple(origin.trees),
        program=placed.program,
        findings=(*loaded.findings, *found, *placed.findings),
        arm=placed.arm or loaded.arm,
        told_arm=given.told,
        known_arm=given.arm,
        signals={**loaded.signals, **given.signals},
    )


def load_text(
    text: SourceText,
    *,
    process: str | FilePath | None = None,
    robot: Robot | None = None,
    language: str | None = None,
) -> Loaded:
    """Load a text that is not a file: in a robot language if named, else pseudo text."""
    if language is None:
        loaded = Loaded(parse_pseudo(text), text=text)
    else:
        loaded = lift_texts(language_of(language), [text], robot)
    return loaded if process is None else with_process(loaded, process)


def with_process(loaded: Loaded, process: str | FilePath) -> Loaded:
    """A program in the cell that a process file states; raises Unreadable or Refused."""
    from assistant.compiler.cell_equipment import (
        check_signals,
        with_cell_equipment,
        with_directions,
        without_other_numbers,
    )
    from assistant.sources.process.file import read_process

    stated = with_directions(read_process(process), loaded.program.signals)
    check_signals(loaded.program, stated, str(process))
    program, findings = with_cell_equipment(loaded.program, stated, str(process))
    told = without_other_numbers(loaded.findings, program, loaded.signals, stated.signals)
    return replace(
        loaded,
        program=program,
        findings=(*told, *findings),
        joint_speed=stated.joint_speed,
        joint_percent=stated.joint_percent,
        seen=stated.seen,
    )


def read_pseudo(path: str | FilePath) -> SourceText:
    return decode(read_bytes(path), str(path), PSEUDO_ENCODINGS)


def parse_pseudo(text: SourceText, side_tables: FilePath | None = None) -> Program:
    """Parse pseudo text into a program with the effects of its vendor text; raise Refused.

    The reader of pseudo text supports no vendor language. side_tables: folder of tables in separate
    files.
    """
    return with_effects(pseudo.parse(text, side_tables=side_tables), languages.effect)


def files_in(folder: str, suffixes: Collection[str]) -> Iterator[str]:
    """Files of a folder and the folders in it, by name; hidden folders and pipes left aside.

    suffixes: of the files, in lower case. Raises Unreadable for a folder that may not be read.
    """
    for inside, inner, names in folders_of(folder):
        inner[:] = sorted(name for name in inner if not name.startswith("."))
        for name in sorted(names):
            path = os.path.join(inside, name)  # noqa: PTH118 (keeps it as the user wrote it)
            if FilePath(name).suffix.lower() in suffixes and not _is_pipe(path):
                yield path


def _is_pipe(path: str) -> bool:
    """True if reading would wait for another program: a pipe or a device, not a file."""
    return FilePath(path).exists() and not FilePath(path).is_file()


def language_of(name: str) -> Language[Any]:
    """Return a language by name; raise Refused for an unknown one."""
    return languages.get(name)


def lift_texts(
    language: Language[Any],
    texts: Sequence[SourceText],
    robot: Robot | None = None,
    *,
    beside: FilePath | None = None,
) -> Loaded:
    """The pseudo-program of vendor texts; raises Refused if one of them is broken."""
    return lift_trees(language, read_trees(language, texts, beside=beside), robot)


def lift_trees(language: Language[Any], trees: Sequence[Any], robot: Robot | None = None) -> Loaded:
    """Lift the trees of one program to a pseudo-program; raise Refused if one of them is invalid.

    Errors with only one possible meaning are corrected, with warnings.
    """
    trees = [(has_errors(tree.findings) and language.mended(tree)) or tree for tree in trees]
    findings = [finding for tree in trees for finding in tree.findings]
    if has_errors(findings):
        raise Refused(*findings)
    return Loaded(language.lift(trees, robot), language.name, tuple(findings))


def read_trees(
    language: Language[Any], texts: Sequence[SourceText], *, beside: FilePath | None = None
) -> list[Any]:
    """The trees of texts, and of the files in the folder `beside` that they call."""
    trees = [language.parse(text) for text in texts]
    if beside is None:
        return trees
    return with_called(language, trees, [text.path for text in texts], beside)


def with_called(
    language: Language[Any], trees: Sequence[Any], paths: Sequence[str | None], folder: FilePath
) -> list[Any]:
    """Trees of files at these paths, and those of the files in a folder that they call."""
    return [*trees, *_called_trees(language, trees, paths, folder)]


def missing_files(language: Language[Any], trees: Iterable[Any]) -> Iterator[Diagnostic]:
    """A finding for each file that a list of a task names and that is not beside it."""
    for tree in trees:
        path = FilePath((tree.source and tree.source.path) or "")
        if language.loading is None or path.suffix.lower() not in language.loading.lists:
            continue
        there = _files_by_name(path.parent)
        if not isinstance(there, Refused):
            for name in language.called_files(tree):
                if _file_name_of(name) not in there:
                    yield _LISTED_FILE_MISSING(name=name, path=str(path))


def _file_name_of(name: str) -> str:
    """The name of a file without the folders before it, in lower case."""
    return name.replace("\\", "/").rsplit("/", 1)[-1].lower()


def whole_programs(files: Sequence[str], language: str | None = None) -> list[str]:
    """Return the files that no other file in their folder calls or lists.

    Called files are read with their callers. Of files that call each other the first one stays. An
    unreadable file stays as well, to be refused separately.
    """
    calls: dict[str, list[str]] = {}
    folders: dict[FilePath, dict[str, str]] = {}
    for file in files:
        folders.setdefault(FilePath(file).parent, {})[FilePath(file).name.lower()] = file
    for file in files:
        path = FilePath(file)
        calls[file] = []
        if len(folders[path.parent]) == 1:  # nothing else that it may call
            continue
        with suppress(Exception):  # it is refused, or fails, when its turn comes
            spoken = _language_of_data(path, read_bytes(path), language)
            if spoken is not None:
                there = folders[path.parent]
                tree = spoken.parse(spoken.read(path))
                named = (spoken.file_called(n, tree, there) for n in spoken.called_files(tree))
                beside = {name for name in named if name is not None} - {path.name.lower()}
                calls[file] = [there[name] for name in there if name in beside]
    called = {other for others in calls.values() for other in others}
    kept: set[str] = set()
    reached: set[str] = set()
    for file in (*(f for f in files if f not in called), *files):
        if file in reached:
            continue
        kept.add(file)
        pending = [file]
        while pending:
            if (one := pending.pop()) not in reached:
                reached.add(one)
                pending += calls[one]
    return [file for file in files if file in kept]


def read_companions(language: Language[Any], trees: Sequence[Any], folder: FilePath) -> list[Any]:
    """The trees of files in a folder that run beside a program, and of what these call."""

    def names(tree: Any) -> tuple[str, ...]:
        return (*language.called_files(tree), *language.companions(tree))

    known = [name for tree in trees for name in language.called_files(tree)]
    return _named_trees(language, trees, names, known, folder)


def _called_trees(
    language: Language[Any], trees: Sequence[Tree], paths: Sequence[str | None], folder: FilePath
) -> list[Tree]:
    """The trees of the files in the folder that trees call, and of those that these call."""
    known = [FilePath(path).name for path in paths if path]
    return _named_trees(language, trees, language.called_files, known, folder)


def _named_trees(
    language: Language[Any],
    trees: Sequence[Any],
    names: Callable[[Any], tuple[str, ...]],
    known: Iterable[str],
    folder: FilePath,
) -> list[Any]:
    """The trees of the files in a folder that trees name, but for those that are known."""
    there = _files_by_name(folder)
    seen = {name.lower() for name in known}
    found: list[Any] = []
    pending = list(trees)
    while pending:
        tree = pending.pop(0)
        for name in names(tree):
            if isinstance(there, Refused):
                raise there
            file = language.file_called(name, tree, there)
            if file is not None and file not in seen:
                seen.add(file)
                found.append(language.parse(language.read(there[file])))
                pending.append(found[-1])
    return found


def _files_by_name(folder: FilePath) -> dict[str, FilePath] | Refused:
    """Return the files in a folder, by their names in lower case, or the reason why it may not be
    read.

    The folder is read even if nothing in it is named: a build is renewed when its files change.
    """
    try:
        _, _, names = next(folders_of(folder))
    except Refused as refused:
        return refused
    return {name.lower(): folder / name for name in names if (folder / name).is_file()}


def _language_of_data(
    source: FilePath, data: bytes | None, named: str | None
) -> Language[Any] | None:
    if named is not None:
        return language_of(named)
    return None if data is None else languages.of_file(source, data)


_UNKNOWN_LANGUAGE_SETTING: Final = error(
    "CO304", "`{key}` is no setting of {table}", "write one of {settings}"
)
_SETTING_OUT_OF_RANGE: Final = error(
    "CO305", "`{key}` is {value}, no whole number from {least} to {most}",
    "{meaning}"
)  # fmt: skip
_SETTING_NO_CHOICE: Final = error("CO307", "`{key}` is {value!a}, none of {words}", "{meaning}")
_LANGUAGE_SETTINGS_NO_TABLE: Final = error(
    "CO306", "`{table}` is no table", "write lines such as {setting} = {value} in it"
)


def with_project_settings(language: Language[Any], folder: FilePath) -> Language[Any]:
    """The language with what the project of a folder says about its controllers.

    Raises Unreadable or Refused, both of exit status 2, if the project's file is broken.
    """
    if not language.settings:
        return language
    project = project_of(folder)
    content = project.content if project is not None else None
    if project is None or not isinstance(content, Mapping) or language.table not in content:
        return language
    return language.configured(_read_language_settings(project, language, content[language.table]))


def _read_language_settings(
    project: Project, language: Language[Any], given: object
) -> dict[str, int | str]:
    at = (language.table,)
    table = "[" + ".".join((*project.table, *at)) + "]"
    if not isinstance(given, Mapping):
        name, first = next(iter(language.settings.items()))
        value = f'"{first.words[0]}"' if isinstance(first, Choice) else first.least
        finding = project.finding(
            _LANGUAGE_SETTINGS_NO_TABLE, at, table=language.table, setting=name, value=value
        )
        raise Refused(finding, exit_status=2)
    found: list[Diagnostic] = []
    for key, value in given.items():
        setting = language.settings.get(key)
        if setting is None:
            known = ", ".join(language.settings)
            found.append(
                project.finding(
                    _UNKNOWN_LANGUAGE_SETTING, (*at, key), key=key, table=table, settings=known
                )
            )
        elif isinstance(setting, Choice):
            if value not in setting.words:
                words = {"words": ", ".join(setting.words), "meaning": setting.meaning}
                at_key = (*at, key)
                found.append(
                    project.finding(_SETTING_NO_CHOICE, at_key, key=key, value=value, **words)
                )
        elif type(value) is not int or not setting.least <= value <= setting.most:
            fields = {"least": setting.least, "most": setting.most, "meaning": setting.meaning}
            found.append(
                project.finding(_SETTING_OUT_OF_RANGE, (*at, key), key=key, value=value, **fields)
            )
    if found:
        raise Refused(*found, exit_status=2)
    return dict(given)


_NO_SUCH_ENTRY = error("CO011", "there is no procedure `{name}` to begin with", "choose {names}")
_ENTRY_WITH_PARAMETERS = error(
    "CO012",
    "nothing can begin with `{name}`, which has parameters, a result or a unit of its own",
    "choose {names}, or write a procedure that calls it",
)


def with_entry(program: Program, entry: str | None) -> Program:
    """The program beginning with that procedure, with its own beginning if none is named.

    Raises Refused for one that there is not, or that nothing can begin with.
    """
    if entry is None:
        return program
    known = program.procedure(entry)
    if known is not None and _can_begin(known):
        return replace(program, entry=known.name)
    begin = ", ".join(beginnings(program))
    names = f"one of {begin}" if begin else "a procedure without parameters"
    rule = _NO_SUCH_ENTRY if known is None else _ENTRY_WITH_PARAMETERS
    raise Refused(rule(name=entry, names=names), exit_status=2)


def beginnings(program: Program) -> tuple[str, ...]:
    """Return the procedures that the program could begin with, those that nothing calls first."""
    names = [one.name for one in program.procedures if _can_begin(one)]
    inner = {name for one in program.procedures for name in called(one)}
    return tuple(sorted(names, key=lambda name: name.lower() in inner))


def _can_begin(procedure: Procedure) -> bool:
    return not procedure.parameters and procedure.result is None and procedure.unit is None

"""What is to be run: programs with all that they call, tasks, backups, and any other source."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant import languages, sources
from assistant.base.diagnostics import Diagnostic, Refused, Severity, error, has_errors
from assistant.base.source_text import SourceText, is_folder, read_bytes
from assistant.compiler.arms import Arms, teaching_arm
from assistant.compiler.crossing import for_arm
from assistant.compiler.entering import with_entry
from assistant.compiler.folders import programs_in
from assistant.compiler.loading import (
    language_of,
    load,
    load_text,
    read_companions,
    read_pseudo,
    read_trees,
)
from assistant.compiler.seen_frames import with_located_frames
from assistant.program import pseudo
from assistant.sources.sights import NOTHING_SEEN, Seeing
from assistant.virtual.tasks import Group, Part, Programs, groups

if TYPE_CHECKING:
    from assistant.languages import Language, Tree
    from assistant.robots import Robot
    from assistant.sources.placements import DrawingPlacement

RUN_ALONE_ONLY: Final = error(
    "CO021", "`{name}` is run by itself, beside no other program", "name it alone"
)
MIXED_LANGUAGES: Final = error(
    "CO022",
    "`{name}` is written in {language}, `{first}` in {other}",
    "name programs of one language: one controller runs them",
)
OPTION_OF_SOURCES: Final = error(
    "CO023",
    "--{option} is for drawings, tables and pseudo-programs, `{name}` is a robot program",
    "leave it out",
)


def programs(
    named: Sequence[str],
    *,
    language: str | None = None,
    robot: Robot | None = None,
    process: str | FilePath | None = None,
    unit: str | None = None,
    entry: str | None = None,
    placement: DrawingPlacement | None = None,
    seeing: Seeing = NOTHING_SEEN,
) -> Programs:
    """What files and folders hold that run together on one controller.

    named: a drawing, table or pseudo-program; or robot programs of one language, or a folder with
    them. language: of robot programs, where neither suffix nor text tell. robot, process, unit,
    placement: see `load`, of other sources. entry: the procedure that a pseudo-program begins with.
    seeing: where its frames that are seen are taken from.
    Raises Unreadable or Refused.
    """
    title = ", ".join(named)
    folder = named[0] if is_folder(named[0]) else None
    if len(named) > 1:
        for name in named:
            if is_folder(name) or _is_source(name):
                raise Refused(RUN_ALONE_ONLY(path=name, name=name), exit_status=2)
    elif folder is None and _is_source(named[0], language):
        loaded = load(named[0], process=process, robot=robot, unit=unit, placement=placement)
        is_text = FilePath(named[0]).suffix.lower() == pseudo.SUFFIX
        program = with_entry(loaded.program, entry)
        text = read_pseudo(named[0]) if is_text else None
        program, sights = with_located_frames(
            program, Arms(robot, seeing=seeing.beside(loaded.seen))
        )
        found = (*loaded.findings, *sights)
        return _program_for_arm(Programs(title, program=program, text=text), found, robot)
    for option, value in (("process", process), ("unit", unit), ("place", placement)):
        if value is not None:
            raise Refused(
                OPTION_OF_SOURCES(path=named[0], option=option, name=named[0]), exit_status=2
            )
    files = list(programs_in(folder, language)) if folder else list(dict.fromkeys(named))
    spoken = _one_language(files, language)
    parts = [_run_part(spoken, group) for group in groups(spoken, files, folder)]
    missing = tuple(found for part in parts for found in spoken.missing(part.trees))
    return Programs(title, spoken, tuple(parts), findings=missing)


def programs_of_text(
    text: SourceText,
    *,
    language: str | None = None,
    robot: Robot | None = None,
    entry: str | None = None,
    seeing: Seeing = NOTHING_SEEN,
) -> Programs:
    """The same for a text that is no file: a robot language's if named, else pseudo text."""
    title = text.path or "standard input"
    if language is None:
        program = with_entry(load_text(text).program, entry)
        program, sights = with_located_frames(program, Arms(robot, seeing=seeing))
        return _program_for_arm(Programs(title, program=program, text=text), sights, robot)
    spoken = language_of(language)
    tree = spoken.parse(text)
    _refuse_errors([tree])
    (group,) = groups(spoken, [title], None)
    part = Part(group.name, (tree,), (title,))
    return Programs(title, spoken, (part,), findings=tuple(spoken.missing([tree])))


def _program_for_arm(
    made: Programs, findings: Sequence[Diagnostic], robot: Robot | None
) -> Programs:
    """A pseudo-program as another arm runs it than the one that it was taught on."""
    assert made.program is not None
    program = made.program
    if robot is None:
        return replace(made, findings=tuple(findings))
    program, changed = for_arm(program, teaching_arm(program, Arms(robot)), robot)
    if has_errors(changed):
        raise Refused(*(f.within(made.title) for f in changed if f.severity is Severity.ERROR))
    return replace(made, program=program, findings=(*findings, *changed))


def _is_source(name: str, language: str | None = None) -> bool:
    suffix = FilePath(name).suffix.lower()
    if language is not None:
        return False
    if suffix == pseudo.SUFFIX or suffix in sources.READERS:
        return True
    # What is no robot program is to be said as for any source that cannot be read.
    return not is_folder(name) and languages.of_file(name, read_bytes(name)) is None


def _one_language(files: Sequence[str], named: str | None) -> Language[Any]:
    """The language of all files; raises Refused if there are two."""
    first: tuple[str, Language[Any]] | None = None
    for file in files:
        spoken = language_of(named) if named else languages.of_file(file, read_bytes(file))
        if spoken is None:
            raise Refused(RUN_ALONE_ONLY(path=file, name=file), exit_status=2)
        if first is not None and spoken.family != first[1].family:
            raise Refused(
                MIXED_LANGUAGES(
                    path=file,
                    name=FilePath(file).name,
                    language=spoken.title,
                    first=FilePath(first[0]).name,
                    other=first[1].title,
                ),
                exit_status=2,
            )
        first = first or (file, spoken)
    assert first is not None
    return first[1]


def _run_part(spoken: Language[Any], group: Group) -> Part:
    """Raises Refused where one of the files has errors."""
    texts = [spoken.read(file) for file in group.files]
    folder = FilePath(group.files[0]).parent if group.beside else None
    trees = read_trees(spoken, texts, beside=folder)
    if folder is not None:
        known = {_tree_path(tree) for tree in trees}
        trees += [t for t in read_companions(spoken, trees, folder) if _tree_path(t) not in known]
    _refuse_errors(trees)
    names = tuple(_tree_path(tree).stem for tree in trees)
    return Part(group.name, tuple(trees), names, group.essential)


def _tree_path(tree: Tree) -> FilePath:
    return FilePath((tree.source.path if tree.source else None) or "")


def _refuse_errors(trees: Sequence[Tree]) -> None:
    found: list[Diagnostic] = [f for tree in trees for f in tree.findings]
    if has_errors(found):
        raise Refused(*(f for f in found if f.severity is Severity.ERROR))

"""Checker: the findings of sources and robot programs, several files of one program together.

`check_files` takes files and folders, `check_text` a text, `check_program` a program that is there
already.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import field, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant import checks, languages, sources
from assistant.base.budgets import internal_error, traceback_wanted
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error, fold, has_errors, info
from assistant.base.length_units import unit_stated
from assistant.base.source_text import SourceText, is_folder, read_bytes
from assistant.base.worker_processes import WorkerDied, pool_of
from assistant.compiler.arms import InCell, known_robot, open_cell, teaching_arm, with_robot_of_cell
from assistant.compiler.cell_defaults import with_values_beside
from assistant.compiler.cell_equipment import STATED_TEXT_NAME
from assistant.compiler.loader import (
    Loaded,
    files_in,
    language_of,
    load,
    missing_files,
    parse_pseudo,
    read_companions,
    read_pseudo,
    read_trees,
    with_process,
    with_project_settings,
)
from assistant.compiler.retarget import for_arm, with_chosen_turns
from assistant.compiler.seen_frames import with_seen_frames
from assistant.compiler.source_map import Places, at_its_line, at_moves
from assistant.compiler.travel import with_planned_travels
from assistant.compiler.work_locations import fold_unplaced_work, with_locations
from assistant.program import pseudo
from assistant.program.program import Program

if TYPE_CHECKING:
    from assistant.cell.scene import Scene
    from assistant.languages import Language
    from assistant.robots import Robot, SolvedProgram
    from assistant.sources.process.placement import DrawingPlacement


_NOTHING_THERE: Final = error(
    "CO301",
    "the folder holds nothing that is checked",
    "name the files: in a folder, {kinds} are looked for, tables of targets are not",
)
_LEFT_OUT: Final = info(
    "CO302",
    "the file is left out: it does not look like a robot program",
    "name it with --from LANGUAGE if it is one",
)
_PSEUDO_MARK: Final = "#"
CellFinder = Callable[[str], FilePath | None]
"""Returns the cell file with the values of undeclared names, by the path of a program."""
_FOLDER_SUFFIXES: Final = (pseudo.SUFFIX, ".dxf")
"""Files searched for in a folder beside programs; any folder may hold tables of other things."""


@dataclass(frozen=True, slots=True)
class CheckedText:
    """A text that was checked.

    mark: begins a comment in it. complete: the search for findings was complete, which is false if
    something could not be read.
    """

    source: SourceText
    mark: str
    complete: bool


@dataclass(frozen=True, slots=True, eq=False)
class CheckedProgram:
    """A program that was checked.

    files: the files of the program. arm: that runs it, with scene and solution, as far as they are
    known.
    """

    files: Sequence[str]
    program: Program
    places: Places
    arm: Robot | None = None
    scene: Scene | None = None
    solution: SolvedProgram | None = None


@dataclass(slots=True)
class Checked:
    """Results of a check.

    findings: in the order of the sources, those of rows and targets one by one. files: number of
    files checked. texts: of programs, by path. unreadable: something could not be read at all.
    paths: of the files, in their order. looked: the programs as checked, None if they are not
    requested.
    """

    findings: list[Diagnostic] = field(default_factory=list)
    files: int = 0
    texts: dict[str, CheckedText] = field(default_factory=dict)
    unreadable: bool = False
    paths: list[str] = field(default_factory=list)
    looked: list[CheckedProgram] | None = None


def check_files(
    paths: Sequence[str | FilePath],
    *,
    robot: str | None = None,
    process: str | FilePath | None = None,
    language: str | None = None,
    unit: str | None = None,
    placement: DrawingPlacement | None = None,
    cell: str | FilePath | InCell | None = None,
    values: CellFinder | None = None,
    keep: bool = False,
    jobs: int | None = None,
) -> Checked:
    """Check files and the contents of folders: robot programs, pseudo-programs and drawings.

    Modules that a controller loads together, as those of a folder in RAPID, are one program. robot:
    reach, limits and configurations are checked for it. process: process file, see `load`.
    language: of robot programs, if neither suffix nor text identifies it. unit: length unit of
    drawings. placement: of the drawings. cell: file of the cell that they run in, so that contacts
    with its bodies are checked; or the cell read from it, whose findings the caller reports.
    values: returns the cell file of a program with values of undeclared names, None for none.
    keep: store the programs in `looked`; then one process checks all. jobs: processes that share
    the work, None for one for each processor if there are more than 20 programs, else one. Raises
    Refused for an unknown robot or language, or for an invalid cell file.
    """
    named = None if language is None else language_of(language)
    stands = _opened_cell(cell, robot)
    checked = Checked([] if isinstance(cell, InCell) else list(stands.findings))
    checked.looked = [] if keep else None
    programs: dict[tuple[Language[Any] | None, FilePath], list[str]] = {}
    seen: set[FilePath] = set()
    for path in dict.fromkeys(map(str, paths)):
        for file in _files_to_check(path, named, checked):
            part = FilePath(file).absolute()
            if part in seen:
                continue
            seen.add(part)
            checked.files += 1
            checked.paths.append(file)
            with _collecting(checked, file):
                spoken = _language_of_file(file, named)
                part = spoken.program_of(part) if spoken else part
                programs.setdefault((spoken, part), []).append(file)
    given: list[_ProgramToCheck] = []
    for (spoken, _), files in programs.items():
        one = _ProgramToCheck(files, stands, process, unit, placement, keep)
        with _collecting(checked, one.where):
            if spoken is not None:
                stated = None if values is None else values(files[0])
                one = replace(one, language=spoken.name, values=stated)
            given.append(one)
    pool = None if keep else pool_of(len(given), jobs)
    for answer in pool.answers(_checked, given, _lost) if pool else map(_checked, given):
        checked.findings += answer.findings
        checked.texts |= answer.texts
        checked.unreadable |= answer.unreadable
        if checked.looked is not None:
            checked.looked += answer.looked or ()
    # a file that others call is looked at with each of them
    checked.findings = list(dict.fromkeys(checked.findings))
    return checked


@dataclass(frozen=True, slots=True)
class _ProgramToCheck:
    """A program, and what it is checked with; the fields are parameters of `check_files`.

    language: name, None for a drawing, a table or a pseudo-program. values: its cell file.
    """

    files: Sequence[str]
    stands: InCell
    process: str | FilePath | None
    unit: str | None
    placement: DrawingPlacement | None
    keep: bool
    language: str | None = None
    values: FilePath | None = None

    @property
    def where(self) -> str:
        return self.files[0] if len(self.files) == 1 else _folder_of(self.files)


def _checked(given: _ProgramToCheck) -> Checked:
    """The findings and texts of one program."""
    checked, files, where = Checked(looked=[] if given.keep else None), given.files, given.where
    with _collecting(checked, where):
        if given.placement is not None:
            from assistant.sources.process.placement import check_drawn

            check_drawn(FilePath(files[0]))
        process, stands, unit = given.process, given.stands, given.unit
        if given.language is not None:
            spoken = language_of(given.language)
            found = _check_program(spoken, files, stands, process, checked, given.values)
        else:
            found = _check_source(files[0], process, unit, given.placement, stands, checked)
        if unit is not None and FilePath(files[0]).suffix.lower() not in sources.READERS:
            found.append(unit_stated(where, unit))
        checked.findings += [f.within(where) for f in found]
    return checked


def _lost(given: _ProgramToCheck, died: WorkerDied) -> Checked:
    return Checked([died.finding(path=given.where)], unreadable=died.exit_status == 2)


def check_text(
    text: SourceText,
    *,
    robot: str | None = None,
    process: str | FilePath | None = None,
    language: str | None = None,
    unit: str | None = None,
    cell: str | FilePath | InCell | None = None,
    others: Sequence[SourceText] = (),
    beside: FilePath | None = None,
    keep: bool = False,
) -> Checked:
    """Check a text that is not a file: in a robot language if named, else pseudo text.

    others: of the same program. beside: folder of files that they call.
    """
    stands = _opened_cell(cell, robot)
    checked = Checked([] if isinstance(cell, InCell) else list(stands.findings), files=1)
    checked.looked = [] if keep else None
    checked.paths.append(text.path or "standard input")
    with _collecting(checked, text.path):
        if language is None:
            found = _check_pseudo(text, None, stands, process, checked)
        else:
            texts = [text, *others]
            found = _check_texts(language_of(language), texts, beside, stands, process, checked)
        if unit is not None:
            found.append(unit_stated(text.path or "standard input", unit))
        checked.findings += [f.within(text.path) for f in dict.fromkeys(found)]
    return checked


def check_program(
    program: Program, stands: InCell, text: SourceText | None = None
) -> tuple[Diagnostic, ...]:
    """The same for a program that has been read or made. text: that it was read of, if any."""
    places = Places(program, text)
    return fold(map(places.finding, _check_meaning(program, stands, places)))


def _opened_cell(cell: str | FilePath | InCell | None, robot: str | None) -> InCell:
    return cell if isinstance(cell, InCell) else open_cell(cell, robot)


def _folder_of(files: Sequence[str]) -> str:
    """The folder of a program's files as the user wrote it, whole if it was written in two ways."""
    if len({FilePath(file).is_absolute() for file in files}) > 1:
        files = [str(FilePath(file).absolute()) for file in files]
    return os.path.commonpath(files) or "."


@dataclass(slots=True)
class _collecting:  # noqa: N801 (used as a `with` word)
    """Turn refusals and failures inside into findings; other programs are checked as well."""

    checked: Checked
    path: str | None = None

    def __enter__(self) -> None: ...

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> bool:
        expected = isinstance(error, Refused | OSError) or traceback_wanted()
        if isinstance(error, Exception) and not expected:
            self.checked.findings.append(internal_error(error).within(self.path))
            self.checked.unreadable = True
            return True
        if not isinstance(error, Refused):
            return False
        self.checked.findings += [f.within(self.path) for f in error.findings]
        self.checked.unreadable |= error.exit_status == 2
        return True


def _files_to_check(path: str, named: Language[Any] | None, checked: Checked) -> Iterator[str]:
    """The file itself, or what a folder holds; hidden folders are left aside."""
    if not is_folder(path) or FilePath(path).suffix.lower() in sources.READERS:
        yield path
        return
    spoken = [named] if named else [languages.get(name) for name in languages.names()]
    suffixes = {suffix for language in spoken for suffix in language.suffixes}
    there = False
    for file in files_in(path, {*suffixes, *_FOLDER_SUFFIXES}):
        there = True
        with _collecting(checked, file):
            if (
                FilePath(file).suffix.lower() in _FOLDER_SUFFIXES
                or _language_of_file(file, named) is not None
            ):
                yield file
            else:
                checked.findings.append(_LEFT_OUT(path=file))
    if not there:
        kinds = " ".join(sorted({*suffixes, *_FOLDER_SUFFIXES}))
        checked.findings.append(_NOTHING_THERE(path=path, kinds=kinds))
        checked.unreadable = True


def _language_of_file(file: str, named: Language[Any] | None) -> Language[Any] | None:
    """The language of a file, None if it is no robot program."""
    suffix = FilePath(file).suffix.lower()
    if suffix == pseudo.SUFFIX or suffix in sources.READERS:
        return None
    return named or languages.of_file(file, read_bytes(file))


def _check_source(
    file: str,
    process: str | FilePath | None,
    unit: str | None,
    placement: DrawingPlacement | None,
    stands: InCell,
    checked: Checked,
) -> list[Diagnostic]:
    """Findings of a drawing, a table, or a `.pseudo` text."""
    path = FilePath(file)
    if path.suffix.lower() == pseudo.SUFFIX:
        return _check_pseudo(read_pseudo(path), path.parent, stands, process, checked)
    loaded = load(
        file,
        process=process,
        robot=stands.robot,
        unit=unit,
        around=stands.around,
        placement=placement,
    )
    stands = stands.beside(loaded.seen)
    meant = _check_meaning(loaded.program, stands, None, [file], checked)
    return [*loaded.findings, *meant]


def _check_pseudo(
    text: SourceText,
    tables: FilePath | None,
    stands: InCell,
    process: str | FilePath | None,
    checked: Checked,
) -> list[Diagnostic]:
    name = text.path or ""
    checked.texts[name] = CheckedText(text, _PSEUDO_MARK, complete=False)
    program = parse_pseudo(text, tables)
    checked.texts[name] = CheckedText(text, _PSEUDO_MARK, complete=True)
    loaded = _with_process(program, process)
    stands, places = stands.beside(loaded.seen), Places(program, text)
    meant = _check_meaning(loaded.program, stands, places, [name], checked)
    return [*loaded.findings, *(at_its_line(finding, text) for finding in meant)]


def _with_process(program: Program, process: str | FilePath | None) -> Loaded:
    loaded = Loaded(program)
    return loaded if process is None else with_process(loaded, process)


def _check_program(
    language: Language[Any],
    files: Sequence[str],
    stands: InCell,
    process: str | FilePath | None,
    checked: Checked,
    stated: FilePath | None,
) -> list[Diagnostic]:
    texts = [language.read(file) for file in files]
    beside = FilePath(files[0]).parent
    return _check_texts(language, texts, beside, stands, process, checked, stated)


def _check_texts(
    language: Language[Any],
    texts: Sequence[SourceText],
    beside: FilePath | None,
    stands: InCell,
    process: str | FilePath | None,
    checked: Checked,
    stated: FilePath | None = None,
) -> list[Diagnostic]:
    """Findings of a program; of a broken one those of its text, as it is not known what it does.

    stated: cell file with values of undeclared names.
    """
    trees = read_trees(language, texts, beside=beside)
    found = [finding for tree in trees for finding in tree.findings]
    found += () if beside is None else missing_files(language, trees)
    complete = not has_errors(found)
    for text in texts:
        checked.texts[text.path or ""] = CheckedText(text, language.comment_mark, complete)
    folder = FilePath(texts[0].path or "").absolute().parent
    beside_it = [] if beside is None else read_companions(language, trees, beside)
    # Companions are checked with the program, but their findings belong to other files.
    strangers = {tree.source.path for tree in beside_it}
    if complete and beside is not None and stated is not None:
        trees = with_values_beside(language, trees, texts[0].path or "", stated)
        strangers.add(STATED_TEXT_NAME)
    said = with_project_settings(language, folder).check([*trees, *beside_it])
    found += (finding for finding in said if finding.path not in strangers)
    if not complete:
        return found
    try:
        program = language.lift(trees, stands.robot)
    except Refused as refused:
        return [*found, *refused.findings]
    told = {finding.code for finding in found}
    loaded = _with_process(program, process)
    stands = stands.beside(loaded.seen)
    found += loaded.findings
    places = Places(loaded.program)
    meant = map(
        places.finding,
        _check_meaning(loaded.program, stands, places, [one.path or "" for one in texts], checked),
    )
    # Findings of the meaning that restate one of the text are left out.
    return [*found, *(f for f in meant if language.restated.get(f.code) not in told)]


def _check_meaning(
    program: Program,
    stands: InCell,
    places: Places | None = None,
    files: Sequence[str] = (),
    checked: Checked | None = None,
) -> tuple[Diagnostic, ...]:
    from assistant import robots

    arms = with_robot_of_cell(program, stands.arms())
    program, located = with_locations(program, arms)
    program, sights = with_seen_frames(program, arms)
    if has_errors(sights):
        return (*located, *sights, *checks.check(program))
    found = (*located, *sights, *checks.check(program))
    arm = arms.robot or known_robot(program.robot)
    if arm is None:
        _keep_checked(
            checked, CheckedProgram(files, program, places or Places(program), None, arms.scene)
        )
        return (*found, *with_planned_travels(program, None, arms.scene, Places(program)).findings)
    if program.origin is None:  # a controller takes the numbers of its own text as they stand
        program, changed = for_arm(program, teaching_arm(program, replace(arms, robot=arm)), arm)
        found += changed
    program, turned = with_chosen_turns(program, arm, arms.scene)
    found += turned
    places = Places(program) if places is None else places
    ways = with_planned_travels(program, arm, arms.scene, places)
    if has_errors(ways.findings):
        _keep_checked(checked, CheckedProgram(files, ways.program, places, arm, arms.scene))
        return (*found, *ways.findings)
    solution = robots.solve_program(ways.program, arm)
    _keep_checked(
        checked, CheckedProgram(files, solution.program, places, arm, arms.scene, solution)
    )
    solved = (*solution.findings, *checks.with_robot(solution, scene=arms.scene))
    told = fold_unplaced_work(program, arm, at_moves(solved, solution.program, places))
    return (*found, *ways.findings, *told)


def _keep_checked(checked: Checked | None, looked: CheckedProgram) -> None:
    if checked is not None and checked.looked is not None:
        checked.looked.append(looked)

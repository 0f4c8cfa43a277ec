"""Compares two programs, in one language or in two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final, Literal

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Refused, error
from assistant.base.source_text import is_folder, lines_of, read_bytes
from assistant.compiler.arms import Arms, robot_of
from assistant.compiler.filling import UNFILLED, with_values_of_file
from assistant.compiler.folders import programs_in
from assistant.compiler.loading import Loaded, with_process
from assistant.compiler.motion import ComparisonTerms, MotionProof, Proving, prove_motion
from assistant.compiler.motion_sides import ProgramPair, trees_in_cell, wire_names
from assistant.compiler.opening import load
from assistant.compiler.pairing import pair_names, read_names
from assistant.compiler.source_map import Place, Places
from assistant.compiler.statement_pairs import StatementRow, statement_rows
from assistant.compiler.tasks import Task, load_task, tasks_of
from assistant.sources.cell import wanted_in_words

if TYPE_CHECKING:
    from assistant.robots import Robot

PROGRAMS_DIFFER: Final = error(
    "CO118",
    "`{written}` does something else than `{source}`, with {inputs}: {what}",
    "see both lines; one of them is to be changed, unless the difference is meant",
)
NOT_COMPARED: Final = error(
    "CO119",
    "the programs cannot be compared: {reason}",
    "state in a cell file what no text declares, or add `--text`: it pairs the statements and runs "
    "nothing",
)
NOTHING_TO_COMPARE: Final = error(
    "CO123",
    "there is nothing to compare: in {runs} runs neither program moved or changed anything",
    "see what both wait for, and where they begin",
)
TOO_MANY_PROCESS_FILES: Final = error(
    "CO125",
    "there are {count} process files for two programs",
    "give one for the first program, or one for each",
)
MOST_DIFFERENCES: Final = 5
"""Differences to report; later ones mostly follow from the first."""
COMPARISON_TERMS: Final = ComparisonTerms(
    PROGRAMS_DIFFER, NOT_COMPARED, MOST_DIFFERENCES, typed=True
)

ComparisonAnswer = Literal["equal", "different", "not compared"]


@dataclass(frozen=True, slots=True)
class Difference:
    """A difference between two programs. inputs: the input values that show it.

    places: the statement of each program, None if no statement does it. behind: the condition that
    each program decided last before it, None without one.
    """

    what: str
    inputs: str
    places: tuple[Place | None, Place | None] = (None, None)
    behind: tuple[Place | None, Place | None] = (None, None)


@dataclass(frozen=True, slots=True)
class Comparison:
    """The result of a comparison. names: both programs. programs: the same, as they were read.

    pairs: the second program's names of signals and data, by the first program's names. rows: the
    statements in pairs, if the programs were not run. arm: of the second program.
    """

    names: tuple[str, str]
    motion: MotionProof
    differences: tuple[Difference, ...] = ()
    findings: tuple[Diagnostic, ...] = ()
    pairs: Mapping[str, str] = field(default_factory=dict)
    rows: tuple[StatementRow, ...] = ()
    programs: tuple[Loaded, ...] = ()
    arm: Robot | None = None

    @property
    def answer(self) -> ComparisonAnswer:
        if self.differences or not all(row.alike for row in self.rows):
            return "different"
        if self.rows:
            return "equal"
        return "equal" if self.motion.holds and not self.motion.empty else "not compared"

    @property
    def equal(self) -> bool:
        return self.answer == "equal"

    @property
    def exit_status(self) -> int:
        """The exit status of the command: 0 equal, 1 different, 2 not compared."""
        return {"equal": 0, "different": 1, "not compared": 2}[self.answer]

    def located_findings(self) -> list[Diagnostic]:
        """The findings, each difference at its line in the second program, else in the first."""
        found = [one for one in self.findings if one.code != PROGRAMS_DIFFER.code]
        for one in self.differences:
            finding = PROGRAMS_DIFFER(
                written=self.names[1], source=self.names[0], inputs=one.inputs, what=one.what
            )
            place = one.places[1] or one.places[0]
            if place is not None:
                finding = replace(finding, path=place.path, line=place.line)
            found.append(finding)
        return found

    def line(self) -> str:
        """The result in one line for people."""
        if self.rows:
            alike = sum(row.alike for row in self.rows)
            return f"{alike} of {len(self.rows)} statements say the same: {self.answer}"
        if self.motion.found is None:
            return self.answer
        return f"{self.motion.compared()}: {self.answer}{self.motion.left_out()}"


@dataclass(frozen=True, slots=True)
class ComparedPart:
    """A program in a file or folder. name: shown to people. task: its files, None for one path."""

    name: str
    task: Task | None = None

    def program(self, robot: str | Robot | None) -> str | Loaded:
        """The argument for `compare`. robot: the arm that the program was written for."""
        if self.task is None or len(self.task.files) == 1:
            return self.task.files[0] if self.task is not None else self.name
        return load_task(self.task, robot=robot_of(robot))


@dataclass(frozen=True, slots=True)
class Counterparts:
    """Pairs of programs. lone: programs without a counterpart, each with the other path."""

    both: tuple[tuple[ComparedPart, ComparedPart], ...]
    lone: tuple[tuple[str, str], ...] = ()


def counterparts(first: str, second: str, language: str | None = None) -> Counterparts:
    """Pairs the programs of two files or folders, by name if a folder holds several.

    language: of files whose names do not tell. Raises Unreadable or Refused.
    """
    own, others = _compared_parts(first, language), _compared_parts(second, language)
    if len(own) == len(others) == 1:
        return Counterparts(((own[0], others[0]),))
    by_name = {_part_key(part): part for part in others}
    both = [(part, by_name[_part_key(part)]) for part in own if _part_key(part) in by_name]
    known = {_part_key(part) for part in own}
    lone = [(part.name, second) for part in own if _part_key(part) not in by_name]
    lone += [(part.name, first) for part in others if _part_key(part) not in known]
    return Counterparts(tuple(both), tuple(lone))


def _compared_parts(path: str, language: str | None) -> list[ComparedPart]:
    if not is_folder(path):
        return [ComparedPart(path)]
    return [
        ComparedPart(task.name, task)
        for task in tasks_of(list(programs_in(path, language)), language)
    ]


def _part_key(part: ComparedPart) -> str:
    return FilePath(part.name).stem.lower()


def compare(
    first: str | FilePath | Loaded,
    second: str | FilePath | Loaded,
    *,
    robot: str | Robot | None = None,
    from_robot: str | Robot | None = None,
    process: str | FilePath | Sequence[str | FilePath] | None = None,
    cell: str | FilePath | None = None,
    names: str | FilePath | Mapping[str, str | int] | None = None,
    language: str | None = None,
    entry: str | None = None,
    proving: Proving | None = None,
    text: bool = False,
) -> Comparison:
    """Runs two programs in the interpreters of their languages and compares what they do.

    first, second: files, or folders with one program each; drawings, tables and pseudo-programs
    run as they are. robot: the arm of the second program. from_robot: the arm of the first.
    process: process file of the first program, or one for each. cell: cell file with the data that
    neither program declares. names: the second program's names of signals and data, by the first
    program's names, or a file with them, see `pairing`. language: for files whose names do not tell
    it. entry: the procedure where the first program begins, if not `main`. text: pair the
    statements instead, without running them.
    Raises Unreadable or Refused for what cannot be read at all.
    """
    arms = Arms(robot_of(robot), robot_of(from_robot))
    files = [process] if process is None or isinstance(process, str | FilePath) else process
    if len(files) > 2:
        raise Refused(TOO_MANY_PROCESS_FILES(count=len(files)), exit_status=2)
    own, others = (*files, None, None)[:2]
    one = _load_part(first, own, cell, arms.written_for, language)
    other = _load_part(second, others, cell, arms.robot, language)
    titles = _program_title(first, one), _program_title(second, other)
    lacking = tuple(
        UNFILLED(what=wanted_in_words(w), place=w.name) for w in (*one.wanting, *other.wanting)
    )
    if names is None or isinstance(names, Mapping):
        stated = {own: str(other) for own, other in (names or {}).items()}
    else:
        stated = read_names(names)
    pairs = pair_names(one.program, other.program, stated)
    told = (*one.findings, *other.findings, *pairs.findings, *lacking)
    done = Comparison(
        titles,
        MotionProof(None),
        findings=told,
        pairs=pairs.names,
        programs=(one, other),
        arm=arms.robot,
    )
    if text:
        return replace(done, rows=paired_statements(done))
    trees, left = trees_in_cell(other.program)
    if left:
        reason = f"`{titles[1]}` does not declare {', '.join(f'`{name}`' for name in left)}"
        return replace(done, findings=(*told, NOT_COMPARED(reason=reason)))
    pair = ProgramPair(one.program, other.program, other.language, trees, pairs.names)
    motion = prove_motion(pair, arms, proving or Proving(), entry, COMPARISON_TERMS)
    if motion.holds and motion.empty and motion.found is not None:
        motion = replace(
            motion, findings=(*motion.findings, NOTHING_TO_COMPARE(runs=motion.found.runs))
        )
    texts = {**_lines_by_path(one), **_lines_by_path(other)}
    found, wires = motion.found, wire_names(pair)
    place = partial(_place_in_texts, texts)
    differences = []
    for difference in found.differences if found is not None else ():
        first_place, second_place = map(place, difference.unlike.places)
        one_behind, other_behind = (
            None if branch is None else place((branch.file, branch.line))
            for branch in difference.behind
        )
        differences.append(
            Difference(
                str(difference.unlike),
                difference.scenario.said(wires),
                (first_place, second_place),
                (one_behind, other_behind),
            )
        )
    return replace(
        done,
        motion=motion,
        differences=tuple(differences),
        findings=(*told, *motion.findings),
    )


def paired_statements(done: Comparison) -> tuple[StatementRow, ...]:
    """Pair the statements of both programs without running them."""
    one, other = done.programs
    both = ProgramPair(one.program, other.program, other.language, (), done.pairs)
    places = (Places(loaded.program, loaded.text) for loaded in done.programs)
    return tuple(statement_rows(both, *places))


def _load_part(
    program: str | FilePath | Loaded,
    process: str | FilePath | None,
    cell: str | FilePath | None,
    robot: Robot | None,
    language: str | None,
) -> Loaded:
    if isinstance(program, Loaded):
        loaded = program if process is None else with_process(program, process)
    else:
        tells = is_folder(program) or languages.of_file(FilePath(program), read_bytes(program))
        spoken = None if tells else language
        loaded = load(program, process=process, robot=robot, language=spoken)
    return loaded if cell is None else with_values_of_file(loaded, cell, taught=robot is not None)


def _program_title(given: str | FilePath | Loaded, loaded: Loaded) -> str:
    return loaded.program.name if isinstance(given, Loaded) else str(given)


def _lines_by_path(loaded: Loaded) -> dict[str, list[str]]:
    """Lines of the files of a program, by the paths that places have."""
    origin = loaded.program.origin
    sources = [tree.source for tree in origin.trees] if origin is not None else [loaded.text]
    return {one.path or "": lines_of(one.text) for one in sources if one is not None}


def _place_in_texts(
    texts: Mapping[str, Sequence[str]], place: tuple[str, int] | None
) -> Place | None:
    if place is None:
        return None
    path, line = place
    lines = texts.get(path, ())
    return Place(path, line, lines[line - 1].strip() if 0 < line <= len(lines) else "")

"""Comparison of two programs, in one language or in two: by running them, or by statements.

Signals and data are paired if they have the same name or number (from headers, process files and
cell files), or if the user states the pair. The rest is paired in order of use, if both programs
have as many of that kind.

    [names]                       # name in the first program = name in the second
    diPart = 4                    # the number of a signal, or
    doGrip = "doGripper"          # its name
    nTotal = "MTOTAL"             # data that outlives a run

Statements are paired without running: both programs are printed as pseudo-program text in which
positions are numbers, tools and frames are poses, paired signals have one name, and data is
numbered in order of use. Names and vendor words make no difference; order and structure do.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from difflib import SequenceMatcher
from functools import partial
from itertools import zip_longest
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final, Literal

from assistant import languages
from assistant.base.budgets import SETTINGS_FILE
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error, has_errors, info
from assistant.base.source_text import decode, is_folder, lines_of, read_bytes
from assistant.compiler.arms import Arms, robot_of
from assistant.compiler.cell_defaults import UNFILLED, with_values_of_file
from assistant.compiler.loader import Loaded, with_process
from assistant.compiler.motion_proof import (
    ComparisonTerms,
    MotionProof,
    ProgramPair,
    Proving,
    prove_motion,
    trees_in_cell,
    wire_names,
)
from assistant.compiler.program_files import Task, load, load_task, programs_in, tasks_of
from assistant.compiler.source_map import Place, Places
from assistant.program import expressions as e
from assistant.program import settings_tables
from assistant.program import statements as p
from assistant.program.geometry import BASE, FLANGE, Pose, Target
from assistant.program.program import Procedure, Program, walk
from assistant.program.pseudo.printer import block_text
from assistant.program.pseudo.statements import statement_text
from assistant.program.rewriting import head, rewrite
from assistant.program.settings_tables import ENCODINGS, Wrong, read_toml
from assistant.program.statement_index import names_in_procedures, records_in_procedures
from assistant.sources.cell_values import wanted_in_words

if TYPE_CHECKING:
    from assistant.robots import Robot


_SIGNAL_WITHOUT_PAIR: Final = error(
    "CO120",
    "nothing says which {kind} of the second program is `{name}`: it has {others}",
    "write in a file for --names what it is there",
)
_PAIRED_BY_ORDER: Final = info(
    "CO121",
    "`{name}` is taken for `{other}`, as each is the {kind} with number {number} in its program",
    "say with --names what it is, if that is wrong",
)
_PAIR_UNKNOWN: Final = error(
    "CO122",
    "there is no signal and no data `{name}` in the {which} program",
    "write a name that it has",
)


@dataclass(frozen=True, slots=True)
class _PairedNames:
    """names: the second program's names by the first program's names, in lower case."""

    names: Mapping[str, str]
    findings: tuple[Diagnostic, ...] = ()


def read_names(path: str | FilePath) -> dict[str, str]:
    """The names of a file; raises Unreadable or Refused."""
    data = read_bytes(path, most=SETTINGS_FILE)
    whole = read_toml(decode(data, str(path), ENCODINGS))
    whole.read({"names": lambda value: value})
    table = whole.table("names")
    found = table.read(dict.fromkeys(table.content, _read_name))
    if has_errors(whole.page.findings):
        raise Refused(*whole.page.findings, exit_status=2)
    return found


def _read_name(value: Any) -> str:
    if isinstance(value, int) and not isinstance(value, bool) and value >= 0:
        return str(value)
    name: str = settings_tables.text(value).strip()
    if not name:
        raise Wrong("is empty", "write a name, or the number of a signal")
    return name


def _pair_names(first: Program, second: Program, stated: Mapping[str, str]) -> _PairedNames:
    """Pairs the signals and data of two programs.

    stated: pairs of the user. Raises Refused (exit status 2) if signals cannot be paired.
    """
    names = {own.lower(): other.lower() for own, other in stated.items()}
    findings = list(_unknown_names(first, second, stated))
    mine = _unpaired_signals(first, second, {*names})
    theirs = _unpaired_signals(second, first, {*names.values()})
    for kind in mine:
        own, other = mine[kind], theirs.get(kind, [])
        if _numbers_of(first, own) and _numbers_of(second, other):  # these are other signals
            continue
        if len(own) == len(other):
            for place, pair in enumerate(zip(own, other, strict=True), 1):
                names[pair[0].lower()] = pair[1].lower()
                findings.append(
                    _PAIRED_BY_ORDER(name=pair[0], other=pair[1], kind=kind, number=place)
                )
        elif other:
            listed = ", ".join(f"`{name}`" for name in other)
            findings.append(_SIGNAL_WITHOUT_PAIR(name=own[0], kind=kind, others=listed))
    if has_errors(findings):
        raise Refused(*findings, exit_status=2)
    return _PairedNames(names, tuple(findings))


def _unknown_names(
    first: Program, second: Program, stated: Mapping[str, str]
) -> Iterator[Diagnostic]:
    """A finding for each stated name that a program does not have."""
    for own, other in stated.items():
        for name, program, which in ((own, first, "first"), (other, second, "second")):
            if not name.isdecimal() and name.lower() not in _data_names(program):
                yield _PAIR_UNKNOWN(name=name, which=which)


def _data_names(program: Program) -> set[str]:
    return {
        name.lower()
        for name in (*program.signals, *program.variables, *names_in_procedures(program))
    }


def _unpaired_signals(program: Program, other: Program, stated: set[str]) -> dict[str, list[str]]:
    """By their kinds the signals that only one program has, in the order in which it uses them.

    A number that the other program does not use is a number all the same, and says which signal it
    is; a signal without one may be any that is left.
    """
    known = {name.lower() for name in other.signals} | stated
    numbers = {signal.number for signal in other.signals.values()} - {None}
    used = dict.fromkeys(name.lower() for name in _signals_used(program))
    order = {name: place for place, name in enumerate(used)}
    found: dict[str, list[str]] = {}
    for name in sorted(program.signals, key=lambda one: order.get(one.lower(), len(order))):
        signal = program.signals[name]
        if name.lower() in known or signal.number in numbers or str(signal.number) in stated:
            continue
        found.setdefault(f"{signal.kind} {signal.direction}", []).append(name)
    return found


def _numbers_of(program: Program, names: list[str]) -> bool:
    return all(program.signals[name].number is not None for name in names)


def _signals_used(program: Program) -> Iterator[str]:
    """Names of signals, in order of the text."""
    used: Iterator[Any] = records_in_procedures(
        program, p.WaitSignal, p.SetSignal, p.Trigger, e.Name
    )
    for part in used:
        yield part.name if isinstance(part, e.Name) else part.signal


_STATEMENTS_LEFT_OUT: Final = (p.Comment, p.Label)
_NUMBER_TEXT: Final = re.compile(r"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_CLOSE_NUMBERS: Final = 0.02
"""Mm and degrees that numbers may be apart, as typed with two decimals."""
_CLOSE_SMALL_NUMBERS: Final = 5e-4
"""The same of numbers up to 1, as the parts of a quaternion are."""


@dataclass(frozen=True, slots=True)
class StatementRow:
    """A pair of statements, None where a program has no counterpart. alike: both say the same."""

    first: Place | None
    second: Place | None
    alike: bool


_PrintedStatement = tuple[str, Any]
"""A statement with its local names replaced, and its span."""


def _statement_rows(pair: ProgramPair, first: Places, second: Places) -> Iterator[StatementRow]:
    """Yield the pairs in order. first, second: where the texts of the programs are."""
    own, others = (
        list(_NamelessPrinter(program, pair, is_second).all())
        for program, is_second in ((pair.first, False), (pair.second, True))
    )
    for one, other in _paired_rows(own, others):
        alike = one is not None and other is not None and _are_alike(one[0], other[0])
        yield StatementRow(_statement_place(one, first), _statement_place(other, second), alike)


def _paired_rows(
    own: list[_PrintedStatement], others: list[_PrintedStatement], *, by_numbers: bool = True
) -> Iterator[tuple[_PrintedStatement | None, _PrintedStatement | None]]:
    """Those that say the same; between them those of the same words, whatever the numbers."""
    mine, theirs = (
        [text if by_numbers else _NUMBER_TEXT.sub("#", text) for text, _ in told]
        for told in (own, others)
    )
    # With autojunk, statements that are frequent in long programs would not be matched.
    for what, a, b, c, d in SequenceMatcher(None, mine, theirs, autojunk=False).get_opcodes():
        if what == "equal":
            yield from zip(own[a:b], others[c:d], strict=True)
        elif what == "replace" and by_numbers:
            yield from _paired_rows(own[a:b], others[c:d], by_numbers=False)
        else:
            yield from zip_longest(own[a:b], others[c:d])


def _statement_place(told: _PrintedStatement | None, places: Places) -> Place | None:
    found = None if told is None or told[1] is None else places.of(told[1])
    return None if found is None else replace(found, text=found.text.strip())


def _are_alike(one: str, other: str) -> bool:
    """True if two statements have the same words, and numbers that are close."""
    if _NUMBER_TEXT.sub("#", one) != _NUMBER_TEXT.sub("#", other):
        return False
    numbers = zip(_NUMBER_TEXT.findall(one), _NUMBER_TEXT.findall(other), strict=True)
    return all(_are_close(float(a), float(b)) for a, b in numbers)


def _are_close(one: float, other: float) -> bool:
    return abs(one - other) <= (
        _CLOSE_SMALL_NUMBERS if max(abs(one), abs(other)) <= 1.0 else _CLOSE_NUMBERS
    )


@dataclass
class _NamelessPrinter:
    """Prints the statements of a program without its own names."""

    program: Program
    pair: ProgramPair
    is_second: bool
    data: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.signals = {
            name.lower(): str(one.number)
            for name, one in self.pair.signals.items()
            if one.number is not None
        }
        self.own_name = {other: own for own, other in self.pair.names.items()}
        known = (self.pair.first.variables, self.pair.second.variables)
        self.common = set.intersection(*({name.lower() for name in names} for names in known))
        self.places = {name.lower(): one for name, one in self.program.targets.items()}
        self.joints = {name.lower(): one for name, one in self.program.joint_targets.items()}
        self.speeds = {name.lower(): one for name, one in self.program.speeds.items()}
        self.blends = {name.lower(): one for name, one in self.program.blends.items()}

    def all(self) -> Iterator[tuple[str, Any]]:
        for at, procedure in enumerate(self._in_order()):
            if at:
                yield "procedure", procedure.span
            for statement in walk(procedure.body):
                if not isinstance(statement, _STATEMENTS_LEFT_OUT):
                    yield self._text(statement), statement.span

    def _in_order(self) -> Sequence[Procedure]:
        """The procedure that begins, then the others as they are called."""
        entry = self.program.procedure(self.program.entry) if self.program.entry else None
        calls = [one.procedure.lower() for one in records_in_procedures(self.program, p.Call)]
        order = {name: at for at, name in enumerate(dict.fromkeys(calls))}
        others = [one for one in self.program.procedures if one is not entry]
        others.sort(key=lambda one: order.get(one.name.lower(), len(order)))
        return [entry, *others] if entry is not None else others

    def _text(self, statement: Any) -> str:
        plain = rewrite(head(statement), self._plain)
        text = statement_text(plain)
        return block_text(plain) if text is None else text

    def _plain(self, part: Any) -> Any:
        match part:
            case e.Name(name):
                return self._value(name)
            case p.WaitSignal() | p.SetSignal() | p.Trigger():
                return replace(part, signal=self._signal(part.signal))
            case p.Call():
                return replace(part, procedure="called")
            case p.Motion():
                return self._motion(part)
            case p.Move("joint", motion=motion):
                return replace(part, motion=replace(motion, speed=_NO_SPEED))
            case Target(pose):
                return Target(_rounded_pose(pose))
            case p.For(variable):
                return replace(part, variable=self._data(variable))
        return part

    def _value(self, name: str) -> e.Expression:
        low = name.lower()
        if low in self.places:
            return e.TargetValue(Target(_rounded_pose(self.places[low].pose)))
        if low in self.joints:
            return e.JointValue(self.joints[low])
        if low in self.signals or low in (one.lower() for one in self.program.signals):
            return e.Name(self._signal(name))
        return e.Name(self._data(name))

    def _signal(self, name: str) -> str:
        low = name.lower()
        number = self.signals.get(low)
        shown = self.own_name.get(low, low) if self.is_second else low
        return f"signal_{shown if number is None else number}"

    def _data(self, name: str) -> str:
        low = self.own_name.get(name.lower(), name.lower()) if self.is_second else name.lower()
        if low in self.common or low in self.pair.names:
            return f"data_{low}"
        return self.data.setdefault(low, f"data_{len(self.data) + 1}")

    def _motion(self, motion: p.Motion) -> p.Motion:
        speed, blend = motion.speed, motion.blend
        if isinstance(speed, e.Name):
            speed = self.speeds.get(speed.name.lower(), speed)
        if isinstance(blend, e.Name):
            blend = self.blends.get(blend.name.lower(), blend)
        tool = self.program.tools.get(motion.tool)
        frame = self.program.frames.get(motion.frame)
        return p.Motion(
            speed,
            blend,
            motion.tool if tool is None else _pose_name(FLANGE, tool.tip),
            motion.frame if frame is None else _pose_name(BASE, frame.pose),
        )


_NO_SPEED: Final = e.Name("speed")
"""Speed of joint moves, which are percentages of the arm's speed."""


def _pose_name(word: str, pose: Pose) -> str:
    """A name for what stands at a place."""
    numbers = [*pose.position, *_positive_quaternion(pose)]
    shown = "_".join(f"{value:.1f}" for value in numbers).replace("-", "m").replace(".", "p")
    return word if pose == Pose() else f"{word}_{shown}"


def _rounded_pose(pose: Pose) -> Pose:
    # Adding 0.0 turns -0.0, which is printed with a sign, into 0.0.
    x, y, z = (round(value, 2) + 0.0 for value in pose.position)
    w, a, b, c = (round(value, 4) + 0.0 for value in _positive_quaternion(pose))
    return Pose((x, y, z), (w, a, b, c))


def _positive_quaternion(pose: Pose) -> tuple[float, ...]:
    """The quaternion of two whose largest part is positive."""
    largest = max(pose.quaternion, key=abs)
    return tuple(value if largest > 0.0 else -value for value in pose.quaternion)


PROGRAMS_DIFFER: Final = error(
    "CO118",
    "`{written}` does something else than `{source}`, with {inputs}: {what}",
    "see both lines; one of them is to be changed, unless the difference is meant",
)
_NOT_COMPARED: Final = error(
    "CO119",
    "the programs cannot be compared: {reason}",
    "state in a cell file what no text declares, or add `--text`: it pairs the statements and runs "
    "nothing",
)
_NOTHING_TO_COMPARE: Final = error(
    "CO123",
    "there is nothing to compare: in {runs} runs neither program moved or changed anything",
    "see what both wait for, and where they begin",
)
_TOO_MANY_PROCESS_FILES: Final = error(
    "CO125",
    "there are {count} process files for two programs",
    "give one for the first program, or one for each",
)
_MOST_DIFFERENCES: Final = 5
"""Differences to report; later ones mostly follow from the first."""
_COMPARISON_TERMS: Final = ComparisonTerms(
    PROGRAMS_DIFFER, _NOT_COMPARED, _MOST_DIFFERENCES, typed=True
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
        raise Refused(_TOO_MANY_PROCESS_FILES(count=len(files)), exit_status=2)
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
    pairs = _pair_names(one.program, other.program, stated)
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
        return replace(done, findings=(*told, _NOT_COMPARED(reason=reason)))
    pair = ProgramPair(one.program, other.program, other.language, trees, pairs.names)
    motion = prove_motion(pair, arms, proving or Proving(), entry, _COMPARISON_TERMS)
    if motion.holds and motion.empty and motion.found is not None:
        motion = replace(
            motion, findings=(*motion.findings, _NOTHING_TO_COMPARE(runs=motion.found.runs))
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
    return tuple(_statement_rows(both, *places))


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
    return (
        loaded
        if cell is None
        else with_values_of_file(loaded, cell, taught=None if robot is None else robot.name)
    )


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

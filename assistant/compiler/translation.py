"""Translation: a vendor program in another language, with a report on each of its statements.

`_add_losses` adds to the report what is not translated although nothing is wrong with it:
statements inside of statements or procedures that are not translated, and calls of such
procedures.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import field, replace
from functools import partial
from itertools import chain
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias, overload

import numpy as np

from assistant.base.arrays import Rows
from assistant.base.budgets import DRAFTING, REPORTING, within, without_gc
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import (
    Declared,
    Diagnostic,
    PathRow,
    ProgramTable,
    Refused,
    Severity,
    Span,
    Subject,
    error,
    fold,
    has_errors,
    warning,
)
from assistant.base.source_text import lines_of
from assistant.compiler.arms import (
    Arms,
    arms_of_loaded,
    known_robot,
    open_cell,
    robot_of,
    stated_arm_findings,
    with_robot_of_cell,
)
from assistant.compiler.cell_defaults import (
    UNFILLED,
    UNPROVEN,
    marked_as_draft,
    with_joint_speed_wanted,
    with_values_of_file,
)
from assistant.compiler.cell_equipment import STATED_TEXT_NAME
from assistant.compiler.compilation import (
    Compiled,
    compile_program,
    lowered_for_language,
    proven_by_motion,
)
from assistant.compiler.drafts import draft_program as drafted
from assistant.compiler.loader import Loaded, beginnings, language_of, with_entry
from assistant.compiler.merge_edits.last_output import write_unedited
from assistant.compiler.motion_proof import MotionProof, Proving
from assistant.compiler.program_files import load
from assistant.compiler.program_names import without_names
from assistant.compiler.read_back_proof import Proof
from assistant.compiler.seen_frames import with_located_frames
from assistant.compiler.source_map import Place, Places, Trace
from assistant.compiler.style import style_beside
from assistant.compiler.uncalled_routines import NOT_CALLED, is_uncalled
from assistant.lazy import pictured
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import along_calls
from assistant.program.program import Program, bodies, walk
from assistant.program.rewriting import head, records
from assistant.robots.findings import NOT_KNOWN
from assistant.sources.cell_values import wanted_in_words
from assistant.sources.sights import NOTHING_SEEN, Seeing

if TYPE_CHECKING:
    from assistant.languages import Language
    from assistant.languages.language_types import Frames, Sampling
    from assistant.program.undeclared_names import Wanted
    from assistant.robots import Robot


_CALLS_PARTLY_TRANSLATED = warning(
    "CO013",
    "`{name}` is called, and not all that it does is said",
    "see to its statements; the call itself is said",
)
_CALLS_NOT_TRANSLATED = error(
    "CO014", "`{name}` is called, which is not said", "see to that procedure first"
)


def _add_losses(program: Program, found: Mapping[Span, list[Diagnostic]]) -> None:
    """Add the losses caused by other parts to the findings about a program's parts, by their spans.

    Parts inside an untranslated part are untranslated for the same reasons; calls of it are
    reported.
    """
    wrong: set[Span | None] = {span for span, told in found.items() if has_errors(told)}
    if not wrong:
        return
    # Inner parts first: calls are judged with them among the lost ones.
    for span, holder in _losses_inside(program, wrong).items():
        if span in found and span not in wrong:
            found[span].extend(f for f in found[holder] if f.severity is Severity.ERROR)
            wrong.add(span)
    for span, finding in _losses_by_calls(program, wrong):
        if span in found:
            found[span].append(finding)


def _losses_inside(program: Program, wrong: Set[Span | None]) -> dict[Span, Span]:
    """Map spans inside untranslated procedures and statements to the span that contains them.

    wrong: the spans of untranslated parts.
    """
    found: dict[Span, Span] = {}
    for procedure in program.procedures:
        whole = procedure.span if procedure.span in wrong else None
        for statement in walk(procedure.body):
            span = statement.span
            if span is not None and whole is not None:
                found.setdefault(span, whole)
            elif span is not None and span in wrong:
                for inner in (one for body in bodies(statement) for one in walk(body)):
                    if inner.span is not None:
                        found.setdefault(inner.span, span)
    return found


def _losses_by_calls(
    program: Program, wrong: Set[Span | None]
) -> Iterator[tuple[Span, Diagnostic]]:
    """Yield calls of untranslated or partly translated procedures: spans of their statements, and
    findings.

    wrong: the spans of untranslated parts, and of the parts inside them.
    """
    named = {q.name.lower(): q for q in program.procedures}
    gone = {key for key, q in named.items() if q.span in wrong}
    lacking = {
        key: frozenset({key} if any(one.span in wrong for one in (q, *walk(q.body))) else ())
        for key, q in named.items()
    }
    lacks = along_calls(program, lacking)
    for procedure in program.procedures:
        for statement in walk(procedure.body):
            span = statement.span
            if span is None or span in wrong:
                continue
            for name in dict.fromkeys(_names_called(statement)):
                if lacks.get(name):
                    rule = _CALLS_NOT_TRANSLATED if name in gone else _CALLS_PARTLY_TRANSLATED
                    yield span, rule(span=span, name=named[name].name)


def _names_called(statement: p.Statement) -> Iterator[str]:
    """The procedures and functions that a statement itself calls, in lower case."""
    for part in records(head(statement)):
        match part:
            case p.Call(procedure=name) | e.Apply(function=name):
                yield name.lower()


_NO_PROGRAM = error(
    "CO005",
    "`{name}` is no program in a robot language",
    "compile it: `robot-assistant compile`",
)

_NOT_RUN = warning(
    "CO016",
    "the proof by motion was not run, because the program is {what}",
    "see to what is not translated, then prove it",
)

_NO_ARM: Final = warning(
    "CO017",
    "no arm is named: nothing checked whether {moves} of its reach and within its limits, and arm "
    "configurations are written as they were stated for another arm, or as a guess",
    "name the arm that will run it with --robot",
)


def _unnamed_arm(program: Program, target: Language[Any], arms: Arms) -> Iterator[Diagnostic]:
    """Report that no arm is named, for a program that moves to poses and leaves its maker.

    A program in another dialect of the same language keeps its targets as they are.
    """
    origin = program.origin
    if (arms.robot or known_robot(program.robot)) is not None or origin is None:
        return
    if language_of(origin.language).family == target.family:
        return
    moves = sum(
        len(one.path) if isinstance(one, p.Follow) else 1
        for one in program.statements()
        if isinstance(one, p.Move | p.MoveCircular | p.Follow)
    )
    if moves:
        yield _NO_ARM(moves="the 1 move is" if moves == 1 else f"the {moves:,} moves are")


Level = Literal["supported", "partial", "not"]
LEVELS: Final[tuple[Level, ...]] = ("supported", "partial", "not")
_LONGEST_TEXT: Final = 100
"""Characters of a statement that a row shows."""


@dataclass(frozen=True, slots=True)
class ReportRow:
    """Translation result of one statement or declaration of the source.

    text: its first line. count: number of statements that it represents. reasons: why it is not
    translated unchanged, errors first. went: its positions in the written files.
    """

    place: Place
    text: str
    level: Level
    reasons: tuple[Diagnostic, ...] = ()
    went: tuple[Place, ...] = ()
    count: int = 1


@dataclass(frozen=True, slots=True)
class Translation:
    """A translated program. files: to write, empty if a statement is not translated.

    compiled: the complete program. written: the program in the files, complete or a draft, with
    stops for untranslated statements. rows: in order of the source. whole: findings on no
    statement. wanting: names declared neither in the program nor in the cell file; the files are
    then a draft with stand-ins for them.
    """

    compiled: Compiled
    written: Compiled
    language: str
    rows: SourceRows
    whole: tuple[Diagnostic, ...]
    files: Mapping[str, bytes] = field(default_factory=dict)
    wanting: tuple[Wanted, ...] = ()

    @property
    def draft(self) -> bool:
        return self.written.ok and (self.written is not self.compiled or bool(self.wanting))

    @property
    def ok(self) -> bool:
        """True if everything is translated and proven, and all of its values are known."""
        return self.compiled.ok and not self.wanting

    @property
    def armless(self) -> bool:
        """True if it moves to poses, and no arm is named whose reach and limits are checked."""
        return any(finding.code == _NO_ARM.code for finding in self.whole)

    @property
    def beginnings(self) -> tuple[str, ...]:
        """The procedures to begin with, of a program that is not written as it has no entry."""
        begun = self.written.ok or self.compiled.source.entry is not None
        return () if begun else beginnings(self.compiled.source)

    @property
    def refusal(self) -> str:
        """Why nothing is written: the first error and its routine; empty if files are, or without
        an error.
        """
        errors = [one for one in self.compiled.found if one.severity is Severity.ERROR]
        if self.files or not errors:
            return ""
        first, more = errors[0], len(errors) - 1
        name = self._routine_of(first)
        told = first.code + (f" in `{name}`" if name else "")
        told += f" and {more:,} more error{'s' * (more > 1)}" if more else ""
        if name and is_uncalled(name, self.compiled.source):
            told += f"; nothing calls `{name}`: take it out of the source if it is not needed"
        return told

    def _routine_of(self, finding: Diagnostic) -> str:
        """Return the procedure with the statement that a finding is about, "" if none has it."""
        places = self.compiled.places
        place = None if finding.span is None else places.of(finding.span)
        at = (finding.path, finding.line) if place is None else (place.path, place.line)
        for procedure in self.compiled.source.procedures:
            for statement in walk(procedure.body):
                here = None if statement.span is None else places.of(statement.span)
                if here is not None and (here.path, here.line) == at:
                    return procedure.name
        return ""

    @property
    def findings(self) -> tuple[Diagnostic, ...]:
        return self.compiled.findings

    @property
    def proof(self) -> Proof:
        return self.written.proof

    @property
    def motion(self) -> MotionProof | None:
        """The proof by motion, None where it was not asked for."""
        return self.written.motion

    def write(self, folder: str | FilePath, *, overwrite: bool = False) -> tuple[FilePath, ...]:
        """Write the files as `Compiled.write` does, also those of a requested draft."""
        if not self.files:
            raise Refused(*self.findings)
        texts = self.compiled.places.texts
        source = texts[0].path if texts else None
        return write_unedited(self.files, folder, source=source, overwrite=overwrite)

    def __repr__(self) -> str:
        count = len(self.findings)
        state = "proven" if self.ok else "a draft" if self.files else "not written"
        told = [state, *sorted(self.files), f"{count} finding{'s' * (count != 1)}"]
        return f"<Translation {self.compiled.program.name} to {self.language}: {', '.join(told)}>"

    def _repr_html_(self) -> str:
        return pictured(self)

    @property
    def totals(self) -> dict[Level, int]:
        """Number of statements at each level; rows of a table count one by one."""
        return self.rows.totals


@without_gc()
def translate(
    source: str | FilePath | Loaded,
    *,
    to: str,
    robot: str | Robot | None = None,
    from_robot: str | Robot | None = None,
    process: str | FilePath | None = None,
    cell: str | FilePath | None = None,
    language: str | None = None,
    most_targets: int | None = None,
    frames: Frames = "base",
    grammar: Sampling = "samples",
    draft: bool = False,
    entry: str | None = None,
    proving: Proving | None = None,
    seeing: Seeing = NOTHING_SEEN,
) -> Translation:
    """Translate a vendor program to another language, for another arm if one is named.

    from_robot: the arm that it was written for. process: file with tools, frames and signals of the
    other cell. cell: file of names that programs use and do not declare, which may be missing yet:
    values that it lacks are in `wanting` of the result; no files are returned for a program that
    touches its bodies, if it has any. language: of the source, if neither suffix nor text
    identifies it. frames: how a language without work objects expresses them, see
    `Language.with_frames`. grammar: `full` has the proof parse programs of more than 20,000 lines
    completely with lark. draft: returns files also if some statements cannot be expressed: each
    becomes a comment after a stop. entry: the procedure that the program begins with, if the source
    has no `main`. proving: settings of a motion proof, None for none; without the requested proof
    no files are returned. seeing: source of frames located by cameras. Raises Unreadable or Refused
    for input that cannot be read at all.
    """
    target, stands = (
        language_of(to).with_frames(frames).with_sampling(grammar),
        open_cell(cell, robot, values=True),
    )
    arms = replace(stands, seeing=seeing).arms(robot_of(from_robot))
    loaded = source
    if not isinstance(loaded, Loaded):
        loaded = load(loaded, process=process, robot=arms.written_for, language=language)
    if loaded.language is None or loaded.program.origin is None:
        raise Refused(_NO_PROGRAM(name=source), exit_status=2)
    if cell is not None:
        taught = None if arms.written_for is None else arms.written_for.name
        loaded = with_values_of_file(loaded, cell, taught=taught, to=target)
    loaded, stated = without_names(loaded, process), arms
    while True:
        program = with_entry(loaded.program, entry)
        program = marked_as_draft(program, loaded.wanting)
        places = Places(program)
        arms = with_robot_of_cell(program, arms_of_loaded(loaded, stated))
        program, sights = with_located_frames(program, arms)
        style = style_beside(program, loaded.text, None)
        compiled = compile_program(program, places, target, arms, most_targets, style)
        if cell is None or not compiled.lacks_joint_speed:
            break
        # The arms do not tell the speed of every joint move: the cell file has to.
        loaded = with_joint_speed_wanted(loaded, compiled.source, loads=target.tool_loads)
    written, later, unrun = compiled, tuple[Diagnostic, ...](), not compiled.ok
    if not compiled.ok:
        # The draft is compiled even if it is not requested: it finds further faults of the source.
        with within(DRAFTING, None, program.size()):
            stopped = bool(loaded.wanting)
            drawn, later = drafted(compiled, target, arms, most_targets, style, stopped=stopped)
        written = drawn if draft else compiled
    else:
        # A run with stand-in values proves nothing.
        sought = None if loaded.wanting else proving
        written = compiled = proven_by_motion(compiled, arms, sought, entry)
    with within(REPORTING, None, program.size()):
        rows, whole = _report(compiled, written, later)
    unfilled = tuple(UNFILLED(what=wanted_in_words(one), place=one.name) for one in loaded.wanting)
    about_arms = (*_unnamed_arm(program, target, arms), *stated_arm_findings(loaded, stated))
    if loaded.wanting and proving is not None:
        unfilled += (UNPROVEN(),)
    elif unrun and proving is not None:
        unfilled += (_NOT_RUN(what="a draft" if written.ok else "not complete"),)
    return Translation(
        compiled,
        written,
        target.name,
        rows,
        (*about_arms, *loaded.findings, *stands.findings, *sights, *unfilled, *whole),
        dict(written.files) if written.ok else {},
        loaded.wanting,
    )


_Name: TypeAlias = tuple[ProgramTable | None, str, str]
"""Procedures or paths, None for any table; the procedure whose own it is, empty if that is not
known; and a name, both in lower case."""


@dataclass(slots=True)
class _Part:
    """Part of the source that a row is made of, with its findings.

    names: used for it in findings. head: its first line represents it. silent: left out of the
    report unless it has findings. within: the part that it is translated with. lines: (n, 2) start
    and end of each of many like lines, None for any other part; at: findings about some of them.
    """

    span: Span
    names: tuple[_Name, ...] = ()
    head: bool = False
    silent: bool = False
    within: Span | None = None
    lines: Rows | None = None
    found: list[Diagnostic] = field(default_factory=list)
    at: dict[int, list[Diagnostic]] = field(default_factory=dict)

    def line(self, span: Span) -> int | None:
        """The line that holds a span, None if none does."""
        if self.lines is None:
            return None
        at = int(np.searchsorted(self.lines[:, 0], span.start, side="right")) - 1
        return at if at >= 0 and span.end <= self.lines[at, 1] else None

    def reasons(self, line: int | None) -> list[Diagnostic]:
        """Findings about one of its lines, or about the part without a line."""
        more = () if line is None else self.at.get(line, ())
        return [*self.found, *(f for f in more if f not in self.found)]

    def note(self, finding: Diagnostic, line: int | None) -> None:
        about = self.found if line is None else self.at.setdefault(line, [])
        if finding.message not in [f.message for f in about]:
            about.append(finding)


class SourceRows(Sequence[ReportRow]):
    """Rows of a report; those of many like lines are made on request."""

    def __init__(
        self,
        parts: Sequence[_Part],
        row: Callable[[_Part, int | None], ReportRow | None],
        level: Callable[[Sequence[Diagnostic]], Level],
    ) -> None:
        self._row, self._level = row, level
        each = ((part, part if part.lines is not None else row(part, None)) for part in parts)
        self._parts = [made for _, made in each if made is not None]
        sizes = [len(one.lines) if isinstance(one, _Part) else 1 for one in self._parts]  # type: ignore[arg-type]
        self._starts = np.concatenate([[0], np.cumsum(sizes)]).astype(int)

    def __len__(self) -> int:
        return int(self._starts[-1])

    @overload
    def __getitem__(self, at: int) -> ReportRow: ...
    @overload
    def __getitem__(self, at: slice) -> tuple[ReportRow, ...]: ...
    def __getitem__(self, at: int | slice) -> ReportRow | tuple[ReportRow, ...]:
        if isinstance(at, slice):
            return tuple(self[k] for k in range(*at.indices(len(self))))
        at = range(len(self))[at]
        number = int(np.searchsorted(self._starts, at, side="right")) - 1
        return self._line(self._parts[number], at - int(self._starts[number]))

    def __iter__(self) -> Iterator[ReportRow]:
        for one in self._parts:
            if isinstance(one, ReportRow):
                yield one
            else:
                assert one.lines is not None
                yield from (self._line(one, line) for line in range(len(one.lines)))

    def _line(self, one: ReportRow | _Part, line: int) -> ReportRow:
        made = one if isinstance(one, ReportRow) else self._row(one, line)
        assert made is not None
        return made

    @property
    def noted(self) -> Iterator[ReportRow]:
        """Those about which something is found."""
        for one in self._parts:
            if isinstance(one, ReportRow):
                if one.reasons:
                    yield one
                continue
            assert one.lines is not None
            lines = range(len(one.lines)) if one.found else sorted(one.at)
            yield from (self._line(one, line) for line in lines)

    @property
    def totals(self) -> dict[Level, int]:
        """Number of rows at each level."""
        counts = dict.fromkeys(LEVELS, 0)
        for one in self._parts:
            if isinstance(one, ReportRow):
                counts[one.level] += one.count
                continue
            assert one.lines is not None
            counts[self._level(one.found)] += len(one.lines) - len(one.at)
            for line in one.at:
                counts[self._level(one.reasons(line))] += 1
        return counts


def _is_stated(place: Place | None) -> bool:
    """True if it comes from a cell file's values, not from a file that was read."""
    return place is not None and (place.path or "").startswith(STATED_TEXT_NAME)


def _report(
    compiled: Compiled, written: Compiled, later: Sequence[Diagnostic]
) -> tuple[SourceRows, tuple[Diagnostic, ...]]:
    """The rows, and the findings that belong to none of them.

    later: what is found of the source once other parts are left out; part of a row or nothing.
    """
    places = compiled.places
    parts: dict[Span, _Part] = {}
    names: dict[_Name, _Part] = {}
    plain = lowered_for_language(compiled.source, language_of(compiled.language))
    also = () if plain is compiled.source else _lowered_parts(plain)
    lifted = {q.span for program in (compiled.source, plain) for q in program.procedures}
    for part in chain(_parts_of_source(compiled.source, places, lifted), also):
        known = parts.setdefault(part.span, part)
        # A part is silent only if no reading of it is to be shown.
        known.silent = known.silent and part.silent
        for name in part.names:
            names.setdefault(name, known)
    about = _PartFinder(parts, names, compiled.source)
    back = Trace(compiled.program, compiled.proof.lifted)
    whole: list[Diagnostic] = []
    for finding in compiled.found:
        proven = finding in compiled.proof.findings  # what it is about is in another tree
        one, line = about.part(finding, back.source(finding), named=not proven)
        # What is not checked is said of the program: the translation of no statement is worse.
        if one is None or finding.code == NOT_KNOWN.code:
            whole.append(places.finding(finding))
        else:
            one.note(finding, line)
    for finding in later:
        if finding.span is not None:
            one, line = about.at(finding.span)
            if one is not None:
                one.note(finding, line)
    # First across, then down, then by calls: each step uses the findings of those before.
    _pass_on_findings(parts)
    _pass_down_findings(parts, [f for f in (*compiled.found, *later) if f.code == NOT_CALLED.code])
    _add_losses(compiled.source, {span: part.found for span, part in parts.items()})
    shown = [part for part in parts.values() if part.found or part.at or not part.silent]
    shown.sort(key=lambda part: (part.span.start, -part.span.end))
    trace = Trace(written.program, written.proof.lifted)
    origin = compiled.source.origin
    spoken = {compiled.language} if origin is None else {compiled.language, origin.language}
    # A `partial` of a module's function can go to another process.
    level = partial(_level, [(one.family, one.fixed) for one in map(language_of, sorted(spoken))])
    # Values from a cell file have no line in the source: only lost ones are shown.
    shown = [
        part for part in shown if not _is_stated(places.of(part.span)) or level(part.found) == "not"
    ]
    return SourceRows(shown, partial(_report_row, places, trace, level), level), fold(whole)


class _PartFinder:
    """Which part of a source, and which line of it, a finding is about."""

    def __init__(
        self, parts: Mapping[Span, _Part], names: Mapping[_Name, _Part], program: Program
    ) -> None:
        self._parts, self._names, self._program = parts, names, program
        self._runs = sorted(
            (part for part in parts.values() if part.lines is not None),
            key=lambda part: part.span.start,
        )
        self._starts = [part.span.start for part in self._runs]

    def part(
        self, finding: Diagnostic, span: Span | None, *, named: bool
    ) -> tuple[_Part | None, int | None]:
        """span: of the source that it is about, None if it has none. named: look for names too."""
        if span is not None:
            part, line = self.at(span)
            if part is not None:
                return part, line
            # No part has exactly this span: the smallest one that contains it counts.
            holding = [s for s in self._parts if s.start <= span.start and span.end <= s.end]
            inmost = min(holding, key=lambda s: s.end - s.start, default=None)
            return (self._parts[inmost] if inmost is not None else None), None
        if not named:
            return None, None
        part = next(
            (self._names[n] for n in _name_of_finding(finding.about) if n in self._names), None
        )
        if part is not None and part.lines is not None and isinstance(finding.about, PathRow):
            return part, part.line(self._row_of(finding.about) or part.span)
        return part, None

    def at(self, span: Span) -> tuple[_Part | None, int | None]:
        """The part that stands at a span, or the line of many that does."""
        at = bisect_right(self._starts, span.start) - 1
        line = self._runs[at].line(span) if at >= 0 else None
        if line is not None:
            return self._runs[at], line
        return self._parts.get(span), None

    def _row_of(self, about: PathRow) -> Span | None:
        for statement in self._program.statements():
            if isinstance(statement, p.Follow) and statement.path.name == about.path:
                return statement.row_span(about.row - 1)
        return None


def _pass_on_findings(parts: Mapping[Span, _Part]) -> None:
    """Copy the findings about a part to those that are translated with it."""
    for part in parts.values():
        holder = None if part.within is None else parts.get(part.within)
        if holder is not None:
            known = {finding.message for finding in part.found}
            part.found += (f for f in holder.found if f.message not in known)


def _pass_down_findings(parts: Mapping[Span, _Part], left_out: Iterable[Diagnostic]) -> None:
    """Copy the findings about an omitted routine to each statement and each declaration in it."""
    about = {f.span: f for f in left_out if f.span is not None}
    outer: list[Span] = []
    for span in sorted(about, key=lambda one: (one.start, -one.end)):
        if not outer or span.start >= outer[-1].end:
            outer.append(span)
    starts = [span.start for span in outer]
    for part in parts.values():
        at = bisect_right(starts, part.span.start) - 1
        if at >= 0 and part.span.end <= outer[at].end and not part.silent:
            part.note(about[outer[at]], None)


def _parts_of_source(
    program: Program, places: Places, lifted: Container[Span | None]
) -> Iterator[_Part]:
    """Yield each part of the source once or twice: as lifted, then as it is in the tree.

    lifted: procedures whose statements are separate parts; the others are represented by their
    text.
    """
    yield from _lifted_parts(program)
    for part in places.parts():
        if part.within is not None and part.within in lifted:
            continue
        name, owner = (part.name or "").lower(), part.owner.lower()
        called = ((None, "", name), (None, owner, name)) if name else ()
        yield _Part(part.span, called, head=True, within=part.within, lines=part.lines)


def _lowered_parts(program: Program) -> Iterator[_Part]:
    """Yield the parts of a source after it is lowered for other languages."""
    yield from _lifted_parts(program)
    owners = (("", program.variables), *((q.name.lower(), q.variables) for q in program.procedures))
    for owner, variables in owners:
        for name, variable in variables.items():
            if variable.span is not None:
                low = name.lower()
                called: tuple[_Name, ...] = ((None, "", low), (None, owner, low))
                yield _Part(variable.span, names=called, head=True)


def _lifted_parts(program: Program) -> Iterator[_Part]:
    """The parts of a program as it is lifted."""
    for procedure in program.procedures:
        if procedure.span is not None:
            called = _part_names("procedures", procedure.name)
            yield _Part(procedure.span, names=called, head=True)
        for statement in walk(procedure.body):
            match statement:
                case p.Follow(path, span=Span() as span):
                    called = _part_names("paths", path.name)
                    yield _Part(span, called, head=True, lines=statement.lines)
                case p.Comment(span=Span() as span) | p.Label(span=Span() as span):
                    yield _Part(span, silent=True)
                case _ if statement.span is not None:
                    yield _Part(statement.span, head=bool(bodies(statement)))
    for declaration in program.declarations:
        if declaration.span is not None:
            yield _Part(declaration.span, head=True)


def _part_names(table: ProgramTable, name: str) -> tuple[_Name, ...]:
    return (None, "", name.lower()), (table, "", name.lower())


def _name_of_finding(about: Subject | str | None) -> tuple[_Name, ...]:
    """Return the names of the part that a finding is about, the surest first; empty if it is about
    several.
    """
    match about:
        case Declared(name=name, table="procedures" | "paths" as table):
            return ((table, "", name.lower()),)
        case Declared(name=name, owner=owner):
            return (None, owner.lower(), name.lower()), (None, "", name.lower())
        case PathRow(path=name):
            return (("paths", "", name.lower()),)
    return ()


def _level(advising: Sequence[tuple[str, tuple[str, ...]]], found: Sequence[Diagnostic]) -> Level:
    """The level of what some findings are about.

    advising: beginnings of the codes of languages, and of those that count all the same. Their
    notes are remarks of a rule on the program, not on its translation.
    """

    def is_advice(finding: Diagnostic) -> bool:
        return finding.severity is Severity.INFO and any(
            finding.code.startswith(family) and not finding.code.startswith(fixed)
            for family, fixed in advising
        )

    if all(map(is_advice, found)):
        return "supported"
    return "not" if any(f.severity is Severity.ERROR for f in found) else "partial"


def _report_row(
    places: Places,
    trace: Trace,
    level: Callable[[Sequence[Diagnostic]], Level],
    part: _Part,
    line: int | None,
) -> ReportRow | None:
    """line: of a part with many, counted from 0."""
    span = part.span
    if line is not None and part.lines is not None:
        span = Span(*part.lines[line].tolist())
    place = places.of(span)
    if place is None:
        return None
    reasons = sorted(part.reasons(line), key=lambda f: f.severity is not Severity.ERROR)
    texts = [text.strip() for text in lines_of(place.text) if text.strip()]
    text = " ".join(texts[:1] if part.head else texts)
    if len(text) > _LONGEST_TEXT:
        text = text[: _LONGEST_TEXT - 1] + "…"
    went = trace.written(span) if line is None else trace.written_line(part.span, line)
    return ReportRow(place, text, level(reasons), tuple(reasons), tuple(went))

"""Translating: a vendor program in another language, with a report on each of its statements."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from assistant.compiler.arms import in_arms, robot_of, standing
from assistant.compiler.compiling import Compiled, compile_program, proven_by_motion, told
from assistant.compiler.controller_files import STATED
from assistant.compiler.drafting import draft as drafted
from assistant.compiler.entering import entered
from assistant.compiler.filling import UNFILLED, UNPROVEN, as_draft, with_cell
from assistant.compiler.keeping.remembered import write_unedited
from assistant.compiler.loading import Loaded, language_of
from assistant.compiler.motion import MotionProof, Proving
from assistant.compiler.naming import without_names
from assistant.compiler.opening import load
from assistant.compiler.proof import Proof
from assistant.compiler.scenes import in_cell
from assistant.compiler.seen_frames import with_known
from assistant.compiler.source_map import Place, Places, Trace
from assistant.compiler.unsaid import lose
from assistant.lazy import pictured
from assistant.program import statements as p
from assistant.program.diagnostics import Diagnostic, Refused, Severity, Span, error, fold
from assistant.program.lines import lines_of
from assistant.program.program import Program, bodies, walk
from assistant.program.subjects import Declared, PathRow, Subject, Table
from assistant.program.system.budgets import DRAFTING, REPORTING, within
from assistant.program.without_gc import uncollected
from assistant.sources.cell import said
from assistant.sources.sights import NOTHING_SEEN, Seeing

if TYPE_CHECKING:
    from assistant.languages.answers import (
        Frames,
    )
    from assistant.program.wanted import Wanted
    from assistant.robots import Robot

NO_PROGRAM = error(
    "CO005",
    "`{name}` is no program in a robot language",
    "compile it: `robot-assistant compile`",
)

Level = Literal["supported", "partial", "not"]
LEVELS: Final[tuple[Level, ...]] = ("supported", "partial", "not")
LONGEST_TEXT: Final = 100
"""Characters of a statement that a row shows."""


@dataclass(frozen=True, slots=True)
class Row:
    """What becomes of one statement or declaration of the source.

    text: its first line. count: rows of a table or moves of a path, else 1.
    reasons: why it is not said as it stands, errors first. went: where it is in the written files.
    """

    place: Place
    text: str
    level: Level
    reasons: tuple[Diagnostic, ...] = ()
    went: tuple[Place, ...] = ()
    count: int = 1


@dataclass(frozen=True, slots=True)
class Translation:
    """A translated program. files: as they are to be written, none if something is not said.

    compiled: all of it. written: what the files are made of, all of it or a draft, with stops
    for what is not said. rows: in order of the source. whole: findings on no statement. wanting:
    what nobody declares, neither the program nor the cell file; the files are a draft then, in
    which something only stands for it.
    """

    compiled: Compiled
    written: Compiled
    language: str
    rows: tuple[Row, ...]
    whole: tuple[Diagnostic, ...]
    files: Mapping[str, bytes] = field(default_factory=dict)
    wanting: tuple[Wanted, ...] = ()

    @property
    def draft(self) -> bool:
        return self.written.ok and (self.written is not self.compiled or bool(self.wanting))

    @property
    def ok(self) -> bool:
        """Whether everything is said and proven, and all of its values are known."""
        return self.compiled.ok and not self.wanting

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
        """Writes the files as `Compiled.write` does; a draft where one was asked for."""
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
        """How many statements there are at each level; rows of a table count one by one."""
        return {level: sum(r.count for r in self.rows if r.level == level) for level in LEVELS}


@uncollected()
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
    draft: bool = False,
    entry: str | None = None,
    proving: Proving | None = None,
    seeing: Seeing = NOTHING_SEEN,
) -> Translation:
    """A vendor program in another language, for another arm if one is named.

    from_robot: the arm that it was written for. process: file with tools, frames and signals
    of the other cell. cell: file of what programs use and do not declare, which need not be there
    yet: what it does not say is in `wanting` of the answer; nothing is given out that touches its
    bodies, if it has any. language: of the source, if neither
    suffix nor text tell.
    frames: how a language without work objects says them, see `Language.with_frames`. draft: gives
    files also if some statements cannot be said: each stands as a comment behind a stop.
    entry: the procedure that the program begins with, where the source has no `main`. proving: how
    a proof by motion is sought, None for none; nothing is given out that lacks one then. seeing:
    where frames that are seen are taken from.
    Raises Unreadable or Refused for what cannot be read at all.
    """
    target, stands = language_of(to).with_frames(frames), in_cell(cell, robot, values=True)
    arms = replace(stands, seeing=seeing).arms(robot_of(from_robot))
    loaded = source
    if not isinstance(loaded, Loaded):
        loaded = load(loaded, process=process, robot=arms.written_for, language=language)
    if loaded.language is None or loaded.program.origin is None:
        raise Refused(NO_PROGRAM(name=source), exit_status=2)
    if cell is not None:
        loaded = with_cell(loaded, cell, taught=arms.written_for is not None, to=target)
    loaded = without_names(loaded, process)
    program = entered(loaded.program, entry)
    program = as_draft(program, loaded.wanting)
    places = Places(program)
    arms = standing(program, in_arms(loaded, arms))
    program, sights = with_known(program, arms)
    compiled = compile_program(program, places, target, arms, most_targets)
    written, later = compiled, tuple[Diagnostic, ...]()
    if not compiled.ok:
        with within(DRAFTING, None, program.size()):
            drawn, later = drafted(compiled, target, arms, most_targets)
        written = drawn if draft else compiled
    else:
        sought = None if loaded.wanting else proving
        written = compiled = proven_by_motion(compiled, arms, sought, entry)
    with within(REPORTING, None, program.size()):
        rows, whole = _report(compiled, written, later)
        rows = tuple(row for row in rows if not _is_stated(row) or row.level == "not")
    unfilled = tuple(UNFILLED(what=said(one), place=one.name) for one in loaded.wanting)
    if loaded.wanting and proving is not None:
        unfilled += (UNPROVEN(),)
    return Translation(
        compiled,
        written,
        target.name,
        rows,
        (*loaded.findings, *stands.findings, *sights, *unfilled, *whole),
        dict(written.files) if written.ok else {},
        loaded.wanting,
    )


_Name: TypeAlias = tuple[Table | None, str, str]
"""Procedures or paths, None for any table; the procedure whose own it is, empty if that is not
known; and a name, both in lower case."""


@dataclass(slots=True)
class _Part:
    """What a row is made of: a part of the source, and what is found about it.

    names: that findings know it by. head: whether its first line stands for it. silent: left
    out of the report unless something is found about it. within: the part that it is said with.
    """

    span: Span
    count: int = 1
    names: tuple[_Name, ...] = ()
    head: bool = False
    silent: bool = False
    within: Span | None = None
    found: list[Diagnostic] = field(default_factory=list)


def _is_stated(row: Row) -> bool:
    """Whether it is in no file that was read, but in what a cell file says."""
    return (row.place.path or "").startswith(STATED)


def _report(
    compiled: Compiled, written: Compiled, later: Sequence[Diagnostic]
) -> tuple[tuple[Row, ...], tuple[Diagnostic, ...]]:
    """The rows, and the findings that belong to none of them.

    later: what is found of the source once other parts are left out; part of a row or nothing.
    """
    places = compiled.places
    parts: dict[Span, _Part] = {}
    names: dict[_Name, _Part] = {}
    plain = told(compiled.source, language_of(compiled.language))
    also = () if plain is compiled.source else _told_parts(plain)
    lifted = {q.span for program in (compiled.source, plain) for q in program.procedures}
    for part in chain(_parts(compiled.source, places, lifted), also):
        known = parts.setdefault(part.span, part)
        known.silent = known.silent and part.silent
        for name in part.names:
            names.setdefault(name, known)
    back = Trace(compiled.program, compiled.proof.lifted)
    whole: list[Diagnostic] = []
    for finding in compiled.found:
        proven = finding in compiled.proof.findings  # what it is about is in another tree
        about = _about(finding, back.source(finding), parts, {} if proven else names)
        if about is None:
            whole.append(places.finding(finding))
        elif finding.message not in [f.message for f in about.found]:
            about.found.append(finding)
    for finding in later:
        about = parts.get(finding.span) if finding.span else None
        if about is not None and finding.message not in [f.message for f in about.found]:
            about.found.append(finding)
    _hand_on(parts)
    lose(compiled.source, {span: part.found for span, part in parts.items()})
    shown = [part for part in parts.values() if part.found or not part.silent]
    shown.sort(key=lambda part: (part.span.start, -part.span.end))
    trace = Trace(written.program, written.proof.lifted)
    advice = _advice(compiled)
    rows = [row for part in shown if (row := _row(part, places, trace, advice)) is not None]
    return tuple(rows), fold(whole)


def _hand_on(parts: Mapping[Span, _Part]) -> None:
    """What is found about a part is found about those that are said with it."""
    for part in parts.values():
        holder = None if part.within is None else parts.get(part.within)
        if holder is not None:
            known = {finding.message for finding in part.found}
            part.found += (f for f in holder.found if f.message not in known)


def _parts(program: Program, places: Places, lifted: Container[Span | None]) -> Iterator[_Part]:
    """Each part of the source once or twice: as it is lifted, then as it stands in the tree.

    lifted: procedures whose statements are parts by themselves; of others each is what its text is.
    """
    yield from _said(program)
    for part in places.parts():
        if part.within is not None and part.within in lifted:
            continue
        name, owner = (part.name or "").lower(), part.owner.lower()
        called = ((None, "", name), (None, owner, name)) if name else ()
        yield _Part(part.span, part.count, called, head=True, within=part.within)


def _told_parts(program: Program) -> Iterator[_Part]:
    """The same of a source with the data that other languages are told of it."""
    yield from _said(program)
    owners = (("", program.variables), *((q.name.lower(), q.variables) for q in program.procedures))
    for owner, variables in owners:
        for name, variable in variables.items():
            if variable.span is not None:
                low = name.lower()
                called: tuple[_Name, ...] = ((None, "", low), (None, owner, low))
                yield _Part(variable.span, names=called, head=True)


def _said(program: Program) -> Iterator[_Part]:
    """The parts of a program as it is lifted."""
    for procedure in program.procedures:
        if procedure.span is not None:
            called = _names("procedures", procedure.name)
            yield _Part(procedure.span, names=called, head=True)
        for statement in walk(procedure.body):
            match statement:
                case p.Follow(path, span=Span() as span):
                    called = _names("paths", path.name)
                    yield _Part(span, len(path), called, head=True)
                case p.Comment(span=Span() as span) | p.Label(span=Span() as span):
                    yield _Part(span, silent=True)
                case _ if statement.span is not None:
                    yield _Part(statement.span, head=bool(bodies(statement)))
    for declaration in program.declarations:
        if declaration.span is not None:
            yield _Part(declaration.span, head=True)


def _about(
    finding: Diagnostic,
    span: Span | None,
    parts: Mapping[Span, _Part],
    names: Mapping[_Name, _Part],
) -> _Part | None:
    """The part that a finding is about, None if it is about the whole."""
    if span is not None:
        if span in parts:
            return parts[span]
        holding = [s for s in parts if s.start <= span.start and span.end <= s.end]
        return parts[min(holding, key=lambda s: s.end - s.start)] if holding else None
    return next((names[name] for name in _named(finding.about) if name in names), None)


def _names(table: Table, name: str) -> tuple[_Name, ...]:
    return (None, "", name.lower()), (table, "", name.lower())


def _named(about: Subject | str | None) -> tuple[_Name, ...]:
    """What the part is known by that a finding is about, the surest first; not if of several."""
    match about:
        case Declared(name=name, table="procedures" | "paths" as table):
            return ((table, "", name.lower()),)
        case Declared(name=name, owner=owner):
            return (None, owner.lower(), name.lower()), (None, "", name.lower())
        case PathRow(path=name):
            return (("paths", "", name.lower()),)
    return ()


def _advice(compiled: Compiled) -> Callable[[Diagnostic], bool]:
    """Whether a finding is a remark of a rule on the program, not on its translation."""
    origin = compiled.source.origin
    names = {compiled.language} if origin is None else {compiled.language, origin.language}
    languages = [language_of(name) for name in names]

    def is_advice(finding: Diagnostic) -> bool:
        return finding.severity is Severity.INFO and any(
            finding.code.startswith(one.family) and not finding.code.startswith(one.fixed)
            for one in languages
        )

    return is_advice


def _row(
    part: _Part, places: Places, trace: Trace, is_advice: Callable[[Diagnostic], bool]
) -> Row | None:
    place = places.of(part.span)
    if place is None:
        return None
    level: Level = "supported"
    reasons = sorted(part.found, key=lambda f: f.severity is not Severity.ERROR)
    if not all(map(is_advice, reasons)):
        level = "not" if reasons[0].severity is Severity.ERROR else "partial"
    lines = [line.strip() for line in lines_of(place.text) if line.strip()]
    text = " ".join(lines[:1] if part.head else lines)
    if len(text) > LONGEST_TEXT:
        text = text[: LONGEST_TEXT - 1] + "…"
    return Row(place, text, level, tuple(reasons), tuple(trace.written(part.span)), part.count)

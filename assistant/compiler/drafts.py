"""Drafts: programs in which what the target language cannot express is written as comments.

Each statement without equivalent becomes a stop with its source text as comments after it;
declarations without equivalent become comments at the head.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any, Final, TypeAlias

import numpy as np

from assistant.base.diagnostics import (
    DATA_TABLES,
    Declared,
    Diagnostic,
    Inner,
    Severity,
    Span,
    error,
    span_over,
)
from assistant.base.source_text import lines_of
from assistant.compiler.arms import Arms
from assistant.compiler.cell_defaults import stopped_at_start
from assistant.compiler.compilation import Compiled, compile_program, lowered_for_language
from assistant.compiler.source_map import Places, Trace
from assistant.compiler.style import PLAIN_STYLE, Style
from assistant.compiler.uncalled_routines import NOT_CALLED
from assistant.languages.language import Language
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Kind
from assistant.program.program import Procedure, Program, Variable
from assistant.program.rewriting import Body, map_bodies, records
from assistant.program.vendor_statements import effect_of

_DECLARATION_LEFT_OUT = error(
    "CO007", "`{name}` is declared by what cannot be said there", "see to its declaration first"
)

_DRAFT_HEADING: Final = (
    "DRAFT: not for production. The program stops at its start, and where a part of it could not",
    "be translated, which is a comment after the stop. Replace these parts by hand, then delete",
    "the stops and this heading.",
)
_NOT_TRANSLATED: Final = "not translated"
_QUOTE_PREFIX: Final = "| "
"""Before each line of source text in a comment: it can be mistaken for nothing else there."""
_MOST_ROUNDS: Final = 8
"""Most rounds: a part left out may be missed elsewhere (a label, a variable), but not for ever."""
_POSITION_TYPES: Final = ("position", "pose", "joints")
"""Types of variables that say where something is."""
_DeclaredNames: TypeAlias = Collection[tuple[str, str]]
"""Procedure, empty for the program, and name of what is declared, in lower case."""


def draft_program(
    compiled: Compiled,
    target: Language[Any],
    arms: Arms,
    most_targets: int | None = None,
    style: Style = PLAIN_STYLE,
    *,
    stopped: bool = False,
) -> tuple[Compiled, tuple[Diagnostic, ...]]:
    """Return the program without the parts that the target cannot express, and the findings on the
    source that appear only then.

    The result counts only if it is `ok`. stopped: the program stops at its start already.
    """
    places, program = compiled.places, lowered_for_language(compiled.source, target)
    program = program if stopped else stopped_at_start(program)
    program = replace(program, comments=(*_DRAFT_HEADING, *program.comments))
    out: set[Span] = set()
    later: list[Diagnostic] = []
    declared = _declared_names(program)
    uncalled: tuple[Diagnostic, ...] = ()
    for _ in range(_MOST_ROUNDS):
        uncalled += tuple(f for f in compiled.found if f.code == NOT_CALLED.code)
        spans, names = _parts_with_errors(compiled, compiled.found)
        shorter = _without_parts(program, spans - out, names, places)
        if shorter == program:
            break
        out |= spans
        program = shorter
        if wanting := _missing_declarations(compiled, program, declared, out):
            later += (_is_about_missing(finding, declared) for finding in wanting)
            spans, names = _parts_with_errors(compiled, wanting)
            program = _without_parts(program, spans - out, names, places)
            out |= spans
        short = _without_uncalled(program, uncalled)
        compiled = compile_program(short, places, target, arms, most_targets, style)
        missing = declared - _declared_names(program)
        errors = (f for f in compiled.found if f.severity is Severity.ERROR and f.line is None)
        later += [_is_about_missing(finding, missing) for finding in errors]
        if compiled.ok:
            break
    found = (*(f for f in uncalled if f not in compiled.found), *compiled.found)
    return replace(compiled, found=found), tuple(later)


def _without_uncalled(program: Program, told: Collection[Diagnostic]) -> Program:
    """The program without what was left out before, as nothing calls it."""
    spans = {f.span for f in told if f.span is not None}
    names = {(f.about.table, f.about.name) for f in told if isinstance(f.about, Declared)}
    left: dict[str, Any] = {
        table: {n: one for n, one in getattr(program, table).items() if (table, n) not in names}
        for table in {str(table) for table, _ in names}
    }
    return replace(
        program,
        procedures=tuple(one for one in program.procedures if one.span not in spans),
        declarations=tuple(one for one in program.declarations if one.span not in spans),
        **left,
    )


def _declared_names(program: Program) -> set[str]:
    """Names in lower case of what is declared, or what a declaration as text speaks of."""
    names = {name.lower() for table in DATA_TABLES for name in getattr(program, table)}
    for declaration in program.declarations:
        names.update(effect_of(declaration).names)
    return names


def _is_about_missing(finding: Diagnostic, missing: Collection[str]) -> Diagnostic:
    """Attribute a finding about a name that a draft lacks to its missing declaration."""
    name = finding.missing
    if name is None or name.lower() not in missing:
        return finding
    return _DECLARATION_LEFT_OUT(name=name, span=finding.span, about=finding.about)


def _missing_declarations(
    compiled: Compiled, program: Program, declared: set[str], out: Collection[Span]
) -> tuple[Diagnostic, ...]:
    """Errors about what a draft still has that lacks a declaration now.

    declared: names in lower case that the whole program declares. out: spans of statements that
    are stops by now.
    """
    missing = declared - _declared_names(program)
    there = {statement.span for statement in program.statements()}.difference(out)
    return tuple(
        finding
        for finding in compiled.wanting
        if (finding.missing or "").lower() in missing
        and (finding.span in there or isinstance(finding.about, Declared))
    )


def _parts_with_errors(
    compiled: Compiled, found: Iterable[Diagnostic]
) -> tuple[set[Span], set[tuple[str, str]]]:
    """Spans of statements and `Names` of declarations that errors are about."""
    trace = Trace(compiled.program, compiled.proof.lifted)
    spans: set[Span] = set()
    names: set[tuple[str, str]] = set()
    for finding in found:
        if finding.severity is Severity.ERROR:
            span, declared = trace.source(finding), _declaration_of(finding)
            if declared is not None and (span is None or finding in compiled.proof.findings):
                names.add((declared.owner.lower(), declared.name.lower()))
            elif span is not None:
                spans.add(span)
    return spans, names


def _declaration_of(finding: Diagnostic) -> Declared | None:
    """The variable, target, tool … that a finding is about, or a part of which it is about."""
    match finding.about:
        case Inner() as inner:
            return inner.declared
        case Declared(table=table) as declared if table is None or table in DATA_TABLES:
            return declared
    return None


def _without_parts(
    program: Program, spans: Collection[Span], names: _DeclaredNames, places: Places
) -> Program:
    """spans: of statements and declarations that go. names: of data that go."""
    heads: list[str] = []
    kept = []
    for declaration in program.declarations:
        if declaration.span in spans:
            heads += _quoted_text(declaration.span, places, declaration.text)
        else:
            kept.append(declaration)
    own = {declaration.span for declaration in program.declarations}
    alone = {span for span in spans if span not in own}  # else it is of another part of a record
    tables: dict[str, Any] = {}
    # Data of procedures first, so that those of the program replace them.
    inner_first = sorted(places.parts(), key=lambda part: not part.owner)
    parts = {part.name.lower(): part for part in inner_first if part.name}
    for table in DATA_TABLES:
        given = getattr(program, table)
        gone = [
            n for n, v in given.items() if ("", n.lower()) in names or _is_declared_in(v, alone)
        ]
        if gone:
            tables[table] = _fewer_entries(given, gone)
        for name in gone:
            part = parts.get(name.lower())
            heads += _quoted_text(part.span if part else None, places, name)
    procedures = tuple(_procedure_without(q, spans, names, places) for q in program.procedures)
    # Settings that serve vendor text have no effect once none is left.
    if not kept and all(map(_serves_vendor_text, filter(_vendor_text, records(procedures)))):
        procedures = tuple(replace(q, body=_without_settings(q.body)) for q in procedures)
    return replace(
        program,
        procedures=procedures,
        declarations=tuple(kept),
        comments=(*program.comments, *heads),
        **tables,
    )


def _is_declared_in(declared: Any, spans: Collection[Span]) -> bool:
    return isinstance(declared, Variable) and declared.span in spans


def _fewer_entries(given: Mapping[str, Any], gone: Collection[str]) -> dict[str, Any]:
    """A table without some of it; of a variable its first value goes before itself does.

    Not of one that a move may lead to: without its value it is another place.
    """
    kept = {}
    for name, value in given.items():
        if name not in gone:
            kept[name] = value
        elif isinstance(value, Variable) and value.initial and value.type not in _POSITION_TYPES:
            kept[name] = replace(value, initial=None)
    return kept


def _procedure_without(
    procedure: Procedure, spans: Collection[Span], names: _DeclaredNames, places: Places
) -> Procedure:
    if procedure.span is not None and procedure.span in spans:
        return replace(procedure, body=tuple(_stop_with_text(procedure.span, places)), variables={})
    body, variables = tuple(_body_without(procedure.body, spans, places)), procedure.variables
    gone = [
        name
        for name, variable in variables.items()
        if (procedure.name.lower(), name.lower()) in names or _is_declared_in(variable, spans)
    ]
    if gone:
        said = (t for name in gone for t in _quoted_text(variables[name].span, places, name))
        body, variables = (*map(p.Comment, said), *body), _fewer_entries(variables, gone)
    return replace(procedure, body=body, variables=variables)


def _vendor_text(record: Any) -> bool:
    return isinstance(record, p.Opaque | e.Verbatim)


def _serves_vendor_text(record: Any) -> bool:
    """True if it only serves other vendor text, as a setting of moves that stay vendor text."""
    return isinstance(record, p.Opaque) and record.reason is not None and record.reason.serves


def _without_settings(body: Body) -> Body:
    """Without what serves vendor text, of which none is left."""
    return tuple(map_bodies(one, _without_settings) for one in body if not _serves_vendor_text(one))


def _body_without(body: Body, spans: Collection[Span], places: Places) -> Iterator[p.Statement]:
    stopped: Span | None = None
    for statement in body:
        span = statement.span
        if span is not None and span in spans and not isinstance(statement, p.Comment):
            if span != stopped:  # one line of the source may be lifted as two statements
                yield from _stop_with_text(span, places)
            stopped = span
        elif isinstance(statement, p.Follow):
            yield from _path_pieces(statement, spans, places)
        else:
            yield map_bodies(statement, lambda b: tuple(_body_without(b, spans, places)))


def _path_pieces(
    follow: p.Follow, spans: Collection[Span], places: Places
) -> Iterator[p.Statement]:
    """A path in pieces, with a stop for each line that has no equivalent."""
    lines, whole = follow.lines, follow.span
    out: list[int] = []
    if lines is not None and whole is not None:
        inside = [s for s in spans if whole.start <= s.start and s.end <= whole.end]
        out = sorted({int(np.searchsorted(lines[:, 0], s.start, side="right")) - 1 for s in inside})
    if not out or lines is None:
        yield follow
        return
    # A line ends with its last row, of an arc with the END.
    ends = np.flatnonzero(np.append(follow.path.kinds[1:], 0) != Kind.END) + 1
    firsts = [0, *ends[:-1].tolist()]
    start = 0
    for line in [*out, len(lines)]:
        stop = firsts[line] if line < len(lines) else len(follow.path)
        if stop > start:
            yield _path_piece(follow, start, stop)
        if line < len(lines):
            yield from _stop_with_text(Span(*lines[line].tolist()), places)
            start = int(ends[line])


def _path_piece(follow: p.Follow, start: int, stop: int) -> p.Follow:
    """Some rows of a path that has lines, as a path of another name if they are not its first."""
    first, last = follow.row_span(start), follow.row_span(stop - 1)
    name = follow.path.name if not start else f"{follow.path.name}_from_{start + 1}"
    path = follow.path.rows(start, stop, name)
    # Places count from the start of the new statement.
    moved = None if path.places is None else path.places - path.places[0, 0]
    return p.Follow(replace(path, places=moved), span=span_over(first, last))


def _stop_with_text(span: Span, places: Places) -> Iterator[p.Statement]:
    """A stop, and the source text of a statement as comments."""
    yield p.Stop(span=span)
    for said in _quoted_text(span, places):
        yield p.Comment(said)


def _quoted_text(span: Span | None, places: Places, text: str = "") -> Iterator[str]:
    """The text at a span as comments, or another one if nothing is known of it."""
    place = places.of(span) if span is not None else None
    file = f"{FilePath(place.path).name} " if place and place.path and places.several else ""
    yield f"{_NOT_TRANSLATED}, {file}line {place.line}:" if place else f"{_NOT_TRANSLATED}:"
    for line in lines_of(place.text if place else text):
        yield _QUOTE_PREFIX + line.strip()

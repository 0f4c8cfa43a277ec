"""Places: where in the texts that a program was lifted from its parts stood."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import (
    Declared,
    Diagnostic,
    Inner,
    Neighbours,
    NumberedMove,
    PathRow,
    Repeated,
    Several,
    SomeTargets,
    Span,
)
from assistant.base.source_text import SourceText, starts_of
from assistant.compiler.loader import language_of
from assistant.languages.language_types import Part
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Kind
from assistant.program.program import Program, bodies, walk
from assistant.program.rewriting import Body, records


@dataclass(frozen=True, slots=True)
class Place:
    """A part of a text. path: of its file, None for standard input. line: counted from 1."""

    path: str | None
    line: int
    text: str


class Places:
    """The texts of a program that was lifted from a vendor language.

    text: of one that was written as a pseudo-program.
    """

    def __init__(self, program: Program, text: SourceText | None = None) -> None:
        self._origin = program.origin
        trees = () if program.origin is None else program.origin.trees
        self._texts = [tree.source or SourceText("") for tree in trees]
        if text is not None and program.origin is None:
            self._texts = [text]
        self._starts = starts_of(self._texts)

    @property
    def texts(self) -> tuple[SourceText, ...]:
        """In their order; the lines of one are counted on behind those of the one before."""
        return tuple(self._texts)

    def lines(self, span: Span) -> tuple[int, int]:
        """First and last line of a span, counted from 1 through all texts; 0, 0 if in none."""
        found = self._local(span)
        if found is None:
            return 0, 0
        source, local = found
        before = 0
        for one in self._texts:
            if one is source:
                break
            before += one.line_count
        # The end is exclusive: at a line end it would count the next line.
        last = max(local.start, local.end - 1)
        first, last = (before + source.line_column(at)[0] for at in (local.start, last))
        return first, last

    @property
    def several(self) -> bool:
        """True if there is more than one text."""
        return len(self._texts) > 1

    def parts(self) -> Iterator[Part]:
        """Yield the parts of the trees other than statements, in order of text."""
        origin = self._origin
        if origin is None:
            return
        language = language_of(origin.language)
        for start, tree in zip(self._starts, origin.trees, strict=True):
            for part in language.parts(tree):
                yield part.moved(start)

    def of(self, span: Span) -> Place | None:
        """The place of a span, None if it is in no text."""
        found = self._local(span)
        if found is None:
            return None
        source, local = found
        line, _ = source.line_column(local.start)
        return Place(source.path, line, source.text[local.start : local.end])

    def spanned(self, finding: Diagnostic) -> Diagnostic:
        """A finding at a line of the only source by its span alone; of several as it is."""
        if len(self._starts) != 1 or finding.span is None:
            return finding
        span = finding.span.moved(self._starts[0])
        return replace(
            finding,
            span=span,
            path=None,
            line=None,
            column=None,
            excerpt=None,
            end_line=None,
            end_column=None,
        )

    def finding(self, finding: Diagnostic) -> Diagnostic:
        """The finding with the file, the line and its text, if it has a span and no line.

        One about data that a text declares gets the line of the declaration, and no span: it is
        about the whole program.
        """
        if finding.line is not None:
            return finding
        if finding.span is None:
            span = self._declared(finding.about) if finding.path is None else None
            if span is None:
                return finding
            return replace(self.finding(replace(finding, span=span)), span=None)
        found = self._local(finding.span)
        if found is None:
            return finding
        source, local = found
        line, column = source.line_column(local.start)
        end_line, end_column = source.line_column(local.end)
        return replace(
            finding,
            path=source.path,
            span=local,
            line=line,
            column=column,
            excerpt=source.line_text(line),
            end_line=end_line,
            end_column=end_column,
        )

    def _declared(self, about: object) -> Span | None:
        """Span of the declaration that a finding is about; None if no text declares it."""
        known = about.declared if isinstance(about, Inner) else about
        if not isinstance(known, Declared) or known.table in (None, "procedures", "paths"):
            return None
        spans = self._data.get((known.owner.lower(), known.name.lower()), [])
        # If a name has several declarations, any of them may be meant.
        return spans[0] if len(spans) == 1 else None

    @cached_property
    def _data(self) -> dict[tuple[str, str], list[Span]]:
        """Owner and name of the data of the texts → where they are declared."""
        found: dict[tuple[str, str], list[Span]] = {}
        for part in self.parts():
            if part.name:
                found.setdefault((part.owner.lower(), part.name.lower()), []).append(part.span)
        return found

    def span(self, finding: Diagnostic) -> Span | None:
        """Return the span of a finding that names the file of one of the texts."""
        if finding.span is None:
            return None
        for start, source in zip(self._starts, self._texts, strict=True):
            if source.path == finding.path:
                return finding.span.moved(start)
        return None

    def _local(self, span: Span) -> tuple[SourceText, Span] | None:
        at = bisect_right(self._starts, span.start) - 1
        if at < 0:
            return None
        source, start = self._texts[at], self._starts[at]
        local = span.moved(-start)
        return (source, local) if local.end <= len(source.text) else None


def at_moves(
    findings: Iterable[Diagnostic], program: Program, places: Places
) -> Iterator[Diagnostic]:
    """Findings about a move by its number, with the file and the line of that move as well.

    program: whose moves were counted, its statements with the spans of the places. They keep to
    the whole program: what is found of one move may be cured at another.
    """
    for finding in findings:
        if finding.span or finding.line:
            yield finding
            continue
        parts: tuple[Any, ...] = (finding.about,)
        spans = [_span_of(finding.about, program)]
        if isinstance(finding.about, Repeated):
            parts = finding.about.parts
            spans = [_span_of(part, program) for part in parts]
            # No part has a place: the finding stays one.
            if not any(spans):
                parts, spans = (finding.about,), [None]
        for part, span in zip(parts, spans, strict=True):
            one = replace(finding, about=part, span=span)
            yield one if span is None else replace(places.finding(one), span=None)


def _span_of(about: object, program: Program) -> Span | None:
    """The span of the first move that a finding is about by its number."""
    match about:
        case NumberedMove(number, name):
            procedure = program.procedure(name)
            count = 0
            for statement in walk(procedure.body) if procedure is not None else ():
                if isinstance(statement, p.Moving) and not isinstance(statement, p.Follow):
                    count += 2 if isinstance(statement, p.MoveCircular) else 1
                if count >= number:
                    return statement.span
        case SomeTargets(of=name, named=(first, *_)):
            return _span_of(first, program) or _move_to(first, name, program)
        case PathRow() | Declared(table=None | "targets"):
            return _move_to(about, "", program)
        case Neighbours(first=first):
            return _span_of(first, program)
        case Several(parts=(first, *_)):
            return _span_of(first, program)
    return None


def _move_to(goal: object, name: str, program: Program) -> Span | None:
    """The span of the first move of a procedure to a target by its name, or to a row of a path."""
    if isinstance(goal, Neighbours):
        goal = goal.first
    procedure = program.procedure(name)
    body = procedure.body if procedure is not None else tuple(program.statements())
    for statement in walk(body):
        match statement, goal:
            case p.Follow(path), PathRow(path=named, row=row) if path.name == named:
                return statement.row_span(row - 1)
            case p.Move() | p.MoveCircular() | p.MoveJoints(), Declared(name=named):
                ends = records((statement.target, getattr(statement, "via", None)))
                if any(isinstance(x, e.Name) and x.name.lower() == named.lower() for x in ends):
                    return statement.span
    return None


class Trace:
    """Positions of the source's statements in the text that was read back.

    adapted: the program as the target language expresses it, its statements with the spans of their
    source. written: as it was read back, None if it could not be.
    """

    def __init__(self, adapted: Program, written: Program | None) -> None:
        self._there = Places(written) if written is not None else None
        pairs = () if written is None else _pairs_of(adapted, written)
        self._went: dict[Span, list[Span]] = {}
        self._from: dict[Span, Span] = {}
        self._paths: dict[Span, tuple[p.Follow, p.Follow]] = {}
        """Paths of the source with those that they became, by the span of either."""
        for one, other in pairs:
            mine, its = one.span, other.span
            if mine is None or its is None:
                continue
            self._went.setdefault(mine, []).append(its)
            self._from.setdefault(its, mine)
            if isinstance(one, p.Follow) and isinstance(other, p.Follow):
                if one.path.places is not None and len(one.path) == len(other.path):
                    self._paths[mine] = self._paths[its] = one, other

    def written(self, span: Span) -> list[Place]:
        """Return the written positions of a statement of the source, in order; empty if unknown."""
        assert self._there is not None or not self._went
        places = [self._there.of(s) for s in self._went.get(span, ())] if self._there else []
        return [place for place in places if place is not None]

    def written_line(self, span: Span, line: int) -> list[Place]:
        """The same of a line of a path, counted from 0."""
        if span not in self._paths or self._there is None:
            return self.written(span)
        mine, its = self._paths[span]
        # A line has one row, or the two of an arc.
        rows = np.flatnonzero(np.append(mine.path.kinds[1:], 0) != Kind.END)
        there = its.row_span(int(rows[line]))
        place = None if there is None else self._there.of(there)
        return [] if place is None else [place]

    def source(self, finding: Diagnostic) -> Span | None:
        """The span in the source that a finding is about, also one in the written text."""
        if finding.line is None or self._there is None:
            return finding.span if finding.line is None else None
        span = self._there.span(finding)
        if span is None:
            return None
        holding = [s for s in self._from if s.start <= span.start and span.end <= s.end]
        inmost = min(holding, key=lambda s: s.end - s.start, default=None)
        if inmost in self._paths:
            return _row_at(*self._paths[inmost], span)
        return self._from[inmost] if inmost is not None else None


def _row_at(mine: p.Follow, its: p.Follow, span: Span) -> Span | None:
    """Return the source span of the path row whose line in the written text holds a span."""
    places = its.path.places
    if places is None or its.span is None:
        return mine.span
    row = int(np.searchsorted(places[:, 0], span.start - its.span.start, side="right")) - 1
    return mine.row_span(row) if row >= 0 else mine.span


def _pairs_of(source: Program, written: Program) -> Iterator[tuple[p.Statement, p.Statement]]:
    there = {q.name.lower(): q for q in written.procedures}
    for procedure in source.procedures:
        other = there.get(procedure.name.lower())
        if other is not None:
            yield from _pairs(procedure.body, other.body)


def _pairs(one: Body, two: Body) -> Iterator[tuple[p.Statement, p.Statement]]:
    """Statements that stand at the same place of two bodies; none where they differ."""
    if list(map(type, one)) != list(map(type, two)):
        return
    for mine, its in zip(one, two, strict=True):
        yield mine, its
        for inner, other in zip(bodies(mine), bodies(its), strict=False):
            yield from _pairs(inner, other)


def at_its_line(finding: Diagnostic, text: SourceText) -> Diagnostic:
    """Return a finding about a statement of a pseudo-program, with the lines of the statement."""
    if finding.span is None or finding.line is not None:
        return finding
    line, column = text.line_column(finding.span.start)
    end_line, end_column = text.line_column(finding.span.end)
    return replace(
        finding,
        path=text.path,
        line=line,
        column=column,
        excerpt=text.line_text(line),
        end_line=end_line,
        end_column=end_column,
    )

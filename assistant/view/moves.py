"""The motion statements of a program: where they stand in its text, and when they are come to."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Final

import numpy as np

from assistant.base.diagnostics import Diagnostic, Span
from assistant.base.source_text import SourceText, lines_of, visible
from assistant.compiler.source_map import Places
from assistant.program.motion import Kind
from assistant.robots.solved_program import Leg, SolvedProgram
from assistant.robots.timing import Simulation
from assistant.robots.timing.segments import Segment
from assistant.robots.timing.uninterrupted_moves import MovesWithoutStop, stretches_of
from assistant.view.motion import Record, column_text
from assistant.view.stages import motion_stages

MOST_MOVES: Final = 2_000
"""Motion statements in the list."""
MOST_PLAYED: Final = 40_000
"""Passings of moves that the time line knows; loops have many."""
MOST_TEXT: Final = 200
"""Characters of a statement, or of a line, that are shown."""
MOST_LINES: Final = 100_000
"""Lines of the program's texts."""

MoveKey = tuple[str, int]
"""Procedure, and number of a motion statement in it."""


def text_records(texts: Sequence[SourceText]) -> tuple[list[Record], int]:
    """The texts, each with its lines and the number of the first; and lines left out."""
    found: list[Record] = []
    first = 1
    for source in texts:
        count = max(0, min(source.line_count, MOST_LINES + 1 - first))
        lines = [visible(source.line_text(i + 1))[:MOST_TEXT] for i in range(count)]
        path = None if source.path is None else visible(source.path)
        found.append({"path": path, "first": first, "lines": lines})
        first += source.line_count
    return found, max(0, first - 1 - MOST_LINES)


class Moves:
    """The motion statements in order of text, and when they are come to in the way that is played.

    until: seconds up to which it is played.
    keys: procedure and number of each. begins: seconds, place in the list and line of the text
    (0 for none), in order of time, of at most `MOST_PLAYED`. until: seconds up to which these are
    all.
    """

    def __init__(
        self, solution: SolvedProgram, simulation: Simulation, places: Places, until: float
    ) -> None:
        self.solution, self.labels, self.texts = solution, simulation.labels, places
        self.keys = list(simulation.labels)
        self.places = {key: i for i, key in enumerate(self.keys)}
        self._in_run = set[MoveKey]()  # statements that are a line each of a run with one span
        self._run: tuple[Span, Sequence[str]] | None = None
        self._lines = dict(self._numbered())
        self.begins: list[tuple[float, int, int]] = []
        self.until = until
        known: dict[int, list[tuple[float, int, int]]] = {}
        for start, passed in motion_stages(simulation, until):
            if len(self.begins) >= MOST_PLAYED:
                self.until = start
                break
            if id(passed) not in known:
                known[id(passed)] = list(self._passings(passed))
            self.begins += [
                (start + time, at, line)
                for time, at, line in known[id(passed)]
                if start + time <= until
            ]
        self.spans: dict[int, int] = {}  # of statements that share one the first
        for name, legs in solution.legs.items():
            for number, leg in enumerate(legs, start=1):
                if leg.statement.span is not None and (name, number) in self.places:
                    self.spans.setdefault(leg.statement.span.start, self.places[name, number])

    def __len__(self) -> int:
        return len(self.keys)

    def records(self) -> list[Record]:
        """Those of the list; `time` is when each begins first, None if it is not played."""
        first: dict[int, float] = {}
        for time, place, _ in self.begins:
            first.setdefault(place, time)
        return [self._record(key, first.get(i)) for i, key in enumerate(self.keys[:MOST_MOVES])]

    def played(self) -> Record:
        times, places, lines = zip(*self.begins, strict=True) if self.begins else ((), (), ())
        return {
            "times": column_text(np.array(times, dtype=np.float64)),
            "moves": column_text(np.array(places, dtype=np.int64)),
            "lines": column_text(np.array(lines, dtype=np.int64)),
            "until": self.until,
        }

    def lines(self) -> tuple[list[Record], int]:
        """The texts, see `text_records`."""
        return text_records(self.texts.texts)

    def of_finding(self, finding: Diagnostic) -> int | None:
        """The place in the list of the statement that a finding is at."""
        return None if finding.span is None else self.spans.get(finding.span.start)

    def line_of(self, key: MoveKey, row: int = 0) -> int:
        """The line of a move, counted through all texts from 1; 0 if it stands in none."""
        rows = self._lines.get(key, ())
        return rows[row] if row < len(rows) else rows[0] if rows else 0

    def _passings(self, passed: MovesWithoutStop) -> Iterator[tuple[float, int, int]]:
        """Moves of a stretch that have a line of their own, and statements, with the seconds in it
        after which they begin.
        """
        stretches = stretches_of(passed.plan)
        before: tuple[Segment, int] | None = None
        rows, first = np.unique(stretches.row, return_index=True)
        for row, at in zip(rows.tolist(), first.tolist(), strict=True):
            piece, inner = passed.piece_of(row)
            key = piece.procedure, piece.number
            line = self.line_of(key, inner)
            if before is None or before[0] is not piece or before[1] != line:
                yield float(stretches.times[at]), self.places[key], line
            before = piece, line

    def _leg(self, key: MoveKey) -> Leg | None:
        procedure, number = key
        legs = self.solution.legs.get(procedure, ())
        return legs[number - 1] if number <= len(legs) else None

    def _numbered(self) -> Iterator[tuple[MoveKey, Sequence[int]]]:
        """Each statement with its line, or with those of its moves.

        A run of like lines has one span: if it has as many lines as moves, each is one of them.
        """
        for name, legs in self.solution.legs.items():
            numbered = enumerate(legs, start=1)
            for span, same in groupby(numbered, key=lambda one: one[1].statement.span):
                run = list(same)
                first, last = (0, 0) if span is None else self.texts.lines(span)
                if first == 0:
                    continue
                moves = [_last_on_line(leg) for _, leg in run]
                told = sum(map(len, moves)) and sum(sum(ends) for ends in moves) == last - first + 1
                line = first
                for (number, _), ends in zip(run, moves, strict=True):
                    lines = []
                    for end in ends or (True,):
                        lines.append(line)
                        line += int(told and end)
                    yield (name, number), tuple(lines) if told else (first,)
                    if told and len(run) > 1:
                        self._in_run.add((name, number))

    def _lines_of_run(self, span: Span, text: str) -> Sequence[str]:
        """Those of the run that was asked for last are kept: its moves come one after the other."""
        if self._run is None or self._run[0] != span:
            self._run = span, lines_of(text)
        return self._run[1]

    def _record(self, key: MoveKey, time: float | None) -> Record:
        procedure, number = key
        leg = self._leg(key)
        span = None if leg is None else leg.statement.span
        place = None if span is None else self.texts.of(span)
        path = None if place is None or place.path is None else visible(place.path)
        line = self.line_of(key)
        if place is not None and span is not None:
            if key in self._in_run:
                own = line - self.texts.lines(span)[0]
                text = self._lines_of_run(span, place.text)[own].strip()
                place = replace(place, line=place.line + own, text=text)
        return {
            "procedure": visible(procedure),
            "number": number,
            "label": visible(self.labels[key].strip("`")),
            "time": time,
            "line": None if place is None else place.line,
            "global": line,
            "path": path,
            "text": "" if place is None else visible(place.text[:MOST_TEXT]),
        }


def _last_on_line(leg: Leg) -> list[bool]:
    """Of each move of a statement whether a line of the text ends with it; two of an arc."""
    if leg.solved_run is None:
        return [True] if len(leg.joints) <= 1 else [False] * (len(leg.joints) - 1) + [True]
    return [bool(end) for end in leg.solved_run.run.kinds[leg.rows] != Kind.VIA]

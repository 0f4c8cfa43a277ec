"""A solved program as rules see it: its linear and circular moves, and where they stand."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.base.diagnostics import Diagnostic, Rule, Span
from assistant.checks.extremes import Extremes, extremes_of
from assistant.checks.moves import Moves, moves_of
from assistant.program.expressions import Number
from assistant.program.program import Program, walk
from assistant.program.statements import Follow, Moving, SetOverride
from assistant.robots import Robot, SolvedProgram
from assistant.robots.solved_program import Leg, SolvedRun

NEIGHBOURS: Final = 2
"""Rows that are at most so far apart are told of together; the points of an arc are two apart."""
MOST_GROUPS: Final = 5
"""Groups of neighbours in a run from which on they are told of together as well."""


@dataclass(frozen=True)
class ProgramView:
    """What rules look at.

    cycle: seconds between two places that the controller commands.
    """

    solution: SolvedProgram
    cycle: float

    @property
    def program(self) -> Program:
        return self.solution.program

    @property
    def robot(self) -> Robot:
        return self.solution.robot

    @cached_property
    def run_views(self) -> tuple[RunView, ...]:
        """The runs of the program in order of text, each with its legs."""
        legs: dict[int, list[Leg]] = {}
        for several in self.solution.legs.values():
            for leg in several:
                if leg.solved_run is not None:
                    legs.setdefault(id(leg.solved_run), []).append(leg)
        shares = _overrides(self.solution)
        solved_runs = self.solution.solved_runs
        return tuple(
            self._view(solved_run, legs[id(solved_run)], shares) for solved_run in solved_runs
        )

    def _view(
        self, solved_run: SolvedRun, legs: Sequence[Leg], shares: dict[int, float]
    ) -> RunView:
        speeds = {name.lower(): speed for name, speed in self.program.speeds.items()}
        blends = {name.lower(): blend for name, blend in self.program.blends.items()}
        moves = moves_of(solved_run, self.robot, speeds, blends)
        return RunView(moves, tuple(sorted(legs, key=lambda leg: leg.rows.start)), shares)


@dataclass(frozen=True)
class RunView:
    """A solved run: its moves, its legs in order of rows, and the override that counts for each.

    shares: id of a leg → what share of the programmed speed it is run with.
    """

    moves: Moves
    legs: tuple[Leg, ...]
    shares: dict[int, float]

    @cached_property
    def extremes(self) -> Extremes:
        return extremes_of(self.moves)

    @cached_property
    def seconds(self) -> Floats:
        """(m,) that the moves take at their speeds and the override; NaN if not known."""
        shares = np.array([self.shares.get(id(leg), 1.0) for leg in self.legs])
        return np.asarray(self.moves.seconds / shares[self.leg_of(self.moves.rows)])

    @cached_property
    def firsts(self) -> Rows:
        """First row of each leg."""
        return np.array([leg.rows.start for leg in self.legs], dtype=np.intp)

    def leg_of(self, rows: Rows) -> Rows:
        """Which legs some rows are of."""
        return np.asarray(np.searchsorted(self.firsts, rows, side="right") - 1)

    def groups(self, rows: Rows, badness: Floats) -> Iterator[tuple[Rows, int]]:
        """Rows of the run (k,) ascending, each group with the place of its worst.

        Neighbours are together, and so are the rows of a path that have no lines of their own. The
        place is one among the k of badness (k,), of which more is worse.
        """
        leg = self.leg_of(rows)
        alone = np.array([_has_lines(one.statement) for one in self.legs], dtype=bool)[leg]
        apart = (np.diff(leg) > 0) | alone[1:]
        cuts = np.flatnonzero((np.diff(rows) > NEIGHBOURS) & apart) + 1
        if len(cuts) >= MOST_GROUPS:
            cuts = cuts[:0]
        at = np.arange(len(rows))
        for each in np.split(at, cuts) if len(at) else ():
            yield rows[each], int(each[badness[each].argmax()])

    def told(self, rule: Rule, rows: Rows, row: int, **fields: Any) -> Diagnostic:
        """A finding about some rows, the worst of which is one of them."""
        where = f" (worst at {self.moves.run.label(row)})" if len(rows) > 1 else ""
        about = self.moves.run.what(rows)
        return rule(about=about, span=self.span(row), worst=where, **fields)

    def span(self, row: int) -> Span | None:
        """The source location of the move to a row."""
        leg = self.legs[int(self.leg_of(np.array([row]))[0])]
        if isinstance(leg.statement, Follow):
            return leg.statement.row_span(row - leg.rows.start)
        return leg.statement.span


def _has_lines(statement: Moving) -> bool:
    """True if each row of the statement has a line of its own in the text."""
    return isinstance(statement, Follow) and statement.path.places is not None


def _overrides(solution: SolvedProgram) -> dict[int, float]:
    """Id of a leg → the override above it, as a share of the programmed speed.

    A procedure begins with the largest one that the program states, the first one with 1. One
    that only running the program tells counts as 1.
    """
    program = solution.program
    stated = [_override_share(s) for s in program.statements() if isinstance(s, SetOverride)]
    shares: dict[int, float] = {}
    for procedure in program.procedures if stated else ():
        first = program.entry is not None and procedure.name.lower() == program.entry.lower()
        share = 1.0 if first else max(stated)
        legs = iter(solution.legs.get(procedure.name, ()))
        for statement in walk(procedure.body):
            if isinstance(statement, SetOverride):
                share = _override_share(statement)
            elif isinstance(statement, Moving):
                leg = next(legs, None)
                shares[id(leg)] = share
    return shares


def _override_share(statement: SetOverride) -> float:
    value = statement.percent
    if isinstance(value, Number) and 0.0 < float(value.value) <= 100.0:
        return float(value.value) / 100.0
    return 1.0


def figure(value: float) -> str:
    """A measured value in three digits, never as a power of ten."""
    return f"{float(f'{value:.3g}'):g}"

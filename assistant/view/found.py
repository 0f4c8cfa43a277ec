"""Findings on a page: in the list, at their lines, and at their places in the cell."""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic
from assistant.base.source_text import visible
from assistant.cell.clearances import Closeness
from assistant.cell.collision.model import Carriers
from assistant.cell.scene import CORE_SUFFIX
from assistant.program.program import Program
from assistant.view.located import LocatedTargets
from assistant.view.motion import Motion, Record
from assistant.view.moves import MOST_MOVES, Moves
from assistant.view.shown import Marked, Shown
from assistant.view.still import StillMotion, StillMoves

MOST_FINDINGS: Final = 500


def finding_records(
    shown: Shown, motion: Motion | StillMotion, moves: Moves | StillMoves, program: Program
) -> list[Record]:
    """The first of them. program: that is shown."""
    lines = _CountedLines(shown, moves)
    located = LocatedTargets(shown.told or program, shown.base)
    return [
        _finding_record(shown, motion, moves, marked, lines, located)
        for marked in shown.findings[:MOST_FINDINGS]
    ]


class _CountedLines:
    """Lines of the texts of a page, counted through all of them, by file and line."""

    def __init__(self, shown: Shown, moves: Moves | StillMoves) -> None:
        self._moves: dict[int, int] = {}
        for number, one in enumerate(moves.records()):
            self._moves.setdefault(one["global"], number)
        self._own = _first_lines([(one.path, one.line_count) for one in shown.places.texts])
        beside = () if shown.beside is None else shown.beside.texts
        self._beside = _first_lines([(one.path, one.line_count) for one in beside])

    def of(self, finding: Diagnostic, own: bool) -> tuple[int, int]:
        """In the text of the program, and in what it was made of; 0 for in none.

        own: whether it is told of the program, and not of what that was made of.
        """
        first, other = (known.get(finding.path) for known in (self._own, self._beside))
        line = finding.line
        return (
            0 if first is None or line is None or not own else first + line - 1,
            0 if other is None or line is None else other + line - 1,
        )

    def move(self, line: int) -> int | None:
        """The motion statement that begins in a line of the program."""
        return self._moves.get(line) if line else None


def _first_lines(texts: list[tuple[str | None, int]]) -> dict[str | None, int]:
    found: dict[str | None, int] = {}
    first = 1
    for path, count in texts:
        found.setdefault(path, first)
        first += count
    return found


def _finding_record(
    shown: Shown,
    motion: Motion | StillMotion,
    moves: Moves | StillMoves,
    marked: Marked,
    lines: _CountedLines,
    located: LocatedTargets,
) -> Record:
    finding, close = marked
    own = shown.spans is None or close is not None
    place = located.of(finding) if close is None else None
    placed = (shown.places if own else shown.spans or shown.places).finding(finding)
    line, beside = lines.of(placed, own)
    move = moves.of_finding(finding) if own and finding.line is None else lines.move(line)
    mark: Record | None = None
    if close is not None and isinstance(moves, Moves) and isinstance(motion, Motion):
        mark = _contact_record(shown, motion, close)
        move = moves.places.get((close.procedure, close.number))
    return {
        "code": finding.code,
        "severity": finding.severity.value,
        "message": visible(finding.message),
        "cure": None if finding.cure is None else visible(finding.cure),
        "where": visible(placed.where()),
        "move": move if move is not None and move < MOST_MOVES else None,
        "line": line,
        "beside": beside,
        "mark": mark,
        "at": place,
        "time": None if place is None else motion.passing(np.array(place)),
    }


def _contact_record(shown: Shown, motion: Motion, close: Closeness) -> Record:
    contact = close.contact
    at = _own_joints(shown, close.joints)
    return {
        "one": visible(contact.one.removesuffix(CORE_SUFFIX)),
        "other": visible(contact.other.removesuffix(CORE_SUFFIX)),
        "points": [list(point) for point in contact.points],
        "normal": list(contact.normal),
        "deep": max(0.0, -min(close.least, contact.distance)),
        "joints": motion.robot.chained(at[None])[0].tolist(),
        "time": motion.when(at),
    }


def _own_joints(shown: Shown, joints: Floats) -> Floats:
    """Of a row of the joints of all robots those of the one that moves."""
    carriers = Carriers(shown.scene.robots)
    at = next(i for i, one in enumerate(shown.scene.robots) if one is shown.placed)
    return joints[carriers.columns[at]]

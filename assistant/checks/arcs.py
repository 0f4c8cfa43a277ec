"""Arcs that no controller can run, or whose circle its three points hardly tell."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.base.diagnostics import Declared, Diagnostic, PathRow, Rule, Span, error, info
from assistant.program.expressions import Expression, Name, TargetValue
from assistant.program.geometry import ArcMeasures
from assistant.program.motion import Kind
from assistant.program.program import Program, bodies
from assistant.program.statements import Follow, Move, MoveCircular, Statement

_Place = Callable[[int], tuple[Declared | PathRow, Span | None]]
"""Row of an arc → where it is, and the line of its move if it has one."""

LEAST_APART: Final = 0.1
"""mm between start, via and end below which an IRC5 refuses an arc (RAPID manual, MoveC)."""
LEAST_HEIGHT: Final = 0.001
"""mm of the via point beside the chord below which an arc has no certain plane."""

LEAST_ANGLE: Final = 1.0
"""degrees between via point and end, seen from the start (RAPID manual, MoveC)."""
MOST_ANGLE: Final = 240.0
"""degrees that an arc should go round at most (RAPID manual, MoveC)."""

TOO_CLOSE = error(
    "CK101",
    "two points of an arc are the same or less than 0.1 mm apart",
    "move them apart, use a linear move, or split a full circle into two arcs",
)
STRAIGHT = error(
    "CK102",
    "the three points of an arc lie on one line",
    "use a linear move, or put the via point beside the line",
)
NEARLY_STRAIGHT = info(
    "CK103",
    "an arc is nearly straight: seen from its start, its points are {angle:.2f} degrees apart",
    "use a linear move; RAPID asks for 1 degree at least",
)
NEARLY_ROUND = info(
    "CK104",
    "an arc goes round {angle:.0f} degrees",
    "split it: up to 240 degrees its three points tell the circle well",
)


def arcs(program: Program) -> Iterator[Diagnostic]:
    for procedure in program.procedures:
        about = Declared(procedure.name, "procedures", in_full=True)
        yield from _arcs_in_body(program, procedure.body, about)


def _arcs_in_body(
    program: Program, body: tuple[Statement, ...], about: Declared
) -> Iterator[Diagnostic]:
    """Follows the position through straight code; where it is not known only the rest counts."""
    here: Floats | None = None
    for statement in body:
        match statement:
            case Follow(path=path):
                yield from _arcs_of_path(statement, here)
                here = path.positions[-1] if len(path) else here
            case Move(target=target):
                here = _position_of(program, target)
            case MoveCircular(via=via, target=target):
                points = [here, _position_of(program, via), _position_of(program, target)]
                row = np.array([p if p is not None else np.full(3, np.nan) for p in points])
                yield from _arc_findings(row[None], _fixed_place(about, statement.span))
                here = points[2]
            case _:
                here = None if bodies(statement) else here
        for inner in bodies(statement):
            yield from _arcs_in_body(program, inner, about)


def _fixed_place(about: Declared, span: Span | None) -> _Place:
    return lambda _: (about, span)


def _arcs_of_path(follow: Follow, before: Floats | None) -> Iterator[Diagnostic]:
    path = follow.path
    vias = np.flatnonzero(path.kinds == Kind.VIA)
    vias = vias[vias + 1 < len(path)]
    if not len(vias):
        return
    starts = path.positions[np.maximum(vias - 1, 0)].copy()
    if vias[0] == 0:
        starts[0] = before if before is not None else np.nan
    points = np.stack([starts, path.positions[vias], path.positions[vias + 1]], axis=1)

    def place(row: int) -> tuple[PathRow, Span | None]:
        via = int(vias[row])
        span = None if path.places is None else follow.row_span(via)
        return PathRow(path.name, via + 1, in_full=True), span

    yield from _arc_findings(points, place)


def _arc_findings(points: Floats, place: _Place) -> Iterator[Diagnostic]:
    """points: (n, 3, 3) start, via and end; NaN for a point that is not known."""
    arcs = ArcMeasures.through(points)
    close = (arcs.sides < LEAST_APART).any(axis=1)  # NaN is no length, so it never is
    straight = ~close & (arcs.area < LEAST_HEIGHT * arcs.sides[:, 2])
    for rule, rows in ((TOO_CLOSE, close), (STRAIGHT, straight)):
        for row in np.flatnonzero(rows):
            about, span = place(int(row))
            yield rule(about=about, span=span)
    sound = ~close & ~straight & np.isfinite(arcs.sides).all(axis=1)
    for rule, angle, rows in (
        (NEARLY_STRAIGHT, arcs.apart, sound & (arcs.apart < LEAST_ANGLE)),
        (NEARLY_ROUND, arcs.around, sound & (arcs.around > MOST_ANGLE)),
    ):
        yield from _angle_findings(rule, angle, np.flatnonzero(rows), place)


def _angle_findings(rule: Rule, angle: Floats, rows: Rows, place: _Place) -> Iterator[Diagnostic]:
    """One finding for all rows of a path, with the angle of the worst; one for each that has a
    line of its own.
    """
    if not len(rows):
        return
    worst = int(rows[(angle if rule is NEARLY_ROUND else -angle)[rows].argmax()])
    about, span = place(worst)
    if span is not None:
        for row in rows.tolist():
            about, span = place(row)
            yield rule(about=about, span=span, angle=angle[row])
        return
    if isinstance(about, PathRow):
        about = replace(about, more=len(rows) - 1)
    yield rule(about=about, angle=angle[worst])


def _position_of(program: Program, expression: Expression) -> Floats | None:
    if isinstance(expression, TargetValue):
        return np.array(expression.target.pose.position)
    target = program.targets.get(expression.name) if isinstance(expression, Name) else None
    return None if target is None else np.array(target.pose.position)

"""Rules about a neutral program that need no robot: arcs, speeds, outputs and signals.

Arcs that no controller can run, or whose circle its three points hardly define; speeds (mm/s) and
corner radii (mm) that look like a mistaken unit or a lost digit; outputs set during a move at a
position that the move does not reach; signals that share a number, and group signals compared with
numbers beyond their bits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.base.diagnostics import (
    Declared,
    Diagnostic,
    PathRow,
    Rule,
    Severity,
    Span,
    error,
    info,
    warning,
)
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.io_use import sets_on_way, used_signal_names
from assistant.program.analysis.motion_use import straight_lengths
from assistant.program.analysis.uses import constant_numbers, constant_value
from assistant.program.expressions import Expression, Name, Number, TargetValue
from assistant.program.geometry import ArcMeasures
from assistant.program.motion import Blend, Kind, Speed
from assistant.program.program import Program, bodies, walk
from assistant.program.rewriting import head, records
from assistant.program.statements import (
    Follow,
    Measure,
    Move,
    MoveCircular,
    MoveStatement,
    Statement,
)

_Place = Callable[[int], tuple[Declared | PathRow, Span | None]]
"""Row of an arc → where it is, and the line of its move if it has one."""

_LEAST_APART: Final = 0.1
"""mm between start, via and end below which an IRC5 refuses an arc (RAPID manual, MoveC)."""
_LEAST_HEIGHT: Final = 0.001
"""mm of the via point beside the chord below which an arc has no certain plane."""

_LEAST_ANGLE: Final = 1.0
"""degrees between via point and end, seen from the start (RAPID manual, MoveC)."""
_MOST_ANGLE: Final = 240.0
"""degrees that an arc should go round at most (RAPID manual, MoveC)."""

_TOO_CLOSE = error(
    "CK101",
    "two points of an arc are the same or less than 0.1 mm apart",
    "move them apart, use a linear move, or split a full circle into two arcs",
)
_STRAIGHT = error(
    "CK102",
    "the three points of an arc lie on one line",
    "use a linear move, or put the via point beside the line",
)
_NEARLY_STRAIGHT = info(
    "CK103",
    "an arc is nearly straight: seen from its start, its points are {angle:.2f} degrees apart",
    "use a linear move; RAPID asks for 1 degree at least",
)
_NEARLY_ROUND = info(
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
    close = (arcs.sides < _LEAST_APART).any(axis=1)  # NaN is no length, so it never is
    straight = ~close & (arcs.area < _LEAST_HEIGHT * arcs.sides[:, 2])
    for rule, rows in ((_TOO_CLOSE, close), (_STRAIGHT, straight)):
        for row in np.flatnonzero(rows):
            about, span = place(int(row))
            yield rule(about=about, span=span)
    sound = ~close & ~straight & np.isfinite(arcs.sides).all(axis=1)
    for rule, angle, rows in (
        (_NEARLY_STRAIGHT, arcs.apart, sound & (arcs.apart < _LEAST_ANGLE)),
        (_NEARLY_ROUND, arcs.around, sound & (arcs.around > _MOST_ANGLE)),
    ):
        yield from _angle_findings(rule, angle, np.flatnonzero(rows), place)


def _angle_findings(rule: Rule, angle: Floats, rows: Rows, place: _Place) -> Iterator[Diagnostic]:
    """Yield one finding for all rows of a path, with the angle of the worst row; one finding per
    row if each row has a separate line.
    """
    if not len(rows):
        return
    worst = int(rows[(angle if rule is _NEARLY_ROUND else -angle)[rows].argmax()])
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


_SLOWEST_SPEED: Final = 0.01
_FASTEST_SPEED: Final = 20_000.0
"""mm/s. Below the one a controller's own printing leaves nothing; above the other no arm is."""
_SMALLEST_RADIUS: Final = 0.01
_LARGEST_RADIUS: Final = 5_000.0
"""mm of corner radius that a program can print, and that fits into a cell."""

_IMPLAUSIBLE_SPEED = error(
    "CK201", "a speed of {value:g} mm/s cannot be meant", "state speeds in mm/s, from 0.01 to 20000"
)
_IMPLAUSIBLE_BLEND = error(
    "CK202",
    "a corner radius of {value:g} mm cannot be meant",
    "state it in mm, from 0.01 to 5000, or stop at the target with `fine`",
)


def magnitudes(program: Program) -> Iterator[Diagnostic]:
    """Every speed and blend that the program states, named ones and those of paths as well.

    Those of a path without lines are reported once each.
    """
    moved: set[str] = set()
    for statement in program.statements():
        if isinstance(statement, Follow):
            yield from _magnitudes_of_path(statement)
            tables = (*statement.path.speeds, *statement.path.blends)
            moved.update(v.name.lower() for v in tables if isinstance(v, Name))
            continue
        stated: dict[Speed | Blend, None] = {}
        for part in records(head(statement)):
            if isinstance(part, Speed | Blend):
                stated[part] = None
            elif isinstance(part, Name):
                moved.add(part.name.lower())
        for value in stated:
            yield from _implausible(value, span=statement.span)
    for name, speed in program.speeds.items():
        if name.lower() in moved or not _is_of_other_axes(speed):
            yield from _implausible(speed, about=Declared(name, "speeds"))
    for name, blend in program.blends.items():
        yield from _implausible(blend, about=Declared(name, "blends"))


def _magnitudes_of_path(statement: Follow) -> Iterator[Diagnostic]:
    """Findings on speeds and blends of a path, at each of its rows that has a line."""
    path = statement.path
    for table, column in ((path.speeds, path.speed), (path.blends, path.blend)):
        for number, value in enumerate(table):
            found = (
                () if isinstance(value, Name) else tuple(_implausible(value, span=statement.span))
            )
            if not found or path.places is None:
                yield from found
                continue
            rows = np.flatnonzero(column == number).tolist()
            for span in dict.fromkeys(map(statement.row_span, rows)):
                yield from (replace(one, span=span) for one in found)


def _implausible(value: Speed | Blend, **place: Any) -> Iterator[Diagnostic]:
    if isinstance(value, Speed):
        if math.isfinite(value.tcp) and not _SLOWEST_SPEED <= value.tcp <= _FASTEST_SPEED:
            yield _IMPLAUSIBLE_SPEED(value=value.tcp, **place)
        return
    radii = [r for r in (value.radius, value.exit) if r is not None and math.isfinite(r)]
    yield from (
        _IMPLAUSIBLE_BLEND(value=r, **place)
        for r in radii
        if not _SMALLEST_RADIUS <= r <= _LARGEST_RADIUS
    )


def _is_of_other_axes(speed: Speed) -> bool:
    """True for a speed at which only external axes or the tool's rotation move."""
    return speed.tcp == 0 and any((speed.rotation, speed.external_linear, speed.external_rotary))


_BEYOND_PATH = warning(
    "CK111",
    "`{name}` is set {amount:g} mm {where} of a way of {length:.2f} mm",
    "give a distance within the way, or set it before the move",
)
_OUTSIDE_PATH = error(
    "CK112",
    "`{name}` is set at {amount:g} {unit} of the way of a move, which no way has",
    "write {most}",
)
ENDS: Final[Mapping[Measure, str]] = {"start": "behind the start", "end": "before the end"}
_UNITS: Final[Mapping[Measure, str]] = {"start": "mm", "end": "mm", "time": "s", "share": "%"}


def outputs(program: Program) -> Iterator[Diagnostic]:
    """Find outputs set before the start of a move, or after the end of a straight move of known
    length.
    """
    if not sets_on_way(program):
        return
    known = straight_lengths(program)
    for procedure in program.procedures:
        numbers = constant_numbers(program, procedure)
        moves = [x for x in walk(procedure.body) if isinstance(x, MoveStatement)]
        for move, one in [(x, one) for x in moves for one in x.triggers]:
            stated = constant_value(one.amount, numbers)
            if isinstance(stated, Number):
                amount, length = float(stated.value), known.get(id(move))
                if amount < 0 or (one.measure == "share" and amount > 100):
                    unit = _UNITS[one.measure]
                    most = "0 to 100 %" if one.measure == "share" else f"0 {unit} or more"
                    yield _OUTSIDE_PATH(
                        name=one.signal, amount=amount, unit=unit, most=most, span=move.span
                    )
                elif length is not None and one.measure in ENDS and amount > length:
                    where = ENDS[one.measure]
                    yield _BEYOND_PATH(
                        name=one.signal, amount=amount, where=where, length=length, span=move.span
                    )


_SHARED_NUMBER: Final = warning(
    "CK121",
    "`{name}` and `{other}` are both the {kind} {direction} {number}",
    "give each signal its own number, or use one name for it",
)
_BEYOND_BITS: Final = warning(
    "CK122",
    "`{name}` has {bits} bits, 0 to {most}, and is compared with {value:g}",
    "give the group as many bits as the number needs, or correct the number",
)
_LEAST_SIGNED_BITS: Final = 16
"""Bits from which on controllers may take a group for a number with a sign."""
_COMPARISONS: Final = frozenset(("=", "<>", "<", ">", "<=", ">="))


def shared_numbers(program: Program) -> Iterator[Diagnostic]:
    """Signals of one kind and direction with the same number: an error if both are used.

    A digital signal may be a bit of a group: controllers read both. So they do with a group input
    that is the lower bits of a wider one, which is mostly a mistake all the same.
    """
    used: set[str] | None = None
    found: dict[tuple[str, str, int], str] = {}
    for name, signal in program.signals.items():
        if signal.number is None:
            continue
        key = (signal.kind, signal.direction, signal.number)
        other = found.setdefault(key, name)
        if other != name:
            used = used_signal_names(program) if used is None else used
            both = {name.lower(), other.lower()} <= used
            if signal.direction == "input" and signal.bits != program.signals[other].bits:
                both = False
            yield _SHARED_NUMBER(
                severity=Severity.ERROR if both else Severity.WARNING,
                name=name,
                other=other,
                kind=signal.kind,
                direction=signal.direction,
                number=signal.number,
                about=Declared(name, "signals"),
            )


def group_values(program: Program) -> Iterator[Diagnostic]:
    """Comparisons of groups, and of data that was read from one, with numbers beyond their bits."""
    groups = {
        name.lower(): (name, signal.bits)
        for name, signal in program.signals.items()
        if signal.kind == "group" and signal.number is not None
    }
    if not groups:
        return
    for procedure in program.procedures:
        for statement in walk(procedure.body):
            names = groups
            if isinstance(statement, p.While):  # an answer is asked for until it is in its range
                names = {**groups, **_group_data(statement.body, groups)}
            for name, bits, value in _group_comparisons(statement, names):
                most = 2**bits - 1
                least = -(2 ** (bits - 1)) if bits >= _LEAST_SIGNED_BITS else 0
                if not least <= value <= most:
                    yield _BEYOND_BITS(
                        name=name, bits=bits, most=most, value=value, span=statement.span
                    )


def _group_data(
    body: tuple[p.Statement, ...], groups: dict[str, tuple[str, int]]
) -> dict[str, tuple[str, int]]:
    """By lower-case name the data that a loop reads from groups, with the group."""
    return {
        x.target.name.lower(): groups[x.value.name.lower()]
        for x in body
        if isinstance(x, p.Assign) and isinstance(x.target, e.Name) and isinstance(x.value, e.Name)
        if x.value.name.lower() in groups
    }


def _group_comparisons(
    statement: p.Statement, names: dict[str, tuple[str, int]]
) -> Iterator[tuple[str, int, float]]:
    """Groups of a statement, their bits, and the numbers that they are compared with."""
    if isinstance(statement, p.WaitSignal) and isinstance(statement.value, e.Number):
        if statement.signal.lower() in names:
            yield *names[statement.signal.lower()], float(statement.value.value)
    for part in records(head(statement)):
        match part:
            case e.Binary(operator, e.Name(name), e.Number(value)) | e.Binary(
                operator, e.Number(value), e.Name(name)
            ) if operator in _COMPARISONS and name.lower() in names:
                yield *names[name.lower()], float(value)

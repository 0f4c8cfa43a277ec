"""Rules of moves: positions that were never taught, flags, arcs, corners at a stop."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from assistant.languages.melfa_basic.checks import motion_rules as rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.checks.kinds import literal
from assistant.languages.melfa_basic.checks.steps import row_span
from assistant.languages.melfa_basic.checks.variables_of import known
from assistant.languages.melfa_basic.tables.vocabulary import commands
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import KEYWORDS, MOV, MVR, MoveRows
from assistant.languages.melfa_basic.tree.positions import NO_FLAGS, Positions
from assistant.program.arrays import Floats, Ints, Truths
from assistant.program.diagnostics import Diagnostic

Found = Iterator[Diagnostic]

NEAR: Final = 0.05
"""mm: points that are nearer to each other are the same one."""
STRAIGHT: Final = 0.01
"""mm: how far the second point of an arc must at least be beside the line of the others."""


@dataclass(slots=True)
class Moves:
    """n moves in the order of the lines, those to plain positions of the file's own lines.

    kinds: (n,) rows of KEYWORDS, -1 for others. follows: (n,) whether the robot is surely where
    the move before it ends. ends, vias, starts: (n, 3) mm, NaN where not known. flags: (n,) of
    the end, -1 where not known. typed: (n,) `Type` with 1 or 2 at its second place.
    places: the item of each move and the row in it. names: of the end, the start.
    """

    kinds: Ints
    follows: Truths
    ends: Floats
    vias: Floats
    starts: Floats
    flags: Ints
    typed: Truths
    items: Sequence[s.Line | MoveRows]
    item: Ints
    row: Ints

    def __len__(self) -> int:
        return len(self.kinds)


@dataclass(slots=True)
class _Piece:
    """A line or a table of moves, as columns of Moves."""

    item: s.Line | MoveRows
    kinds: Ints
    follows: Truths
    points: list[Floats]
    flags: Ints
    typed: Truths
    rows: Ints = field(default_factory=lambda: np.zeros(1, np.int64))


def moves(look: Look) -> Moves:
    """Worked out once for a file."""
    positions = look.once(_positions)
    changed = _changed(look)
    pieces: list[_Piece] = []
    follows = False
    for item in look.code:
        if isinstance(item, MoveRows):
            pieces.append(_of_rows(item, positions, changed, follows=follows))
            follows = True
            continue
        if item.label is not None:
            follows = False
        if isinstance(item.statement, s.Motion):
            piece = _of_line(item, item.statement, positions, changed, follows=follows)
            pieces.append(piece)
            follows = item.statement.append is None
        elif not _is_harmless(item.statement):
            follows = False
    return _joined(pieces)


def _positions(look: Look) -> Positions:
    return Positions(look.tree)


def _changed(look: Look) -> set[str]:
    """Positions that the program gives a value while it runs."""
    return {use.variable.key for _, use in look.uses if use.role in ("written", "either")}


KEEPS: Final = (s.Print, s.Open, s.Close, s.DefNames, s.Dim, s.DefOther, s.DefIo, s.Const)
"""Statements after which the robot is where it was, beside commands that say so."""


def _is_harmless(statement: s.Statement | None) -> bool:
    match statement:
        case None:
            return True
        case s.Command(keyword=keyword):
            return keyword in commands("stays")
        case s.Assign():
            return True
    return isinstance(statement, KEEPS)


def _of_rows(rows: MoveRows, positions: Positions, changed: set[str], *, follows: bool) -> _Piece:
    stem = rows.stem.upper()
    points: list[Floats] = []
    flags = np.full(len(rows), NO_FLAGS, dtype=np.int64)
    moved = np.array(
        [int(n[len(stem) :]) for n in changed if n.startswith(stem) and n[len(stem) :].isdigit()],
        dtype=np.int64,
    )
    for numbers in (rows.end, rows.via, rows.start):
        values, marks, found = positions.find(stem, numbers)
        found = found & ~np.isin(numbers, moved) if len(moved) else found
        where = np.where(found[:, None], values[:, :3], np.nan)
        points.append(where)
        if numbers is rows.end:
            flags = np.where(found, marks[:, 0], NO_FLAGS)
    begin = np.ones(len(rows), dtype=bool)
    begin[0] = follows
    return _Piece(
        rows, rows.kinds, begin, points, flags, np.zeros(len(rows), dtype=bool),
        np.arange(len(rows), dtype=np.int64),
    )  # fmt: skip


def _of_line(
    line: s.Line, motion: s.Motion, positions: Positions, changed: set[str], *, follows: bool
) -> _Piece:
    kind = KEYWORDS.index(motion.keyword) if motion.keyword in KEYWORDS else -1
    named: list[s.Expression | None] = [None, None, None]
    if kind == MVR and len(motion.arguments) >= ARC_POINTS:
        named = [motion.arguments[2], motion.arguments[1], motion.arguments[0]]
    elif kind >= 0 and len(motion.arguments) == 1:
        named = [motion.arguments[0], None, None]
    points, flags = [], np.full(1, NO_FLAGS, dtype=np.int64)
    for at, expression in enumerate(named):
        point = np.full((1, 3), np.nan)
        constant = _constant(expression, positions, changed)
        if constant is not None:
            values = [np.nan if v is None else v for v in (*constant.values, None, None, None)]
            point[0] = values[:3]
            if at == 0 and constant.flags is not None and constant.flags[0] is not None:
                flags[0] = constant.flags[0]
        points.append(point)
    second = literal(motion.type[1]) if motion.type else 0
    return _Piece(
        line, np.array([kind]), np.array([follows]), points, flags, np.array([second in (1, 2)])
    )


ARC_POINTS: Final = 3


def _constant(
    expression: s.Expression | None, positions: Positions, changed: set[str]
) -> s.Constant | None:
    if isinstance(expression, s.Constant):
        return expression
    if isinstance(expression, s.Variable) and expression.arguments is None:
        plain = not expression.component and expression.key[0] == "P"
        if plain and expression.key not in changed:
            return positions.constant(expression.key)
    return None


def _joined(pieces: list[_Piece]) -> Moves:
    def column(arrays: list[Any], empty: Any) -> Any:
        return np.concatenate(arrays) if arrays else empty

    none = np.empty(0, np.int64)
    nowhere = np.empty((0, 3))
    sizes = [len(piece.kinds) for piece in pieces]
    return Moves(
        column([p.kinds for p in pieces], none),
        column([p.follows for p in pieces], np.empty(0, bool)),
        column([p.points[0] for p in pieces], nowhere),
        column([p.points[1] for p in pieces], nowhere),
        column([p.points[2] for p in pieces], nowhere),
        column([p.flags for p in pieces], none),
        column([p.typed for p in pieces], np.empty(0, bool)),
        [piece.item for piece in pieces],
        np.repeat(np.arange(len(pieces)), sizes),
        column([p.rows for p in pieces], none),
    )


# --------------------------------------------------------------------------------------- rules


def never_taught(look: Look) -> Found:
    """Moves to positions that are all zeros, or that were left without a value."""
    names = look.once(known)
    zeros: dict[str, str] = {}
    for item in look.data:
        if isinstance(item, s.Data) and isinstance(item.value, s.Constant):
            values = [v for v in item.value.values if v is not None]
            key = item.variable.key
            if key in names.given and not _is_given_elsewhere(look, key) and values:
                if not any(values) and key[0] == "P":
                    zeros[key] = "all its values are 0"
    seen: set[str] = set()
    for line, motion in look.all(s.Motion):
        for argument in motion.arguments:
            if isinstance(argument, s.Variable) and argument.key in zeros:
                key = argument.key
                if key not in seen and argument.arguments is None and not argument.component:
                    seen.add(key)
                    name = argument.name
                    yield look.at(
                        rules.NEVER_TAUGHT, line, name, name=name, what=zeros[key], more=""
                    )
    yield from _zero_rows(look)


def _is_given_elsewhere(look: Look, key: str) -> bool:
    return key in look.once(_changed)


def _zero_rows(look: Look) -> Found:
    run = look.once(moves)
    zero = (run.ends == 0).all(axis=1)
    for at in np.flatnonzero(zero)[:1].tolist():
        item = run.items[int(run.item[at])]
        if isinstance(item, MoveRows):
            row = int(run.row[at])
            name = f"{item.stem}{int(item.end[row])}"
            yield look.finding(
                rules.NEVER_TAUGHT,
                row_span(look, item, row, name),
                name=name,
                what="it lies in the origin",
                more=_more(int(zero.sum()) - 1),
            )


def flags(look: Look) -> Found:
    """Linear moves and arcs between positions of different structure flags."""
    run = look.once(moves)
    if len(run) < 2:
        return
    before = np.concatenate([[NO_FLAGS], run.flags[:-1]])
    straight = (run.kinds > MOV) & run.follows & ~run.typed
    wrong = straight & (before != NO_FLAGS) & (run.flags != NO_FLAGS) & (before != run.flags)
    hits = np.flatnonzero(wrong)
    for at in hits[:MOST].tolist():
        more = _more(len(hits) - MOST) if at == hits[MOST - 1 : MOST].sum() else ""
        item = run.items[int(run.item[at])]
        name, where = _end(look, item, int(run.row[at]))
        yield look.finding(
            rules.FLAGS,
            where,
            word=KEYWORDS[run.kinds[at]],
            before=int(before[at]),
            after=int(run.flags[at]),
            name=name,
            more=more,
        )


MOST: Final = 5
"""Moves of one kind of mistake that are told one by one."""


def _more(count: int) -> str:
    return f" and {count} more like it" if count > 0 else ""


def _end(look: Look, item: s.Line | MoveRows, row: int) -> tuple[str, Any]:
    """The name of the position that a move ends at, and where the move stands."""
    if isinstance(item, MoveRows):
        name = f"{item.stem}{int(item.end[row])}"
        return name, row_span(look, item, row, name)
    motion = item.statement
    end = motion.arguments[-1] if isinstance(motion, s.Motion) else None
    if isinstance(end, s.Variable):
        return end.name, look.place(item, end) or item
    return "the end", item


def arcs(look: Look) -> Found:
    """Arcs that are no arcs, and arcs that start elsewhere."""
    run = look.once(moves)
    arc = run.kinds == MVR
    if not arc.any():
        return
    one, two = run.vias - run.starts, run.ends - run.starts
    chord = np.linalg.norm(two, axis=1)
    off = np.linalg.norm(np.cross(one, two), axis=1) / np.maximum(chord, NEAR)
    near = (np.linalg.norm(one, axis=1) < NEAR) | (chord < NEAR)
    near |= np.linalg.norm(run.ends - run.vias, axis=1) < NEAR
    for hits, what in (
        (np.flatnonzero(arc & near), "two points of the arc are the same"),
        (np.flatnonzero(arc & ~near & (off < STRAIGHT)), "the points of the arc lie in a line"),
    ):
        if len(hits):
            _, where = _end(look, run.items[int(run.item[hits[0]])], int(run.row[hits[0]]))
            yield look.finding(rules.ARC_STRAIGHT, where, what=what, more=_more(len(hits) - 1))
    before = np.concatenate([np.full((1, 3), np.nan), run.ends[:-1]])
    gap = np.linalg.norm(run.starts - before, axis=1)
    hits = np.flatnonzero(arc & run.follows & (gap > NEAR))
    if len(hits):
        at = int(hits[0])
        item = run.items[int(run.item[at])]
        name, where = _start(look, item, int(run.row[at]))
        yield look.finding(
            rules.ARC_START, where, name=name, distance=float(gap[at]), more=_more(len(hits) - 1)
        )


def _start(look: Look, item: s.Line | MoveRows, row: int) -> tuple[str, Any]:
    if isinstance(item, MoveRows):
        name = f"{item.stem}{int(item.start[row])}"
        return name, row_span(look, item, row, name)
    motion = item.statement
    first = motion.arguments[0] if isinstance(motion, s.Motion) else None
    if isinstance(first, s.Variable):
        return first.name, look.place(item, first) or item
    return "the start", item


def circles(look: Look) -> Found:
    """Mvc where an arc is meant: the next move starts at its third point."""
    last: tuple[s.Line, s.Motion] | None = None
    for item in look.code:
        motion = item.statement if isinstance(item, s.Line) else None
        if isinstance(item, s.Line) and isinstance(motion, s.Motion):
            if last is not None and len(motion.arguments) >= ARC_POINTS:
                third, start = last[1].arguments[-1], last[1].arguments[0]
                follows = motion.arguments[0] == third and third != start
                if follows and isinstance(third, s.Variable) and isinstance(start, s.Variable):
                    yield look.at(
                        rules.FULL_CIRCLE, last[0], "Mvc", start=start.name, name=third.name
                    )
            full = motion.keyword == "Mvc" and len(motion.arguments) >= ARC_POINTS
            last = (item, motion) if full else None

"""Paths: made from numbered moves, as single moves, and their tables.

Moves through consecutively numbered targets become one path; a path becomes moves row by row for a
language without paths.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Rows
from assistant.base.diagnostics import Findings, Span, span_over
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import names_in
from assistant.program.geometry import Target
from assistant.program.motion import Kind, Path, configuration_row
from assistant.program.program import Program, TakenNames, bodies, identifier
from assistant.program.rewriting import Body, map_bodies
from assistant.program.vendor_statements import effect_of

_ROW: Final = re.compile(r"(.*)_([1-9][0-9]{0,14})", re.DOTALL)


def with_paths(program: Program, original: Callable[[str], str] = str) -> Program:
    """Moves through `seam_1`, `seam_2` … that nothing else uses, two at least, become `seam`.

    original: gives the name of a path back that was written under another.
    """
    uses: Counter[str] = Counter()
    for procedure in program.procedures:
        uses.update(n.lower() for n in names_in(procedure))
    # A name that is used once is used by its move alone.
    for declaration in program.declarations:
        uses.update(effect_of(declaration).names)
    once = {n.lower(): (n, t) for n, t in program.targets.items() if uses[n.lower()] == 1}
    if not once:
        return program
    gatherer = _Gatherer(once, original)
    procedures = tuple(replace(q, body=gatherer.body(q.body)) for q in program.procedures)
    left = {n: t for n, t in program.targets.items() if n.lower() not in gatherer.gone}
    return replace(program, procedures=procedures, targets=left)


class _Gatherer:
    def __init__(
        self, once: Mapping[str, tuple[str, Target]], original: Callable[[str], str]
    ) -> None:
        self.once, self.original = once, original
        self.gone: set[str] = set()

    def body(self, body: tuple[p.Statement, ...]) -> tuple[p.Statement, ...]:
        out: list[p.Statement] = []
        held: list[p.Statement] = []
        stem, count = "", 0
        for statement in body:
            piece = self.piece(statement)
            if piece is not None and piece[0] == stem.lower() and piece[1] == count + 1 and held:
                held.append(statement)
                count = piece[2]
                continue
            # The row does not continue the path: what is held so far becomes one.
            out += self.joined(held, count)
            # Only the first row of a path begins one.
            if piece is not None and piece[1] == 1:
                held, stem, count = [statement], piece[0], piece[2]
            else:
                held, stem, count = [], "", 0
                out.append(self.inside(statement))
        return tuple(out + self.joined(held, count))

    def inside(self, statement: p.Statement) -> p.Statement:
        if not bodies(statement):
            return statement
        changed: p.Statement = map_bodies(statement, self.body)
        return changed

    def piece(self, statement: p.Statement) -> tuple[str, int, int] | None:
        """Stem, first and last number of the rows that a statement could be of a path."""
        match statement:
            case p.Follow(path):
                return path.name.lower(), 1, len(path)
            case p.Move(motion=motion) | p.MoveCircular(motion=motion) if (
                p.COMPUTED in motion.fixed
            ):
                # Rows have no speeds that the program computes.
                return None
            case p.Move(_, e.Name(name), triggers=(), until=None):
                row = self.row(name)
                return None if row is None else (row[0], row[1], row[1])
            case p.MoveCircular(e.Name(via), e.Name(end), triggers=(), until=None):
                one, two = self.row(via), self.row(end)
                if one is not None and two is not None and (one[0], one[1] + 1) == two:
                    return one[0], one[1], two[1]
        return None

    def row(self, name: str) -> tuple[str, int] | None:
        match = _ROW.fullmatch(name.lower())
        if match is None or name.lower() not in self.once:
            return None
        return match[1], int(match[2])

    def joined(self, held: list[p.Statement], count: int) -> list[p.Statement]:
        # One row is a move; a path alone is one already.
        if count < 2 or (len(held) == 1 and isinstance(held[0], p.Follow)):
            return held
        span = span_over(held[0].span, held[-1].span)
        paths = [self.path(statement) for statement in held]
        joined = _joined_paths(paths[0].name, paths)
        places = None if span is None else _row_spans(held, paths, span.start)
        return [p.Follow(replace(joined, places=places), span=span)]

    def path(self, statement: p.Statement) -> Path:
        match statement:
            case p.Follow(path):
                return path
            case p.Move(kind, e.Name(name), motion):
                row = Kind.JOINT if kind == "joint" else Kind.LINEAR
                return self.of([name], [row], motion)
            case p.MoveCircular(e.Name(via), e.Name(end), motion):
                return self.of([via, end], [Kind.VIA, Kind.END], motion)
        raise TypeError(statement)

    def of(self, names: list[str], kinds: list[Kind], motion: p.Motion) -> Path:
        targets = [self.once[n.lower()][1] for n in names]
        self.gone.update(n.lower() for n in names)
        first = self.once[names[0].lower()][0]
        speed, blend = motion.fixed
        return Path.of(
            self.original(first.rsplit("_", 1)[0]),
            [t.pose.position for t in targets],
            [t.pose.quaternion for t in targets],
            kinds=np.array(kinds),
            configurations=[configuration_row(t.configuration) for t in targets],
            external=[t.external for t in targets],
            speeds=(speed,),
            blends=(blend,),
            tools=(motion.tool,),
            frames=(motion.frame,),
        )


def _row_spans(held: Sequence[p.Statement], paths: Sequence[Path], start: int) -> Rows | None:
    """Spans of the rows of paths in the text, counted from `start`; None if any has none."""
    parts = []
    for statement, path in zip(held, paths, strict=True):
        span, places = statement.span, path.places
        if span is None or (isinstance(statement, p.Follow) and places is None):
            return None
        if not isinstance(statement, p.Follow):
            places = np.full((len(path), 2), (0, span.end - span.start))
        assert places is not None
        parts.append(places + (span.start - start))
    return np.concatenate(parts)


def _joined_paths(name: str, paths: list[Path]) -> Path:
    """Paths one after the other as one, without the places of their rows."""
    tables: dict[str, tuple[Any, ...]] = {}
    columns: dict[str, Any] = {}
    for column in ("speed", "blend", "tool", "frame"):
        rows: dict[Any, int] = {}
        parts = []
        for path in paths:
            entries = getattr(path, column + "s")
            # Equal entries of several tables become one.
            index = np.array([rows.setdefault(v, len(rows)) for v in entries], dtype=np.int32)
            parts.append(index[getattr(path, column)])
        columns[column] = np.concatenate(parts)
        tables[column + "s"] = tuple(rows)
    for column in ("kinds", "positions", "quaternions", "configurations", "external"):
        columns[column] = np.concatenate([getattr(path, column) for path in paths])
    columns.update(tables)
    return replace(paths[0], name=name, places=None, **columns)


def _motion_at(path: Path, row: int) -> p.Motion:
    """The speed, blend, tool and frame of one row; for the few, never for all of a long path."""
    speed, blend = path.speeds[path.speed[row]], path.blends[path.blend[row]]
    return p.Motion(speed, blend, path.tools[path.tool[row]], path.frames[path.frame[row]])


def move_at(path: Path, row: int, target: e.Expression) -> p.Move:
    """Return the move to a row of a path that is not part of an arc."""
    kind = path.kinds[row]
    return p.Move("joint" if kind == Kind.JOINT else "linear", target, _motion_at(path, row))


def with_points(program: Program) -> Program:
    """The program that moves to declared targets: those in moves and of paths become such.

    For a language without paths and without targets written out. Paths with arcs stay.
    """
    targets = dict(program.targets)
    taken = TakenNames(targets)

    def point(target: Target, wanted: str) -> e.Name:
        name = identifier(wanted, taken)
        taken.add(name)
        targets[name] = target
        return e.Name(name)

    def moves(node: p.Statement) -> Iterator[p.Statement]:
        match node:
            case p.Move(target=e.TargetValue(target)):
                yield replace(node, target=point(target, "point"))
            case p.Follow(path) if set(path.kinds.tolist()) <= {Kind.JOINT, Kind.LINEAR}:
                for row in range(len(path)):
                    to = point(path.target(row), f"{path.name}_{row + 1}")
                    yield replace(move_at(path, row, to), span=node.span)
            case _:
                yield map_bodies(node, body)

    def body(given: Body) -> Body:
        return tuple(made for node in given for made in moves(node))

    procedures = tuple(replace(q, body=body(q.body)) for q in program.procedures)
    return replace(program, procedures=procedures, targets=targets)


T = TypeVar("T")

COLUMNS: Final = ("speed", "blend", "tool", "frame")
"""Columns of rows in the tables `speeds`, `blends`, `tools` and `frames` of a path."""


def has_half_arcs(path: Path) -> bool:
    """True if a via point has no end after it, or an end no via point before it."""
    if not len(path):
        return False
    after = np.append(path.kinds[1:], np.uint8(Kind.LINEAR))
    torn = (path.kinds == Kind.VIA) != (after == Kind.END)
    return bool(torn.any() or path.kinds[0] == Kind.END)


def with_whole_arcs(path: Path) -> Path:
    """The path with speed, blend, tool and frame of an arc's end at its via point, too."""
    via = np.flatnonzero(path.kinds[:-1] == Kind.VIA)
    made: dict[str, Any] = {}
    for column in COLUMNS:
        values = np.array(getattr(path, column))
        values[via] = values[via + 1]
        made[column] = values
    return replace(path, **made)


def reported_at_lines(
    findings: Findings,
    line: Callable[[int], Span | None],
    index: NDArray[Any],
    value: Callable[[int], T],
    entry: int,
) -> T:
    """The value of an entry, with what is found about it at the line of each row that has it.

    line: where the move to a row is in the source text. index: (n,) the entry of each row.
    """
    rows = np.flatnonzero(index == entry)
    before, known = line(int(rows[0])), len(findings)
    with findings.at(before):
        made = value(entry)
    found = findings[known:]
    # The finding is repeated for each line that has the entry.
    for row in rows[1:].tolist() if found else ():
        span = line(row)
        if span != before:  # the two rows of an arc have one line
            with findings.at(span):
                findings.extend(found)
        before = span
    return made


def table_of(
    index: NDArray[Any], value: Callable[[int], Any]
) -> tuple[tuple[Any, ...], NDArray[np.int32]]:
    """The entries that an index column uses, each once and by first use, and their rows."""
    used, first, inverse = np.unique(index, return_index=True, return_inverse=True)
    order = np.argsort(first)
    entries: list[Any] = []
    rows = np.zeros(len(used), dtype=np.int32)
    for i in order:
        entry = value(int(used[i]))
        if entry not in entries:
            entries.append(entry)
        rows[i] = entries.index(entry)
    return tuple(entries), rows[inverse.reshape(-1)]

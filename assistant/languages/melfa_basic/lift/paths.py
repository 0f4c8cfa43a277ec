"""Runs of moves through numbered positions, gathered into paths."""

from __future__ import annotations

import itertools
from bisect import bisect_right
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from assistant.languages.melfa_basic import poses
from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.columnar import KEYWORDS, MOV, MVR, MoveRows
from assistant.languages.melfa_basic.lift.gathering import rows_as_lines, split_name
from assistant.languages.melfa_basic.lift.positions import configurations
from assistant.languages.melfa_basic.names import ARC_START
from assistant.program import statements as p
from assistant.program.diagnostics import Span, over
from assistant.program.path import Kind, Path
from assistant.program.program import identifier

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lift.statements import Reader

Ints = NDArray[np.int64]


@dataclass(slots=True)
class _Chunk:
    """Consecutive rows of a path under one state."""

    kinds: NDArray[np.uint8]
    settings: tuple[Any, ...]


class Runs:
    """Collects moves for a Reader; `flush` puts the path that they make among the statements.

    previous: the position variable (upper case) where the robot stands, None if unknown.
    at: where the entry that is read stands; what is made of it gets that span.
    """

    def __init__(self, reader: Reader) -> None:
        self.reader = reader
        self.changed = False
        self.previous: str | None = None
        self.at: Span | None = None
        self.span: Span | None = None
        self.stem = ""
        self.first = self.last = 0
        self.chunks: list[_Chunk] = []
        self.names: set[str] = set()
        self.taken: list[tuple[str, int, int]] = []
        head = reader.meanings.header
        self.ranges = sorted(head.paths)
        self.starts = [first for first, _, _ in self.ranges]
        self.single = {} if reader.own else _used_once(reader.code)

    # ------------------------------------------------------------------------ gathering

    def rows(self, rows: MoveRows, made: list[p.Statement]) -> None:
        """Moves in columns: runs of consecutive numbers go to the path, the rest one by one."""
        arc = rows.kinds == MVR
        odd = arc & ((rows.start != rows.via - 1) | (rows.via != rows.end - 1))
        first = np.where(arc, rows.via, rows.end)
        breaks = np.ones(len(rows), dtype=bool)
        breaks[1:] = (first[1:] != rows.end[:-1] + 1) | odd[1:] | odd[:-1]
        breaks |= ~self.allowed(rows.stem, first) | ~self.allowed(rows.stem, rows.end)
        starts = self.range_starts(rows.stem)
        if len(starts):
            breaks |= np.isin(first, starts)
        edges = [*np.flatnonzero(breaks).tolist(), len(rows)]
        for low, high in itertools.pairwise(edges):
            self.run(_cut(rows, low, high), made, bool(odd[low]))

    def run(self, rows: MoveRows, made: list[p.Statement], odd: bool) -> None:
        """Rows of consecutive numbers."""
        arc = bool(rows.kinds[0] == MVR)
        first = int(rows.via[0] if arc else rows.end[0])
        allowed = bool(self.allowed(rows.stem, np.array([first, int(rows.end[0])])).all())
        starts_at = f"{rows.stem}{rows.start[0]}".upper() if arc else None
        if odd or not allowed or (arc and starts_at != self.previous):
            self.flush(made)
            for line in rows_as_lines(_cut(rows, 0, 1)):
                self.single_move(line, made)
            if len(rows) > 1:
                self.run(_cut(rows, 1, len(rows)), made, False)
            return
        self.extend(rows.stem, first, _kinds(rows), made)

    def single_move(self, line: s.Line | s.Data, made: list[p.Statement]) -> None:
        reader = self.reader
        if not isinstance(line, s.Line) or not isinstance(line.statement, s.Motion):
            return
        from assistant.languages.melfa_basic.lift.expressions import Unliftable

        try:
            moves = reader.move(line.statement)
        except Unliftable:
            moves = [reader.opaque(line.statement)]
        made += [replace(move, span=self.at) for move in moves]

    def motion(self, node: s.Motion, made: list[p.Statement]) -> bool:
        """A single line that may go on with the path or begin one; False if it cannot."""
        if node.type or node.append or node.keyword not in KEYWORDS:
            return False
        names = [split_name(a) for a in node.arguments]
        if node.keyword != "Mvr":
            if len(names) != 1 or names[0] is None:
                return False
            stem, number = names[0]
            kind = Kind.JOINT if node.keyword == KEYWORDS[MOV] else Kind.LINEAR
            if not self.allowed(stem, np.array([number])).all():
                return False
            self.extend(stem, number, np.array([kind], np.uint8), made)
            return True
        if len(names) != 3 or names[1] is None or names[2] is None:
            return False
        (stem, via), (other, end) = names[1], names[2]
        start = node.arguments[0]
        key = start.key if isinstance(start, s.Variable) else ""
        here = (key == ARC_START and self.reader.arc_pending) or key == self.previous
        if stem != other or end != via + 1 or not here:
            return False
        if not self.allowed(stem, np.array([via, end])).all():
            return False
        if not self.reader.own and not (self.chunks and via == self.last + 1):
            return False
        self.extend(stem, via, np.array([Kind.VIA, Kind.END], np.uint8), made)
        return True

    def extend(
        self, stem: str, first: int, kinds: NDArray[np.uint8], made: list[p.Statement]
    ) -> None:
        """Puts rows to the path, which is begun anew if they do not go on with it."""
        goes_on = (
            bool(self.chunks)
            and stem.upper() == self.stem.upper()
            and first == self.last + 1
            and self.range_of(stem, first) == self.range_of(stem, self.last)
        )
        if not goes_on:
            self.flush(made)
            self.stem, self.first, self.span = stem, first, self.at
        self.span = over(self.span, self.at)
        self.reader.arc_pending = False
        self.last = first + len(kinds) - 1
        self.chunks.append(_Chunk(kinds, self.reader.now()))
        self.previous = f"{stem}{self.last}".upper()

    # -------------------------------------------------------------------------- limits

    def range_of(self, stem: str, number: int) -> int:
        """The row of the heading's ranges that holds a number, -1 for none."""
        if not self.reader.own or stem.upper() != "P":
            return -1
        at = bisect_right(self.starts, number) - 1
        return at if at >= 0 and number <= self.ranges[at][1] else -1

    def range_starts(self, stem: str) -> list[int]:
        return self.starts if self.reader.own and stem.upper() == "P" else []

    def allowed(self, stem: str, numbers: Ints) -> NDArray[np.bool_]:
        """Whether positions of a path: known, and in a range or used nowhere else."""
        _, _, known = self.reader.meanings.positions.find(stem, numbers)
        if self.reader.own:
            if stem.upper() != "P" or not self.ranges:
                return np.zeros(len(numbers), dtype=bool)
            at = np.searchsorted(self.starts, numbers, side="right") - 1
            ends = np.array([last for _, last, _ in self.ranges])
            return known & (at >= 0) & (numbers <= ends[at])
        single = self.single.get(stem.upper())
        if single is None:
            return np.zeros(len(numbers), dtype=bool)
        return known & np.isin(numbers, single)

    def holds(self, key: str) -> bool:
        """Whether a position variable is a row of a path that was made."""
        name = split_name(s.Variable(key))
        return name is not None and any(
            stem == name[0].upper() and first <= name[1] <= last for stem, first, last in self.taken
        )

    # -------------------------------------------------------------------------- making

    def forget(self) -> None:
        """The robot's place is not known any more."""
        self.previous = None

    def flush(self, made: list[p.Statement]) -> None:
        """Ends the path that is being gathered."""
        if not self.chunks:
            return
        chunks, self.chunks = self.chunks, []
        kinds = np.concatenate([c.kinds for c in chunks])
        if not self.reader.own and len(kinds) == 1:
            self.lone(chunks[0], made)
            return
        numbers = np.arange(self.first, self.last + 1, dtype=np.int64)
        meanings = self.reader.meanings
        values, flags, _ = meanings.positions.find(self.stem, numbers)
        width = (
            8 if not np.isnan(values[:, 7]).all() else 7 if not np.isnan(values[:, 6]).all() else 6
        )
        position, quaternion, external = poses.from_values(values[:, :width], meanings.robot)
        self.taken.append((self.stem.upper(), self.first, self.last))
        path = Path.of(
            self.name(),
            position,
            quaternion,
            kinds=kinds,
            configurations=configurations(flags, meanings.robot),
            external=external,
            **_columns(chunks),
        )
        made.append(p.Follow(path, span=self.span))

    def name(self) -> str:
        at = self.range_of(self.stem, self.first)
        given = self.ranges[at][2] if at >= 0 else self.stem.rstrip("_")
        if at < 0:
            given = identifier(given, self.names)
        self.names.add(given)
        return given

    def lone(self, chunk: _Chunk, made: list[p.Statement]) -> None:
        """A single move is no path."""
        reader = self.reader
        now, previous = reader.now(), self.previous
        reader.tcp, reader.joint, reader.blend, reader.tool, reader.frame = chunk.settings
        word = "Mov" if chunk.kinds[0] == Kind.JOINT else "Mvs"
        move = reader.to(word, s.Variable(f"{self.stem}{self.first}"), None)
        made.append(replace(move, span=self.span))
        reader.tcp, reader.joint, reader.blend, reader.tool, reader.frame = now
        self.previous = previous


def _cut(rows: MoveRows, low: int, high: int) -> MoveRows:
    part = slice(low, high)
    return MoveRows(
        rows.stem, rows.steps[part], rows.kinds[part], rows.start[part], rows.via[part],
        rows.end[part],
    )  # fmt: skip


def _kinds(rows: MoveRows) -> NDArray[np.uint8]:
    """The kinds of a path's rows: an arc is two."""
    arc = rows.kinds == MVR
    plain = np.where(rows.kinds == MOV, Kind.JOINT, Kind.LINEAR)
    last = np.cumsum(1 + arc) - 1
    kinds = np.full(int(last[-1]) + 1, Kind.VIA, dtype=np.uint8)
    kinds[last] = np.where(arc, Kind.END, plain)
    return kinds


def _columns(chunks: list[_Chunk]) -> dict[str, Any]:
    """Tables and index columns of a path; the percentage counts for joint moves only."""
    tables: dict[str, list[Any]] = {"speed": [], "blend": [], "tool": [], "frame": []}
    rows: dict[str, dict[Any, int]] = {name: {} for name in tables}
    columns: dict[str, list[NDArray[np.int32]]] = {name: [] for name in tables}

    def row(name: str, key: Any) -> int:
        if key not in rows[name]:
            rows[name][key] = len(tables[name])
            tables[name].append(key)
        return rows[name][key]

    from assistant.program.motion import Speed

    for chunk in chunks:
        tcp, percent, *rest = chunk.settings
        n = len(chunk.kinds)
        joint = chunk.kinds == Kind.JOINT
        speed = np.zeros(n, dtype=np.int32)
        for flag, percent_ in ((True, percent), (False, None)):
            if (joint == flag).any():
                value = Speed(tcp, joint=percent_) if isinstance(tcp, float) else tcp
                speed[joint == flag] = row("speed", value)
        columns["speed"].append(speed)
        for name, value in zip(("blend", "tool", "frame"), rest, strict=True):
            columns[name].append(np.full(n, row(name, value), dtype=np.int32))
    made: dict[str, Any] = {name: np.concatenate(parts) for name, parts in columns.items()}
    made.update({name + "s": table for name, table in tables.items()})
    return made


def _used_once(code: list[Any]) -> dict[str, Ints]:
    """By stem, the numbers of positions that the code mentions in one place only."""
    seen: dict[str, list[Ints]] = {}
    for item in code:
        if isinstance(item, MoveRows):
            arc = item.kinds == MVR
            apart = arc & (item.start != item.via - 1)
            parts = [item.end, item.via[arc], item.start[apart]]
            seen.setdefault(item.stem.upper(), []).append(np.concatenate(parts))
        elif isinstance(item, s.Line) and item.statement is not None:
            for stem, number in _mentions(item.statement):
                seen.setdefault(stem.upper(), []).append(np.array([number]))
    single: dict[str, Ints] = {}
    for stem, found in seen.items():
        numbers, counts = np.unique(np.concatenate(found), return_counts=True)
        single[stem] = numbers[counts == 1]
    return single


def _mentions(node: Any) -> list[tuple[str, int]]:
    """Numbered variables of a statement; an arc's start is one with the end before it."""
    from dataclasses import fields, is_dataclass

    found: list[tuple[str, int]] = []
    if isinstance(node, s.Motion) and node.keyword == "Mvr" and len(node.arguments) == 3:
        names = [split_name(a) for a in node.arguments]
        if names[0] and names[1] and names[0] == (names[1][0], names[1][1] - 1):
            return [n for n in names[1:] if n]
    left: list[Any] = [node]
    while left:
        inner = left.pop()
        if isinstance(inner, tuple):
            left += inner
        elif isinstance(inner, s.Variable):
            plain = split_name(s.Variable(inner.name))
            if plain:
                found.append(plain)
            left += inner.arguments or ()
        elif is_dataclass(inner):
            left += [getattr(inner, f.name) for f in fields(inner)]
    return found

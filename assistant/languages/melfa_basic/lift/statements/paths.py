"""Runs of moves through numbered positions, gathered into paths."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.languages.melfa_basic.lift.settings.framed_targets import unframed
from assistant.languages.melfa_basic.lift.settings.held import FRAME, JOINT, TCP, TOOL
from assistant.languages.melfa_basic.lift.values.symbols import Symbols
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.words import ARC_START
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import KEYWORDS, MOV, MVR, MoveRows
from assistant.languages.melfa_basic.tree.line_tables import (
    rows_as_lines,
    split_name,
    split_numbered,
)
from assistant.languages.melfa_basic.tree.positions import configurations
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.languages.runs.paths import path_kinds, setting_columns
from assistant.languages.settings.flow import UNKNOWN
from assistant.program import statements as p
from assistant.program.arrays import Ints, Truths
from assistant.program.diagnostics import Span, over
from assistant.program.motion import Speed
from assistant.program.path import Kind, Path
from assistant.program.program import identifier

Values = tuple[Any, ...]
"""Settings of a move, by TCP, JOINT, BLEND, TOOL and FRAME."""
Place = tuple[str, Any, Any]
"""Where the robot stands: a position variable (upper case), the tool and the frame."""

One = Callable[[s.Motion, Values, Span | None], list[p.Statement]]
"""Makes the statements of a move that is part of no path."""


_PLAIN: Final = np.array([Kind.JOINT, Kind.LINEAR, Kind.END], dtype=np.uint8)
"""Kinds of rows of a path by those of moves."""


@dataclass(slots=True)
class _Chunk:
    """Consecutive rows of a path under one state."""

    kinds: NDArray[np.uint8]
    settings: Values
    span: Span | None


def sayable(values: Values, joint: bool) -> bool:
    """Whether every setting is known that a move of that kind depends on."""
    return all(v is not UNKNOWN for k, v in enumerate(values) if k != (TCP if joint else JOINT))


def speed_of(values: Values, joint: bool) -> Speed:
    """The speed of a move; that of the tool says nothing of a joint move."""
    return Speed(math.inf, joint=values[JOINT]) if joint else Speed(values[TCP])


class Runs:
    """Collects moves; `flush` puts the path that they make among the statements.

    single: of `used_once`. own: the file says itself which positions are paths. previous: where
    the robot stands, None if that is not known. arc_pending: the start of an arc was just read
    from the robot.
    """

    def __init__(self, symbols: Symbols, single: Mapping[str, Ints], own: bool, one: One) -> None:
        self.symbols, self.own, self.one = symbols, own, one
        self.previous: Place | None = None
        self.arc_pending = False
        self.at: Span | None = None
        self.stem = ""
        self.first = self.last = 0
        self.chunks: list[_Chunk] = []
        self.names: set[str] = set()
        self.taken: list[tuple[str, int, int]] = []
        self.ranges = sorted(symbols.header.paths)
        self.starts = [first for first, _, _ in self.ranges]
        self.single = single

    # ------------------------------------------------------------------------ gathering

    def rows(self, rows: MoveRows, values: Values, made: list[p.Statement]) -> None:
        """Moves in columns: runs of consecutive numbers go to the path, the rest one by one."""
        self.at = rows.span
        if not all(sayable(values, joint) for joint in set((rows.kinds == MOV).tolist())):
            self.one_by_one(rows, values, made)
            return
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
            self.run(rows.rows(slice(low, high)), values, made, bool(odd[low]))

    def run(self, rows: MoveRows, values: Values, made: list[p.Statement], odd: bool) -> None:
        """Rows of consecutive numbers."""
        arc = bool(rows.kinds[0] == MVR)
        first = int(rows.via[0] if arc else rows.end[0])
        allowed = bool(self.allowed(rows.stem, np.array([first, int(rows.end[0])])).all())
        starts_at = place(f"{rows.stem}{rows.start[0]}", values) if arc else None
        if odd or not allowed or (arc and starts_at != self.previous):
            self.one_by_one(rows.rows(slice(1)), values, made)
            if len(rows) > 1:
                self.run(rows.rows(slice(1, None)), values, made, False)
            return
        kinds = path_kinds(rows.kinds == MVR, _PLAIN[rows.kinds])
        self.extend(rows.stem, first, kinds, values, self.at, made)

    def one_by_one(self, rows: MoveRows, values: Values, made: list[p.Statement]) -> None:
        self.flush(made)
        for line in rows_as_lines(rows):
            if isinstance(line, s.Line) and isinstance(line.statement, s.Motion):
                made += self.one(line.statement, values, self.at)

    def motion(
        self, node: s.Motion, values: Values, span: Span | None, made: list[p.Statement]
    ) -> bool:
        """A single line that may go on with the path or begin one; False if it cannot."""
        node, values = unframed(node, values, self.symbols.header)
        if node.type or node.append or node.keyword not in KEYWORDS:
            return False
        if not sayable(values, node.keyword == KEYWORDS[MOV]):
            return False
        names = [split_name(a) for a in node.arguments]
        if node.keyword != "Mvr":
            if len(names) != 1 or names[0] is None:
                return False
            stem, number = names[0]
            kind = Kind.JOINT if node.keyword == KEYWORDS[MOV] else Kind.LINEAR
            if not self.allowed(stem, np.array([number])).all():
                return False
            self.extend(stem, number, np.array([kind], np.uint8), values, span, made)
            return True
        if len(names) != 3 or names[1] is None or names[2] is None:
            return False
        (stem, via), (other, end) = names[1], names[2]
        if stem != other or end != via + 1 or not self.is_here(node.arguments[0], values):
            return False
        if not self.allowed(stem, np.array([via, end])).all():
            return False
        if not self.own and not (self.chunks and via == self.last + 1):
            return False
        self.extend(stem, via, np.array([Kind.VIA, Kind.END], np.uint8), values, span, made)
        return True

    def is_here(self, start: s.Expression | None, values: Values) -> bool:
        """Whether the robot stands at the start of an arc."""
        key = start.key if isinstance(start, s.Variable) and start.arguments is None else ""
        if key == ARC_START and self.arc_pending:
            return True
        return self.previous is not None and self.previous == place(key, values)

    def extend(
        self,
        stem: str,
        first: int,
        kinds: NDArray[np.uint8],
        values: Values,
        span: Span | None,
        made: list[p.Statement],
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
            self.stem, self.first = stem, first
        self.arc_pending = False
        self.last = first + len(kinds) - 1
        self.chunks.append(_Chunk(kinds, values, span))
        self.previous = place(f"{stem}{self.last}", values)

    # -------------------------------------------------------------------------- limits

    def range_of(self, stem: str, number: int) -> int:
        """The row of the heading's ranges that holds a number, -1 for none."""
        if not self.own or stem.upper() != "P":
            return -1
        at = bisect_right(self.starts, number) - 1
        return at if at >= 0 and number <= self.ranges[at][1] else -1

    def range_starts(self, stem: str) -> list[int]:
        return self.starts if self.own and stem.upper() == "P" else []

    def allowed(self, stem: str, numbers: Ints) -> Truths:
        """Whether positions of a path: known, and in a range or used nowhere else."""
        _, _, known = self.symbols.positions.find(stem, numbers)
        if self.own:
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
        if not self.own and len(kinds) == 1:
            made += self._lone(chunks[0])
            return
        numbers = np.arange(self.first, self.last + 1, dtype=np.int64)
        symbols = self.symbols
        values, flags, _ = symbols.positions.find(self.stem, numbers)
        width = (
            8 if not np.isnan(values[:, 7]).all() else 7 if not np.isnan(values[:, 6]).all() else 6
        )
        position, quaternion, external = poses.from_values(values[:, :width], symbols.robot)
        self.taken.append((self.stem.upper(), self.first, self.last))
        path = Path.of(
            self.name(),
            position,
            quaternion,
            kinds=kinds,
            configurations=configurations(flags, symbols.robot),
            external=external,
            **_columns(chunks),
        )
        span = over(chunks[0].span, chunks[-1].span)
        made.append(p.Follow(path, span=span))

    def name(self) -> str:
        at = self.range_of(self.stem, self.first)
        given = self.ranges[at][2] if at >= 0 else self.stem.rstrip("_")
        if at < 0:
            given = identifier(given, self.names)
        self.names.add(given)
        return given

    def _lone(self, chunk: _Chunk) -> list[p.Statement]:
        """A single move is no path."""
        previous = self.previous
        word = "Mov" if chunk.kinds[0] == Kind.JOINT else "Mvs"
        target = s.Variable(f"{self.stem}{self.first}")
        made = self.one(s.Motion(word, (target,)), chunk.settings, chunk.span)
        self.previous = previous
        return made


def place(name: str, values: Values) -> Place:
    return name.upper(), values[TOOL], values[FRAME]


def _columns(chunks: list[_Chunk]) -> dict[str, Any]:
    """Tables and index columns of a path; the percentage counts for joint moves only."""
    ways = [2 * at + (chunk.kinds != Kind.JOINT) for at, chunk in enumerate(chunks)]
    rows = np.concatenate(ways)
    used = np.flatnonzero(np.bincount(rows))
    settings = [
        (speed_of(chunks[way // 2].settings, way % 2 == 0), *chunks[way // 2].settings[2:])
        for way in used.tolist()
    ]
    return setting_columns(settings, np.searchsorted(used, np.arange(2 * len(chunks)))[rows])


def used_once(code: Sequence[s.Entry]) -> dict[str, Ints]:
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
    found: list[tuple[str, int]] = []
    if isinstance(node, s.Motion) and node.keyword == "Mvr" and len(node.arguments) == 3:
        names = [split_name(a) for a in node.arguments]
        if names[0] and names[1] and names[0] == (names[1][0], names[1][1] - 1):
            return [n for n in names[1:] if n]
    for inner in nodes(node):
        if isinstance(inner, s.Variable):
            plain = split_numbered(inner.name)
            if plain:
                found.append(plain)
    return found

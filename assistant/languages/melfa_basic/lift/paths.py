"""Paths: runs of moves through numbered positions.

Moves that follow each other under settings that are known become one path, whose positions are
columns; any other move is left to the lift of single moves.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Ints, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span, span_over
from assistant.languages.melfa_basic.lift.settings import (
    FRAME,
    JOINT,
    TCP,
    TOOL,
    without_frame_product,
)
from assistant.languages.melfa_basic.lift.symbols import Symbols
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.variables import ARC_START
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import KEYWORDS, MOV, MVR, MoveRows, row_slice
from assistant.languages.melfa_basic.tree.line_tables import (
    configurations,
    rows_as_lines,
    split_name,
    split_numbered,
)
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.languages.runs.paths import path_kinds, settings_of_parts
from assistant.languages.settings_flow import UNKNOWN, Computed
from assistant.program import statements as p
from assistant.program.motion import Kind, Path, Speed
from assistant.program.program import identifier

_WORD: Final = re.compile(r"\w+")
Values = tuple[Any, ...]
"""Settings of a move, by TCP, JOINT, BLEND, TOOL and FRAME."""
Place = tuple[str, Any, Any]
"""Position of the robot: a position variable (upper case), the tool and the frame."""

SingleMove = Callable[[s.Motion, Values, Span | None], list[p.Statement]]
"""Makes the statements of a move that is part of no path."""


MOST_TAUGHT: Final = 2000
"""Greatest number of positions of a stem that people may have taught: each keeps its name, as a
separate target. A larger number was written by a program; they are rows of paths.
"""
_PLAIN_KINDS: Final = np.array([Kind.JOINT, Kind.LINEAR, Kind.END], dtype=np.uint8)
"""Kinds of rows of a path by those of moves."""
_KEYWORD_ROWS: Final = {
    word: path_kinds(np.array([kind == MVR]), _PLAIN_KINDS[[kind]])
    for kind, word in enumerate(KEYWORDS)
}
"""Word of a move → the kinds of its rows."""


@dataclass(slots=True)
class _Chunk:
    """Consecutive rows of a path under one state."""

    kinds: NDArray[np.uint8]
    settings: Values
    span: Span | None
    places: Rows | None = None
    """(rows, 2) where the line of each is, counted from the begin of the span; None: all of it."""


def are_known(values: Values, joint: bool) -> bool:
    """True if every setting is known that a move of that kind depends on."""
    return all(v is not UNKNOWN for k, v in enumerate(values) if k != (TCP if joint else JOINT))


def are_fixed(values: Values, joint: bool) -> bool:
    """True if every setting that such a move depends on has one value, as in a path."""
    used = (v for k, v in enumerate(values) if k != (TCP if joint else JOINT))
    return are_known(values, joint) and not any(isinstance(v, Computed) for v in used)


def move_speed(values: Values, joint: bool) -> Speed:
    """Return the speed of a move; the tool speed does not affect a joint move."""
    return Speed(math.inf, joint=values[JOINT]) if joint else Speed(values[TCP])


class Runs:
    """Collects moves; `flush` puts the path that they make among the statements.

    single: of `positions_used_once`. own: the file states which positions are paths. previous:
    where the robot is, None if that is not known. arc_pending: the start of an arc was just read
    from the robot. range: row of the heading's ranges that the path's last position is in.
    """

    def __init__(
        self, symbols: Symbols, single: Mapping[str, Ints], own: bool, one: SingleMove
    ) -> None:
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
        # `reshape` gives two columns even without any range.
        self.starts, self.stops = np.array([r[:2] for r in self.ranges]).reshape(-1, 2).T
        self.range = -1
        self.single = {stem: n for stem, n in single.items() if len(n) > MOST_TAUGHT}

    # ------------------------------------------------------------------------ gathering

    def rows(self, rows: MoveRows, values: Values, made: list[p.Statement]) -> None:
        """Moves in columns: runs of consecutive numbers go to the path, the rest one by one."""
        self.at = rows.span
        known = all(are_fixed(values, joint) for joint in set((rows.kinds == MOV).tolist()))
        arc = rows.kinds == MVR
        first = np.where(arc, rows.via, rows.end)
        alone = ~(self.allowed(rows.stem, first) & self.allowed(rows.stem, rows.end)) | (not known)
        alone |= arc & (rows.via != rows.end - 1)
        apart = arc & (rows.start != rows.via - 1)
        if not self.own:  # where a path may begin with an arc from anywhere
            alone |= apart
        ranges = self.ranges_of(rows.stem, first)
        # A new run begins where numbers do not go on, where a move stays alone, or a range ends.
        breaks = np.ones(len(rows), dtype=bool)
        breaks[1:] = (first[1:] != rows.end[:-1] + 1) | alone[1:] | alone[:-1]
        breaks[1:] |= apart[1:] | (ranges[1:] != ranges[:-1])
        for low, high in itertools.pairwise([*np.flatnonzero(breaks).tolist(), len(rows)]):
            # The first move may not go on from where the robot is; then it is lifted alone, and the
            # rest of the run is tried again.
            for at in range(low, high):
                kinds = path_kinds(arc[at:high], _PLAIN_KINDS[rows.kinds[at:high]])
                start = s.Variable(f"{rows.stem}{rows.start[at]}")
                part = row_slice(rows, at, high)
                self.at = part.span
                if not alone[at] and self.extend(
                    rows.stem, int(first[at]), kinds, start, values, self.at, made
                ):
                    # An arc takes two rows of the path, both on its line.
                    if part.places is not None:
                        self.chunks[-1].places = np.repeat(part.places, 1 + arc[at:high], axis=0)
                    break
                self.one_by_one(row_slice(rows, at, at + 1), values, made)

    def one_by_one(self, rows: MoveRows, values: Values, made: list[p.Statement]) -> None:
        self.at = rows.span
        self.flush(made)
        for line in rows_as_lines(rows):
            if isinstance(line, s.Line) and isinstance(line.statement, s.Motion):
                made += self.one(line.statement, values, self.at)

    def motion(
        self, node: s.Motion, values: Values, span: Span | None, made: list[p.Statement]
    ) -> bool:
        """A single line that may go on with the path or begin one; False if it cannot."""
        node, values = without_frame_product(node, values, self.symbols.header)
        if node.type or node.append or node.keyword not in _KEYWORD_ROWS:
            return False
        kinds, targets = _KEYWORD_ROWS[node.keyword], node.arguments
        names = [name for name in map(split_name, targets[-len(kinds) :]) if name is not None]
        arc = len(kinds) == 2
        if len(targets) != 1 + 2 * arc or len(names) != len(kinds):
            return False
        (stem, first), (other, last) = names[0], names[-1]
        if stem != other or last != first + arc or not are_fixed(values, kinds[0] == Kind.JOINT):
            return False
        # A path of a file from elsewhere begins with a plain move.
        if arc and not self.own and not (self.chunks and first == self.last + 1):
            return False
        return bool(self.allowed(stem, np.array([first, last])).all()) and self.extend(
            stem, first, kinds, targets[0], values, span, made
        )

    def is_here(self, start: s.Expression | None, values: Values) -> bool:
        """True if the robot is at the start of an arc."""
        here = robot_place(start, values)
        if here is not None and here[0] == ARC_START and self.arc_pending:
            # The compiler has just read the start of the arc from the robot.
            return True
        return here is not None and self.previous == here

    def extend(
        self,
        stem: str,
        first: int,
        kinds: NDArray[np.uint8],
        start: s.Expression | None,
        values: Values,
        span: Span | None,
        made: list[p.Statement],
    ) -> bool:
        """Append rows to the path; begin a new path if they do not continue it.

        start: of the arc that they may begin with. Return False if the robot is not there.
        """
        if kinds[0] == Kind.VIA and not self.is_here(start, values):
            return False
        last = first + len(kinds) - 1
        begins, ends = self.ranges_of(stem, np.array([first, last])).tolist()
        goes_on = bool(self.chunks) and stem.upper() == self.stem.upper()
        if not goes_on or first != self.last + 1 or begins != self.range:
            self.flush(made)
            self.stem, self.first = stem, first
        self.arc_pending = False
        self.last, self.range = last, ends
        self.chunks.append(_Chunk(kinds, values, span))
        self.previous = place_at(f"{stem}{last}", values)
        return True

    # -------------------------------------------------------------------------- limits

    def ranges_of(self, stem: str, numbers: Ints) -> Ints:
        """(n,) the row of the heading's ranges that holds each number, -1 for none."""
        if not self.own or stem.upper() != "P" or not self.ranges:
            return np.full(len(numbers), -1, dtype=np.int64)
        at = np.searchsorted(self.starts, numbers, side="right") - 1
        return np.where((at >= 0) & (numbers <= self.stops[at]), at, -1)

    def allowed(self, stem: str, numbers: Ints) -> Truths:
        """True for each position that a path may contain: known, and in a range or used nowhere
        else.
        """
        _, _, known = self.symbols.positions.find(stem, numbers)
        if self.own:
            return known & (self.ranges_of(stem, numbers) >= 0)
        return known & np.isin(numbers, self.single.get(stem.upper(), ()))

    def holds(self, key: str) -> bool:
        """True if a position variable is a row of a finished path."""
        name = split_name(s.Variable(key))
        return name is not None and any(
            stem == name[0].upper() and first <= name[1] <= last for stem, first, last in self.taken
        )

    # -------------------------------------------------------------------------- making

    def forget(self) -> None:
        """The robot's place is not known any more."""
        self.previous = None

    def changed(self, key: str) -> None:
        """A variable (upper case) is assigned to: the robot's place may be another position now.

        In a file of people, any variable may be the tool or the frame; in one of the compiler, the
        heading names these, and the writer knows which parameters are by reference.
        """
        names = self.symbols.header.names
        mounts = names["tool"].keys() | names["frame"].keys()
        own = self.symbols.own and key not in mounts
        if not own or (self.previous and key in _WORD.findall(self.previous[0])):
            self.previous = None

    def flush(self, made: list[p.Statement]) -> None:
        """Ends the path that is being gathered."""
        if not self.chunks:
            return
        chunks, self.chunks = self.chunks, []
        kinds = np.concatenate([c.kinds for c in chunks])
        # A single move of such a file is a target, not a path.
        if not self.own and len(kinds) == 1:
            made += self._lone(chunks[0])
            return
        numbers = np.arange(self.first, self.last + 1, dtype=np.int64)
        symbols = self.symbols

        def motion(part: int, joint: bool) -> p.Motion:
            given = chunks[part].settings  # the percentage counts for joint moves only
            return p.Motion(move_speed(given, joint), *given[2:])

        values, flags, _ = symbols.positions.find(self.stem, numbers)
        # NaN marks additional axes that the arm does not have.
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
            **settings_of_parts([chunk.kinds for chunk in chunks], motion),
        )
        if not self.own:
            path = replace(path, original=(self.stem, self.first))
        span = span_over(chunks[0].span, chunks[-1].span)
        made.append(p.Follow(replace(path, places=_row_spans(chunks)), span=span))

    def name(self) -> str:
        (at,) = self.ranges_of(self.stem, np.array([self.first])).tolist()
        given = self.ranges[at][2] if at >= 0 else identifier(self.stem.rstrip("_"), self.names)
        self.names.add(given)
        return given

    def _lone(self, chunk: _Chunk) -> list[p.Statement]:
        """A single move is no path."""
        # The robot's position is known beyond this move already.
        previous = self.previous
        word = "Mov" if chunk.kinds[0] == Kind.JOINT else "Mvs"
        target = s.Variable(f"{self.stem}{self.first}")
        made = self.one(s.Motion(word, (target,)), chunk.settings, chunk.span)
        self.previous = previous
        return made


def _row_spans(chunks: Sequence[_Chunk]) -> Rows | None:
    """Spans of the rows of chunks, counted from the start of the first."""
    first, parts = chunks[0].span, list[Rows]()
    for chunk in chunks:
        if chunk.span is None or first is None:
            return None
        own = chunk.places
        if own is None:
            own = np.full((len(chunk.kinds), 2), (0, chunk.span.end - chunk.span.start))
        parts.append(own + (chunk.span.start - first.start))
    return np.concatenate(parts)


def robot_place(at: s.Expression | None, values: Values) -> Place | None:
    """Return the robot's place at a position; None if only the running program knows it."""
    key = _place_key(at)
    return None if key is None else place_at(key, values)


def _place_key(at: s.Expression | None) -> str | None:
    """A variable, an element of an array, or either moved by numbers, as one text."""
    match at:
        case s.Variable(arguments=None):
            return at.key
        case s.Variable(arguments=arguments, component="") if arguments and all(
            isinstance(x, s.Number) for x in arguments
        ):
            return f"{at.key}{[x.value for x in arguments if isinstance(x, s.Number)]}"
        case s.Binary("+" | "*" as operator, base, s.Constant(values=moved)):
            key = _place_key(base)
            numbers = [None if value is None else float(value) for value in moved]
            return None if key is None else f"{key}{operator}{numbers}"
    return None


def place_at(name: str, values: Values) -> Place:
    return name.upper(), values[TOOL], values[FRAME]


def positions_used_once(code: Sequence[s.Entry]) -> dict[str, Ints]:
    """By stem, the numbers of positions that the code mentions in one place only."""
    seen: dict[str, list[Ints]] = {}
    for item in code:
        if isinstance(item, MoveRows):
            arc = item.kinds == MVR
            # The start of an arc is a separate mention unless it is the row above.
            apart = arc & (item.start != item.via - 1)
            parts = [item.end, item.via[arc], item.start[apart]]
            seen.setdefault(item.stem.upper(), []).append(np.concatenate(parts))
        elif isinstance(item, s.Line) and item.statement is not None:
            for stem, number in _mentioned_numbers(item.statement):
                seen.setdefault(stem.upper(), []).append(np.array([number]))
    single: dict[str, Ints] = {}
    for stem, found in seen.items():
        numbers, counts = np.unique(np.concatenate(found), return_counts=True)
        single[stem] = numbers[counts == 1]
    return single


def _mentioned_numbers(node: Any) -> list[tuple[str, int]]:
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

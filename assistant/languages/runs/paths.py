"""Moves in columns as the rows of paths."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Ints, Rows, Truths
from assistant.languages.runs.columns import Entries, NameIndex, Names
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Kind, Path

_SETTINGS: Final = ("speed", "blend", "tool", "frame")
"""Columns of a path that are rows of a table, whose name adds an `s`."""


class Stretch(NamedTuple):
    """Rows of a path from start up to stop. numbered: the names before stop follow each other."""

    start: int
    stop: int
    numbered: bool


def path_kinds(arcs: Truths, plain: NDArray[np.integer]) -> NDArray[np.uint8]:
    """Return (rows,) a `Kind` each; an arc has two rows. plain: (n,) of moves that are not arcs."""
    # The row at which each move ends; rows between are those that arcs go through.
    ends = np.cumsum(1 + arcs) - 1
    kinds = np.full(int(ends[-1]) + 1 if len(ends) else 0, Kind.VIA, dtype=np.uint8)
    kinds[ends] = np.where(arcs, Kind.END, plain)
    return kinds


def setting_columns(motions: Sequence[p.Motion], index: NDArray[np.integer]) -> dict[str, Any]:
    """Columns and tables of a path. index: (rows,) of motions that some rows have each."""
    columns: dict[str, Any] = {}
    for name in _SETTINGS:
        entries = Entries.of(getattr(motion, name) for motion in motions)
        columns[name], columns[name + "s"] = entries.index[index], entries.table
    return columns


def settings_of_parts(
    kinds: Sequence[NDArray[np.uint8]], motion: Callable[[int, bool], p.Motion]
) -> dict[str, Any]:
    """The same of a path in parts. kinds: of the rows of each part.

    motion: of a part, by its place, and of its joint moves or of the others.
    """
    # Two numbers for each part: its joint moves and its others have different settings.
    ways = [2 * at + (part != Kind.JOINT) for at, part in enumerate(kinds)]
    used, index = np.unique(np.concatenate(ways), return_inverse=True)
    return setting_columns([motion(way // 2, way % 2 == 0) for way in used.tolist()], index)


def setting_codes(path: Path) -> Ints:
    """(n,) a number for the settings of each row: rows with the same settings have the same."""
    code = np.zeros(len(path), dtype=np.int64)
    for name in _SETTINGS:
        # The rows of all tables as digits of one number.
        code = code * len(getattr(path, name + "s")) + getattr(path, name)
    return code


class NamedTargets:
    """Declared targets by name: how often they are named, and which of them are in paths.

    uses: (n,) of each. taken: (n,) whether it is in a path.
    """

    def __init__(self, names: Names) -> None:
        self.names = names
        self.uses = np.zeros(len(names), dtype=np.int64)
        self.taken = np.zeros(len(names), dtype=bool)
        self._index = NameIndex(names)

    def count(self, names: Names) -> None:
        """Names that something mentions."""
        rows = self._index.rows(names)
        np.add.at(self.uses, rows[rows >= 0], 1)

    def alone(self, names: Names) -> tuple[Rows, Truths]:
        """The row of each name, -1 for none, and whether it is declared and named once only."""
        rows = self._index.rows(names)
        known = rows >= 0
        alone = known.copy()
        alone[known] = self.uses[rows[known]] == 1
        return rows, alone


def values_at(rows: Rows, values: Floats) -> Floats:
    """Rows of values (n, width), not copied where they follow each other."""
    if np.array_equal(rows, np.arange(rows[0], rows[0] + len(rows))):
        return values[rows[0] : rows[0] + len(rows)]
    return values[rows]


class PathRows:
    """The targets of n moves, one a row: what an arc goes through and where it ends are two.

    vias: (n,) names of what arcs go through. names: (rows,) of the targets. kinds: (rows,) a
    `Kind` each. moves: (rows,) the move that each is a target of.
    """

    def __init__(self, ends: Names, vias: Names, arcs: Truths, plain: NDArray[np.integer]) -> None:
        self.moves = np.repeat(np.arange(len(ends)), 1 + arcs)
        self.kinds = path_kinds(arcs, plain)
        self.names = ends
        if arcs.any():
            through = self.kinds == Kind.VIA
            # Ends and vias in one column: the via of a move is that many rows further on.
            self.names = Names.joined([ends, vias]).rows(self.moves + len(ends) * through)

    def stretches(self, alone: Truths) -> Iterator[Stretch]:
        """Parts whose names have consecutive numbers from 1, and what is between them.

        alone: (rows,) whether the target is declared and named once only.
        """
        stem, number = self.names.stem, self.names.number
        follows = np.zeros(len(stem), dtype=bool)
        follows[1:] = (stem[1:] == stem[:-1]) & (number[1:] == number[:-1] + 1)
        follows[1:] &= alone[1:] & alone[:-1] & (number[1:] > 1)
        broken = (self.kinds == Kind.END) & ~follows  # an arc through no neighbours
        cut = ~follows & ~broken
        cut[np.flatnonzero(broken) - 1] = True
        cut[np.minimum(np.flatnonzero(broken) + 1, len(cut) - 1)] = True
        cut &= self.kinds != Kind.END
        starts = np.flatnonzero(cut)
        usable = alone.copy()
        usable[np.flatnonzero(broken)] = False
        usable[np.flatnonzero(broken) - 1] = False
        usable &= number == 1
        for start, stop in zip(starts.tolist(), [*starts[1:].tolist(), len(stem)], strict=True):
            yield Stretch(start, stop, bool(usable[start]) and stop - start > 1)

    def one_by_one(
        self, part: Stretch, name: Callable[[str], str], motion: Callable[[int], p.Motion]
    ) -> Iterator[p.Statement]:
        """A statement a move. name, motion: as the program has what a row is called and how its
        move is made.
        """
        via: e.Name | None = None
        for row in range(part.start, part.stop):
            target, kind = e.Name(name(self.names.name(row))), self.kinds[row]
            how = motion(int(self.moves[row]))
            if kind == Kind.VIA:
                via = target
            elif via is not None:
                yield p.MoveCircular(via, target, how)
                via = None
            else:
                yield p.Move("joint" if kind == Kind.JOINT else "linear", target, how)

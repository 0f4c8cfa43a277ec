"""Occupancy of the space around a robot: a sparse grid of cells in the frame of its base.

A cell is free if it lies entirely inside space that a body of the robot filled without contact. It
is occupied if a contact was in it; a body that fills it later makes it free again. All others are
unknown. Files of maps are NPZ archives with the columns of `Occupancy` and a version.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from enum import IntEnum
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Ints, Truths
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, Unreadable
from assistant.base.file_sets import write_all
from assistant.base.source_text import read_bytes
from assistant.cell.findings import NEWER_MAP, NO_MAP, OTHER_GRID, WRONG_CELL_SIZE
from assistant.sources.tables.npy_files import read_npz

_HALF: Final = 1 << 20
"""Places of cells along an axis go from -HALF to HALF - 1."""


class CellState(IntEnum):
    UNKNOWN = 0
    FREE = 1
    OCCUPIED = 2


CellStates = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Occupancy:
    """A map of cells of `size` mm; the cell (0, 0, 0) begins in the origin of the robot's base.

    robot: name of its kind. keys: (n,) of the cells that something is known of, ascending, see
    `keys_of`. filled, touched: (n,) in how many runs a cell was filled, or had a contact in it.
    free: (n,) whether it is free now, else it is occupied. runs: how many went into the map.
    """

    size: float
    robot: str
    keys: Ints
    filled: Ints
    touched: Ints
    free: Truths
    runs: int = 0

    @staticmethod
    def unknown(size: float, robot: str) -> Occupancy:
        """Return a map in which all space is unknown. Raises Refused for an invalid size."""
        if not (np.isfinite(size) and size > 0.0):
            raise Refused(WRONG_CELL_SIZE(size=f"{size:g}"), exit_status=2)
        none = np.zeros(0, dtype=np.int64)
        return Occupancy(float(size), robot, none, none, none, none.astype(np.bool_))

    def counts(self) -> Mapping[CellState, int]:
        """Return the numbers of free and occupied cells; unknown cells are unlimited."""
        free = int(self.free.sum())
        return {CellState.FREE: free, CellState.OCCUPIED: len(self.keys) - free}

    @property
    def litres(self) -> float:
        """The volume that is known to be free."""
        return self.counts()[CellState.FREE] * self.size**3 / 1e6

    def states(self, cells: Ints) -> CellStates:
        """(n,) `CellState` of cells (n, 3)."""
        return self._of(keys_of(cells))

    def at(self, points: Floats) -> CellStates:
        """(n,) `CellState` of the cells that points (n, 3) mm of the base lie in."""
        return self.states(cells_at(points, self.size))

    def _of(self, keys: Ints) -> CellStates:
        out = np.zeros(len(keys), dtype=np.uint8)
        if len(self.keys):
            place = np.minimum(np.searchsorted(self.keys, keys), len(self.keys) - 1)
            known = self.keys[place] == keys
            free = self.free[place[known]]
            out[known] = np.where(free, np.uint8(CellState.FREE), np.uint8(CellState.OCCUPIED))
        return out

    def new_in(self, keys: Ints) -> int:
        """Return how many of the cells with these keys are not free yet."""
        return int((self._of(keys) != CellState.FREE).sum())

    def cells(self, state: CellState) -> Ints:
        """(n, 3) cells that are free, or occupied."""
        wanted = self.free if state == CellState.FREE else ~self.free
        return cells_of_keys(self.keys[wanted])

    def with_run(self, filled: Ints, touched: Ints) -> Occupancy:
        """With a run that filled cells and then ended at a contact in others, by their keys."""
        keys = np.union1d(np.union1d(self.keys, filled), touched)
        out = self._spread(keys)
        now, hit = np.isin(keys, filled), np.isin(keys, touched)
        return Occupancy(
            self.size,
            self.robot,
            keys,
            out.filled + now,
            out.touched + hit,
            (out.free | now) & ~hit,
            self.runs + 1,
        )

    def merged(self, other: Occupancy) -> Occupancy:
        """Merge two maps. A cell that is free in one and occupied in the other is occupied.

        Raises Refused for maps of other robots or sizes of cells.
        """
        self._check(other)
        keys = np.union1d(self.keys, other.keys)
        a, b = self._spread(keys), other._spread(keys)
        known_a, known_b = np.isin(keys, self.keys), np.isin(keys, other.keys)
        return Occupancy(
            self.size,
            self.robot,
            keys,
            a.filled + b.filled,
            a.touched + b.touched,
            (a.free | ~known_a) & (b.free | ~known_b),
            self.runs + other.runs,
        )

    def compared(self, newer: Occupancy) -> Comparison:
        """Compare a newer map with this one: cells that are newly known, and cells that differ.

        Raises Refused for maps of other robots or sizes of cells.
        """
        self._check(newer)
        keys = np.union1d(self.keys, newer.keys)
        table = np.zeros((3, 3), dtype=np.int64)
        np.add.at(table, (self._of(keys), newer._of(keys)), 1)
        unknown, free, occupied = CellState.UNKNOWN, CellState.FREE, CellState.OCCUPIED
        return Comparison(
            same=int(table[free, free] + table[occupied, occupied]),
            gained=int(table[unknown].sum()),
            lost=int(table[:, unknown].sum()),
            freed=int(table[occupied, free]),
            blocked=int(table[free, occupied]),
        )

    def _spread(self, keys: Ints) -> Occupancy:
        """With a row for each of some more keys."""
        place = np.searchsorted(keys, self.keys)
        filled, touched = np.zeros((2, len(keys)), dtype=np.int64)
        free = np.zeros(len(keys), dtype=np.bool_)
        filled[place], touched[place], free[place] = self.filled, self.touched, self.free
        return Occupancy(self.size, self.robot, keys, filled, touched, free, self.runs)

    def _check(self, other: Occupancy) -> None:
        for one, two in (
            (f"cells of {self.size:g} mm", f"cells of {other.size:g} mm"),
            (f"the robot {self.robot}", f"the robot {other.robot}"),
        ):
            if one != two:
                raise Refused(OTHER_GRID(one=one, other=two), exit_status=2)


@dataclass(frozen=True, slots=True)
class Comparison:
    """Two maps, in cells: known alike; known in the newer only, in the older only; occupied and
    then free; free and then occupied.
    """

    same: int
    gained: int
    lost: int
    freed: int
    blocked: int


def cells_at(points: Floats, size: float) -> Ints:
    """(n, 3) cells that points (n, 3) mm lie in."""
    return np.floor(points / size).astype(np.int64)


def keys_of(cells: Ints) -> Ints:
    """(n,) a number for each of cells (n, 3), in their order."""
    x, y, z = (cells + _HALF).T
    return np.asarray((x << 42) | (y << 21) | z)


def cells_of_keys(keys: Ints) -> Ints:
    """(n, 3) cells by their numbers."""
    mask = (1 << 21) - 1
    return np.stack([keys >> 42, (keys >> 21) & mask, keys & mask], axis=1) - _HALF


_MAP_VERSION: Final = 1
_MAP_KIND: Final = "explored space"
_MAP_COLUMNS: Final = ("keys", "filled", "touched", "free")
_LARGEST_EXACT: Final = 2.0**53
"""The largest number that columns keep exactly: they are read as float64."""


def save_map(occupancy: Occupancy, path: str | FilePath) -> None:
    """Writes a map; the file appears whole or not at all. Raises Refused if it cannot be."""
    buffer = io.BytesIO()
    columns: dict[str, Any] = {name: getattr(occupancy, name) for name in _MAP_COLUMNS}
    columns["keys"] = np.stack([occupancy.keys >> 32, occupancy.keys & 0xFFFFFFFF])
    columns["free"] = occupancy.free.astype(np.uint8)
    numbers = np.array([_MAP_VERSION, occupancy.size, occupancy.runs], dtype=np.float64)
    np.savez_compressed(
        buffer, kind=np.array(_MAP_KIND), robot=np.array(occupancy.robot), about=numbers, **columns
    )
    write_all({FilePath(path): buffer.getvalue()})


def load_map(path: str | FilePath) -> Occupancy:
    """Load the map of a file. Raises Unreadable or Refused, with a finding, if it is not a map."""
    arrays, texts = read_npz(read_bytes(path), str(path))
    if texts.get("kind") != _MAP_KIND or "robot" not in texts:
        raise Unreadable(NO_MAP(path=str(path), reason="it says to be something else"))
    about = arrays.get("about", np.zeros(0))
    if about.shape == (3,) and about[0] > _MAP_VERSION:
        raise Refused(
            NEWER_MAP(path=str(path), version=float(about[0]), known=_MAP_VERSION), exit_status=2
        )
    reason = _map_fault(arrays, about)
    if reason:
        raise Unreadable(NO_MAP(path=str(path), reason=reason))
    return Occupancy(
        float(about[1]),
        texts["robot"],
        _keys(arrays["keys"]),
        _whole(arrays["filled"]),
        _whole(arrays["touched"]),
        arrays["free"] != 0.0,
        int(about[2]),
    )


def _map_fault(arrays: dict[str, Floats], about: Floats) -> str:
    """Return the reason why columns are not a map, empty if they are one."""
    if about.shape != (3,) or not (np.isfinite(about).all() and about[1] > 0.0 and about[2] >= 0.0):
        return "its `about` is not version, size of cells and number of runs"
    missing = [name for name in _MAP_COLUMNS if name not in arrays]
    if missing:
        return f"it lacks {', '.join(missing)}"
    keys, count = arrays["keys"], arrays["keys"].shape[-1] if arrays["keys"].ndim else 0
    if keys.shape != (2, count) or any(arrays[name].shape != (count,) for name in _MAP_COLUMNS[1:]):
        return "its columns differ in length"
    for name in _MAP_COLUMNS:
        values = arrays[name]
        if not (np.isfinite(values) & (values >= 0.0) & (values < _LARGEST_EXACT)).all():
            return f"`{name}` holds what no number of cells is"
        if (values != np.floor(values)).any():
            return f"`{name}` holds what is no whole number"
    if (keys >= [[2.0**31], [2.0**32]]).any() or (np.diff(_keys(keys)) <= 0).any():
        return "its cells are not in order"
    return ""


def _keys(halves: Floats) -> Ints:
    upper, lower = (_whole(row) for row in halves)
    return (upper << 32) | lower


def _whole(values: Floats) -> Ints:
    return values.astype(np.int64)

"""Long runs of alike lines as columns: declared robtargets and plain moves, and their text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.languages.rapid.tables.words import UNUSED
from assistant.program.arrays import Floats, Ints, Rows
from assistant.program.columns import Chosen, Decimal, Integer, Piece, rows_text

FEWEST: Final = 8
"""Rows that make a run; fewer are cheap as ordinary nodes."""

POSITION_PLACES: Final = 4
QUATERNION_PLACES: Final = 9
JOINT_PLACES: Final = 6
"""Of joints and external axes, degrees or mm."""
MOST_DECIMALS: Final = 1e6
"""mm; smaller values have nine exact decimals in a double."""
PARTS: Final = ((0, 3), (3, 7), (7, 11), (11, 17))
"""Columns of position, quaternion, confdata and external axes."""
MOVES: Final = ("MoveJ", "MoveL", "MoveC")
JOINT, LINEAR, CIRCULAR = range(3)


@dataclass(frozen=True, slots=True, eq=False)
class Names:
    """n names, each a stem and a number behind it.

    stem: (n,) int32 rows of stems. number: (n,) int64, -1 for a name that is its stem.
    """

    stems: tuple[bytes, ...]
    stem: NDArray[np.int32]
    number: Ints

    def __len__(self) -> int:
        return len(self.stem)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Names):
            return NotImplemented
        if len(self) != len(other) or not np.array_equal(self.number, other.number):
            return False
        same = np.array([[a == b for b in other.stems] for a in self.stems], dtype=bool)
        return len(self) == 0 or bool(same[self.stem, other.stem].all())

    def __hash__(self) -> int:
        return hash((len(self), self.number[:1].tobytes()))

    def pieces(self) -> list[Piece]:
        digits = Chosen(self.stem, self.stems)
        if (self.number >= 0).all():
            return [digits, Integer(self.number)]
        missing = np.where(self.number < 0, np.nan, self.number)
        return [digits, Decimal(missing, 0, missing=b"")]

    def name(self, row: int) -> str:
        """One name; for the few, never for all."""
        number = int(self.number[row])
        stem = self.stems[int(self.stem[row])].decode("ascii")
        return f"{stem}{number}" if number >= 0 else stem

    def rows(self, rows: slice | Rows) -> Names:
        return Names(self.stems, self.stem[rows], self.number[rows])

    @staticmethod
    def numbered(stem: str, count: int, first: int = 1) -> Names:
        """`stem` followed by first, first + 1 …"""
        return Names(
            (stem.encode("ascii"),),
            np.zeros(count, dtype=np.int32),
            np.arange(first, first + count, dtype=np.int64),
        )


@dataclass(frozen=True, slots=True, eq=False)
class TargetRun:
    """n declared robtargets.

    values: (n, 17) position mm, quaternion, confdata, external axes with 9E9 for unused ones.
    """

    names: Names
    values: Floats

    def __len__(self) -> int:
        return len(self.values)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TargetRun):
            return NotImplemented
        return self.names == other.names and np.array_equal(self.values, other.values)

    def __hash__(self) -> int:
        return hash(self.names)


@dataclass(frozen=True, slots=True)
class MotionNames:
    """What a plain move names behind its target; frame empty without WObj."""

    speed: str
    zone: str
    tool: str
    frame: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class MoveRun:
    """n plain moves, either all to targets with a name or all to targets that are written out.

    kinds: (n,) uint8, rows of MOVES. names: the n targets. vias: of the circular moves only.
    motion: (n,) int32 rows of motions. values: (n, 17) as of a TargetRun, of targets without
    a name; names and vias are empty then.
    """

    kinds: NDArray[np.uint8]
    names: Names
    vias: Names
    motion: NDArray[np.int32]
    motions: tuple[MotionNames, ...]
    values: Floats | None = None

    def __len__(self) -> int:
        return len(self.kinds)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, MoveRun):
            return NotImplemented
        if len(self) != len(other) or not np.array_equal(self.kinds, other.kinds):
            return False
        if (self.values is None) != (other.values is None):
            return False
        if self.values is not None and not np.array_equal(self.values, other.values):  # type: ignore[arg-type]
            return False
        same = np.array([[a == b for b in other.motions] for a in self.motions], dtype=bool)
        return (
            self.names == other.names
            and self.vias == other.vias
            and (len(self) == 0 or bool(same[self.motion, other.motion].all()))
        )

    def __hash__(self) -> int:
        return hash(self.names)


# Writing


def targets_text(run: TargetRun, scope: str, indent: str, newline: str) -> str:
    """The declarations of a run; every value comes back as the very same double."""
    head = f"{indent}{scope + ' ' if scope else ''}CONST robtarget "
    pieces: list[Piece] = [head.encode("ascii"), *run.names.pieces(), b":=", *_target(run.values)]
    pieces.append(b";" + newline.encode("ascii"))
    return rows_text(pieces, len(run)).decode("ascii")


def _target(values: Floats) -> list[Piece]:
    pieces: list[Piece] = []
    for part, (start, stop) in enumerate(PARTS):
        pieces.append(b"],[" if part else b"[[")
        for column in range(start, stop):
            pieces.append(b"," if column > start else b"")
            pieces += _number(values[:, column])
    return [*pieces, b"]]"]


def _number(values: Floats) -> list[Piece]:
    """A column in the fewest decimals that give it back; odd values as Python writes them."""
    if len(values) > 1 and (values == values[0]).all():
        return [rows_text(_number(values[:1]), 1)]
    for places in (0, POSITION_PLACES, QUATERNION_PLACES):
        if (np.abs(values) < MOST_DECIMALS).all() and (np.round(values, places) == values).all():
            return [Decimal(values, places, strip=True)]
    odd = (np.abs(values) >= MOST_DECIMALS) | (np.round(values, QUATERNION_PLACES) != values)
    different, index = np.unique(values[odd], return_inverse=True)
    texts = [b"9E9" if v == UNUSED else repr(float(v)).encode("ascii") for v in different]
    chosen = np.zeros(len(values), dtype=np.int64)
    chosen[odd] = index + 1
    pieces: list[Piece] = [Chosen(chosen, (b"", *texts))]
    if not odd.all():
        plain = np.where(odd, np.nan, values)
        pieces.append(Decimal(plain, QUATERNION_PLACES, strip=True, missing=b""))
    return pieces


def moves_text(run: MoveRun, indent: str, newline: str) -> str:
    circular = run.kinds == CIRCULAR
    row = np.cumsum(circular) - 1
    via = Names(
        (*run.vias.stems, b""),
        np.where(circular, _at(run.vias.stem, row), len(run.vias.stems)).astype(np.int32),
        np.where(circular, _at(run.vias.number, row), -1),
    )
    between = Chosen(circular.astype(np.int64), (b"", b","))
    kinds = tuple(f"{indent}{kind} ".encode("ascii") for kind in MOVES)
    tails = tuple(
        f",{m.speed},{m.zone},{m.tool}{chr(92) + 'WObj:=' + m.frame if m.frame else ''};{newline}"
        for m in run.motions
    )
    pieces: list[Piece] = [Chosen(run.kinds, kinds)]
    if circular.any():
        pieces += [*via.pieces(), between]
    pieces += run.names.pieces() if run.values is None else _target(run.values)
    pieces += [Chosen(run.motion, tuple(t.encode("ascii") for t in tails))]
    return rows_text(pieces, len(run)).decode("ascii")


def _at(values: Ints | NDArray[np.int32], rows: Rows) -> Ints:
    if not len(values):
        return np.zeros(len(rows), dtype=np.int64)
    return np.asarray(values[np.maximum(rows, 0)], dtype=np.int64)


def concatenate(runs: Sequence[TargetRun]) -> TargetRun:
    """Several runs as one."""
    stems: list[bytes] = []
    stem = []
    for run in runs:
        stem.append(run.names.stem + np.int32(len(stems)))
        stems.extend(run.names.stems)
    names = Names(
        tuple(stems),
        np.concatenate([np.empty(0, np.int32), *stem]),
        np.concatenate([np.empty(0, np.int64), *(run.names.number for run in runs)]),
    )
    return TargetRun(names, joined([np.empty((0, 17)), *(run.values for run in runs)]))


class Store:
    """An array (most, 17) whose rows are handed out in turn, so that `joined` need not copy.

    taken: rows handed out; set back for rows that are not wanted after all.
    """

    def __init__(self, most: int) -> None:
        self._values = np.empty((most, PARTS[-1][1]))
        self.taken = 0

    def take(self, rows: int) -> Floats:
        self.taken += rows
        return self._values[self.taken - rows : self.taken]


def joined(parts: Sequence[Floats]) -> Floats:
    """Rows (n, 17) one after the other; neighbours in one array stay where they are."""
    parts = [part for part in parts if len(part)] or list(parts[:1])
    base = parts[0].base
    if base is None or any(part.base is not base or not part.flags.c_contiguous for part in parts):
        return np.concatenate(parts)
    begins = [part.__array_interface__["data"][0] for part in parts]
    ends = [begin + part.nbytes for begin, part in zip(begins, parts, strict=True)]
    if begins[1:] != ends[:-1]:
        return np.concatenate(parts)
    first = (begins[0] - base.__array_interface__["data"][0]) // base.strides[0]
    return np.asarray(base[first : first + sum(map(len, parts))])

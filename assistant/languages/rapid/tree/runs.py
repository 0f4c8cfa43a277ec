"""Long runs of alike lines as columns: declared robtargets and plain moves, and their text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats
from assistant.base.columns import Chosen, Piece, rows_text
from assistant.languages.rapid.tables.words import UNUSED
from assistant.languages.runs.columns import Entries, Names, Run
from assistant.languages.runs.row_text import FewestDecimals, Groups

FEWEST_IN_RUN: Final = 8
"""Rows that make a run; fewer are cheap as ordinary nodes."""

POSITION_PLACES: Final = 4
QUATERNION_PLACES: Final = 9
JOINT_PLACES: Final = 6
"""Of joints and external axes, degrees or mm."""
SIZES_PLACES: Final = 6
"""Of masses, inertias, speeds and zone sizes."""
TARGET_DECIMALS: Final = FewestDecimals((0, POSITION_PLACES, QUATERNION_PLACES), {UNUSED: b"9E9"})
TARGET_PARTS: Final = ((0, 3), (3, 7), (7, 11), (11, 17))
"""Columns of position, quaternion, confdata and external axes."""
TARGET_GROUPS: Final = Groups(
    tuple(stop - start for start, stop in TARGET_PARTS),
    *(b"[[", b"],[", b"]]"),
    known=tuple((text, UNUSED) for text in (b"9E9", b"9E+09", b"9E+9")),
)
"""A robtarget that is written out."""
PLAIN_MOVES: Final = ("MoveJ", "MoveL", "MoveC")
JOINT, LINEAR, CIRCULAR = range(3)


@dataclass(frozen=True, slots=True, eq=False)
class TargetRun(Run):
    """n declared robtargets.

    values: (n, 17) position mm, quaternion, confdata, external axes with 9E9 for unused ones.
    """

    names: Names
    values: Floats

    @classmethod
    def of(cls, rows: Sequence[tuple[str, list[float]]]) -> TargetRun:
        """rows: the name and the 17 numbers of each."""
        names, values = zip(*rows, strict=True)
        return cls(Names.of(names), np.array(values, dtype=np.float64))


@dataclass(frozen=True, slots=True)
class MotionNames:
    """What a plain move names behind its target; frame empty without WObj."""

    speed: str
    zone: str
    tool: str
    frame: str = ""


class MoveRow(NamedTuple):
    """A plain move: a row of MOVES, and the name or the 17 numbers of its target.

    via: empty for a move that is not circular.
    """

    kind: int
    target: str | list[float]
    via: str
    motion: MotionNames

    @property
    def is_written(self) -> bool:
        return not isinstance(self.target, str)


@dataclass(frozen=True, slots=True, eq=False)
class MoveRun(Run):
    """n plain moves, either all to targets with a name or all to targets that are written out.

    kinds: (n,) uint8, rows of MOVES. names: the n targets; none of those that are written out.
    vias: none of moves that are not circular. values: (n, 17) as of a TargetRun, of targets
    without a name.
    """

    kinds: NDArray[np.uint8]
    names: Names
    vias: Names
    motions: Entries[MotionNames]
    values: Floats | None = None

    @classmethod
    def of(cls, rows: Sequence[MoveRow]) -> MoveRun:
        none = Names.none(len(rows))
        return cls(
            np.array([row.kind for row in rows], dtype=np.uint8),
            none if rows[0].is_written else Names.of([str(row.target) for row in rows]),
            Names.of([row.via for row in rows]) if any(row.via for row in rows) else none,
            Entries.of(row.motion for row in rows),
            np.array([row.target for row in rows]) if rows[0].is_written else None,
        )


# Writing


def targets_text(run: TargetRun, scope: str, indent: str, newline: str) -> str:
    """The declarations of a run; every value comes back as the very same double."""
    head = f"{indent}{scope + ' ' if scope else ''}CONST robtarget "
    pieces: list[Piece] = [
        head.encode("ascii"),
        *run.names.pieces(),
        b":=",
        *_target_pieces(run.values),
    ]
    pieces.append(b";" + newline.encode("ascii"))
    return rows_text(pieces, len(run)).decode("ascii")


def _target_pieces(values: Floats) -> list[Piece]:
    return TARGET_GROUPS.pieces([TARGET_DECIMALS.pieces(column) for column in values.T])


def moves_text(run: MoveRun, indent: str, newline: str) -> str:
    circular = run.kinds == CIRCULAR
    kinds = tuple(f"{indent}{kind} ".encode("ascii") for kind in PLAIN_MOVES)
    tails = tuple(
        f",{m.speed},{m.zone},{m.tool}{chr(92) + 'WObj:=' + m.frame if m.frame else ''};{newline}"
        for m in run.motions.table
    )
    pieces: list[Piece] = [Chosen(run.kinds, kinds)]
    if circular.any():
        pieces += [*run.vias.pieces(), Chosen(circular.astype(np.int64), (b"", b","))]
    pieces += run.names.pieces() if run.values is None else _target_pieces(run.values)
    pieces += [Chosen(run.motions.index, tuple(t.encode("ascii") for t in tails))]
    return rows_text(pieces, len(run)).decode("ascii")

"""Contours in the axes of who looks along the tool."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from assistant.program.geometry import Vector
from assistant.sources.contours.curves import Line, Points, cross, vector
from assistant.sources.contours.flat import Piece
from assistant.sources.contours.orientation import level_x_axis


@dataclass(frozen=True, slots=True)
class ToolView:
    """axes: (3, 3), rows x, y and up, which is against the tool; x and y are as one sees them who
    looks along the tool.
    """

    axes: Points

    @staticmethod
    def along(direction: Vector) -> ToolView:
        up = -np.asarray(direction, dtype=np.float64)
        x = level_x_axis(direction)
        return ToolView(np.stack([x, cross(up, x), up]))

    def of(self, pieces: Sequence[Piece]) -> tuple[Piece, ...]:
        return _in_view(pieces, self.axes)

    def back(self, pieces: Sequence[Piece]) -> tuple[Piece, ...]:
        return _in_view(pieces, self.axes.T)


def _in_view(pieces: Sequence[Piece], axes: Points) -> tuple[Piece, ...]:
    if np.array_equal(axes, np.eye(3)):
        return tuple(pieces)
    return tuple(_piece_in_view(piece, axes) for piece in pieces)


def _piece_in_view(piece: Piece, axes: Points) -> Piece:
    start, end = vector(axes @ piece.start), vector(axes @ piece.end)
    if isinstance(piece, Line):
        return replace(piece, start=start, end=end)
    via, centre, normal = (vector(axes @ v) for v in (piece.via, piece.centre, piece.normal))
    return replace(piece, start=start, via=via, end=end, centre=centre, normal=normal)

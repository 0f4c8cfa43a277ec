"""How the tool stands along a contour, in columns."""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Rows
from assistant.program.geometry import Vector
from assistant.program.motion import Kind
from assistant.sources.contours.curves import Points
from assistant.sources.contours.moves import Moves

SMOOTH_CORNER: Final = 15.0
"""Degrees of a corner up to which the tool turns on while it moves; over it, it stops."""
LEAST_PROJECTION: Final = 1e-6
"""Length of a projected unit vector below which it has no direction."""


def level_x_axis(direction: Vector) -> Points:
    """The tool's x axis that is as near to the frame's +X as `direction`, its z axis, allows.

    The frame's +Y takes the place of +X where the tool points along X.
    """
    z = np.asarray(direction, dtype=np.float64)
    for axis in (np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])):
        x = axis - (axis @ z) * z
        length = float(np.linalg.norm(x))
        if length > LEAST_PROJECTION:
            return np.asarray(x / length)
    raise ValueError(f"{direction} is no direction")


def facing_quaternions(direction: Vector, x: Points) -> Points:
    """Canonical quaternions (n, 4) of tools with z along a direction and x axes (n, 3)."""
    z = np.broadcast_to(np.asarray(direction, dtype=np.float64), x.shape)
    return rotations.from_matrix(np.stack([x, np.cross(z, x), z], axis=-1))


def degrees_turned(quaternions: Points, direction: Vector) -> float:
    """Degrees about a direction that tools (n, 4) turn from the first to the last, in all.

    From row to row they turn the shorter way; to the right about the direction counts up.
    """
    x = level_x_axis(direction)
    y = np.cross(np.asarray(direction, dtype=np.float64), x)
    axes = rotations.rotate(quaternions, np.broadcast_to([1.0, 0.0, 0.0], (len(quaternions), 3)))
    angles = np.unwrap(np.arctan2(axes @ y, axes @ x))
    return float(np.degrees(angles[-1] - angles[0]))


def x_axes_along(moves: Moves, direction: Vector) -> tuple[Points, Points, Rows]:
    """X axes that follow the contour: at its start (3,), at the rows, and where to turn.

    The rows' axes are (m, 3) for the rows that the third result, (m,), lists: a row that
    comes twice is a corner, at which the tool stops and then turns. At a smooth joint the
    axis is the mean of both sides. Where the contour runs along the tool, the last axis
    before it holds on.
    """
    n = len(moves)
    z = np.asarray(direction, dtype=np.float64)
    arriving, leaving = (_projected_units(v, z) for v in (moves.arriving, moves.leaving))
    both = np.stack([leaving, arriving], axis=1).reshape(-1, 3)  # in order of the way
    both = _filled_forward(both, level_x_axis(direction))
    leaving, arriving = both[0::2], both[1::2]
    after = np.concatenate([leaving[1:], arriving[-1:]])
    turn = np.degrees(
        np.arctan2(
            np.linalg.norm(np.cross(arriving, after), axis=1), (arriving * after).sum(axis=1)
        )
    )
    corner = (turn > SMOOTH_CORNER) & (moves.kinds != Kind.VIA)
    mean = _unit_normals(np.where(corner[:, None], arriving, arriving + after))
    rows = np.repeat(np.arange(n), np.where(corner, 2, 1))
    second = np.flatnonzero(rows[1:] == rows[:-1]) + 1
    axes = mean[rows]
    axes[second] = after[rows[second]]
    return leaving[0], axes, rows


def _projected_units(v: Points, z: Points) -> Points:
    """Unit vectors of v (n, 3) seen along z; NaN where v runs along it."""
    flat = v - (v @ z)[:, None] * z
    size = np.linalg.norm(flat, axis=1, keepdims=True)
    known = size > LEAST_PROJECTION
    return np.asarray(np.where(known, flat / np.where(known, size, 1.0), np.nan))


def _filled_forward(v: Points, otherwise: Points) -> Points:
    """Rows of NaN filled with the row before; the first ones with the first known, if any."""
    known = np.flatnonzero(~np.isnan(v[:, 0]))
    if not known.size:
        return np.broadcast_to(otherwise, v.shape)
    place = np.searchsorted(known, np.arange(len(v)), "right") - 1
    return np.asarray(v[known[np.maximum(place, 0)]])


def _unit_normals(v: Points) -> Points:
    return np.asarray(v / np.linalg.norm(v, axis=1, keepdims=True))

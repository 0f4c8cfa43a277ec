"""Object coordinate systems, inserts and directions as matrices.

Matrices are (4, 4), work on columns and hold mm in the end: world = matrix @ [x y z 1].
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats

if TYPE_CHECKING:
    from ezdxf.entities.insert import Insert


_ARBITRARY_AXIS_BOUND: Final = 1.0 / 64.0
"""DXF reference, arbitrary axis algorithm: closer than this to z, x comes from the y axis."""

_LARGEST: Final = 1e20
"""Largest number of an insert in the drawing's unit, even the finest unit; squares stay finite."""

_EVEN: Final = 1e-6
"""Relative difference in scale, and cosine, below which a transform keeps angles."""


def ocs_axes(extrusion: ArrayLike) -> Floats:
    """Axes of the object coordinate system of an extrusion, in columns (3, 3), read only.

    The arbitrary axis algorithm of the DXF reference. Raises ValueError for a zero vector.
    """
    x, y, z = np.asarray(extrusion, dtype=np.float64).tolist()
    return _axes_of(x, y, z)


@lru_cache(maxsize=1024)
def _axes_of(*extrusion: float) -> Floats:
    # A drawing has few directions, and most entities are flat.
    z = _unit(np.array(extrusion))
    near = abs(z[0]) < _ARBITRARY_AXIS_BOUND and abs(z[1]) < _ARBITRARY_AXIS_BOUND
    x = _unit(cross(np.array((0.0, 1.0, 0.0) if near else (0.0, 0.0, 1.0)), z))
    axes = np.column_stack([x, cross(z, x), z])
    # The array is cached and shared.
    axes.flags.writeable = False
    return axes


def cross(a: Floats, b: Floats) -> Floats:
    """Vector product of two (3,); numpy's own is made for columns and slow on one."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def ocs_matrix(extrusion: ArrayLike) -> Floats:
    """Object to world coordinates of an entity with that extrusion."""
    return affine(ocs_axes(extrusion))


def affine(linear: ArrayLike, origin: ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
    """The (4, 4) matrix of a (3, 3) one and where it puts the origin."""
    matrix = np.eye(4)
    matrix[:3, :3] = linear
    matrix[:3, 3] = origin
    return matrix


def scaling(factor: float) -> Floats:
    return affine(np.eye(3) * factor)


def point(matrix: Floats, p: ArrayLike) -> Floats:
    """A point (3,) or points (n, 3) moved by a matrix."""
    return np.asarray(np.asarray(p, dtype=np.float64) @ matrix[:3, :3].T + matrix[:3, 3])


def direction(matrix: Floats, v: ArrayLike) -> Floats:
    """A vector (3,) or vectors (n, 3) turned and scaled by a matrix, but not moved."""
    return np.asarray(np.asarray(v, dtype=np.float64) @ matrix[:3, :3].T)


def cells(insert: Insert) -> Iterator[tuple[float, float]]:
    """Offsets of the copies of an insert along its own turned x and y, rows last.

    One for a plain insert. Where the spacing is 0 copies would coincide: then there is one.
    """
    dxf = insert.dxf
    columns, rows = copies(insert)
    for row in range(rows):
        for column in range(columns):
            yield column * dxf.column_spacing, row * dxf.row_spacing


def copies(insert: Insert) -> tuple[int, int]:
    """Return the number of columns and rows of an insert, see `cells`."""
    dxf = insert.dxf
    columns = dxf.column_count if dxf.column_spacing else 1
    rows = dxf.row_count if dxf.row_spacing else 1
    return max(columns, 1), max(rows, 1)


def check_insert(insert: Insert) -> None:
    """Raises ValueError for an insert whose numbers cannot be reckoned with."""
    dxf = insert.dxf
    numbers = [dxf.rotation, dxf.xscale, dxf.yscale, dxf.zscale, dxf.row_spacing]
    numbers += [dxf.column_spacing, *dxf.insert.xyz, *dxf.extrusion.xyz]
    if not all(abs(float(n)) < _LARGEST for n in numbers):  # NaN fails as well
        raise ValueError(f"a number is not finite or beyond {_LARGEST:g}")
    _scale(insert)


def insert_axes(insert: Insert) -> Floats:
    """Axes of an insert in columns (3, 3), unit length, turned over where a scale is negative."""
    return np.asarray(_turned_axes(insert) * np.sign(_scale(insert)))


def insert_origin(insert: Insert, cell: tuple[float, float] = (0.0, 0.0)) -> Floats:
    """Return the position at which an insert puts the base point of its block.

    The grid of a multiple insert is turned with it, but not scaled.
    """
    at = direction(ocs_matrix(insert.dxf.extrusion), insert.dxf.insert.xyz)
    return np.asarray(at + _turned_axes(insert) @ np.array([*cell, 0.0]))


def insert_matrix(
    insert: Insert, base: ArrayLike = (0.0, 0.0, 0.0), cell: tuple[float, float] = (0.0, 0.0)
) -> Floats:
    """Return the transform from block coordinates to those of the insert's container.

    base: base point of the block. cell: offset of one copy of a multiple insert.
    """
    linear = _turned_axes(insert) * _scale(insert)
    origin = insert_origin(insert, cell) - linear @ np.asarray(base, dtype=np.float64)
    return affine(linear, origin)


def mirrors(matrix: Floats) -> bool:
    return bool(np.linalg.det(matrix[:3, :3]) < 0)


def skews(matrix: Floats) -> bool:
    # A transform that keeps angles has equal diagonals and zeros elsewhere.
    """True if a matrix changes angles, as an uneven scale does."""
    gram = matrix[:3, :3].T @ matrix[:3, :3]
    even = np.eye(3) * np.trace(gram) / 3.0
    return bool(np.abs(gram - even).max() > _EVEN * np.trace(gram))


def right_handed(x: Floats, z: Floats) -> Floats:
    """Rotation matrix with z along `z`, and x as near to `x` as it can be.

    Raises ValueError if a vector is zero or both are parallel.
    """
    unit_z = _unit(z)
    unit_x = _unit(x)
    across = unit_x - (unit_x @ unit_z) * unit_z
    # Parallel vectors leave x undetermined.
    if np.linalg.norm(across) < 1e-9:
        raise ValueError("its directions fall into one")
    across = _unit(across)
    return np.column_stack([across, cross(unit_z, across), unit_z])


def _turned_axes(insert: Insert) -> Floats:
    angle = math.radians(insert.dxf.rotation)
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(ocs_axes(insert.dxf.extrusion) @ turn)


def _scale(insert: Insert) -> Floats:
    x, y, z = (float(s) for s in (insert.dxf.xscale, insert.dxf.yscale, insert.dxf.zscale))
    # Writers of flat drawings put 0 for z, where nothing stands that it could scale.
    scale = np.array([x, y, z or abs(x)], dtype=np.float64)
    if not scale.all():
        raise ValueError("a scale of the insert in x or y is 0")
    return scale


def _unit(v: Floats) -> Floats:
    length = float(np.linalg.norm(v))
    if not 0.0 < length < math.inf:
        raise ValueError("a direction has no length")
    return np.asarray(v / length)

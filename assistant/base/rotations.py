"""Rotations in columns: quaternions (n, 4) scalar first, matrices (n, 3, 3), Euler angles.

Angles are degrees. A quaternion column that leaves this module is of unit length and has
its first non-zero part positive, so that equal rotations have equal columns.
"""

from __future__ import annotations

from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats, norms

EulerOrder = Literal["ZYX", "XYZ", "ZYZ"]
"""Intrinsic orders. ZYX: R = Rz(c)·Ry(b)·Rx(a), the A, B, C of MELFA and RAPID's OrientZYX."""

AXES: Final = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}

DUST: Final = 1e-14
"""Quaternion parts below this are rounding: they stand for 1e-12 degrees."""
NOTHING: Final = 1e-9
"""Quaternion parts up to this do not tell on which side of the sphere it is."""


def canonical(quaternions: ArrayLike) -> Floats:
    """Unit length, and the first part that is not nearly zero made positive; (..., 4).

    Parts below `DUST` become 0: a half turn about x is (0, 1, 0, 0), whatever rounding left.
    """
    q = np.asarray(quaternions, dtype=np.float64)
    q = q / np.sqrt(np.einsum("...i,...i->...", q, q))[..., None]
    size = np.abs(q)
    q[size < DUST] = 0.0
    first = q[..., 0]
    # w decides for nearly all rotations: the search along each row is left out.
    if not (size[..., 0] > NOTHING).all():
        at = (size > NOTHING).argmax(axis=-1)
        first = np.take_along_axis(q, at[..., None], axis=-1)[..., 0]
    q *= np.where(first < 0.0, -1.0, 1.0)[..., None]
    q += 0.0  # no negative zero
    return np.asarray(q)


def unflipped(quaternions: Floats) -> Floats:
    """The same rotations (n, 4), each on the side of the one before it."""
    cosine = np.einsum("ij,ij->i", quaternions[1:], quaternions[:-1])
    if not (cosine < 0.0).any():
        return quaternions
    sign = np.cumprod(np.concatenate([[1.0], np.where(cosine < 0.0, -1.0, 1.0)]))
    return np.asarray(quaternions * sign[:, None])


def multiply(left: ArrayLike, right: ArrayLike) -> Floats:
    """Hamilton product, broadcast over leading axes; (..., 4)."""
    return np.stack(_product(left, right), axis=-1)


def _product(left: ArrayLike, right: ArrayLike) -> tuple[Floats, Floats, Floats, Floats]:
    """The parts (...) of a Hamilton product."""
    a, b = np.asarray(left, dtype=np.float64), np.asarray(right, dtype=np.float64)
    aw, ax, ay, az = a[..., 0], a[..., 1], a[..., 2], a[..., 3]
    bw, bx, by, bz = b[..., 0], b[..., 1], b[..., 2], b[..., 3]
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def conjugate(quaternions: ArrayLike) -> Floats:
    return np.asarray(np.multiply(quaternions, [1.0, -1.0, -1.0, -1.0]))


def rotate(quaternions: ArrayLike, vectors: ArrayLike) -> Floats:
    """Vectors (..., 3) turned by unit quaternions (..., 4)."""
    q, v = np.asarray(quaternions, dtype=np.float64), np.asarray(vectors, dtype=np.float64)
    w, x, y, z = np.moveaxis(q, -1, 0)
    a, b, c = np.moveaxis(v, -1, 0)
    # t = 2 (x, y, z) × v, and v + w t + (x, y, z) × t; by columns, as `np.cross` is slower.
    t, u, s = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return np.stack(
        [a + w * t + (y * s - z * u), b + w * u + (z * t - x * s), c + w * s + (x * u - y * t)],
        axis=-1,
    )


def angle_between(left: ArrayLike, right: ArrayLike) -> Floats:
    """Angle in degrees between two unit quaternion columns, exact for small angles."""
    w, x, y, z = _product(conjugate(left), right)
    # The arc cosine of w would lose angles below 1e-6 degrees.
    sine = np.sqrt(x * x + y * y + z * z)
    return np.asarray(np.degrees(2.0 * np.arctan2(sine, np.abs(w))))


def turns(first: ArrayLike, last: ArrayLike) -> Floats:
    """Radians about each axis (..., 3) of the shorter turns from unit quaternions to others."""
    turn = multiply(last, conjugate(first))
    turn = np.where(turn[..., :1] < 0.0, -turn, turn)
    sine = norms(turn[..., 1:])[..., None]
    angle = 2.0 * np.arctan2(sine, turn[..., :1])
    # The limit of angle / sine for small turns is 2.
    return np.asarray(turn[..., 1:] * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 2.0))


def between(first: ArrayLike, last: ArrayLike, part: ArrayLike) -> Floats:
    """Unit quaternions on the shorter turns from unit quaternions (..., 4) to others (..., 4).

    part: (...) of each turn; all three are broadcast. The sign is that of the first.
    """
    a, b = np.asarray(first, dtype=np.float64), np.asarray(last, dtype=np.float64)
    b = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0.0, -b, b)
    apart, near = norms(b - a), norms(b + a)
    # From the lengths of two chords, as an arc cosine loses small angles.
    angle = (2.0 * np.arctan2(apart, near))[..., None]
    sine, t = np.sin(angle), np.asarray(part, dtype=np.float64)[..., None]
    # Rotations that are nearly equal are interpolated linearly: the sines would give 0 / 0.
    alike = sine < 1e-9
    safe = np.where(alike, 1.0, sine)
    one = np.where(alike, 1.0 - t, np.sin((1.0 - t) * angle) / safe)
    two = np.where(alike, t, np.sin(t * angle) / safe)
    return np.asarray(one * a + two * b)


def about(axis: ArrayLike, degrees: ArrayLike) -> Floats:
    """Quaternions of turns about a unit axis (..., 3)."""
    half = np.radians(np.asarray(degrees, dtype=np.float64)) / 2.0
    return np.concatenate(
        [np.cos(half)[..., None], np.sin(half)[..., None] * np.asarray(axis, dtype=np.float64)],
        axis=-1,
    )


def from_euler(angles: ArrayLike, order: EulerOrder = "ZYX") -> Floats:
    """Quaternions of intrinsic Euler angles (..., 3), given in the order of the letters."""
    a = np.asarray(angles, dtype=np.float64)
    first, second, third = (about(AXES[letter], a[..., i]) for i, letter in enumerate(order))
    return canonical(multiply(multiply(first, second), third))


_LOCKED: Final = 1e-9
"""Sine or cosine of the middle angle below which the outer two are one rotation."""


def to_euler(quaternions: ArrayLike, order: EulerOrder = "ZYX") -> Floats:
    """Return intrinsic Euler angles (..., 3), in the order of the letters, in (-180, 180].

    If the middle angle makes the outer two one rotation, the first of them is 0 (a controller shows
    C = 0 there). The last angle is computed from the rotation that remains once the first is turned
    back, so that nothing is lost near that singularity.
    """
    m = to_matrix(quaternions)
    x, y, z = (m[..., row, :] for row in range(3))
    if order == "ZYX":
        flat = np.hypot(x[..., 0], y[..., 0])
        s, c, first = _first(y[..., 0], x[..., 0], flat)
        middle = np.arctan2(-z[..., 0], c * x[..., 0] + s * y[..., 0])
        last = np.arctan2(s * x[..., 2] - c * y[..., 2], c * y[..., 1] - s * x[..., 1])
    elif order == "XYZ":
        flat = np.hypot(y[..., 2], z[..., 2])
        s, c, first = _first(-y[..., 2], z[..., 2], flat)
        middle = np.arctan2(x[..., 2], c * z[..., 2] - s * y[..., 2])
        last = np.arctan2(c * y[..., 0] + s * z[..., 0], c * y[..., 1] + s * z[..., 1])
    else:
        flat = np.hypot(x[..., 2], y[..., 2])
        s, c, first = _first(y[..., 2], x[..., 2], flat)
        middle = np.arctan2(c * x[..., 2] + s * y[..., 2], z[..., 2])
        last = np.arctan2(c * y[..., 0] - s * x[..., 0], c * y[..., 1] - s * x[..., 1])
    degrees = np.degrees(np.stack([first, middle, last], axis=-1))
    return np.asarray(np.where(degrees <= -180.0, degrees + 360.0, degrees) + 0.0)


def _first(y: Floats, x: Floats, flat: Floats) -> tuple[Floats, Floats, Floats]:
    """Sine, cosine and value of the first angle, 0 where it is locked to the last."""
    angle = np.where(flat < _LOCKED, 0.0, np.arctan2(y, x))
    return np.sin(angle), np.cos(angle), angle


def to_matrix(quaternions: ArrayLike) -> Floats:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    q = np.asarray(quaternions, dtype=np.float64)
    w, x, y, z = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    out = np.empty((*w.shape, 3, 3))  # `np.stack` takes twice as long for a single row
    out[..., 0, 0] = 1 - 2 * (y * y + z * z)
    out[..., 0, 1] = 2 * (x * y - w * z)
    out[..., 0, 2] = 2 * (x * z + w * y)
    out[..., 1, 0] = 2 * (x * y + w * z)
    out[..., 1, 1] = 1 - 2 * (x * x + z * z)
    out[..., 1, 2] = 2 * (y * z - w * x)
    out[..., 2, 0] = 2 * (x * z - w * y)
    out[..., 2, 1] = 2 * (y * z + w * x)
    out[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return out


def from_matrix(matrices: ArrayLike) -> Floats:
    """Canonical quaternions (..., 4) of rotation matrices (..., 3, 3).

    Shepperd's method (J. Guidance and Control 1978): the largest part first, so that no
    rotation loses precision.
    """
    m = np.asarray(matrices, dtype=np.float64)
    d = np.einsum("...ii->...i", m)
    trace = d.sum(axis=-1)
    squares = np.stack(
        [1 + trace, *(1 + 2 * d[..., i] - trace for i in range(3))], axis=-1
    )  # 4 w², 4 x², 4 y², 4 z²
    wx, wy, wz = (
        m[..., 2, 1] - m[..., 1, 2],
        m[..., 0, 2] - m[..., 2, 0],
        m[..., 1, 0] - m[..., 0, 1],
    )
    xy, xz, yz = (
        m[..., 0, 1] + m[..., 1, 0],
        m[..., 0, 2] + m[..., 2, 0],
        m[..., 1, 2] + m[..., 2, 1],
    )
    s = np.moveaxis(squares, -1, 0)
    rows = np.stack(
        [
            np.stack([s[0], wx, wy, wz], -1),
            np.stack([wx, s[1], xy, xz], -1),
            np.stack([wy, xy, s[2], yz], -1),
            np.stack([wz, xz, yz, s[3]], -1),
        ],
        axis=-2,
    )
    best = squares.argmax(axis=-1)
    return canonical(np.take_along_axis(rows, best[..., None, None], axis=-2)[..., 0, :])

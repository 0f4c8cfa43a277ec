"""Where rays from one place meet shapes: how far, and how the surface stands there.

Each function takes the place (3,) and directions (n, 3) in the frame of the shape, and gives
distances (n,) in lengths of the directions, inf where nothing is met, and unit normals (n, 3).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.cell.scene import Box, Capsule, Convex, Cylinder, Mesh, Shape, Sphere

Hits = tuple[Floats, Floats]
PAIRS_AT_ONCE: Final = 2_000_000
"""Pairs of rays and triangles that are worked out at once."""
PARALLEL_SHARE: Final = 1e-12
"""Of a direction along an axis or a face, below which it runs beside it."""


def cast_rays(shape: Shape, eye: Floats, rays: Floats) -> Hits:
    """The first meeting of each ray with a shape, seen from outside."""
    match shape:
        case Sphere(radius=radius):
            return _sphere(np.zeros(3), radius, eye, rays)
        case Capsule(radius=radius, length=length):
            ends = (np.array([0.0, 0.0, end * length / 2.0]) for end in (-1.0, 1.0))
            parts = [_sphere(end, radius, eye, rays) for end in ends]
            return _nearest_hits(_tube(radius, length, eye, rays), *parts)
        case Cylinder(radius=radius, length=length):
            lids = [_lid(radius, side * length / 2.0, side, eye, rays) for side in (-1.0, 1.0)]
            return _nearest_hits(_tube(radius, length, eye, rays), *lids)
        case Box(size=size):
            normals = np.concatenate([np.eye(3), -np.eye(3)])
            return _halves(normals, np.tile(np.array(size) / 2.0, 2), eye, rays)
        case Convex():
            hull = shape.hull
            normals, corners = _faces(hull)
            offsets = (normals * corners).sum(axis=1)
            return _halves(normals, offsets, eye, rays)
    return _triangles(shape, eye, rays)


def _sphere(centre: Floats, radius: float, eye: Floats, rays: Floats) -> Hits:
    away = centre - eye
    squares = (rays**2).sum(axis=1)
    along = rays @ away / squares
    inside = along**2 - (away @ away - radius**2) / squares
    t = np.full(len(rays), np.inf)
    hit = inside >= 0.0
    t[hit] = along[hit] - np.sqrt(inside[hit])
    t[~(t > 0.0)] = np.inf
    return t, _hits_at(eye, rays, t, lambda points: (points - centre) / radius)


def _tube(radius: float, length: float, eye: Floats, rays: Floats) -> Hits:
    """The side of a cylinder about z."""
    across = (rays[:, :2] ** 2).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        along = -(rays[:, :2] @ eye[:2]) / across
        inside = along**2 - (eye[:2] @ eye[:2] - radius**2) / across
        t = along - np.sqrt(inside)
        good = (across > PARALLEL_SHARE) & (inside >= 0.0) & (t > 0.0)
        good &= np.abs(eye[2] + t * rays[:, 2]) <= length / 2.0
    t[~good] = np.inf

    def normal(points: Floats) -> Floats:
        return np.column_stack([points[:, :2] / radius, np.zeros(len(points))])

    return t, _hits_at(eye, rays, t, normal)


def _lid(radius: float, z: float, side: float, eye: Floats, rays: Floats) -> Hits:
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (z - eye[2]) / rays[:, 2]
        at = eye[:2] + t[:, None] * rays[:, :2]
        good = (side * rays[:, 2] < 0.0) & (t > 0.0) & ((at**2).sum(axis=1) <= radius**2)
    t[~good] = np.inf
    return t, np.tile([0.0, 0.0, side], (len(rays), 1))


def _halves(normals: Floats, offsets: Floats, eye: Floats, rays: Floats) -> Hits:
    """A convex body as half spaces normal · x ≤ offset."""
    enter, leave = np.full(len(rays), -np.inf), np.full(len(rays), np.inf)
    face = np.zeros(len(rays), dtype=np.intp)
    for number, (normal, offset) in enumerate(zip(normals, offsets, strict=True)):
        toward, rest = rays @ normal, offset - eye @ normal
        with np.errstate(divide="ignore", invalid="ignore"):
            t = rest / toward
        front = toward < -PARALLEL_SHARE
        later = front & (t > enter)
        enter[later], face[later] = t[later], number
        back = toward > PARALLEL_SHARE
        leave[back] = np.minimum(leave[back], t[back])
        if rest < 0.0:
            leave[~front & ~back] = -np.inf
    enter[~((enter <= leave) & (enter > 0.0))] = np.inf
    return enter, normals[face]


def _faces(mesh: Mesh) -> Hits:
    """Unit normals of its triangles, and a corner of each."""
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    across = np.cross(b - a, c - a)
    sizes = np.linalg.norm(across, axis=1, keepdims=True)
    return across / np.where(sizes > 0.0, sizes, 1.0), a


def _triangles(mesh: Mesh, eye: Floats, rays: Floats) -> Hits:
    """By Möller and Trumbore, Fast, minimum storage ray-triangle intersection, 1997."""
    best, face = np.full(len(rays), np.inf), np.zeros(len(rays), dtype=np.intp)
    for rows in _chunks(len(rays), len(mesh.triangles)):
        some = rays[rows]
        for number, (i, j, k) in enumerate(mesh.triangles):
            a = mesh.points[i]
            one, two = mesh.points[j] - a, mesh.points[k] - a
            p = np.cross(some, two)
            size = p @ one
            with np.errstate(divide="ignore", invalid="ignore"):
                u = p @ (eye - a) / size
                q = np.cross(eye - a, one)
                v = some @ q / size
                t = two @ q / size
                good = (np.abs(size) > PARALLEL_SHARE) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
                good &= (t > 0.0) & (t < best[rows])
            best[rows] = np.where(good, t, best[rows])
            face[rows] = np.where(good, number, face[rows])
    normals = _faces(mesh)[0][face]
    normals[(normals * rays).sum(axis=1) > 0.0] *= -1.0
    return best, normals


def _chunks(count: int, across: int) -> Iterator[slice]:
    step = max(PAIRS_AT_ONCE // max(across, 1), 1024)
    return (slice(start, start + step) for start in range(0, count, step))


def _nearest_hits(*found: Hits) -> Hits:
    """The nearest of several meetings."""
    distances = np.stack([t for t, _ in found])
    which = distances.argmin(axis=0)
    rows = np.arange(distances.shape[1])
    return distances[which, rows], np.stack([n for _, n in found])[which, rows]


def _hits_at(eye: Floats, rays: Floats, t: Floats, normal: object) -> Floats:
    """Normals where something is met, upright elsewhere."""
    out = np.tile([0.0, 0.0, 1.0], (len(rays), 1))
    hit = np.isfinite(t)
    out[hit] = normal(eye + t[hit, None] * rays[hit])  # type: ignore[operator]
    return out

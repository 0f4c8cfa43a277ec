"""Whether a picture agrees that an outline is where it is said to be.

Of each place on the outline one of three things holds: there is an edge (it is supported); there is
none and something else covers the place (it is hidden); or the picture contradicts: the material
goes on across the outline, or there is none at all.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.program.arrays import Floats, Truths
from assistant.program.geometry import Pose
from assistant.vision.recognition.edges import BESIDE, Found, Samples, edges_near
from assistant.vision.recognition.objects import Outline
from assistant.vision.recognition.photo import Photo

if TYPE_CHECKING:
    from types import ModuleType

NEAR: Final = 1.6
"""Pixels that an edge of the picture is at most from the outline that it supports."""
GRID: Final = 28
"""Places along the longer side of an outline at which its inside is looked at."""


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """Parts of the outline, 0 to 1. inside: part of the face that shows its colour; empty: part
    where there is nothing. edges: which samples are supported, with the pixels that they are at.
    """

    supported: float
    hidden: float
    contradicted: float
    inside: float
    empty: float
    edges: Found
    held: Truths


def judge(cv: ModuleType, photo: Photo, outline: Outline, samples: Samples, pose: Pose) -> Judged:
    """What a picture says to an outline at a pose of it."""
    found = edges_near(cv, photo, samples, pose, 3.0, along=True)
    held = np.isfinite(found.offs) & (np.abs(found.offs) <= NEAR)
    grid = photo.camera.project(pose.moved(inner_points(outline)))
    there = photo.is_foreground(grid)
    colours = photo.colours(grid)
    seen = there & np.isfinite(colours).all(axis=1)
    own = np.median(colours[seen], axis=0) if seen.sum() >= 5 else np.full(3, np.nan)
    spread = 1.4826 * np.median(np.linalg.norm(colours[seen] - own, axis=1)) if seen.any() else 0.0
    close = max(photo.different * 1.25, 2.0 * float(spread))
    inner, outer = (found.pixels + side * BESIDE * found.normals for side in (-1.0, 1.0))
    like_in = _like(photo, inner, own, close) & photo.is_foreground(inner)
    like_out = _like(photo, outer, own, close) & photo.is_foreground(outer)
    nothing = ~photo.is_foreground(inner) & photo.camera.within(inner)
    wrong = (~held & like_in & like_out) | nothing
    held &= like_in
    with np.errstate(invalid="ignore"):
        alike = np.linalg.norm(colours - own, axis=1) < close
    visible = photo.camera.within(grid)
    return Judged(
        float(held.mean()),
        float((~held & ~wrong).mean()),
        float(wrong.mean()),
        float((alike & there).sum() / max(len(grid), 1)),
        float((~there & visible).sum() / max(len(grid), 1)),
        found,
        held,
    )


def inner_points(outline: Outline, count: int = GRID) -> Floats:
    """(n, 3) places inside of an outline, on a grid of which none is near to its edge."""
    low, high = outline.rings[0].min(axis=0), outline.rings[0].max(axis=0)
    step = float((high - low).max()) / count
    x, y = np.meshgrid(np.arange(low[0], high[0], step), np.arange(low[1], high[1], step))
    places = np.column_stack([x.ravel(), y.ravel()]) + 0.5 * step
    inside = np.zeros(len(places), dtype=np.bool_)
    edge = np.full(len(places), np.inf)
    for ring in outline.rings:
        inside ^= within(ring, places)
        edge = np.minimum(edge, to_ring(ring, places))
    kept = places[inside & (edge > step)]
    if len(kept) < 12:
        kept = places[inside]
    return np.column_stack([kept, np.zeros(len(kept))])


def within(ring: Floats, points: Floats) -> Truths:
    """(n,) which points (n, 2) a polygon goes round, by the crossings of a line from each."""
    inside = np.zeros(len(points), dtype=np.bool_)
    for (ax, ay), (bx, by) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        if ay == by:
            continue
        spans = (ay > points[:, 1]) != (by > points[:, 1])
        inside ^= spans & (points[:, 0] < (bx - ax) * (points[:, 1] - ay) / (by - ay) + ax)
    return inside


def to_ring(ring: Floats, points: Floats) -> Floats:
    """(n,) distances of points (n, 2) to the sides of a polygon."""
    least = np.full(len(points), np.inf)
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        side = b - a
        part = np.clip((points - a) @ side / max(float(side @ side), 1e-12), 0.0, 1.0)
        away = np.linalg.norm(points - a - part[:, None] * side, axis=1)
        least = np.minimum(least, away)
    return least


def _like(photo: Photo, pixels: Floats, own: Floats, close: float) -> Truths:
    with np.errstate(invalid="ignore"):
        return np.asarray(np.linalg.norm(photo.colours(pixels) - own, axis=1) < close)

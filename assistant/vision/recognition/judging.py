"""Whether a picture agrees that an outline is where it is said to be.

Of each place on the outline one of three things holds: there is an edge (it is supported); there is
none and something else covers the place (it is hidden); or the picture contradicts: the material
goes on across the outline, or there is none at all.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.arrays import Floats, Truths
from assistant.program.geometry import Pose
from assistant.vision.recognition.edges import SIDE_DISTANCE, FoundEdges, OutlineSamples, find_edges
from assistant.vision.recognition.objects import Outline
from assistant.vision.recognition.photo import Photo

if TYPE_CHECKING:
    from types import ModuleType

SUPPORTING_DISTANCE: Final = 1.6
"""Pixels that an edge of the picture is at most from the outline that it supports."""
MOST_COLOUR_DIFFERENCE: Final = 30.0
"""Units of L*a*b* from which no two colours are of one plain thing, however mottled."""
INNER_GRID: Final = 28
"""Places along the longer side of an outline at which its inside is looked at."""


@dataclass(frozen=True, slots=True, eq=False)
class OutlineSupport:
    """Parts of the outline, 0 to 1. inside: part of the face that shows its colour; empty: part
    where there is nothing. edges: which samples are supported, with the pixels that they are at.
    """

    supported: float
    hidden: float
    contradicted: float
    inside: float
    empty: float
    edges: FoundEdges
    held: Truths


@dataclass(frozen=True, slots=True, eq=False)
class FaceAppearance:
    """What a picture shows where a face is said to be. colour: (3,) L*a*b* of most of it, NaN where
    nothing is. close: how far colours of one thing may be from it. alike, empty: parts of the face
    that have that colour, and where nothing is.
    """

    colour: Floats
    close: float
    alike: float
    empty: float


def face_appearance(photo: Photo, inner: Floats, pose: Pose) -> FaceAppearance:
    """inner: places (n, 3) inside of the outline, see `inner_points`."""
    grid = photo.camera.project(pose.moved(inner))
    there = photo.is_foreground(grid)
    colours = photo.colours(grid)[there]
    visible = photo.camera.within(grid)
    empty = float((~there & visible).mean())
    if len(colours) < 5:
        return FaceAppearance(np.full(3, np.nan), photo.different, 0.0, empty)
    own = np.median(colours, axis=0)
    away = np.linalg.norm(colours - own, axis=1)
    spread = 2.0 * 1.4826 * float(np.median(away))
    close = min(max(photo.different * 1.25, spread), MOST_COLOUR_DIFFERENCE)
    return FaceAppearance(own, close, float((away < close).sum()) / len(inner), empty)


def judge_outline(
    cv: ModuleType, photo: Photo, inner: Floats, samples: OutlineSamples, pose: Pose
) -> OutlineSupport:
    """What a picture says to an outline at a pose of it; inner: as of `face_of`."""
    found = find_edges(cv, photo, samples, pose, 3.0, along=True)
    held = np.isfinite(found.offs) & (np.abs(found.offs) <= SUPPORTING_DISTANCE)
    face = face_appearance(photo, inner, pose)
    own, close = face.colour, face.close
    inside, outside = (found.pixels + side * SIDE_DISTANCE * found.normals for side in (-1.0, 1.0))
    like_in = _shows_own_colour(photo, inside, own, close) & photo.is_foreground(inside)
    like_out = _shows_own_colour(photo, outside, own, close) & photo.is_foreground(outside)
    nothing = ~photo.is_foreground(inside) & photo.camera.within(inside)
    wrong = (~held & like_in & like_out) | nothing
    held &= like_in
    return OutlineSupport(
        supported=float(held.mean()),
        hidden=float((~held & ~wrong).mean()),
        contradicted=float(wrong.mean()),
        inside=face.alike,
        empty=face.empty,
        edges=found,
        held=held,
    )


def inner_points(outline: Outline, count: int = INNER_GRID) -> Floats:
    """(n, 3) places inside of an outline, on a grid of which none is near to its edge."""
    low, high = outline.rings[0].min(axis=0), outline.rings[0].max(axis=0)
    step = float((high - low).max()) / count
    x, y = np.meshgrid(np.arange(low[0], high[0], step), np.arange(low[1], high[1], step))
    places = np.column_stack([x.ravel(), y.ravel()]) + 0.5 * step
    inside = np.zeros(len(places), dtype=np.bool_)
    edge = np.full(len(places), np.inf)
    for ring in outline.rings:
        inside ^= points_in_ring(ring, places)
        edge = np.minimum(edge, distances_to_ring(ring, places))
    kept = places[inside & (edge > step)]
    if len(kept) < 12:
        kept = places[inside]
    return np.column_stack([kept, np.zeros(len(kept))])


def points_in_ring(ring: Floats, points: Floats) -> Truths:
    """(n,) which points (n, 2) a polygon goes round, by the crossings of a line from each."""
    inside = np.zeros(len(points), dtype=np.bool_)
    for (ax, ay), (bx, by) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        if ay == by:
            continue
        spans = (ay > points[:, 1]) != (by > points[:, 1])
        inside ^= spans & (points[:, 0] < (bx - ax) * (points[:, 1] - ay) / (by - ay) + ax)
    return inside


def distances_to_ring(ring: Floats, points: Floats) -> Floats:
    """(n,) distances of points (n, 2) to the sides of a polygon."""
    least = np.full(len(points), np.inf)
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        side = b - a
        part = np.clip((points - a) @ side / max(float(side @ side), 1e-12), 0.0, 1.0)
        away = np.linalg.norm(points - a - part[:, None] * side, axis=1)
        least = np.minimum(least, away)
    return least


def _shows_own_colour(photo: Photo, pixels: Floats, own: Floats, close: float) -> Truths:
    with np.errstate(invalid="ignore"):
        return np.asarray(np.linalg.norm(photo.colours(pixels) - own, axis=1) < close)

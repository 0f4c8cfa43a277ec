"""Edges of pictures to parts of a pixel, along lines across which they are looked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.program.geometry import Pose
from assistant.vision.recognition.estimating import PixelErrors, pixels_and_slopes
from assistant.vision.recognition.objects import Outline
from assistant.vision.recognition.photo import Photo

if TYPE_CHECKING:
    from types import ModuleType

PROFILE_STEP: Final = 0.5
"""Pixels between samples across an edge."""
LEAST_RISE: Final = 5.0
"""Grey levels a pixel that an edge rises by at least."""
LEAST_RISE_SIGMAS: Final = 5.0
"""Times the noise that it rises by as well."""
SAMPLE_SPACING: Final = 3.0
"""Pixels between samples of an outline."""
CORNER_CLEARANCE: Final = 3.0
"""Pixels from a corner within which no edge is looked for: it is round in the picture."""
SIDE_DISTANCE: Final = 3.5
"""Pixels from the outline at which it is looked what is on both sides."""
MOSTLY_BACKGROUND: Final = 0.7
MOST_EDGE_SLOPE: Final = 0.12
"""Pixels that an edge may leave the outline by a pixel along it; more is the edge of another thing
that crosses there."""


@dataclass(frozen=True, slots=True, eq=False)
class OutlineSamples:
    """Places along an outline: points (n, 3) in the object's frame, tangents and normals (n, 3)
    out of the material, ring: (n,) number of its ring.
    """

    points: Floats
    tangents: Floats
    normals: Floats
    ring: Floats

    def __len__(self) -> int:
        return len(self.points)


def sample_outline(outline: Outline, apart: float, clear: float = 0.0) -> OutlineSamples:
    """Places every `apart` mm, but for those nearer than `clear` mm to a corner.

    Corners of polygons that stand for arcs are none: they turn by less than 25 degrees.
    """
    points, tangents, rings = list[Floats](), list[Floats](), list[Floats]()
    for number, ring in enumerate(outline.rings):
        sides = np.roll(ring, -1, axis=0) - ring
        lengths = np.linalg.norm(sides, axis=1)
        ends = np.concatenate([[0.0], np.cumsum(lengths)])
        count = max(8, round(ends[-1] / apart))
        at = (np.arange(count) + 0.5) * ends[-1] / count
        side = np.clip(np.searchsorted(ends, at, side="right") - 1, 0, len(ring) - 1)
        along = sides / np.maximum(lengths, 1e-12)[:, None]
        if clear > 0.0:
            turn = (np.roll(along, 1, axis=0) * along).sum(axis=1)
            corners = ends[:-1][turn < np.cos(np.radians(25.0))]
            if len(corners):
                gap = np.abs(at[:, None] - corners[None, :])
                gap = np.minimum(gap, ends[-1] - gap).min(axis=1)
                at, side = at[gap >= clear], side[gap >= clear]
        points.append(ring[side] + along[side] * (at - ends[side])[:, None])
        tangents.append(along[side])
        rings.append(np.full(len(side), float(number)))
    flat = np.concatenate(tangents)
    none = np.zeros((len(flat), 1))
    normals = np.column_stack([flat[:, 1], -flat[:, 0], none])
    return OutlineSamples(
        np.column_stack([np.concatenate(points), none]),
        np.column_stack([flat, none]),
        normals,
        np.concatenate(rings),
    )


@dataclass(frozen=True, slots=True, eq=False)
class FoundEdges:
    """Where edges are: offs (n,) pixels out of the material from the outline, NaN where there is
    none. pixels: (n, 2) of the outline; normals: (n, 2) out of the material there; slopes: (n, 6)
    of the pixels along these normals by the pose.
    """

    offs: Floats
    pixels: Floats
    normals: Floats
    slopes: Floats


def find_edges(
    cv: ModuleType,
    photo: Photo,
    samples: OutlineSamples,
    pose: Pose,
    reach: float,
    *,
    along: bool = False,
) -> FoundEdges:
    """The edges nearest to an outline, looked for up to `reach` pixels on both sides.

    along: only those that run along the outline.
    """
    pixels, slopes = pixels_and_slopes(photo.camera, pose, samples.points)
    eps = 1e-3
    ahead = photo.camera.project(pose.moved(samples.points + eps * samples.tangents)) - pixels
    out = photo.camera.project(pose.moved(samples.points + eps * samples.normals)) - pixels
    normals = np.column_stack([ahead[:, 1], -ahead[:, 0]])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    normals *= np.where((normals * out).sum(axis=1) < 0.0, -1.0, 1.0)[:, None]
    offs = _edge_offsets(cv, photo, pixels, normals, reach)
    offs[~photo.camera.within(pixels, reach)] = np.nan
    if along:
        offs = np.where(_edge_slopes(offs, pixels) > MOST_EDGE_SLOPE, np.nan, offs)
    return FoundEdges(offs, pixels, normals, np.einsum("nk,nkj->nj", normals, slopes))


def measure_edges(
    cv: ModuleType, photo: Photo, samples: OutlineSamples, reach: float, height: float = 0.0
) -> Callable[[Pose], PixelErrors]:
    """What a picture measures of an outline; the reach shrinks as the pose is approached.

    height: mm that the part goes down from its face. Where the camera sees that side, the edge may
    be of the face or of its foot, or both in one.
    """
    left = [reach, reach, max(reach / 2.0, 2.0)]

    def rows(pose: Pose) -> PixelErrors:
        near = left.pop(0) if left else 2.0
        found = find_edges(cv, photo, samples, pose, near, along=not left)
        offs = found.offs if left else _background_edges(photo, found)
        unsure = 0.5 * np.maximum(_foot_offsets(photo, samples, pose, found, height), 0.0)
        return PixelErrors(-offs, found.slopes, along=True, unsure=unsure)

    return rows


def _foot_offsets(
    photo: Photo, samples: OutlineSamples, pose: Pose, found: FoundEdges, height: float
) -> Floats:
    """(n,) pixels that the foot of a part is seen out of the outline of its face."""
    if height == 0.0:
        return np.zeros(len(samples))
    foot = photo.camera.project(pose.moved(samples.points - np.array([0.0, 0.0, height])))
    return np.asarray(np.nan_to_num(((foot - found.pixels) * found.normals).sum(axis=1)))


def _background_edges(photo: Photo, found: FoundEdges) -> Floats:
    """Offs of edges to the background alone, where these are most: an edge to another thing may be
    that of the thing, which lies upon it.
    """
    clear = ~photo.is_foreground(found.pixels + SIDE_DISTANCE * found.normals)
    told = np.isfinite(found.offs)
    if (told & clear).sum() < MOSTLY_BACKGROUND * told.sum():
        return found.offs
    return np.where(clear, found.offs, np.nan)


def _edge_slopes(offs: Floats, pixels: Floats) -> Floats:
    """(n,) how much an edge leaves the outline a pixel, from the neighbours on both sides of each:
    the smaller change, as beyond a corner or the end of an edge there is another one.
    """
    changes = []
    for shift in (1, -1):
        gap = np.linalg.norm(np.roll(pixels, shift, axis=0) - pixels, axis=1)
        change = np.abs(np.roll(offs, shift) - offs) / np.maximum(gap, 1e-9)
        changes.append(np.where(np.isnan(change), np.inf, change))
    return np.minimum(*changes)


def _edge_offsets(
    cv: ModuleType, photo: Photo, pixels: Floats, normals: Floats, reach: float
) -> Floats:
    """The nearest of the strong rises along each normal, by a parabola through its top."""
    half = int(np.ceil(reach / PROFILE_STEP)) + 3
    t = np.arange(-half, half + 1) * PROFILE_STEP
    places = np.nan_to_num(pixels)[:, None, :] + t[None, :, None] * normals[:, None, :]
    grid = places.astype(np.float32)
    values = cv.remap(
        photo.smooth, grid[..., 0], grid[..., 1], cv.INTER_LINEAR, borderMode=cv.BORDER_REPLICATE
    )
    rise = np.linalg.norm(values[:, 4:] - values[:, :-4], axis=2) / (4 * PROFILE_STEP)
    t = t[2:-2]
    least = max(LEAST_RISE, LEAST_RISE_SIGMAS * photo.noise / (2.0 * PROFILE_STEP * 4) * 2.0)
    middle = rise[:, 1:-1]
    top = (middle >= rise[:, :-2]) & (middle > rise[:, 2:]) & (middle > least)
    top &= np.abs(t[1:-1]) <= reach
    # Of several, the one that is both strong and near.
    value = np.where(top, middle * (1.0 - np.abs(t[1:-1]) / (1.5 * reach)), 0.0)
    best = value.argmax(axis=1)
    rows = np.arange(len(best))
    a, b, c = rise[rows, best], rise[rows, best + 1], rise[rows, best + 2]
    curve = a - 2.0 * b + c
    part = np.where(curve < 0.0, 0.5 * (a - c) / np.minimum(curve, -1e-9), 0.0)
    offs = t[1:-1][best] + np.clip(part, -1.0, 1.0) * PROFILE_STEP
    return np.where(value[rows, best] > 0.0, offs, np.nan)

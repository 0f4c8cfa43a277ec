"""Edges of a picture along an outline, whether they support its pose, and its symmetry.

Edges are found to parts of a pixel along lines across the outline. For each sample of the outline
one of three things holds: an edge supports it; it is hidden, as something else covers it; or the
picture contradicts it, as the material goes on across the outline or is missing. `symmetry_of`
counts the ways in which an outline can be turned and look the same.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.arrays import Floats, Truths
from assistant.base.data_classes import dataclass
from assistant.program.geometry import Pose
from assistant.vision.recognition.known_objects import Outline
from assistant.vision.recognition.photo import Photo
from assistant.vision.recognition.pose_estimation import PixelErrors, pixels_and_slopes

if TYPE_CHECKING:
    from types import ModuleType


_PROFILE_STEP: Final = 0.5
"""Pixels between samples across an edge."""
_LEAST_RISE: Final = 5.0
"""Grey levels a pixel that an edge rises by at least."""
_LEAST_RISE_SIGMAS: Final = 5.0
"""Times the noise that it rises by as well."""
SAMPLE_SPACING: Final = 3.0
"""Pixels between samples of an outline."""
CORNER_CLEARANCE: Final = 3.0
"""Pixels from a corner within which edges are ignored: a corner is round in the picture."""
_SIDE_DISTANCE: Final = 3.5
"""Pixels from the outline at which both sides of it are examined."""
_MOSTLY_BACKGROUND: Final = 0.7
_MOST_EDGE_SLOPE: Final = 0.12
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
    """Return positions every `apart` mm, but for those nearer than `clear` mm to a corner.

    Corners of polygons that approximate arcs do not count: they turn by less than 25 degrees.
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
    """Edges found near an outline: offs (n,) pixels out of the material from the outline, NaN
    without an edge. pixels: (n, 2) of the outline; normals: (n, 2) out of the material there;
    slopes: (n, 6) of the pixels along these normals by the pose.
    """

    offs: Floats
    pixels: Floats
    normals: Floats
    slopes: Floats


def _find_edges(
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
        offs = np.where(_edge_slopes(offs, pixels) > _MOST_EDGE_SLOPE, np.nan, offs)
    return FoundEdges(offs, pixels, normals, np.einsum("nk,nkj->nj", normals, slopes))


def measure_edges(
    cv: ModuleType, photo: Photo, samples: OutlineSamples, reach: float, height: float = 0.0
) -> Callable[[Pose], PixelErrors]:
    """Return a function that measures the pixel errors of an outline at a pose; the reach shrinks
    from call to call.

    height: mm that the part extends down from its face. On a side that the camera sees, the edge
    may be of the face or of its foot, or both in one.
    """
    left = [reach, reach, max(reach / 2.0, 2.0)]

    def rows(pose: Pose) -> PixelErrors:
        near = left.pop(0) if left else 2.0
        found = _find_edges(cv, photo, samples, pose, near, along=not left)
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
    clear = ~photo.is_foreground(found.pixels + _SIDE_DISTANCE * found.normals)
    told = np.isfinite(found.offs)
    if (told & clear).sum() < _MOSTLY_BACKGROUND * told.sum():
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
    half = int(np.ceil(reach / _PROFILE_STEP)) + 3
    t = np.arange(-half, half + 1) * _PROFILE_STEP
    places = np.nan_to_num(pixels)[:, None, :] + t[None, :, None] * normals[:, None, :]
    grid = places.astype(np.float32)
    values = cv.remap(
        photo.smooth, grid[..., 0], grid[..., 1], cv.INTER_LINEAR, borderMode=cv.BORDER_REPLICATE
    )
    rise = np.linalg.norm(values[:, 4:] - values[:, :-4], axis=2) / (4 * _PROFILE_STEP)
    t = t[2:-2]
    least = max(_LEAST_RISE, _LEAST_RISE_SIGMAS * photo.noise / (2.0 * _PROFILE_STEP * 4) * 2.0)
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
    offs = t[1:-1][best] + np.clip(part, -1.0, 1.0) * _PROFILE_STEP
    return np.where(value[rows, best] > 0.0, offs, np.nan)


_SUPPORTING_DISTANCE: Final = 1.6
"""Pixels that an edge of the picture is at most from the outline that it supports."""
_MOST_COLOUR_DIFFERENCE: Final = 30.0
"""Units of L*a*b* from which no two colours are of one plain thing, however mottled."""
_INNER_GRID: Final = 28
"""Positions along the longer side of an outline at which its inside is sampled."""


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
    """Appearance of a picture at the supposed pose of a face. colour: (3,) L*a*b* of most of it,
    NaN for background. close: largest distance of colours of one thing from it. alike, empty: parts
    of the face with that colour, and with background.
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
    close = min(max(photo.different * 1.25, spread), _MOST_COLOUR_DIFFERENCE)
    return FaceAppearance(own, close, float((away < close).sum()) / len(inner), empty)


def judge_outline(
    cv: ModuleType, photo: Photo, inner: Floats, samples: OutlineSamples, pose: Pose
) -> OutlineSupport:
    """Judge an outline at a pose in a picture; inner: as in `face_appearance`."""
    found = _find_edges(cv, photo, samples, pose, 3.0, along=True)
    held = np.isfinite(found.offs) & (np.abs(found.offs) <= _SUPPORTING_DISTANCE)
    face = face_appearance(photo, inner, pose)
    own, close = face.colour, face.close
    inside, outside = (found.pixels + side * _SIDE_DISTANCE * found.normals for side in (-1.0, 1.0))
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


def inner_points(outline: Outline, count: int = _INNER_GRID) -> Floats:
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


_MOST_SYMMETRY: Final = 24
"""Turns of a full one that are tried; what looks the same by `_DISC_SYMMETRIES` of them is a
disc."""
_DISC_SYMMETRIES: Final = (11, 13)
_SAME_OFFSET: Final = 0.004
"""Part of its size by which a turned outline may be off itself."""

_NEARLY_SAME_OFFSET: Final = 0.02
"""Part of its size by which it is off itself on average, where it looks nearly the same."""


def outline_centre(outline: Outline) -> Floats:
    """(2,) the centre of area of what the first ring goes round, about which it is turned."""
    x, y = (outline.rings[0] - outline.rings[0][0]).T
    cross = x * np.roll(y, -1) - y * np.roll(x, -1)
    moment = [((one + np.roll(one, -1)) * cross).sum() for one in (x, y)]
    return np.asarray(outline.rings[0][0] + np.array(moment) / (3.0 * cross.sum()))


def symmetry_of(outline: Outline) -> int:
    """The ways, 1 for none but itself, 0 for a disc, which can be turned by any angle."""
    if all(off.max() < _SAME_OFFSET for off in _turned_offsets(outline, _DISC_SYMMETRIES)):
        return 0
    ways = range(_MOST_SYMMETRY, 1, -1)
    alike = (
        k
        for k, off in zip(ways, _turned_offsets(outline, ways), strict=True)
        if off.max() < _SAME_OFFSET
    )
    return next(alike, 1)


def near_symmetry_of(outline: Outline) -> int:
    """In how many ways it looks nearly the same, but for something small; 1 for none."""
    ways = range(2, _MOST_SYMMETRY + 1)
    means = [float(off.mean()) for off in _turned_offsets(outline, ways)]
    least = min(means)
    if least > _NEARLY_SAME_OFFSET:
        return 1
    return max(
        k for k, off in zip(ways, means, strict=True) if off <= 1.5 * least + _SAME_OFFSET / 2.0
    )


def _turned_offsets(outline: Outline, ways: Iterable[int]) -> Iterator[Floats]:
    """Yield distances (n,) of points on a turned outline from the outline itself, in parts of its
    size.
    """
    middle, size = outline_centre(outline), outline.diameter
    points = sample_outline(outline, size / 90.0).points[:, :2] - middle
    rings = [ring - middle for ring in outline.rings]
    for number in ways:
        turn = 2.0 * np.pi / number
        c, s = np.cos(turn), np.sin(turn)
        turned = points @ np.array([[c, s], [-s, c]])
        yield np.min([distances_to_ring(ring, turned) for ring in rings], axis=0) / size

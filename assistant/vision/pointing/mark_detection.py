"""Detect the marks of a pointing device in one picture: coloured balls, and lights.

The outline of a ball is found to parts of a pixel along lines from the middle of its coloured
region: where the colour is half way between inside and outside, both sampled nearby, so the light
may differ around the ball.

The outline of a sphere is nearly an ellipse whose middle is not the projected centre: it lies
farther from the middle of the picture, by up to half a pixel for a ball of 40 mm at 1 m. The rays
of the outline form a round cone about the ray of the centre, whatever the lens does. For a ray u of
it and the direction d of the centre, u · d = cos α, where sin α = radius / distance: with
n = d / cos α that is linear, u · n = 1.

A light is a spot that is brighter than its surroundings.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths
from assistant.base.data_classes import dataclass
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.synthetic_pictures import Picture
from assistant.vision.opencv import opencv
from assistant.vision.pointing.devices import Ball, HueRange, Light


@dataclass(frozen=True, slots=True)
class MarkSpot:
    """place: pixel (u, v) at which the mark's middle is projected. radius: pixels.

    angle: radians between its middle and its outline, None of a light. confidence: 0 to 1; of a
    ball the part of its outline that is seen where it should be, of a light how much brighter than
    all else it is. at_edge: it reaches the edge of the picture.
    """

    place: tuple[float, float]
    radius: float
    angle: float | None
    confidence: float
    at_edge: bool = False


_CONE_ROUNDS: Final = 6
"""Rounds that leave out rays which are not on the cone."""
_FEWEST_RAYS: Final = 8
"""Fewest rays of an outline that determine a cone."""
_CONE_SAMPLES: Final = 120
"""Cones through three rays each that are tried."""


@dataclass(frozen=True, slots=True, eq=False)
class Cone:
    """direction: (3,) unit vector to the centre. angle: α in radians.

    on: (n,) which rays lie on it. scatter: radians, root mean square of those.
    """

    direction: Floats
    angle: float
    on: Truths
    scatter: float


def _fit_cone(rays: Floats, off: float) -> Cone | None:
    """The cone that most of some unit rays (n, 3) lie on, or None where they tell none.

    off: radians that a ray of it may be off. Where half of a ball is hidden, the others are those
    of what hides it: of cones through three rays each the one is taken that most others lie on
    (Fischler and Bolles, 1981; Torr and Zisserman, MLESAC, 2000, for how they are counted), and
    then made exact by all that do.
    """
    good = np.flatnonzero(np.isfinite(rays).all(axis=1))
    if len(good) < _FEWEST_RAYS:
        return None
    normal = _best_sampled_cone(rays[good], off)
    on = np.zeros(len(rays), dtype=bool)
    away: Floats = np.full(len(rays), np.nan)
    for _ in range(_CONE_ROUNDS):
        if not np.linalg.norm(normal) > 1.0:
            return None
        away = _angles_outside(rays, normal[None])[0]
        before, on = on, np.abs(away) <= off
        if on.sum() < _FEWEST_RAYS:
            return None
        if (on == before).all():
            break
        normal = np.asarray(np.linalg.lstsq(rays[on], np.ones(on.sum()), rcond=None)[0], float)
    length = float(np.linalg.norm(normal))
    scatter = float(np.sqrt(np.mean(away[on] ** 2)))
    return Cone(normal / length, float(np.arccos(1.0 / length)), np.asarray(on), scatter)


def _angles_outside(rays: Floats, normals: Floats) -> Floats:
    """(k, n) radians by which rays (n, 3) are outside of cones (k, 3)."""
    lengths = np.linalg.norm(normals, axis=1)[:, None]
    cosines = np.clip(normals @ rays.T / lengths, -1.0, 1.0)
    return np.asarray(np.arccos(cosines) - np.arccos(1.0 / lengths))


def _best_sampled_cone(rays: Floats, off: float) -> Floats:
    """The cone through three of some rays (n, 3) that the others are nearest to."""
    chosen = (
        np.random.default_rng(0).random((_CONE_SAMPLES, len(rays))).argpartition(2, axis=1)[:, :3]
    )
    three = rays[chosen]
    with np.errstate(divide="ignore", invalid="ignore"):
        sound = np.abs(np.linalg.det(three)) > 1e-12
        normals = np.zeros((_CONE_SAMPLES, 3))
        normals[sound] = np.linalg.solve(three[sound], np.ones((sound.sum(), 3, 1)))[..., 0]
        sound &= np.linalg.norm(normals, axis=1) > 1.0
    if not sound.any():
        return np.zeros(3)
    missed = np.minimum(_angles_outside(rays, normals[sound]) ** 2, off**2).sum(axis=1)
    return np.asarray(normals[sound][np.argmin(missed)])


_LEAST_BALL_AREA: Final = 12
"""Pixels of a ball's colour; what is smaller is noise."""
_MOST_BALLS: Final = 6
"""Largest number of balls of one colour that are examined, the largest first."""
_OUTLINE_LINES: Final = 90
"""From the middle of a ball across its outline."""
_OUTLINE_STEP: Final = 0.25
"""Pixels along such a line."""
_PLATEAU: Final = 1.5
"""Pixels at both ends of a line that tell the colour inside and outside."""
_SHADING_NEAR: Final = 2.0
_SHADING_FAR: Final = 4.0
"""Pixels inside of an outline between which it is looked how the light changes."""
_OUTLINE_BLUR: Final = 1.0
"""Pixels, sigma, of an outline as lenses and smoothing make it."""
_LEAST_CONTRAST: Final = 18.0
"""Grey levels that colours inside and outside differ by at least."""
_HUE_SMOOTHING: Final = 0.6
"""Pixels by which noise is smoothed before; the same on both sides of an outline."""
_OUTLINE_TOLERANCE: Final = 0.5
"""Pixels that a part of the outline may be off."""
_LEAST_CONFIDENCE: Final = 0.45
"""Part of the outline; of less a ball is not told from something else of its colour."""


def _hues_of(picture: Picture) -> Any:
    """(h, w, 3) hue, saturation and value, smoothed a little; once for all balls of a picture."""
    cv2 = opencv()
    return cv2.cvtColor(cv2.GaussianBlur(picture, (3, 3), 0), cv2.COLOR_BGR2HSV)


def _find_balls(picture: Picture, hues: Any, camera: Camera, ball: Ball) -> tuple[MarkSpot, ...]:
    """Find spots in a picture that may be the ball, the surest first."""
    cv2 = opencv()
    mask = _colour_mask(cv2, hues, ball.colour)
    count, _, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    areas = stats[1:, cv2.CC_STAT_AREA]
    largest = np.argsort(-areas, kind="stable")[:_MOST_BALLS] + 1
    found = []
    for i in largest[: count - 1]:
        if stats[i, cv2.CC_STAT_AREA] < _LEAST_BALL_AREA:
            break
        x, y, w, h = (int(v) for v in stats[i, :4])
        # Half of a ball may be in the shade, or behind a stick: its box tells more than its area.
        radius = max(max(w, h) / 2.0, float(np.sqrt(stats[i, cv2.CC_STAT_AREA] / np.pi)))
        centre = (x + (w - 1) / 2.0, y + (h - 1) / 2.0)
        patch = _patch_around(cv2, picture, ball.colour, centre, radius)
        spot = _measure_ball(cv2, patch, camera, centre, radius)
        if spot is not None:
            found.append(spot)
    return tuple(sorted(found, key=lambda spot: -spot.confidence))


def _colour_mask(cv2: Any, hues: Any, colour: HueRange) -> Any:
    """Which pixels (h, w) are of a colour, without single ones."""
    low, high = colour.hue - colour.width, colour.hue + colour.width
    least, most = (255.0 * colour.saturation, 255.0 * colour.value), (255.0, 255.0)
    mask = None
    for turn in (-360.0, 0.0, 360.0):
        a, b = max(low + turn, 0.0) / 2.0, min(high + turn, 360.0) / 2.0
        if a < b:
            part = cv2.inRange(hues, (a, *least), (b, *most))
            mask = part if mask is None else cv2.bitwise_or(mask, part)
    return cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((2, 2), np.uint8))


@dataclass(frozen=True, slots=True, eq=False)
class _Patch:
    """A part of a picture as grey levels along a colour: 0 for all greys, and a mixture of colours
    has that of their levels. origin: its upper left pixel.
    """

    levels: Any
    origin: tuple[int, int]


def _patch_around(
    cv2: Any, picture: Picture, colour: HueRange, centre: tuple[float, float], radius: float
) -> _Patch:
    height, width = picture.shape[:2]
    half = 1.5 * radius + 12.0
    u0, v0 = (max(int(c - half), 0) for c in centre)
    u1, v1 = (min(int(c + half) + 1, most) for c, most in zip(centre, (width, height), strict=True))
    third, hue = np.radians(120.0), np.radians(colour.hue)
    weights = np.array([[np.cos(hue + third), np.cos(hue - third), np.cos(hue)]]) * 2.0 / 3.0
    soft = cv2.GaussianBlur(picture[v0:v1, u0:u1], (0, 0), _HUE_SMOOTHING).astype(np.float32)
    return _Patch(cv2.transform(soft, weights.astype(np.float32)), (u0, v0))


def _measure_ball(
    cv2: Any, patch: _Patch, camera: Camera, centre: tuple[float, float], radius: float
) -> MarkSpot | None:
    """The ball about a place, measured twice: the second time from where the first found it."""
    spot = None
    for _ in range(2):
        edge = _ball_outline(cv2, patch, centre, radius)
        scale = float(np.mean(camera.lens.focal))
        cone = _fit_cone(camera.directions(edge), _OUTLINE_TOLERANCE / scale)
        spot = None if cone is None else _spot_of_cone(camera, cone, edge)
        if spot is None:
            return None
        centre, radius = spot.place, spot.radius
    return spot if spot is not None and spot.confidence >= _LEAST_CONFIDENCE else None


def _ball_outline(cv2: Any, patch: _Patch, centre: tuple[float, float], radius: float) -> Floats:
    """(LINES, 2) pixels of the outline, NaN on lines that cross none."""
    reach = min(4.0 + 0.15 * radius, max(0.7 * radius, 2.5))
    r = np.arange(max(radius - reach, 0.0), radius + reach + _OUTLINE_STEP, _OUTLINE_STEP)
    angles = np.arange(_OUTLINE_LINES) * (2.0 * np.pi / _OUTLINE_LINES)
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    at = np.array(centre) + ways[:, None, :] * r[None, :, None]
    u, v = ((at[..., k] - patch.origin[k]).astype(np.float32) for k in (0, 1))
    values = cv2.remap(
        patch.levels, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=-1e4
    ).astype(np.float64)
    values[values < -1e3] = np.nan
    ends = int(_PLATEAU / _OUTLINE_STEP)
    with np.errstate(invalid="ignore"):
        inside, outside = values[:, :ends].mean(axis=1), values[:, -ends:].mean(axis=1)
        half = (inside + outside) / 2.0
        first = np.argmax(values < half[:, None], axis=1)
        half += _shading_offsets(values, first, inside, reach)
        below = values < half[:, None]
        first = np.argmax(below, axis=1)
        good = below.any(axis=1) & (first > 0) & (inside - outside > _LEAST_CONTRAST)
    rows, k = np.flatnonzero(good), first[good]
    before, after = values[rows, k - 1], values[rows, k]
    part = (before - half[rows]) / (before - after)
    edge = np.full((_OUTLINE_LINES, 2), np.nan)
    edge[rows] = np.array(centre) + ways[rows] * (r[k - 1] + part * _OUTLINE_STEP)[:, None]
    return edge


def _shading_offsets(values: Floats, first: Any, inside: Floats, reach: float) -> Floats:
    """(LINES,) what the level of the outline is higher where light changes across the ball.

    The level inside goes on as it does from `_SHADING_FAR` to `_SHADING_NEAR` pixels before the
    outline; a slope s of it, and a blur of sigma b, put the half level off by s b / √(2 π).
    """
    if reach < _SHADING_FAR:
        return np.zeros(len(values))
    rows = np.arange(len(values))
    near, far = (
        np.clip(first - int(d / _OUTLINE_STEP), 0, None) for d in (_SHADING_NEAR, _SHADING_FAR)
    )
    slope = (values[rows, near] - values[rows, far]) / (_SHADING_FAR - _SHADING_NEAR)
    level = values[rows, near] + slope * _SHADING_NEAR
    return np.asarray((level - inside) / 2.0 - slope * _OUTLINE_BLUR / np.sqrt(2.0 * np.pi))


def _spot_of_cone(camera: Camera, cone: Cone, edge: Floats) -> MarkSpot | None:
    """The place of a cone in the picture."""
    back = rotations.conjugate(np.array(camera.pose.quaternion))
    direction = rotations.rotate(back, cone.direction)
    if not direction[2] > 0.0:
        return None
    place = camera.lens.pixels((direction[:2] / direction[2])[None])[0]
    if not np.isfinite(place).all():
        return None
    radius = float(np.median(np.linalg.norm(edge[cone.on] - place, axis=1)))
    width, height = camera.lens.size
    most = (width - 1, height - 1)
    at_edge = bool((place < radius + 1.0).any() or (place > np.array(most) - radius - 1.0).any())
    confidence = float(np.count_nonzero(cone.on)) / _OUTLINE_LINES
    return MarkSpot((float(place[0]), float(place[1])), radius, cone.angle, confidence, at_edge)


_LIGHT_SMOOTHING: Final = 1.0
"""Pixels, sigma, of the smoothing before the search for bright spots."""
_LEAST_BRIGHTNESS: Final = 60.0
"""Grey levels above what is around it."""
_SURROUNDINGS_WIDTH: Final = 31
"""Pixels across which the usual brightness of a place is taken, by its median."""
_MOST_LIGHTS: Final = 6
_WEIGHED_RADII: Final = 2.0
"""Times its radius around a spot in which its brightness is weighed, and 3 pixels more."""
_LEAST_FILL: Final = 0.55
"""Part of its box that a round spot fills at least; a disc fills 0.79."""


def _find_lights(picture: Picture) -> tuple[MarkSpot, ...]:
    """Find spots in a picture that may be the light, the surest first.

    Its largest size is in mm, which can only be compared with a known distance: see
    `device_tracking`.
    """
    cv2 = opencv()
    bright = picture.max(axis=2).astype(np.float32)
    soft = cv2.GaussianBlur(bright, (0, 0), _LIGHT_SMOOTHING)
    small = cv2.resize(soft, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    usual = cv2.medianBlur(np.round(small).astype(np.uint8), _SURROUNDINGS_WIDTH // 2 | 1)
    height, width = bright.shape
    ground = cv2.resize(usual, (width, height), interpolation=cv2.INTER_LINEAR).astype(np.float32)
    above = soft - ground
    peak = float(above.max())
    if peak < _LEAST_BRIGHTNESS:
        return ()
    mask = (above > peak / 2.0).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    found = []
    for i in np.argsort(-stats[1:, cv2.CC_STAT_AREA], kind="stable")[:_MOST_LIGHTS] + 1:
        spot = _measure_light(bright, labels, int(i), stats[i], above)
        if spot is not None:
            found.append(spot)
    return tuple(sorted(found, key=lambda spot: -spot.confidence))


def _measure_light(
    bright: Any, labels: Any, number: int, stats: Any, above: Any
) -> MarkSpot | None:
    """The middle of a spot, weighed by what it is brighter than the ring around it."""
    x, y, w, h, area = (int(v) for v in stats[:5])
    fill = area / (w * h)
    if fill < _LEAST_FILL or max(w, h) > 3 * min(w, h):
        return None
    radius = float(np.sqrt(area / np.pi))
    reach = _WEIGHED_RADII * radius + 3.0
    place: Floats = np.array([x + (w - 1) / 2.0, y + (h - 1) / 2.0])
    height, width = bright.shape
    for _ in range(3):
        low = np.maximum(np.floor(place - reach), 0).astype(int)
        high = np.minimum(np.ceil(place + reach), (width - 1, height - 1)).astype(int)
        part = bright[low[1] : high[1] + 1, low[0] : high[0] + 1].astype(np.float64)
        u, v = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1))
        away = np.hypot(u - place[0], v - place[1])
        ring = (away > reach - 1.5) & (away <= reach + 0.5)
        if not ring.any():
            return None
        weight = np.where(away <= reach, np.maximum(part - np.median(part[ring]), 0.0), 0.0)
        weight[weight < 0.04 * weight.max()] = 0.0
        total = weight.sum()
        if not total > 0.0:
            return None
        place = np.array([(weight * u).sum(), (weight * v).sum()]) / total
    own = above[labels == number]
    confidence = min(1.0, float(own.max()) / (2.0 * _LEAST_BRIGHTNESS)) * min(1.0, fill / 0.7)
    least, most = place - (reach - 0.5), place + (reach - 0.5)
    at_edge = bool((least < 0.0).any() or (most > (width - 1, height - 1)).any())
    return MarkSpot((float(place[0]), float(place[1])), radius, None, confidence, at_edge)


def find_spots(
    picture: Picture, camera: Camera, marks: Sequence[Ball | Light]
) -> list[tuple[MarkSpot, ...]]:
    """Find spots in a picture for each of the marks, the surest first.

    Raises Refused without OpenCV.
    """
    hues = None
    found = []
    for mark in marks:
        if isinstance(mark, Light):
            found.append(_find_lights(picture))
            continue
        hues = _hues_of(picture) if hues is None else hues
        found.append(_find_balls(picture, hues, camera, mark))
    return found

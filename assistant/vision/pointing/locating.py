"""A device in pictures of one moment: where it is, or why that cannot be told.

What looks like a mark in one picture is joined with what looks like it in the others. Only what the
cameras see at one place, as large as the mark is and before them, is the mark; and if that holds of
two places, none of them is.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import WORLD, Camera
from assistant.vision.cameras.drawing import Picture
from assistant.vision.cameras.triangulating import triangulate
from assistant.vision.pointing import rules
from assistant.vision.pointing.devices import Ball, Device, Light
from assistant.vision.pointing.finding import find_spots
from assistant.vision.pointing.pictures import brightness_finding, size_finding
from assistant.vision.pointing.spots import MarkSpot
from assistant.vision.pointing.wand_pose import fit_device_poses

RADIUS_TOLERANCE: Final = 0.05
"""Part of its radius that a ball may be seen larger or smaller, beside parts of a pixel."""
RADIUS_PIXELS: Final = 0.75
"""Pixels of the outline."""
MOST_COMBINATIONS: Final = 2000
"""Ways to join spots of several marks that are looked at."""


@dataclass(frozen=True, slots=True)
class Limits:
    """noise: pixels, one sigma, of a place in a picture; covariances are for it. residual: pixels,
    root mean square, that pictures may disagree by.
    """

    noise: float = 0.2
    residual: float = 0.5


USUAL_LIMITS: Final = Limits()


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """pose: of the device in the world. pixels: (c, b, 2) of its marks in each camera, NaN where
    one does not see a mark. covariance: (6, 6) of the position in mm and of the turn about the axes
    of the world in radians, 0 for turns that its marks do not tell. residual: pixels, root mean
    square. confidence: 0 to 1, of the mark that is seen worst.
    """

    pose: Pose
    pixels: Floats
    covariance: Floats
    residual: float
    confidence: float = 1.0


Seen = Sighting | Diagnostic
"""Where it is, or why nobody knows."""


def check_cameras(cameras: Sequence[Camera]) -> None:
    """Raises Refused for cameras that cannot tell a place."""
    if len(cameras) < 2:
        raise Refused(rules.ONE_CAMERA(count=len(cameras)), exit_status=2)
    for camera in cameras:
        if camera.parent != WORLD:
            finding = rules.CARRIED_CAMERA(camera=camera.name, parent=camera.parent)
            raise Refused(finding, exit_status=2)


def locate_device(
    device: Device,
    cameras: Sequence[Camera],
    pictures: Sequence[Picture],
    limits: Limits = USUAL_LIMITS,
) -> Seen:
    """The device in pictures of the cameras, in their order, that were taken at one moment."""
    sizes = (size_finding(c, p) for c, p in zip(cameras, pictures, strict=True))
    if (wrong := next((finding for finding in sizes if finding), None)) is not None:
        return wrong
    seen = [find_spots(p, c, device.marks) for c, p in zip(cameras, pictures, strict=True)]
    found: list[_MarkPositions] = []
    for b, name in enumerate(device.mark_names):
        of_mark = [each[b] for each in seen]
        places = _mark_positions(device.marks[b], name, cameras, pictures, of_mark, limits)
        if isinstance(places, Diagnostic):
            return places
        found.append(places)
    if len(found) == 1:
        return _locate_single_mark(device, cameras, found[0], limits)
    return _join_marks(device, cameras, found, limits)


def locate_at_pixels(
    device: Device, cameras: Sequence[Camera], pixels: Floats, limits: Limits = USUAL_LIMITS
) -> Seen:
    """The device whose marks are seen at pixels (c, b, 2): of one moment, or means of several."""
    posed = fit_device_poses(cameras, pixels[:, None], device.positions, limits.noise)
    residual = float(posed.residuals[0])
    if not np.isfinite(residual):
        return rules.MARK_WITHOUT_DEPTH(mark=device.name)
    if residual > limits.residual:
        if len(device.marks) > 1:
            return rules.OTHER_MARK_DISTANCES(
                device=device.name, residual=residual, most=limits.residual
            )
        return rules.MARK_DISAGREES(
            mark=device.mark_names[0], residual=residual, most=limits.residual
        )
    turn = posed.quaternions[0]
    if device.turns_shown == 0:
        turn = np.array(device.orientation)
    pose = Pose.of(posed.positions[0], turn)
    return Sighting(pose, pixels, posed.covariances[0], residual)


@dataclass(frozen=True, slots=True, eq=False)
class _MarkPositions:
    """Where a mark may be: points (n, 3), pixels (c, n, 2), confidences (n,)."""

    name: str
    points: Floats
    pixels: Floats
    confidences: Floats


def _mark_positions(
    mark: Ball | Light,
    name: str,
    cameras: Sequence[Camera],
    pictures: Sequence[Picture],
    seen: Sequence[tuple[MarkSpot, ...]],
    limits: Limits,
) -> _MarkPositions | Diagnostic:
    """Places at which two cameras or more see a mark, as large as it is."""
    blind = [i for i, found in enumerate(seen) if not found]
    if len(cameras) - len(blind) < 2:
        camera, picture = cameras[blind[0]], pictures[blind[0]]
        dazzled = brightness_finding(camera, picture, dark=isinstance(mark, Ball))
        return dazzled or rules.MARK_NOT_SEEN(camera=camera.name, mark=name)
    ways = list(itertools.product(*(found or (None,) for found in seen)))[:MOST_COMBINATIONS]
    pixels = np.array(
        [[(np.nan, np.nan) if s is None else s.place for s in way] for way in ways]
    ).swapaxes(0, 1)
    told = triangulate(cameras, list(pixels), limits.noise)
    if not np.isfinite(told.points).all(axis=1).any():
        return rules.MARK_WITHOUT_DEPTH(mark=name)
    good = np.flatnonzero(told.residuals <= limits.residual)
    if not len(good):
        residual = float(np.nanmin(told.residuals))
        return rules.MARK_DISAGREES(mark=name, residual=residual, most=limits.residual)
    sizes = np.array([_apparent_radii(ways[i], told.points[i], cameras) for i in good])
    fits = np.array(
        [_radius_fits(ways[i], size, mark) for i, size in zip(good, sizes, strict=True)]
    )
    if not fits.any():
        stated = mark.radius if isinstance(mark, Ball) else mark.largest / 2.0
        off = np.abs(np.log(sizes / stated)).max(axis=1)
        worst = sizes[np.argmin(off)]
        seen_as = float(worst[np.argmax(np.abs(np.log(worst / stated)))])
        return rules.OTHER_BALL_RADIUS(mark=name, seen=seen_as, stated=stated)
    good = good[fits]
    inside = np.array([not any(s is not None and s.at_edge for s in ways[i]) for i in good])
    if not inside.any():
        edges = (c for c, s in zip(cameras, ways[good[0]], strict=True) if s and s.at_edge)
        return rules.MARK_AT_EDGE(mark=name, camera=next(edges).name)
    good = good[inside]
    sure = np.array([min(s.confidence for s in ways[i] if s is not None) for i in good])
    apart = mark.radius if isinstance(mark, Ball) else mark.largest
    kept = _distinct_positions(told.points[good], sure, apart)
    return _MarkPositions(name, told.points[good][kept], pixels[:, good][:, kept], sure[kept])


def _apparent_radii(
    way: Sequence[MarkSpot | None], point: Floats, cameras: Sequence[Camera]
) -> Floats:
    """(c,) mm of the mark as each camera sees it; that of the others where one does not."""
    found = []
    for camera, spot in zip(cameras, way, strict=True):
        if spot is None:
            continue
        distance = float(np.linalg.norm(point - np.array(camera.pose.position)))
        if spot.angle is not None:
            found.append(distance * np.sin(spot.angle))
        else:
            found.append(distance * spot.radius / float(np.mean(camera.lens.focal)))
    return np.array([*found, *found[:1] * (len(cameras) - len(found))])


def _radius_fits(way: Sequence[MarkSpot | None], seen: Floats, mark: Ball | Light) -> bool:
    if isinstance(mark, Light):
        return bool((seen <= mark.largest / 2.0).all())
    pixels = min(spot.radius for spot in way if spot is not None)
    off = np.abs(seen - mark.radius) / mark.radius
    return bool((off <= RADIUS_TOLERANCE + RADIUS_PIXELS / max(pixels, 1.0)).all())


def _distinct_positions(points: Floats, sure: Floats, apart: float) -> Rows:
    """Of places that are the same one, the surest; the surest first."""
    kept: list[int] = []
    for i in np.argsort(-sure, kind="stable"):
        if all(np.linalg.norm(points[i] - points[k]) > apart for k in kept):
            kept.append(int(i))
    return np.array(kept, dtype=np.intp)


def _locate_single_mark(
    device: Device, cameras: Sequence[Camera], places: _MarkPositions, limits: Limits
) -> Seen:
    if len(places.points) > 1:
        return _two_devices(places.name, places.points)
    seen = locate_at_pixels(device, cameras, places.pixels[:, :1], limits)
    return _with_confidence(seen, float(places.confidences[0]))


def _two_devices(name: str, points: Floats) -> Diagnostic:
    distance = float(np.linalg.norm(points[0] - points[1]))
    return rules.TWO_DEVICES(count=len(points), mark=name, distance=distance)


def _with_confidence(seen: Seen, confidence: float) -> Seen:
    if isinstance(seen, Diagnostic):
        return seen
    return Sighting(seen.pose, seen.pixels, seen.covariance, seen.residual, confidence)


def _join_marks(
    device: Device, cameras: Sequence[Camera], found: Sequence[_MarkPositions], limits: Limits
) -> Seen:
    """The marks that lie to each other as those of the device do."""
    counts = [range(len(places.points)) for places in found]
    ways = np.array(list(itertools.islice(itertools.product(*counts), MOST_COMBINATIONS)))
    pixels = np.stack([places.pixels[:, ways[:, b]] for b, places in enumerate(found)], axis=2)
    posed = fit_device_poses(cameras, pixels, device.positions, limits.noise)
    residuals = np.where(np.isfinite(posed.residuals), posed.residuals, np.inf)
    best = int(np.argmin(residuals))
    good = np.flatnonzero(residuals <= limits.residual)
    if len(good) > 1:
        kept = _distinct_positions(
            posed.positions[good], -residuals[good], _least_device_distance(device)
        )
        if len(kept) > 1:
            return _two_devices(device.name, posed.positions[good][kept])
    seen = locate_at_pixels(device, cameras, pixels[:, best], limits)
    sure = min(float(p.confidences[i]) for p, i in zip(found, ways[best], strict=True))
    return _with_confidence(seen, sure)


def _least_device_distance(device: Device) -> float:
    """From how many mm on two places are two devices."""
    return max(m.radius if isinstance(m, Ball) else m.largest for m in device.marks)

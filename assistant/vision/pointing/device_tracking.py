"""Locate a pointing device in pictures of several cameras, and track it from moment to moment.

Candidates for a mark in one picture are joined with those in the others. Only a position that the
cameras agree on, of the size of the mark and in front of them, is the mark; if two positions fit,
neither is. A device with several marks gets its pose by least squares over all pictures. A sighting
farther from the last one than a hand moves is rejected.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from itertools import combinations
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Pose
from assistant.vision import rules
from assistant.vision.cameras.camera import LEAST_DEPTH, WORLD, Camera, triangulate
from assistant.vision.cameras.camera_file import Rig
from assistant.vision.cameras.capture import Frame, open_frames, pairing_finding, picture_names
from assistant.vision.cameras.synthetic_pictures import Picture
from assistant.vision.pointing.devices import Ball, Device, Light
from assistant.vision.pointing.mark_detection import MarkSpot, find_spots

_POSE_ROUNDS: Final = 12
_CONVERGED_STEP: Final = 1e-7
"""mm and radians of a step at which the search ends."""
_UNDETERMINED_SHARE: Final = 1e-7
"""Part of the strongest direction below which the pixels do not tell a direction."""
_ALONG_X_COSINE: Final = np.cos(np.radians(20.0))


@dataclass(frozen=True, slots=True, eq=False)
class DevicePoses:
    """n poses of a device: positions (n, 3) mm, quaternions (n, 4), NaN where they are not told.

    covariances: (n, 6, 6) of the position in mm and of the turn about the axes of the world in
    radians, for the noise that was given; 0 for a turn that the marks do not tell. residuals: (n,)
    pixels, root mean square over u and v of all marks and cameras.
    """

    positions: Floats
    quaternions: Floats
    covariances: Floats
    residuals: Floats


def fit_device_poses(
    cameras: Sequence[Camera], pixels: Floats, marks: Floats, noise: float = 0.2
) -> DevicePoses:
    """pixels: (c, n, b, 2) of b marks in n moments, NaN where one is not seen; marks: (b, 3) mm.

    Every mark must be seen by two cameras. The begin is the rigid motion onto the triangulated
    marks (Kabsch 1976, by singular values), then Gauss and Newton on the pixels.
    """
    count, b = pixels.shape[1], len(marks)
    flat = [one.reshape(-1, 2) for one in pixels]
    located = triangulate(cameras, flat, noise).points.reshape(count, b, 3)
    good = np.isfinite(located).all(axis=(1, 2))
    positions = np.full((count, 3), np.nan)
    quaternions = np.full((count, 4), np.nan)
    covariances = np.full((count, 6, 6), np.nan)
    residuals = np.full(count, np.nan)
    if good.any():
        p, turn = _rigid_motions(located[good], marks)
        p, turn, normal, squares, there = _refine_poses(cameras, pixels[:, good], marks, p, turn)
        if b > 1 and _in_line(marks):
            turn = _without_free_turn(turn, marks)
        positions[good], quaternions[good] = p, rotations.from_matrix(turn)
        covariances[good] = noise**2 * np.linalg.pinv(
            normal, rcond=_UNDETERMINED_SHARE, hermitian=True
        )
        residuals[good] = np.sqrt(squares / np.maximum(2 * there, 1))
    return DevicePoses(positions, quaternions, covariances, residuals)


def _in_line(marks: Floats) -> bool:
    return bool(np.linalg.matrix_rank(marks - marks.mean(axis=0), tol=1.0) < 2)


def _rigid_motions(points: Floats, marks: Floats) -> tuple[Floats, Floats]:
    """Positions (n, 3) and rotations (n, 3, 3) that bring marks (b, 3) nearest to (n, b, 3)."""
    middle, centre = points.mean(axis=1), marks.mean(axis=0)
    u, _, vt = np.linalg.svd(np.einsum("nbi,bj->nij", points - middle[:, None], marks - centre))
    flip = np.tile(np.eye(3), (len(points), 1, 1))
    flip[:, 2, 2] = np.linalg.det(u @ vt)
    turn = u @ flip @ vt
    return middle - np.einsum("nij,j->ni", turn, centre), turn


def _refine_poses(
    cameras: Sequence[Camera], pixels: Floats, marks: Floats, p: Floats, turn: Floats
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """The poses, the normal matrices (n, 6, 6), the squares in pixels (n,) and marks seen (n,)."""
    n, b = len(p), len(marks)
    there = np.asarray(np.isfinite(pixels).all(axis=3))
    normal, squares = np.zeros((n, 6, 6)), np.zeros(n)
    for _ in range(_POSE_ROUNDS):
        arms = np.einsum("nij,bj->nbi", turn, marks)
        points = (p[:, None] + arms).reshape(-1, 3)
        normal, vector, squares = np.zeros((n, 6, 6)), np.zeros((n, 6)), np.zeros(n)
        for i, camera in enumerate(cameras):
            seen = pixels[i]
            known = there[i] & _in_front(camera, points).reshape(n, b)
            off = np.where(known[..., None], camera.project(points).reshape(n, b, 2) - seen, 0.0)
            by_point = camera.slopes(points).reshape(n, b, 2, 3)
            by_turn = -np.einsum("nbki,nbij->nbkj", by_point, _cross_matrices(arms))
            slope = np.concatenate([by_point, by_turn], axis=3)
            slope = np.where(known[..., None, None], slope, 0.0)
            normal += np.einsum("nbki,nbkj->nij", slope, slope)
            vector += np.einsum("nbki,nbk->ni", slope, off)
            squares += (off**2).sum(axis=(1, 2))
        back = np.linalg.pinv(normal, rcond=_UNDETERMINED_SHARE, hermitian=True)
        step = -np.einsum("nij,nj->ni", back, vector)
        p = p + step[:, :3]
        turn = _rotate_by(turn, step[:, 3:])
        if not (np.abs(step) > _CONVERGED_STEP).any():
            break
    return p, turn, normal, squares, there.sum(axis=(0, 2)).astype(np.float64)


def _in_front(camera: Camera, points: Floats) -> Truths:
    return np.asarray(camera.seen_by(points)[:, 2] > LEAST_DEPTH)


def _cross_matrices(arms: Floats) -> Floats:
    """(..., 3, 3) matrices of the cross product with vectors (..., 3)."""
    x, y, z = np.moveaxis(arms, -1, 0)
    none = np.zeros_like(x)
    rows = np.array([[none, -z, y], [z, none, -x], [-y, x, none]])
    return np.moveaxis(rows, (0, 1), (-2, -1))


def _rotate_by(turn: Floats, by: Floats) -> Floats:
    """Rotations (n, 3, 3) turned about axes of the world by vectors (n, 3) in radians."""
    angle = np.linalg.norm(by, axis=1)
    axis = by / np.maximum(angle, 1e-300)[:, None]
    return np.asarray(rotations.to_matrix(rotations.about(axis, np.degrees(angle))) @ turn)


def _without_free_turn(turn: Floats, marks: Floats) -> Floats:
    """Turned about the line of the marks, so that x follows the rule of `Device`.

    The line is the z of the device, or its frame is left as the fit gave it.
    """
    away = marks - marks.mean(axis=0)
    if np.abs(away[:, :2]).max() > 1e-6:
        return turn
    z = turn[:, :, 2]
    wished = np.where(np.abs(z[:, :1]) > _ALONG_X_COSINE, (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    y = np.cross(z, wished)
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    return np.stack([np.cross(y, z), y, z], axis=2)


_DARK_LEVEL: Final = 25.0
"""Grey level that half of a picture which shows something is above."""
_SATURATED_LEVEL: Final = 252
"""Grey level from which on a pixel tells no more."""
_MOST_SATURATED: Final = 0.3
"""Part of a picture."""


def _size_finding(camera: Camera, picture: Picture) -> Diagnostic | None:
    width, height = camera.lens.size
    if picture.shape == (height, width, 3):
        return None
    return rules.UNCALIBRATED_SIZE(
        camera=camera.name,
        width=picture.shape[1],
        height=picture.shape[0],
        wanted_width=width,
        wanted_height=height,
    )


def _brightness_finding(camera: Camera, picture: Picture, *, dark: bool) -> Diagnostic | None:
    """dark: whether a dark picture is wrong; a light is seen best in one."""
    brightest = picture[::2, ::2].max(axis=2)
    if dark and float(np.median(brightest)) < _DARK_LEVEL:
        return rules.TOO_DARK_PICTURE(camera=camera.name, level=_DARK_LEVEL)
    full = float(np.mean(brightest >= _SATURATED_LEVEL))
    if full > _MOST_SATURATED:
        return rules.TOO_BRIGHT_PICTURE(camera=camera.name, percent=100.0 * full)
    return None


_RADIUS_TOLERANCE: Final = 0.05
"""Part of its radius that a ball may be seen larger or smaller, beside parts of a pixel."""
_RADIUS_PIXELS: Final = 0.75
"""Pixels of the outline."""
_MOST_COMBINATIONS: Final = 2000
"""Largest number of tried combinations of spots of several marks."""


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
"""Sighting of the device, or the reason why it is unknown."""


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
    """Locate the device in pictures of the cameras, in their order, taken at one moment."""
    sizes = (_size_finding(c, p) for c, p in zip(cameras, pictures, strict=True))
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
    """Possible positions of a mark: points (n, 3), pixels (c, n, 2), confidences (n,)."""

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
        dazzled = _brightness_finding(camera, picture, dark=isinstance(mark, Ball))
        return dazzled or rules.MARK_NOT_SEEN(camera=camera.name, mark=name)
    ways = list(itertools.product(*(found or (None,) for found in seen)))[:_MOST_COMBINATIONS]
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
    return bool((off <= _RADIUS_TOLERANCE + _RADIUS_PIXELS / max(pixels, 1.0)).all())


def _distinct_positions(points: Floats, sure: Floats, apart: float) -> Rows:
    """Return the surest one of positions that are the same; the surest first."""
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
    ways = np.array(list(itertools.islice(itertools.product(*counts), _MOST_COMBINATIONS)))
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


_FASTEST_HAND: Final = 1500.0
"""mm/s that a hand moves a device with."""
_JUMP_SIGMAS: Final = 6.0
"""Times its uncertainty that a device may be off beside."""
_MOMENTS_TO_FORGET: Final = 5
"""Moments without a believed sighting after which the device is searched for anew, everywhere."""


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """seconds: since the first. pictures: one of each camera, in the order of the cameras."""

    seconds: float
    pictures: Sequence[Picture]


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """Observation at one moment."""

    seconds: float
    seen: Seen


def track_device(
    moments: Iterable[Moment],
    device: Device,
    cameras: Sequence[Camera],
    limits: Limits = USUAL_LIMITS,
    fastest: float = _FASTEST_HAND,
) -> Iterator[Observation]:
    """A look at each moment, in its time. Raises Refused for cameras that can tell no place."""
    check_cameras(cameras)
    looks = (
        Observation(m.seconds, locate_device(device, cameras, m.pictures, limits)) for m in moments
    )
    return reject_jumps(looks, fastest)


def reject_jumps(
    looks: Iterable[Observation], fastest: float = _FASTEST_HAND
) -> Iterator[Observation]:
    """The same looks; a sighting farther away than a hand gets in the time is a finding instead."""
    last: tuple[float, Sighting] | None = None
    missed = 0
    for look in looks:
        seen = look.seen
        if isinstance(seen, Sighting) and last is not None:
            seen = _reject_jump(seen, look.seconds - last[0], last[1], fastest)
        if isinstance(seen, Diagnostic):
            missed += 1
            if missed >= _MOMENTS_TO_FORGET:
                last = None
        else:
            last, missed = (look.seconds, seen), 0
        yield Observation(look.seconds, seen)


def _reject_jump(seen: Sighting, seconds: float, last: Sighting, fastest: float) -> Seen:
    distance = float(np.linalg.norm(np.subtract(seen.pose.position, last.pose.position)))
    spread = float(np.sqrt(np.trace((seen.covariance + last.covariance)[:3, :3])))
    if distance <= fastest * seconds + _JUMP_SIGMAS * spread:
        return seen
    return rules.DEVICE_JUMPED(distance=distance, seconds=seconds)


FILE_RATE: Final = 30.0
"""Pictures a second of files, which do not say when they were taken."""


@contextmanager
def open_moments(
    rig: Rig,
    cameras: Sequence[Camera],
    rate: float = FILE_RATE,
) -> Iterator[Iterator[Moment]]:
    """The moments of cameras of a rig, until one of them gives no more pictures.

    Raises Refused (exit status 2) for a camera without a source, for folders whose pictures are not
    of the same moments, and as `capture.open_frames` does.
    """
    for camera in cameras:
        if not rig.sources.get(camera.name):
            raise Refused(rules.NO_PICTURE_SOURCE(camera=camera.name), exit_status=2)
    sources = [rig.sources[camera.name] for camera in cameras]
    _check_pairing(rig, cameras, sources)
    with ExitStack() as stack:
        frames = [
            stack.enter_context(open_frames(camera, source, rig.folder))
            for camera, source in zip(cameras, sources, strict=True)
        ]
        yield _join_frames(frames, rate)


def _check_pairing(rig: Rig, cameras: Sequence[Camera], sources: Sequence[str]) -> None:
    named = {
        camera.name: files
        for camera, source in zip(cameras, sources, strict=True)
        if (files := picture_names(source, rig.folder))
    }
    for (one, names), (other, others) in combinations(named.items(), 2):
        if (finding := pairing_finding(one, names, other, others)) is not None:
            raise Refused(finding, exit_status=2)


def _join_frames(frames: Sequence[Iterator[Frame]], rate: float) -> Iterator[Moment]:
    began: float | None = None
    for group in zip(*frames, strict=False):
        first = group[0]
        began = first.seconds if began is None else began
        seconds = first.number / rate if first.name else first.seconds - began
        yield Moment(seconds, [frame.picture for frame in group])

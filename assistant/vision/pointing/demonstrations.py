"""Positions and strokes that a user demonstrates with a pointing device.

A position is shown by holding the device still for some moments: pixels are averaged over them and
the pose is computed once from the means, which is the most likely one for pixels of equal noise.

A stroke is the path of the device from one held position to the next. Moments at one position
become one point, so a halt leaves no knot. The points are smoothed by straight lines fitted to
their neighbours along the path (Cleveland, Robust locally weighted regression, 1979, without the
robust weights) and resampled at even distances; both held positions stay as they are.
"""

from __future__ import annotations

import io
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Pose
from assistant.vision import rules
from assistant.vision.cameras.camera import Camera
from assistant.vision.pointing.device_tracking import (
    USUAL_LIMITS,
    Limits,
    Observation,
    Sighting,
    locate_at_pixels,
)
from assistant.vision.pointing.devices import Device

_HOLD_FRAMES: Final = 30
_COMMON_NOISE: Final = 0.02
"""Pixels, one sigma, that the middle of a mark is off in all moments alike."""
_HIDDEN_NOISE: Final = 0.2
"""More of them for a mark that is hidden, part of it for one that is hidden in part: measured
against pictures drawn ray by ray, 0.05 px in the mean and 0.14 at most.
"""
_INTENDED_HOLD_RATIO: Final = 5.0
"""Times what a hold may be off within which moments were meant as one."""
_MOMENT_SIGMAS: Final = 4.5
"""Times the noise of a moment that it may be off beside what a hand may."""
_SETTLING_RATIO: Final = 2.5
_SETTLING_FLOOR: Final = 0.05
"""mm."""
_CREEP_SHARE: Final = 0.7
"""Part of that for the means of the two halves: they are compared once, the moments thirty times.
"""


@dataclass(frozen=True, slots=True)
class HoldLimits:
    """Limits of a hold, in addition to the noise.

    frames: consecutive moments. within: mm that each may be off their mean. creep: mm between the
    means of the first and the second half. turned: degrees that each may be off. apart: mm to the
    position shown before; a closer one does not count as new.
    """

    frames: int = _HOLD_FRAMES
    within: float = 1.5
    creep: float = 0.5
    turned: float = 1.5
    apart: float = 15.0


USUAL_HOLD: Final = HoldLimits()


@dataclass(frozen=True, slots=True, eq=False)
class HeldPosition:
    """A place that was shown.

    pose: in the world. covariance: (6, 6) of the mean, mm and radians, from the scatter that there
    was or the noise of pixels that was stated, whichever is more, and from what is off in all
    moments alike. spread, turned: root mean square of single moments about it, mm and degrees.
    frames: how many they were. residual: pixels. began, ended: seconds.
    """

    pose: Pose
    covariance: Floats
    spread: float
    turned: float
    frames: int
    residual: float
    began: float
    ended: float

    @property
    def sigma(self) -> float:
        """mm, one sigma, of the place in the direction that is known worst."""
        return float(np.sqrt(np.linalg.eigvalsh(self.covariance[:3, :3])[-1]))


def find_holds(
    looks: Iterable[Observation],
    device: Device,
    cameras: Sequence[Camera],
    limits: Limits = USUAL_LIMITS,
    still: HoldLimits = USUAL_HOLD,
    tell: Callable[[Diagnostic], None] = lambda _: None,
) -> Iterator[HeldPosition]:
    """Each place at which the device is held still.

    tell: is given each finding when it first holds, and again after others or a good moment.
    """
    window: deque[tuple[float, Sighting]] = deque(maxlen=still.frames)
    before: Pose | None = None
    said, nearly = "", 0
    for look in looks:
        if isinstance(look.seen, Diagnostic):
            window.clear()
            nearly = 0
            if look.seen.code != said:
                tell(look.seen)
            said = look.seen.code
            continue
        said = ""
        window.append((look.seconds, look.seen))
        if before is not None:
            distance = _distance(look.seen.pose, before)
            if distance < still.apart:
                window.clear()
                continue
            before = None if distance > 2.0 * still.apart else before
        if len(window) < still.frames:
            continue
        found = average_hold(window, device, cameras, limits, still)
        if isinstance(found, HeldPosition):
            before, nearly = found.pose, 0
            window.clear()
            yield found
        elif found.code in _BROKEN_HOLD:
            nearly = _intended_moments(window, still, nearly)
            if nearly == still.frames:
                tell(found)
            window.popleft()  # the next moment is looked at with the others
        else:
            tell(found)
            window.clear()


_BROKEN_HOLD: Final = (rules.DEVICE_MOVED.code, rules.DEVICE_TURNED.code)


def _intended_moments(
    window: Sequence[tuple[float, Sighting]], still: HoldLimits, count: int
) -> int:
    """For how many moments it was tried to hold the device still, and it was not.

    It is `frames` at once where the first half was still: then a hold was broken off. A hand on its
    way to a place is 0.
    """
    sightings = [sighting for _, sighting in window]
    half = sightings[: len(sightings) // 2]
    if (
        count < still.frames
        and len(half) > 1
        and _extent(half) < _most_deviation(half, still.within)
    ):
        return still.frames
    return (
        count + 1
        if _extent(sightings) < _INTENDED_HOLD_RATIO * _most_deviation(sightings, still.within)
        else 0
    )


def average_hold(
    window: Iterable[tuple[float, Sighting]],
    device: Device,
    cameras: Sequence[Camera],
    limits: Limits = USUAL_LIMITS,
    still: HoldLimits = USUAL_HOLD,
) -> HeldPosition | Diagnostic:
    """The place of moments at which the device was to be still, or why they show none."""
    given = list(window)
    seconds = [one[0] for one in given]
    sightings = [one[1] for one in given]
    points = np.array([one.pose.position for one in sightings])
    moved = _movement_finding(points, sightings, still)
    if moved is not None:
        return moved
    settled = _settling_moments(points)
    seconds, sightings, points = seconds[settled:], sightings[settled:], points[settled:]
    pixels = np.stack([one.pixels for one in sightings])
    always = np.isfinite(pixels).all(axis=0)
    mean = np.where(always, np.where(np.isfinite(pixels), pixels, 0.0).mean(axis=0), np.nan)
    seen = locate_at_pixels(device, cameras, mean, limits)
    if isinstance(seen, Diagnostic):
        return seen
    turns = np.array([one.pose.quaternion for one in sightings])
    angles = rotations.angle_between(seen.pose.quaternion, turns)
    noise = float(np.sqrt(np.linalg.eigvalsh(seen.covariance[3:, 3:])[-1]))
    turnable = still.turned + _MOMENT_SIGMAS * float(np.degrees(noise))
    if float(angles.max()) > turnable:
        return rules.DEVICE_TURNED(angle=float(angles.max()), most=turnable)
    away = points - np.array(seen.pose.position)
    spread = float(np.sqrt(np.mean((away**2).sum(axis=1))))
    turned = float(np.sqrt(np.mean(angles**2)))
    return HeldPosition(
        seen.pose,
        seen.covariance
        * (_noise_ratio(seen, away) / len(points) + _common_variance(sightings, limits)),
        spread,
        turned,
        len(points),
        seen.residual,
        seconds[0],
        seconds[-1],
    )


def _movement_finding(
    points: Floats, sightings: Sequence[Sighting], still: HoldLimits
) -> Diagnostic | None:
    off = float(np.linalg.norm(points - points.mean(axis=0), axis=1).max())
    most = _most_deviation(sightings, still.within)
    if off > most:
        return rules.DEVICE_MOVED(distance=off, most=most)
    half = len(points) // 2
    crept = float(np.linalg.norm(points[:half].mean(axis=0) - points[-half:].mean(axis=0)))
    most = still.creep + (most - still.within) * float(np.sqrt(2.0 / half)) * _CREEP_SHARE
    return rules.DEVICE_MOVED(distance=crept, most=most) if crept > most else None


def _settling_moments(points: Floats) -> int:
    """Return the number of first moments in which the hand was still coming to rest: they are left
    out.

    They are farther from the mean of the second half than its moments differ from each other.
    """
    half = points[len(points) // 2 :]
    steps = float(np.sqrt((np.diff(half, axis=0) ** 2).sum(axis=1).mean() / 2.0))
    away = np.linalg.norm(points - half.mean(axis=0), axis=1)
    return min(
        int(np.argmax(away <= _SETTLING_RATIO * steps + _SETTLING_FLOOR)), len(points) - len(half)
    )


def _most_deviation(sightings: Sequence[Sighting], within: float) -> float:
    """Return the mm that a moment may be off: the tolerance of a hand plus the noise of the
    sightings.

    The noise is the stated one, or less if consecutive moments differ by less.
    """
    mean = np.mean([sighting.covariance[:3, :3] for sighting in sightings], axis=0)
    points = np.array([sighting.pose.position for sighting in sightings])
    steps = float(np.sqrt((np.diff(points, axis=0) ** 2).sum(axis=1).mean() / 2.0))
    return within + _MOMENT_SIGMAS * min(float(np.sqrt(np.linalg.eigvalsh(mean)[-1])), steps)


def _noise_ratio(seen: Sighting, away: Floats) -> float:
    """Return the ratio of the variance of the moments to that of the stated noise, at least 1."""
    expected = float(np.trace(seen.covariance[:3, :3]))
    scattered = float((away**2).sum(axis=1).mean())
    return max(1.0, scattered / max(expected, 1e-12))


def _common_variance(sightings: Sequence[Sighting], limits: Limits) -> float:
    """The variance, as part of that of the stated noise, that no number of moments makes less."""
    hidden = 1.0 - float(np.mean([one.confidence for one in sightings]))
    return float(((_COMMON_NOISE + _HIDDEN_NOISE * hidden) / limits.noise) ** 2)


def _distance(one: Pose, other: Pose) -> float:
    return float(np.linalg.norm(np.subtract(one.position, other.position)))


def _extent(sightings: Sequence[Sighting]) -> float:
    """Return the diagonal, mm, of the box that contains the device positions."""
    points = np.array([sighting.pose.position for sighting in sightings])
    return float(np.linalg.norm(np.ptp(points, axis=0)))


_SAME_POINT: Final = 2.0
"""mm within which moments are one point of the way."""
_HELD_RADIUS: Final = 6.0
"""mm from a place that was held within which moments belong to it."""


@dataclass(frozen=True, slots=True)
class Smoothing:
    """step: mm between waypoints. window: mm of the way to both sides that each is fitted to.
    gap: mm that the device may go unseen. shortest: mm of a stroke.
    """

    step: float = 5.0
    window: float = 12.0
    gap: float = 25.0
    shortest: float = 20.0


_USUAL_SMOOTHING: Final = Smoothing()


@dataclass(frozen=True, slots=True, eq=False)
class Stroke:
    """positions: (n, 3) mm and quaternions: (n, 4) along the way. length: mm.

    scatter: mm, root mean square, of what was seen from it. first, last: the places between
    which it was shown.
    """

    positions: Floats
    quaternions: Floats
    length: float
    scatter: float
    first: HeldPosition
    last: HeldPosition

    def csv(self) -> str:
        """Return a table of waypoints, mm and unit quaternions."""
        text = io.StringIO()
        text.write("x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n")
        turns = rotations.canonical(self.quaternions)
        for p, q in zip(self.positions.tolist(), turns.tolist(), strict=True):
            numbers = [f"{v + 0.0:.3f}" for v in p] + [f"{v + 0.0:.7f}" for v in q]
            text.write(",".join(numbers) + "\n")
        return text.getvalue()


def find_strokes(
    looks: Iterable[Observation],
    device: Device,
    cameras: Sequence[Camera],
    limits: Limits = USUAL_LIMITS,
    still: HoldLimits = USUAL_HOLD,
    smoothing: Smoothing = _USUAL_SMOOTHING,
    tell: Callable[[Diagnostic], None] = lambda _: None,
) -> Iterator[Stroke]:
    """The ways between two holds, the first, the third … of which begin one.

    Raises Refused for a stroke of no length, and for one that was not seen as a whole.
    """
    seen: list[tuple[float, Sighting]] = []

    def remembered() -> Iterator[Observation]:
        for look in looks:
            if isinstance(look.seen, Sighting):
                seen.append((look.seconds, look.seen))
            yield look

    first: HeldPosition | None = None
    for held in find_holds(remembered(), device, cameras, limits, still, tell):
        if first is None:
            first = held
            continue
        between = [s for t, s in seen if first.ended < t < held.began]
        yield _fit_stroke(first, between, held, smoothing)
        first = None
        seen.clear()


def _fit_stroke(
    first: HeldPosition,
    between: Sequence[Sighting],
    last: HeldPosition,
    smoothing: Smoothing = _USUAL_SMOOTHING,
) -> Stroke:
    """The way from one held place past sightings to another one; raises Refused."""
    ends = [np.array(held.pose.position) for held in (first, last)]
    points = np.array([s.pose.position for s in between]).reshape(-1, 3)
    turns = np.array([s.pose.quaternion for s in between]).reshape(-1, 4)
    near = [np.linalg.norm(points - end, axis=1) < _HELD_RADIUS for end in ends]
    begin = len(points) - int(np.argmax(near[0][::-1])) if near[0].any() else 0
    end = int(np.argmax(near[1])) if near[1].any() else len(points)
    points, turns = points[begin:end], turns[begin:end]
    whole = np.concatenate([ends[:1], points, ends[1:]])
    steps = np.linalg.norm(np.diff(whole, axis=0), axis=1)
    if float(steps.max()) > smoothing.gap:
        finding = rules.GAP_IN_STROKE(distance=float(steps.max()), most=smoothing.gap)
        raise Refused(finding)
    nodes, at, weights = _merge_points(whole, np.array([1.0, *np.ones(len(points)), 1.0]))
    nodes[0], nodes[-1] = ends
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(nodes, axis=0), axis=1))])
    if along[-1] < smoothing.shortest:
        raise Refused(rules.SHORT_STROKE(length=float(along[-1])))
    own = [np.array(held.pose.quaternion) for held in (first, last)]
    turns = rotations.unflipped(np.concatenate([own[:1], turns, own[1:]]))
    turned = np.stack([turns[at == i].mean(axis=0) for i in range(len(nodes))])
    dense = np.linspace(0.0, along[-1], max(2, int(np.ceil(along[-1] / smoothing.step * 4.0)) + 1))
    values = np.concatenate([nodes, turned], axis=1)
    smooth = _fit_local_lines(along, values, weights, dense, smoothing.window)
    smooth[0, :3], smooth[-1, :3] = ends
    positions, quaternions = _resample(smooth[:, :3], smooth[:, 3:], smoothing.step)
    scatter = _stroke_scatter(nodes, positions)
    length = float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum())
    return Stroke(positions, quaternions, length, scatter, first, last)


def _merge_points(points: Floats, weights: Floats) -> tuple[Floats, Rows, Floats]:
    """Means (k, 3) of points that follow each other within `_SAME_POINT`; which of them each point
    of (n,) belongs to; how many belong to each (k,).
    """
    at: Rows = np.zeros(len(points), dtype=np.intp)
    centre, count, number = points[0].copy(), 1, 0
    for i in range(1, len(points)):
        if np.linalg.norm(points[i] - centre) > _SAME_POINT or i == len(points) - 1:
            number, centre, count = number + 1, points[i].copy(), 1
        else:
            count += 1
            centre += (points[i] - centre) / count
        at[i] = number
    total: Floats = np.bincount(at, weights).astype(np.float64)
    means = [np.bincount(at, weights * points[:, k]) / total for k in range(3)]
    return np.stack(means, axis=1), at, total


def _fit_local_lines(
    along: Floats, values: Floats, weights: Floats, at: Floats, window: float
) -> Floats:
    """Lines through neighbours (k, c) along a way, at places (m,) of it; weights fall to 0."""
    found = np.empty((len(at), values.shape[1]))
    for i, s in enumerate(at):
        away = np.abs(along - s)
        reach = max(window, float(np.sort(away)[min(2, len(away) - 1)]) * 1.5)
        w = weights * np.maximum(1.0 - (away / reach) ** 3, 0.0) ** 3
        x = along - s
        total, mean = w.sum(), (w @ x) / w.sum()
        middle = (w @ values) / total
        spread = w @ (x - mean) ** 2
        slope = (w * (x - mean)) @ values / spread if spread > 1e-9 else 0.0 * middle
        found[i] = middle - slope * mean
    return found


def _resample(positions: Floats, quaternions: Floats, step: float) -> tuple[Floats, Floats]:
    """At even distances along the way, at most `step` apart, with both ends."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(positions, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], max(2, int(np.ceil(along[-1] / step)) + 1))
    p = np.stack([np.interp(at, along, positions[:, k]) for k in range(3)], axis=1)
    q = np.stack([np.interp(at, along, quaternions[:, k]) for k in range(4)], axis=1)
    return p, rotations.canonical(q)


def _stroke_scatter(nodes: Floats, way: Floats) -> float:
    """mm, root mean square, from nodes (k, 3) to the straight parts between points of a way."""
    a, along = way[:-1], np.diff(way, axis=0)
    part = np.einsum("kmi,mi->km", nodes[:, None] - a, along) / (along**2).sum(axis=1)
    foot = a + np.clip(part, 0.0, 1.0)[..., None] * along
    least = ((nodes[:, None] - foot) ** 2).sum(axis=2).min(axis=1)
    return float(np.sqrt(least.mean()))

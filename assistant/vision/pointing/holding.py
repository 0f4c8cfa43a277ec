"""A device that is held still for n moments: the place that it shows, and how sure it is.

Pixels are averaged over the moments and the place is worked out once from their means, which is the
most likely one for pixels with the same noise.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera
from assistant.vision.pointing import rules
from assistant.vision.pointing.devices import Device
from assistant.vision.pointing.locating import USUAL_LIMITS, Limits, Sighting, locate_at_pixels
from assistant.vision.pointing.tracking import Observation

HOLD_FRAMES: Final = 30
COMMON_NOISE: Final = 0.02
"""Pixels, one sigma, that the middle of a mark is off in all moments alike."""
HIDDEN_NOISE: Final = 0.2
"""More of them for a mark that is hidden, part of it for one that is hidden in part: measured
against pictures drawn ray by ray, 0.05 px in the mean and 0.14 at most.
"""
INTENDED_HOLD_RATIO: Final = 5.0
"""Times what a hold may be off within which moments were meant as one."""
MOMENT_SIGMAS: Final = 4.5
"""Times the noise of a moment that it may be off beside what a hand may."""
SETTLING_RATIO: Final = 2.5
SETTLING_FLOOR: Final = 0.05
"""mm."""
CREEP_SHARE: Final = 0.7
"""Part of that for the means of the two halves: they are compared once, the moments thirty times.
"""


@dataclass(frozen=True, slots=True)
class HoldLimits:
    """What a hold is, beside the noise that there is.

    frames: moments one after the other. within: mm that each may be off their mean. creep: mm
    between the means of the first and the second half. turned: degrees that each may be off.
    apart: mm to the place shown before, nearer to which nothing is shown anew.
    """

    frames: int = HOLD_FRAMES
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
        elif found.code in BROKEN_HOLD:
            nearly = _intended_moments(window, still, nearly)
            if nearly == still.frames:
                tell(found)
            window.popleft()  # the next moment is looked at with the others
        else:
            tell(found)
            window.clear()


BROKEN_HOLD: Final = (rules.DEVICE_MOVED.code, rules.DEVICE_TURNED.code)


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
        if _extent(sightings) < INTENDED_HOLD_RATIO * _most_deviation(sightings, still.within)
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
    turnable = still.turned + MOMENT_SIGMAS * float(np.degrees(noise))
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
    most = still.creep + (most - still.within) * float(np.sqrt(2.0 / half)) * CREEP_SHARE
    return rules.DEVICE_MOVED(distance=crept, most=most) if crept > most else None


def _settling_moments(points: Floats) -> int:
    """How many moments at the begin the hand was still coming to rest: they are left out.

    They are farther from the mean of the second half than its own moments differ.
    """
    half = points[len(points) // 2 :]
    steps = float(np.sqrt((np.diff(half, axis=0) ** 2).sum(axis=1).mean() / 2.0))
    away = np.linalg.norm(points - half.mean(axis=0), axis=1)
    return min(
        int(np.argmax(away <= SETTLING_RATIO * steps + SETTLING_FLOOR)), len(points) - len(half)
    )


def _most_deviation(sightings: Sequence[Sighting], within: float) -> float:
    """How many mm a moment may be off: what a hand may, and the noise of what is seen.

    That is what was stated, or less where moments that follow each other differ by less.
    """
    mean = np.mean([sighting.covariance[:3, :3] for sighting in sightings], axis=0)
    points = np.array([sighting.pose.position for sighting in sightings])
    steps = float(np.sqrt((np.diff(points, axis=0) ** 2).sum(axis=1).mean() / 2.0))
    return within + MOMENT_SIGMAS * min(float(np.sqrt(np.linalg.eigvalsh(mean)[-1])), steps)


def _noise_ratio(seen: Sighting, away: Floats) -> float:
    """How many times the variance of the stated noise the moments had, 1 at least."""
    expected = float(np.trace(seen.covariance[:3, :3]))
    scattered = float((away**2).sum(axis=1).mean())
    return max(1.0, scattered / max(expected, 1e-12))


def _common_variance(sightings: Sequence[Sighting], limits: Limits) -> float:
    """The variance, as part of that of the stated noise, that no number of moments makes less."""
    hidden = 1.0 - float(np.mean([one.confidence for one in sightings]))
    return float(((COMMON_NOISE + HIDDEN_NOISE * hidden) / limits.noise) ** 2)


def _distance(one: Pose, other: Pose) -> float:
    return float(np.linalg.norm(np.subtract(one.position, other.position)))


def _extent(sightings: Sequence[Sighting]) -> float:
    """How many mm from corner to corner of the box in which the device was."""
    points = np.array([sighting.pose.position for sighting in sightings])
    return float(np.linalg.norm(np.ptp(points, axis=0)))

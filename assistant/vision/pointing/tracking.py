"""A device followed from moment to moment: it is not believed to jump, and is found again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.diagnostics import Diagnostic
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.drawing import Picture
from assistant.vision.pointing import rules
from assistant.vision.pointing.devices import Device
from assistant.vision.pointing.locating import (
    USUAL_LIMITS,
    Limits,
    Seen,
    Sighting,
    check_cameras,
    locate_device,
)

FASTEST_HAND: Final = 1500.0
"""mm/s that a hand moves a device with."""
JUMP_SIGMAS: Final = 6.0
"""Times its uncertainty that a device may be off beside."""
MOMENTS_TO_FORGET: Final = 5
"""Moments without a believed sighting after which the device is looked for anew, everywhere."""


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """seconds: since the first. pictures: one of each camera, in the order of the cameras."""

    seconds: float
    pictures: Sequence[Picture]


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """What is known of one moment."""

    seconds: float
    seen: Seen


def track_device(
    moments: Iterable[Moment],
    device: Device,
    cameras: Sequence[Camera],
    limits: Limits = USUAL_LIMITS,
    fastest: float = FASTEST_HAND,
) -> Iterator[Observation]:
    """A look at each moment, in its time. Raises Refused for cameras that can tell no place."""
    check_cameras(cameras)
    looks = (
        Observation(m.seconds, locate_device(device, cameras, m.pictures, limits)) for m in moments
    )
    return reject_jumps(looks, fastest)


def reject_jumps(
    looks: Iterable[Observation], fastest: float = FASTEST_HAND
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
            if missed >= MOMENTS_TO_FORGET:
                last = None
        else:
            last, missed = (look.seconds, seen), 0
        yield Observation(look.seconds, seen)


def _reject_jump(seen: Sighting, seconds: float, last: Sighting, fastest: float) -> Seen:
    distance = float(np.linalg.norm(np.subtract(seen.pose.position, last.pose.position)))
    spread = float(np.sqrt(np.trace((seen.covariance + last.covariance)[:3, :3])))
    if distance <= fastest * seconds + JUMP_SIGMAS * spread:
        return seen
    return rules.DEVICE_JUMPED(distance=distance, seconds=seconds)

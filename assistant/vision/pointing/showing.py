"""Devices as things that synthetic cameras see."""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.cell.link_bodies import capsule_between
from assistant.cell.scene import Sphere
from assistant.program.geometry import Pose
from assistant.vision.cameras.drawing import Colour, VisibleBody
from assistant.vision.pointing.devices import Ball, Device

BALL_PAINTS: Final[dict[str, Colour]] = {
    "red": (210, 30, 30),
    "orange": (230, 120, 20),
    "yellow": (220, 210, 30),
    "green": (40, 180, 40),
    "cyan": (30, 190, 190),
    "blue": (30, 70, 210),
    "magenta": (200, 40, 180),
}
STICK_PAINT: Final[Colour] = (70, 70, 72)
STICK_RADIUS: Final = 3.0
"""mm, radius of a stick between two balls."""


def bodies_of_device(device: Device, pose: Pose) -> list[VisibleBody]:
    """The balls of a device at a pose in the world, and sticks from the first one to each other."""
    balls = [mark for mark in device.marks if isinstance(mark, Ball)]
    found = [
        VisibleBody(
            Sphere(one.radius),
            pose @ Pose(one.position),
            BALL_PAINTS.get(one.colour_name, (200, 200, 200)),
        )
        for one in balls
    ]
    for one in balls[1:]:
        part = capsule_between(np.array(balls[0].position), np.array(one.position), STICK_RADIUS)
        found.append(VisibleBody(part.shape, pose @ part.pose, STICK_PAINT))
    return found

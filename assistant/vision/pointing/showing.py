"""Devices as things that synthetic cameras see."""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.cell.link_bodies import capsule_between
from assistant.cell.scene import Sphere
from assistant.program.geometry import Pose
from assistant.vision.cameras.drawing import Colour, Thing
from assistant.vision.pointing.devices import Ball, Device

PAINTS: Final[dict[str, Colour]] = {
    "red": (210, 30, 30),
    "orange": (230, 120, 20),
    "yellow": (220, 210, 30),
    "green": (40, 180, 40),
    "cyan": (30, 190, 190),
    "blue": (30, 70, 210),
    "magenta": (200, 40, 180),
}
STICK: Final[Colour] = (70, 70, 72)
THICK: Final = 3.0
"""mm, radius of a stick between two balls."""


def things_of_device(device: Device, pose: Pose) -> list[Thing]:
    """The balls of a device at a pose in the world, and sticks from the first one to each other."""
    balls = [mark for mark in device.marks if isinstance(mark, Ball)]
    found = [
        Thing(
            Sphere(one.radius),
            pose @ Pose(one.position),
            PAINTS.get(one.colour_name, (200, 200, 200)),
        )
        for one in balls
    ]
    for one in balls[1:]:
        part = capsule_between(np.array(balls[0].position), np.array(one.position), THICK)
        found.append(Thing(part.shape, pose @ part.pose, STICK))
    return found

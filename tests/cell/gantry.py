"""A gantry whose axes slide along z, y and x: its ways are straight, its distances exact."""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.cell.scene import PlacedRobot
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.robot_file import read

GANTRY = b"""
name = "gantry"
title = "Gantry"
maker = "nobody"
controller = "none"
languages = []
arm = "serial"
configuration = "turns"
payload_kg = 5
reach_mm = 4000
source = "made for tests"

[[links]]
alpha = -90
[[links]]
alpha = -90
theta = -90
[[links]]

[axes_mm]
J1 = { limits = [-5000, 5000], speed = 3000, home = 0 }
J2 = { limits = [-5000, 5000], speed = 3000, home = 0 }
J3 = { limits = [-5000, 5000], speed = 3000, home = 0 }
"""


def gantry(name: str = "gantry", base: Pose = IDENTITY) -> PlacedRobot:
    """Without bodies of its own. Its flange stands as its base, turned by `TURN`."""
    return PlacedRobot(name, read(GANTRY), base)


TURN: Final = Pose((0.0, 0.0, 0.0), (0.0, 0.5**0.5, 0.0, 0.5**0.5))
"""The flange in the base with all axes at 0."""


def joints(places: Floats) -> Floats:
    """(n, 3) places of the flange in the base → joints (n, 3)."""
    return np.ascontiguousarray(places[:, ::-1])

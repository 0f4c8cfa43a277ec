"""The experiments of the literature on arms of the catalogue: what learns, where, and from what."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant import robots
from assistant.base.arrays import Floats
from assistant.learning.maps.extended_map import ExtendedMap
from assistant.learning.maps.goals import InBox, InRanges, Space, ranges_about_home, ranges_for_box
from assistant.learning.maps.seen_arm import ObservedArm, observed_arm, pair_for
from assistant.learning.maps.training import start_map
from assistant.vision.cameras.camera import Camera, looking_at

TOOL_TIP: Final = (0.0, 0.0, 60.0)
TOOL_POINTS: Final = (TOOL_TIP, (60.0, 0.0, 20.0), (0.0, 60.0, 20.0))
"""Mm on the flange: the tip of a tool, and marks aside of it."""


@dataclass(frozen=True, slots=True, eq=False)
class Experiment:
    """dimensions: numbers by which a goal is told."""

    arm: ObservedArm
    space: Space
    ranges: Floats
    dimensions: int

    def start(self, seed: int = 0) -> ExtendedMap:
        return start_map(self.arm, self.space, self.ranges, self.dimensions, seed)


def three_joints() -> Experiment:
    """As published: the first three joints of an arm, the tip of its tool anywhere in a box.

    Here of an RV-2AJ whose hand is held straight; the box is 150 x 400 x 200 mm.
    """
    box = np.array([[300.0, 450.0], [-200.0, 200.0], [200.0, 400.0]])
    robot = robots.get("rv-2aj")
    arm = observed_arm(
        robot, pair_for(box_corners(box)), [TOOL_TIP], ("J1", "J2", "J3"), np.zeros(5)
    )
    ranges = np.array([[-60.0, 60.0], [-60.0, 120.0], [0.0, 120.0]])
    return Experiment(arm, InBox(box), ranges, 3)


def five_joints() -> Experiment:
    """All joints of an RV-2AJ, two points of whose tool are seen."""
    robot = robots.get("rv-2aj")
    ranges = np.array([[-50.0, 50.0], [0.0, 50.0], [50.0, 100.0], [20.0, 70.0], [-45.0, 45.0]])
    return over_ranges(observed_arm(robot, (), TOOL_POINTS[:2]), ranges)


def over_ranges(arm: ObservedArm, ranges: Floats | None = None) -> Experiment:
    """Joints of any arm between ranges (a, 2), by default about its home; without cameras a pair is
    put up that sees it there.
    """
    known = ranges_about_home(arm.robot, arm.moves) if ranges is None else ranges
    seen = arm
    if not arm.cameras:
        joints = np.random.default_rng(0).uniform(known[:, 0], known[:, 1], (2000, len(known)))
        seen = arm.watched(pair_for(arm.tool(joints)[0].reshape(-1, 3)))
    return Experiment(seen, InRanges(known), known, seen.task.determined)


def over_box(arm: ObservedArm, space: InBox) -> Experiment:
    """A tool that is held by a rule, in a box; raises Refused if the arm does not reach it."""
    seen = arm
    if not arm.cameras:
        around = float(np.linalg.norm(arm.points - arm.points[0], axis=1).max())
        wider = space.box + np.array([-around, around])
        seen = arm.watched(pair_for(box_corners(wider)))
    turned = space.rule != "any" and space.turn[0] < space.turn[1]
    return Experiment(seen, space, ranges_for_box(seen, space), 4 if turned else 3)


def six_joints() -> Experiment:
    """All joints of an IRB 1200 whose tool points down and is turned, seen by three points."""
    box = np.array([[350.0, 550.0], [-150.0, 150.0], [150.0, 350.0]])
    arm = observed_arm(robots.get("irb1200-5-0.9"), (), TOOL_POINTS)
    return over_box(arm, InBox(box, "down", (-45.0, 45.0)))


def moved_aside(camera: Camera, by: float) -> Camera:
    """A camera that stands so many mm aside and still looks at where it did, 1 m ahead."""
    eye = np.array(camera.pose.position)
    ahead = camera.directions(np.array([camera.lens.centre]))[0]
    aside = np.cross(ahead, (0.0, 0.0, 1.0))
    place = looking_at(eye + by * aside / np.linalg.norm(aside), eye + 1000.0 * ahead)
    return Camera(camera.name, camera.lens, place, camera.parent)


def box_corners(box: Floats) -> Floats:
    """(8, 3) of a box (3, 2)."""
    grid = np.meshgrid(*box, indexing="ij")
    return np.stack([one.ravel() for one in grid], axis=1)

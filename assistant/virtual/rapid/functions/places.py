"""Functions that work out positions, orientations and poses from others."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.program.geometry import Pose
from assistant.virtual.rapid.ends import UNSURE, Fault
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.poses import (
    moved_target,
    number,
    orient,
    pos,
    pose,
    pose_of,
    quaternion_of,
    vector_of,
)
from assistant.virtual.rapid.values import Record, copied

ANGLE_SWITCHES: Final = ("z", "y", "x")
MOST_REPAIRED: Final = 0.1
"""How far the sum of squares may be from 1 for NOrient (manual, NOrient)."""


def _offset_target(given: Given) -> Record:
    """Along the axes of the target's frame; the rest of the target stays as it is."""
    target = copied(given.record(0, "robtarget"))
    assert isinstance(target, Record)
    x, y, z = (a + given.number(i) for i, a in enumerate(vector_of(target.parts["trans"]), 1))
    target.parts["trans"] = pos((x, y, z))
    return target


def _relative_target(given: Given) -> Record:
    """Along the axes of the tool, then turned about its x, its new y and its new z."""
    target = given.record(0, "robtarget")
    shift = (given.number(1), given.number(2), given.number(3))
    angles = [given.optional_number(option) or 0.0 for option in ("rx", "ry", "rz")]
    turn = rotations.from_euler(angles, "XYZ")
    return moved_target(target, pose_of(target) @ Pose.of(np.array(shift), turn))


def _multiplied_poses(given: Given) -> Record:
    return pose(pose_of(given.record(0, "pose")) @ pose_of(given.record(1, "pose")))


def _inverse_pose(given: Given) -> Record:
    return pose(pose_of(given.record(0, "pose")).inverse())


def _transformed_vector(given: Given) -> Record:
    at = pose_of(given.record(0, "pose")) @ Pose(vector_of(given.record(1, "pos")))
    return pos(at.position)


def _orientation_of_angles(given: Given) -> Record:
    angles = [given.number(i) for i in range(3)]
    w, x, y, z = (float(part) for part in rotations.from_euler(angles, "ZYX"))
    return orient((w, x, y, z))


def _euler_angle(given: Given) -> float:
    wanted = [i for i, letter in enumerate(ANGLE_SWITCHES) if given.has(letter)]
    if len(wanted) != 1:
        raise Fault("EulerZYX takes one of its switches")
    angles = rotations.to_euler(quaternion_of(given.record(0, "orient")), "ZYX")
    return float(angles[wanted[0]])


def _normalised_orientation(given: Given) -> Record:
    parts = [number(part) for part in given.record(0, "orient").parts.values()]
    length = math.hypot(*parts)
    if not abs(length * length - 1.0) <= MOST_REPAIRED:
        raise Fault("an orientation that is too far from a unit quaternion", UNSURE)
    w, x, y, z = (part / length for part in parts)
    return orient((w, x, y, z))


def _distance(given: Given) -> float:
    return math.dist(vector_of(given.record(0, "pos")), vector_of(given.record(1, "pos")))


def _magnitude(given: Given) -> float:
    return math.hypot(*vector_of(given.record(0, "pos")))


def _dot_product(given: Given) -> float:
    return float(np.dot(vector_of(given.record(0, "pos")), vector_of(given.record(1, "pos"))))


def _cross_product(given: Given) -> Record:
    one, two = (vector_of(given.record(i, "pos")) for i in (0, 1))
    x, y, z = (float(part) for part in np.cross(one, two))
    return pos((x, y, z))


POSE_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("Offs", 4, _offset_target),
        table_row("RelTool", 4, _relative_target, "rx ry rz"),
        table_row("PoseMult", 2, _multiplied_poses),
        table_row("PoseInv", 1, _inverse_pose),
        table_row("PoseVect", 2, _transformed_vector),
        table_row("OrientZYX", 3, _orientation_of_angles),
        table_row("EulerZYX", 1, _euler_angle, "x y z"),
        table_row("NOrient", 1, _normalised_orientation),
        table_row("Distance", 2, _distance),
        table_row("VectMagn", 1, _magnitude),
        table_row("DotProd", 2, _dot_product),
        table_row("CrossProd", 2, _cross_product),
    )
)

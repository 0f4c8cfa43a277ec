"""Functions that work out positions, orientations and poses from others."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.program.geometry import Pose
from assistant.virtual.rapid.ends import UNSURE, Fault
from assistant.virtual.rapid.given import Given, takes
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.poses import (
    moved,
    number,
    orient,
    pos,
    pose,
    pose_of,
    quaternion_of,
    vector_of,
)
from assistant.virtual.rapid.values import Record, copied

ANGLES: Final = ("z", "y", "x")
MOST_REPAIRED: Final = 0.1
"""How far the sum of squares may be from 1 for NOrient (manual, NOrient)."""


def _offset(given: Given) -> Record:
    """Along the axes of the target's frame; the rest of the target stays as it is."""
    target = copied(given.record(0, "robtarget"))
    assert isinstance(target, Record)
    x, y, z = (a + given.number(i) for i, a in enumerate(vector_of(target.parts["trans"]), 1))
    target.parts["trans"] = pos((x, y, z))
    return target


def _relative(given: Given) -> Record:
    """Along the axes of the tool, then turned about its x, its new y and its new z."""
    target = given.record(0, "robtarget")
    shift = (given.number(1), given.number(2), given.number(3))
    angles = [given.optional_number(option) or 0.0 for option in ("rx", "ry", "rz")]
    turn = rotations.from_euler(angles, "XYZ")
    return moved(target, pose_of(target) @ Pose.of(np.array(shift), turn))


def _multiply(given: Given) -> Record:
    return pose(pose_of(given.record(0, "pose")) @ pose_of(given.record(1, "pose")))


def _inverse(given: Given) -> Record:
    return pose(pose_of(given.record(0, "pose")).inverse())


def _transformed(given: Given) -> Record:
    at = pose_of(given.record(0, "pose")) @ Pose(vector_of(given.record(1, "pos")))
    return pos(at.position)


def _from_angles(given: Given) -> Record:
    angles = [given.number(i) for i in range(3)]
    w, x, y, z = (float(part) for part in rotations.from_euler(angles, "ZYX"))
    return orient((w, x, y, z))


def _angle(given: Given) -> float:
    wanted = [i for i, letter in enumerate(ANGLES) if given.has(letter)]
    if len(wanted) != 1:
        raise Fault("EulerZYX takes one of its switches")
    angles = rotations.to_euler(quaternion_of(given.record(0, "orient")), "ZYX")
    return float(angles[wanted[0]])


def _normalised(given: Given) -> Record:
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


def _dot(given: Given) -> float:
    return float(np.dot(vector_of(given.record(0, "pos")), vector_of(given.record(1, "pos"))))


def _cross(given: Given) -> Record:
    one, two = (vector_of(given.record(i, "pos")) for i in (0, 1))
    x, y, z = (float(part) for part in np.cross(one, two))
    return pos((x, y, z))


TABLE: Final[Mapping[str, Function]] = dict(
    (
        takes("Offs", 4, _offset),
        takes("RelTool", 4, _relative, "rx ry rz"),
        takes("PoseMult", 2, _multiply),
        takes("PoseInv", 1, _inverse),
        takes("PoseVect", 2, _transformed),
        takes("OrientZYX", 3, _from_angles),
        takes("EulerZYX", 1, _angle, "x y z"),
        takes("NOrient", 1, _normalised),
        takes("Distance", 2, _distance),
        takes("VectMagn", 1, _magnitude),
        takes("DotProd", 2, _dot),
        takes("CrossProd", 2, _cross),
    )
)

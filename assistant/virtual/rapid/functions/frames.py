"""Functions that work out frames from positions, and positions in other frames."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.program.geometry import Pose
from assistant.virtual.rapid.ends import UNSURE, Fault, NotSimulated
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import whole
from assistant.virtual.rapid.poses import (
    extjoint_of,
    moved_target,
    pose,
    pose_of,
    record,
    truth,
    vector_of,
)
from assistant.virtual.rapid.values import Array, Record

MIRROR: Final = np.array([1.0, 1.0, -1.0])
"""The xy plane of the frame of the mirror."""


def _mirrored_target(given: Given) -> Record:
    r"""MirPos: the tool's x and z axis are mirrored, with \MirY its y and z axis.

    The third follows from them, so that the axes are a right-handed system again.
    """
    target, plane = given.record(0, "robtarget"), _mirror_place(given.record(1, "wobjdata"))
    frame = given.optional_record("wobj", "wobjdata")
    into = plane.inverse() @ (Pose() if frame is None else _mirror_place(frame))
    seen = into @ pose_of(target)
    axes = rotations.to_matrix(seen.quaternion) * MIRROR[:, None]
    if given.has("miry"):
        axes[:, 0] = np.cross(axes[:, 1], axes[:, 2])
    else:
        axes[:, 1] = np.cross(axes[:, 2], axes[:, 0])
    there = Pose.of(np.multiply(seen.position, MIRROR), rotations.from_matrix(axes))
    return moved_target(target, into.inverse() @ there)


def _mirror_place(frame: Record) -> Pose:
    """Of a work object in the world, or of one on the robot in the wrist."""
    if not truth(frame.parts["ufprog"]):
        raise NotSimulated("a work object that a mechanical unit moves")
    return pose_of(frame.parts["uframe"]) @ pose_of(frame.parts["oframe"])


def _defined_frame(given: Given) -> Record:
    origin = whole(given.optional_number("origin") or 1.0, "the origin of a frame")
    return pose(_frame_through(_frame_points(given, range(3)), origin))


def _displaced_frame(given: Given) -> Record:
    """DefDFrame: what takes three positions to three others."""
    old, new = (_frame_through(_frame_points(given, range(i, i + 3)), 1) for i in (0, 3))
    return pose(new @ old.inverse())


def _frame_points(given: Given, indices: range) -> Floats:
    return np.array([vector_of(given.record(i, "robtarget").parts["trans"]) for i in indices])


def _frame_through(points: Floats, origin: int) -> Pose:
    """A frame whose x axis goes from the first to the second point, the third on the side of +y.

    origin: 1 or 2 for that point, 3 for where the y axis then goes through the third point.
    """
    first, second, third = points
    x = second - first
    z = np.cross(x, third - first)
    if not np.linalg.norm(z) > 1e-6:
        raise Fault("a frame of positions on one line", "ERR_FRAME")
    x /= np.linalg.norm(x)
    z /= np.linalg.norm(z)
    places = {1: first, 2: second, 3: first + np.dot(third - first, x) * x}
    if origin not in places:
        raise Fault(f"a frame with the origin {origin}", UNSURE)
    axes = np.column_stack((x, np.cross(z, x), z))
    return Pose.of(places[origin], rotations.canonical(rotations.from_matrix(axes)))


def _fitted_frame(given: Given) -> Record:
    """DefAccFrame: the frame that takes positions to others with the least squares of distances."""
    count = whole(given.number(2), "the number of positions")
    old, new = (_listed_points(given, i, count) for i in (0, 1))
    middle, other = old.mean(axis=0), new.mean(axis=0)
    u, _, v = np.linalg.svd((old - middle).T @ (new - other))
    turn = v.T @ np.diag((1.0, 1.0, np.sign(np.linalg.det(v.T @ u.T)))) @ u.T
    shift = other - turn @ middle
    apart = np.linalg.norm(old @ turn.T + shift - new, axis=1)
    given.place(3).set(float(apart.max()))
    given.place(4).set(float(apart.mean()))
    return pose(Pose.of(shift, rotations.canonical(rotations.from_matrix(turn))))


def _listed_points(given: Given, index: int, count: int) -> Floats:
    targets = given.place(index).get()
    assert isinstance(targets, Array)
    if not 3 <= count <= min(10, len(targets.items)):
        raise Fault(f"a frame of {count} positions, which is for 3 to 10", UNSURE)
    found = [record(item, "robtarget").parts["trans"] for item in targets.items[:count]]
    return np.array([vector_of(one) for one in found])


def _object_target(given: Given) -> Record:
    """ORobT: a position without the displacement and the offset that are active."""
    arm, target = given.machine.arm, given.record(0, "robtarget")
    if not given.has("inpdisp"):
        target = moved_target(target, arm.displacement @ pose_of(target))
    else:
        target = moved_target(target, pose_of(target))
    if not given.has("ineoffs"):
        target.parts["extax"] = extjoint_of(target.parts["extax"], arm.offsets)
    return target


FRAME_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("MirPos", 2, _mirrored_target, "wobj miry"),
        table_row("DefFrame", 3, _defined_frame, "origin"),
        table_row("DefDFrame", 6, _displaced_frame),
        table_row("DefAccFrame", 5, _fitted_frame),
        table_row("ORobT", 1, _object_target, "inpdisp ineoffs"),
    )
)

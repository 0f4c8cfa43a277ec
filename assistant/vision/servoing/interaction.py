"""Change of seen features by motion: interaction matrices, twists, Jacobians of arms.

A twist is (vx, vy, vz, wx, wy, wz): mm/s of a point and rad/s, in the axes of a frame.
"""

from __future__ import annotations

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.program.geometry import Pose
from assistant.robots import Robot


def interaction_matrix(tangents: Floats, depths: Floats) -> Floats:
    """(2n, 6) change of tangents x / z, y / z of still points by the twist of the camera.

    tangents: (n, 2). depths: (n,) mm along the view. The twist is of the camera's own point, in its
    own axes. Chaumette and Hutchinson, Visual servo control part I (IEEE Robotics and Automation
    Magazine 13 (4), 2006), equation 11.
    """
    x, y = tangents.T
    near, none, one = 1.0 / depths, np.zeros_like(x), np.ones_like(x)
    rows = [
        [-near, none, x * near, x * y, -(one + x * x), y],
        [none, -near, y * near, one + y * y, -x * y, -x],
    ]
    return np.asarray(np.moveaxis(np.array(rows), 2, 0).reshape(-1, 6))


def carried_twist(frame: Pose, flange: Pose) -> Floats:
    """Return (6, 6) from the twist of a flange, at its point in the axes of the base, to that of a
    frame.

    frame: in the base, fixed to the flange; its twist is at its origin in its axes.
    """
    turn = rotations.to_matrix(np.array(frame.quaternion)).T
    arm = np.array(frame.position) - np.array(flange.position)
    out = np.zeros((6, 6))
    out[:3, :3] = out[3:, 3:] = turn
    out[:3, 3:] = -turn @ cross(arm)
    return out


def cross(vector: Floats) -> Floats:
    """(3, 3) matrix of the vector product from the left."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def turned_by(quaternion: Floats) -> Floats:
    """(3,) radians about its axis, of the shorter way."""
    w, vector = quaternion[0], quaternion[1:]
    if w < 0.0:
        w, vector = -w, -vector
    size = float(np.linalg.norm(vector))
    if size < 1e-12:
        return np.asarray(2.0 * vector)
    return np.asarray(vector / size * 2.0 * np.arctan2(size, w))


def jacobian(robot: Robot, joints: Floats) -> Floats:
    """(6, a) twist of the flange in the base, by a degree (or mm) a second of each axis."""
    out: Floats = np.array(robot.jacobian(joints, unit="deg")[0])
    out[3:] = np.radians(out[3:])
    return out


def flange_of(robot: Robot, joints: Floats) -> Pose:
    place, turn = robot.flange_poses(joints[None])
    return Pose.of(place[0], turn[0])

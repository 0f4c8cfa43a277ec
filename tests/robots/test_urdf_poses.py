"""The catalogue against the joint origins of public URDFs, chained without any of its code."""

from __future__ import annotations

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations

ORIGINS = {
    # ros-industrial/abb_experimental 20b9cf86
    "irb120-3-0.58": ((0, 0, 0), (0, 0, 290), (0, 0, 270), (0, 0, 70), (302, 0, 0), (72, 0, 0)),
    "irb1200-5-0.9": ((0, 0, 399.1), (0, 0, 0), (0, 0, 448), (0, 0, 42), (451, 0, 0), (82, 0, 0)),
    "irb1200-7-0.7": ((0, 0, 399.1), (0, 0, 0), (0, 0, 350), (0, 0, 42), (351, 0, 0), (82, 0, 0)),
    "irb1600-6-1.2": (
        (0, 0, 0), (150, 0, 486.5), (0, 0, 475), (300, 0, 0), (300, 0, 0), (65, 0, 0)),
    "irb2600-12-1.65": (
        (0, 0, 445), (150, 0, 0), (0, 0, 700), (0, 0, 115), (795, 0, 0), (85, 0, 0)),
    "irb4600-20-2.50": (
        (0, 0, 495), (175, 0, 0), (0, 0, 1095), (0, 0, 175), (1230.5, 0, 0), (85, 0, 0)),
    "irb4600-40-2.55": (
        (0, 0, 495), (175, 0, 0), (0, 0, 1095), (0, 0, 175), (1270, 0, 0), (135, 0, 0)),
    "irb4600-60-2.05": (
        (0, 0, 495), (175, 0, 0), (0, 0, 900), (0, 0, 175), (960, 0, 0), (135, 0, 0)),
    "irb6700-200-2.60": (
        (0, 0, 780), (320, 0, 0), (0, 0, 1125), (0, 0, 200), (1142.5, 0, 0), (200, 0, 0)),
    # ros-industrial/abb_experimental c400391a (IRB 140T, the same arm) and 1f2ce986
    "irb140-6-0.81": ((0, 0, 104), (70, 0, 248), (0, 0, 360), (380, 0, 0), (0, 0, 0), (65, 0, 0)),
    "irb2600-12-1.85": (
        (0, 0, 445), (150, 0, 0), (0, 0, 900), (0, 0, 115), (795, 0, 0), (85, 0, 0)),
    # ros-industrial/abb 09a4feed
    "irb1600-10-1.45": (
        (0, 0, 0), (150, 0, 486.5), (0, 0, 700), (300, 0, 0), (300, 0, 0), (65, 0, 0)),
    # isys-vision/abb_experimental 6b851e4c
    "irb6700-150-3.20": (
        (0, 0, 780), (320, 0, 0), (0, 0, 1280), (0, 0, 200), (1592.5, 0, 0), (200, 0, 0)),
    # Mitsubishi-Electric-Asia/melfa_ros2_driver 8a52cd2
    "rv-2fr": ((0, 0, 0), (0, 0, 295), (0, 0, 230), (-50, 0, 0), (0, 0, 270), (0, 0, 70)),
    "rv-4fr": ((0, 0, 0), (0, 0, 350), (0, 0, 235), (-50, 0, 0), (0, 0, 275), (0, 0, 85)),
    "rv-4frl": ((0, 0, 0), (0, 0, 350), (0, 0, 310), (-50, 0, 0), (0, 0, 335), (0, 0, 85)),
    "rv-7frl": ((0, 0, 0), (0, 0, 400), (0, 0, 435), (-50, 0, 0), (0, 0, 470), (0, 0, 85)),
    "rv-8crl": ((0, 0, 0), (0, 0, 390), (0, 0, 450), (-100, 0, 0), (0, 0, 470), (0, 0, 85)),
    "rv-13frl": ((0, 0, 0), (130, 0, 450), (0, 0, 565), (-65, 0, 0), (0, 0, 690), (0, 0, 97)),
    "rh-6frh5520": ((0, 0, 0), (325, 0, 0), (225, 0, 0), (0, 0, 0)),
}  # fmt: skip
"""Robot → origin of each joint in the link before it, in mm; none of them is turned."""
AXES = {"irb": "ZYYXYX", "rv-": "ZYYZYZ", "rh-": "ZZzZ"}
"""Beginning of a name → axis of each joint; a small letter slides."""


def about(axis: str, degrees: float) -> np.ndarray:
    """(4, 4) turn about an axis of its own frame."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    one, two = {"X": (1, 2), "Y": (2, 0), "Z": (0, 1)}[axis]
    out = np.eye(4)
    out[one, one] = out[two, two] = c
    out[two, one], out[one, two] = s, -s
    return out


def along(x: float, y: float, z: float) -> np.ndarray:
    out = np.eye(4)
    out[:3, 3] = x, y, z
    return out


def flange(name: str, joints: np.ndarray) -> np.ndarray:
    """(4, 4) what the URDF says; ABB's tool0 is its last link turned by 90 degrees about Y."""
    out = np.eye(4)
    for origin, axis, joint in zip(ORIGINS[name], AXES[name[:3]], joints, strict=True):
        moved = along(0, 0, joint) if axis.islower() else about(axis, joint)
        out = out @ along(*origin) @ moved
    return out @ about("Y", 90.0) if name.startswith("irb") else out


@pytest.mark.parametrize("name", ORIGINS)
def test_the_flange_is_where_the_urdf_has_it(name: str) -> None:
    robot = robots.get(name)
    joints = np.random.default_rng(7).uniform(*robot.limits.T, (50, len(robot.axes)))
    expected = np.stack([flange(name, row) for row in joints])
    positions, quaternions = robot.fk(joints)
    assert np.abs(positions - expected[:, :3, 3]).max() < 1e-9
    assert np.abs(rotations.to_matrix(quaternions) - expected[:, :3, :3]).max() < 1e-12

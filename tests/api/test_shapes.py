"""Arrays of another shape or type, and arguments of another kind: refused, never reshaped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import assistant
from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.learning.measured_poses import measured_from_columns
from assistant.program.geometry import Pose
from assistant.program.motion import Path, Speed
from assistant.robots.configurations import from_flags, to_confdata
from assistant.robots.retargeting import joints_on_other_arm
from assistant.vision.cameras.camera import Camera, Lens, triangulate

ROBOT = robots.get("irb1200-7-0.7")
CAMERA = Camera("left", Lens((640, 480), (600.0, 600.0), (319.5, 239.5)), Pose((0.0, 0.0, -1000.0)))
OTHER = replace(CAMERA, name="right", pose=Pose((300.0, 0.0, -1000.0)))
POSES = np.tile([500.0, 0.0, 500.0, 0.0, 1.0, 0.0, 0.0], (3, 1))
QUATERNIONS = POSES[:, 3:]


@pytest.mark.parametrize(
    "call",
    [
        lambda: ROBOT.fk(np.zeros((6, 5))),
        lambda: ROBOT.fk(np.zeros((5, 4))),
        lambda: ROBOT.fk(np.zeros((3, 2))),
        lambda: ROBOT.fk(np.ones((3, 6), dtype=complex)),
        lambda: ROBOT.fk(np.ones((3, 6), dtype=bool)),
        lambda: ROBOT.chain(np.zeros((6, 5))),
        lambda: ROBOT.link_frames(np.zeros((6, 5))),
        lambda: ROBOT.configuration(np.zeros((6, 5))),
        lambda: ROBOT.inside(np.zeros((6, 1))),
        lambda: ROBOT.ik(np.zeros((3, 4)), np.ones((3, 4))),
        lambda: ROBOT.ik(np.zeros((3, 3)), np.ones((4, 4))),
        lambda: ROBOT.joints_of(np.zeros((3, 3)), QUATERNIONS, np.zeros((6, 3), dtype=int)),
        lambda: triangulate([CAMERA, OTHER], [np.zeros((2, 3)), np.zeros((2, 3))]),
        lambda: CAMERA.project(np.zeros((3, 4))),
        lambda: CAMERA.directions(np.zeros((2, 3))),
        lambda: to_confdata(np.zeros((3, 2))),
        lambda: to_confdata(np.full((2, 6), 0.5)),
        lambda: from_flags(np.zeros((2, 3))),
        lambda: joints_on_other_arm(np.zeros((6, 5)), ROBOT, ROBOT),
        lambda: Path.of("p", np.zeros((3, 4)), np.zeros((4, 3)), speeds=[Speed(100.0)]),
        lambda: measured_from_columns(np.zeros((4, 6)), np.zeros((3, 4))),
        lambda: assistant.from_poses(POSES.astype(complex), unit="mm"),
        lambda: assistant.from_poses(POSES.astype(bool), unit="mm"),
        lambda: assistant.from_joints(np.zeros((2, 6), bool), unit="deg", robot=ROBOT),
        lambda: assistant.from_joints(np.zeros((2, 6), complex), unit="deg", robot=ROBOT),
        lambda: assistant.from_poses(POSES, unit="mm", blend="coarse"),
        lambda: assistant.from_poses(POSES, unit="mm", blend=[1.0]),
        lambda: assistant.from_poses(POSES, unit="mm", speed="fast"),
        lambda: assistant.from_poses(POSES, unit="mm", speed=True),
        lambda: assistant.from_poses(POSES, unit="mm", process=5),
        lambda: assistant.from_poses(POSES, unit="mm", robot=5),
        lambda: assistant.check(None),
        lambda: assistant.check([None]),
        lambda: assistant.check(b"a.mod"),
        lambda: assistant.load(None),
        lambda: assistant.compile(None, language="rapid"),
        lambda: assistant.translate({}, to="rapid"),
        lambda: assistant.simulate(5, robot=ROBOT),
        lambda: assistant.check("a.pseudo", cell=5),
    ],
)
def test_what_has_another_shape_or_type_is_refused_by_a_finding(call) -> None:
    with pytest.raises(Refused) as refused:
        call()
    assert all(finding.code and finding.cure for finding in refused.value.findings)


def test_single_rows_and_more_dimensions_are_taken_as_rows() -> None:
    joints = np.arange(36.0).reshape(2, 3, 6)
    assert np.array_equal(ROBOT.fk(joints)[0], ROBOT.fk(joints.reshape(6, 6))[0])
    assert np.array_equal(ROBOT.fk(joints[0, 0].tolist())[0], ROBOT.fk(joints[0, :1])[0])
    assert ROBOT.fk([])[0].shape == (0, 3)

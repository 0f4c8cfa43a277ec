"""Arrays of another shape or type, and arguments of another kind: refused, never reshaped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from spatialmath import SE3

import assistant
from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.blocks.diagrams import RealTime
from assistant.blocks.library import arms, sources
from assistant.controllers.cyclic import Limits, Trajectory
from assistant.controllers.recording import Recording
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
        lambda: ROBOT.fk([0.0, 0.0, np.nan, 0.0, 30.0, 0.0]),
        lambda: ROBOT.fk(np.full((2, 6), np.inf)),
        lambda: ROBOT.fk(["1", "2", "3", "4", "5", "6"]),
        lambda: ROBOT.fk(np.ma.masked_array([1.0] * 6, [0, 1, 0, 0, 0, 0])),
        lambda: ROBOT.fk(np.array(["2026-01-01"] * 6, dtype="datetime64[D]")),
        lambda: ROBOT.fk(SE3.Empty()),
        lambda: ROBOT.fk([0.0] * 6, unit="grad"),
        lambda: ROBOT.chain([np.nan] * 6),
        lambda: ROBOT.link_frames([np.nan] * 6),
        lambda: ROBOT.inside("home"),
        lambda: ROBOT.inside([Pose()] * 6),
        lambda: ROBOT.jacobian([0.0] * 6),
        lambda: ROBOT.jacobian([0.0] * 6, unit={"deg": 1}),
        lambda: ROBOT.manipulability([1e308] * 6, unit="rad"),
        lambda: ROBOT.ik(SE3(0.4, 0.0, 0.4), unit=["m"]),
        lambda: ROBOT.joints_of(np.zeros((2, 3)), QUATERNIONS[:2], np.zeros((3, 6), dtype=int)),
        lambda: ROBOT.check("plate.dxf"),
        lambda: robots.solve_program(assistant.from_poses(POSES, unit="mm"), "rv-2aj"),
        lambda: robots.get("irb99"),
        lambda: robots.get(None),
        lambda: assistant.languages.get("fortran"),
        lambda: Pose((1.0, 2.0)),
        lambda: Pose(("a", 0, 0)),
        lambda: Pose((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        lambda: Pose.of([1.0, 2.0], [1.0, 0.0, 0.0, 0.0]),
        lambda: Pose.of_matrix(np.zeros((2, 2))),
        lambda: Pose().offset("up"),
        lambda: Pose().moved([1.0, 2.0]),
        lambda: Pose().interpolate(POSES, 0.5),
        lambda: assistant.pose.of(Pose((0.0, 0.0, 0.0), (2.0, 0.0, 0.0, 0.0))),
        lambda: assistant.pose.read([0.0, 0.0, 0.0, 1e308, 0.0, 0.0], "rotation-vector", unit="m"),
        lambda: assistant.pose.read([[1.0], [2.0, 3.0]], "matrix", unit="mm"),
        lambda: assistant.pose.write(Pose(), "kuka", to_unit=np.zeros((2, 2))),
        lambda: assistant.pose.parse(POSES, "kuka"),
        lambda: assistant.from_joints(np.zeros((2, 6)), unit=["deg"], robot=ROBOT),
        lambda: Trajectory.of_joints(np.zeros((2, 6)), unit=np.zeros(2)),
        lambda: Trajectory.of_joints(np.zeros((2, 6)), unit="rad", robot="rv-2aj"),
        lambda: Trajectory.of_path("seam"),
        lambda: Limits.of_robot("rv-2aj"),
        lambda: Limits.of_robot(ROBOT, "half"),
        lambda: arms.ForwardKinematics("fk", "rv-2aj"),
        lambda: arms.InverseKinematics("ik", "rv-2aj"),
        lambda: arms.SimulatedArm("arm", ROBOT, start=[0.0] * 5),
        lambda: arms.SimulatedArm("arm", ROBOT, lag=np.nan),
        lambda: sources.Constant("one", "seam"),
        lambda: sources.Table("way", [0.0, 1.0], [[1.0], [np.nan]]),
        lambda: sources.Table("way", [1.0, 0.0], [[1.0], [2.0]]),
        lambda: sources.joint_table("way", ROBOT, [0.0, 1.0], np.zeros((2, 5))),
        lambda: sources.PoseToPose("line", SE3(), SE3(), 1.0),
        lambda: sources.PoseToPose("line", Pose(), Pose(), np.nan),
        lambda: RealTime("fast"),
        lambda: Recording({"x": ()}).add("fast"),
        lambda: Recording({"x": ()}).add(),
        lambda: Recording({"x": ()}).column("y"),
    ],
)
def test_what_has_another_shape_or_type_is_refused_by_a_finding(call) -> None:
    with pytest.raises(Refused) as refused:
        call()
    assert all(finding.code and finding.cure for finding in refused.value.findings)


def test_names_that_are_unknown_are_key_errors_too() -> None:
    for call in (lambda: robots.get("irb12"), lambda: assistant.languages.get("rapd")):
        with pytest.raises(KeyError, match=r"^CO00[12]: there is no .* \(did you mean"):
            call()


def test_joints_may_be_radians() -> None:
    joints = np.array([[10.0, 20.0, -15.0, 30.0, 40.0, -50.0]])
    for ours, theirs in zip(
        ROBOT.fk(joints), ROBOT.fk(np.radians(joints), unit="rad"), strict=True
    ):
        assert np.allclose(ours, theirs, atol=1e-9)
    wanted = SE3(np.asarray(ROBOT.to_rtb().fkine(np.radians(joints[0])).A), check=False)
    assert np.allclose(assistant.pose.se3(*ROBOT.fk(joints), unit="m").A, wanted.A, atol=1e-9)
    assert ROBOT.inside(joints[0]).shape == () and ROBOT.inside([]).shape == (0,)


def test_single_rows_and_more_dimensions_are_taken_as_rows() -> None:
    joints = np.arange(36.0).reshape(2, 3, 6)
    assert np.array_equal(ROBOT.fk(joints)[0], ROBOT.fk(joints.reshape(6, 6))[0])
    assert np.array_equal(ROBOT.fk(joints[0, 0].tolist())[0], ROBOT.fk(joints[0, :1])[0])
    assert ROBOT.fk([])[0].shape == (0, 3)

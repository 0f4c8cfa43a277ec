"""Positions of controllers as targets of a file, and motions by hand within the limits."""

from __future__ import annotations

import math

import numpy as np
import pytest

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.compiler.commanded_motion import check_jog, check_position
from assistant.compiler.taught_targets import TargetOptions, teach_target
from assistant.controllers.states import Jog, Position
from assistant.program.geometry import Pose
from assistant.sources import read

FIVE = robots.get("rv-2aj")
SIX = robots.get("irb1200-7-0.7")
BENT = (20.0, 30.0, -40.0, 10.0, 60.0, 15.0)


def position(robot, joints, tool: Pose | None = None) -> Position:
    """What a controller tells of an arm whose tool it knows."""
    positions, quaternions = robot.fk(np.array([joints]))
    pose = Pose.of(positions[0], quaternions[0]) @ (tool or Pose())
    told = dict(zip(robot.axes, joints, strict=True))
    shown = tuple(told.get(f"J{i}") for i in range(1, 7))
    return Position(shown, pose.position, pose.quaternion)


@pytest.mark.parametrize("robot", [FIVE, SIX], ids=lambda robot: robot.name)
def test_a_pose_is_stored_with_the_branch_of_the_arm(tmp_path, robot):
    joints = robot.own_joints(BENT) if robot is SIX else (10.0, 20.0, 90.0, 30.0, 0.0)
    file = tmp_path / "points.toml"
    teach_target(file, "there", position(robot, joints), robot, TargetOptions())
    program = read(file).program
    stored = program.targets["there"]
    assert program.robot == robot.name and stored.configuration is not None
    columns = robot.configuration(np.array([joints]))
    pose = stored.pose
    back = robot.joints_of([pose.position], [pose.quaternion], columns)[0]
    assert np.abs(back - np.array(joints)).max() < 0.01


def test_joints_are_stored_with_a_gap_for_the_axis_that_is_not_there(tmp_path):
    file = tmp_path / "points.toml"
    joints = (10.0, 20.0, 90.0, 30.0, 0.5)
    teach_target(file, "there", position(FIVE, joints), FIVE, TargetOptions(joints=True))
    stored = read(file).program.joint_targets["there"].joints
    assert [j for j in stored if not math.isnan(j)] == list(joints) and math.isnan(stored[3])


def test_without_a_robot_only_the_pose_is_known(tmp_path):
    file = tmp_path / "points.toml"
    teach_target(file, "there", position(SIX, BENT), None, TargetOptions())
    stored = read(file).program
    assert stored.targets["there"].configuration is None and stored.robot is None
    with pytest.raises(Refused) as refused:
        teach_target(file, "here", position(SIX, BENT), None, TargetOptions(joints=True))
    assert refused.value.findings[0].code == "TB512"


GRIPPER = Pose((0.0, 0.0, 60.0))
WITH_TOOL = "[tools.gripper]\ntip = [0, 0, 60]\n[frames.table]\nposition = [100, 0, 0]\n"
WITH_TOOL += "euler_zyx = [0, 0, 0]\n"


def test_a_pose_of_another_tool_is_refused(tmp_path):
    file = tmp_path / "points.toml"
    file.write_text(WITH_TOOL, encoding="utf-8")
    shown = position(SIX, BENT, GRIPPER)
    with pytest.raises(Refused) as refused:
        teach_target(file, "there", shown, SIX, TargetOptions())
    (finding,) = refused.value.findings
    assert finding.code == "CO701" and "60.00 mm" in finding.message
    assert file.read_text(encoding="utf-8") == WITH_TOOL
    teach_target(file, "there", shown, SIX, TargetOptions(tool="gripper"))
    with pytest.raises(Refused):
        teach_target(file, "on_table", shown, SIX, TargetOptions(tool="gripper", frame="table"))
    x, y, z = shown.position
    moved = Position(shown.joints, (x - 100.0, y, z), shown.quaternion)
    teach_target(file, "on_table", moved, SIX, TargetOptions(tool="gripper", frame="table"))
    assert set(read(file).program.targets) == {"there", "on_table"}


def test_the_tool_of_a_process_file_beside_counts(tmp_path):
    (tmp_path / "points.process.toml").write_text(
        WITH_TOOL + '[motion]\ntool = "gripper"\n', encoding="utf-8"
    )
    teach_target(
        tmp_path / "points.toml", "there", position(SIX, BENT, GRIPPER), SIX, TargetOptions()
    )
    with pytest.raises(Refused):
        teach_target(tmp_path / "points.toml", "bare", position(SIX, BENT), SIX, TargetOptions())


def test_the_joints_of_another_arm(tmp_path):
    for robot, shown in ((FIVE, position(SIX, BENT)), (SIX, position(FIVE, FIVE.home))):
        with pytest.raises(Refused) as refused:
            teach_target(tmp_path / "points.toml", "there", shown, robot, TargetOptions())
        assert refused.value.findings[0].code == "CO702"
    assert list(tmp_path.iterdir()) == []


def test_a_pose_without_numbers(tmp_path):
    shown = Position((), (math.nan, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
    with pytest.raises(Refused) as refused:
        teach_target(tmp_path / "points.toml", "there", shown, None, TargetOptions())
    assert refused.value.findings[0].code == "CO704"


@pytest.mark.parametrize(
    ("jog", "code"),
    [
        (Jog("J1", 50.0), None),
        (Jog("J1", 151.0), "CO711"),
        (Jog("J5", -200.0), "CO711"),
        (Jog("X", 20.0), None),
        (Jog("X", 2000.0), "CO713"),
        (Jog("Z", -2000.0), "CO713"),
        (Jog("A", 20.0), None),
        (Jog("C", 400.0), "CO713"),
        (Jog("Z", -30.0, frame="tool"), None),
        (Jog("Z", 2000.0, frame="tool"), "CO713"),
        (Jog("J7", 1.0), "CO712"),
    ],
)
def test_a_jog_stays_within_the_limits(jog, code):
    shown = position(SIX, BENT, GRIPPER)
    if code is None:
        assert check_jog(jog, shown, SIX) == ()
        return
    with pytest.raises(Refused) as refused:
        check_jog(jog, shown, SIX)
    assert [finding.code for finding in refused.value.findings] == [code]


@pytest.mark.parametrize(
    ("jog", "code"),
    [
        (Jog("Y", 60.0), None),
        (Jog("X", 1000.0), "CO713"),
        (Jog("A", 30.0), None),
        (Jog("B", -20.0), None),
        (Jog("B", 120.0), "CO713"),
        (Jog("C", 1.0), "CO712"),
    ],
)
def test_an_arm_of_five_axes_keeps_its_tool_in_its_plane(jog, code):
    shown = position(FIVE, (10.0, 20.0, 90.0, 30.0, 0.0))
    if code is None:
        assert check_jog(jog, shown, FIVE) == ()
        return
    with pytest.raises(Refused) as refused:
        check_jog(jog, shown, FIVE)
    assert [finding.code for finding in refused.value.findings] == [code]


def test_where_no_robot_is_known_that_is_said():
    shown = position(SIX, BENT)
    assert [f.code for f in check_jog(Jog("J1", 500.0), shown, None)] == ["CO714"]
    assert [f.code for f in check_position(shown, None)] == ["CO714"]


def test_an_arm_outside_of_its_limits_is_another_arm():
    assert check_position(position(SIX, BENT), SIX) == ()
    joints = (*BENT[:4], SIX.limits[4, 1] + 1.0, BENT[5])
    with pytest.raises(Refused) as refused:
        check_position(position(SIX, joints), SIX)
    assert refused.value.findings[0].code == "CO715"

"""Poses that tell nothing, and poses that are read wrongly: a diagnostic each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.learning.arm_calibration import calibrate
from assistant.learning.measured_poses import measured_from_columns, read_measured
from assistant.learning.parameter_fit import KnownPlacement
from assistant.program.geometry import IDENTITY
from tests.learning.calibration.truth import drawn, joints_of, points_of, quaternions_of

ARM = "irb1200-5-0.9"


@pytest.fixture
def truth():
    return drawn(ARM, 3)


@pytest.fixture
def joints():
    return joints_of(ARM, 40, 3)


def refused(poses, robot=ARM, **more):
    with pytest.raises(Refused) as found:
        calibrate(robots.get(robot), poses, **more)
    return found.value.findings[0]


def test_too_few_poses_say_how_many_are_needed(truth, joints):
    few = joints[:8]
    finding = refused(measured_from_columns(few, points_of(truth, few)))
    assert finding.code == "LN103"
    assert "at least 11" in finding.cure


def test_poses_that_are_all_alike(truth, joints):
    alike = joints[:1] + np.random.default_rng(0).uniform(-0.2, 0.2, joints.shape)
    assert refused(measured_from_columns(alike, points_of(truth, alike))).code == "LN104"


def test_joints_that_are_radians(truth, joints):
    finding = refused(measured_from_columns(np.radians(joints), points_of(truth, joints)))
    assert finding.code == "LN107"
    assert "radians" in finding.message


@pytest.mark.parametrize(
    ("factor", "unit"), [(0.001, "points are m"), (0.1, "cm"), (1 / 25.4, "inches")]
)
def test_points_in_another_unit(truth, joints, factor, unit):
    finding = refused(measured_from_columns(joints, points_of(truth, joints) * factor))
    assert finding.code == "LN107"
    assert unit in finding.message


@pytest.mark.parametrize("order", [[1, 0, 2], [0, 2, 1], [2, 1, 0]])
def test_points_whose_columns_are_swapped_are_mirrored(truth, joints, order):
    finding = refused(measured_from_columns(joints, points_of(truth, joints)[:, order]))
    assert finding.code == "LN107"
    assert "mirrored" in finding.message


def test_points_of_a_left_handed_frame_are_mirrored(truth, joints):
    finding = refused(measured_from_columns(joints, points_of(truth, joints) * (1.0, -1.0, 1.0)))
    assert finding.code == "LN107"
    assert "mirrored" in finding.message


def test_columns_in_another_order_are_named_where_the_base_is_known(truth, joints):
    here = replace(truth, base=np.eye(4))
    points = points_of(here, joints)[:, [1, 2, 0]]
    finding = refused(measured_from_columns(joints, points), known=KnownPlacement(IDENTITY))
    assert finding.code == "LN107"
    assert "order z x y" in finding.message


def test_joints_whose_columns_are_swapped(truth, joints):
    swapped = joints.copy()
    swapped[:, [2, 4]] = np.clip(joints[:, [4, 2]], -90.0, 60.0)
    within = replace_rows(joints, swapped)
    finding = refused(measured_from_columns(swapped[within], points_of(truth, joints)[within]))
    assert finding.code == "LN107"
    assert "J3 and J5 are swapped" in finding.message


def replace_rows(joints, swapped):
    """Rows in which nothing had to be clipped."""
    return (swapped[:, [2, 4]] == joints[:, [4, 2]]).all(axis=1)


def test_a_joint_that_counts_the_other_way(truth, joints):
    points = points_of(truth, joints)
    finding = refused(measured_from_columns(joints * (1, 1, 1, -1, 1, 1), points))
    assert finding.code == "LN107"
    assert "J4 counts the other way" in finding.message


def test_quaternions_with_w_last(truth, joints):
    turns = np.roll(quaternions_of(truth, joints), -1, axis=1)
    finding = refused(measured_from_columns(joints, points_of(truth, joints), turns))
    assert finding.code == "LN107"
    assert "w last" in finding.message


def test_the_poses_of_another_robot_name_it(truth, joints):
    low, high = robots.get("irb120-3-0.58").limits.T
    some = ((joints > low) & (joints < high)).all(axis=1)
    finding = refused(
        measured_from_columns(joints[some], points_of(truth, joints[some])), "irb120-3-0.58"
    )
    assert finding.code == "LN108"
    assert "irb1200-5-0.9" in finding.message


def test_points_that_no_arm_explains(joints):
    points = np.random.default_rng(0).uniform(-500.0, 500.0, (20, 3))
    assert refused(measured_from_columns(joints[:20], points)).code in ("LN109", "LN111")


def test_more_rows_are_wild_than_a_fit_bears(truth, joints):
    points = points_of(truth, joints)
    points[26:] += np.random.default_rng(0).uniform(-400.0, 400.0, (14, 3))
    assert refused(measured_from_columns(joints, points)).code == "LN111"


def test_what_moved_meanwhile_is_told_with_the_row(truth, joints):
    points = points_of(truth, joints)
    points[24:] += (4.0, 1.0, 0.0)
    done = calibrate(robots.get(ARM), measured_from_columns(joints, points))
    (told,) = (one.message for one in done.findings if one.code == "LN123")
    assert "from row 25 on" in told


def test_joints_outside_the_limits_name_row_and_axis(truth, joints):
    joints[6, 2] = 95.0
    finding = refused(measured_from_columns(joints, points_of(truth, joints)))
    assert finding.code == "LN106"
    assert "J3 is 95 in row 7" in finding.message


def test_rows_without_numbers_are_left_out_and_told(truth, joints):
    points = points_of(truth, joints)
    points[[3, 8]] = np.nan
    done = calibrate(robots.get(ARM), measured_from_columns(joints, points))
    (told,) = (one for one in done.findings if one.code == "LN102")
    assert "row 4, 9 is left out" in told.message
    assert len(done.measured) == 38


def test_columns_of_different_lengths_are_a_mistake_of_the_caller(joints):
    with pytest.raises(ValueError, match="for each pose"):
        measured_from_columns(joints, np.zeros((3, 3)))


HEADER = "j1_deg,j2_deg,j3_deg,j4_deg,j5_deg,j6_deg,x_mm,y_mm,z_mm"


@pytest.mark.parametrize(
    ("text", "code", "said"),
    [
        ("", "IN005", "empty"),
        ("\n\n", "LN100", "missing"),
        ("j1,j2,j3,x,y,z\n", "LN100", "no column `j1_deg`"),
        (HEADER.replace(",j6_deg", ""), "LN100", "no column `j6_deg`"),
        (HEADER.replace("j6_deg", "j6_deg,j7_deg"), "LN100", "7 joints"),
        (HEADER.replace(",z_mm", ""), "LN100", "no column `z_mm`"),
        (HEADER.replace("z_mm", "x_mm"), "LN100", "`x_mm` twice"),
        (HEADER + ",x_m", "LN100", "`x_mm` and `x_m`"),
        (HEADER + ",q_w,q_x,q_y", "LN100", "`q_w` but no `q_z`"),
        (HEADER + "\n1,2,3,4,5,6,a,8,9", "LN101", "`x_mm` holds `a`"),
        (HEADER + "\n1,2,3,4,5,6,inf,8,9", "LN101", "`inf`"),
        (HEADER + ",q_w,q_x,q_y,q_z\n1,2,3,4,5,6,7,8,9,2,0,0,0", "LN101", "length 2"),
        (HEADER.replace("x_mm,y_mm,z_mm", "left_u_px,left_v_px"), "LN118", "no cameras"),
        (HEADER.replace("x_mm,y_mm,z_mm", "left_u_px"), "LN100", "only one of `left_u_px`"),
    ],
)
def test_files_that_are_no_measured_poses(tmp_path, text, code, said):
    file = tmp_path / "measured.csv"
    file.write_text(text)
    with pytest.raises(Refused) as found:
        read_measured(file, robots.get(ARM))
    (finding,) = found.value.findings
    assert finding.code == code
    assert said in finding.message
    assert finding.path == str(file)


def test_units_of_the_header_and_other_separators_are_taken(tmp_path, truth, joints):
    points = points_of(truth, joints)
    file = tmp_path / "measured.csv"
    names = [*(f"J{i}_rad" for i in range(1, 7)), "x_m", "y_m", "z_m", "_remark", "name"]
    rows = [
        [*map(repr, (*np.radians(j).tolist(), *(p / 1000).tolist())), "a", "b"]
        for j, p in zip(joints, points, strict=True)
    ]
    file.write_text("\n".join(";".join(row) for row in [names, *rows, [""]]))
    poses = read_measured(file, robots.get(ARM))
    assert poses.joints == pytest.approx(joints)
    assert poses.points == pytest.approx(points)
    assert poses.rows.tolist() == list(range(1, 41))


@pytest.mark.parametrize(
    ("robot", "estimate", "code"), [("urdf", "lengths", "LN117"), ("coupled", "chain", "LN122")]
)
def test_what_the_file_of_a_robot_cannot_say(truth, joints, robot, estimate, code):
    arm = robots.get(ARM)
    other = replace(arm, coupling=-1.0)
    if robot == "urdf":
        from assistant.robots.arms import Serial

        chain = arm.arm.whole_chain
        other = replace(arm, arm=Serial(chain.joints, chain.flange))
    with pytest.raises(Refused) as found:
        calibrate(other, measured_from_columns(joints, points_of(truth, joints)), estimate=estimate)
    assert found.value.findings[0].code == code
    assert found.value.exit_status == 2

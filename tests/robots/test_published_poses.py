"""Joints and poses that others measured or published, forwards and backwards."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.languages.melfa_basic.tables.poses import to_values
from assistant.robots import Robot
from assistant.robots.arms import Lengths, SixAxis
from assistant.robots.configurations import to_confdata


@dataclass(frozen=True)
class Pair:
    """Joints and the flange that belongs to them, both as printed.

    quaternion: of the flange, or None where the source has none. source: who published it.
    place: mm that the printed decimals of joints and position allow.
    """

    robot: str
    joints: tuple[float, ...]
    position: tuple[float, float, float]
    quaternion: tuple[float, ...] | None
    source: str
    place: float = 0.01

    def __str__(self) -> str:
        return f"{self.robot}-{'_'.join(f'{joint:g}' for joint in self.joints)}"


def rpy(*angles: float) -> tuple[float, ...]:
    """The quaternion of printed roll, pitch, yaw: R = Rz·Ry·Rx."""
    return tuple(float(v) for v in rotations.from_euler(angles[::-1], "ZYX"))


HALF = float(np.sqrt(0.5))
LEVEL, DOWN_30, DOWN = (HALF, 0, HALF, 0), (0.5, 0, 0.866025404, 0), (0.0, 0, 1, 0)
URDF = "ROS-Industrial URDF, tool0"
STUDIO = "RobotStudio export"
MEASURED = "Susta79/RF210001, README"
PAIRS = (
    Pair("irb1200-7-0.7", (0,) * 6, (433, 0, 791.1), LEVEL, URDF),
    Pair("irb1200-7-0.7", (0, 0, 0, 0, 30, 0), (422.014, 0, 750.1), DOWN_30, STUDIO),
    Pair("irb1200-7-0.7", (0, 0, 0, 0, 90, 0), (351, 0, 709.1), DOWN, URDF),
    Pair("irb1200-5-0.9", (0,) * 6, (533, 0, 889.1), LEVEL, URDF),
    Pair("irb1200-5-0.9", (0, 0, 0, 0, 30, 0), (522.014, 0, 848.1), DOWN_30, STUDIO),
    Pair("irb120-3-0.58", (0,) * 6, (374, 0, 630), LEVEL, URDF),
    Pair("irb120-3-0.58", (0, 0, 0, 0, 30, 0), (364.354, 0, 594), DOWN_30, STUDIO),
    Pair("irb140-6-0.81", (0, 0, 0, 0, 30, 0), (506.291651, 0, 679.5), DOWN_30, STUDIO, 1e-6),
    Pair("irb4600-20-2.50", (0,) * 6, (1490.5, 0, 1765), LEVEL, MEASURED),
    Pair("irb4600-20-2.50", (90, 0, 0, 0, 0, 0), (0, 1490.5, 1765), None, MEASURED),
    Pair("irb4600-20-2.50", (45,) * 6, (734.88, 794.99, -21.32),
         rpy(-144.74, -30.0, 125.26), MEASURED),
    Pair("irb4600-20-2.50", (-45,) * 6, (-547.50, 607.60, 2559.89),
         rpy(35.26, -30.0, -144.74), MEASURED),
    Pair("rv-2a", (0, 0, 90, 0, 90, 0), (350, 0, 645), rpy(180, 0, 180), "hmu.melfa_robot.py"),
    Pair("rv-6s", (0, 0, 90, 0, 90, 0), (400, 0, 645), rpy(180, 0, 180), "ctu-mitsubishi, home"),
    Pair("rv-2aj", (0, 21.19, 72.78, 86.03, 0), (250, 0, 450), rpy(180, 0, 180),
         "JPOSF and PPOSF in alexandremstf/ros_mitsubishi", 0.03),
    Pair("rv-2aj", (-107.756, 32.1796, 104.1809, 42.9295, 66.1123), (-74.55, -232.81, 323.81),
         None, "Rodchi, RV_2AJ_Main.m"),
)  # fmt: skip

pairs = pytest.mark.parametrize("pair", PAIRS, ids=str)


@pairs
def test_the_pose_of_published_joints(pair: Pair) -> None:
    p, q = robots.get(pair.robot).fk([pair.joints])
    assert p[0] == pytest.approx(pair.position, abs=pair.place)
    if pair.quaternion is not None:
        assert rotations.angle_between(q[0], np.array(pair.quaternion)) < 0.011


@pairs
def test_the_joints_of_a_published_pose(pair: Pair) -> None:
    robot = robots.get(pair.robot)
    _, q = robot.fk([pair.joints])
    turned = q if pair.quaternion is None else np.array([pair.quaternion])
    if robot.five_axis:
        turned = q  # the printed position is beside the plane of the printed angles
    found = robot.joints_of([pair.position], turned, robot.configuration([pair.joints]))
    in_line = robot.arm.spherical and pair.joints[4] == 0
    compared = [0, 1, 2, 4] if in_line else range(len(robot.axes))
    expected = np.array(pair.joints, dtype=float)
    assert found[0, compared] == pytest.approx(expected[compared], abs=0.03)


@pytest.mark.parametrize(
    ("joints", "a", "b"),
    [
        ((0, 21.19, 72.78, 86.03, 0), 0.0, 180.0),
        ((-107.756, 32.1796, 104.1809, 42.9295, 66.1123), 173.86, 179.29),
    ],
)
def test_the_angles_that_an_rv_2aj_shows(joints, a: float, b: float) -> None:
    """The second of Rodchi's program: tool down, A = J6 - J1."""
    robot = robots.get("rv-2aj")
    values = to_values(*robot.fk([joints]), np.full((1, 6), np.nan), robot)[0]
    assert values[4] == pytest.approx(b, abs=0.01)
    assert (values[3] - a + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=0.02)


def test_an_rv_2a_with_a_hand_of_100_mm() -> None:
    """Answers to JPOSF and PPOSF in the comments of one MATLAB client of an RV-2A."""
    p, q = robots.get("rv-2a").fk([[-0.01, 8.15, 68.99, 0.03, 12.89, 0.0]])
    tip = p[0] + 100.0 * rotations.to_matrix(q)[0, :, 2]
    # Half of the last decimal of a joint is 0.07 mm at the tip.
    assert tip == pytest.approx([535.21, -0.03, 779.78], abs=0.07)


# CalcRobT of RobotStudio on an IRB 6700-140/2.85 with a flange of 350 mm, measured by
# LeroyDu56/CrossArm (docs/validation.md, section 3): joints, confdata, position of tool0.
MEASURED_CONFDATA = (
    ((0, 0, 0, 0, -90, 0), (0, 0, 0, 1), (1712.5, 0, 2455)),
    ((0, 0, 0, 0, 90, 0), (0, 0, 0, 0), (1712.5, 0, 1755)),
    ((0, 0, 0, 185, -90, 0), (0, 2, 0, 1), (1712.5, 30.505, 1756.332)),
    ((0, 0, 0, -185, -90, 0), (0, -3, 0, 1), (1712.5, -30.505, 1756.332)),
    ((0, 0, 0, 0, -90, 190), (0, 0, 2, 1), (1712.5, 0, 2455)),
    ((0, 0, 0, 0, -90, -190), (0, 0, -3, 1), (1712.5, 0, 2455)),
    ((0, 0, 0, 0, -90, 350), (0, 0, 3, 1), (1712.5, 0, 2455)),
    ((0, 40, 60, 0, -90, 0), (0, 0, 0, 1), (1342.975, 0, 174.949)),
    ((0, 40, -60, 0, -90, 0), (0, 0, 0, 1), (2163.547, 0, 2634.894)),
    ((0, -60, -80, 0, -90, 0), (0, 0, 0, 5), (-2074.529, 0, 1816.257)),
    ((90, 0, 0, 0, -90, 0), (1, 0, 0, 1), (0, 1712.5, 2455)),
    ((-150, 0, 0, 0, -90, 0), (-2, 0, 0, 1), (-1483.068, -856.25, 2455)),
)


def irb6700_of_robotstudio() -> Robot:
    """The catalogue's arm with the lengths of the one that was measured."""
    lengths = Lengths(d1=780, a1=320, a2=1125, a3=-200, d4=1392.5, d6=350)
    return replace(robots.get("irb6700-150-3.20"), arm=SixAxis(lengths))


@pytest.mark.parametrize(("joints", "confdata", "position"), MEASURED_CONFDATA)
def test_confdata_that_robotstudio_computes(joints, confdata, position) -> None:
    robot = irb6700_of_robotstudio()
    assert robot.fk([joints])[0][0] == pytest.approx(position, abs=1e-3)
    assert to_confdata(robot.configuration([joints]))[0].tolist() == list(confdata)


def test_the_elbow_bit_changes_at_the_angle_that_was_measured() -> None:
    robot = irb6700_of_robotstudio()
    joints = [[0, 0, -81.83 + d, 0, -90, 0] for d in (0.01, -0.01)]
    assert to_confdata(robot.configuration(joints))[:, 3].tolist() == [1, 3]

"""The SCARA: which side its arm is on, its slide in mm, and what it cannot do."""

from __future__ import annotations

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.program.expressions import JointValue
from assistant.program.geometry import JointTarget
from assistant.program.motion import FINE, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow, Motion, MoveJoints, Statement
from assistant.robots.configurations import to_flags

ARM = robots.get("rh-6frh5520")


def program(statement: Statement) -> Program:
    return Program("p", (Procedure("main", (statement,)),))


def path(positions, quaternions) -> Path:
    return Path.of("seam", np.array(positions), np.array(quaternions), speeds=[Speed(100.0)])


def test_the_stretched_arm_and_the_elbow_at_a_right_angle() -> None:
    p, q = ARM.fk([[0, 0, 200, 0], [0, 90, 150, -90], [30, 0, 140, 15]])
    assert p[0] == pytest.approx([550, 0, 200])
    assert p[1] == pytest.approx([325, 225, 150])
    upright = np.sin(np.radians(22.5))
    assert q[[0, 1]] == pytest.approx(np.tile([1, 0, 0, 0], (2, 1)))
    assert q[2] == pytest.approx([np.cos(np.radians(22.5)), 0, 0, upright])


def test_right_and_left_are_bit_two_of_flag_one() -> None:
    joints = np.array([[10, -50, 200, 0], [10, 50, 200, 0], [10, -50, 200, 250]])
    assert to_flags(ARM.configuration(joints)).tolist() == [[4, 0], [0, 0], [4, 0x1000]]


def test_a_path_gets_its_side_and_keeps_it() -> None:
    y = np.linspace(-200, 200, 101)
    seam = path(np.c_[350 + 0 * y, y, 250 + y / 10], np.tile([1.0, 0, 0, 0], (101, 1)))
    out, findings = robots.configure(program(Follow(seam)), ARM)
    done = out.procedures[0].body[0].path
    assert not findings
    assert np.unique(to_flags(done.configurations)[:, 0]).tolist() == [4]
    joints = ARM.joints_of(done.positions, done.quaternions, done.configurations)
    assert (joints[:, 1] < 0).all()
    assert joints[:, 2] == pytest.approx(250 + y / 10)


def test_a_tool_that_hangs_is_told_of() -> None:
    tilted = rotations.about((1.0, 0.0, 0.0), 5.0)
    seam = path([[350.0, 0, 200], [350.0, 10, 200]], [[1.0, 0, 0, 0], tilted])
    (finding,) = ARM.check(program(Follow(seam)))
    assert finding.code == "RB116"
    assert "5.000 degrees (seam_2)" in finding.message


def test_heights_and_reach_in_millimetres() -> None:
    seam = path(
        [[350.0, 0, 350], [350.0, 10, 400], [600.0, 0, 200]], np.tile([1.0, 0, 0, 0], (3, 1))
    )
    reach, limits = ARM.check(program(Follow(seam)))
    assert reach.code == "RB102" and "50.0 mm too far out (seam_3)" in reach.message
    assert limits.code == "RB103" and "J3 would be at 400.00 mm, its limit is 333" in limits.message
    move = MoveJoints(JointValue(JointTarget((0.0, 0.0, 120.0, 0.0))), Motion(Speed(100.0), FINE))
    (finding,) = ARM.check(program(move))
    assert finding.code == "RB109" and "J3 at 120 mm is outside" in finding.message

"""Robots of roboticstoolbox as ours; its own forward kinematics says whether they are right."""

from __future__ import annotations

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.program.se3 import se3_of

rtb = pytest.importorskip("roboticstoolbox")
SE3 = pytest.importorskip("spatialmath").SE3
IRB = robots.get("irb1200-7-0.7")
ARMS = {
    "puma": rtb.models.DH.Puma560,
    "stanford, which slides": rtb.models.DH.Stanford,
    "cobra, a scara": rtb.models.DH.Cobra600,
    "puma of elementary transforms": rtb.models.ETS.Puma560,
    "panda, seven axes": rtb.models.ETS.Panda,
    "ours": IRB.to_rtb,
}


@pytest.mark.parametrize("make", ARMS.values(), ids=ARMS)
def test_forward_kinematics_are_those_of_the_toolbox(make):
    arm = make()
    made = robots.from_rtb(arm, np.full(arm.n, 100.0))
    low, high = made.limits.T
    joints = np.random.default_rng(3).uniform(low, high, (50, len(low)))
    units = np.where(made.sliding, 1e-3, np.radians(1.0))
    theirs = np.stack([one.A for one in map(arm.fkine, joints * units)])
    assert np.array(se3_of(*made.fk(joints), unit="m").A) == pytest.approx(theirs, abs=1e-9)
    assert (made.limits.T * units) == pytest.approx(arm.qlim, abs=1e-12)


def test_base_and_tool_of_elementary_transforms_count():
    arm = rtb.models.ETS.Panda()
    arm.base, arm.tool = SE3(0.1, 0.2, 0.3) * SE3.Rz(0.4), SE3(0.0, 0.0, 0.12)
    made = robots.from_rtb(arm, np.full(7, 100.0))
    place = made.fk(np.full(7, 20.0))[0][0] / 1000.0
    assert place == pytest.approx(arm.fkine(np.radians(np.full(7, 20.0))).t, abs=1e-9)


def test_base_and_tool_count_and_a_spherical_wrist_is_in_closed_form():
    arm = IRB.to_rtb()
    arm.base, arm.tool = SE3(0.1, 0.2, 0.3) * SE3.Rz(0.4), SE3(0.0, 0.0, 0.12) * SE3.Rz(0.2)
    made = robots.from_rtb(arm, IRB.speeds)
    assert made.arm.kind == IRB.arm.kind and made.branches == IRB.branches
    joints = np.random.default_rng(4).uniform(-60.0, 60.0, (20, 6))
    theirs = np.stack([one.A for one in map(arm.fkine, np.radians(joints))])
    positions, turns = made.fk(joints)
    assert positions / 1000.0 == pytest.approx(theirs[:, :3, 3], abs=1e-9)
    assert np.abs(rotations.to_matrix(turns) - theirs[:, :3, :3]).max() < 1e-9
    found, valid = made.ik(positions, turns)
    there = np.where(valid[..., None], found, np.inf)
    assert np.abs(there - joints[:, None]).max(axis=2).min(axis=1).max() < 1e-6


def test_what_is_assumed_is_told():
    made = robots.from_rtb(rtb.models.DH.Puma560(), np.full(6, 100.0))
    assert [one.code for one in made.findings] == ["RB011"]
    assert "numerically" in made.findings[0].message and made.name == "puma-560"


@pytest.mark.parametrize(
    ("give", "speeds"),
    [
        (lambda: 7, [1.0]),
        (rtb.models.DH.Puma560, [1.0, 2.0]),
        (rtb.models.DH.Puma560, [0.0] * 6),
        (lambda: rtb.DHRobot([rtb.RevoluteDH(a=1.0, qlim=[-np.inf, np.inf])]), [1.0]),
    ],
    ids=["a number", "two speeds", "no speed", "no limits"],
)
def test_what_is_no_chain_with_limits_is_refused(give, speeds):
    with pytest.raises(Refused, match="RB010"):
        robots.from_rtb(give(), speeds)

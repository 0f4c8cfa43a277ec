"""Kinematics, sources and arms as blocks, beside other libraries and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from assistant import robots, simulate
from assistant.base.diagnostics import Refused
from assistant.blocks.diagrams import Diagram, run
from assistant.blocks.library.arms import (
    NEAREST_BRANCH,
    ArmMotion,
    ForwardKinematics,
    InverseKinematics,
    Jacobian,
    Resolved,
    SimulatedArm,
)
from assistant.blocks.library.sources import Constant, PoseToPose, Table, joint_table, trapezoid
from assistant.program.geometry import Pose
from assistant.robots.timing import drive_of

IRB = robots.get("irb1200-7-0.7")
TOOL = Pose((0.0, 0.0, 60.0))
DOWN = (0.0, 1.0, 0.0, 0.0)


def test_a_line_of_poses_goes_through_joints_and_back() -> None:
    diagram = Diagram()
    start, end = Pose((420.0, -60.0, 360.0), DOWN), Pose((420.0, 140.0, 300.0), DOWN)
    line = diagram.add(PoseToPose("line", start, end, 1.0))
    nearest = diagram.add(Constant("nearest", NEAREST_BRANCH))
    inverse = diagram.add(InverseKinematics("inverse", IRB, TOOL))
    forward = diagram.add(ForwardKinematics("forward", IRB, TOOL))
    diagram.wire((line, "pose"), (inverse, "pose"))
    diagram.wire(nearest, (inverse, "branch"))
    diagram.wire((inverse, "joints"), forward)
    ran = run(diagram, 1.0, 0.01)
    assert (ran["inverse.valid"] == 1.0).all()
    assert np.abs(ran["forward.pose"] - ran["line.pose"]).max() < 1e-9
    assert np.abs(np.diff(ran["inverse.joints"], axis=0)).max() < 2.0  # it stays in its branch
    assert ran["line.pose"][-1, :3] == pytest.approx(end.position)


def test_every_branch_is_given_and_one_may_be_chosen() -> None:
    diagram = Diagram()
    pose = diagram.add(Constant("there", [420.0, -60.0, 360.0, *DOWN]))
    branch = diagram.add(Table("branch", np.arange(9.0), np.arange(9.0)))
    inverse = diagram.add(InverseKinematics("inverse", IRB, TOOL))
    diagram.wire(pose, (inverse, "pose"))
    diagram.wire((branch, "value"), (inverse, "branch"))
    ran = run(diagram, 8.0, 1.0)
    which = ran["inverse.which"][0]
    assert ran["inverse.valid"][:8] == pytest.approx(which)
    assert ran["inverse.valid"][8] == 0.0  # there is no ninth one
    for number in np.flatnonzero(which):
        branches = ran["inverse.all"][number].reshape(8, 6)
        assert ran["inverse.joints"][number] == pytest.approx(branches[number])


def test_the_jacobian_is_that_of_roboticstoolbox() -> None:
    model, joints = IRB.to_rtb(), np.array([20.0, 30.0, -10.0, 40.0, 50.0, 60.0])
    diagram = Diagram()
    diagram.wire(diagram.add(Constant("at", joints, "deg")), diagram.add(Jacobian("j", IRB)))
    ours = run(diagram, 0.0, 0.01)["j.jacobian"].reshape(6, 6)
    theirs = model.jacob0(np.radians(joints))
    assert ours[:3] == pytest.approx(1000.0 * np.radians(theirs[:3]), abs=1e-6)
    assert ours[3:] == pytest.approx(theirs[3:], abs=1e-8)


def test_the_motion_of_a_program_leads_a_simulated_arm() -> None:
    done = simulate("samples/plate.dxf", robot="irb1200-7-0.7").simulation.samples
    diagram = Diagram()
    motion = diagram.add(joint_table("plate", IRB, done.t, done.joints))
    arm = diagram.add(SimulatedArm("arm", IRB, start=done.joints[0]))
    diagram.wire((motion, "joints"), arm)
    ran = run(diagram, float(done.t[-1]), 0.01)
    assert not ran["arm.limited"].any()
    behind = ran["arm.joints"][1:] - ran["plate.joints"][:-1]
    assert np.abs(behind).max() < 1e-9  # it is where it was told to be a step before


def test_an_arm_that_is_asked_for_too_much_keeps_its_limits() -> None:
    diagram = Diagram()
    wanted = diagram.add(Constant("far", [500.0, 0.0, 0.0, 0.0, 30.0, 0.0], "deg"))
    arm = diagram.add(SimulatedArm("arm", IRB))
    diagram.wire(wanted, arm)
    ran = run(diagram, 2.0, 0.004)
    joints = ran["arm.joints"]
    assert (np.abs(np.diff(joints, axis=0)) <= 0.004 * IRB.speeds + 1e-9).all()
    assert joints[-1, 0] == pytest.approx(IRB.limits[0, 1])
    assert ran["arm.limited"][-1] == 1.0


def test_a_lag_of_the_first_order_is_exact_at_each_step() -> None:
    diagram = Diagram()
    goal = IRB.home + np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    arm = diagram.add(SimulatedArm("arm", IRB, lag=0.1))
    diagram.wire(diagram.add(Constant("goal", goal, "deg")), arm)
    ran = run(diagram, 0.5, 0.01)
    rest = goal[0] - ran["arm.joints"][:, 0]
    assert rest == pytest.approx(np.exp(-ran.seconds / 0.1), rel=1e-9)


def test_an_arm_that_comes_to_rest_keeps_its_accelerations() -> None:
    goal = IRB.home + np.array([40.0, -10.0, 5.0, 0.0, 20.0, 0.0])
    diagram = Diagram()
    arm = diagram.add(SimulatedArm("arm", IRB, percent=50.0, rests=True))
    diagram.wire(diagram.add(Constant("goal", goal, "deg")), arm)
    ran = run(diagram, 2.0, 0.004)
    speeds = np.diff(ran["arm.joints"], axis=0) / 0.004
    drive = drive_of(IRB)
    assert (np.abs(speeds) <= drive.speeds / 2.0 + 1e-6).all()
    assert (np.abs(np.diff(speeds, axis=0)) / 0.004 <= drive.accelerations + 1e-6).all()
    assert ran["arm.joints"][-1] == pytest.approx(goal) and ran["arm.limited"].max() == 1.0
    alone = ArmMotion.of(IRB, percent=50.0)
    alone.towards(goal)
    alone.step(0.3)
    assert ran["arm.joints"][75] == pytest.approx(alone.joints)  # after 0.3 s


def test_resolved_rates_move_the_tool_as_told() -> None:
    joints = np.array([10.0, 20.0, 10.0, 30.0, 40.0, 0.0])
    diagram = Diagram()
    at = diagram.add(Constant("at", joints, "deg"))
    speed = diagram.add(Constant("speed", [50.0, -20.0, 10.0, 0.0, 5.0, 0.0]))
    rates = diagram.add(Resolved("rates", IRB))
    diagram.wire(at, (rates, "joints"))
    diagram.wire(speed, (rates, "speed"))
    found = run(diagram, 0.0, 0.01)["rates.speeds"][0]
    moved = [IRB.fk(joints + by * found)[0][0] for by in (-1e-5, 1e-5)]
    assert (moved[1] - moved[0]) / 2e-5 == pytest.approx([50.0, -20.0, 10.0], abs=1e-4)


def test_a_trapezoid_begins_and_ends_at_rest() -> None:
    at = np.array([trapezoid(part) for part in np.linspace(-0.1, 1.1, 1201)])
    speed = np.diff(at) / 1e-3
    assert (at[0], at[-1], at[600]) == pytest.approx((0.0, 1.0, 0.5))
    assert speed.min() >= 0.0
    assert speed.max() == pytest.approx(1.5, abs=1e-3)
    assert np.abs(np.diff(speed)).max() < 5e-3


def test_what_makes_no_sense_is_refused() -> None:
    with pytest.raises(Refused, match="do not rise at row 2"):
        Table("t", [0.0, 0.0], [1.0, 2.0])
    with pytest.raises(Refused, match=r"BL113.*outside its limits"):
        SimulatedArm("arm", IRB, start=[1000.0] * 6)
    diagram = Diagram()
    inverse = diagram.add(InverseKinematics("inverse", IRB))
    diagram.wire(diagram.add(Constant("nothing", np.zeros(7))), (inverse, "pose"))
    diagram.wire(diagram.add(Constant("branch", 0.0)), (inverse, "branch"))
    with pytest.raises(Refused, match="BL110"):
        run(diagram, 0.0, 0.1)

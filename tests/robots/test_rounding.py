"""Targets whose printed numbers are a little beside what was taught."""

from __future__ import annotations

import re

import numpy as np
import pytest

from assistant import languages, robots
from assistant.base.rotations import from_euler, to_euler
from assistant.program.expressions import TargetValue
from assistant.program.geometry import Pose, Target
from assistant.program.motion import FINE, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Motion, Move
from tests.robots.printed import nearest, printed, solve_program

ARMS = [robots.get(name) for name in robots.names()]
KINDS = ("straight", "limits", "borders")


def codes(arm, language: str, text: str) -> list[str]:
    lifted = languages.get(language).lift(languages.get(language).parse(text))
    return [f.code for f in robots.configure(lifted, arm)[1]]


def rapid(target: str) -> str:
    return (
        f"MODULE M\nCONST robtarget p0:=[{target},[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
        "PROC main()\nMoveJ p0,v100,fine,tool0;\nENDPROC\nENDMODULE\n"
    )


@pytest.mark.parametrize(
    ("name", "target"),
    [
        (
            "irb120-3-0.58",
            "298.59,298.59,493.76],[0.529916,-0.313476,0.756798,0.219498],[0,0,0,0",
        ),
        (
            "irb140-6-0.81",
            "436.99,520.79,548.59],[0.551725,-0.335286,0.719022,0.257274],[0,0,0,0",
        ),
        (
            "irb1200-7-0.7",
            "507.861468,89.549679,547.865484],"
            "[0.043577871,0.836516304,0.224143868,0.498097349],[0,1,-4,0",
        ),
    ],
)
def test_a_straight_wrist_as_printed_is_taken_in_the_stated_quadrants(name, target) -> None:
    assert codes(robots.get(name), "rapid", rapid(f"[{target}]")) == []


def test_a_turn_is_taken_on_both_sides_of_its_border_as_printed() -> None:
    text = "1 Tool P_NTool\n2 Mov PA\n3 End\nPA=(-246.30,1.03,430.36,-57.93,88.69,121.39)(6,1)\n"
    assert codes(robots.get("rv-4frl"), "melfa-basic-5", text) == []


def test_a_straight_wrist_leads_back_to_its_joints() -> None:
    arm = robots.get("irb1200-7-0.7")
    wanted = np.array([[10.0, 10.0, 10.0, 200.0, 0.0, -30.0]])
    found = arm.joints_of(*arm.fk(wanted), arm.configuration(wanted))
    assert found[:, 3] + found[:, 5] == pytest.approx(170.0)
    assert arm.configuration(found).tolist() == arm.configuration(wanted).tolist()


def test_axis_four_of_a_straight_wrist_stays_where_it_was_as_printed() -> None:
    arm = robots.get("irb120-3-0.58")
    joints = np.zeros((41, 6))
    joints[:, 0], joints[:, 1], joints[:, 3] = np.linspace(0, 30, 41), 20.0, 40.0
    joints[:, 4] = np.linspace(20, 0, 41)
    p, q, _ = printed(arm, *arm.fk(joints))
    for configurations in (None, arm.configuration(joints)):
        found = solve_program(arm, p, q, configurations, kinds=1)
        assert not found.findings
        assert found.solved_runs[0].joints == pytest.approx(joints, abs=0.2)


def test_what_is_short_of_its_reach_by_rounding_is_reached() -> None:
    arm = robots.get("irb1200-7-0.7")
    joints = np.tile([20.0, 30.0, -np.degrees(np.arctan2(351.0, 42.0)), 10.0, 40.0, 0.0], (30, 1))
    joints[:, [0, 3, 4, 5]] += np.linspace(0.0, 20.0, 30)[:, None]
    p, q, _ = printed(arm, *arm.fk(joints))
    assert not solve_program(arm, p, q, None).findings
    out = np.array([[np.cos(np.radians(20.0)), np.sin(np.radians(20.0)), 0.0]])
    (finding,) = solve_program(arm, p[:1] + 0.05 * out, q[:1], None).findings
    assert finding.code == "RB102"
    assert " 0.0 mm" not in finding.message


def taught(arm, kind: str, count: int, seed: int = 0) -> np.ndarray:
    """(n, a) joints with a straight wrist, an axis at a limit, or at the border of its turns."""
    rng = np.random.default_rng(seed)
    low, high = arm.limits.T
    joints = rng.uniform(low, high, (count, len(low)))
    if kind == "straight":
        joints[:, 4] = 0.0
        joints[::3, 3] = 0.0
        joints[::6, 5] = 0.0
    elif kind == "limits":
        axis = rng.integers(0, len(low), count)
        joints[np.arange(count), axis] = arm.limits[axis, rng.integers(0, 2, count)]
    else:
        step = 90.0 if arm.counts == "quadrants" else 360.0
        for row in range(count):
            _, axis = arm.turning()[rng.integers(len(arm.turning()))]
            every = step * np.arange(-6, 6) + (0.0 if step < 100.0 else 180.0)
            inside = every[(every >= low[axis]) & (every <= high[axis])]
            if len(inside):
                joints[row, axis] = rng.choice(inside)
    return joints


def accepted(arm, kind: str, count: int) -> None:
    taken(arm, taught(arm, kind, count))


def taken(arm, joints: np.ndarray) -> None:
    """Asserts that joints (n, a), as printed, are had with their own configurations."""
    configurations = arm.configuration(joints)
    p, q, rounding = printed(arm, *arm.fk(joints))
    assert np.isfinite(arm.joints_of(p, q, configurations)).all()
    done = solve_program(arm, p, q, configurations)
    assert not done.findings
    found = done.solved_runs[0].joints
    assert arm.inside(found).all()
    there, _ = arm.fk(found)
    assert (
        np.linalg.norm(there - p, axis=1).max()
        < 3.0 * rounding[0] + np.radians(3.0 * rounding[1]) * arm.reach
    )


@pytest.mark.parametrize(
    ("name", "joints"),
    [  # which the nearest joints to what is printed have bent to the other side
        ("irb120-3-0.58", [70.186666, 84.555031, -76.851095, 0.0, 0.0, 0.0]),
        ("irb6700-150-3.20", [42.843329, 17.746157, -82.78712, 0.0, 0.0, 0.0]),
        ("rv-2fr", [-48.970542, -77.908823, 11.582248, -41.409888, 0.0, 226.699526]),
        # and with axis 4 at its limit as near to it as can be
        ("rv-6sl", [-116.97086, 135.0, 13.435826, -46.12908, -0.02713, 9.840764]),
    ],
)
def test_a_straight_wrist_whose_joints_are_far_from_what_is_printed_is_taken(name, joints) -> None:
    arm = robots.get(name)
    taken(arm, np.array([joints]))


def beyond(arm, count: int, seed: int = 1) -> tuple[np.ndarray, ...]:
    """Poses as printed, configurations, of joints beyond a limit by more than rounding explains."""
    rng = np.random.default_rng(seed)
    joints = taught(arm, "limits", 2 * count, seed)
    low, high = arm.limits.T
    at = np.where(joints == low, -1.0, np.where(joints == high, 1.0, 0.0))
    outside = joints + at * np.geomspace(1e-3, 1.0, len(joints))[:, None]
    configurations = arm.configuration(outside)
    p, q, rounding = printed(arm, *arm.fk(outside))
    far = nearest(arm, outside, p, q, rounding) > 2.0
    if arm.five_axis:  # what the position leaves open of the plane of the arm is rounding too
        far &= np.hypot(p[:, 0], p[:, 1]) > 100.0
    rows = rng.permutation(np.flatnonzero(far))[:count]
    return p[rows], q[rows], configurations[rows]


def refused(arm, count: int, *, whole: bool) -> None:
    p, q, configurations = beyond(arm, count)
    assert len(p) > count // 3
    assert np.isnan(arm.joints_of(p, q, configurations)).any(axis=1).all()
    if not whole:
        return
    findings = solve_program(arm, p, q, configurations).findings
    told: dict[str, int] = {}
    for finding in findings:
        assert finding.code in ("RB102", "RB103", "RB107", "RB108", "RB127")
        counted = re.search(r"(\d+) of \d+ targets", finding.where())
        told[finding.code] = told.get(finding.code, 0) + (int(counted[1]) if counted else 1)
    # What is at a limit by rounding may have other quadrants than are stated, too.
    at_limit = told.pop("RB127", 0)
    assert sum(told.values()) <= len(p) <= sum(told.values()) + at_limit <= 1.001 * len(p)


@pytest.mark.one_in(4)  # each arm, with one of the kinds
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_a_pose_as_printed_is_taken_with_its_own_configuration(arm, kind) -> None:
    if kind != "straight" or arm.arm.spherical:
        accepted(arm, kind, 40)


@pytest.mark.parametrize("name", ["irb120-3-0.58", "rv-4frl", "rv-2aj"])
def test_a_pose_that_rounding_does_not_explain_is_refused(name) -> None:
    refused(robots.get(name), 40, whole=True)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_ten_thousand_poses_as_printed_are_taken(arm, kind) -> None:
    if kind != "straight" or arm.arm.spherical:
        accepted(arm, kind, 10_000)


@pytest.mark.slow
@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_ten_thousand_poses_that_rounding_does_not_explain_are_refused(arm) -> None:
    refused(arm, 10_000, whole=True)


def at_limit(name: str, axis: int, over: float, digits: int) -> list[tuple[str, str]]:
    """Findings of a move to a pose, as printed, with a joint beyond its limit by so much."""
    arm = robots.get(name)
    joints = arm.home + np.array([4.0, -7.0, 5.0, 6.0, 0.0, -3.0])
    joints[4] = 35.0
    joints[axis] = arm.limits[axis, 1] + over
    p, q = arm.fk(joints[None])
    turn = from_euler(np.round(to_euler(q), digits))
    target = Target(Pose.of(np.round(p[0], digits), np.asarray(turn).reshape(4)))
    move = Move("linear", TargetValue(target), Motion(Speed(100.0), FINE))
    program = Program("p", (Procedure("main", (move,)),), robot=name)
    findings = robots.solve_program(program, arm).findings
    return [(one.code, one.severity.value) for one in findings]


@pytest.mark.parametrize(("name", "axis"), [("irb1200-7-0.7", 2), ("irb1200-7-0.7", 1)])
def test_what_two_decimals_explain_is_a_warning(name: str, axis: int) -> None:
    assert at_limit(name, axis, 0.005, 2) == [("RB127", "warning")]
    assert at_limit(name, axis, 0.03, 2) == [("RB103", "error")]
    assert at_limit(name, axis, 0.005, 7) == [("RB103", "error")]  # it means what it says

"""The arm branch of a path: the right one, or the right finding at the right row."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from assistant import languages, robots
from assistant.base import rotations
from assistant.program.geometry import Pose, Tool
from assistant.program.motion import Kind, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow
from assistant.robots.arms import Serial
from assistant.robots.arms.spherical_wrist import recognise_six_axis
from tests.examples import drawn

DOWN = (0.0, 0.0, 1.0, 0.0)
ABB = robots.get("irb1200-7-0.7")
MELFA = robots.get("rv-4frl")
seeds = st.integers(0, 2**31)


def program(positions, quaternions=DOWN, held=None, **more) -> Program:
    p = np.asarray(positions, dtype=float)
    q = np.broadcast_to(np.asarray(quaternions, dtype=float), (len(p), 4))
    path = Path.of("seam", p, q, speeds=[Speed(100.0)], **more)
    return Program("p", (Procedure("main", (Follow(path),)),), tools=held or {})


def solved(arm: robots.Robot, *args, **more):
    """The joints of a path, its configurations, the findings."""
    solution = robots.solve_program(program(*args, **more), arm)
    (solved_run,) = solution.solved_runs
    return solved_run.joints, solved_run.configurations, solution.findings


def codes(findings) -> list[str]:
    return [finding.code for finding in findings]


def turning(degrees) -> np.ndarray:
    """A tool that points down, turned about its own axis."""
    return rotations.multiply(
        DOWN, rotations.about(np.tile([0, 0, 1.0], (len(degrees), 1)), degrees)
    )


def emitted(language: str, arm: robots.Robot, *args) -> str:
    chosen = languages.get(language)
    configured, findings = robots.configure(program(*args), arm)
    assert not findings
    return chosen.render(chosen.build(chosen.adapt(configured, arm).program, arm))


# ----------------------------------------------------------------------- wrist singularity


def test_a_crossing_of_the_wrist_singularity_is_told_of_at_the_row_behind_it() -> None:
    z = np.linspace(200, 150, 40)
    gripper = {"gripper": Tool(Pose((0, 0, 60)))}
    positions = np.c_[240 + 0 * z, -50 + 0 * z, z]
    joints, configurations, findings = solved(ABB, positions, held=gripper, tools=("gripper",))
    (finding,) = findings
    assert finding.code == "RB115"
    behind = int(np.flatnonzero(np.diff(np.sign(joints[:, 4])))[0]) + 1
    assert finding.where().endswith(f"seam: 1 of 40 targets (seam_{behind + 1})")
    flip = configurations[:, 2]
    assert flip.tolist() == [int(flip[0])] * behind + [1 - int(flip[0])] * (40 - behind)
    assert np.abs(np.diff(joints, axis=0)).max() < 3.0
    _, valid = ABB.ik(positions + np.array([0, 0, 60]), np.tile(DOWN, (40, 1)))
    assert set(np.flatnonzero(valid.all(axis=0))) == {0, 1}  # no other branch goes all the way


def test_a_branch_that_keeps_off_the_wrist_singularity_is_taken() -> None:
    middle, quaternion = ABB.fk([[65.4, 36.7, -2.7, 40.7, 0.0, -78.8]])
    way = np.linspace(-30, 30, 31)[:, None] + 0.4
    positions = middle + way * np.array([0.79, 0.31, 0.52])
    every, valid = ABB.ik(positions, np.repeat(quaternion, 31, axis=0))
    up = every[:, 0]
    assert valid[:, :2].all()
    assert np.abs(up[:, 4]).min() < 0.5  # with the elbow up it is crossed
    joints, configurations, findings = solved(ABB, positions, quaternion[0])
    assert not findings
    assert configurations[:, :2].tolist() == [[0, 1]] * 31
    assert np.abs(joints[:, 4]).min() > 10.0
    assert np.abs(np.diff(joints, axis=0)).max() < 10.0


@settings(max_examples=drawn(25), deadline=None)
@given(seeds, st.sampled_from([ABB, MELFA, robots.get("irb140-6-0.81")]))
def test_a_path_touches_the_singularity_only_where_every_branch_does(seed, arm) -> None:
    rng = np.random.default_rng(seed)
    low, high = arm.limits.T
    joints = arm.limits.mean(axis=1) + rng.uniform(-0.35, 0.35, 6) * (high - low)
    joints[4] = rng.uniform(-2, 2)
    middle, quaternion = arm.fk(joints[None])
    way = rng.normal(size=3)
    positions = middle + np.linspace(-15, 15, 31)[:, None] * way / np.linalg.norm(way)
    every, valid = arm.ik(positions, np.repeat(quaternion, 31, axis=0))
    whole = valid.all(axis=0)
    assume(whole.any())
    clear = np.abs(every[:, :, 4]).min(axis=0) > 10.0
    step = np.abs(np.diff(every, axis=0)).max(axis=(0, 2))
    chosen, _, findings = solved(arm, positions, quaternion[0])
    if (whole & clear & (step < 20.0)).any():
        assert not findings
        assert np.abs(chosen[:, 4]).min() > 5.0


# ----------------------------------------------------------------------------- out of reach


def test_three_targets_out_of_reach_are_named_with_the_worst_and_the_nearest_pose() -> None:
    x = np.array([600, 640, 720, 760, 715, 640, 600.0])
    positions = np.c_[x, 0 * x, 300 + 0 * x]
    joints, configurations, findings = solved(ABB, positions)
    (finding,) = findings
    assert finding.code == "RB102"
    assert finding.where().endswith("seam: 3 of 7 targets (seam_3, seam_4, seam_5)")
    worst = np.hypot(760, 300 + 82 - 399.1) - 350 - np.hypot(42, 351)
    assert f"{worst:.1f} mm too far out (seam_4)" in finding.message
    stated = re.search(r"can take is \[(.*)\] \[(.*)\]", finding.cure)
    assert stated is not None
    place, turned = ([float(v) for v in group.split(",")] for group in stated.groups())
    assert ABB.ik([place], [turned])[1].any()
    assert np.linalg.norm(np.subtract(place, positions[3])) == pytest.approx(worst, abs=0.05)
    out = [2, 3, 4]
    assert np.isnan(joints[out]).all()
    assert np.isfinite(np.delete(joints, out, axis=0)).all()
    assert len(np.unique(np.delete(configurations, out, axis=0), axis=0)) == 1


# -------------------------------------------------------------------------- turns of axis 6


@pytest.mark.parametrize("arm", [ABB, MELFA, robots.get("irb120-3-0.58")], ids=lambda arm: arm.name)
@pytest.mark.parametrize("rows", [7, 13, 481])
def test_axis_six_goes_beyond_half_a_turn_and_comes_back(arm, rows) -> None:
    degrees = 240.0 - np.abs(np.linspace(-240, 240, rows))
    joints, configurations, findings = solved(
        arm, np.tile([400, 0, 300.0], (rows, 1)), turning(degrees)
    )
    assert not findings
    turned = joints[:, 5] - joints[0, 5]
    assert np.allclose(np.abs(turned), degrees)
    assert np.ptp(joints[:, :5], axis=0) == pytest.approx(0.0)
    assert arm.inside(joints).all()
    wanted = np.floor((joints[:, 5] + 1e-6) / 90.0)
    if arm.counts == "quadrants":
        assert configurations[:, 5].tolist() == wanted.tolist()
    else:
        assert ((configurations[:, 5] + 2) // 4 == np.round((joints[:, 5] - 1e-6) / 360)).all()


def test_what_is_emitted_of_a_turn_beyond_half_and_back() -> None:
    places = np.tile([450, 0, 300.0], (5, 1))
    degrees = turning(np.array([0.0, 120, 240, 120, 0]))
    text = emitted("rapid", ABB, places, degrees)
    assert re.findall(r"robtarget .*?=\[\[.*?\],\[.*?\],(\[.*?\])", text) == [
        "[0,0,0,0]",
        "[0,0,1,0]",
        "[0,0,2,0]",
        "[0,0,1,0]",
        "[0,0,0,0]",
    ]
    assert "ConfL" not in text
    text = emitted("melfa-basic-6", MELFA, places, degrees)
    assert re.findall(r"\)\((\d+,\d+)\)", text) == ["7,0", "7,0", "7,1048576", "7,0", "7,0"]


# ------------------------------------------------------------------------------- elbow down


@pytest.mark.parametrize("way", np.eye(3).tolist())
def test_what_only_the_elbow_down_reaches_is_followed_with_the_elbow_down(way) -> None:
    for language, arm, joints in (
        ("rapid", ABB, (-17, 117, -181, -186, 123, 298)),
        ("melfa-basic-5", robots.get("rv-6s"), (-58, 87, -24, -15, -88, -70)),
    ):
        middle, quaternion = arm.fk([joints])
        positions = middle + np.linspace(-20, 20, 9)[:, None] * np.array(way)
        _, valid = arm.ik(positions, np.repeat(quaternion, 9, axis=0))
        up = [0, 1, 6, 7]  # 4 · back + 2 · bent backwards + flip
        assert valid.any(axis=1).all()
        assert not valid[:, up].any()
        found, configurations, findings = solved(arm, positions, quaternion[0])
        assert not findings
        assert (configurations[:, 1] == 1).all()
        assert arm.inside(found).all()
        assert np.abs(np.diff(found, axis=0)).max() < 20.0
        text = emitted(language, arm, positions, quaternion[0])
        flip = int(configurations[0, 2])
        if language == "rapid":
            figures = re.findall(r"robtarget .*?=\[\[.*?\],\[.*?\],\[.*?,.*?,.*?,(\d)\]", text)
            assert figures == [str(2 + flip)] * 9
            assert "ConfL" not in text
        else:
            figures = re.findall(r"\)\((\d+),", text)
            assert figures == [str(7 - 2 - flip)] * 9


# ------------------------------------------------------------------------------ all together


def test_where_one_branch_winds_up_on_the_way_another_is_taken() -> None:
    positions = [[184.0, -168.0, 249.0], [320.0, 281.0, 436.0]]
    quaternions = np.array([[0.254, 0.228, 0.94, 0.023], [0.351, -0.349, 0.865, 0.088]])
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    joints, _, findings = solved(MELFA, positions, quaternions)
    assert not findings
    assert MELFA.inside(joints).all()


def test_of_a_long_path_too_the_branch_is_taken_whose_turns_suffice() -> None:
    part = np.linspace(0.0, 1.0, 30_000)[:, None]
    ends = np.array([[0.254, 0.228, 0.94, 0.023], [0.351, -0.349, 0.865, 0.088]])
    quaternions = ends[0] + part * (ends[1] - ends[0])
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    positions = [184.0, -168.0, 249.0] + part * [136.0, 449.0, 187.0]
    joints, _, findings = solved(MELFA, positions, quaternions)
    assert not findings
    assert MELFA.inside(joints).all()
    assert np.abs(np.diff(joints, axis=0)).max() < 1.0


@settings(max_examples=drawn(25), deadline=None)
@given(seeds, st.sampled_from([ABB, MELFA, robots.get("rh-6frh5520"), robots.get("rv-2aj")]))
def test_what_is_chosen_is_inside_the_limits_and_leads_back_to_the_poses(seed, arm) -> None:
    rng = np.random.default_rng(seed)
    low, high = arm.limits.T
    p, q = arm.fk(rng.uniform(low, high, (30, len(low))))
    kinds = np.where(rng.random(30) < 0.5, Kind.JOINT, Kind.LINEAR)
    joints, _, _ = solved(arm, p, q, kinds=kinds)
    assert arm.inside(joints).all()
    there, turned = arm.fk(joints)
    assert np.abs(there - p).max() < 1e-4
    assert rotations.angle_between(turned, q).max() < 0.02


@settings(max_examples=drawn(25), deadline=None)
@given(seed=seeds)
def test_an_arm_recognised_in_a_chain_takes_the_branches_of_its_closed_form(seed) -> None:
    known = robots.get("irb1600-10-1.45")
    chain = Serial.of_links(known.arm.links(), np.radians(known.limits + known.zero[:, None]))
    rng = np.random.default_rng(seed)
    joints = rng.uniform(*known.limits.T)
    joints[2] = rng.uniform(-100.0, -60.0)  # near to stretched
    position, quaternion = known.fk(joints)
    lines = position + np.cumsum(rng.normal(0.0, 40.0, (6, 3)), axis=0)
    kinds = np.array([Kind.JOINT] + 5 * [Kind.LINEAR], dtype=np.uint8)
    mine, theirs = (
        solved(arm, lines, quaternion[0], kinds=kinds)
        for arm in (known, replace(known, arm=recognise_six_axis(chain)))
    )
    assert codes(mine[2]) == codes(theirs[2])
    assert mine[1].tolist() == theirs[1].tolist()
    assert mine[0] == pytest.approx(theirs[0], abs=1e-3, nan_ok=True)

"""The nearest pose that an arm can take instead of one that it cannot."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from assistant import robots
from assistant.base import rotations
from assistant.program import pseudo
from assistant.program.geometry import Pose
from assistant.robots.arms.closed_form import from_ab
from assistant.robots.arms.nearest_pose import find_nearest_pose
from tests.examples import drawn

ARM = robots.get("rv-2aj")
FLANGE = Pose()
HAND = Pose((0.0, 0.0, 80.0))
seeds = st.integers(0, 2**31)


def reachable(seed: int, count: int) -> np.ndarray:
    low, high = ARM.limits.T
    return np.random.default_rng(seed).uniform(low, high, (count, len(low)))


def taken(pose: Pose, tip: Pose) -> bool:
    flange = pose @ tip.inverse()
    _, valid = ARM.ik([flange.position], [flange.quaternion])
    return bool(valid.any())


@settings(max_examples=drawn(10), deadline=None)
@given(seeds, st.sampled_from([FLANGE, HAND]))
def test_a_pose_that_is_reached_is_its_own(seed: int, tip: Pose) -> None:
    p, q = ARM.fk(reachable(seed, 1))
    wanted = Pose.of(p[0], q[0]) @ tip
    found = find_nearest_pose(ARM, wanted, tip)
    assert np.allclose(found.position, wanted.position, atol=1e-3)
    turned = rotations.angle_between(np.array(found.quaternion), np.array(wanted.quaternion))
    assert float(turned) < 0.05


@settings(max_examples=drawn(10), deadline=None)
@given(seeds)
@example(14129)
def test_no_pose_of_many_is_nearer(seed: int) -> None:
    rng = np.random.default_rng(seed)
    wanted = Pose.of(rng.uniform(-700, 700, 3), rotations.canonical(rng.normal(size=4)))
    found = find_nearest_pose(ARM, wanted, FLANGE)
    distance = float(np.linalg.norm(np.subtract(found.position, wanted.position)))
    others, _ = ARM.fk(reachable(seed, 5000))
    assert distance <= np.linalg.norm(others - wanted.position, axis=1).min() + 1e-3


def finding(target: str, arm: robots.Robot = ARM) -> str:
    text = (
        f"program p\n\ntarget t {target}\n\nprocedure main\n"
        "  move joint t speed 100 mm/s joint 10 % blend fine\nend\n"
    )
    found = arm.check(pseudo.parse(text))
    return next(f.cure for f in found if f.code in ("RB102", "RB103", "RB104"))


@pytest.mark.parametrize(
    "target",
    [
        "[300, 100, 200] [0.5, 0.5, 0.5, 0.5]",  # the tool leans out of the plane
        "[700, 0, 300] [0, 0, 1, 0]",  # too far out
        "[20, 10, 100] [0, 0, 1, 0]",  # too near
        "[-300, -5, 700] [0.7071068, 0, 0.7071068, 0]",
    ],
)
def test_the_cure_states_a_pose_that_the_arm_takes(target: str) -> None:
    cure = finding(target)
    stated = re.search(r"nearest pose that it can take is (.*) \(mm and degrees", cure)
    assert stated is not None
    values = [float(v) for v in re.findall(r"[XYZAB] (-?[0-9.]+)", stated.group(1))]
    assert len(values) == 5
    q = from_ab([values[:3]], [values[3:]])[0]
    assert taken(Pose.of(np.array(values[:3]), q), FLANGE)


OTHERS = [robots.get(name) for name in ("irb120-3-0.58", "irb1200-7-0.7", "rv-4frl", "rh-6frh5520")]
FAR = {
    "irb120-3-0.58": "[600, 200, 100] [0, 0, 1, 0]",
    "irb1200-7-0.7": "[900, -300, 200] [0.5, 0.5, 0.5, 0.5]",
    "rv-4frl": "[5, 3, 270] [0, 0, 1, 0]",
    "rh-6frh5520": "[500, 400, 200] [1, 0, 0, 0]",
}


def stated_by(cure: str) -> Pose:
    stated = re.search(
        r"nearest pose that it can take is (.*) \(mm (and degrees )?in its base", cure
    )
    assert stated is not None
    values = [float(v) for v in re.findall(r"-?[0-9.]+", stated.group(1))]
    turned = values[3:] if len(values) == 7 else rotations.from_euler(values[:2:-1])
    return Pose.of(np.array(values[:3]), np.asarray(turned))


@pytest.mark.parametrize("arm", OTHERS, ids=lambda arm: arm.name)
def test_out_of_reach_the_stated_pose_is_taken_and_none_nearer_is(arm: robots.Robot) -> None:
    wanted = np.array([float(v) for v in re.findall(r"-?[0-9.]+", FAR[arm.name])])
    pose = stated_by(finding(FAR[arm.name], arm))
    assert float(rotations.angle_between(np.array(pose.quaternion), wanted[3:])) < 0.01
    assert arm.ik([pose.position], [pose.quaternion])[1].any()
    distance = np.linalg.norm(np.array(pose.position) - wanted[:3])
    ways = np.random.default_rng(7).normal(size=(4000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    nearer = wanted[:3] + 0.999 * distance * ways
    _, valid = arm.ik(nearer, np.tile(wanted[3:], (len(nearer), 1)))
    assert not valid.any()


@pytest.mark.parametrize("arm", OTHERS[:3], ids=lambda arm: arm.name)
def test_where_no_position_allows_the_orientation_it_is_turned(arm: robots.Robot) -> None:
    wrist = 2 if arm.name == "rv-4frl" else 4
    limits = arm.limits.copy()
    limits[wrist] = limits[wrist].mean() + np.array([-1.0, 1.0])
    limits[[0, 3, 5]] = [-1.0, 1.0]
    narrow = replace(arm, limits=limits, home=limits.mean(axis=1))
    wanted = Pose((300.0, 100.0, 200.0), (0.0, 0.6, 0.8, 0.0))
    found = find_nearest_pose(narrow, wanted, FLANGE, keep=True)
    rounded = replace(narrow, limits=limits + np.array([-0.01, 0.01]))
    assert rounded.ik([found.position], [found.quaternion])[1].any()
    others, _ = narrow.fk(np.random.default_rng(3).uniform(*limits.T, (5000, 6)))
    distance = np.linalg.norm(np.subtract(found.position, wanted.position))
    assert distance <= np.linalg.norm(others - wanted.position, axis=1).min() + 1e-3

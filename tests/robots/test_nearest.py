"""The nearest pose that an arm of five axes can take instead of one that it cannot."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from assistant import robots
from assistant.program import pseudo, rotations
from assistant.program.geometry import Pose
from assistant.robots.arms.five_axis import from_ab
from assistant.robots.nearest import nearest

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


@settings(max_examples=10, deadline=None)
@given(seeds, st.sampled_from([FLANGE, HAND]))
def test_a_pose_that_is_reached_is_its_own(seed: int, tip: Pose) -> None:
    p, q = ARM.fk(reachable(seed, 1))
    wanted = Pose.of(p[0], q[0]) @ tip
    found = nearest(ARM, wanted, tip)
    assert np.allclose(found.position, wanted.position, atol=1e-3)
    turned = rotations.angle_between(np.array(found.quaternion), np.array(wanted.quaternion))
    assert float(turned) < 0.05


@settings(max_examples=10, deadline=None)
@given(seeds)
@example(14129)
def test_no_pose_of_many_is_nearer(seed: int) -> None:
    rng = np.random.default_rng(seed)
    wanted = Pose.of(rng.uniform(-700, 700, 3), rotations.canonical(rng.normal(size=4)))
    found = nearest(ARM, wanted, FLANGE)
    distance = float(np.linalg.norm(np.subtract(found.position, wanted.position)))
    others, _ = ARM.fk(reachable(seed, 5000))
    assert distance <= np.linalg.norm(others - wanted.position, axis=1).min() + 1e-3


def finding(target: str) -> str:
    text = (
        f"program p\n\ntarget t {target}\n\nprocedure main\n"
        "  move joint t speed 100 mm/s joint 10 % blend fine\nend\n"
    )
    found = ARM.check(pseudo.parse(text))
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
    position = np.array([values[:3]])
    # two decimals may leave the reach by as much: a hundredth towards the shoulder is inside
    inward = position + (np.array([0.0, 0.0, 300.0]) - position) * 1e-4
    outward = position + (position - np.array([0.0, 0.0, 300.0])) * 1e-4
    assert any(
        taken(Pose.of(p[0], from_ab(p, [values[3:]])[0]), FLANGE)
        for p in (position, inward, outward)
    )

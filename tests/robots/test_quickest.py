"""Branches and whole turns on paths of joint moves, against all that there are."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import assume, event, given, settings
from hypothesis import strategies as st

from assistant import robots
from assistant.program.motion import UNSTATED, Kind, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow
from assistant.robots.motion.branch_sequence import BRANCH_CHANGE_COST, LIMIT_CLEARANCE
from tests.examples import drawn

ARMS = [
    robots.get(name)
    for name in ("irb120-3-0.58", "irb1200-7-0.7", "irb140-6-0.81", "irb4600-20-2.50")
] + [robots.get(name) for name in ("rv-4frl", "rv-13frl", "rh-6frh5520")]
MELFA = robots.get("rv-4frl")
BEST = 1e-3
"""Share of the time that a path may take more: of equally quick ways the calmest is taken."""
seeds = st.integers(0, 2**31)
arms = st.sampled_from(ARMS)


def followed(arm, p, q, kinds=Kind.JOINT, configurations=None):
    """The joints of a path, its configurations, the findings."""
    p = np.asarray(p, dtype=float)
    stated = {} if configurations is None else {"configurations": configurations.astype(np.int8)}
    path = Path.of("p", p, q, kinds=np.full(len(p), kinds), speeds=[Speed(100.0)], **stated)
    solution = robots.solve_program(Program("p", (Procedure("main", (Follow(path),)),)), arm)
    (solved_run,) = solution.solved_runs
    return solved_run.joints, solved_run.configurations, solution.findings


def wound(arm, rows: np.ndarray) -> list[np.ndarray]:
    """Joints (m, a) of rows that belong together with all whole turns that stay clear of the
    limits, or at least inside them.
    """
    out: list[list[float]] = []
    for axis, (low, high) in enumerate(arm.limits):
        angles = rows[:, axis]
        turns = [360.0 * k for k in range(-3, 4)] if axis in arm.winding() else [0.0]
        for margin in (LIMIT_CLEARANCE if axis in arm.winding() else 0.0, -1e-6):
            inside = [
                turn
                for turn in turns
                if low + margin <= (angles + turn).min() and (angles + turn).max() <= high - margin
            ]
            if inside:
                break
        out.append(inside)
    return [rows + np.array(turns) for turns in itertools.product(*out)]


def least(arm, chains: list[list[np.ndarray]], branched: bool) -> float:
    """Seconds of the quickest of all ways through chains, each in one of its states (m, a)."""
    total: np.ndarray = np.zeros(())
    last = [arm.home[None]]
    for chain in chains:
        ends, starts = np.array([s[-1] for s in last]), np.array([s[0] for s in chain])
        seconds = (np.abs(ends[:, None] - starts[None]) / arm.speeds).max(axis=2)
        if branched:
            one, two = (arm.branch_of(arm.configuration(each)) for each in (ends, starts))
            seconds = seconds + BRANCH_CHANGE_COST * (one[:, None] != two[None])
        total = total[..., None] + (seconds if total.ndim else seconds[0])
        last = chain
    return float(total.min())


def seconds(arm, joints: np.ndarray, branched: bool, moves=slice(None)) -> float:
    every = np.vstack([arm.home, joints])
    steps = (np.abs(np.diff(every, axis=0)) / arm.speeds).max(axis=1)
    if branched:
        steps += BRANCH_CHANGE_COST * (np.diff(arm.branch_of(arm.configuration(every))) != 0)
    return float(steps[moves].sum())


@settings(max_examples=drawn(30))
@given(seeds, st.integers(1, 4), arms, st.booleans())
def test_no_other_branches_and_turns_take_joint_moves_less_time(seed, count, arm, some) -> None:
    rng = np.random.default_rng(seed)
    taught = rng.uniform(*arm.limits.T, (count, len(arm.axes)))
    p, q = arm.fk(taught)
    every, valid = arm.ik(p, q)
    assume(valid.any(axis=1).all())
    stated = np.full((count, 6), UNSTATED)
    if some:
        row = rng.integers(count)
        stated[row] = arm.configuration(taught[row])
    joints, configurations, findings = followed(arm, p, q, configurations=stated)
    assert not findings
    rows = np.flatnonzero(stated[:, 0] != UNSTATED)
    assert configurations[rows].tolist() == stated[rows].tolist()
    chains = []
    for row in range(count):
        if row in rows:
            chains.append([joints[row : row + 1]])
            continue
        branches = every[row][valid[row]]
        chains.append([one for branch in branches for one in wound(arm, branch[None])])
    best = least(arm, chains, branched=True)
    event("wound" if np.abs(np.diff(joints, axis=0)).max(initial=0.0) > 180.0 else "short")
    assert seconds(arm, joints, branched=True) == pytest.approx(best, rel=BEST)


@settings(max_examples=drawn(25))
@given(seeds, st.integers(2, 4), arms)
def test_no_other_turns_take_joint_moves_between_lines_less_time(seed, count, arm) -> None:
    rng = np.random.default_rng(seed)
    low, high = arm.limits.T
    taught = rng.uniform(low, high, (count, len(low)))
    there, turned = arm.fk(taught)
    p = there[:, None] + np.cumsum(rng.uniform(-8.0, 8.0, (count, 3, 3)), axis=1)
    q = np.repeat(turned, 3, axis=0)
    kinds = np.tile([Kind.JOINT, Kind.LINEAR, Kind.LINEAR], count)
    joints, _, findings = followed(arm, p.reshape(-1, 3), q, kinds)
    assume(not findings)
    chains = [wound(arm, joints[row : row + 3]) for row in range(0, len(joints), 3)]
    best = least(arm, chains, branched=False)
    mine = seconds(arm, joints, branched=False, moves=slice(None, None, 3))
    assert mine == pytest.approx(best, rel=BEST)


@pytest.mark.parametrize("times", [1, 6700])
def test_an_axis_is_not_taken_where_it_has_to_be_wound_back_from(times: int) -> None:
    """From 49.9 to 179.3 is nearer than to -180.7, but from there on to -122.8 farther."""
    joints = np.tile([10.0, 20.0, 90.0, 0.0, 60.0, 0.0], (3 * times, 1))
    joints[:, 3] = np.tile([49.9, 179.3, -122.8], times)
    found, _, findings = followed(MELFA, *MELFA.fk(joints))
    assert not findings
    joints[1::3, 3] = -180.7
    assert np.abs(found - joints).max() < 1e-6


def test_an_axis_that_has_time_for_a_turn_does_not_turn() -> None:
    """Axis 1 takes longer than axis 6 for a whole turn; nothing is won by that."""
    joints = np.tile([0.0, 20.0, 90.0, 49.9, 60.0, 0.0], (4, 1))
    joints[:, 3] = [49.9, 179.3, -122.8, -122.8]
    joints[:, 0] = [0.0, 0.0, 0.0, 170.0]
    joints[:, 5] = [0.0, 0.0, 0.0, 20.0]
    found, _, _ = followed(MELFA, *MELFA.fk(joints))
    assert found[:, 5] == pytest.approx(joints[:, 5], abs=1e-6)

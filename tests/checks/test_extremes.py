"""What is taken down of a move's way is what a far finer look at it sees."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from assistant import robots
from assistant.checks.program_view import extremes_of, moves_of
from assistant.program.motion import UNSTATED, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow
from assistant.robots.arms import Serial
from assistant.robots.arms.spherical_wrist import recognise_six_axis
from tests.examples import drawn

NAMES = ["irb1200-7-0.7", "rv-4frl", "rv-2aj", "rh-6frh5520", "irb4600-20-2.50"]
FINE: Final = 3001
IN_LINE: Final = 0.1
"""degrees of axis 5 below which axes 4 and 6 of the fine look mean nothing."""
EVEN: Final = 2.0
"""degrees, or mm, in a fine step; where it is more a joint as good as jumps."""
NEAR: Final = 10.0
"""degrees of axis 5 below which its least angle has to be exact."""
SHORT: Final = 0.1
"""seconds of a move that is too short for any joint to get to its speed."""


def journey_between(arm, *joints, kinds):
    p, q = arm.fk(joints)
    stated = arm.configuration(joints)
    stated[1:, 0] = UNSTATED
    path = Path.of("way", p, q, kinds=kinds, speeds=[Speed(100.0)], configurations=stated)
    return robots.solve_program(Program("p", (Procedure("main", (Follow(path),)),)), arm)


def moves_between(arm, *joints, kinds):
    solution = journey_between(arm, *joints, kinds=kinds)
    assume(not [f for f in solution.findings if f.severity == "error" or f.code == "RB115"])
    return moves_of(solution.solved_runs[0], arm, {}, {})


def looked_at_finely(arm, moves):
    p, q = moves.poses(np.array([0]), FINE)
    ends = moves.joints[[moves.starts[0] + 1, moves.rows[0] + 1]]
    branch, other = arm.branch_of(arm.configuration(ends))
    assume(branch == other)
    found, excess = arm.solve(p[0], q[0], (int(branch),))
    assume(excess.max() < 1e-6)
    fine = np.concatenate([ends[:1], found[:, 0].T, ends[1:]])
    return fine


def least_seconds(arm, moves, fine):
    """What the joint speeds allow, by steps that get smaller where they are fastest, until they
    tell the speed.
    """
    branch = int(arm.branch_of(arm.configuration(fine[:1]))[0])
    begin, width, found = 0.0, 1.0, 0.0
    while True:
        needed = np.abs(arm.wound(np.diff(fine, axis=0))) / arm.speeds * (len(fine) - 1) / width
        last, found = found, needed.max()
        if abs(found - last) < 1e-3 * found or width < 1e-7:
            return found
        at = int(needed.max(axis=1).argmax())
        step = width / (len(fine) - 1)
        begin, end = begin + step * max(at - 1, 0), begin + step * min(at + 2, len(fine) - 1)
        width = end - begin
        p, q = moves.poses_at(np.array([0]), np.linspace(begin, end, 301)[None])
        fine = arm.solve(p[0], q[0], (branch,))[0][:, 0].T


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kinds", [(1, 1), (1, 2, 3)])
@settings(max_examples=drawn(30), derandomize=True)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_way_is_that_of_a_fine_look(name, kinds, seed):
    arm = robots.get(name)
    rng = np.random.default_rng(seed)
    low, high = arm.limits.T
    joints = [rng.uniform(low, high)]
    joints += [np.clip(joints[0] + rng.normal(0.0, 15.0, len(low)), low, high) for _ in kinds[1:]]
    moves = moves_between(arm, *joints, kinds=kinds)
    fine = looked_at_finely(arm, moves)
    extremes = extremes_of(moves)
    assume(not extremes.crossed[0])
    step = np.abs(arm.wound(np.diff(fine, axis=0)))
    if arm.arm.spherical:
        bend = np.degrees(np.arcsin(np.abs(np.sin(np.radians(fine[:, 4]))))).min()
        if min(bend, extremes.wrist[0]) < NEAR:
            assert extremes.wrist[0] == pytest.approx(bend, abs=0.2)
        assume(bend > IN_LINE)
    assume(step.max() < EVEN)
    seconds = least_seconds(arm, moves, fine)
    assert extremes.seconds[0] <= 1.01 * seconds
    if seconds > SHORT:
        assert extremes.seconds[0] >= 0.9 * seconds


@pytest.mark.parametrize("how", ["recognised", "followed"])
@pytest.mark.parametrize("kinds", [(1, 1), (1, 2, 3)])
def test_an_arm_of_links_goes_the_same_way(how, kinds):
    known = robots.get("irb4600-20-2.50")
    joints = np.array(
        [[-20.0, 10, 20, 15, 40, -30], [0, 0, 30, 10, 45, 0], [35, 20, 10, -5, 50, 20]]
    )
    joints = joints[: len(kinds)]
    known = replace(known, home=joints[0])
    chain = Serial.of_links(known.arm.links(), np.radians(known.limits + known.zero[:, None]))
    own = replace(known, arm=recognise_six_axis(chain) if how == "recognised" else chain)
    journeys = [journey_between(arm, *joints, kinds=kinds) for arm in (known, own)]
    assert {f.code for solution in journeys for f in solution.findings} <= {"RB118"}
    wanted, found = (extremes_of(moves_of(j.solved_runs[0], j.robot, {}, {})) for j in journeys)
    assert wanted.seconds[0] > 0.05
    assert found.seconds == pytest.approx(wanted.seconds, rel=1e-3)
    assert found.axis.tolist() == wanted.axis.tolist()
    if how == "recognised":
        assert found.wrist == pytest.approx(wanted.wrist, abs=1e-6)
        assert found.elbow == pytest.approx(wanted.elbow, abs=1e-6)
        assert found.shoulder == pytest.approx(wanted.shoulder, abs=1e-6)
        assert np.isfinite(found.elbow).all()

"""A plan as straight stretches: the arm is never farther off them than they say."""

from __future__ import annotations

import numpy as np
import pytest

from assistant import robots
from assistant.program.expressions import JointValue, TargetValue
from assistant.program.geometry import JointTarget, Pose, Target
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Motion, Move, MoveJoints
from assistant.robots.timing import simulate
from assistant.robots.timing.uninterrupted_moves import stretches_of

ARM = robots.get("irb1200-7-0.7")


def program(seed: int, lines: bool, radius: float = 20.0) -> Program:
    """Moves about home, every second one a line if there are any."""
    draw = np.random.default_rng(seed)
    statements: list[Move | MoveJoints] = []
    for number in range(8):
        row = ARM.home + draw.uniform(-12.0, 12.0, 6)
        blend = Blend(radius) if number < 7 else FINE
        motion = Motion(Speed(float(draw.uniform(100.0, 800.0))), blend)
        if lines and number % 2:
            p, q = ARM.fk(row[None])
            statements.append(Move("linear", TargetValue(Target(Pose.of(p[0], q[0]))), motion))
        else:
            statements.append(MoveJoints(JointValue(JointTarget(tuple(row.tolist()))), motion))
    return Program("way", (Procedure("main", tuple(statements)),), robot=ARM.name)


@pytest.mark.parametrize("lines", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_the_arm_is_where_its_stretches_say(seed: int, lines: bool) -> None:
    solved = robots.solve_program(program(seed, lines), ARM)
    for passed in simulate(solved).passed:
        stretches = stretches_of(passed.plan)
        times = np.linspace(0.0, passed.plan.seconds, 3000)
        there = passed.plan.at(times).joints
        at = np.searchsorted(stretches.times, times, side="right") - 1
        at = np.clip(at, 0, len(stretches.slack) - 1)
        start, way = stretches.joints[at], np.diff(stretches.joints, axis=0)[at]
        part = ((there - start) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), 1e-12)
        off = np.abs(there - start - np.clip(part, 0.0, 1.0)[:, None] * way)
        assert (off <= 1.2 * stretches.slack[at] + 1e-3).all()


def test_joint_moves_are_off_their_stretches_in_corners_only() -> None:
    for seed in range(4):
        solved = robots.solve_program(program(seed, lines=False), ARM)
        for passed in simulate(solved).passed:
            assert stretches_of(passed.plan).slack.max() < 0.1

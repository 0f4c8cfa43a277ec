"""Tables of joints, poses, configurations, Jacobians and branches that source is tested with."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.blocks.code import rules
from assistant.robots import Robot
from assistant.robots.motion.singularities import distance_from_singularity, jacobian

VECTOR_ROWS: Final = 200
VECTOR_SEED: Final = 22
LEAST_FROM_SINGULARITY: Final = 0.02
"""How far from a singularity the rows are, as `away` tells it: nearer to one, the rounding of a
pose turns joints by more than the test allows."""
DRAWING_ROUNDS: Final = 100
"""Times that four times as many joints are drawn as rows are wanted."""


def vectors_csv(robot: Robot, rows: int = VECTOR_ROWS) -> bytes:
    """A CSV with a row of names, then joints at random inside the limits and what is of them.

    There are fewer rows where hardly any joints are away from singularities; raises Refused where
    none are.
    """
    columns = np.hstack(list(_vector_columns(robot, _random_joints(robot, rows))))
    names = ",".join(_column_names(robot))
    lines = [",".join(map(repr, row)) for row in columns.tolist()]
    return "\n".join([names, *lines, ""]).encode()


def _random_joints(robot: Robot, rows: int) -> Floats:
    """(rows, a) at most, the same ones of each robot, none of them near a singularity."""
    random, (low, high) = np.random.default_rng(VECTOR_SEED), robot.limits.T
    found = np.empty((0, len(low)))
    for _ in range(DRAWING_ROUNDS):
        if len(found) >= rows:
            break
        more = random.uniform(low, high, (4 * rows, len(low)))
        found = np.concatenate(
            [found, more[distance_from_singularity(robot, more) > LEAST_FROM_SINGULARITY]]
        )
    if not len(found):
        raise Refused(rules.ALWAYS_SINGULAR(title=robot.title))
    return found[:rows]


def degrees_jacobian(robot: Robot, joints: Floats) -> Floats:
    """(n, 6, a) mm and degrees of the flange for each degree (or mm) of a joint."""
    out = jacobian(robot, joints)
    turning = ~robot.sliding
    out[:, :3, turning] *= np.radians(robot.reach)
    return out


def _vector_columns(robot: Robot, joints: Floats) -> Iterator[Floats]:
    n = len(joints)
    p, q = robot.fk(joints)
    yield from (joints, p, q, robot.configuration(joints).astype(np.float64))
    yield degrees_jacobian(robot, joints).reshape(n, -1)
    branches, valid = robot.ik(p, q)
    yield np.concatenate([branches, valid[..., None]], axis=2).reshape(n, -1)


def _column_names(robot: Robot) -> list[str]:
    axes = list(robot.axes)
    pose = ["x", "y", "z", "qw", "qx", "qy", "qz"]
    sides = ["side_1", "side_2", "side_3", "quarter_J1", "quarter_J4", "quarter_J6"]
    rates = [f"d{row}/d{axis}" for row in ("x", "y", "z", "rx", "ry", "rz") for axis in axes]
    branches = [
        f"branch_{branch}_{of}" for branch in range(robot.branches) for of in (*axes, "valid")
    ]
    return [*axes, *pose, *sides, *rates, *branches]

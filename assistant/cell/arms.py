"""Bodies of the links of an arm, worked out from its lengths and the radii of its file.

A link is a capsule along each straight part of its chain: from its axis along the offset, then
along its length. That is rounder than the casting that the maker draws; the meshes of a URDF say
more.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import numpy as np

from assistant.cell.scene import Body, Part, Placed, Scene
from assistant.cell.shapes import Capsule
from assistant.program.arrays import Floats, norms
from assistant.program.geometry import IDENTITY, Pose, Vector
from assistant.robots.arms.chain import onto_z
from assistant.robots.robot import Robot

SHORT: Final = 1.0
"""mm of a link below which it has no body of its own."""
SEED: Final = 20
POSES: Final = 1000
ALWAYS: Final = 0.95
"""Share of random poses in which two links touch that cannot be kept apart: their bodies are
rounder than the links."""


def placed(name: str, robot: Robot, base: Pose = IDENTITY) -> Placed:
    """A robot of a cell with the bodies of its links."""
    return Placed(name, robot, base, tuple(link_bodies(name, robot)))


def link_bodies(name: str, robot: Robot) -> Iterator[Body]:
    """Bodies `NAME.base`, `NAME.J1` … of a robot, each carried by what it is called after.

    Where axis 1 begins on the floor, the lower half of its column is the base.
    """
    chain = robot.arm.whole_chain
    steps = [*(joint.pose.position for joint in chain.joints), chain.flange.position]
    origin, foot = np.zeros(3), np.zeros(3)
    for carrier, step, radius in zip(("base", *robot.axes), steps, robot.radii, strict=True):
        corners = [foot if carrier == "J1" else origin, _up(step), np.array(step)]
        if carrier == "base" and norms(np.array([step]))[0] <= SHORT:
            corners = [origin, foot := _up(steps[1]) / 2.0]
        parts = tuple(
            capsule_between(start, end, float(radius))
            for start, end in pairwise(corners)
            if norms((end - start)[None])[0] > SHORT
        )
        if parts:
            yield Body(f"{name}.{carrier}", parts, parent=f"{name}.{carrier}")


def _up(step: Vector) -> Floats:
    """What of a step to the next frame goes along the z axis of this one, as a step."""
    return np.array([0.0, 0.0, step[2]])


def capsule_between(start: Floats, end: Floats, radius: float) -> Part:
    """A capsule whose half spheres are about two points (3,)."""
    way = end - start
    length = float(norms(way[None])[0])
    x, y, z = (way / length).tolist()
    return Part(Capsule(radius, length), Pose.of((start + end) / 2.0, np.array(onto_z((x, y, z)))))


def touching_links(placed: Placed) -> frozenset[tuple[str, str]]:
    """Pairs of an arm's own bodies, in order, whose contact says nothing.

    Neighbours, bodies that touch where the arm stands at home, and those that nearly always do;
    the same three that MoveIt's setup assistant leaves out.
    """
    from assistant.cell.collision.model import Model

    model = Model(Scene(robots=(placed,)))
    low, high = np.clip(placed.robot.limits, -360.0, 360.0).T
    rows = np.random.default_rng(SEED).uniform(low, high, (POSES, len(low)))
    rows[0] = placed.robot.home
    n, pairs = len(rows), len(model)
    row, pair = np.repeat(np.arange(n), pairs), np.tile(np.arange(pairs), n)
    touch = model.exact(rows, row, pair).reshape(n, pairs) <= 0.0
    order = [body.name for body in placed.links]
    out = set[tuple[str, str]]()
    for p in range(pairs):
        one, other = (model.items[i].body.name for i in (model.one[p], model.other[p]))
        beside = abs(order.index(one) - order.index(other)) == 1
        if beside or touch[0, p] or touch[:, p].mean() >= ALWAYS:
            out.add((min(one, other), max(one, other)))
    return frozenset(out)

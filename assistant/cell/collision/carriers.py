"""Where what carries bodies is, for rows of joints: the world, links and flanges of robots.

A row holds the joints of all robots of a scene, one after the other, in degrees (mm of an axis that
slides).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, norms
from assistant.base.diagnostics import Refused
from assistant.cell.rules import CIRCULAR_PARENTS, NO_PARENT
from assistant.cell.scene import FLANGE, WORLD, Body, PlacedRobot, Scene
from assistant.cell.shapes import Shape, extent, farthest
from assistant.program.geometry import Pose
from assistant.robots.robot import Robot


@dataclass(frozen=True, eq=False)
class Carriers:
    """Carriers of a scene, numbered: 0 the world, then base, links and flange of each robot.

    robots: in their order. first: of each the number of its base; its links follow.
    columns: of each the slice of its joints in a row.
    """

    robots: tuple[PlacedRobot, ...]

    @cached_property
    def first(self) -> tuple[int, ...]:
        sizes = [len(placed.robot.axes) + 2 for placed in self.robots]
        return tuple(1 + sum(sizes[:i]) for i in range(len(sizes)))

    @cached_property
    def columns(self) -> tuple[slice, ...]:
        ends = np.cumsum([len(placed.robot.axes) for placed in self.robots])
        return tuple(
            slice(end - len(p.robot.axes), end) for p, end in zip(self.robots, ends, strict=True)
        )

    @property
    def joints(self) -> int:
        """How many a row has."""
        return sum(len(placed.robot.axes) for placed in self.robots)

    @cached_property
    def names(self) -> Mapping[str, int]:
        """Numbers of carriers by the names that bodies give as their parents."""
        found = {WORLD: 0}
        for placed, first in zip(self.robots, self.first, strict=True):
            own = ("base", *placed.robot.axes, FLANGE)
            found |= {f"{placed.name}.{name}": first + i for i, name in enumerate(own)}
            if len(self.robots) == 1:
                found |= {name: first + i for i, name in enumerate(own)}
        return found

    def at(self, rows: Floats) -> tuple[Floats, Floats]:
        """Rows (n, j) → origins (n, c, 3) mm, rotations (n, c, 3, 3) of carriers in the world."""
        n, count = len(rows), 1 + sum(len(p.robot.axes) + 2 for p in self.robots)
        origins, turns = np.zeros((n, count, 3)), np.empty((n, count, 3, 3))
        turns[:, 0] = np.eye(3)
        for placed, first, columns in zip(self.robots, self.first, self.columns, strict=True):
            o, t = placed.robot.link_frames(rows[:, columns])
            base = rotations.to_matrix(np.array(placed.base.quaternion))
            own = slice(first + 1, first + 1 + o.shape[1])
            origins[:, first], turns[:, first] = placed.base.position, base
            origins[:, own] = o @ base.T + np.array(placed.base.position)
            turns[:, own] = base @ t
        return origins, turns

    def moved_by(self, carrier: int) -> tuple[int, ...]:
        """Places in a row of the joints that move a carrier."""
        for first, columns, placed in zip(self.first, self.columns, self.robots, strict=True):
            axes = len(placed.robot.axes)
            if first < carrier <= first + axes + 1:
                return tuple(range(columns.start, columns.start + min(carrier - first, axes)))
        return ()

    def reaches(self, carrier: int, pose: Pose, shape: Shape) -> Floats:
        """(j,) how far a point of a carried shape moves at most for a radian (mm) of each joint.

        Joints are those of the chain, see `coupled`. pose: of the shape in the frame of the
        carrier. About the axis that carries it a point moves as far as it is from that line; about
        those before, no farther than the lengths between the axis and the shape add up to, however
        the joints between them turn.
        """
        out = np.zeros(self.joints)
        moving = self.moved_by(carrier)
        if not moving:
            return out
        at = next(i for i, s in enumerate(self.columns) if s.start <= moving[0] < s.stop)
        robot, start = self.robots[at].robot, self.columns[at].start
        if carrier - self.first[at] > len(robot.axes):
            pose = robot.arm.whole_chain.flange @ pose
        steps, own = link_lengths(robot), moving[-1] - start
        last = float(farthest(shape, np.array(pose.inverse().position)[None])[0])
        for place in moving:
            axis = place - start
            out[place] = 1.0 if robot.sliding[axis] else steps[axis + 1 : own + 1].sum() + last
        if not robot.sliding[own]:
            out[moving[-1]] = min(last, _from_axis(robot, own, pose, shape))
        return out

    def coupled(self, chain: Floats) -> Floats:
        """What joints of the chain move things (j, ...), as what the joints of rows move them."""
        out = chain.copy()
        for placed, columns in zip(self.robots, self.columns, strict=True):
            if placed.robot.coupling:  # J2 also turns what J3 turns
                second = columns.start + 1
                out[second] += abs(placed.robot.coupling) * chain[second + 1]
        return out


def _from_axis(robot: Robot, axis: int, pose: Pose, shape: Shape) -> float:
    """Mm that a point of a shape is away from the axis whose link carries it, at most."""
    along = np.array(robot.arm.whole_chain.joints[axis].axis)
    low, high = extent(shape)
    corners = np.array(list(product(*zip(low, high, strict=True))))
    placed = rotations.rotate(np.array(pose.quaternion), corners) + np.array(pose.position)
    return float(norms(np.cross(placed, along / np.linalg.norm(along))).max())


def link_lengths(robot: Robot) -> Floats:
    """(a + 1,) mm between the frames of links that follow each other, at most, base to flange."""
    chain = robot.arm.whole_chain
    poses = [*(joint.pose for joint in chain.joints), chain.flange]
    out = norms(np.array([pose.position for pose in poses]))
    for i, slides in enumerate(robot.sliding):
        if slides:  # the frame of the link slides away from its axis
            out[i] += np.abs(robot.limits[i] + robot.zero[i]).max()
    return np.asarray(out)


def carrier_of(scene: Scene, body: Body, carriers: Carriers) -> tuple[int, Pose]:
    """What carries a body, and its pose in the frame of that.

    Raises Refused for a parent that the scene has not, or that is carried by the body itself.
    """
    pose, parent, seen = body.pose, body.parent, {body.name}
    while parent not in carriers.names:
        if parent in seen:
            raise Refused(CIRCULAR_PARENTS(name=body.name, parent=parent), exit_status=2)
        seen.add(parent)
        if parent in scene.frames:
            return 0, scene.frames[parent] @ pose
        upper = scene.body(parent)
        if upper is None:
            known = _listed([*carriers.names, *scene.frames])
            raise Refused(NO_PARENT(name=body.name, parent=parent, known=known), exit_status=2)
        pose, parent = upper.pose @ pose, upper.parent
    return carriers.names[parent], pose


def _listed(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names[:12])

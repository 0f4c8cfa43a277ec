"""Random cells beside blended corners, judged by dense samples of the way and distances of our own.

The way is a line, and in a corner the parabola that touches both lines at the border of the zone;
the distance of a capsule is the least of points on its axis, that of a box the one of a point.
"""

from __future__ import annotations

import re

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.cell.link_bodies import place_robot, touching_links
from assistant.cell.scene import Body, Box, Capsule, Part, Scene, Shape, Sphere
from assistant.checks.clearances import clearances
from assistant.program.expressions import TargetValue
from assistant.program.geometry import Pose, Target, Tool
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Motion, Move

ARMS = ("irb1200-7-0.7", "rv-7frl", "irb120-3-0.58")
TIP = 100.0
BALL = 6.0
MARGIN = 12.0


class Case:
    """A random program around a random corner, with one body in the way of its tool."""

    def __init__(self, seed: int) -> None:
        self.draw = np.random.default_rng(seed)
        self.robot = robots.get(ARMS[seed % len(ARMS)])
        reach = self.robot.reach
        middle = np.array([0.55 * reach, 0.0, 0.35 * reach])
        while True:
            self.points = middle + self.draw.uniform(-0.16 * reach, 0.16 * reach, (4, 3))
            legs = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
            steps = np.diff(self.points, axis=0) / legs[:, None]
            turns = np.einsum("ij,ij->i", steps[1:], steps[:-1])
            if legs.min() > 40.0 and np.abs(turns).max() < 0.95 and self.solves():
                break
        self.zones = np.exp(self.draw.uniform(np.log(1.0), np.log(100.0), 2))
        self.way = self.sampled()
        self.joints = np.concatenate([self.approach(), self.solved(self.way)])
        clearance = float(np.exp(self.draw.uniform(np.log(0.2), np.log(10.0))))
        self.clearance = clearance if self.draw.random() < 0.6 else -clearance
        self.body = self.in_the_way()

    def solves(self) -> bool:
        steps = np.linspace(0.0, 1.0, 20)[:, None]
        ways = [a + steps * (b - a) for a, b in zip(self.points[:-1], self.points[1:], strict=True)]
        return bool(np.isfinite(self.solved(np.concatenate(ways))).all())

    def solved(self, tips: np.ndarray) -> np.ndarray:
        """Joints at tips of a tool that points down, in the branch of home."""
        down = np.tile([0.0, 1.0, 0.0, 0.0], (len(tips), 1))
        rows, valid = self.robot.ik(tips + np.array([0.0, 0.0, TIP]), down)
        rows = np.where(valid[..., None], rows, np.nan)
        off = np.abs(rows - self.robot.home).max(axis=2)
        best = np.nanmin(np.where(np.isnan(off), np.inf, off), axis=1)
        good = np.isfinite(best)
        which = np.where(np.isnan(off), np.inf, off).argmin(axis=1)
        return np.where(good[:, None], rows[np.arange(len(tips)), which], np.nan)

    def sampled(self) -> np.ndarray:
        a, b, c, d = self.points
        parts, start = [], a
        for here, (before, after), zone in zip((b, c), ((a, c), (b, d)), self.zones, strict=True):
            lengths = [np.linalg.norm(here - before), np.linalg.norm(after - here)]
            size = min(zone, *(length / 2.0 for length in lengths))
            enter = here + size * (before - here) / lengths[0]
            leave = here + size * (after - here) / lengths[1]
            parts.append(line(start, enter))
            u = np.linspace(0.0, 1.0, max(3, int(size / 0.1)))[:, None]
            parts.append((1 - u) ** 2 * enter + 2 * u * (1 - u) * here + u**2 * leave)
            start = leave
        return np.concatenate([*parts, line(start, d)])

    def approach(self) -> np.ndarray:
        """Joints of the move from home to the first point."""
        first = self.solved(self.points[:1])[0]
        part = np.linspace(0.0, 1.0, 4000)[:, None]
        return np.asarray(self.robot.home + part * (first - self.robot.home))

    def tips(self) -> np.ndarray:
        p, q = self.robot.fk(self.joints)
        return np.asarray(p + rotations.rotate(q, np.array([0.0, 0.0, TIP])))

    def in_the_way(self) -> Body:
        """A ball or a box that is nearest to the way by what the case wants."""
        corner = self.points[1 + self.draw.integers(2)]
        at = self.way[np.abs(np.linalg.norm(self.way - corner, axis=1)).argmin()]
        away = self.draw.normal(size=3)
        away[2] = -abs(away[2]) - 0.3
        away /= np.linalg.norm(away)
        sizes = self.draw.uniform(6.0, 40.0, 3)
        shape: Shape = Sphere(float(sizes[0]))
        if self.draw.random() < 0.6:
            shape = Box(tuple(sizes.tolist()))
        turn = random_turn(self.draw)
        low, high = -60.0, 200.0
        for _ in range(60):
            far = (low + high) / 2.0
            pose = Pose.of(at + far * away, turn)
            found = from_shape(shape, pose, self.way).min() - BALL
            low, high = (low, far) if found > self.clearance else (far, high)
        return Body("block", (Part(shape),), pose)

    def program(self) -> Program:
        moves = [("joint", FINE), *(("linear", Blend(float(z))) for z in self.zones)]
        moves += [("linear", FINE)]
        statements = [
            Move(
                kind,
                TargetValue(Target(Pose.of(point, (0.0, 1.0, 0.0, 0.0)))),
                Motion(Speed(200.0), blend, tool="pin"),
            )
            for point, (kind, blend) in zip(self.points, moves, strict=True)
        ]
        return Program(
            "way",
            (Procedure("main", tuple(statements)),),
            robot=self.robot.name,
            tools={"pin": Tool(Pose((0.0, 0.0, TIP)))},
        )

    def scene(self) -> Scene:
        arm = place_robot("arm", self.robot)
        pin = Body("pin", (Part(Sphere(BALL)),), Pose((0.0, 0.0, TIP)), parent="arm.flange")
        own = touching_links(arm)
        return Scene((self.body, pin), (arm,), allowed=own, margin=MARGIN)

    def truth(self, scene: Scene) -> dict[str, float]:
        """Least distances of the body from the ball and from the links, by their names."""
        shape, pose = self.body.parts[0].shape, self.body.pose
        out = {"pin": float(from_shape(shape, pose, self.tips()).min() - BALL)}
        origins, turns = self.robot.link_frames(self.joints[::4])
        for link in scene.robots[0].links:
            carrier = link.parent.removeprefix("arm.")
            if carrier == "base":
                continue
            number = self.robot.axes.index(carrier)
            least = np.inf
            for part in link.parts:
                assert isinstance(part.shape, Capsule)
                along = np.linspace(-0.5, 0.5, 41)[:, None] * [0.0, 0.0, part.shape.length]
                axis = rotations.rotate(np.array(part.pose.quaternion), along)
                axis = axis + np.array(part.pose.position)
                points = origins[:, number, None] + np.einsum("nij,sj->nsi", turns[:, number], axis)
                found = from_shape(shape, pose, points.reshape(-1, 3)).min() - part.shape.radius
                least = min(least, float(found))
            out[link.name] = least
        return out


def line(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    count = max(3, int(np.linalg.norm(end - start) / 0.1))
    return start + np.linspace(0.0, 1.0, count)[:, None] * (end - start)


def random_turn(draw: np.random.Generator) -> tuple[float, float, float, float]:
    w, x, y, z = draw.normal(size=4)
    size = float(np.sqrt(w * w + x * x + y * y + z * z))
    return float(w / size), float(x / size), float(y / size), float(z / size)


def from_shape(shape: Shape, pose: Pose, points: np.ndarray) -> np.ndarray:
    """(n,) mm of points (n, 3) from a ball or a box, below 0 inside."""
    w, x, y, z = pose.quaternion
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    local = (points - np.array(pose.position)) @ turn
    if isinstance(shape, Sphere):
        return np.linalg.norm(local, axis=1) - shape.radius
    assert isinstance(shape, Box)
    off = np.abs(local) - np.array(shape.size) / 2.0
    return np.linalg.norm(np.maximum(off, 0.0), axis=1) + np.minimum(off.max(axis=1), 0.0)


def judge(seed: int) -> None:
    case = Case(seed)
    solved = robots.solve_program(case.program(), case.robot)
    assert not [f for f in solved.findings if f.severity.name == "ERROR"], seed
    scene = case.scene()
    said: dict[str, tuple[str, float]] = {}
    for finding in clearances(solved, scene):
        names = re.findall(r"`([\w.]+)`", finding.message)[:2]
        if "block" in names:
            (name,) = {*names} - {"block"}
            least = re.search(r"within ([\d.]+) mm", finding.message)
            code, value = said.get(name, ("", np.inf))
            found = float(least[1]) if least else -1.0
            said[name] = (min(code or "CK999", finding.code), min(value, found))
    for name, least in case.truth(scene).items():
        code, value = said.get(name, ("", np.inf))
        if least < 0.0:
            assert code == "CK421", (seed, name, least, code)
        if least > 0.5:
            assert code not in ("CK421", "CK428"), (seed, name, least, code)
        if name == "pin" and 0.5 < least < MARGIN - 0.5:
            assert code == "CK422", (seed, name, least)
            assert abs(value - least) < 0.15, (seed, name, least, value)


@pytest.mark.parametrize("seed", range(2))
def test_contacts_beside_corners(seed: int) -> None:
    judge(seed)


@pytest.mark.slow
def test_two_hundred_cells() -> None:
    for seed in range(200):
        judge(1000 + seed)

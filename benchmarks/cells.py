"""Cells to plan in, with problems that have a known answer."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant import robots
from assistant.base.arrays import Floats
from assistant.cell import link_bodies
from assistant.cell.planning.space import Space, goal_joints
from assistant.cell.scene import Body, Box, Capsule, Part, PlacedRobot, Scene
from assistant.program.geometry import Pose

ARM: Final = robots.get("irb1200-7-0.7")
AHEAD: Final = (0.5**0.5, 0.0, 0.5**0.5, 0.0)
"""The tool along x of the base."""


def box(name: str, size: tuple[float, float, float], at: tuple[float, float, float]) -> Body:
    return Body(name, (Part(Box(size)),), Pose(at))


def scene_of(*bodies: Body, others: tuple[PlacedRobot, ...] = ()) -> Scene:
    """Bodies about an arm that carries a slim tool of 120 mm, its tip at `TIP`."""
    arm = link_bodies.place_robot("arm", ARM)
    tool = Body("tool", (Part(Capsule(12.0, 100.0)),), Pose((0.0, 0.0, 62.0)), "arm.flange")
    allowed = set(link_bodies.touching_links(arm))
    allowed |= {("arm.J6", "tool"), ("arm.J5", "tool"), ("arm.flange", "tool")}
    for other in others:
        allowed |= link_bodies.touching_links(other)
    return Scene((*bodies, tool), (arm, *others), allowed=frozenset(allowed))


TIP: Final = Pose((0.0, 0.0, 124.0))


def shelf() -> Scene:
    """Four boards with sides and a back before the arm: three bays, each open to it."""
    boards = [box(f"board{i}", (300, 700, 16), (700, 0, 150 + 260 * i)) for i in range(4)]
    sides = [box(f"side{i}", (300, 16, 796), (700, y, 540)) for i, y in enumerate((-358, 0, 358))]
    return scene_of(*boards, *sides, box("back", (16, 732, 796), (858, 0, 540)))


def window() -> Scene:
    """A wall before the arm with a hole of 170 by 170 mm, just wide enough for its wrist."""
    x, y, z, half = 560.0, 60.0, 620.0, 85.0
    return scene_of(
        box("below", (20, 1600, z - half), (x, 0, (z - half) / 2.0)),
        box("above", (20, 1600, 800), (x, 0, z + half + 400)),
        box("left", (20, 800 - y - half, 2 * half), (x, (800 + y + half) / 2.0, z)),
        box("right", (20, 800 + y - half, 2 * half), (x, -(800 - y + half) / 2.0, z)),
    )


def two_robots() -> Scene:
    """Another arm opposite, which reaches over a table between both."""
    other = link_bodies.place_robot("other", ARM, Pose((950.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
    return scene_of(box("table", (300, 800, 40), (480, 0, 150)), others=(other,))


CELLS: Final = {"shelf": shelf, "window": window, "two robots": two_robots}
REGIONS: Final = {
    "shelf": ((620.0, -300.0, 230.0), (700.0, 300.0, 830.0)),
    "window": ((620.0, 20.0, 580.0), (680.0, 100.0, 660.0)),
    "two robots": ((350.0, -350.0, 250.0), (560.0, 350.0, 600.0)),
}
"""Where the tip is at the end of a problem, low and high corner in mm."""
BACK: Final = 250.0
"""mm along x from such a place to where a straight way out of it ends."""


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """A way (n, a) that is free, and the pose of the tip at its end."""

    known: Floats
    goal: Pose
    others: dict[str, Floats]

    @property
    def start(self) -> Floats:
        return self.known[0]


def problems(cell: str, scene: Scene, count: int, seed: int) -> Iterator[Problem]:
    """Problems with a known answer: straight out of a place, then by free moves elsewhere.

    The way is made from its end: the tip goes back along x, and on by straight moves of the
    joints, each kept if it is free. So there is a way, as it was just gone.
    """
    draw = np.random.default_rng(seed)
    low, high = (np.array(corner) for corner in REGIONS[cell])
    while count:
        others = {}
        if len(scene.robots) > 1:
            swung = np.array([draw.uniform(-25, 25), draw.uniform(20, 55), *[0.0] * 4])
            others = {"other": swung + ARM.home}
        space = Space(scene, scene.robots[0], others=others, tool=TIP)
        place = draw.uniform(low, high)
        goal = Pose.of(place, np.array(AHEAD))
        ways = goal_joints(ARM, goal, ARM.home, TIP)
        ways = ways[space.free(ways)] if len(ways) else ways
        out = _out(space, place, ways[int(draw.integers(len(ways)))]) if len(ways) else None
        if out is None:
            continue
        back = [*out, *_wandering(space, out[-1], draw)]
        if len(back) - len(out) < 2:
            continue
        yield Problem(np.array(back)[::-1].copy(), goal, others)
        count -= 1


def _out(space: Space, place: Floats, at: Floats) -> list[Floats] | None:
    rows = [at]
    for gone in np.linspace(0.0, BACK, 26)[1:]:
        pose = Pose.of(place - np.array([gone, 0.0, 0.0]), np.array(AHEAD))
        ways = goal_joints(ARM, pose, rows[-1], TIP)
        if not len(ways) or np.abs(ways[0] - rows[-1]).max() > 20.0:
            return None
        if not space.clear(rows[-1][None], ways[:1])[0]:
            return None
        rows.append(ways[0])
    return rows


def _wandering(space: Space, at: Floats, draw: np.random.Generator) -> list[Floats]:
    low, high = ARM.limits.T
    rows: list[Floats] = []
    for _ in range(12):
        to = at + draw.uniform(0.2, 0.6) * (draw.uniform(low, high) - at)
        if space.clear(at[None], to[None])[0]:
            rows.append(at := to)
        if len(rows) == 3:
            break
    return rows

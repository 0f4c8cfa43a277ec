"""A map of explored space as bodies of a scene: what is not known to be free is in the way.

What is unknown reaches up to the surface of a body that has just been there, as cells that it fills
in part only are unknown still. So against unknown space each body is taken thinner by `SKIN` cells:
no less than from corner to corner of a cell, and what a body moves between two places at which it
was looked at. Every place that a robot has been at is clear then, and what is clear lies in free
space but for that skin. Against occupied cells a body counts with all it is.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from assistant.cell.collision.carriers import lengths
from assistant.cell.exploration.boxes import boxes_of
from assistant.cell.exploration.depths import thinner
from assistant.cell.exploration.filling import MOST, STEP, SURE, Filler
from assistant.cell.exploration.occupancy import Occupancy, State
from assistant.cell.exploration.rules import OTHER_GRID, TOO_FINE
from assistant.cell.scene import Body, Part, Scene
from assistant.cell.shapes import Box
from assistant.program.arrays import Floats, Ints, Truths, norms
from assistant.program.diagnostics import Refused
from assistant.program.geometry import Pose

SKIN: Final = 2.0 * SURE + STEP
"""Sizes of a cell that a body is taken thinner by."""
UNKNOWN_COLOUR: Final = (200, 200, 210)
OCCUPIED_COLOUR: Final = (200, 80, 60)


def with_map(scene: Scene, occupancy: Occupancy, name: str | None = None) -> Scene:
    """A scene with bodies `NAME.unknown` and `NAME.occupied` about a robot.

    They fill all that it can reach and that is not known to be free. Each of its bodies gets a
    thinner one, `….core`, that alone must keep out of what is unknown. Raises Refused for a map of
    another robot, or with more cells than can be handled.
    """
    filler = Filler(scene, name, occupancy.size)
    placed = filler.placed
    if placed.robot.name != occupancy.robot:
        one, other = f"the robot {placed.robot.name}", f"the robot {occupancy.robot}"
        raise Refused(OTHER_GRID(one=one, other=other), exit_status=2)
    moved = {body.name: body for body, _, _, _ in filler.moved()}
    cores = tuple(_core(body, SKIN * occupancy.size) for body in moved.values())
    first, occupied, unknown = _spaces(occupancy, farthest(filler))
    base = f"{placed.name}.base"
    spaces = tuple(
        Body(f"{placed.name}.{what}", parts, Pose(), base, colour, 0.0)
        for what, cells, colour in (
            ("occupied", occupied, OCCUPIED_COLOUR),
            ("unknown", unknown, UNKNOWN_COLOUR),
        )
        if (parts := _parts(boxes_of(cells) + first, occupancy.size))
    )
    out = replace(scene, bodies=(*scene.bodies, *cores, *spaces))
    everything = {body.name for body in out.all_bodies()}
    unknown_name, occupied_name = f"{placed.name}.unknown", f"{placed.name}.occupied"
    own = {core.name for core in cores}
    pairs = {(one, other) for one in own for other in everything - {unknown_name}}
    pairs |= {(unknown_name, other) for other in everything - own}
    pairs |= {(occupied_name, other) for other in everything - set(moved)}
    allowed = {(min(pair), max(pair)) for pair in pairs}
    return replace(out, allowed=scene.allowed | allowed)


def farthest(filler: Filler) -> float:
    """Mm from the origin of the base that nothing that the robot moves can be beyond."""
    steps = lengths(filler.placed.robot)
    reach = 0.0
    for part in filler.parts:
        corners = np.stack([part.low, part.high])
        ball = float(norms(np.abs(corners).max(axis=0)[None])[0])
        own = float(norms(np.array([part.pose.position]))[0]) + ball
        reach = max(reach, float(steps[: part.link + 1].sum()) + own)
    return reach


def _spaces(occupancy: Occupancy, reach: float) -> tuple[Ints, Truths, Truths]:
    """The first cell of what can be reached, and of its cells which are occupied and unknown."""
    half = int(np.ceil(reach / occupancy.size))
    count = (2 * half) ** 3
    if count > MOST:
        raise Refused(TOO_FINE(size=occupancy.size, count=count, most=MOST), exit_status=2)
    occupied = np.zeros((2 * half,) * 3, dtype=np.bool_)
    unknown = np.ones_like(occupied)
    for state in (State.FREE, State.OCCUPIED):
        cells = occupancy.cells(state) + half
        inside = cells[((cells >= 0) & (cells < 2 * half)).all(axis=1)]
        unknown[tuple(inside.T)] = False
        if state == State.OCCUPIED:
            occupied[tuple(inside.T)] = True
    return np.full(3, -half), occupied, unknown


def _parts(boxes: Ints, size: float) -> tuple[Part, ...]:
    return tuple(_part(box.astype(np.float64) * size) for box in boxes)


def _part(box: Floats) -> Part:
    x, y, z = (box[1] - box[0]).tolist()
    return Part(Box((x, y, z)), Pose.of(box.mean(axis=0), np.array([1.0, 0.0, 0.0, 0.0])))


def _core(body: Body, by: float) -> Body:
    parts = tuple(Part(thinner(part.shape, by), part.pose) for part in body.parts)
    return replace(body, name=f"{body.name}.core", parts=parts, margin=0.0, locations={})

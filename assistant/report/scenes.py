"""A cell as a table of its bodies, and as plain data."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.cell.collision.model import Carriers, carrier_of
from assistant.cell.scene import Body, Mesh, Scene, Shape, extent, surface

_HEADINGS: Final = ("body", "stands in", "shape", "from", "to", "margin")
"""From and to: the box around it in the world, mm, with all robots at home."""


def record(scene: Scene) -> dict[str, Any]:
    """Return the contents of the table as plain data: mm."""
    return {
        "robots": {placed.name: placed.robot.name for placed in scene.robots},
        "margin": scene.margin,
        "bodies": [
            {
                "name": body.name,
                "parent": body.parent,
                "shapes": [_kind(part.shape) for part in body.parts],
                "from": low.tolist(),
                "to": high.tolist(),
                "margin": body.margin,
                "locations": {
                    name: {"position": list(pose.position), "quaternion": list(pose.quaternion)}
                    for name, pose in body.locations.items()
                },
            }
            for body, low, high in _boxes(scene)
        ],
        "allowed": [list(pair) for pair in sorted(scene.allowed)],
    }


def lines(scene: Scene) -> Iterator[str]:
    """A line a robot, then headings and a line a body, in columns."""
    for placed in scene.robots:
        at = _said(np.array(placed.base.position))
        yield f"robot {placed.name}: {placed.robot.title}, its base at {at} mm"
    rows = [_HEADINGS, *(_row(*one, scene) for one in _boxes(scene))]
    widths = [max(len(row[i]) for row in rows) for i in range(len(_HEADINGS))]
    for row in rows if len(rows) > 1 else ():
        yield "  ".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
    count = sum(len(body.locations) for body in scene.bodies)
    if count:
        names = (f"{body.name} {name}" for body in scene.bodies for name in body.locations)
        yield f"locations: {', '.join(names)}"


def _row(body: Body, low: Floats, high: Floats, scene: Scene) -> tuple[str, ...]:
    shapes = list(dict.fromkeys(_kind(part.shape) for part in body.parts))
    what = f"{len(body.parts)} parts: " if len(body.parts) > 1 else ""
    margin = scene.margin if body.margin is None else body.margin
    return (
        body.name,
        body.parent,
        what + ", ".join(shapes),
        _said(low),
        _said(high),
        f"{margin:g} mm",
    )


def _kind(shape: Shape) -> str:
    if isinstance(shape, Mesh):
        state = "closed" if shape.solid else "open"
        return f"mesh of {len(shape.triangles)} triangles, {state}"
    return "hull" if type(shape).__name__ == "Convex" else type(shape).__name__.lower()


def _said(point: Floats) -> str:
    return ", ".join(f"{round(float(value), 1) + 0.0:g}" for value in point)


def _boxes(scene: Scene) -> Iterator[tuple[Body, Floats, Floats]]:
    """Each body, links among them, with the corners (3,) of the box around it in the world."""
    carriers = Carriers(scene.robots)
    homes = [np.asarray(placed.robot.home, dtype=np.float64) for placed in scene.robots]
    origins, turns = carriers.at(np.concatenate([np.zeros(0), *homes])[None])
    for body in scene.all_bodies():
        carrier, pose = carrier_of(scene, body, carriers)
        boxes = []
        for part in body.parts:
            placed = pose @ part.pose
            turn = turns[0, carrier] @ rotations.to_matrix(np.array(placed.quaternion))
            at = origins[0, carrier] + turns[0, carrier] @ np.array(placed.position)
            boxes.append(_box(part.shape, at, turn))
        low = np.min([box[0] for box in boxes], axis=0)
        yield body, low, np.max([box[1] for box in boxes], axis=0)


def _box(shape: Shape, at: Floats, turn: Floats) -> tuple[Floats, Floats]:
    """The least and the greatest coordinates (3,) of a shape at a place in the world."""
    low, high = extent(shape)
    corners = surface(shape).points
    points = np.concatenate([corners, [low, high]]) if turn.trace() == 3.0 else corners
    points = points @ turn.T + at
    return points.min(axis=0), points.max(axis=0)

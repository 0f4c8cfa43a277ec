"""A map of explored space as bodies of a scene: what is not known to be free is in the way.

What is unknown reaches up to the surface of a body that has just been there, as cells that it fills
in part only are unknown still. So against unknown space each body is taken thinner by `SKIN` cells:
no less than from corner to corner of a cell, and what a body moves between two places at which it
was looked at. Every place that a robot has been at is clear then, and what is clear lies in free
space but for that skin. Against occupied cells a body counts with all it is.

Unknown space is one mesh of its surface, however ragged that is: so each body has one pair with it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Ints, Truths, norms
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.cell.collision.carriers import carrier_of, link_lengths
from assistant.cell.exploration.boxes import boxes_of, surface_of
from assistant.cell.exploration.depths import thinner_shape
from assistant.cell.exploration.filling import HALF_DIAGONAL, MOST_CELLS, STEP_IN_CELLS, Filler
from assistant.cell.exploration.occupancy import CellState, Occupancy, cells_at, cells_of_keys
from assistant.cell.exploration.rules import (
    CELLS_TOO_LARGE,
    CHART_BODY_NAME,
    OPEN_BODY,
    OTHER_GRID,
    SKIN_IN_UNKNOWN,
    TOO_FINE,
)
from assistant.cell.scene import CORE_SUFFIX, OCCUPIED_SUFFIX, UNKNOWN_SUFFIX, Body, Part, Scene
from assistant.cell.shapes import Box, Mesh, extent
from assistant.program.geometry import Pose

SKIN: Final = 2.0 * HALF_DIAGONAL + STEP_IN_CELLS
"""Sizes of a cell that a body is taken thinner by."""
OCCUPIED_COLOUR: Final = (200, 80, 60)


def with_map(
    scene: Scene, occupancy: Occupancy, name: str | None = None, *, blocked: bool = True
) -> Scene:
    """A scene with bodies `NAME.unknown` and `NAME.occupied` about a robot.

    They fill all that it can reach and that is not known to be free. Each body that it moves, or
    takes while a program runs, gets a thinner one, `….core`, that alone must keep out of what is
    unknown; what the latter fill where they stand at first is known. blocked: False for occupied
    space only, where the scene's own bodies tell all else. Raises Refused for a map of another
    robot, or with more cells than can be handled.
    """
    return mapped(scene, occupancy, name, blocked=blocked)[0]


def mapped(
    scene: Scene, occupancy: Occupancy, name: str | None = None, *, blocked: bool = True
) -> tuple[Scene, tuple[Diagnostic, ...]]:
    """As `with_map`, with findings: how much of a body unknown space may have, and bodies that have
    explored nothing, so that they are in unknown space wherever no other has been.
    """
    filler = Filler(scene, name, occupancy.size)
    placed = filler.placed
    if placed.robot.name != occupancy.robot:
        one, other = f"the robot {placed.robot.name}", f"the robot {occupancy.robot}"
        raise Refused(OTHER_GRID(one=one, other=other), exit_status=2)
    moved = {body.name: body for body, _, _, _ in filler.moved()}
    taken = {b.name: b for b in scene.bodies if b.taken is not None and b.name not in moved}
    skin = SKIN * occupancy.size
    cores = (
        *(_core(body, skin) for body in moved.values()),
        *(_core_on(body, placed.name, skin) for body in taken.values()),
    )
    standing = [_standing(filler, body) for body in taken.values()]
    reach = farthest_reach(filler, taken.values())
    first, occupied, known = _spaces(occupancy, np.concatenate([*standing, occupancy.keys]))
    base = f"{placed.name}.base"
    boxes = _boxes(occupied, first, occupancy.size)
    spaces = [Body(placed.name + OCCUPIED_SUFFIX, boxes, Pose(), base, OCCUPIED_COLOUR, 0.0)]
    if blocked:
        part = Part(_around(known, first, occupancy.size, reach))
        spaces.append(
            Body(placed.name + UNKNOWN_SUFFIX, (part,), Pose(), base, margin=0.0, shown=False)
        )
    spaces = [body for body in spaces if body.parts]
    out = replace(scene, bodies=(*scene.bodies, *(cores if blocked else ()), *spaces))
    added = {body.name for body in out.bodies[len(scene.bodies) :]}
    for body in scene.all_bodies():
        if body.name in added:
            raise Refused(CHART_BODY_NAME(name=body.name), exit_status=2)
    everything = {body.name for body in out.all_bodies()}
    unknown_name, occupied_name = placed.name + UNKNOWN_SUFFIX, placed.name + OCCUPIED_SUFFIX
    own = {core.name for core in cores}
    pairs = {(one, other) for one in own for other in everything - {unknown_name}}
    pairs |= {(unknown_name, other) for other in everything - own}
    pairs |= {(occupied_name, other) for other in everything - {*moved, *taken}}
    allowed = {(min(pair), max(pair)) for pair in pairs}
    findings = (*_thin(filler), SKIN_IN_UNKNOWN(name=placed.name, skin=skin)) if blocked else ()
    return replace(out, allowed=scene.allowed | allowed), findings


def _thin(filler: Filler) -> Iterator[Diagnostic]:
    """Bodies that are thinner than the skin that is taken off them."""
    yield from (finding for finding in filler.findings if finding.code == OPEN_BODY.code)
    deepest: dict[str, float] = {}
    for part in filler.parts:
        name = part.body.name
        deepest[name] = min(deepest.get(name, np.inf), part.solid.deepest)
    for name, deep in deepest.items():
        if deep < SKIN * filler.size:
            yield CELLS_TOO_LARGE(name=name, size=filler.size, better=deep / SKIN)


def farthest_reach(filler: Filler, taken: Iterable[Body] = ()) -> float:
    """Mm from the origin of the base that nothing that the robot moves, or takes, can be beyond."""
    steps = link_lengths(filler.placed.robot)
    reach = 0.0
    for part in filler.parts:
        corners = np.stack([part.low, part.high])
        ball = float(norms(np.abs(corners).max(axis=0)[None])[0])
        own = float(norms(np.array([part.pose.position]))[0]) + ball
        reach = max(reach, float(steps[: part.link + 1].sum()) + own)
    reach = max(reach, float(steps.sum()))
    return reach + max((_across(body, filler.scene.margin) for body in taken), default=0.0)


def _across(body: Body, margin: float) -> float:
    """Mm that no point of a body is farther from what it is within its margin of."""
    places = np.array([part.pose.position for part in body.parts]).reshape(-1, 3)
    radii = [
        float(norms(np.abs(np.stack(extent(p.shape))).max(axis=0)[None])[0]) for p in body.parts
    ]
    ball = float((norms(places) + radii).max(initial=0.0))
    return 2.0 * ball + (margin if body.margin is None else body.margin)


def _standing(filler: Filler, body: Body) -> Ints:
    """Keys of the cells that a body fills where it stands at first; of none that moves."""
    carrier, pose = carrier_of(filler.scene, body, filler.carriers)
    if carrier == 0:
        return filler.inside(body, filler.placed.base.inverse() @ pose)
    base = filler.carriers.names[f"{filler.placed.name}.base"]
    return filler.inside(body, pose) if carrier == base else np.zeros(0, dtype=np.int64)


def _spaces(occupancy: Occupancy, keys: Ints) -> tuple[Ints, Truths, Truths]:
    """The first cell of the box about some keys, and of its cells which are occupied, which known.

    keys: of all that is known.
    """
    cells, touched = cells_of_keys(keys), occupancy.cells(CellState.OCCUPIED)
    if not len(cells):
        return np.zeros(3, dtype=np.int64), *np.zeros((2, 1, 1, 1), dtype=np.bool_)
    first = cells.min(axis=0)
    shape = cells.max(axis=0) - first + 1
    if int(np.prod(shape)) > MOST_CELLS:
        count = int(np.prod(shape))
        raise Refused(TOO_FINE(size=occupancy.size, count=count, most=MOST_CELLS), exit_status=2)
    occupied, known = np.zeros((2, *shape), dtype=np.bool_)
    known[tuple((cells - first).T)] = True
    occupied[tuple((touched - first).T)] = True
    return first, occupied, known


def _around(known: Truths, first: Ints, size: float, reach: float) -> Mesh:
    """All in reach but the known cells, the first of which is at a place of the grid."""
    corners, triangles = surface_of(known)
    outer, sides = surface_of(np.ones((1, 1, 1), dtype=np.bool_))
    farthest_known = np.abs((corners + first) * size).max(initial=0.0)
    half = max(reach, farthest_known) + size

    def within(points: Floats) -> Truths:
        places = cells_at(points, size) - first
        inside = np.asarray(((places >= 0) & (places < known.shape)).all(axis=1))
        out = np.asarray((np.abs(points) < half).all(axis=1))
        out[inside] = ~known[tuple(places[inside].T)]
        return out

    points = np.concatenate([(corners + first) * size, (2.0 * outer - 1.0) * half])
    faces = np.concatenate([triangles[:, ::-1], sides + len(corners)])
    return Mesh(points, faces, within=within)


def _boxes(cells: Truths, first: Ints, size: float) -> tuple[Part, ...]:
    return tuple(_part(box.astype(np.float64) * size) for box in boxes_of(cells) + first)


def _part(box: Floats) -> Part:
    x, y, z = (box[1] - box[0]).tolist()
    return Part(Box((x, y, z)), Pose.of(box.mean(axis=0), np.array([1.0, 0.0, 0.0, 0.0])))


def _core(body: Body, by: float) -> Body:
    parts = tuple(Part(thinner_shape(part.shape, by), part.pose) for part in body.parts)
    return Body(body.name + CORE_SUFFIX, parts, body.pose, body.parent, margin=0.0, shown=False)


def _core_on(body: Body, robot: str, by: float) -> Body:
    """Of what a program takes: it goes where that goes."""
    core = _core(body, by)
    return replace(core, name=f"{robot}.{core.name}", parent=body.name, pose=Pose())

"""Explored space as bodies of a scene: space that is not known to be free is an obstacle.

Unknown space reaches up to the surface of a body that has just been there, as cells that it fills
only in part are still unknown. So against unknown space each body is thinner by `_SKIN` cells: the
diagonal of a cell, and what a body moves between two positions at which it was tested. Every
position at which a robot has been is clear then, and clear space is free space but for that skin.
Against occupied cells a body counts in full.

Unknown space is one mesh of its surface, however ragged, so each body has one pair with it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Ints, Truths, norms
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.cell.collision.model import carrier_of, link_lengths
from assistant.cell.exploration.filled_cells import (
    HALF_DIAGONAL,
    MOST_CELLS,
    STEP_IN_CELLS,
    Filler,
    thinner_shape,
)
from assistant.cell.exploration.occupancy import CellState, Occupancy, cells_at, cells_of_keys
from assistant.cell.findings import (
    CELLS_TOO_LARGE,
    CHART_BODY_NAME,
    OPEN_BODY,
    OTHER_GRID,
    SKIN_IN_UNKNOWN,
    TOO_FINE,
)
from assistant.cell.scene import (
    CORE_SUFFIX,
    OCCUPIED_SUFFIX,
    UNKNOWN_SUFFIX,
    Body,
    Box,
    Mesh,
    Part,
    Scene,
    extent,
)
from assistant.program.geometry import Pose


def boxes_of(cells: Truths) -> Ints:
    """(k, 2, 3) first and last-but-one-after cells of boxes that hold the true cells (x, y, z).

    Runs along one axis, runs of like runs along the next, and of these along the last; of the six
    orders of axes the one with the fewest boxes.
    """
    return min((_along(cells, order) for order in itertools.permutations(range(3))), key=len)


def surface_of(cells: Truths) -> tuple[Ints, Ints]:
    """Return the surface of the true cells (x, y, z): corners (n, 3) and triangles (m, 3) of their
    rows.

    Each rectangle of faces in one plane has separate corners and two triangles, which are
    counter-clockwise as seen from outside.
    """
    padded = np.pad(cells, 1).astype(np.int8)
    rectangles = [np.zeros((0, 4, 3), dtype=np.int64)]
    for axis in range(3):
        inner = tuple(slice(None) if k == axis else slice(1, -1) for k in range(3))
        steps = np.diff(padded, axis=axis)[inner]  # at the plane before cell i: 1 where it begins
        for side in (1, -1):
            corners = _rectangles(steps == side, axis)
            # The first edge is along the next axis, the other along the one after that.
            rectangles.append(corners if side == -1 else corners[:, ::-1])
    corners = np.concatenate(rectangles)
    first = 4 * np.arange(len(corners))[:, None]
    triangles = np.concatenate([first + np.array(half) for half in ((0, 1, 2), (0, 2, 3))])
    return corners.reshape(-1, 3), triangles


def _rectangles(faces: Truths, axis: int) -> Ints:
    """(k, 4, 3) corners of rectangles of true faces in planes across an axis, counter-clockwise as
    seen from where the axis leads.
    """
    one, other = (axis + 1) % 3, (axis + 2) % 3
    first, last = min(
        (_runs(faces, (axis, *order), (1,)) for order in ((one, other), (other, one))),
        key=lambda found: len(found[0]),
    )
    out = np.empty((len(first), 4, 3), dtype=np.int64)
    out[:, :, axis] = first[:, None, axis]
    out[:, [0, 3], one], out[:, [1, 2], one] = first[:, None, one], last[:, None, one]
    out[:, [0, 1], other], out[:, [2, 3], other] = first[:, None, other], last[:, None, other]
    return out


def _along(cells: Truths, order: tuple[int, ...]) -> Ints:
    return np.stack(_runs(cells, order, (1, 0)), axis=1)


def _runs(cells: Truths, order: tuple[int, ...], joined: tuple[int, ...]) -> tuple[Ints, Ints]:
    """(k, 3) first and last-but-one-after cells of runs along the last of an order of the axes.

    joined: places in that order of the axes along which like runs become one.
    """
    turned = np.moveaxis(cells, order, (0, 1, 2))
    edges = np.diff(np.pad(turned.astype(np.int8), ((0, 0), (0, 0), (1, 1))), axis=2)
    first, stops = np.argwhere(edges == 1), np.argwhere(edges == -1)[:, 2]
    last = np.column_stack([first[:, :2] + 1, stops])
    for axis in joined:
        first, last = _joined(first, last, axis)
    back = list(np.argsort(order))
    return first[:, back], last[:, back]


def _joined(first: Ints, last: Ints, axis: int) -> tuple[Ints, Ints]:
    """Boxes that follow each other along an axis and are alike across it, as one."""
    if not len(first):
        return first, last
    others = [k for k in range(3) if k != axis]
    across = np.column_stack([first[:, others], last[:, others]])
    order = np.lexsort((first[:, axis], *across.T))
    first, last, across = first[order], last[order], across[order]
    new = np.append(
        True, (across[1:] != across[:-1]).any(axis=1) | (first[1:, axis] != last[:-1, axis])
    )
    begins = np.flatnonzero(new)
    ends = np.append(begins[1:], len(first)) - 1
    out = last[begins].copy()
    out[:, axis] = last[ends, axis]
    return first[begins], out


_SKIN: Final = 2.0 * HALF_DIAGONAL + STEP_IN_CELLS
"""Sizes of a cell that a body is taken thinner by."""
_OCCUPIED_COLOUR: Final = (200, 80, 60)


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
    """Return the scene of `with_map` with findings: how much unknown space may overlap a body, and
    bodies that have explored nothing, so that they are in unknown space wherever no other body has
    been.
    """
    filler = Filler(scene, name, occupancy.size)
    placed = filler.placed
    if placed.robot.name != occupancy.robot:
        one, other = f"the robot {placed.robot.name}", f"the robot {occupancy.robot}"
        raise Refused(OTHER_GRID(one=one, other=other), exit_status=2)
    moved = {body.name: body for body, _, _, _ in filler.moved()}
    taken = {b.name: b for b in scene.bodies if b.taken is not None and b.name not in moved}
    skin = _SKIN * occupancy.size
    cores = (
        *(_core(body, skin) for body in moved.values()),
        *(_core_on(body, placed.name, skin) for body in taken.values()),
    )
    standing = [_standing(filler, body) for body in taken.values()]
    reach = _farthest_reach(filler, taken.values())
    first, occupied, known = _spaces(occupancy, np.concatenate([*standing, occupancy.keys]))
    base = f"{placed.name}.base"
    boxes = _boxes(occupied, first, occupancy.size)
    spaces = [Body(placed.name + OCCUPIED_SUFFIX, boxes, Pose(), base, _OCCUPIED_COLOUR, 0.0)]
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
        if deep < _SKIN * filler.size:
            yield CELLS_TOO_LARGE(name=name, size=filler.size, better=deep / _SKIN)


def _farthest_reach(filler: Filler, taken: Iterable[Body] = ()) -> float:
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
    """Return the core of a body that a program takes: it moves with that body."""
    core = _core(body, by)
    return replace(core, name=f"{robot}.{core.name}", parent=body.name, pose=Pose())

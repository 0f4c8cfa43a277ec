"""One contour in the words of the program: approach, switch on, follow, switch off, retract.

Where a contour begins and ends are targets with names of their own. The places above them are
given relative to those, so that whoever teaches one of them anew moves all of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from assistant.program import rotations
from assistant.program.arrays import Floats
from assistant.program.diagnostics import Diagnostic, error
from assistant.program.expressions import Name, Number
from assistant.program.geometry import BASE, Frame, Pose, Target, Vector
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.path import Kind, Path
from assistant.program.program import TakenNames, identifier
from assistant.program.statements import (
    Follow,
    Motion,
    Move,
    MoveCircular,
    SetSignal,
    Statement,
    Wait,
)
from assistant.sources.contours.curves import Points
from assistant.sources.contours.moves import FLATTENED, Moves
from assistant.sources.contours.ordering import Measure
from assistant.sources.contours.orientation import along, facing, level, turned
from assistant.sources.process import Layer, Process
from assistant.sources.process.values import shown
from assistant.sources.rounding import radii
from assistant.sources.standing import Standing, backed_off, to, way_in
from assistant.sources.surroundings import seconds

MOVING_FRAME = error(
    "CT207",
    "contours of layer {layer!r} cannot be put from frame `{drawing}` into `{frame}`: "
    "one of them moves",
    "use a frame that stands still",
)
UNKNOWN_FRAME = error(
    "CT208",
    "there is no frame `{frame}` for layer {layer!r}",
    "define it under [frames] in the process file",
)

HALF_TURN: Final = 180.0 + 1e-6
"""Degrees that a tool is wound up by over which the way back is another one."""

SAME: Final = 1e-6
"""mm, degrees and parts of a quaternion that tell no two places apart."""


@dataclass(frozen=True, slots=True)
class Placed:
    """How the drawing stands in a layer's frame, and where the tool points there."""

    pose: Pose
    direction: Vector

    @staticmethod
    def of(name: str, layer: Layer, process: Process) -> Placed | Diagnostic:
        length = float(np.linalg.norm(layer.direction))
        if not (np.isfinite(length) and length > 0.0):
            raise ValueError(f"{layer.direction} is no direction")
        direction = np.asarray(layer.direction) / length
        drawing, wanted = process.defaults.frame, layer.motion.frame
        pose = Pose()
        if drawing != wanted:
            frames = {BASE: Frame(), **process.frames}
            for frame in (drawing, wanted):
                if frame not in frames:
                    return UNKNOWN_FRAME(frame=shown(frame), layer=shown(name))
            if any(frames[f].held or frames[f].mechanism for f in (drawing, wanted)):
                return MOVING_FRAME(layer=shown(name), drawing=drawing, frame=wanted)
            pose = frames[wanted].pose.inverse() @ frames[drawing].pose
        x, y, z = rotations.rotate(pose.quaternion, direction).tolist()
        return Placed(pose, (x, y, z))

    def rows(self, rows: Moves) -> Moves:
        if self.pose == Pose():
            return rows
        turn = self.pose.quaternion
        return replace(
            rows,
            start=rotations.rotate(turn, rows.start) + self.pose.position,
            positions=rotations.rotate(turn, rows.positions) + self.pose.position,
            leaving=rotations.rotate(turn, rows.leaving),
            arriving=rotations.rotate(turn, rows.arriving),
        )


@dataclass(frozen=True, slots=True)
class Followed:
    """The statements of a contour, the targets that they name, degrees the tool has turned."""

    statements: tuple[Statement, ...]
    targets: Mapping[str, Target]
    wound: float
    findings: tuple[Diagnostic, ...] = ()


def follow(
    name: str,
    drawn: Moves,
    layer: Layer,
    placed: Placed,
    before: float | None,
    process: Process,
    taken: TakenNames,
) -> Followed:
    """Approach, switch on, follow, switch off, retract.

    name: of the path; its ends are `<name>_start` and `<name>_end`, one target where the contour
    comes back to its start with the tool as it was. before: the degrees of the contour before,
    None for the first one. process: its tolerance is what corners without a stated size may be cut
    by, and what stands around the work tells where the tool comes from. taken: names that must not
    be used.
    """
    moved = placed.rows(drawn)
    pose, path = _path(name, moved, layer, placed.direction, (1 - FLATTENED) * process.tolerance)
    wound = turned(np.concatenate([[pose.quaternion], path.quaternions]), placed.direction)
    start, end, via = (identifier(f"{name}_{k}", taken) for k in ("start", "end", "via"))
    targets = {start: Target(pose)}
    last = path.target(len(path) - 1)
    if abs(wound) < SAME and _same(pose, last.pose):
        end = start
    else:
        targets[end] = last
    kind = "travel" if process.defaults.travels else _kind(before, layer)
    motion = layer.motion
    travel = replace(motion, speed=layer.travel, blend=FINE)
    plunge = replace(motion, speed=_slower(motion, layer.travel), blend=FINE)
    standing = Standing.of(process, motion)
    into = way_in(standing, pose, layer.approach, start)
    out = into
    if (end, layer.retract) != (start, layer.approach):
        out = way_in(standing, targets[end].pose, layer.retract, end)
    statements: list[Statement] = []
    if layer.approach > 0.0:
        statements.append(to(kind, backed_off(start, layer.approach, into), travel))
        statements.append(Move("linear", Name(start), plunge))
    else:
        statements.append(to(kind, Name(start), travel))
    statements += [SetSignal(signal, _number(value)) for signal, value in layer.on]
    if layer.delay > 0.0:
        statements.append(Wait(_number(layer.delay)))
    arc = path.kinds[-1] == Kind.END
    if rest := len(path) - (2 if arc else 1):
        statements.append(Follow(path.rows(0, rest)))
    stop = replace(motion, blend=FINE)
    if arc:
        targets[via] = path.target(rest)
        statements.append(MoveCircular(Name(via), Name(end), stop))
    else:
        statements.append(Move("linear", Name(end), stop))
    statements += [SetSignal(signal, _number(value)) for signal, value in layer.off]
    if layer.retract > 0.0:
        statements.append(Move("linear", backed_off(end, layer.retract, out), travel))
    findings = dict.fromkeys((*into.findings, *out.findings))
    return Followed(tuple(statements), targets, wound, tuple(findings))


def measured(layer: Layer, placed: Placed, standing: Standing | None) -> Measure | None:
    """The seconds of travel above points of a layer; None if nobody knows what is around.

    The turn of a tool that follows the contours is left out.
    """
    if standing is None:
        return None
    turn = facing(placed.direction, level(placed.direction)[None])[0]
    up = -layer.approach * np.asarray(placed.direction)

    def places(points: Points) -> Floats | None:
        drawn = rotations.rotate(placed.pose.quaternion, points) + placed.pose.position
        return standing.places(drawn + up, turn)

    return Measure(places, seconds)


def _same(one: Pose, other: Pose) -> bool:
    """Whether poses are the same but for the noise of computing them."""
    numbers = (*one.position, *one.quaternion), (*other.position, *other.quaternion)
    return bool(np.allclose(*numbers, rtol=0.0, atol=SAME))


def _kind(wound: float | None, layer: Layer) -> Literal["joint", "linear"]:
    """How the tool comes from one contour, along which it has turned by degrees, to the next.

    A line turns it the shorter way, so that a tool that follows closed contours would wind up
    with each of them; a joint move lets the wrist turn back. It is made above the work only.
    """
    if wound is None:
        return "joint"
    if not layer.tangential or not (layer.approach > 0.0 and layer.retract > 0.0):
        return "linear"
    return "joint" if abs(wound) > HALF_TURN else "linear"


def _slower(motion: Motion, travel: Speed) -> Speed:
    """Towards the work: never faster than along the contour, as far as that is known."""
    speed = motion.speed
    return speed if isinstance(speed, Speed) and speed.tcp < travel.tcp else travel


def _number(value: float) -> Number:
    return Number(int(value) if value == int(value) else value)


def _path(
    name: str, rows: Moves, layer: Layer, direction: Vector, tolerance: float
) -> tuple[Pose, Path]:
    """The start's pose, and the path of the rows; it stops at its end and where it turns.

    tolerance: mm that cutting a corner may leave the drawing by, with what fitting has used.
    """
    if layer.tangential:
        first, axes, chosen = along(rows, direction)
        begin, quaternions = facing(direction, first[None]), facing(direction, axes)
    else:
        chosen = np.arange(len(rows))
        begin = facing(direction, level(direction)[None])
        quaternions = np.broadcast_to(begin, (len(rows), 4))
    stops = np.zeros(len(chosen), dtype=np.int32)
    again = np.flatnonzero(chosen[1:] == chosen[:-1])
    stops[again] = stops[again + 1] = stops[-1] = 1
    kinds = rows.kinds[chosen]
    kinds[again + 1] = Kind.LINEAR  # turning on the spot is a linear move, whatever led there
    motion, positions = layer.motion, rows.positions[chosen]
    (speed, blend), blends = motion.fixed, tuple[Blend | Name, ...]()
    blends = (blend, FINE)
    if layer.rounded:
        sizes = _corners(rows.start, positions, kinds, tolerance - rows.deviation)
        table, index = np.unique(sizes, return_inverse=True)
        blends = (*(Blend(size) if size > 0.0 else FINE for size in table.tolist()), FINE)
        stops = np.where(stops == 1, len(table), index)
    path = Path.of(
        name,
        positions,
        quaternions,
        kinds=kinds,
        speeds=(speed,),
        blends=blends,
        blend=stops,
        tools=(motion.tool,),
        frames=(motion.frame,),
    )
    return Pose.of(rows.start, begin[0]), path


def _corners(
    start: Points, positions: Points, kinds: NDArray[np.uint8], tolerance: float
) -> Floats:
    """Sizes (n,) of the corners in mm, 0 for a stop; the two rows of an arc have one."""
    way, led = np.vstack([start, positions]), np.concatenate([[Kind.LINEAR], kinds])
    sizes = radii(way, led, np.ones(len(positions), dtype=np.bool_), tolerance)[1:]
    via = np.flatnonzero(kinds == Kind.VIA)
    sizes[via] = sizes[via + 1]
    return sizes

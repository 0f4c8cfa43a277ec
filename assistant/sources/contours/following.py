"""One contour in the words of the program: approach, switch on, follow, switch off, retract.

Where a contour begins and ends are targets with names of their own. The places above them are
given relative to those, so that whoever teaches one of them anew moves all of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic, error
from assistant.program.expressions import Name
from assistant.program.geometry import BASE, Frame, Pose, Target, Vector
from assistant.program.motion import FINE, Blend, Kind, Path, Speed
from assistant.program.program import TakenNames, identifier
from assistant.program.settings_tables import shown
from assistant.program.statements import Follow, Motion, Move, MoveCircular, Statement, Trigger
from assistant.sources.contours.chaining import Contour
from assistant.sources.contours.curves import (
    Arc,
    Curve,
    FreeCurve,
    Points,
    arc_sweeps,
    chorded,
    cross,
)
from assistant.sources.contours.moves import FLATTENING_PART, Moves
from assistant.sources.contours.ordering import TravelMeasure
from assistant.sources.contours.orientation import (
    degrees_turned,
    facing_quaternions,
    level_x_axis,
    x_axes_along,
)
from assistant.sources.contours.pacing import MovesWithSpeeds, move_lengths, with_speeds
from assistant.sources.contours.switching import NoRoomForOutputs, contour_outputs, divided_at
from assistant.sources.process import Layer, Process
from assistant.sources.rounding import rounding_radii
from assistant.sources.standing import FramedSurroundings, approach_of, backed_off_target, move_to
from assistant.sources.surroundings import travel_seconds

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

PEAK_CHORD: Final = 1e-3
"""mm that chords of a free curve are off where its highest point is looked for."""

SAME_POSE: Final = 1e-6
"""mm, degrees and parts of a quaternion that tell no two places apart."""


@dataclass(frozen=True, slots=True)
class PlacedLayer:
    """How the drawing stands in a layer's frame, and where the tool points there."""

    pose: Pose
    direction: Vector

    @staticmethod
    def of(name: str, layer: Layer, process: Process) -> PlacedLayer | Diagnostic:
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
        return PlacedLayer(pose, (x, y, z))

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
class FollowedContour:
    """The statements of a contour, the targets that they name, degrees the tool has turned.

    corners: that are gone round at the speed of corners.
    """

    statements: tuple[Statement, ...]
    targets: Mapping[str, Target]
    wound: float | None
    findings: tuple[Diagnostic, ...] = ()
    corners: int = 0


def follow_contour(
    name: str,
    drawn: Moves,
    layer: Layer,
    placed: PlacedLayer,
    before: float | None,
    process: Process,
    taken: TakenNames,
    top: float = 0.0,
    *,
    drawn_on: str = "",
    stays: bool = False,
) -> FollowedContour:
    """Approach, switch on, follow, switch off, retract.

    name: of the path; its ends are `<name>_start` and `<name>_end`, one target where the contour
    comes back to its start with the tool as it was. before: the degrees of the contour before,
    None where the tool comes from anywhere. process: its tolerance is what corners without a
    stated size may be cut by, and what stands around the work tells where the tool comes from.
    taken: names that must not be used. top: of the layer, see `highest`. drawn_on: the layer's
    name. stays: the arm stops above the end. Without statements there is no room for what the
    layer says.
    """
    moved = placed.rows(drawn)
    flat = FLATTENING_PART * process.tolerance
    total = float(move_lengths(moved.start, moved.positions, moved.kinds).sum())
    made = with_speeds(moved, layer.pace, divided_at(layer, total), flat)
    pose, path = _contour_path(name, made, layer, placed.direction, process.tolerance - flat)
    wound = degrees_turned(np.concatenate([[pose.quaternion], path.quaternions]), placed.direction)
    start, end = (identifier(f"{name}_{k}", taken) for k in ("start", "end"))
    targets = {start: Target(pose)}
    last = path.target(len(path) - 1)
    if abs(wound) < SAME_POSE and _are_same_poses(pose, last.pose):
        end = start
    else:
        targets[end] = last
    kind = "travel" if process.defaults.travels else _travel_kind(before, layer)
    motion, above = layer.motion, layer.above
    travel = replace(motion, speed=layer.travel, blend=above.blend)
    plunge = replace(motion, speed=_slower_motion(motion, layer.travel), blend=FINE)
    standing = FramedSurroundings.of(process, motion)
    high = TravelHeights.of(layer, placed, top, pose, last.pose)
    into = approach_of(standing, pose, high.before, start)
    out = into
    if (end, high.after) != (start, high.before):
        out = approach_of(standing, targets[end].pose, high.after, end)
    way = move_lengths(np.array(pose.position), path.positions, path.kinds)
    speeds = np.array([one.tcp if isinstance(one, Speed) else 0.0 for one in path.speeds])
    try:
        switched = contour_outputs(layer, way, high.after, speeds[path.speed])
    except NoRoomForOutputs as unfit:
        return FollowedContour((), {}, None, (unfit.rule(layer=shown(drawn_on), **unfit.fields),))
    statements: list[Statement] = []
    if high.before > 0.0:
        statements.append(move_to(kind, backed_off_target(start, high.before, into), travel))
        if 0.0 < layer.approach < high.before:
            statements.append(
                Move("linear", backed_off_target(start, layer.approach, into), travel)
            )
        statements.append(Move("linear", Name(start), plunge, switched.first))
    else:
        statements.append(move_to(kind, Name(start), travel))
    statements += switched.before
    along_it, named = _path_statements(path, switched.on_way, end, taken)
    statements += along_it
    targets |= named
    statements += switched.after
    if high.after > 0.0:
        leaving = replace(travel, blend=FINE) if stays else travel
        up = backed_off_target(end, high.after, out)
        statements.append(Move("linear", up, leaving, switched.last))
    findings = dict.fromkeys((*into.findings, *out.findings))
    return FollowedContour(tuple(statements), targets, wound, tuple(findings), made.corners)


def _path_statements(
    path: Path, on_way: Mapping[int, tuple[Trigger, ...]], end: str, taken: TakenNames
) -> tuple[list[Statement], dict[str, Target]]:
    """The statements along a path, and the targets that they name but for its end.

    on_way: what moves set, by the row that ends them; those and the last one are statements of
    their own. end: the name of the end.
    """
    statements: list[Statement] = []
    targets: dict[str, Target] = {}
    done, parts = 0, 0
    for row in sorted({*on_way, len(path) - 1}):
        arc = path.kinds[row] == Kind.END
        if (first := row - 1 if arc else row) > done:
            parts += 1
            part = path.name if parts == 1 else identifier(f"{path.name}_part", taken)
            taken.add(part)
            statements.append(Follow(path.rows(done, first, part)))
        done = row + 1
        here, said = path.target(row), end
        if done < len(path):
            said = identifier(f"{path.name}_on_way", taken)
            taken.add(said)
            targets[said] = here
        speed = path.speeds[path.speed[row]]
        blend = FINE if done == len(path) else path.blends[path.blend[row]]
        motion = Motion(speed, blend, path.tools[0], path.frames[0])
        if arc:
            via = identifier(f"{path.name}_via", taken)
            taken.add(via)
            targets[via] = path.target(first)
            statements.append(MoveCircular(Name(via), Name(said), motion, on_way.get(row, ())))
        else:
            statements.append(Move("linear", Name(said), motion, on_way.get(row, ())))
    return statements, targets


@dataclass(frozen=True, slots=True)
class TravelHeights:
    """Mm above the start and the end of a contour at which travel goes, 0 for on the work."""

    before: float
    after: float

    @staticmethod
    def of(layer: Layer, placed: PlacedLayer, top: float, start: Pose, end: Pose) -> TravelHeights:
        """top: of the layer, see `highest`."""
        if layer.above.height is None:
            return TravelHeights(layer.approach, layer.retract)
        above = top + layer.above.height
        up, down = (above + float(np.dot(p.position, placed.direction)) for p in (start, end))
        return TravelHeights(round(up, 3), round(down, 3))


def highest_point(contours: Sequence[Contour], placed: PlacedLayer) -> float:
    """Mm, against the direction of the tool, that the highest point of contours is from the origin
    of their layer's frame.
    """
    up = -np.asarray(placed.direction)
    curves = [curve for contour in contours for curve in contour.curves]
    drawn = _ends_and_peaks(curves, np.asarray(placed.pose.quaternion), up)
    points = rotations.rotate(placed.pose.quaternion, drawn) + placed.pose.position
    return float((points @ up).max())


def _ends_and_peaks(curves: Sequence[Curve], turn: Floats, up: Points) -> Points:
    """Points (n, 3) of curves, the highest ones among them. up: seen from where `turn` leads."""
    found = [np.array([[curve.start, curve.end] for curve in curves]).reshape(-1, 3)]
    found += [chorded(curve, PEAK_CHORD) for curve in curves if isinstance(curve, FreeCurve)]
    arcs = [curve for curve in curves if isinstance(curve, Arc)]
    if arcs:
        above = rotations.to_matrix(turn).T @ up
        start, centre, normal = (
            np.array([getattr(a, name) for a in arcs]) for name in ("start", "centre", "normal")
        )
        way = above - (normal @ above)[:, None] * normal
        size = np.linalg.norm(way, axis=1, keepdims=True)
        arm = np.linalg.norm(start - centre, axis=1, keepdims=True)
        peak = arm * way / np.where(size > SAME_POSE, size, np.inf)
        ahead = (cross(start - centre, peak) * normal).sum(axis=1)
        angle = np.degrees(np.arctan2(ahead, ((start - centre) * peak).sum(axis=1))) % 360.0
        on = (size[:, 0] > SAME_POSE) & (angle <= arc_sweeps(arcs))
        found.append((centre + peak)[on])
    return np.concatenate(found)


def travel_measure(
    layer: Layer, placed: PlacedLayer, standing: FramedSurroundings | None
) -> TravelMeasure | None:
    """The seconds of travel above points of a layer; None if nobody knows what is around.

    The turn of a tool that follows the contours is left out.
    """
    if standing is None:
        return None
    turn = facing_quaternions(placed.direction, level_x_axis(placed.direction)[None])[0]
    up = -layer.approach * np.asarray(placed.direction)

    def places(points: Points) -> Floats | None:
        drawn = rotations.rotate(placed.pose.quaternion, points) + placed.pose.position
        return standing.places(drawn + up, turn)

    return TravelMeasure(places, travel_seconds)


def _are_same_poses(one: Pose, other: Pose) -> bool:
    """Whether poses are the same but for the noise of computing them."""
    numbers = (*one.position, *one.quaternion), (*other.position, *other.quaternion)
    return bool(np.allclose(*numbers, rtol=0.0, atol=SAME_POSE))


def _travel_kind(wound: float | None, layer: Layer) -> Literal["joint", "linear"]:
    """How the tool comes from one contour, along which it has turned by degrees, to the next.

    A line turns it the shorter way, so that a tool that follows closed contours would wind up
    with each of them; a joint move lets the wrist turn back. It is made above the work only.
    """
    if wound is None:
        return "joint"
    if layer.above.kind is not None:
        return layer.above.kind
    if not layer.tangential or not (layer.approach > 0.0 and layer.retract > 0.0):
        return "linear"
    return "joint" if abs(wound) > HALF_TURN else "linear"


def _slower_motion(motion: Motion, travel: Speed) -> Speed:
    """Towards the work: never faster than along the contour, as far as that is known."""
    speed = motion.speed
    return speed if isinstance(speed, Speed) and speed.tcp < travel.tcp else travel


def _contour_path(
    name: str, made: MovesWithSpeeds, layer: Layer, direction: Vector, tolerance: float
) -> tuple[Pose, Path]:
    """The start's pose, and the path of the rows; it stops at its end and where it turns.

    tolerance: mm that cutting a corner may leave the drawing by, with what fitting has used.
    Where a move was divided nothing stops.
    """
    rows = made.rows
    if layer.tangential:
        first, axes, chosen = x_axes_along(rows, direction)
        begin, quaternions = (
            facing_quaternions(direction, first[None]),
            facing_quaternions(direction, axes),
        )
    else:
        chosen = np.arange(len(rows))
        begin = facing_quaternions(direction, level_x_axis(direction)[None])
        quaternions = np.broadcast_to(begin, (len(rows), 4))
    stops = np.zeros(len(chosen), dtype=np.int32)
    again = np.flatnonzero(chosen[1:] == chosen[:-1])
    stops[again] = stops[again + 1] = stops[-1] = 1
    kinds = rows.kinds[chosen]
    kinds[again + 1] = Kind.LINEAR  # turning on the spot is a linear move, whatever led there
    motion, positions = layer.motion, rows.positions[chosen]
    (speed, blend), blends = motion.fixed, tuple[Blend | Name, ...]()
    blends = (blend, FINE)
    divided = made.divided[chosen] & (stops == 0)
    if layer.rounded or divided.any():
        sizes = _corner_radii(rows.start, positions, kinds, tolerance - rows.deviation)
        table, index = np.unique(sizes, return_inverse=True)
        rounded = index if layer.rounded else np.where(divided, index, len(table) + 1)
        sized = (Blend(size) if size > 0.0 else FINE for size in table.tolist())
        blends = (*sized, FINE) if layer.rounded else (*sized, FINE, blend)
        stops = np.where(stops == 1, len(table), rounded)
    path = Path.of(
        name,
        positions,
        quaternions,
        kinds=kinds,
        speeds=tuple(speed if one is None else one for one in made.table),
        speed=made.speeds[chosen],
        blends=blends,
        blend=stops,
        tools=(motion.tool,),
        frames=(motion.frame,),
    )
    return Pose.of(rows.start, begin[0]), path


def _corner_radii(
    start: Points, positions: Points, kinds: NDArray[np.uint8], tolerance: float
) -> Floats:
    """Sizes (n,) of the corners in mm, 0 for a stop; the two rows of an arc have one."""
    way, led = np.vstack([start, positions]), np.concatenate([[Kind.LINEAR], kinds])
    sizes = rounding_radii(way, led, np.ones(len(positions), dtype=np.bool_), tolerance)[1:]
    via = np.flatnonzero(kinds == Kind.VIA)
    sizes[via] = sizes[via + 1]
    return sizes

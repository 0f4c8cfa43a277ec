"""Statements of one contour: approach, switch on, follow, switch off, retract.

The start and the end of a contour are named targets. The targets above them are given relative to
those, so that teaching one of them again moves all of it. `_contour_outputs` sets outputs at other
positions on the contour than its ends; `FramedSurroundings` asks the surroundings of the process
for a motion in its frame with its tool.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule, error
from assistant.program.expressions import Apply, Expression, Name, Number
from assistant.program.geometry import BASE, FLANGE, Frame, Pose, Target, Tool, Vector
from assistant.program.motion import FINE, Blend, Kind, Path, Speed
from assistant.program.program import TakenNames, identifier
from assistant.program.settings_tables import shown
from assistant.program.statements import (
    Follow,
    Motion,
    Move,
    MoveCircular,
    SetSignal,
    Statement,
    Travel,
    Trigger,
    Wait,
)
from assistant.sources.contours.chains import Contour
from assistant.sources.contours.contour_order import TravelMeasure
from assistant.sources.contours.curves import (
    Arc,
    Curve,
    FreeCurve,
    Points,
    arc_sweeps,
    chorded,
    cross,
)
from assistant.sources.contours.moves import (
    FLATTENING_PART,
    Moves,
    MovesWithSpeeds,
    degrees_turned,
    facing_quaternions,
    level_x_axis,
    move_lengths,
    with_speeds,
    x_axes_along,
)
from assistant.sources.contours.path_tolerance import rounding_radii
from assistant.sources.process import (
    Layer,
    Process,
    Surroundings,
    SwitchPoint,
    WayIn,
    travel_seconds,
)

_CONTOUR_TOO_SHORT = error(
    "CT220",
    "a contour of layer {layer!r} is {length:.2f} mm long, too short for {what}",
    "give less of it, or put the contour on a layer of its own",
)
_SWITCHED_OFF_TOO_LATE = error(
    "CT221",
    "the seconds of `off_before` are {wanted:.2f} mm of a contour of layer {layer!r}, of whose last"
    " move {length:.2f} mm lie before that place",
    "give `mm` alone, or fewer seconds",
)

_SAME_POSITION: Final = 1e-6
"""mm that make no other place."""
_TRIGGER_DECIMALS: Final = 3
"""Decimals of mm along a move."""


class _NoRoomForOutputs(ValueError):
    """A contour has no room for an output: the rule, and the fields of its finding except the
    layer.
    """

    def __init__(self, rule: Rule, **fields: Any) -> None:
        super().__init__()
        self.rule: Final = rule
        self.fields: Final = fields


@dataclass(slots=True)
class _ContourOutputs:
    """Outputs of one contour.

    first, last: outputs that the moves to the start and up from the end set during the motion.
    on_way: by the row of the path that ends the move. before, after: statements at the start and at
    the end.
    """

    first: tuple[Trigger, ...] = ()
    last: tuple[Trigger, ...] = ()
    on_way: dict[int, tuple[Trigger, ...]] = field(default_factory=dict)
    before: list[Statement] = field(default_factory=list)
    after: list[Statement] = field(default_factory=list)


def _number_literal(value: float) -> Number:
    """A whole number where it is one."""
    return Number(int(value) if value == int(value) else value)


def _divided_at(layer: Layer, total: float) -> tuple[float, ...]:
    """Mm from the start at which a move is divided, as one move sets at one place only.

    total: of the contour.
    """
    on, off = layer.switching.on_after, layer.switching.off_before
    if on is None or off is None:
        return ()
    return ((on.mm + total - off.mm) / 2.0,)


def _contour_outputs(layer: Layer, lengths: Floats, up: float, speeds: Floats) -> _ContourOutputs:
    """Return the outputs along a contour.

    lengths, speeds: mm and mm/s of the rows of its path, (n,). up: mm of the retract from its end.
    Raises NoRoomForOutputs for an output that has no room on it.
    """
    made, said = _ContourOutputs(), layer.switching
    total = float(lengths.sum())
    on = said.on_after.mm if said.on_after is not None else 0.0
    off = said.off_before.mm if said.off_before is not None else 0.0
    if on + off >= total and (on or off):
        parts = (("on_after", on), ("off_before", off))
        # Both switch points must be on the contour, and in their order.
        raise _NoRoomForOutputs(
            _CONTOUR_TOO_SHORT,
            length=total,
            what=" and ".join(f"{k} of {v:g} mm" for k, v in parts if v),
        )
    if said.on_before is not None:
        made.first = tuple(_triggers_at(layer.on, said.on_before))
    elif said.on_after is not None:
        _note_triggers(made, lengths, on, _triggers_at(layer.on, said.on_after))
    else:
        made.before += signal_statements(layer.on)
    if layer.delay > 0.0:
        made.before.append(Wait(_number_literal(layer.delay)))
    if said.off_before is not None:
        row = _note_triggers(made, lengths, total - off, _triggers_at(layer.off, said.off_before))
        ahead = said.off_before.seconds * float(speeds[row])
        # A trigger cannot act before its move begins: the time must fit in what the move has before
        # it.
        room = total - off - float(lengths[:row].sum())
        if ahead > room:
            raise _NoRoomForOutputs(_SWITCHED_OFF_TOO_LATE, wanted=ahead, length=room)
    elif said.off_after is not None and said.off_after.mm:
        up_to = SwitchPoint(up - said.off_after.mm)
        made.last = tuple(_triggers_at(layer.off, up_to))
    else:
        if said.off_after is not None:
            made.after.append(Wait(_number_literal(said.off_after.seconds)))
        made.after += signal_statements(layer.off)
    return made


def _note_triggers(
    made: _ContourOutputs, lengths: Floats, place: float, triggers: Iterable[Trigger]
) -> int:
    """Notes what is set at mm from the start at the row whose move leads there, and gives it.

    A place between two moves is the beginning of the second one, which a corner does not move.
    """
    ends = np.cumsum(lengths)
    row = min(int(np.searchsorted(ends, place + _SAME_POSITION, "right")), len(ends) - 1)
    # Triggers count mm back from the end of their move.
    left = _number_literal(round(float(ends[row]) - place, _TRIGGER_DECIMALS))
    found = tuple(
        Trigger(one.signal, one.value, left, one.measure, ahead=one.ahead) for one in triggers
    )
    made.on_way[row] = (*made.on_way.get(row, ()), *found)
    return row


def _triggers_at(values: Iterable[tuple[str, float]], at: SwitchPoint) -> Iterator[Trigger]:
    ahead = _number_literal(at.seconds) if at.seconds else None
    for signal, value in values:
        yield Trigger(
            signal,
            _number_literal(value),
            _number_literal(round(at.mm, _TRIGGER_DECIMALS)),
            "end",
            ahead=ahead,
        )


def signal_statements(values: Iterable[tuple[str, float]]) -> Iterator[SetSignal]:
    """Statements that give outputs their values."""
    return (SetSignal(signal, _number_literal(value)) for signal, value in values)


@dataclass(frozen=True, slots=True)
class FramedSurroundings:
    """frame: in the base of the robot. tool: its tip in the flange."""

    around: Surroundings
    frame: Pose
    tool: Pose

    @staticmethod
    def of(process: Process, motion: Motion) -> FramedSurroundings | None:
        """None where nobody knows what is around, or work or tool move."""
        frames = {BASE: Frame(), **process.frames}
        tools = {FLANGE: Tool(), **process.tools}
        frame, tool = frames.get(motion.frame), tools.get(motion.tool)
        if process.around is None or frame is None or tool is None:
            return None
        if frame.held or frame.mechanism or not tool.held:
            return None
        return FramedSurroundings(process.around, frame.pose, tool.tip)

    def places(self, positions: Floats, quaternions: Floats) -> Floats | None:
        """Return the `places` of `Surroundings` for poses in the frame; one quaternion (4,) may
        serve all.
        """
        turn = self.frame.quaternion
        turned = rotations.multiply(np.array(turn), np.atleast_2d(quaternions))
        return self.around.places(
            rotations.rotate(turn, positions) + self.frame.position,
            np.broadcast_to(turned, (len(positions), 4)),
            self.tool,
        )

    def way_in(self, pose: Pose, distance: float, place: str) -> WayIn:
        return self.around.way_in(self.frame @ pose, self.tool, distance, place)


def approach_of(
    standing: FramedSurroundings | None, pose: Pose, distance: float, place: str
) -> WayIn:
    """Along the tool where nobody knows what is around."""
    return WayIn() if standing is None or not distance else standing.way_in(pose, distance, place)


def backed_off_target(target: str, distance: float, way: WayIn) -> Expression:
    """Mm away from a named target, in the direction of a way."""
    numbers = (
        _number_expression(round(part * distance, _BACKED_OFF_DECIMALS)) for part in way.direction
    )
    return Apply("relative", (Name(target), *numbers))


def move_to(
    kind: Literal["joint", "linear", "travel"], target: Expression, motion: Motion
) -> Statement:
    return Travel(target, motion) if kind == "travel" else Move(kind, target, motion)


def _number_expression(value: float) -> Number:
    return Number(int(value) if value == int(value) else value)


_BACKED_OFF_DECIMALS: Final = 3
"""Decimals of mm that a place is backed off by."""


_MOVING_FRAME = error(
    "CT207",
    "contours of layer {layer!r} cannot be put from frame `{drawing}` into `{frame}`: "
    "one of them moves",
    "use a frame that stands still",
)
_UNKNOWN_FRAME = error(
    "CT208",
    "there is no frame `{frame}` for layer {layer!r}",
    "define it under [frames] in the process file",
)

_HALF_TURN: Final = 180.0 + 1e-6
"""Degrees that a tool is wound up by over which the way back is another one."""

_PEAK_CHORD: Final = 1e-3
"""Largest deviation in mm of chords of a free curve in the search for its highest point."""

_SAME_POSE: Final = 1e-6
"""mm, degrees and parts of a quaternion that tell no two places apart."""


@dataclass(frozen=True, slots=True)
class PlacedLayer:
    """Pose of the drawing in a layer's frame, and direction of the tool there."""

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
                    return _UNKNOWN_FRAME(frame=shown(frame), layer=shown(name))
            if any(frames[f].held or frames[f].mechanism for f in (drawing, wanted)):
                return _MOVING_FRAME(layer=shown(name), drawing=drawing, frame=wanted)
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

    corners: that are gone round at the speed of corners. turns: where the tool turns on the spot,
    (n, 3) mm in the frame.
    """

    statements: tuple[Statement, ...]
    targets: Mapping[str, Target]
    wound: float | None
    findings: tuple[Diagnostic, ...] = ()
    corners: int = 0
    turns: Floats = field(default_factory=lambda: np.empty((0, 3)))


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
    made = with_speeds(moved, layer.pace, _divided_at(layer, total), flat)
    # Flattening arcs has used its part of the tolerance.
    pose, path = _contour_path(name, made, layer, placed.direction, process.tolerance - flat)
    wound = degrees_turned(np.concatenate([[pose.quaternion], path.quaternions]), placed.direction)
    start, end = (identifier(f"{name}_{k}", taken) for k in ("start", "end"))
    targets = {start: Target(pose)}
    last = path.target(len(path) - 1)
    # A closed contour has one target for both ends: teaching it again moves both.
    if abs(wound) < _SAME_POSE and _are_same_poses(pose, last.pose):
        end = start
    else:
        targets[end] = last
    kind = "travel" if process.defaults.travels else _travel_kind(before, layer)
    motion, above = layer.motion, layer.above
    travel = replace(motion, speed=layer.travel, blend=above.blend)
    plunge = replace(motion, speed=_slower_motion(motion, layer.travel), blend=FINE)
    standing = FramedSurroundings.of(process, motion)
    high = _TravelHeights.of(layer, placed, top, pose, last.pose)
    into = approach_of(standing, pose, high.before, start)
    out = into
    if (end, high.after) != (start, high.before):
        out = approach_of(standing, targets[end].pose, high.after, end)
    way = move_lengths(np.array(pose.position), path.positions, path.kinds)
    speeds = np.array([one.tcp if isinstance(one, Speed) else 0.0 for one in path.speeds])
    try:
        switched = _contour_outputs(layer, way, high.after, speeds[path.speed])
    except _NoRoomForOutputs as unfit:
        return FollowedContour((), {}, None, (unfit.rule(layer=shown(drawn_on), **unfit.fields),))
    statements: list[Statement] = []
    if high.before > 0.0:
        statements.append(move_to(kind, backed_off_target(start, high.before, into), travel))
        # From the travel height first to the approach height, then down at the speed of the work.
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
        # The arm must not blend into a move that does not follow.
        leaving = replace(travel, blend=FINE) if stays else travel
        up = backed_off_target(end, high.after, out)
        statements.append(Move("linear", up, leaving, switched.last))
    findings = dict.fromkeys((*into.findings, *out.findings))
    turns = path.positions[1:][np.all(path.positions[1:] == path.positions[:-1], axis=1)]
    return FollowedContour(tuple(statements), targets, wound, tuple(findings), made.corners, turns)


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
        # The via of an arc is no row of the path before it.
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
class _TravelHeights:
    """Mm above the start and the end of a contour at which travel goes, 0 for on the work."""

    before: float
    after: float

    @staticmethod
    def of(layer: Layer, placed: PlacedLayer, top: float, start: Pose, end: Pose) -> _TravelHeights:
        """top: of the layer, see `highest`."""
        if layer.above.height is None:
            return _TravelHeights(layer.approach, layer.retract)
        above = top + layer.above.height
        up, down = (above + float(np.dot(p.position, placed.direction)) for p in (start, end))
        return _TravelHeights(round(up, 3), round(down, 3))


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
    found += [chorded(curve, _PEAK_CHORD) for curve in curves if isinstance(curve, FreeCurve)]
    arcs = [curve for curve in curves if isinstance(curve, Arc)]
    if arcs:
        # Up against the tool, in the drawing's own axes.
        above = rotations.to_matrix(turn).T @ up
        start, centre, normal = (
            np.array([getattr(a, name) for a in arcs]) for name in ("start", "centre", "normal")
        )
        way = above - (normal @ above)[:, None] * normal
        size = np.linalg.norm(way, axis=1, keepdims=True)
        arm = np.linalg.norm(start - centre, axis=1, keepdims=True)
        # A level circle has no highest point: its ends are as high.
        peak = arm * way / np.where(size > _SAME_POSE, size, np.inf)
        ahead = (cross(start - centre, peak) * normal).sum(axis=1)
        angle = np.degrees(np.arctan2(ahead, ((start - centre) * peak).sum(axis=1))) % 360.0
        on = (size[:, 0] > _SAME_POSE) & (angle <= arc_sweeps(arcs))
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
    """True if poses are the same except for rounding errors."""
    numbers = (*one.position, *one.quaternion), (*other.position, *other.quaternion)
    return bool(np.allclose(*numbers, rtol=0.0, atol=_SAME_POSE))


def _travel_kind(wound: float | None, layer: Layer) -> Literal["joint", "linear"]:
    """Return the kind of the move from one contour, along which the tool has turned by degrees, to
    the next.

    A line turns it in the shorter direction, so that a tool that follows closed contours would wind
    up with each of them; a joint move lets the wrist turn back. It is made above the work only.
    """
    if wound is None:
        return "joint"
    if layer.above.kind is not None:
        return layer.above.kind
    if not layer.tangential or not (layer.approach > 0.0 and layer.retract > 0.0):
        return "linear"
    return "joint" if abs(wound) > _HALF_TURN else "linear"


def _slower_motion(motion: Motion, travel: Speed) -> Speed:
    """Towards the work: never faster than along the contour, as far as that is known."""
    speed = motion.speed
    return speed if isinstance(speed, Speed) and speed.tcp < travel.tcp else travel


def _contour_path(
    name: str, made: MovesWithSpeeds, layer: Layer, direction: Vector, tolerance: float
) -> tuple[Pose, Path]:
    """Return the start's pose, and the path of the rows; it stops at its end and where it turns.

    tolerance: mm by which cutting a corner may depart from the drawing, including the deviation of
    fitting. The path does not stop where a move was divided.
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
    # The last row stops, and so do both rows of a corner at which the tool turns.
    stops = np.zeros(len(chosen), dtype=np.int32)
    again = np.flatnonzero(chosen[1:] == chosen[:-1])
    stops[again] = stops[again + 1] = stops[-1] = 1
    kinds = rows.kinds[chosen]
    kinds[again + 1] = Kind.LINEAR  # turning on the spot is a linear move, whatever led there
    motion, positions = layer.motion, rows.positions[chosen]
    (speed, blend), blends = motion.fixed, tuple[Blend | Name, ...]()
    blends = (blend, FINE)
    # A divided move must not stop where its parts meet.
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
    # Both rows of an arc are one move with one blend.
    via = np.flatnonzero(kinds == Kind.VIA)
    sizes[via] = sizes[via + 1]
    return sizes

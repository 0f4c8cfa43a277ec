"""Programs along the contours of a drawing: one procedure a layer, as its process says."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from assistant.program import rotations
from assistant.program.diagnostics import Diagnostic, Rule, Severity
from assistant.program.expressions import Number, TargetValue
from assistant.program.geometry import BASE, Frame, Pose, Target, Vector
from assistant.program.motion import FINE, Speed
from assistant.program.path import Kind, Path
from assistant.program.program import MANGLED, Procedure, identifier
from assistant.program.statements import (
    Comment,
    Follow,
    Motion,
    Move,
    SetSignal,
    Statement,
    Wait,
)
from assistant.sources.contours import chain
from assistant.sources.curves import Arc, Curve, Line
from assistant.sources.moves import WIDEST, Moves, moves
from assistant.sources.nesting import holders
from assistant.sources.ordering import ordered
from assistant.sources.orientation import along, facing, level, turned
from assistant.sources.process import Layer, Process
from assistant.sources.process_table import nearest
from assistant.sources.process_values import shown

UNUSED = Rule(
    "CT201",
    Severity.WARNING,
    "not used on layer {layer!r}, which the process file does not have: {what}",
    'add [layers."{layer}"] to the process file, or leave_out = ["{layer}"] at its top',
)
NO_CONTOURS = Rule(
    "CT202",
    Severity.INFO,
    "the process file's layer {layer!r} has no contours in the drawing",
    "{cure}",
)
TOO_SMALL = Rule(
    "CT203",
    Severity.WARNING,
    "a contour on layer {layer!r} is smaller than the tolerance of {tolerance:g} mm and left out",
    "give a smaller `tolerance`",
)
NOT_FITTED = Rule(
    "CT204",
    Severity.ERROR,
    "a curve on layer {layer!r} cannot be followed within {tolerance:g} mm",
    "redraw it without jumps, or give a larger `tolerance`",
)
FITTED = Rule(
    "CT205",
    Severity.INFO,
    "{count} ellipses and splines on layer {layer!r} are followed by arcs and lines, "
    "at most {deviation:.4f} mm off",
    "give a smaller `tolerance` for more and shorter pieces",
)
TRAVEL = Rule(
    "CT206",
    Severity.INFO,
    "travel between the {count} contours of layer {layer!r} is {after:.0f} mm{inside}; "
    "it was {before:.0f} mm in the order of drawing",
    "",
)
MOVING_FRAME = Rule(
    "CT207",
    Severity.ERROR,
    "contours of layer {layer!r} cannot be put from frame `{drawing}` into `{frame}`: "
    "one of them moves",
    "use a frame that stands still",
)
UNKNOWN_FRAME = Rule(
    "CT208",
    Severity.ERROR,
    "there is no frame `{frame}` for layer {layer!r}",
    "define it under [frames] in the process file",
)

WIDEST_TURN: Final = 120.0
"""Degrees of an arc over which the tool turns with the contour: a controller turns it the
shorter way from start to end, which has to stay the way of the arc."""

HALF_TURN: Final = 180.0 + 1e-6
"""Degrees that a tool is wound up by over which the way back is another one."""

LONGEST_STEM: Final = 20
"""Letters of a layer's name that go into the names of its paths."""


def contour_program(
    curves: Sequence[Curve], process: Process, *, taken: set[str], path: str | None = None
) -> tuple[tuple[Procedure, ...], tuple[Diagnostic, ...]]:
    """A procedure for each layer that has a process, and what was found.

    curves: in the coordinates of the process's default frame; the layers come in order of
    first appearance. A layer whose motion names another frame is followed at the same
    place, its targets and its tool direction given in that frame. Without any layer in the
    process, every layer moves as the defaults say. Curves of other layers are counted in a
    finding. taken: names that must not be used; those of the procedures and paths are added.
    path: the drawing, for findings.
    """
    layers: dict[str, list[Curve]] = {}
    for curve in curves:
        layers.setdefault(curve.layer.casefold(), []).append(curve)
    known = {name.casefold(): layer for name, layer in process.layers.items()}
    unwanted = {name.casefold() for name in process.leave_out}
    usual = None if known else Layer("contours", process.defaults.motion)
    procedures: list[Procedure] = []
    findings: list[Diagnostic] = []
    followed: list[tuple[str, Sequence[Curve], Layer]] = []
    for key, group in layers.items():
        layer = known.get(key, None if key in unwanted else usual)
        if layer is None:
            if key not in unwanted:
                findings.append(UNUSED(what=_count(group), layer=shown(group[0].layer)))
            continue
        name = _name(group[0].layer, taken)
        taken.add(name)
        followed.append((name, group, layer))
    # All procedures have their names before any path gets one.
    for name, members, layer in followed:
        made, found = _procedure(name, members, layer, process, taken)
        procedures += made
        findings += found
    findings += _without_contours(process.layers, [group[0].layer for group in layers.values()])
    return tuple(procedures), tuple(f.within(path) for f in findings)


def _name(layer: str, taken: set[str]) -> str:
    """Of the procedure; a signal is often called as its layer is, and needs the name more."""
    name = identifier(layer)
    return name if identifier(layer, taken) == name else identifier(f"{name}_contours", taken)


def _count(curves: Sequence[Curve]) -> str:
    """`3 lines, 1 arc`."""
    kinds = Counter(
        "line" if isinstance(c, Line) else "arc" if isinstance(c, Arc) else "free curve"
        for c in curves
    )
    return ", ".join(f"{n} {kind}{'s' if n > 1 else ''}" for kind, n in kinds.items())


def _without_contours(layers: Mapping[str, Layer], drawn: list[str]) -> list[Diagnostic]:
    there = {name.casefold() for name in drawn}
    findings = []
    for name in layers:
        if name.casefold() not in there:
            near = nearest(name, drawn)
            cure = f"did you mean {shown(near)}?" if near else "draw some, or delete its table"
            findings.append(NO_CONTOURS(layer=shown(name), cure=cure))
    return findings


def _procedure(
    named: str, curves: Sequence[Curve], layer: Layer, process: Process, taken: set[str]
) -> tuple[list[Procedure], list[Diagnostic]]:
    """The procedure of that name along the curves of one layer; none if nothing is left."""
    name = curves[0].layer
    contours, chained = chain(curves, process.tolerance)
    findings = list(chained)
    placed = _Placed.of(name, layer, process)
    if isinstance(placed, Diagnostic):
        return [], [*findings, placed]
    if not contours:
        return [], findings
    around = holders(contours, layer.direction, process.tolerance) if layer.inside_first else []
    order = ordered(contours, around)
    if len(contours) > 1:
        inside = ", with those inside others first" if any(i >= 0 for i in around) else ""
        findings.append(
            TRAVEL(
                layer=shown(name),
                count=len(contours),
                before=order.before,
                after=order.after,
                inside=inside,
            )
        )
    if named != name:
        findings.append(MANGLED(place=f"layer {shown(name)}", given=name, name=named))
    stem = _stem(name, taken)
    body: list[Statement] = [Comment(_plain(f"{layer.process}: layer {name}"))]
    widest = WIDEST_TURN if layer.tangential else WIDEST
    deviation, fitted, count = 0.0, 0, 0
    wound: float | None = None
    for contour in order.contours:
        rows = moves(contour, process.tolerance, widest=widest)
        handle = next((c.handle for c in contour.curves if c.handle), "")
        place = f"entity {handle}" if handle else None
        if not rows.within:
            findings.append(NOT_FITTED(place=place, layer=shown(name), tolerance=process.tolerance))
        elif not len(rows):
            findings.append(TOO_SMALL(place=place, layer=shown(name), tolerance=process.tolerance))
        else:
            count += 1
            deviation, fitted = max(deviation, rows.deviation), fitted + rows.fitted
            made, wound = _follow(f"{stem}_{count}", rows, layer, placed, wound)
            body += made
            taken.add(f"{stem}_{count}")
    if fitted:
        findings.append(FITTED(layer=shown(name), count=fitted, deviation=deviation))
    return ([Procedure(named, tuple(body))] if count else []), findings


def _stem(layer: str, taken: set[str]) -> str:
    """Start of the layer's path names, so that no path or row has the name of another thing.

    Row k of path n is called stem_n_k, so `glue` and `glue_1` must not both be stems.
    """
    base = identifier(layer.lower())[:LONGEST_STEM].rstrip("_")
    used = {t.lower() for t in taken}
    candidate, count = base, 1
    while any(_clash(candidate, name) for name in used):
        count += 1
        candidate = f"{base.replace('_', '')}{count}"
    return candidate


def _clash(stem: str, name: str) -> bool:
    """Whether a name in use looks like a row or path of the stem."""
    return re.fullmatch(re.escape(stem) + r"(_\d+)+", name) is not None


def _plain(text: str) -> str:
    """One printable line."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


@dataclass(frozen=True, slots=True)
class _Placed:
    """How the drawing stands in a layer's frame, and where the tool points there."""

    pose: Pose
    direction: Vector

    @staticmethod
    def of(name: str, layer: Layer, process: Process) -> _Placed | Diagnostic:
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
        return _Placed(pose, (x, y, z))

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


def _follow(
    name: str, drawn: Moves, layer: Layer, placed: _Placed, before: float | None
) -> tuple[list[Statement], float]:
    """Approach, switch on, follow, switch off, retract; and the degrees that the tool has turned.

    before: the degrees of the contour before, None for the first one.
    """
    moved = placed.rows(drawn)
    pose, path = _path(name, moved, layer, placed.direction)
    wound = turned(np.concatenate([[pose.quaternion], path.quaternions]), placed.direction)
    kind = _travels(before, layer)
    motion = layer.motion
    travel = replace(motion, speed=layer.travel, blend=FINE)
    plunge = replace(motion, speed=_slower(motion, layer.travel), blend=FINE)
    last = path.pose(len(path) - 1)
    statements: list[Statement] = []
    if layer.approach > 0.0:
        statements.append(Move(kind, _above(pose, layer.approach), travel))
        statements.append(Move("linear", _above(pose, 0.0), plunge))
    else:
        statements.append(Move(kind, _above(pose, 0.0), travel))
    statements += [SetSignal(signal, _number(value)) for signal, value in layer.on]
    if layer.delay > 0.0:
        statements.append(Wait(_number(layer.delay)))
    statements.append(Follow(path))
    statements += [SetSignal(signal, _number(value)) for signal, value in layer.off]
    if layer.retract > 0.0:
        statements.append(Move("linear", _above(last, layer.retract), travel))
    return statements, wound


def _travels(wound: float | None, layer: Layer) -> Literal["joint", "linear"]:
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


def _above(pose: Pose, distance: float) -> TargetValue:
    return TargetValue(Target(pose.offset(z=-distance) if distance else pose))


def _number(value: float) -> Number:
    return Number(int(value) if value == int(value) else value)


def _path(name: str, rows: Moves, layer: Layer, direction: Vector) -> tuple[Pose, Path]:
    """The start's pose, and the path of the rows; it stops at its end and where it turns."""
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
    motion = layer.motion
    path = Path.of(
        name,
        rows.positions[chosen],
        quaternions,
        kinds=kinds,
        speeds=(motion.speed,),
        blends=(motion.blend, FINE),
        blend=stops,
        tools=(motion.tool,),
        frames=(motion.frame,),
    )
    return Pose.of(rows.start, begin[0]), path

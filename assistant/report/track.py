"""The track of a program: the poses its tool goes through, in the order of its statements."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.program.expressions import Expression, Name
from assistant.program.geometry import BASE, IDENTITY, Pose
from assistant.program.motion import Kind, Path
from assistant.program.program import Program, walk
from assistant.program.statements import (
    Call,
    Follow,
    Motion,
    Move,
    MoveCircular,
    MoveJoints,
    Moving,
    Statement,
)
from assistant.robots.motion.interpolation import DrawingSampling, circles
from assistant.robots.program_values import Names

STARTS: Final = "_start"
"""Suffix of the target name at which the following of a contour begins."""


@dataclass(frozen=True, slots=True)
class Track:
    """positions (n, 3) mm and quaternions (n, 4) in the robot's base frame.

    kinds (n,): the `Kind` of the move that leads to each pose; joint moves are drawn as
    chords though the arm does not go straight. names: row → name, of the targets that have one.
    """

    positions: Floats
    quaternions: Floats
    kinds: NDArray[np.uint8]
    names: dict[int, str]

    def __len__(self) -> int:
        return len(self.positions)

    def lengths(self) -> Floats:
        """Distance in mm along the track at each pose (n,)."""
        steps = np.linalg.norm(np.diff(self.positions, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)]) if len(self) else np.empty(0)


@dataclass(slots=True)
class _Piece:
    positions: Floats
    quaternions: Floats
    kinds: NDArray[np.uint8]
    name: str | None = None


@dataclass(frozen=True, slots=True)
class Stop:
    """A motion statement with where it leads to.

    place: among the motion statements of its procedure, from 1. positions: (n, 3) mm in the robot's
    base of its targets, of an arc the one on the way first. numbers: these targets counted through
    the procedure from 1, those of paths left aside.
    """

    procedure: str
    place: int
    statement: Move | MoveCircular | Follow
    positions: Floats
    numbers: tuple[int, ...]


def stops(program: Program) -> Iterator[Stop]:
    """Yield the stops of each procedure, in order of text, without those known only at run time."""
    names = Names(program)
    for procedure in program.procedures:
        names.enter(procedure)
        place = number = 0
        for statement in walk(procedure.body):
            if not isinstance(statement, Moving):
                continue
            place += 1
            own = {MoveCircular: 2, Follow: 0}.get(type(statement), 1)
            number += own
            if isinstance(statement, MoveJoints):
                continue
            numbers = tuple(range(number - own + 1, number + 1))
            for piece in _moved(program, names, statement):
                yield Stop(procedure.name, place, statement, piece.positions, numbers)


def track(program: Program) -> Track:
    """Return the motion of the entry procedure and those that it calls, ignoring conditions."""
    pieces = list(_pieces(program, Names(program), program.entry, ()))
    if not pieces:
        return Track(np.empty((0, 3)), np.empty((0, 4)), np.empty(0, np.uint8), {})
    names, row, last = {}, 0, None
    drawn: list[_Piece] = []
    for piece in pieces:
        piece = _with_arcs(piece, last)
        if piece.name:
            names[row + len(piece.positions) - 1] = piece.name
        row += len(piece.positions)
        last = piece.positions[-1]
        drawn.append(piece)
    return Track(
        np.concatenate([p.positions for p in drawn]),
        np.concatenate([p.quaternions for p in drawn]),
        np.concatenate([p.kinds for p in drawn]),
        names,
    )


@dataclass(frozen=True, slots=True)
class Way:
    """Positions (n, 3) mm in the robot's base, and the name of the contour that they follow.

    name: None for the travel between contours.
    """

    name: str | None
    positions: Floats


def ways(program: Program) -> Iterator[Way]:
    """The track of a program made from a drawing: contours, and the travel between them."""
    name, rows = None, list[Floats]()
    last: Floats | None = None
    for piece in _pieces(program, Names(program), program.entry, ()):
        positions = _with_arcs(piece, last).positions
        last = positions[-1]
        starts = piece.name is not None and piece.name.endswith(STARTS)
        begun = piece.name.removesuffix(STARTS) if starts and piece.name else None
        rows.append(positions)
        if begun is not None and begun != name:
            yield Way(name, np.concatenate(rows))
            name, rows = begun, [last[None]]
        elif name is not None and piece.name is None:
            rows.pop()
            yield Way(name, np.concatenate(rows))
            name, rows = None, [rows[-1][-1:], positions]
    if rows:
        yield Way(name, np.concatenate(rows))


def _pieces(
    program: Program, names: Names, name: str | None, above: tuple[str, ...]
) -> Iterator[_Piece]:
    procedure = program.procedure(name) if name else None
    if procedure is None or procedure.name in above:
        return
    for statement in walk(procedure.body):
        if isinstance(statement, Call):
            yield from _pieces(program, names, statement.procedure, (*above, procedure.name))
        else:
            names.enter(procedure)
            yield from _moved(program, names, statement)


def _moved(program: Program, names: Names, statement: Statement) -> Iterator[_Piece]:
    match statement:
        case Move(kind=kind, target=target, motion=motion):
            how = Kind.JOINT if kind == "joint" else Kind.LINEAR
            yield from _single(program, names, [(target, how)], motion)
        case MoveCircular(via=via, target=target, motion=motion):
            yield from _single(program, names, [(via, Kind.VIA), (target, Kind.END)], motion)
        case Follow(path=path):
            yield _of_path(program, path)


def _single(
    program: Program, names: Names, targets: list[tuple[Expression, Kind]], motion: Motion
) -> Iterator[_Piece]:
    found = [(names.place(expression), kind) for expression, kind in targets]
    if any(place is None for place, _ in found):
        return
    frame = _frame(program, motion.frame)
    poses = [frame @ place.pose for place, _ in found if place is not None]
    last = targets[-1][0]
    yield _Piece(
        np.array([pose.position for pose in poses]),
        np.array([pose.quaternion for pose in poses]),
        np.array([kind for _, kind in found], np.uint8),
        last.name if isinstance(last, Name) else None,
    )


def _of_path(program: Program, path: Path) -> _Piece:
    positions, quaternions = path.positions.copy(), path.quaternions.copy()
    for index, name in enumerate(path.frames):
        rows = path.frame == index
        frame = _frame(program, name)
        if frame != IDENTITY and rows.any():
            turned = rotations.rotate(frame.quaternion, positions[rows])
            positions[rows] = turned + np.array(frame.position)
            quaternions[rows] = rotations.multiply(frame.quaternion, quaternions[rows])
    return _Piece(positions, quaternions, path.kinds, path.name)


def _frame(program: Program, name: str) -> Pose:
    frame = program.frames.get(name)
    return IDENTITY if frame is None or name == BASE else frame.pose


def _with_arcs(piece: _Piece, before: Floats | None) -> _Piece:
    """Each VIA and END pair replaced by chords of the arc that they and the start define."""
    vias = np.flatnonzero(piece.kinds == Kind.VIA)
    if not len(vias):
        return piece
    positions, quaternions, kinds = [], [], []
    row = 0
    for via in vias:
        positions.append(piece.positions[row:via])
        quaternions.append(piece.quaternions[row:via])
        kinds.append(piece.kinds[row:via])
        start = piece.positions[via - 1] if via else before
        points = piece.positions[via : via + 2]
        chords = points if start is None else arc_points(start, points[0], points[1])
        positions.append(chords)
        quaternions.append(np.repeat(piece.quaternions[via + 1 : via + 2], len(chords), axis=0))
        kinds.append(np.full(len(chords), Kind.END, np.uint8))
        row = int(via) + 2
    rest = slice(row, None)
    return _Piece(
        np.concatenate([*positions, piece.positions[rest]]),
        np.concatenate([*quaternions, piece.quaternions[rest]]),
        np.concatenate([*kinds, piece.kinds[rest]]),
        piece.name,
    )


def _chords(radius: float, angle: float) -> int:
    """Number of chords of a drawn arc, so that none is visibly off."""
    if not 0.0 < radius < math.inf:
        return DrawingSampling.ARC
    step = 2.0 * math.acos(max(1.0 - DrawingSampling.OFF / radius, 0.5))
    return min(max(math.ceil(abs(angle) / step), DrawingSampling.ARC), DrawingSampling.MOST)


def arc_points(start: Floats, via: Floats, end: Floats) -> Floats:
    """Points (m, 3) on the arc after `start` up to `end`; the points themselves if straight."""
    circle = circles(start[None], via[None], end[None])
    if circle.ends[0] == 0.0:
        return np.stack([via, end])
    count = _chords(float(circle.radii[0]), float(circle.ends[0]))
    angles = np.linspace(0.0, circle.ends, count + 1)[1:]
    return np.asarray(circle.points(angles.T)[0])

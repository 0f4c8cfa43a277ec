"""Locations of work in a cell: those of bodies as targets, and work that was never placed.

A location of a body becomes a target of a program that moves to its name and does not declare it.
If the moves of a program are in the robot's base, close to axis 1, the findings about reach are
replaced by one that asks for the placement of the work.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, error, has_errors
from assistant.compiler.arms import Arms
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import BASE, Frame, Pose, Target
from assistant.program.program import Procedure, Program, walk
from assistant.program.rewriting import records
from assistant.program.statements import Follow, Move, MoveCircular

if TYPE_CHECKING:
    from assistant.cell.scene import Body, PlacedRobot, Scene
    from assistant.robots import Robot


_LOCATION_NO_TARGET: Final = error(
    "CO077", "the location `{name}` of the cell is no target here: {reason}", "{cure}"
)


@dataclass(frozen=True, slots=True)
class _BodyLocation:
    """A location of a body."""

    body: Body
    name: str

    @property
    def long(self) -> str:
        return f"{self.body.name}_{self.name}"


def with_locations(program: Program, arms: Arms) -> tuple[Program, tuple[Diagnostic, ...]]:
    """The program with a target for each location of the cell that moves name.

    A location is called by its name, or as `BODY_LOCATION`. Its pose is that of the tool there, in
    the frame of the moves. Names that the program declares stay its own.
    """
    if arms.scene is None or program.origin is not None:
        return program, ()
    known = _known_locations(arms.scene)
    if not known:
        return program, ()
    placed = robot_in_cell(program, arms)
    declared = {name.lower() for name in (*program.targets, *program.joint_targets)}
    declared |= {name.lower() for name in (*program.variables, *program.signals)}
    uses = _locations_used(program, declared, known)
    targets = dict(program.targets)
    found = []
    for name, frames in uses.items():
        told = _location_fault(name, frames, known[name.lower()], program, placed is not None)
        if told is not None:
            found.append(told)
            continue
        assert placed is not None
        (place,), (frame,) = known[name.lower()], frames
        pose = _fixed_pose(arms.scene, place.body)
        if pose is None:
            moves = f"`{place.body.name}` moves with an arm"
            found.append(
                _LOCATION_NO_TARGET(name=name, reason=moves, cure="declare a target of its own")
            )
            continue
        in_base = placed.base.inverse() @ pose @ place.body.locations[place.name]
        targets[name] = Target(_frame_named(program, frame).pose.inverse() @ in_base)
    return (replace(program, targets=targets) if uses else program), tuple(found)


def _known_locations(scene: Scene) -> Mapping[str, tuple[_BodyLocation, ...]]:
    """Names, in lower case, with the locations that they may be."""
    found: dict[str, tuple[_BodyLocation, ...]] = {}
    for body in scene.bodies:
        for name in body.locations:
            place = _BodyLocation(body, name)
            for one in (name.lower(), place.long.lower()):
                found[one] = (*found.get(one, ()), place)
    return found


def _locations_used(
    program: Program, declared: set[str], known: Mapping[str, tuple[_BodyLocation, ...]]
) -> dict[str, tuple[str, ...]]:
    """Names of locations, as the program first writes each, with the frames of the moves there."""
    found: dict[str, tuple[str, ...]] = {}
    spelled: dict[str, str] = {}
    for procedure in program.procedures:
        own = declared | {name.lower() for name in _own_names(procedure)}
        for name, frame in _names_moved_to(procedure):
            low = name.lower()
            if low in own or low not in known:
                continue
            first = spelled.setdefault(low, name)
            before = found.get(first, ())
            if frame.lower() not in {one.lower() for one in before}:
                found[first] = (*before, frame)
    return found


def _own_names(procedure: Procedure) -> Iterator[str]:
    yield from procedure.variables
    yield from (parameter.name for parameter in procedure.parameters)


def _names_moved_to(procedure: Procedure) -> Iterator[tuple[str, str]]:
    """Names in where moves go, each with the frame of the move."""
    for one in walk(procedure.body):
        motion: Any = getattr(one, "motion", None)
        if isinstance(motion, p.Motion):
            for key in ("target", "via"):
                for part in records(getattr(one, key, None)):
                    if isinstance(part, e.Name):
                        yield part.name, motion.frame


def robot_in_cell(program: Program, arms: Arms) -> PlacedRobot | None:
    """The robot of the cell that runs the program; None if that is not known."""
    from assistant.cell.clearances import robot_of
    from assistant.compiler.arms import known_robot

    arm = arms.robot or known_robot(program.robot)
    if arm is None or arms.scene is None:
        return None
    try:
        return robot_of(arms.scene, arm)
    except LookupError:
        return None


def _location_fault(
    name: str,
    frames: tuple[str, ...],
    places: tuple[_BodyLocation, ...],
    program: Program,
    standing: bool,
) -> Diagnostic | None:
    """Return a finding if a location cannot be a target."""
    if len(places) > 1:
        bodies = ", ".join(f"`{place.body.name}`" for place in places)
        long = " or ".join(f"`{place.long}`" for place in places)
        return _LOCATION_NO_TARGET(name=name, reason=f"it is one of {bodies}", cure=f"write {long}")
    if len(frames) > 1:
        names = ", ".join("the base" if one == BASE else f"frame `{one}`" for one in frames)
        reason = f"moves go to it in {names}"
        return _LOCATION_NO_TARGET(name=name, reason=reason, cure="move to it in one frame")
    frame = _frame_named(program, frames[0])
    if frame.held or frame.mechanism or frame.seen:
        reason = f"the frame `{frames[0]}` of the moves there does not stand still"
        return _LOCATION_NO_TARGET(name=name, reason=reason, cure="move to it in another frame")
    if not standing:
        reason = "which robot of the cell runs the program is not known"
        return _LOCATION_NO_TARGET(
            name=name, reason=reason, cure="name the robot as the cell does: --robot"
        )
    return None


def _frame_named(program: Program, name: str) -> Frame:
    """The frame of a name; that of the base for a name that nobody declares, told elsewhere."""
    frames = {key.lower(): frame for key, frame in program.frames.items()}
    return frames.get(name.lower(), Frame()) if name != BASE else Frame()


def _fixed_pose(scene: Scene, body: Body) -> Pose | None:
    """The pose of a body in the world; None for one that an arm moves."""
    from assistant.base import rotations
    from assistant.cell.collision.model import Carriers, carrier_of

    carriers = Carriers(scene.robots)
    carrier, pose = carrier_of(scene, body, carriers)
    if carriers.moved_by(carrier):
        return None
    homes = [np.asarray(one.robot.home, dtype=np.float64) for one in scene.robots]
    origins, turns = carriers.at(np.concatenate([np.zeros(0), *homes])[None])
    turn = rotations.from_matrix(turns[:1, carrier])[0]
    return Pose.of(origins[0, carrier], turn) @ pose


_PLACEMENT_CURE: Final = (
    "give the work its place: `position` of a frame that [motion] names, or of [placement], in the"
    " process file, or --place X,Y,Z for one run; --place 0,0,0 if it is drawn around the base"
)
_FRAME_CURE: Final = (
    "give the work its place: `position` of a frame that [motion] names, in the process file"
)
_UNPLACED: Final = error(
    "CO340", "nothing places the work, so it stands at the base of {arm}{codes}", "{cure}"
)
_REACH_CODES: Final = ("RB", "CK3", "CK42")
"""Code prefixes of findings about an arm's limits at a position."""
_NEAR_AXIS_PART: Final = 0.15
"""Part of an arm's reach from its axis 1 in which nobody puts a work piece."""


def fold_unplaced_work(
    program: Program, arm: Robot, found: Iterable[Diagnostic]
) -> tuple[Diagnostic, ...]:
    """Return the findings of a program for an arm; those of unplaced work become a single finding.

    A drawing is drawn about its own origin, and without a frame that is the robot's: it is refused.
    Findings on reach, limits, singularities and speeds there have the same cause.
    """
    found = tuple(found)
    told = [one for one in found if one.code.startswith(_REACH_CODES)]
    if program.placed is False and _is_in_base(program):
        return (
            _unplaced_finding(arm, told, _PLACEMENT_CURE),
            *(other for other in found if other not in told),
        )
    if program.placed is not None:
        return found
    if not has_errors(told) or program.origin is not None or not _is_at_base(program, arm):
        return found
    return (
        _unplaced_finding(arm, told, _cure_at_base(program)),
        *(other for other in found if other not in told),
    )


def _cure_at_base(program: Program) -> str:
    """Return what to do about work at the robot's base, which may be metres taken as mm."""
    from assistant.sources.tables.rows import LIKE_METRES, METRES_CURE

    if np.abs(_positions(program)).max() > LIKE_METRES:
        return _FRAME_CURE
    return f"if the positions are metres, {METRES_CURE}; else {_FRAME_CURE}"


def _unplaced_finding(arm: Robot, told: Sequence[Diagnostic], cure: str) -> Diagnostic:
    counts = Counter(one.code for one in told)
    codes = ", ".join(f"{code} ({n} times)" if n > 1 else code for code, n in counts.items())
    there = f", where it cannot do all of it: {codes}" if told else ""
    return _UNPLACED(arm=arm.title, codes=there, cure=cure)


def _is_in_base(program: Program) -> bool:
    """True if it moves or has targets, and all of its moves are in the robot's base."""
    moving = [s for s in program.statements() if isinstance(s, Follow | Move | MoveCircular)]
    frames = {frame for statement in moving for frame in _frames_of(statement)}
    return bool(moving or program.targets) and not frames - {BASE}


def _is_at_base(program: Program, arm: Robot) -> bool:
    """True if all of it is in the robot's base and close to the arm's axis 1."""
    if any(set(_frames_of(one)) - {BASE} for one in program.statements()):
        return False
    way = _positions(program)[:, :2]
    if not len(way):
        return False
    off = np.maximum(np.maximum(way.min(axis=0), -way.max(axis=0)), 0.0)
    return bool(np.hypot(*off) < _NEAR_AXIS_PART * arm.reach)


def _positions(program: Program) -> Floats:
    """Return the positions (n, 3) of all targets and paths."""
    points = [target.pose.position for target in program.targets.values()]
    paths = [one.path.positions for one in program.statements() if isinstance(one, Follow)]
    return np.concatenate([np.reshape(points, (-1, 3)), *paths])


def _frames_of(statement: object) -> Iterator[str]:
    if isinstance(statement, Follow):
        yield from statement.path.frames
    elif isinstance(statement, Move | MoveCircular):
        yield statement.motion.frame

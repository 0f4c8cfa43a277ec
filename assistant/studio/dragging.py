"""What is told while something is dragged: whether it is reached, and what is touched there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats, evenly_spaced
from assistant.base.source_text import visible
from assistant.cell.collision.model import Model
from assistant.program.geometry import Pose
from assistant.program.motion import UNSTATED
from assistant.robots.arms import closed_form
from assistant.robots.robot import Robot
from assistant.robots.solved_program import Leg
from assistant.studio.stages import DRAWING_HANDLE, Handle, Stage

MOST_DRAWING_POSES: Final = 400
"""Of the way along a drawing that are looked at while it is dragged."""
MOST_CONTACT_POSES: Final = 40
"""Of these, at which it is seen whether anything is touched."""
OPEN_CONFIGURATION: Final = np.full(6, UNSTATED, dtype=np.int64)

DragRecord = dict[str, Any]


def drag_record(stage: Stage, handle: Handle, position: Sequence[float]) -> DragRecord:
    """What would be at another position (3,) mm in the world.

    reached: None where no arm is known. joints: (a,) of the arm's chain there, as `view` poses it,
    None where it is not reached. other: whether another branch of the arm leads there than the
    text states. touches: names of two bodies, None for nothing. near: the same within the margin.
    left: how many of `looked` places are not reached.
    """
    nothing: DragRecord = {
        "reached": None,
        "joints": None,
        "other": False,
        "touches": None,
        "near": None,
        "left": 0,
        "looked": 0,
    }
    if stage.solved is None:
        return nothing
    with stage.lock:
        if handle.kind == DRAWING_HANDLE:
            return nothing | _drawing_record(stage, handle, np.array(position))
        return nothing | _target_record(stage, handle, position)


def target_joints(
    stage: Stage, handle: Handle, position: Sequence[float]
) -> tuple[Floats | None, bool]:
    """(a,) joints with which a target is reached at a position in the world, None if it is not.

    True for those of another configuration than the text states, on the branch that is nearest.
    """
    assert stage.solved is not None
    solution = stage.solved.solution
    leg = solution.legs[handle.procedure][handle.place - 1]
    if leg.solved_run is None:
        return None, False
    p, q = _flange_poses(leg, handle, position)
    row = leg.rows.start + handle.row
    stated = leg.solved_run.configurations[row : row + 1]
    (joints,) = solution.robot.joints_of(p, q, stated)
    if np.isfinite(joints).all():
        return joints, False
    return _nearest_joints(solution.robot, p, q, leg.joints[handle.row]), True


def target_pose(handle: Handle, position: Sequence[float]) -> Pose:
    """The pose of a target in its frame at another position (3,) mm in the world."""
    local = handle.frame.inverse() @ handle.pose
    x, y, z = handle.frame.inverse().moved(np.array([position]))[0].tolist()
    if not handle.with_arm:
        return Pose((x, y, z), local.quaternion)
    leans = closed_form.to_ab([local.position], [local.quaternion])
    w, i, j, k = closed_form.from_ab([(x, y, z)], leans)[0].tolist()
    return Pose((x, y, z), (w, i, j, k))


def _flange_poses(leg: Leg, handle: Handle, position: Sequence[float]) -> tuple[Floats, Floats]:
    assert leg.solved_run is not None
    local = target_pose(handle, position)
    rows = np.array([leg.rows.start + handle.row])
    target = np.array([local.position]), np.array([local.quaternion])
    return leg.solved_run.run.mounting.to_flange(*target, rows)


def _nearest_joints(robot: Robot, p: Floats, q: Floats, before: Floats) -> Floats | None:
    found, valid = robot.ik(p, q)
    if not valid.any():
        return None
    from_where = before if np.isfinite(before).all() else robot.home
    away = np.abs(found[0] - from_where).max(axis=1)
    best: Floats = found[0, int(np.where(valid[0], away, np.inf).argmin())]
    return best


def _target_record(stage: Stage, handle: Handle, position: Sequence[float]) -> DragRecord:
    joints, other = target_joints(stage, handle, position)
    if joints is None:
        return {"reached": False, "looked": 1, "left": 1}
    robot = stage.robot
    assert robot is not None
    chained = robot.chained(joints[None])[0].tolist()
    told: DragRecord = {"reached": True, "joints": chained, "other": other, "looked": 1}
    return told | _contact_record(stage, joints[None])


def _contact_record(stage: Stage, joints: Floats) -> DragRecord:
    """joints: (n, a) of the arm that moves; the other ones stand at home."""
    model = stage.model()
    if model is None or not len(model):
        return {}
    apart, pair = model.nearest(_all_joints(stage, model, joints))
    worst = int((apart - model.margins[pair]).argmin())
    one, other = (side[pair[worst]] for side in (model.one, model.other))
    names = [visible(model.items[int(item)].body.name) for item in (one, other)]
    if apart[worst] <= 0.0:
        return {"touches": names}
    return {"near": names} if apart[worst] < model.margins[pair[worst]] else {}


def _all_joints(stage: Stage, model: Model, joints: Floats) -> Floats:
    parts = [
        joints if one is stage.shown.placed else np.tile(one.robot.home, (len(joints), 1))
        for one in model.scene.robots
    ]
    return np.concatenate(parts, axis=1)


def _drawing_record(stage: Stage, handle: Handle, position: Floats) -> DragRecord:
    """Of places along the whole way, evenly picked."""
    assert stage.solved is not None
    solution, base = stage.solved.solution, stage.shown.base
    by = position - np.array(handle.pose.position)
    turned = np.asarray(base.inverse().moved((by + np.array(base.position))[None]))[0]
    flanges = [solved.run.flange(slice(None)) for solved in solution.solved_runs]
    if not flanges:
        return {}
    p = np.concatenate([one for one, _ in flanges])
    q = np.concatenate([one for _, one in flanges])
    picked = evenly_spaced(len(p), MOST_DRAWING_POSES)
    p, q = p[picked] + turned, q[picked]
    joints = solution.robot.joints_of(p, q, np.tile(OPEN_CONFIGURATION, (len(p), 1)))
    there = np.isfinite(joints).all(axis=1)
    left = int((~there).sum())
    told: DragRecord = {"reached": left == 0, "left": left, "looked": len(p)}
    reached = joints[there]
    if not len(reached):
        return told
    few = evenly_spaced(len(reached), MOST_CONTACT_POSES)
    return told | _contact_record(stage, reached[few])

"""What makes measured poses useless: too few, all alike, outside the limits, or read wrongly.

Where the nominal arm misses the points by far, each usual mistake is tried: radians for degrees,
another unit, mirrored points, joints in another order or counted the other way, quaternions with
w last, another robot. One that fits very much better is what happened.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

import numpy as np

from assistant import robots
from assistant.base import rotations
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.learning.calibration import rules
from assistant.learning.calibration.aligning import align_placement, rough_residual
from assistant.learning.calibration.measured import MeasuredPoses
from assistant.learning.calibration.models import LengthsModel
from assistant.learning.calibration.problem import FitProblem, KnownPlacement
from assistant.robots import Robot

SUSPICIOUS_MISS: Final = 0.005
"""Of the reach, by which the nominal arm misses the points where mistakes are tried."""
MISTAKE_SHARE: Final = 0.25
"""Of what it misses, that a mistake must leave at most to be the reason."""
SUSPICIOUS_TURN: Final = 5.0
"""Degrees of the measured turns that no arm is off by."""
LEAST_AXIS_RANGE: Final = 2.0
"""Degrees or mm by which some axis must move."""
USEFUL_AXIS_RANGE: Final = 10.0
"""Degrees or mm that an axis should move by."""
MISTAKEN_UNITS: Final = {"m": 1000.0, "cm": 10.0, "inches": 25.4}
MIRRORED_Z: Final = np.array([1.0, 1.0, -1.0])


def check_motion(robot: Robot, poses: MeasuredPoses) -> tuple[Diagnostic, ...]:
    """Findings of axes that hardly move; raises Refused for poses outside limits or all alike."""
    _check_limits(robot, poses)
    spans = np.ptp(poses.joints, axis=0) if len(poses) else np.zeros(len(robot.axes))
    if spans.max() < LEAST_AXIS_RANGE:
        unit = "degrees"
        raise Refused(
            rules.POSES_ALIKE(path=poses.path, most=max(float(spans.max()), 0.01), unit=unit)
        )
    still = [axis for axis, span in zip(robot.axes, spans, strict=True) if span < USEFUL_AXIS_RANGE]
    if not still:
        return ()
    return (
        rules.AXES_HARDLY_MOVE(path=poses.path, axes=", ".join(still), least=USEFUL_AXIS_RANGE),
    )


def _check_limits(robot: Robot, poses: MeasuredPoses) -> None:
    low, high = robot.limits.T
    outside = (poses.joints < low - 1e-3) | (poses.joints > high + 1e-3)
    findings = []
    for i in np.flatnonzero(outside.any(axis=0)):
        first, count = int(np.argmax(outside[:, i])), int(outside[:, i].sum())
        fields: dict[str, Any] = {
            "axis": robot.axes[i],
            "low": low[i],
            "high": high[i],
            "count": count,
        }
        value, row = float(poses.joints[first, i]), int(poses.rows[first])
        findings.append(
            rules.JOINTS_OUTSIDE_LIMITS(path=poses.path, row=row, value=value, **fields)
        )
    if findings:
        raise Refused(*findings)


def check_reading(robot: Robot, poses: MeasuredPoses, known: KnownPlacement) -> None:
    """Raises Refused for poses that fit very much better if they are read otherwise."""
    points = replace(poses, turns=None)
    now = _point_miss(robot, points, known)
    if now > SUSPICIOUS_MISS * robot.reach:
        tried = [
            (_point_miss(robot, other, known), what, cure)
            for other, what, cure in _other_readings(points, known, robot)
        ]
        then, what, cure = min(tried)
        if then < MISTAKE_SHARE * now:
            told: dict[str, Any] = {"now": f"{now:.4g} mm", "then": f"{then:.4g} mm"}
            raise Refused(rules.MISREAD_POSES(path=poses.path, what=what, cure=cure, **told))
        _check_other_robots(robot, points, known, now)
    if poses.turns is not None:
        _check_turns(robot, poses, known)


def _other_readings(
    poses: MeasuredPoses, known: KnownPlacement, robot: Robot
) -> Iterator[tuple[MeasuredPoses, str, str]]:
    joints, points = poses.joints, poses.points
    turning = ~robot.sliding
    scaled = np.where(turning, np.degrees(joints), joints)
    yield replace(poses, joints=scaled), "the joints are radians", "name their columns `j1_rad` …"
    for unit, factor in MISTAKEN_UNITS.items():
        column = {"inches": "in"}.get(unit, unit)
        cure = f"name the columns `x_{column}`, `y_{column}`, `z_{column}`"
        yield replace(poses, points=points * factor), f"the points are {unit}", cure
    mirrored = "the points are mirrored: two columns are swapped, or an axis counts the other way"
    cure = "bring the columns into the order of a right-handed frame"
    if known.base is None:
        yield replace(poses, points=points * MIRRORED_Z), mirrored, cure
    else:
        for order in itertools.permutations(range(3)):
            if order != (0, 1, 2):
                what = f"the points are in the order {' '.join('xyz'[i] for i in order)}"
                swapped = points[:, list(order)]
                yield replace(poses, points=swapped), what, "swap their columns"
        for i in range(3):
            signs = np.where(np.arange(3) == i, -1.0, 1.0)
            what = f"{'xyz'[i]} counts the other way (mirrored)"
            yield replace(poses, points=points * signs), what, "turn its sign"
    for a, b in itertools.combinations(range(joints.shape[1]), 2):
        places = list(range(joints.shape[1]))
        places[a], places[b] = b, a
        what = f"{robot.axes[a]} and {robot.axes[b]} are swapped"
        yield replace(poses, joints=joints[:, places]), what, "swap their columns"
    for i, axis in enumerate(robot.axes):
        signs = np.where(np.arange(joints.shape[1]) == i, -1.0, 1.0)
        yield replace(poses, joints=joints * signs), f"{axis} counts the other way", "turn its sign"


def _check_other_robots(
    robot: Robot, poses: MeasuredPoses, known: KnownPlacement, now: float
) -> None:
    found: list[tuple[float, str]] = []
    for name in robots.names():
        other = robots.get(name)
        same = len(other.axes) == len(robot.axes) and (other.sliding == robot.sliding).all()
        if same and name != robot.name:
            found.append((_point_miss(other, poses, known), name))
    then, name = min(found, default=(np.inf, ""))
    if then < MISTAKE_SHARE * now:
        fields: dict[str, Any] = {"robot": robot.name, "other": name, "now": now, "then": then}
        raise Refused(rules.OTHER_ROBOT(path=poses.path, **fields))


def _check_turns(robot: Robot, poses: MeasuredPoses, known: KnownPlacement) -> None:
    assert poses.turns is not None
    now = _turn_miss(robot, poses, known)
    if now < SUSPICIOUS_TURN:
        return
    w_last = np.roll(poses.turns, 1, axis=1)
    others = [
        (w_last, "the quaternions have w last", "name their columns in the order of the file"),
        (rotations.conjugate(poses.turns), "the quaternions are turned back", "turn their sign"),
        (rotations.conjugate(w_last), "the quaternions are turned back and have w last", "do both"),
    ]
    tried = []
    for turns, what, cure in others:
        other = replace(poses, turns=rotations.canonical(turns))
        tried.append((_turn_miss(robot, other, known), what, cure))
    then, what, cure = min(tried)
    if then > MISTAKE_SHARE * now:
        what, cure = "they are left out", "leave the columns out, or look at what is measured"
        then = 0.0
    told: dict[str, Any] = {"now": f"{now:.3g} degrees", "then": f"{then:.3g}"}
    raise Refused(rules.MISREAD_POSES(path=poses.path, what=what, cure=cure, **told))


def _point_miss(robot: Robot, poses: MeasuredPoses, known: KnownPlacement) -> float:
    """The mm by which the nominal arm misses the middle one of the points."""
    problem = FitProblem(LengthsModel(robot), poses)
    return rough_residual(problem, known)


def _turn_miss(robot: Robot, poses: MeasuredPoses, known: KnownPlacement) -> float:
    """Degrees, of the middle row, with base and tool by the points and the tool's turn by all."""
    points = FitProblem(LengthsModel(robot), replace(poses, turns=None))
    placed, _ = align_placement(points, known)
    whole = FitProblem(LengthsModel(robot), poses)
    wanted = replace(known, base=placed.base, tool=placed.tool.position)
    state, _ = align_placement(whole, wanted)
    _, turned = whole.errors(state)
    return float(np.degrees(np.median(np.linalg.norm(turned, axis=1))))

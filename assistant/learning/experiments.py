"""Learning experiments: arm, joints, points, cameras and space; those of the literature; baselines.

The baselines are what one would take today instead of a learned map, on the same trials.
`CalibratedBaseline`: the cameras are known, two pictures give points, and the kinematics of the
robot file give joints. `NearestBaseline`: joints by a plane through the nearest of pictures that
were taken of the arm about the targets, as many as the map has made movements. Both correct once by
what is seen, as the map does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, replace
from typing import Final, Protocol

import numpy as np

from assistant import robots
from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.learning.extended_map import JOINTS_OF_POINTS, ExtendedMap, MapTask
from assistant.learning.map_training import MapErrors, start_map
from assistant.learning.observed_arm import (
    Goals,
    InBox,
    InRanges,
    ObservedArm,
    Space,
    ToolRule,
    check_box,
    check_ranges,
    observed_arm,
    pair_for,
    ranges_about_home,
    ranges_for_box,
    solve_joints,
)
from assistant.learning.rules import BAD_HELD_JOINT, INCOMPLETE_TOOL_RULE, NO_AXIS, OTHER_MAP_TASK
from assistant.robots import Robot
from assistant.vision.cameras.camera import Camera, looking_at, triangulate

TOOL_TIP: Final = (0.0, 0.0, 60.0)
TOOL_POINTS: Final = (TOOL_TIP, (60.0, 0.0, 20.0), (0.0, 60.0, 20.0))
"""Mm on the flange: the tip of a tool, and marks aside of it."""


@dataclass(frozen=True, slots=True, eq=False)
class Experiment:
    """An experiment of a map. dimensions: numbers that describe a goal."""

    arm: ObservedArm
    space: Space
    ranges: Floats
    dimensions: int

    def start(self, seed: int = 0) -> ExtendedMap:
        return start_map(self.arm, self.space, self.ranges, self.dimensions, seed)


def three_joints() -> Experiment:
    """Return the published experiment: the first three joints of an arm, the tip of its tool
    anywhere in a box.

    This version uses an RV-2AJ whose hand is held straight; the box is 150 x 400 x 200 mm.
    """
    box = np.array([[300.0, 450.0], [-200.0, 200.0], [200.0, 400.0]])
    robot = robots.get("rv-2aj")
    arm = observed_arm(
        robot, pair_for(_box_corners(box)), [TOOL_TIP], ("J1", "J2", "J3"), np.zeros(5)
    )
    ranges = np.array([[-60.0, 60.0], [-60.0, 120.0], [0.0, 120.0]])
    return Experiment(arm, InBox(box), ranges, 3)


def five_joints() -> Experiment:
    """All joints of an RV-2AJ, two points of whose tool are seen."""
    robot = robots.get("rv-2aj")
    ranges = np.array([[-50.0, 50.0], [0.0, 50.0], [50.0, 100.0], [20.0, 70.0], [-45.0, 45.0]])
    return over_ranges(observed_arm(robot, (), TOOL_POINTS[:2]), ranges)


def over_ranges(arm: ObservedArm, ranges: Floats | None = None) -> Experiment:
    """Joints of any arm between ranges (a, 2), by default about its home; without cameras a pair is
    put up that sees it there.
    """
    known = ranges_about_home(arm.robot, arm.moves) if ranges is None else ranges
    seen = arm
    if not arm.cameras:
        joints = np.random.default_rng(0).uniform(known[:, 0], known[:, 1], (2000, len(known)))
        seen = arm.watched(pair_for(arm.tool(joints)[0].reshape(-1, 3)))
    return Experiment(seen, InRanges(known), known, seen.task.determined)


def over_box(arm: ObservedArm, space: InBox) -> Experiment:
    """A tool that is held by a rule, in a box; raises Refused if the arm does not reach it."""
    seen = arm
    if not arm.cameras:
        around = float(np.linalg.norm(arm.points - arm.points[0], axis=1).max())
        wider = space.box + np.array([-around, around])
        seen = arm.watched(pair_for(_box_corners(wider)))
    turned = space.rule != "any" and space.turn[0] < space.turn[1]
    return Experiment(seen, space, ranges_for_box(seen, space), 4 if turned else 3)


def six_joints() -> Experiment:
    """All joints of an IRB 1200 whose tool points down and is turned, seen by three points."""
    box = np.array([[350.0, 550.0], [-150.0, 150.0], [150.0, 350.0]])
    arm = observed_arm(robots.get("irb1200-5-0.9"), (), TOOL_POINTS)
    return over_box(arm, InBox(box, "down", (-45.0, 45.0)))


def moved_aside(camera: Camera, by: float) -> Camera:
    """A camera that stands so many mm aside and still looks at where it did, 1 m ahead."""
    eye = np.array(camera.pose.position)
    ahead = camera.directions(np.array([camera.lens.centre]))[0]
    aside = np.cross(ahead, (0.0, 0.0, 1.0))
    place = looking_at(eye + by * aside / np.linalg.norm(aside), eye + 1000.0 * ahead)
    return Camera(camera.name, camera.lens, place, camera.parent)


def _box_corners(box: Floats) -> Floats:
    """(8, 3) of a box (3, 2)."""
    grid = np.meshgrid(*box, indexing="ij")
    return np.stack([one.ravel() for one in grid], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class ExperimentSettings:
    """held: joints that stay where they are, degrees. points: (k, 3) mm of the tool on the flange,
    None for as many of `TOOL_POINTS` as tell the joints. ranges: of joints by name, instead of
    those about home. box: (3, 2) mm, None for wherever the joints bring the tool. cameras: none for
    a pair that is put up. free: the orientation of the tool is free; the joints that the points
    leave open are learnt nearest to the middle of their ranges.
    """

    robot: Robot
    held: Mapping[str, float] = field(default_factory=dict)
    points: Floats | None = None
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    box: Floats | None = None
    rule: ToolRule = "any"
    turn: tuple[float, float] = (0.0, 0.0)
    cameras: tuple[Camera, ...] = ()
    free: bool = False


def experiment_of(asked: ExperimentSettings, net: ExtendedMap | None = None) -> Experiment:
    """net: a map that goes on learning, in whose ranges targets are then drawn.

    Raises Refused for what does not fit together.
    """
    robot = asked.robot
    for name in (*asked.held, *asked.ranges):
        if name not in robot.axes:
            finding = NO_AXIS(robot=robot.title, axis=name, known=", ".join(robot.axes))
            raise Refused(finding, exit_status=2)
    moves = tuple(name for name in robot.axes if name not in asked.held)
    rest = _rest_joints(asked)
    alone = asked.free or (asked.box is not None and asked.rule == "any")
    count = 1 if alone else _points_to_determine(len(moves))
    points = np.array(TOOL_POINTS[:count]) if asked.points is None else asked.points
    arm = observed_arm(robot, asked.cameras, points.tolist(), moves, rest)
    arm = replace(arm, free=asked.free)
    if asked.rule == "any" and any(asked.turn):
        raise Refused(INCOMPLETE_TOOL_RULE(rule="by", what="its turn alone"), exit_status=2)
    if asked.rule != "any" and (asked.box is None or asked.held):
        what = "without a box" if asked.box is None else f"while {', '.join(asked.held)} stays"
        raise Refused(INCOMPLETE_TOOL_RULE(rule=asked.rule, what=what), exit_status=2)
    if asked.box is not None:
        if asked.rule == "any" and len(points) != 1:
            what = f"at {len(points)} points in a box"
            raise Refused(INCOMPLETE_TOOL_RULE(rule="anyhow", what=what), exit_status=2)
        found = over_box(arm, InBox(check_box(asked.box), asked.rule, asked.turn))
        ranges = _stated_ranges(asked, moves, found.ranges)
        made = Experiment(found.arm, found.space, ranges, found.dimensions)
    else:
        about = ranges_about_home(robot, moves)
        if net is not None and net.task.axes == moves:
            about = np.column_stack([net.scale.low, net.scale.high])
        made = over_ranges(arm, check_ranges(robot, moves, _stated_ranges(asked, moves, about)))
    if net is not None:
        _check_task(net, made)
    return made


def _rest_joints(asked: ExperimentSettings) -> Floats:
    """Joints of the whole robot where it is at home, and held ones where they are to stay."""
    robot, rest = asked.robot, asked.robot.home.copy()
    for name, value in asked.held.items():
        at = robot.axes.index(name)
        least, most = robot.limits[at].tolist()
        reason = ""
        if not least <= value <= most:
            reason = f"a {robot.title} has it between {least:g} and {most:g}"
        elif name in asked.ranges:
            reason = "it learns in a range as well"
        elif len(asked.held) == len(robot.axes):
            reason = "no joint is left that moves"
        if reason:
            raise Refused(BAD_HELD_JOINT(axis=name, value=value, reason=reason), exit_status=2)
        rest[at] = value
    return rest


def _points_to_determine(joints: int) -> int:
    return next((points for points, most in JOINTS_OF_POINTS.items() if joints <= most), 3)


def _stated_ranges(asked: ExperimentSettings, moves: tuple[str, ...], ranges: Floats) -> Floats:
    out = ranges.copy()
    for name, (low, high) in asked.ranges.items():
        if name in moves:
            out[moves.index(name)] = low, high
    return check_ranges(asked.robot, moves, out)


def _check_task(net: ExtendedMap, made: Experiment) -> None:
    """Raise Refused unless a map has learnt the requested task."""
    asked = made.arm.task
    if net.task != asked:
        raise Refused(
            OTHER_MAP_TASK(learnt=_task_text(net.task), asked=_task_text(asked)), exit_status=2
        )
    if isinstance(made.space, InRanges):
        inside = (made.ranges[:, 0] >= net.scale.low) & (made.ranges[:, 1] <= net.scale.high)
        if not inside.all():
            names = ", ".join(np.array(asked.axes)[~inside].tolist())
            learnt = f"narrower ranges of {names}"
            raise Refused(OTHER_MAP_TASK(learnt=learnt, asked="wider ones"), exit_status=2)


def _task_text(task: MapTask) -> str:
    cameras, points = ", ".join(task.cameras), "point" if task.points == 1 else "points"
    axes = ", ".join(task.axes)
    return f"{axes} of {task.robot} by {task.points} {points} in {cameras}"


_NEIGHBOUR_RATIO: Final = 3
"""Times the numbers that a plane has: how many of the nearest pictures it is laid through."""
_DISTANCES_AT_ONCE: Final = 20_000_000
"""Distances between targets and pictures that are computed together."""
_LEAST_SLOPE_SPREAD: Final = 0.2
"""Pixels: a plane has no slope along directions in which pictures differ by less."""
_LEAST_PICTURE_SPREAD: Final = 1e-9
"""Pixels, where all pictures are alike."""
_PICTURE_SURPLUS: Final = 20
"""Factor of the wanted pictures: among so many pictures, those near the targets are chosen."""


class Baseline(Protocol):
    def joints(self, pixels: Floats) -> Floats:
        """Pictures (m, d) → joints (m, a) for them."""
        ...

    def corrected(self, joints: Floats, target: Floats, seen: Floats) -> Floats:
        """Better joints (m, a), once the tool is seen there."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class CalibratedBaseline:
    """Baseline with a calibrated model. model: the arm as in its robot file, with the cameras as
    they were calibrated.

    Three points give a complete pose, which `Robot.ik` solves. For fewer points, joints are found
    by Gauss-Newton over `Robot.fk`, from the middle of the ranges (a, 2).
    """

    model: ObservedArm
    ranges: Floats

    def joints(self, pixels: Floats) -> Floats:
        return self._solved(self._points(pixels))

    def corrected(self, joints: Floats, target: Floats, seen: Floats) -> Floats:
        """Move the tool in the model by the seen distance between tool and target."""
        off = self._points(target) - self._points(seen)
        return self._solved(self.model.tool(joints)[0] + off, joints)

    def _points(self, pixels: Floats) -> Floats:
        """(m, k, 3) mm."""
        cameras: tuple[Camera, ...] = self.model.cameras
        rows = pixels.reshape(len(pixels), -1, len(cameras), 2)
        seen = [rows[:, :, i].reshape(-1, 2) for i in range(len(cameras))]
        return triangulate(cameras, seen).points.reshape(len(pixels), -1, 3)

    def _solved(self, points: Floats, begin: Floats | None = None) -> Floats:
        robot, middle = self.model.robot, self.ranges.mean(axis=1)
        if points.shape[1] >= 3 and len(self.model.moves) == len(robot.axes):
            turns = fit_rotations(self.model.points, points)
            places = points.mean(axis=1) - rotations.rotate(turns, self.model.points.mean(axis=0))
            found, valid = robot.ik(places, turns)
            away = np.where(valid, norms(np.nan_to_num(found - middle)), np.inf)
            best = found[np.arange(len(points)), away.argmin(axis=1)]
            return np.asarray(np.where(np.isfinite(best), best, middle))
        first = np.tile(middle, (len(points), 1)) if begin is None else begin
        return solve_joints(self.model, points, first, self.ranges)


@dataclass(frozen=True, slots=True, eq=False)
class NearestBaseline:
    """pictures (n, d) pixels, taken at joints (n, a); it answers between `ranges` (a, 2)."""

    pictures: Floats
    taken: Floats
    ranges: Floats
    scale: Floats = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "scale", self.pictures.std(axis=0) + _LEAST_PICTURE_SPREAD)

    def joints(self, pixels: Floats) -> Floats:
        out = [self._planes(pixels[rows])[0] for rows in self._parts(len(pixels))]
        return np.asarray(np.clip(np.concatenate(out), *self.ranges.T))

    def corrected(self, joints: Floats, target: Floats, seen: Floats) -> Floats:
        out = []
        for rows in self._parts(len(target)):
            slopes = self._planes(target[rows])[1]
            out.append(joints[rows] + np.einsum("mda,md->ma", slopes, target[rows] - seen[rows]))
        return np.asarray(np.clip(np.concatenate(out), *self.ranges.T))

    def _parts(self, count: int) -> list[slice]:
        size = max(_DISTANCES_AT_ONCE // len(self.pictures), 1)
        return [slice(at, at + size) for at in range(0, count, size)]

    def _planes(self, pixels: Floats) -> tuple[Floats, Floats]:
        """Joints (m, a) of least squares near pictures, and their slopes (m, d, a)."""
        near = self._near(pixels)
        pictures, joints = self.pictures[near], self.taken[near]
        middle, mean = pictures.mean(axis=1), joints.mean(axis=1)
        offsets = pictures - middle[:, None]
        squares = np.einsum("mnd,mne->mde", offsets, offsets)
        squares += offsets.shape[1] * _LEAST_SLOPE_SPREAD**2 * np.eye(pixels.shape[1])
        slopes = np.linalg.solve(squares, np.swapaxes(offsets, 1, 2) @ (joints - mean[:, None]))
        return mean + np.einsum("mda,md->ma", slopes, pixels - middle), slopes

    def _near(self, pixels: Floats) -> Rows:
        ours, theirs = self.pictures / self.scale, pixels / self.scale
        distances = 0.5 * (ours**2).sum(axis=1) - theirs @ ours.T
        count = min(_NEIGHBOUR_RATIO * (pixels.shape[1] + 1), len(ours))
        return np.asarray(np.argpartition(distances, count - 1, axis=1)[:, :count])


def nearest_baseline(
    arm: ObservedArm, ranges: Floats, count: int, goals: Goals, seed: int = 0
) -> NearestBaseline:
    """So many pictures of an arm between ranges; fewer where it is rarely seen.

    Those are taken whose numbers all lie between those of the goals, a tenth wider, as targets of a
    map do; others only where there are too few of them.
    """
    draw, size = np.random.default_rng(seed + 3), (count, len(ranges))
    low, high = goals.pixels.min(axis=0), goals.pixels.max(axis=0)
    more = 0.1 * (high - low)
    near: list[tuple[Floats, Floats]] = []
    far: list[tuple[Floats, Floats]] = []
    found = 0
    for _ in range(_PICTURE_SURPLUS):
        joints = draw.uniform(ranges[:, 0], ranges[:, 1], size)
        pixels = arm(joints)
        like = ((pixels >= low - more) & (pixels <= high + more)).all(axis=1)
        other = np.isfinite(pixels).all(axis=1) & ~like
        near.append((pixels[like], joints[like]))
        far.append((pixels[other][: count - found], joints[other][: count - found]))
        found += int(like.sum())
        if found >= count:
            break
    pixels, joints = (np.concatenate(columns)[:count] for columns in zip(*near, *far, strict=True))
    return NearestBaseline(pixels, joints, ranges)


def baseline_errors(rival: Baseline, arm: ObservedArm, goals: Goals) -> MapErrors:
    """Return errors as for the map: the first movement as `coarse`, the others after one
    correction.
    """
    first = rival.joints(goals.pixels)
    seen = arm(first)
    there = np.isfinite(seen).all(axis=1)
    last = first.copy()
    last[there] = rival.corrected(first[there], goals.pixels[there], seen[there])
    points, turns = arm.tool(last)
    off = norms(points[:, 0] - goals.points[:, 0])
    coarse = norms(arm.tool(first)[0][:, 0] - goals.points[:, 0])
    turned = np.array([np.nan])
    if goals.turns is not None:
        turned = rotations.angle_between(turns, goals.turns)
    pixels = np.sqrt(np.nanmean((arm(last) - goals.pixels) ** 2))
    means = float(off.mean()), float(off.max()), float(turned.mean()), float(turned.max())
    return MapErrors(0, *means, float(pixels), float(coarse.mean()))


def fit_rotations(points: Floats, found: Floats) -> Floats:
    """(m, 4) rotations that take points (k, 3) nearest to found ones (m, k, 3), about their middles
    (Kabsch, Acta Crystallographica A32, 1976).
    """
    here = points - points.mean(axis=0)
    there = found - found.mean(axis=1, keepdims=True)
    u, _, v = np.linalg.svd(np.einsum("ki,mkj->mij", here, there))
    flip = np.linalg.det(u) * np.linalg.det(v)
    u[:, :, 2] *= flip[:, None]
    return rotations.from_matrix(np.swapaxes(u @ v, 1, 2))

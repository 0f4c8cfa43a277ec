"""An arm whose tool synthetic cameras see, and goals for it.

It is called with joints and returns pixels, for learning without a real arm. Goals are targets as
the cameras see them, with the true points to measure errors by: drawn between joints, or in a box
with the tool held by a rule. `solve_joints` finds joints for seen points by the kinematics of the
robot file; the map does not use it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field, replace
from functools import cached_property
from typing import Final, Literal

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths, norms, rows_of
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.learning.extended_map import MapTask
from assistant.learning.rules import BAD_BOX, BAD_RANGE, BOX_NOT_REACHED, NO_AXIS, NO_LENGTH
from assistant.program.geometry import Pose
from assistant.robots import Robot
from assistant.robots.arms.closed_form import FiveAxis, Lengths, SixAxis
from assistant.vision.cameras.camera import Camera, Lens, looking_at

_LENGTH_NAMES: Final = ("d1", "a1", "a2", "a3", "d4", "d6")


@dataclass(frozen=True, eq=False)
class ObservedArm:
    """Called with joints (n, a) of `moves` it answers pixels (n, d), as `ArmFunction`.

    robot: in whose base the cameras stand. moves: names of the joints that move; the others stay at
    `rest`, (robot's a,), by default its home. points: (k, 3) mm of the tool in the frame of the
    flange. noise: pixels, one sigma, drawn by `seed`. free: the orientation of the tool is free, so
    that fewer points than the joints need are enough: only their places are learnt.
    """

    robot: Robot
    cameras: tuple[Camera, ...]
    points: Floats
    moves: tuple[str, ...]
    rest: Floats
    noise: float = 0.0
    seed: int = 0
    free: bool = False
    _draw: np.random.Generator = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_draw", np.random.default_rng(self.seed))

    def __call__(self, joints: Floats) -> Floats:
        return self.seen(self.tool(joints)[0])

    def tool(self, joints: Floats) -> tuple[Floats, Floats]:
        """Joints (n, a) → the points of the tool (n, k, 3) mm and its rotation (n, 4); the truth,
        which the map never sees.
        """
        whole = np.tile(self.rest, (len(joints), 1))
        whole[:, self.columns] = joints
        positions, turns = self.robot.flange_poses(whole)
        return positions[:, None] + rotations.rotate(turns[:, None], self.points), turns

    def seen(self, points: Floats) -> Floats:
        """Points (n, k, 3) of a tool → pixels (n, d), with noise; NaN outside of a picture."""
        out = np.empty((*points.shape[:2], len(self.cameras), 2))
        flat = points.reshape(-1, 3)
        for i, camera in enumerate(self.cameras):
            pixels = camera.project(flat)
            pixels[~camera.within(pixels)] = np.nan
            out[:, :, i] = pixels.reshape(*points.shape[:2], 2)
        if self.noise:
            out += self._draw.normal(0.0, self.noise, out.shape)
        return out.reshape(len(points), -1)

    @cached_property
    def columns(self) -> list[int]:
        return [self.robot.axes.index(name) for name in self.moves]

    @property
    def task(self) -> MapTask:
        names = tuple(camera.name for camera in self.cameras)
        return MapTask(self.robot.name, self.moves, names, len(self.points))

    def noisy(self, noise: float, seed: int = 0) -> ObservedArm:
        return replace(self, noise=noise, seed=seed)

    def bent(self, points: Floats) -> ObservedArm:
        """With another tool."""
        return replace(self, points=points)

    def watched(self, cameras: Sequence[Camera]) -> ObservedArm:
        """By other cameras, or by the same ones that have been moved."""
        return replace(self, cameras=tuple(cameras))

    def longer(self, name: str, factor: float) -> ObservedArm:
        """With another length of a link, by its name in `Lengths`; raises Refused for none."""
        return replace(self, robot=with_length(self.robot, name, factor))


def observed_arm(
    robot: Robot,
    cameras: Sequence[Camera],
    points: Sequence[Sequence[float]],
    moves: Sequence[str] = (),
    rest: Floats | None = None,
) -> ObservedArm:
    """moves: by default all joints. Raises Refused for a joint that the robot has not."""
    known = tuple(moves) or robot.axes
    for name in known:
        if name not in robot.axes:
            finding = NO_AXIS(robot=robot.title, axis=name, known=", ".join(robot.axes))
            raise Refused(finding, exit_status=2)
    still = robot.home if rest is None else np.asarray(rest, dtype=np.float64)
    tool = rows_of(points, 3, "points")
    return ObservedArm(robot, tuple(cameras), tool, known, still)


def with_length(robot: Robot, name: str, factor: float) -> Robot:
    """The robot with one length times a factor; raises Refused for a length that it has not."""
    lengths = getattr(robot.arm, "lengths", None)
    known = [one for one in _LENGTH_NAMES if getattr(lengths, one, 0.0)]
    if not isinstance(robot.arm, SixAxis | FiveAxis) or name not in known:
        finding = NO_LENGTH(robot=robot.title, name=name, known=", ".join(known) or "none")
        raise Refused(finding, exit_status=2)
    values = {one: getattr(lengths, one) for one in _LENGTH_NAMES}
    values[name] *= factor
    return replace(robot, arm=replace(robot.arm, lengths=Lengths(**values)))


_PAIR_LENS: Final = Lens.ideal((640, 480), 800.0)
_PAIR_MARGIN: Final = 30.0
"""Pixels that are kept free at the edges by `pair_for`."""
_PAIR_ASIDE: Final = 0.3
"""Sideways offset of each of the two cameras, as a share of the distance."""
_PAIR_HEIGHT: Final = 0.35
"""Height of the cameras above the observed points, as a share of the distance."""


def pair_for(points: Floats, lens: Lens = _PAIR_LENS) -> tuple[Camera, Camera]:
    """Two cameras in front of a robot that see points (n, 3) mm of its base, as near as can be."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    distance = max(float(np.linalg.norm(np.ptp(points, axis=0))), 1.0)
    while True:
        cameras = tuple(
            Camera(name, lens, _pose_of_pair(middle, distance, side * _PAIR_ASIDE))
            for name, side in (("left", -1.0), ("right", 1.0))
        )
        if all(one.within(one.project(points), _PAIR_MARGIN).all() for one in cameras):
            return cameras[0], cameras[1]
        distance *= 1.05


def _pose_of_pair(middle: Floats, distance: float, aside: float) -> Pose:
    ahead = np.array([1.0, aside, _PAIR_HEIGHT])
    eye = middle + distance * ahead / np.linalg.norm(ahead)
    return looking_at(eye, middle)


_SLOPE_STEP: Final = 1e-4
"""Degrees (mm) by which slopes of forward kinematics are taken."""
_LONGEST_STEP: Final = 20.0
"""Degrees (mm) of one step."""
_SOLVER_ROUNDS: Final = 60


def solve_joints(arm: ObservedArm, points: Floats, begin: Floats, ranges: Floats) -> Floats:
    """Joints (m, a) within ranges (a, 2) for points (m, k, 3) mm; Gauss and Newton from (m, a)."""
    joints = np.clip(begin, ranges[:, 0], ranges[:, 1])
    even = np.eye(joints.shape[1])
    for _ in range(_SOLVER_ROUNDS):
        off = (points - arm.tool(joints)[0]).reshape(len(points), -1)
        slope = point_slopes(arm, joints)
        square = np.einsum("mri,mrj->mij", slope, slope)
        square += 1e-9 * even * np.trace(square, axis1=1, axis2=2)[:, None, None]
        pull = np.einsum("mri,mr->mi", slope, off)
        step = np.linalg.solve(square, pull[..., None])[..., 0]
        step = np.clip(step, -_LONGEST_STEP, _LONGEST_STEP)
        joints = np.clip(joints + step, ranges[:, 0], ranges[:, 1])
        if np.abs(step).max() < 1e-9:
            break
    return joints


def point_slopes(arm: ObservedArm, joints: Floats) -> Floats:
    """(m, 3 k, a) mm a degree (mm) of the seen points at joints (m, a)."""
    columns = []
    for axis in range(joints.shape[1]):
        more, less = joints.copy(), joints.copy()
        more[:, axis] += _SLOPE_STEP
        less[:, axis] -= _SLOPE_STEP
        apart = arm.tool(more)[0] - arm.tool(less)[0]
        columns.append(apart.reshape(len(joints), -1) / (2.0 * _SLOPE_STEP))
    return np.stack(columns, axis=-1)


ToolRule = Literal["any", "down", "forward"]
"""Orientation of the tool: any, its z axis down, or along x of the base."""
_TOOL_ROTATIONS: Final[dict[ToolRule, tuple[float, float, float, float]]] = {
    "down": (0.0, 0.0, 1.0, 0.0),
    "forward": (0.7071067811865476, 0.0, 0.7071067811865476, 0.0),
}
"""Rotations of a tool that is not turned about its own axis."""
_BOX_SAMPLES: Final = 2000
"""Poses by which it is asked how much of a box an arm reaches."""
_LEAST_REACHED: Final = 0.999
_REACHED_MM: Final = 0.01
"""Mm within which a place is reached."""


@dataclass(frozen=True, slots=True, eq=False)
class Goals:
    """pixels: (m, d). points: (m, k, 3) mm of the tool there. turns: (m, 4) of the tool, None where
    only a place is wanted.
    """

    pixels: Floats
    points: Floats
    turns: Floats | None = None

    @property
    def diagonal(self) -> float:
        """Mm of the box about the places of the first point."""
        return float(np.linalg.norm(np.ptp(self.points[:, 0], axis=0)))


@dataclass(frozen=True, slots=True, eq=False)
class InRanges:
    """The tool wherever joints between (a, 2) bring it."""

    ranges: Floats

    def draw(self, arm: ObservedArm, count: int, draw: np.random.Generator) -> Goals:
        joints = _random_joints(draw, self.ranges, count)
        points, turns = arm.tool(joints)
        return Goals(arm.seen(points), points, None if arm.free else turns)


@dataclass(frozen=True, slots=True, eq=False)
class InBox:
    """The first point of the tool in a box (3, 2) mm of the base, the tool held by a rule.

    rule: `any` only for arms of which one point is seen. turn: degrees about the tool's own axis,
    lowest and highest.
    """

    box: Floats
    rule: ToolRule = "any"
    turn: tuple[float, float] = (0.0, 0.0)

    def draw(self, arm: ObservedArm, count: int, draw: np.random.Generator) -> Goals:
        places = _random_joints(draw, self.box, count)
        if self.rule == "any":
            points = places[:, None]
            return Goals(arm.seen(points), points)
        turns = self._turns(draw.uniform(*self.turn, count))
        points = places[:, None] + rotations.rotate(turns[:, None], arm.points - arm.points[0])
        return Goals(arm.seen(points), points, turns)

    def joints(
        self, arm: ObservedArm, count: int, draw: np.random.Generator
    ) -> tuple[Floats, Truths]:
        """Return joints (n, a) for poses in the box, of the branch that reaches most, and which
        poses it reaches.
        """
        places = _random_joints(draw, self.box, count)
        turns = self._turns(draw.uniform(*self.turn, count))
        flange = places - rotations.rotate(turns, arm.points[0])
        joints, valid = arm.robot.ik(flange, turns)
        best = int(valid.sum(axis=0).argmax())
        return joints[:, best], valid[:, best]

    def _turns(self, degrees: Floats) -> Floats:
        about = rotations.about((0.0, 0.0, 1.0) * np.ones((len(degrees), 1)), degrees)
        return rotations.canonical(rotations.multiply(np.array(_TOOL_ROTATIONS[self.rule]), about))


Space = InRanges | InBox


def ranges_about_home(robot: Robot, moves: Sequence[str]) -> Floats:
    """(a, 2) in which every joint of an arm can learn: 25 degrees about its home, 50 of the first
    axis and 45 of the last, moved into its limits.
    """
    wide = {robot.axes[0]: 50.0, robot.axes[-1]: 45.0}
    out = []
    for name in moves:
        at = robot.axes.index(name)
        least, most = robot.limits[at]
        half = min(wide.get(name, 25.0), (most - least) / 2.0)
        middle = float(np.clip(robot.home[at], least + half, most - half))
        out.append((middle - half, middle + half))
    return np.array(out)


def check_ranges(robot: Robot, moves: Sequence[str], ranges: Floats) -> Floats:
    """Return the ranges (a, 2) unchanged; raises Refused for a range that is empty or leaves the
    limits.
    """
    for name, (low, high) in zip(moves, ranges.tolist(), strict=True):
        least, most = robot.limits[robot.axes.index(name)].tolist()
        if not least <= low < high <= most:
            said = BAD_RANGE(
                axis=name, low=low, high=high, robot=robot.title, least=least, most=most
            )
            raise Refused(said, exit_status=2)
    return ranges


def check_box(box: Floats) -> Floats:
    """Return the box (3, 2) unchanged; raises Refused for an invalid box."""
    reason = ""
    if box.shape != (3, 2) or not np.isfinite(box).all():
        reason = "is not three ranges of numbers"
    elif not (box[:, 0] < box[:, 1]).all():
        reason = "is empty"
    if reason:
        raise Refused(BAD_BOX(reason=reason), exit_status=2)
    return box


def ranges_for_box(arm: ObservedArm, space: InBox, seed: int = 0) -> Floats:
    """(a, 2) between which joints reach all of a box, a twentieth wider, inside the limits.

    Raises Refused if the arm does not reach the box in one of its branches, without a rule from its
    home on.
    """
    draw = np.random.default_rng(seed)
    limits = arm.robot.limits[arm.columns]
    if space.rule == "any":
        points = _random_joints(draw, space.box, _BOX_SAMPLES)[:, None]
        home = np.tile(arm.robot.home[arm.columns], (_BOX_SAMPLES, 1))
        joints = solve_joints(arm, points, home, limits)
        reached = norms(arm.tool(joints)[0][:, 0] - points[:, 0]) < _REACHED_MM
    else:
        joints, reached = space.joints(arm, _BOX_SAMPLES, draw)
    share = float(reached.mean())
    if share < _LEAST_REACHED:
        held = "anyhow" if space.rule == "any" else space.rule
        finding = BOX_NOT_REACHED(share=share, robot=arm.robot.title, rule=held)
        raise Refused(finding, exit_status=1)
    low, high = joints[reached].min(axis=0), joints[reached].max(axis=0)
    more = 0.05 * (high - low) + 1.0
    least, most = limits.T
    return np.column_stack([np.maximum(low - more, least), np.minimum(high + more, most)])


def _random_joints(draw: np.random.Generator, ranges: Floats, count: int) -> Floats:
    """(count, a) between ranges (a, 2)."""
    return draw.uniform(ranges[:, 0], ranges[:, 1], (count, len(ranges)))

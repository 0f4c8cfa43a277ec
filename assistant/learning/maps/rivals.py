"""What one would take today instead of a learned map, on the same trials: two of them.

`Calibrated`: the cameras are known, two pictures give points, points give joints by the kinematics
of the robot file. `Nearest`: joints by a plane through the nearest of pictures that were taken of
the arm about the targets, as many as the map has made movements. Both then correct once by what is
seen, as the map does.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final, Protocol

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, norms
from assistant.learning.maps.goals import Goals
from assistant.learning.maps.seen_arm import ObservedArm
from assistant.learning.maps.solving import solve_joints
from assistant.learning.maps.training import MapErrors
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.triangulating import triangulate

NEIGHBOUR_RATIO: Final = 3
"""Times the numbers that a plane has: how many of the nearest pictures it is laid through."""
DISTANCES_AT_ONCE: Final = 20_000_000
"""Distances between targets and pictures that are computed together."""
LEAST_SLOPE_SPREAD: Final = 0.2
"""Pixels: a plane has no slope along directions in which pictures differ by less."""
LEAST_PICTURE_SPREAD: Final = 1e-9
"""Pixels, where all pictures are alike."""
PICTURE_SURPLUS: Final = 20
"""Times the pictures that are wanted, among which those about the targets are looked for."""


class Baseline(Protocol):
    def joints(self, pixels: Floats) -> Floats:
        """Pictures (m, d) → joints (m, a) for them."""
        ...

    def corrected(self, joints: Floats, target: Floats, seen: Floats) -> Floats:
        """Better joints (m, a), once the tool is seen there."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class CalibratedBaseline:
    """model: the arm as its robot file has it, with the cameras as they were calibrated.

    A whole pose, told by three points, goes through `Robot.ik`. For fewer points joints are found
    by Gauss and Newton over `Robot.fk`, from the middle of the ranges (a, 2).
    """

    model: ObservedArm
    ranges: Floats

    def joints(self, pixels: Floats) -> Floats:
        return self._solved(self._points(pixels))

    def corrected(self, joints: Floats, target: Floats, seen: Floats) -> Floats:
        """As far from where the model has the tool as it is seen to be from the target."""
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
        object.__setattr__(self, "scale", self.pictures.std(axis=0) + LEAST_PICTURE_SPREAD)

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
        size = max(DISTANCES_AT_ONCE // len(self.pictures), 1)
        return [slice(at, at + size) for at in range(0, count, size)]

    def _planes(self, pixels: Floats) -> tuple[Floats, Floats]:
        """Joints (m, a) of least squares near pictures, and their slopes (m, d, a)."""
        near = self._near(pixels)
        pictures, joints = self.pictures[near], self.taken[near]
        middle, mean = pictures.mean(axis=1), joints.mean(axis=1)
        offsets = pictures - middle[:, None]
        squares = np.einsum("mnd,mne->mde", offsets, offsets)
        squares += offsets.shape[1] * LEAST_SLOPE_SPREAD**2 * np.eye(pixels.shape[1])
        slopes = np.linalg.solve(squares, np.swapaxes(offsets, 1, 2) @ (joints - mean[:, None]))
        return mean + np.einsum("mda,md->ma", slopes, pixels - middle), slopes

    def _near(self, pixels: Floats) -> Rows:
        ours, theirs = self.pictures / self.scale, pixels / self.scale
        distances = 0.5 * (ours**2).sum(axis=1) - theirs @ ours.T
        count = min(NEIGHBOUR_RATIO * (pixels.shape[1] + 1), len(ours))
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
    for _ in range(PICTURE_SURPLUS):
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
    """As of the map: its first movement as `coarse`, the others after one correction."""
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

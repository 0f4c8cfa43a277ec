"""Points of a trajectory beside the poses at which an arm passed them, and a plot of both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.program.se3 import Unit
from assistant.report import figures
from assistant.report.plots import draw_pose_curves, label_poses

ARM_MARKS: Final = ".x+1234"
"""Marks of the arms that are drawn, in their order."""


@dataclass(frozen=True, slots=True)
class Poses:
    """Positions (n, 3) mm and unit quaternions (n, 4), scalar first."""

    positions: Floats
    quaternions: Floats

    def __len__(self) -> int:
        return len(self.positions)

    def deviation(self, other: Poses) -> tuple[float, float]:
        """Return the largest distance in mm and the largest angle in degrees between like rows."""
        apart = np.linalg.norm(self.positions - other.positions, axis=1)
        turned = rotations.angle_between(self.quaternions, other.quaternions)
        return float(apart.max(initial=0.0)), float(turned.max(initial=0.0))


def passed_poses(points: Poses, seen: Poses) -> Poses:
    """Return the poses at which a motion passes points, in the order of the points.

    points: n of them. seen: the motion, one or more samples of it in the order of time; between
    two samples it goes straight and turns evenly. Each point is looked for after the one before
    it, up to the end of the motion, where the motion is nearest to it.
    """
    if len(seen) == 1:
        seen = Poses(np.repeat(seen.positions, 2, 0), np.repeat(seen.quaternions, 2, 0))
    starts = seen.positions[:-1]
    steps = np.diff(seen.positions, axis=0)
    squares = np.einsum("ij,ij->i", steps, steps)
    nearest = np.empty(len(points))
    reached = 0.0
    for index, point in enumerate(points.positions):
        first = min(int(reached), len(steps) - 1)
        along = np.einsum("ij,ij->i", point - starts[first:], steps[first:])
        parts = along / np.where(squares[first:] > 0.0, squares[first:], 1.0)
        lowest = np.zeros(len(parts))
        lowest[0] = reached - first
        parts = np.clip(parts, lowest, 1.0)
        places = starts[first:] + parts[:, None] * steps[first:]
        best = int(np.linalg.norm(places - point, axis=1).argmin())
        reached = nearest[index] = first + best + parts[best]
    rows = np.minimum(nearest.astype(int), len(steps) - 1)
    parts = nearest - rows
    return Poses(
        starts[rows] + parts[:, None] * steps[rows],
        rotations.between(seen.quaternions[rows], seen.quaternions[rows + 1], parts),
    )


def point_plot(
    points: Poses,
    arms: Mapping[str, Poses],
    title: str,
    *,
    unit: Unit = "mm",
    format: str = "png",
) -> bytes:
    """Position and quaternion of the TCP over the number of the point.

    points: the trajectory, drawn as lines. arms: name of an arm → where it passed the points,
    drawn as marks. unit: of the positions that are drawn.
    """
    figure = figures.new_figure(8.0, 6.0)
    upper, lower = figure.subplots(2, 1, sharex=True)
    numbers = np.arange(1.0, len(points) + 1.0)
    turns = rotations.unflipped(points.quaternions)
    draw_pose_curves((upper, lower), numbers, points.positions, turns, unit)
    for mark, (name, there) in zip(ARM_MARKS, arms.items(), strict=False):
        other = np.einsum("ij,ij->i", there.quaternions, turns) < 0.0  # side of the sphere
        signed = np.where(other[:, None], -there.quaternions, there.quaternions)
        drawn = {"linestyle": "", "marker": mark}
        draw_pose_curves(
            (upper, lower), numbers, there.positions, signed, unit, named=False, **drawn
        )
        upper.plot([], [], color="black", label=name, **drawn)
    return label_poses(figure, (upper, lower), "point", title, unit, format)

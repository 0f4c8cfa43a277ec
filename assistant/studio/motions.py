"""How an arm moved in a run, in columns for the page, and how far two such motions are apart."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, evenly_spaced, norms
from assistant.robots import Robot

MOST_POINTS: Final = 2_000
"""Of each curve that the page draws."""
MOST_COMPARED: Final = 20_000
"""Of each path that is compared."""
TURN_WEIGHT: Final = 100.0
"""mm that a place counts as farther off whose tool is turned right round: where a tool turns on the
spot, or comes by again, the place is meant at which it is turned alike."""
BLOCK_SIZE: Final = 256
"""Places whose distances from all of the other path are worked out at once."""

MotionColumns = Mapping[str, np.ndarray]
"""As `motion_columns` gives them; empty where motions take no time."""


def shown_motion(
    columns: MotionColumns, robot: Robot | None, most: int = MOST_POINTS
) -> dict[str, Any]:
    """Columns of a run as lists: samples evenly picked, the first and the last among them.

    t: seconds. position: mm, rows of x, y, z; quaternion: (w, x, y, z); orientation: degrees about
    z, y, x, each without jumps; joints: degrees, rows by `axes`; chain: the same as the scene poses
    the arm; speed: mm/s; inputs and outputs:
    rows by their names. samples: how many there are in all.
    """
    if "t" not in columns or robot is None:
        return {"samples": 0, "t": []}
    count = len(columns["t"])
    some = evenly_spaced(count, max(2, most))
    picked = ("t", "position", "quaternion", "joints", "speed", "inputs", "outputs")
    names = ("axes", "input_names", "output_names")
    angles = np.unwrap(rotations.to_euler(columns["quaternion"]), period=360.0, axis=0)
    return {
        "samples": count,
        **{name: columns[name][some].tolist() for name in picked},
        **{name: columns[name].tolist() for name in names},
        "orientation": angles[some].tolist(),
        "chain": robot.chained(columns["joints"][some]).tolist(),
    }


@dataclass(frozen=True, slots=True)
class Deviation:
    """The place of one path that is farthest from the other path.

    distance: mm. angle: degrees, the most that the tool is turned otherwise at the place that is
    nearest. time: seconds on the path of the run that the place is on. of: 0 or 1, that run.
    """

    distance: float
    angle: float
    time: float
    of: int


def path_deviation(
    first: MotionColumns, second: MotionColumns, begins: tuple[Floats, Floats]
) -> Deviation | None:
    """How far two tools' paths are apart at most, seen from either; None without both.

    begins: seconds at which the motions of each begin. Where there are as many of both, a place is
    compared with those of the same motion only. Nothing is said of when the tools are there: what
    is slower alone has no deviation.
    """
    if "t" not in first or "t" not in second:
        return None
    one, two = _moving_samples(first), _moving_samples(second)
    if len(begins[0]) != len(begins[1]):
        begins = np.zeros(1), np.zeros(1)
    found = []
    for of, (here, there) in enumerate(((one, two), (two, one))):
        distance, angle = _deviation_by_motion(here, there, begins[of], begins[1 - of])
        at = int(np.argmax(distance))
        found.append(Deviation(float(distance[at]), float(angle.max()), float(here["t"][at]), of))
    worst = max(found, key=lambda each: each.distance)
    return Deviation(worst.distance, max(each.angle for each in found), worst.time, worst.of)


def _deviation_by_motion(
    here: Mapping[str, Floats], there: Mapping[str, Floats], begin: Floats, other: Floats
) -> tuple[Floats, Floats]:
    """(k,) mm and degrees of each place of a path from the same motion of the other one."""
    ours = np.append(np.searchsorted(here["t"], begin), len(here["t"]))
    ours[0] = 0
    low = np.maximum(np.searchsorted(there["t"], other, side="right") - 1, 0)
    high = np.append(np.searchsorted(there["t"], other[1:]) + 1, len(there["t"]))
    low[0] = 0
    distance, angle = np.zeros(len(here["t"])), np.zeros(len(here["t"]))
    for k in range(len(begin)):
        rows, window = slice(ours[k], ours[k + 1]), slice(low[k], max(high[k], low[k] + 1))
        if ours[k] < ours[k + 1]:
            pair = ({n: c[s] for n, c in p.items()} for p, s in ((here, rows), (there, window)))
            distance[rows], angle[rows] = _distance_to_lines(*pair)
    return distance, angle


def _moving_samples(columns: MotionColumns) -> dict[str, Floats]:
    """Samples at which the tool went on, not too many of them."""
    position, quaternion = columns["position"], columns["quaternion"]
    gone = norms(np.diff(position, axis=0)) > 0.0
    turned = np.any(np.diff(quaternion, axis=0) != 0.0, axis=1)
    kept = np.flatnonzero(np.append(True, gone | turned))
    step = -(-len(kept) // MOST_COMPARED)
    kept = np.unique(np.append(kept[::step], kept[-1]))
    return {"t": columns["t"][kept], "position": position[kept], "quaternion": quaternion[kept]}


def _distance_to_lines(
    here: Mapping[str, Floats], there: Mapping[str, Floats]
) -> tuple[Floats, Floats]:
    """(k,) mm and degrees of each place of a path from the lines about the nearest of another.

    Places are near each other by where they are and how they are turned, see TURNED.
    """
    points, path = here["position"], there["position"]
    squares = np.einsum("ij,ij->i", path, path)
    nearest = np.empty(len(points), dtype=np.intp)
    for begin in range(0, len(points), BLOCK_SIZE):
        rows = slice(begin, begin + BLOCK_SIZE)
        cosine = np.abs(here["quaternion"][rows] @ there["quaternion"].T)
        unlike = squares - 2.0 * points[rows] @ path.T - 2.0 * TURN_WEIGHT**2 * cosine
        nearest[rows] = np.argmin(unlike, axis=1)
    place, turn = path[nearest], there["quaternion"][nearest]
    best = _pose_distance(points, here["quaternion"], place, turn)
    for side in (-1, 1):
        other = np.clip(nearest + side, 0, len(path) - 1)
        way = path[other] - path[nearest]
        first, last = there["quaternion"][nearest], there["quaternion"][other]
        step = _same_side(last, first) - first
        along = np.sum((points - path[nearest]) * way, axis=1)
        along += TURN_WEIGHT**2 * np.sum(
            (_same_side(here["quaternion"], first) - first) * step, axis=1
        )
        length = np.sum(way * way, axis=1) + TURN_WEIGHT**2 * np.sum(step * step, axis=1)
        part = np.clip(along / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
        at, turned = path[nearest] + part[:, None] * way, rotations.between(first, last, part)
        off = _pose_distance(points, here["quaternion"], at, turned)
        nearer = (off < best)[:, None]
        place, turn = np.where(nearer, at, place), np.where(nearer, turned, turn)
        best = np.minimum(best, off)
    return norms(points - place), rotations.angle_between(here["quaternion"], turn)


def _pose_distance(points: Floats, turns: Floats, places: Floats, others: Floats) -> Floats:
    """(k,) mm squared by which poses are unlike."""
    turned = _same_side(turns, others) - others
    return np.asarray(
        np.sum((points - places) ** 2, axis=1) + TURN_WEIGHT**2 * np.sum(turned**2, axis=1)
    )


def _same_side(quaternions: Floats, others: Floats) -> Floats:
    """(k, 4) the same rotations, each on the side of another one."""
    return np.where(np.sum(quaternions * others, axis=1) < 0.0, -1.0, 1.0)[:, None] * quaternions

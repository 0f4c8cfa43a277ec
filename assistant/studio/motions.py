"""How an arm moved in a run, in columns for the page, and how far two such motions are apart."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from assistant.program import rotations
from assistant.program.arrays import Floats, norms

MOST_POINTS: Final = 2_000
"""Of each curve that the page draws."""
MOST_PLACES: Final = 20_000
"""Of each path that is compared."""
TURNED: Final = 100.0
"""mm that a place counts as farther off whose tool is turned right round: where a tool turns on the
spot, or comes by again, the place is meant at which it is turned alike."""
TOGETHER: Final = 256
"""Places whose distances from all of the other path are worked out at once."""

Columns = Mapping[str, np.ndarray]
"""As `motion_columns` gives them; empty where motions take no time."""


def shown(columns: Columns, most: int = MOST_POINTS) -> dict[str, Any]:
    """Columns of a run as lists: samples evenly picked, the first and the last among them.

    t: seconds. position: mm, rows of x, y, z; quaternion: (w, x, y, z); orientation: degrees about
    z, y, x, each without jumps; joints: degrees, rows by `axes`; speed: mm/s; inputs and outputs:
    rows by their names. samples: how many there are in all.
    """
    if "t" not in columns:
        return {"samples": 0, "t": []}
    count = len(columns["t"])
    some = np.unique(np.linspace(0, count - 1, max(2, most)).astype(np.intp))
    picked = ("t", "position", "quaternion", "joints", "speed", "inputs", "outputs")
    names = ("axes", "input_names", "output_names")
    angles = np.unwrap(rotations.to_euler(columns["quaternion"]), period=360.0, axis=0)
    return {
        "samples": count,
        **{name: columns[name][some].tolist() for name in picked},
        **{name: columns[name].tolist() for name in names},
        "orientation": angles[some].tolist(),
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


def deviation(first: Columns, second: Columns) -> Deviation | None:
    """How far two tools' paths are apart at most, seen from either; None without both.

    It says nothing of when the tools are there: what is slower alone has no deviation.
    """
    if "t" not in first or "t" not in second:
        return None
    one, two = _path(first), _path(second)
    found = []
    for of, (here, there) in enumerate(((one, two), (two, one))):
        distance, angle = _apart(here, there)
        at = int(np.argmax(distance))
        found.append(Deviation(float(distance[at]), float(angle.max()), float(here["t"][at]), of))
    worst = max(found, key=lambda each: each.distance)
    return Deviation(worst.distance, max(each.angle for each in found), worst.time, worst.of)


def _path(columns: Columns) -> dict[str, Floats]:
    """Samples at which the tool went on, not too many of them."""
    position, quaternion = columns["position"], columns["quaternion"]
    gone = norms(np.diff(position, axis=0)) > 0.0
    turned = np.any(np.diff(quaternion, axis=0) != 0.0, axis=1)
    kept = np.flatnonzero(np.append(True, gone | turned))
    step = -(-len(kept) // MOST_PLACES)
    kept = np.unique(np.append(kept[::step], kept[-1]))
    return {"t": columns["t"][kept], "position": position[kept], "quaternion": quaternion[kept]}


def _apart(here: Mapping[str, Floats], there: Mapping[str, Floats]) -> tuple[Floats, Floats]:
    """(k,) mm and degrees of each place of a path from the lines about the nearest of another."""
    points, path = here["position"], there["position"]
    nearest = np.empty(len(points), dtype=np.intp)
    squares = np.einsum("ij,ij->i", path, path)
    for begin in range(0, len(points), TOGETHER):
        rows = slice(begin, begin + TOGETHER)
        cosine = here["quaternion"][rows] @ there["quaternion"].T
        unlike = squares - 2.0 * points[rows] @ path.T - TURNED**2 * cosine**2
        nearest[rows] = np.argmin(unlike, axis=1)
    distance = norms(points - path[nearest])
    turn = there["quaternion"][nearest]
    for side in (-1, 1):
        other = np.clip(nearest + side, 0, len(path) - 1)
        way = path[other] - path[nearest]
        length = np.einsum("ij,ij->i", way, way)
        along = np.einsum("ij,ij->i", points - path[nearest], way)
        part = np.clip(along / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
        off = norms(points - path[nearest] - part[:, None] * way)
        nearer = off < distance
        between = rotations.between(there["quaternion"][nearest], there["quaternion"][other], part)
        distance = np.where(nearer, off, distance)
        turn = np.where(nearer[:, None], between, turn)
    return distance, rotations.angle_between(here["quaternion"], turn)

"""Arms of five axes: targets and paths with orientations that they reach."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Truths
from assistant.base.diagnostics import Findings, Subject
from assistant.program.geometry import Target
from assistant.program.motion import Path, configuration_row
from assistant.program.passes.legalisation import FiveAxes
from assistant.robots.configurations import BACK

ORIENTATION_TOLERANCE: Final = 0.05
"""degrees by which an orientation may leave what five axes reach."""
EQUAL_ORIENTATION: Final = 1e-6
"""degrees below which it is reached as it is."""
VERTICAL: Final = 1e-4
"""Sine of the tool's tilt below which it counts as straight up or down."""


def over_the_back(
    positions: Floats,
    quaternions: Floats,
    configurations: NDArray[np.int8],
) -> Truths:
    """Which poses a five-axis arm takes over its back with a tool that is not vertical (n,).

    Their A and B depend on axis 1, which no source says of this branch; straight down both
    branches show the same.
    """
    from assistant.robots.arms import five_axis

    tilt = five_axis.to_ab(positions, quaternions)[:, 1]
    tilted = np.abs(np.sin(np.radians(tilt))) > VERTICAL
    return np.asarray((configurations[:, BACK] == 1) & tilted)


def target_in_reach(
    name: str, target: Target, about: Subject | str, can: FiveAxes, findings: Findings
) -> Target:
    """A target with the orientation that is reached at its position."""
    positions, quaternions = np.array([target.pose.position]), np.array([target.pose.quaternion])
    row = np.array([configuration_row(target.configuration)], dtype=np.int8)
    if over_the_back(positions, quaternions, row)[0]:
        findings.append(can.over_the_back(name=name, about=about))
    (angle,) = miss = _orientation_error(positions, quaternions)
    if angle > ORIENTATION_TOLERANCE:
        findings.append(can.unreachable(name=name, angle=float(angle), about=about))
    if angle <= EQUAL_ORIENTATION:
        return target
    w, x, y, z = (float(v) for v in _reached_orientations(positions, quaternions, miss)[0])
    return replace(target, pose=replace(target.pose, quaternion=(w, x, y, z)))


def path_in_reach(path: Path, can: FiveAxes, findings: Findings) -> Path:
    """A path with the orientations that are reached at its positions."""
    behind = over_the_back(path.positions, path.quaternions, path.configurations)
    if behind.any():
        place = f"{int(behind.sum())} targets of {path.name}"
        name = f"{path.name}_{int(behind.argmax()) + 1}"
        findings.append(can.over_the_back(name=name, place=place))
    miss = _orientation_error(path.positions, path.quaternions)
    if far := int(np.count_nonzero(miss > ORIENTATION_TOLERANCE)):
        worst = int(np.argmax(miss))
        name, place = f"{path.name}_{worst + 1}", f"{far} targets of {path.name}"
        findings.append(can.unreachable(name=name, angle=float(miss[worst]), place=place))
    if not (miss > EQUAL_ORIENTATION).any():
        return path
    return replace(path, quaternions=_reached_orientations(path.positions, path.quaternions, miss))


def _orientation_error(positions: Floats, quaternions: Floats) -> Floats:
    from assistant.robots.arms import five_axis

    return five_axis.miss(positions, quaternions)


def _reached_orientations(positions: Floats, quaternions: Floats, miss: Floats) -> Floats:
    """The orientations, those that are missed exchanged for what is reached there."""
    from assistant.robots.arms import five_axis

    off, made = miss > EQUAL_ORIENTATION, quaternions.copy()
    ab = five_axis.to_ab(positions[off], quaternions[off])
    made[off] = five_axis.from_ab(positions[off], ab)
    return made

"""What measured poses miss of what an arm, its base and its tool say, and how that changes.

A measured point is base · flange(joints) · tool. Corrections are, in this order: of the base x, y,
z (mm along its own axes) and turns about them (degrees); of the tool the same along its own axes;
of the arm those of its model.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.learning.calibration.measured import MeasuredPoses
from assistant.learning.calibration.models import ArmModel, Parameter, rotation_vectors
from assistant.program.geometry import IDENTITY, Pose, Quaternion, Vector

SHIFT_NAMES: Final = ("x", "y", "z")
TURN_NAMES: Final = ("rx", "ry", "rz")


def _placement_parameters(what: str) -> tuple[Parameter, ...]:
    shifts = (Parameter(f"{what}.{name}", "mm") for name in SHIFT_NAMES)
    return (*shifts, *(Parameter(f"{what}.{name}", "deg") for name in TURN_NAMES))


BASE_PARAMETERS: Final = _placement_parameters("base")
TOOL_PARAMETERS: Final = _placement_parameters("tool")
PLACEMENT_COUNT: Final = len(BASE_PARAMETERS) + len(TOOL_PARAMETERS)


@dataclass(frozen=True, slots=True)
class KnownPlacement:
    """base: of the arm in the measuring frame. tool, turn: of what is measured, in the flange.
    None if they are sought.
    """

    base: Pose | None = None
    tool: Vector | None = None
    turn: Quaternion | None = None


@dataclass(frozen=True, slots=True, eq=False)
class FitState:
    """base: of the arm in the measuring frame. tool: what is measured, in the flange.
    values: (k,) corrections of the arm.
    """

    base: Pose
    tool: Pose
    values: Floats

    def moved(self, step: Floats) -> FitState:
        """With corrections (12 + k,) added, turns about axes of their own."""
        base, tool = _small_motion(step[:6]), _small_motion(step[6:PLACEMENT_COUNT])
        return FitState(self.base @ base, self.tool @ tool, self.values + step[PLACEMENT_COUNT:])


@dataclass(frozen=True)
class FitProblem:
    """point_noise: mm, one sigma along each axis, or a factor of the covariances where those are
    known. turn_noise: degrees about each axis.
    """

    model: ArmModel
    measured: MeasuredPoses
    point_noise: float = 1.0
    turn_noise: float = 0.1

    @property
    def parts(self) -> int:
        """Numbers that a row gives."""
        return 3 if self.measured.turns is None else 6

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return (*BASE_PARAMETERS, *TOOL_PARAMETERS, *self.model.parameters)

    @cached_property
    def whitening(self) -> Floats:
        """(n, 3, 3) by which errors of points are multiplied, mm to sigmas but for the factor."""
        if self.measured.covariances is None:
            return np.tile(np.eye(3), (len(self.measured), 1, 1))
        return np.asarray(np.linalg.inv(np.linalg.cholesky(self.measured.covariances)))

    def of(self, which: Rows) -> FitProblem:
        return replace(self, measured=self.measured.of(which))

    def start(self, base: Pose = IDENTITY, tool: Pose = IDENTITY) -> FitState:
        return FitState(base, tool, np.zeros(len(self.model.parameters)))

    def errors(self, state: FitState) -> tuple[Floats, Floats]:
        """(n, 3) mm and (n, 3) radians in the measuring frame, said less measured; of turns 0
        where none are measured.
        """
        p, r = self.model.flange(self.measured.joints, state.values)
        base = rotations.to_matrix(np.array(state.base.quaternion))
        tip = p + r @ np.array(state.tool.position)
        off = tip @ base.T + np.array(state.base.position) - self.measured.points
        if self.measured.turns is None:
            return off, np.zeros_like(off)
        said = base @ r @ rotations.to_matrix(np.array(state.tool.quaternion))
        seen = rotations.to_matrix(self.measured.turns)
        return off, rotation_vectors(said @ seen.transpose(0, 2, 1))

    def missing(self, state: FitState) -> Floats:
        """(n, parts) in sigmas."""
        off, turned = self.errors(state)
        white: Floats = np.einsum("nij,nj->ni", self.whitening, off) / self.point_noise
        if self.measured.turns is None:
            return white
        return np.hstack([white, turned / np.radians(self.turn_noise)])

    def slope(self, state: FitState, *, arm: bool = True) -> Floats:
        """(n, parts, 12 + k): change of `missing` by each correction. arm: whether those of the arm
        are wanted; 0 if not.
        """
        if arm:
            found = self.model.slopes(self.measured.joints, state.values)
            p, r, moved, turned = found.positions, found.rotations, found.moved, found.turned
        else:
            p, r = self.model.flange(self.measured.joints, state.values)
            moved = turned = np.zeros((len(p), 3, len(state.values)))
        base = rotations.to_matrix(np.array(state.base.quaternion))
        tool = rotations.to_matrix(np.array(state.tool.quaternion))
        lever = r @ np.array(state.tool.position)
        n, degree = len(p), np.radians(1.0)
        by = np.zeros((n, 6, PLACEMENT_COUNT + moved.shape[2]))
        by[:, :3, 0:3] = base
        by[:, :3, 3:6] = -base @ _cross_matrices(p + lever) * degree
        by[:, 3:, 3:6] = base * degree
        by[:, :3, 6:9] = base @ r @ tool
        by[:, 3:, 9:12] = base @ r @ tool * degree
        by[:, :3, PLACEMENT_COUNT:] = base @ (moved - _cross_matrices(lever) @ turned)
        by[:, 3:, PLACEMENT_COUNT:] = base @ turned
        by[:, :3] = self.whitening @ by[:, :3] / self.point_noise
        by[:, 3:] /= np.radians(self.turn_noise)
        return by[:, : self.parts]

    def wanted(self, known: KnownPlacement, *, arm: bool = True) -> Truths:
        """(12 + k,) which corrections are looked for. arm: whether those of the arm are."""
        out = np.full(len(self.parameters), arm)
        out[: len(BASE_PARAMETERS)] = known.base is None
        out[len(BASE_PARAMETERS) : len(BASE_PARAMETERS) + 3] = known.tool is None
        out[len(BASE_PARAMETERS) + 3 : PLACEMENT_COUNT] = (
            known.turn is None and self.measured.turns is not None
        )
        return out


def _small_motion(step: Floats) -> Pose:
    turn = step[3:]
    angle = float(np.linalg.norm(turn))
    axis = turn / angle if angle > 0.0 else np.array([0.0, 0.0, 1.0])
    return Pose.of(step[:3], rotations.canonical(rotations.about(axis, angle)))


def _cross_matrices(vectors: Floats) -> Floats:
    """(n, 3, 3) matrices by which a cross product with vectors (n, 3) is taken."""
    x, y, z = vectors.T
    none = np.zeros_like(x)
    rows = [[none, -z, y], [z, none, -x], [-y, x, none]]
    return np.moveaxis(np.array(rows), 2, 0)

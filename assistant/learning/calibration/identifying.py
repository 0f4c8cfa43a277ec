"""Which corrections the measured poses tell apart, and with what else the others are one.

Columns of the Jacobian are taken in an order of preference, base and tool first, by QR; one that
the earlier ones already explain is held, and the coefficients by which they do tell of what only
the sum is seen. Everett and Hsu, The theory of kinematic parameter identification for industrial
robots, 1988; the scaling of columns: Schröer et al., Complete, minimal and model-continuous
kinematic models for robot calibration, 1997.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Truths
from assistant.learning.calibration.models import Parameter
from assistant.learning.calibration.problem import PLACEMENT_COUNT

DEPENDENT_SHARE: Final = 1e-5
"""Of a column, what is left of it beside the others, below which it is a sum of them."""
MOST_SIGMA: Final = {"mm": 2.0, "deg": 1.0}
"""Standard deviation from which on a correction is held: errors of assembly are smaller."""
MOST_PARTS: Final = 6
"""Parts of a sum that are said."""
LEAST_PART: Final = 0.02
"""Share of a sum, by its effect on the points, from which on it is told."""


@dataclass(frozen=True, slots=True)
class HeldParameter:
    """A correction that is not told. parts: with what it is one: names with how much of each, mm
    or degrees, one mm or degree of it looks like. sigma: None for exactly one, or how uncertain it
    would be by itself.
    """

    parameter: Parameter
    parts: tuple[tuple[str, float, str], ...]
    sigma: float | None = None

    @property
    def reason(self) -> str:
        if self.sigma is not None:
            unit = self.parameter.unit
            return f"these poses would tell it to {self.sigma:.2g} {unit} only"
        if not self.parts:
            return "it changes nothing that is measured"
        few = self.parts[:MOST_PARTS]
        said = " and ".join(f"{much:.3g} {unit} of {name}" for name, much, unit in few)
        more = len(self.parts) - len(few)
        rest = f" and a little of {more} more" if more else ""
        return f"1 {self.parameter.unit} of it looks like {said}{rest}"


def identify_parameters(
    slope: Floats, parameters: Sequence[Parameter], wanted: Truths, *, loose: bool
) -> tuple[Truths, tuple[HeldParameter, ...]]:
    """Which (k,) corrections are free, and those of the wanted ones that are held.

    slope: (m, k) in sigmas a mm or degree. loose: whether those are held as well that are told
    worse than any error of assembly; of base and tool all are free that can be.
    """
    free, held = np.zeros(len(parameters), dtype=bool), []
    basis: list[Floats] = []
    for i in map(int, np.flatnonzero(wanted)):
        column = slope[:, i]
        size = float(np.linalg.norm(column))
        rest = column.copy()
        for _ in range(2):  # once more, as what is left of a long column is rounding
            for one in basis:
                rest -= (rest @ one) * one
        left = float(np.linalg.norm(rest))
        parameter = parameters[i]
        if left <= DEPENDENT_SHARE * size or size == 0.0:
            held.append(HeldParameter(parameter, _parts_of_sum(slope, parameters, free, i)))
            continue
        sigma = 1.0 / left
        if loose and i >= PLACEMENT_COUNT and sigma > MOST_SIGMA[parameter.unit]:
            held.append(HeldParameter(parameter, (), sigma))
            continue
        basis.append(rest / left)
        free[i] = True
    return free, tuple(held)


def condition_number(slope: Floats) -> float:
    """Of the Jacobian (m, k) with columns of one length: 1 where nothing is mixed."""
    if not slope.shape[1]:
        return 1.0
    return float(np.linalg.cond(slope / np.linalg.norm(slope, axis=0)))


def _parts_of_sum(
    slope: Floats, parameters: Sequence[Parameter], free: Truths, at: int
) -> tuple[tuple[str, float, str], ...]:
    columns = np.flatnonzero(free)
    if not len(columns):
        return ()
    much = np.linalg.lstsq(slope[:, columns], slope[:, at], rcond=None)[0]
    effect = np.abs(much) * np.linalg.norm(slope[:, columns], axis=0)
    order = [i for i in np.argsort(-effect) if effect[i] > LEAST_PART * effect.max() > 0.0]
    return tuple(
        (parameters[columns[i]].name, float(much[i]), parameters[columns[i]].unit) for i in order
    )

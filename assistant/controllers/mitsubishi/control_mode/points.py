"""Joint positions that are fit to be sent: inside of the limits, and not too far apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats, reals
from assistant.base.diagnostics import Refused
from assistant.controllers.mitsubishi.data_link import rules
from assistant.controllers.mitsubishi.data_link.records import AXES, DECIMALS


def joint_limits(limits: ArrayLike) -> Floats:
    """(k, 2) lowest and highest degrees of each axis; raises Refused if they are none."""
    rows = _number_rows(limits, "the limits")
    if rows.ndim != 2 or rows.shape[1:] != (2,) or not 0 < len(rows) <= AXES:
        raise _bad_points(
            f"the limits have the shape {rows.shape}", "give (low, high) in degrees for each axis"
        )
    if not (rows[:, 0] < rows[:, 1]).all():
        raise _bad_points("a limit is no range", "give (low, high) in degrees for each axis")
    return rows


def checked_points(joints: ArrayLike, limits: Floats, most_step: float | None) -> Floats:
    """(n, k) degrees as they will arrive, NaN for an axis that the arm lacks.

    limits: (k, 2). most_step: degrees that an axis may turn from one point to the next.
    Raises Refused before anything is sent.
    """
    points = _number_rows(joints, "the points")
    if points.ndim != 2 or len(points) == 0 or points.shape[1] != len(limits):
        reason = f"it has the shape {points.shape}, the arm {len(limits)} axes"
        raise _bad_points(reason, "give a row for each point, with an angle for each axis")
    lacking = np.isnan(points)
    if np.isinf(points).any() or (lacking != lacking[0]).any() or lacking.all():
        raise _bad_points(
            "an angle is no number", "leave an axis out (NaN) of all points or of none"
        )
    points = points.round(DECIMALS)
    outside = (points < limits[:, 0]) | (points > limits[:, 1])
    if outside.any():
        row, axis = np.argwhere(outside)[0]
        low, high = limits[axis]
        raise Refused(
            rules.OUT_OF_LIMITS(
                place=f"point {row + 1}",
                number=row + 1,
                axis=axis + 1,
                value=points[row, axis],
                low=low,
                high=high,
            )
        )
    if most_step is not None and len(points) > 1:
        check_steps(points, most_step)
    return points


def check_steps(points: Floats, most: float, first: int = 2) -> None:
    """Raises Refused for a step that is too far. first: number of the point behind the first."""
    steps = np.nan_to_num(np.abs(np.diff(points, axis=0)))
    if (far := steps > most).any():
        row, axis = np.argwhere(far)[0]
        raise Refused(
            rules.TOO_FAR(
                place=f"point {row + first}",
                number=row + first,
                axis=axis + 1,
                step=steps[row, axis],
                most=most,
            )
        )


def _number_rows(given: ArrayLike, what: str) -> Floats:
    try:
        return reals(given)
    except ValueError as error:
        raise _bad_points(
            f"{what} are no table of numbers: {error}", "give rows of numbers"
        ) from None


def _bad_points(reason: str, cure: str) -> Refused:
    return Refused(rules.BAD_POINTS(reason=reason, cure=cure), exit_status=2)

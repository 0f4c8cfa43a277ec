"""Poses from outside: finite, of believable size, with unit quaternions or rigid matrices."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, norms
from assistant.base.diagnostics import Diagnostic, error, warning

NOT_FINITE = error("TB201", "{what} {value} is not finite{more}", "mend or remove the row")
TOO_LARGE = error(
    "TB202",
    "{what} {value:g} is larger than {most:g}{more}",
    "check the unit and the decimal point",
)
NOT_UNIT = error(
    "TB203",
    "the quaternion is {length:.6g} long, not 1{more}",
    "check the order of its parts (w x y z) and give at least four decimals",
)
NORMALISED = warning(
    "TB204",
    "not quite 1 long and made so: {count} quaternions, the worst {length:.6g}",
    "give more decimals",
)
NOT_RIGID = error(
    "TB205",
    "the matrix is no rotation: it is off by {miss:.3g}{more}",
    "check that it is no reflection, has no scale, and that columns are the axes",
)
ORTHONORMALISED = warning(
    "TB206",
    "not quite orthonormal and made so: {count} matrices, the worst by {miss:.3g}",
    "give more decimals",
)
LAST_ROW = error(
    "TB207",
    "the last row of the matrix is {row}, not 0 0 0 1{more}",
    "give homogeneous matrices with the position in the last column",
)
LIKELY_METRES = warning(
    "TB208",
    "all {count} positions lie within {most:g} mm of the frame; are they metres?",
    'give millimetres, or say `unit = "m"` in the file or its process file; columns of metres are '
    "called `x_m`, `y_m` and `z_m`",
)

LARGEST_POSITION: Final = 1e6
"""mm; no robot, track or gantry is a kilometre long."""
LARGEST_ANGLE: Final = 1e5
"""degrees."""
SILENT_DEVIATION: Final = 1e-6
"""Deviation from unit length that is taken for rounding in the last decimal."""
REPAIRABLE_DEVIATION: Final = 1e-3
"""Deviation from unit length up to which it is repaired with a warning."""
LIKE_METRES: Final = 3.0
"""mm; a path that stays this near to the origin of its frame is likely in metres."""

LocateRow = Callable[[int], Mapping[str, Any]]
"""Row → where it is, as arguments of a rule (path, line, place …)."""


def position_findings(
    values: Floats,
    locate: LocateRow,
    what: str = "the coordinate",
    *,
    most: float = LARGEST_POSITION,
) -> list[Diagnostic]:
    """What is wrong with the numbers (n, k) of n rows: not finite, or beyond `most`."""
    if values.size:
        low, high = values.min(), values.max()  # no number if one of them is none
        if np.isfinite(low) and np.isfinite(high) and -most <= low and high <= most:
            return []
    findings = []
    finite = np.isfinite(values)
    if not finite.all():
        rows = np.flatnonzero(~finite.all(axis=1))
        value = values[rows[0]][~finite[rows[0]]][0]
        findings.append(
            NOT_FINITE(**locate(int(rows[0])), what=what, value=float(value), more=_rows_more(rows))
        )
    large = np.abs(np.where(finite, values, 0.0)) > most
    if large.any():
        rows = np.flatnonzero(large.any(axis=1))
        value = values[rows[0]][large[rows[0]]][0]
        findings.append(
            TOO_LARGE(
                **locate(int(rows[0])),
                what=what,
                value=float(value),
                most=most,
                more=_rows_more(rows),
            )
        )
    return findings


def unit_quaternions(quaternions: Floats, locate: LocateRow) -> tuple[Floats, list[Diagnostic]]:
    """Canonical quaternions (n, 4), and what was wrong with the given ones.

    Up to `REPAIRED` off unit length they are repaired, beyond refused; not finite ones too.
    """
    findings = position_findings(quaternions, locate, "the quaternion part", most=np.inf)
    if findings:
        return quaternions, findings
    with np.errstate(over="ignore"):
        lengths = norms(quaternions)
    miss = np.abs(lengths - 1.0)
    bad = np.flatnonzero(~(miss <= REPAIRABLE_DEVIATION))
    if len(bad):
        row = int(bad[0])
        return quaternions, [NOT_UNIT(**locate(row), length=lengths[row], more=_rows_more(bad))]
    if len(off := np.flatnonzero(miss > SILENT_DEVIATION)):
        worst = int(np.argmax(miss))
        findings.append(NORMALISED(**locate(worst), count=len(off), length=lengths[worst]))
    return rotations.canonical(quaternions), findings


def poses_of_matrices(
    matrices: Floats, locate: LocateRow
) -> tuple[Floats, Floats, list[Diagnostic]]:
    """Positions (n, 3) and canonical quaternions (n, 4) of homogeneous matrices (n, 4, 4)."""
    positions = np.ascontiguousarray(matrices[:, :3, 3])
    findings = position_findings(
        matrices.reshape(len(matrices), 16), locate, "the matrix element", most=np.inf
    )
    if findings:
        return positions, np.empty((0, 4)), findings
    last = np.flatnonzero((np.abs(matrices[:, 3] - [0, 0, 0, 1]) > 1e-9).any(axis=1))
    if len(last):
        row = " ".join(f"{v:g}" for v in matrices[last[0], 3])
        findings.append(LAST_ROW(**locate(int(last[0])), row=row, more=_rows_more(last)))
    turn = matrices[:, :3, :3]
    with np.errstate(over="ignore", invalid="ignore"):
        product = np.einsum("nij,nik->njk", turn, turn)
        miss = np.abs(product - np.eye(3)).max(axis=(1, 2))
        miss = np.where(np.linalg.det(turn) < 0, np.maximum(miss, 2.0), miss)
    bad = np.flatnonzero(~(miss <= REPAIRABLE_DEVIATION))
    if len(bad):
        first = int(bad[0])
        findings.append(NOT_RIGID(**locate(first), miss=miss[first], more=_rows_more(bad)))
    if findings:
        return positions, np.empty((0, 4)), findings
    if len(off := np.flatnonzero(miss > SILENT_DEVIATION)):
        worst = int(np.argmax(miss))
        findings.append(ORTHONORMALISED(**locate(worst), count=len(off), miss=miss[worst]))
    return positions, rotations.from_matrix(turn), findings


def metres_finding(positions: Floats, place: Mapping[str, Any]) -> list[Diagnostic]:
    """A warning if positions look like metres."""
    apart = len(positions) > 1 and np.ptp(positions, axis=0).max() > 0.0
    if apart and 0 < np.abs(positions).max() <= LIKE_METRES:
        return [LIKELY_METRES(**place, count=len(positions), most=LIKE_METRES)]
    return []


def _rows_more(rows: Rows) -> str:
    return f" ({len(rows)} such rows)" if len(rows) > 1 else ""

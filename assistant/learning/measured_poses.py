"""Measured poses: joints of an arm, and the measured point of its tool at each.

    j1_deg, j2_deg, …, x_mm, y_mm, z_mm [, q_w, q_x, q_y, q_z]      of a tracker
    j1_deg, j2_deg, …, left_u_px, left_v_px, right_u_px, right_v_px  of two cameras

Each name states its unit: `_deg` or `_rad` of joints that turn, `_mm`, `_cm`, `_m` or `_in` of
lengths. Columns that begin with `_`, and `name`, are left out.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path as FilePath
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, all_of, reals, rows_of
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Unreadable
from assistant.base.source_text import decode, lines_of, read_bytes
from assistant.learning import rules
from assistant.robots import Robot
from assistant.vision.cameras.camera import WORLD, Camera, triangulate

_LENGTH_UNITS: Final = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
"""Units in mm."""
_ANGLE_UNITS: Final = {"deg": 1.0, "rad": 180.0 / math.pi}
"""Units in degrees."""
_QUATERNION_COLUMNS: Final = ("q_w", "q_x", "q_y", "q_z")
_PIXEL_COLUMN: Final = re.compile(r"(?P<camera>.+)_(?P<side>[uv])_px")
_QUATERNION_TOLERANCE: Final = 0.02
"""By which the length of a quaternion may be off 1; files print few decimals."""
_MOST_PIXEL_RESIDUAL: Final = 3.0
"""Pixels, root mean square, up to which two cameras have seen the same point."""


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredPoses:
    """joints: (n, a) degrees or mm, as the robot counts them. points: (n, 3) mm of the tool point
    in the measuring frame. turns: (n, 4) unit quaternions of what is measured with it, or None.
    covariances: (n, 3, 3) mm² of the points as far as they are known, or None: all alike.
    rows: (n,) of the file, from 1 below its header. findings: of rows that are left out.
    """

    joints: Floats
    points: Floats
    turns: Floats | None
    rows: Rows
    covariances: Floats | None = None
    path: str | None = None
    findings: tuple[Diagnostic, ...] = ()

    def __len__(self) -> int:
        return len(self.joints)

    def of(self, which: Rows) -> MeasuredPoses:
        """Some of the rows."""
        return MeasuredPoses(
            self.joints[which],
            self.points[which],
            None if self.turns is None else self.turns[which],
            self.rows[which],
            None if self.covariances is None else self.covariances[which],
            self.path,
            self.findings,
        )


def read_measured(
    path: str | FilePath, robot: Robot, cameras: Mapping[str, Camera] | None = None
) -> MeasuredPoses:
    """The measured poses of a CSV file, with `,`, `;` or a tab between its columns.

    cameras: by their names, calibrated in the measuring frame, for columns of pixels. Raises
    Unreadable for what is no such table, and Refused for numbers that cannot be.
    """
    name = str(path)
    text = decode(read_bytes(path), name, ("utf-8-sig", "utf-8")).text
    header, lines = _split_cells(text, name)
    table = _PoseTable(header, lines, name)
    joints = table.joints(robot)
    cameras_seen = table.cameras()
    if cameras_seen:
        points, covariances, wrong = _triangulated(table, cameras_seen, cameras)
    else:
        points, covariances, wrong = table.positions(), None, {}
    turns = table.quaternions()
    whole: Truths = all_of(np.isfinite(joints)) & all_of(np.isfinite(points))
    if turns is not None:
        whole &= all_of(np.isfinite(turns))
    rows = np.arange(1, len(joints) + 1)
    findings = _left_out_findings(rows, whole, wrong, name)
    every = MeasuredPoses(joints, points, turns, rows, covariances, name, findings)
    return every.of(np.flatnonzero(whole))


def measured_from_columns(
    joints: Floats,
    points: Floats,
    quaternions: Floats | None = None,
    covariances: Floats | None = None,
) -> MeasuredPoses:
    """The same from columns: joints (n, a), points (n, 3) mm, quaternions (n, 4).

    Rows that are not finite are left out. Raises ValueError for columns of different lengths.
    """
    j, p = np.atleast_2d(reals(joints)), rows_of(points, 3, "points")
    q = None if quaternions is None else rows_of(quaternions, 4, "quaternions")
    if len({len(j), len(p), len(j) if q is None else len(q)}) != 1:
        raise ValueError("joints, points and quaternions are wanted for each pose")
    whole: Truths = all_of(np.isfinite(j)) & all_of(np.isfinite(p))
    if q is not None:
        whole &= all_of(np.isfinite(q))
        q = rotations.canonical(np.where(whole[:, None], q, (1.0, 0.0, 0.0, 0.0)))
    rows = np.arange(1, len(j) + 1)
    every = MeasuredPoses(
        j, p, q, rows, covariances, None, _left_out_findings(rows, whole, {}, None)
    )
    return every.of(np.flatnonzero(whole))


def _left_out_findings(
    rows: Rows, whole: Truths, wrong: Mapping[str, Truths], path: str | None
) -> tuple[Diagnostic, ...]:
    """Return one finding for each reason for which rows are left out."""
    known = np.zeros(len(rows), dtype=bool)
    for which in wrong.values():
        known |= which
    reasons = {**wrong, "a number is missing": ~whole & ~known}
    return tuple(
        rules.ROW_LEFT_OUT(path=path, rows=_row_numbers(rows[which]), reason=reason)
        for reason, which in reasons.items()
        if which.any()
    )


def _row_numbers(rows: Rows, most: int = 8) -> str:
    """Numbers of rows in words."""
    told = ", ".join(str(int(row)) for row in rows[:most])
    return told if len(rows) <= most else f"{told} and {len(rows) - most} more"


def _triangulated(
    table: _PoseTable, names: Sequence[str], cameras: Mapping[str, Camera] | None
) -> tuple[Floats, Floats, dict[str, Truths]]:
    """Points, covariances and why some rows have none."""
    if cameras is None:
        reason = "no cameras are named"
        raise Refused(rules.NO_MEASURING_CAMERAS(path=table.path, reason=reason), exit_status=2)
    missing = [name for name in names if name not in cameras]
    if missing:
        reason = f"there is no camera `{missing[0]}` among {', '.join(cameras) or 'none'}"
        raise Refused(rules.NO_MEASURING_CAMERAS(path=table.path, reason=reason), exit_status=2)
    if len(names) < 2:
        reason = f"a point needs two cameras, of which only `{names[0]}` has columns"
        raise Refused(rules.NO_MEASURING_CAMERAS(path=table.path, reason=reason), exit_status=2)
    carried = next((name for name in names if cameras[name].parent != WORLD), None)
    if carried is not None:
        reason = f"`{carried}` does not stand still: its parent is `{cameras[carried].parent}`"
        raise Refused(rules.NO_MEASURING_CAMERAS(path=table.path, reason=reason), exit_status=2)
    pixels = [table.pixels(name) for name in names]
    found = triangulate([cameras[name] for name in names], pixels)
    points = found.points.copy()
    blind: Truths = ~all_of(np.isfinite(points))
    apart: Truths = ~blind & (found.residuals > _MOST_PIXEL_RESIDUAL)
    points[apart] = np.nan
    wrong = {
        "less than two cameras see the point": blind,
        f"the cameras disagree by more than {_MOST_PIXEL_RESIDUAL:g} pixels": apart,
    }
    return points, found.covariances, wrong


def _split_cells(text: str, path: str) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """The names of the header, and each row that is not empty with its line."""
    first = next((line for line in lines_of(text) if line.strip()), "")
    mark = max(",;\t", key=first.count)
    try:
        reader = csv.reader(io.StringIO(text), delimiter=mark)
        rows = [(reader.line_num, [c.strip() for c in row]) for row in reader]
    except csv.Error as wrong:
        raise Unreadable(_bad_header(path, f"cannot be read: {wrong}")) from None
    rows = [(line, row) for line, row in rows if any(row)]
    if not rows:
        raise Unreadable(_bad_header(path, "is missing"))
    header = [name.lower() for name in rows[0][1]]
    double = next((name for name in header if name and header.count(name) > 1), None)
    if double is not None:
        raise Unreadable(_bad_header(path, f"names `{double}` twice"))
    return header, rows[1:]


def _bad_header(path: str, reason: str, columns: str = "j1_deg …, x_mm, y_mm, z_mm") -> Diagnostic:
    return rules.BAD_HEADER(path=path, line=1, reason=reason, columns=columns)


class _PoseTable:
    """Columns of a table by their names; a value that is not a number is reported with its line."""

    def __init__(self, header: list[str], lines: list[tuple[int, list[str]]], path: str) -> None:
        self.header, self.lines, self.path = header, lines, path

    def joints(self, robot: Robot) -> Floats:
        """(n, a) in the units of the robot."""
        columns, wanted = [], []
        for axis, slides in zip(robot.axes, robot.sliding, strict=True):
            units = _LENGTH_UNITS if slides else _ANGLE_UNITS
            wanted.append(f"{axis.lower()}_{'mm' if slides else 'deg'}")
            columns.append(self.found(axis.lower(), units))
        missing = [name for name, at in zip(wanted, columns, strict=True) if at is None]
        if missing:
            raise Unreadable(self.wrong(f"has no column `{missing[0]}`", wanted))
        others = [n for n in self.header if re.fullmatch(r"j\d+_(deg|rad|mm|cm|m|in)", n)]
        if len(others) > len(columns):
            most = f"has {len(others)} joints, but {robot.title} has {len(columns)} axes"
            raise Unreadable(self.wrong(most, wanted))
        return np.column_stack([self.column(*at) for at in columns if at is not None])

    def positions(self) -> Floats:
        columns = [self.found(axis, _LENGTH_UNITS) for axis in "xyz"]
        lost = [f"{axis}_mm" for axis, at in zip("xyz", columns, strict=True) if at is None]
        if lost:
            raise Unreadable(self.wrong(f"has no column `{lost[0]}`", ["j1_deg", "…"]))
        return np.column_stack([self.column(*at) for at in columns if at is not None])

    def quaternions(self) -> Floats | None:
        """(n, 4) unit quaternions, None without their columns."""
        there = [name for name in _QUATERNION_COLUMNS if name in self.header]
        if not there:
            return None
        if len(there) < len(_QUATERNION_COLUMNS):
            lost = next(name for name in _QUATERNION_COLUMNS if name not in there)
            raise Unreadable(self.wrong(f"has `{there[0]}` but no `{lost}`", ["j1_deg", "…"]))
        q = np.column_stack([self.column(name, 1.0) for name in _QUATERNION_COLUMNS])
        lengths = np.linalg.norm(q, axis=1)
        off = np.abs(lengths - 1.0) > _QUATERNION_TOLERANCE
        if off.any():
            row = int(np.argmax(off))
            value = f"a quaternion of length {lengths[row]:.3g}"
            line = self.lines[row][0]
            raise Refused(rules.NOT_A_NUMBER(path=self.path, line=line, name="q_w", value=value))
        # A row that is not whole is left out later; it needs some length until then.
        safe = np.where(np.isfinite(lengths)[:, None], q, (1.0, 0.0, 0.0, 0.0))
        out = rotations.canonical(safe)
        out[~np.isfinite(lengths)] = np.nan
        return np.asarray(out)

    def cameras(self) -> list[str]:
        """The cameras that have columns, in their order."""
        found: dict[str, set[str]] = {}
        for name in self.header:
            if match := _PIXEL_COLUMN.fullmatch(name):
                found.setdefault(match["camera"], set()).add(match["side"])
        half = next((camera for camera, sides in found.items() if len(sides) < 2), None)
        if half is not None:
            raise Unreadable(
                self.wrong(f"has only one of `{half}_u_px` and `{half}_v_px`", ["j1_deg"])
            )
        return list(found)

    def pixels(self, camera: str) -> Floats:
        return np.column_stack([self.column(f"{camera}_{side}_px", 1.0) for side in "uv"])

    def found(self, stem: str, units: Mapping[str, float]) -> tuple[str, float] | None:
        """The column of that name in one of the units, with what its numbers are multiplied by."""
        there = [
            (f"{stem}_{unit}", f) for unit, f in units.items() if f"{stem}_{unit}" in self.header
        ]
        if len(there) > 1:
            raise Unreadable(self.wrong(f"has `{there[0][0]}` and `{there[1][0]}`", [there[0][0]]))
        return there[0] if there else None

    def column(self, name: str, factor: float) -> Floats:
        """(n,) numbers; NaN for an empty cell, or one that says so."""
        at = self.header.index(name)
        out = np.full(len(self.lines), np.nan)
        for row, (line, cells) in enumerate(self.lines):
            text = cells[at] if at < len(cells) else ""
            if text.lower() in ("", "nan", "-nan"):
                continue
            try:
                out[row] = float(text) * factor
            except ValueError:
                out[row] = math.inf
            if not math.isfinite(out[row]):
                value = f"`{text[:40]}`"
                found = rules.NOT_A_NUMBER(path=self.path, line=line, name=name, value=value)
                raise Refused(found, exit_status=2)
        return out

    def wrong(self, reason: str, columns: Sequence[str]) -> Diagnostic:
        told = ", ".join([*columns, "x_mm", "y_mm", "z_mm"])
        return _bad_header(self.path, reason, told)

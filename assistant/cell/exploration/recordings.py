"""Recordings of the joints of a moving arm, with an input that signals contacts."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats, Truths
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.source_text import read_bytes
from assistant.cell.findings import (
    BLANK_ROWS,
    NO_RECORDED_COLUMN,
    NOT_RECORDED,
    RECORDED_OUTSIDE_LIMITS,
    TIMES_NOT_ASCENDING,
)
from assistant.robots.robot import Robot
from assistant.sources.tables.delimited_text import read_cells
from assistant.sources.tables.headers import shown

_SECONDS: Final = ("seconds", "t_s", "time")
"""Columns of the time, as logs, motions over time and recordings of led arms name them."""
_SETTLING: Final = 0.5
"""Seconds before a contact that tell nothing: a signal is read later than the joints, or comes
late."""
OVER: Final = 0.5
"""Degrees (mm) that a recorded joint may be over its limits: controllers round, and overshoot."""
_AXIS_UNITS: Final = ("deg", "mm")


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """runs: (k, a) joints of rows that follow each other, all without contact; contacts: how often
    there was one; findings: of the file.
    """

    runs: tuple[Floats, ...]
    contacts: int
    findings: tuple[Diagnostic, ...] = ()


def read_recording(path: str | FilePath, robot: Robot, contact: str | None = None) -> Recorded:
    """The joints of a CSV file that `monitor --log`, `follow --log` or `simulate` has written.

    Its columns are `j1_deg` …, `_mm` of axes that slide, with or without `_` before them, or
    `joints.J1` … as `servo --log` writes them.
    contact: the column of an input that is not 0 in contact. Raises Unreadable for no text,
    Refused, with a finding, for a table that lacks joints, or holds those of another arm.
    """
    file = FilePath(path)
    columns: dict[str, int] = {}

    def check(header: tuple[str, ...], where: Mapping[str, Any]) -> None:
        columns.update(_columns(header, robot, contact, where))

    cells = read_cells(read_bytes(file), str(file), check)
    wanted = sorted(columns.values())
    values = dict(zip(wanted, cells.numbers(wanted).T, strict=True))
    axes = [values[columns[axis]] for axis in robot.axes]
    rows = np.stack(axes, axis=1)
    there = ~np.isnan(rows).any(axis=1)
    left = np.zeros(len(rows), dtype=np.bool_)
    contacts = 0
    if contact is not None:
        touching = values[columns["contact"]] != 0.0  # as is one that is not told
        times = values[columns["seconds"]]
        if np.isnan(times).any() or (np.diff(times) < 0.0).any():
            raise Refused(TIMES_NOT_ASCENDING(path=str(file)))
        left = _left(times, touching)
        contacts = int((np.diff(touching.astype(np.int8), prepend=0) == 1).sum())
    findings = list(cells.findings)
    if not there.all():
        gone = np.flatnonzero(~there)
        place = cells.place(int(gone[0]))
        findings.append(BLANK_ROWS(count=len(gone), total=len(rows), **place))
    _check_limits(rows[there], robot, str(file))
    return Recorded(tuple(_runs(rows, left | ~there)), contacts, tuple(findings))


def clear_runs(times: Floats, rows: Floats, touching: Truths) -> tuple[Floats, ...]:
    """Rows (n, a) that follow each other without contact, but for those that a late signal doubts.

    times: (n,) seconds, ascending. touching: (n,) rows in contact.
    """
    return tuple(_runs(rows, _left(times, touching)))


def _runs(rows: Floats, left: Truths) -> Iterator[Floats]:
    """Rows that follow each other, without those that are left out."""
    edges = np.flatnonzero(np.diff(np.concatenate([[True], left, [True]])))
    for first, last in edges.reshape(-1, 2).tolist():
        yield rows[first:last]


def _columns(
    header: Sequence[str], robot: Robot, contact: str | None, where: Mapping[str, Any]
) -> dict[str, int]:
    """Columns by axis, `seconds` and `contact`; raises Refused for one that is missing."""
    plain = [name.strip().lower().removeprefix("_") for name in header]
    found: dict[str, int] = {}
    for axis in robot.axes:
        form = re.compile(
            rf"{re.escape(axis.lower())}_({'|'.join(_AXIS_UNITS)})|joints\.{re.escape(axis.lower())}"
        )
        for number, name in enumerate(plain):
            if form.fullmatch(name):
                found.setdefault(axis, number)
    lacking = [f"`{axis.lower()}_deg`" for axis in robot.axes if axis not in found]
    if lacking:
        raise Refused(NOT_RECORDED(names=", ".join(lacking), robot=robot.title, **where))
    if contact is None:
        return found
    for what, names in (("contact", (contact.lower().removeprefix("_"),)), ("seconds", _SECONDS)):
        at = next((i for i, name in enumerate(plain) if name in names), None)
        if at is None:
            known = ", ".join(shown(name) for name in header)
            raise Refused(
                NO_RECORDED_COLUMN(name=f"`{names[0]}`", known=known, **where), exit_status=2
            )
        found[what] = at
    return found


def _left(times: Floats, touching: Truths) -> Truths:
    """Return the samples in contact, or so shortly before contact or the end that a signal may be
    late.
    """
    ends = np.append(times[touching], times[-1:])
    following = ends[np.searchsorted(ends, times)]
    return np.asarray(touching | (following - times < _SETTLING))


def _check_limits(rows: Floats, robot: Robot, path: str) -> None:
    low, high = robot.limits.T
    over = np.maximum(low - rows, rows - high)
    if not len(rows) or over.max() <= OVER:
        return
    row, axis = np.unravel_index(int(np.argmax(over)), over.shape)
    finding = RECORDED_OUTSIDE_LIMITS(
        path=path,
        axis=robot.axes[int(axis)],
        value=float(rows[row, axis]),
        unit=robot.units[int(axis)],
        low=float(low[axis]),
        high=float(high[axis]),
        robot=robot.title,
    )
    raise Refused(finding)

"""Columns of a table, read and checked: numbers, motions, branches, signals and waits.

All numbers are in neutral units: mm, degrees, mm/s, seconds.
"""

from __future__ import annotations

import re
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Severity, error, has_errors
from assistant.program.motion import UNSTATED, Kind
from assistant.sources.process import Process
from assistant.sources.tables import rows
from assistant.sources.tables.delimited_text import EMPTY_CELL, NOT_A_NUMBER, Cells, UnreadCells
from assistant.sources.tables.headers import MOST_JOINTS, ORIENTATIONS, Column, shown
from assistant.sources.tables.rows import (
    LARGEST_ANGLE,
    LARGEST_POSITION,
    position_findings,
    unit_quaternions,
)


def _signal_findings(
    cells: Cells, columns: list[Column], values: Floats, process: Process
) -> list[Diagnostic]:
    """Signals that are set but not declared as outputs, or to what they cannot be."""
    findings = []
    for index, column in enumerate(columns):
        if column.group != "set":
            continue
        name = output_signal(column.detail, process)
        if name is None:
            cure = rows.cure_for("signal", column.detail, process.signals)
            place = cells.header_place(index)
            findings.append(rows.UNKNOWN_SIGNAL(**place, name=shown(column.detail), cure=cure))
            continue
        signal, given = process.signals[name], values[:, index]
        most = rows.most_value(signal)
        with np.errstate(invalid="ignore"):
            wrong = ~np.isnan(given) & ((given < 0) | (given > most) | (given != np.rint(given)))
        if most < np.inf and wrong.any():
            row = int(np.argmax(wrong))
            fields: dict[str, Any] = {"kind": signal.kind, "name": shown(name), "most": most}
            place = cells.place(row, index)
            findings.append(rows.NOT_ITS_VALUE(**place, **fields, value=float(given[row])))
        if not np.isfinite(given[~np.isnan(given)]).all():
            findings += position_findings(
                np.nan_to_num(given, nan=0.0, posinf=np.inf)[:, None],
                partial(cells.place, column=index),
                shown(cells.header[index]),
            )
    return findings


def _via_findings(
    cells: Cells, columns: list[Column], values: Floats, kinds: NDArray[np.uint8]
) -> list[Diagnostic]:
    """Signals and waits in the middle of an arc."""
    findings = []
    for index, column in enumerate(columns):
        if column.group in ("set", "wait"):
            wrong = (kinds == Kind.VIA) & ~np.isnan(values[:, index])
            if wrong.any():
                place = cells.place(int(np.argmax(wrong)), index)
                findings.append(rows.VIA_ACTION(**place, what=shown(cells.header[index])))
    return findings


def output_signal(name: str, process: Process) -> str | None:
    found = next((s for s in process.signals if s.lower() == name.lower()), None)
    return found if found and process.signals[found].direction == "output" else None


ERROR: Final = Severity.ERROR
_NO_TARGET = error(
    "TB131",
    "the row has neither a pose nor joints{more}",
    "fill in the position and orientation, or every joint",
)
_BOTH_TARGETS = error(
    "TB132", "the row has a pose and joints{more}", "keep one of them in each row"
)
_NO_CONFIGURATION = error(
    "TB134",
    "the arm branch is not complete or not of this kind{more}",
    "write 0 or 1 for `back`, `down`, `flip` and whole quadrants, or leave all six cells empty",
)
_JOINTS_ONLY_JOINT = error(
    "TB135", "a row of joints cannot be reached by a {motion} move", "write `joint`"
)

_MOST_CODES: Final = 20
_FINE_CELL: Final = re.compile(rb"(?i)[,;\t\n\" ]fine\s*[,;\t\n\"]")
_TEXT_GROUPS: Final = ("name", "tool", "frame", "motion", "comment", "left out")


@dataclass(frozen=True, slots=True)
class ColumnTable:
    """A table as neutral columns.

    of_joints: (n,) rows that are joint targets. joints: (n, a), NaN for an absent joint.
    """

    cells: Cells
    columns: list[Column]
    positions: Floats
    quaternions: Floats
    of_joints: Truths
    joints: Floats
    external: Floats | None
    configurations: NDArray[np.int8] | None
    kinds: NDArray[np.uint8]
    motions: rows.RowMotions
    values: Floats
    findings: list[Diagnostic]

    @property
    def begins(self) -> bool:
        """True if the first row does not say how it is reached."""
        column = self.first("motion")
        return column is None or bool(self.cells.empty[0, column])

    @property
    def states_speed(self) -> bool:
        """True if the first row states a speed itself."""
        speeds = [i for i, c in enumerate(self.columns) if c.group in ("speed", "rotation")]
        return not bool(self.cells.empty[0, speeds].all())

    def first(self, group: str) -> int | None:
        return _first_column(self.columns, group)


def _first_column(columns: list[Column], group: str) -> int | None:
    return next((i for i, c in enumerate(columns) if c.group == group), None)


def table_of(cells: Cells, columns: list[Column], process: Process) -> ColumnTable:
    """Every column read and checked; raises Refused with all that is wrong."""
    try:
        values, findings = _number_columns(cells, columns)
    except UnreadCells as unread:
        # The other rows are checked as well, so that one run reports all.
        others = _findings_of(cells.those(~unread.rows), columns, process)
        raise Refused(*unread.findings, *others) from None
    groups = {c.group for c in columns}
    of_joints, wrong = _row_kinds(cells, columns)
    findings += wrong
    orientation = next((o for o in ORIENTATIONS if o in groups), None)
    at_pose = [i for i, c in enumerate(columns) if c.group in ("position", orientation)]
    n, poses = len(cells), ~of_joints & ~np.isnan(values[:, at_pose]).any(axis=1)
    positions, quaternions = np.zeros((n, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    if orientation:
        at = np.flatnonzero(poses)
        given = _group_columns(columns, values, "position", 3)[at]
        findings += position_findings(given, _locate(cells, columns, "position", at))
        positions[at] = given
        turned, wrong = _orientation(cells, columns, values, orientation, at)
        findings += wrong
        if not has_errors(wrong):
            quaternions[at] = turned
    joints = _group_columns(
        columns,
        values,
        "joints",
        1 + max((c.part for c in columns if c.group == "joints"), default=-1),
    )
    external = _group_columns(columns, values, "external", 6) if "external" in groups else None
    for group, what in (("joints", "the joint"), ("external", "the external axis")):
        if _first_column(columns, group) is not None:
            known = _group_columns(columns, values, group, MOST_JOINTS)
            # Empty cells are no fault here.
            known[np.isnan(known)] = 0.0
            findings += position_findings(known, _locate(cells, columns, group), what)
    kinds, wrong = _move_kinds(cells, columns, of_joints, process)
    findings += wrong
    configurations, wrong = _configurations(cells, columns, values)
    findings += wrong
    motions, wrong = _row_motions(cells, columns, values, process)
    findings += wrong
    findings += _signal_findings(cells, columns, values, process)
    findings += _via_findings(cells, columns, values, kinds)
    if has_errors(findings):
        raise Refused(*findings)
    return ColumnTable(
        cells, columns, positions, quaternions, of_joints, joints, external,
        configurations, kinds, motions, values, findings,
    )  # fmt: skip


def _findings_of(cells: Cells, columns: list[Column], process: Process) -> list[Diagnostic]:
    """Return the faults of some rows, but for those of arcs, which may lack a row."""
    if not len(cells):
        return []
    try:
        return table_of(cells, columns, process).findings
    except Refused as refused:
        return [one for one in refused.findings if one.code != rows.BROKEN_ARC.code]


def _number_columns(cells: Cells, columns: list[Column]) -> tuple[Floats, list[Diagnostic]]:
    """All numbers (n, k) in mm, degrees and mm/s; NaN for empty cells and columns of text."""
    wanted = [i for i, c in enumerate(columns) if c.group not in _TEXT_GROUPS]
    if (
        cells.plain is not None
        and len(wanted) == len(columns)
        and all(column.factor == 1.0 for column in columns)
    ):
        return cells.plain, []
    values = np.full(cells.shape, np.nan)
    blend = _first_column(columns, "blend")
    findings: list[Diagnostic] = []
    # Only a blend column with the word `fine` is read as text.
    if blend is not None and _FINE_CELL.search(cells.data):
        wanted.remove(blend)
        values[:, blend], findings = _blend_words(cells, blend)
    if wanted:
        factors = np.array([columns[i].factor for i in wanted])
        with np.errstate(over="ignore"):  # what overflows is refused as not finite
            values[:, wanted] = cells.numbers(wanted) * factors
    return values, findings


def _blend_words(cells: Cells, column: int) -> tuple[Floats, list[Diagnostic]]:
    """Blends of which some are the word `fine`."""
    index, table = cells.codes(column)
    radii, findings = [], []
    for code, text in enumerate(table):
        word = text.strip().lower()
        if word in ("", "fine"):
            radii.append(0.0 if word else np.nan)
        elif re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", word):
            radii.append(float(word))
        else:
            radii.append(np.nan)
            wrong = index == code
            place = cells.place(int(np.argmax(wrong)), column)
            more = rows.more_rows(wrong, cells.place)
            findings.append(NOT_A_NUMBER(**place, cell=shown(text), more=more))
    return np.array(radii)[index], findings


def _group_columns(columns: list[Column], values: Floats, group: str, size: int) -> Floats:
    """The columns of a group (n, size) in the order of their parts, NaN for missing ones."""
    gathered = np.full((len(values), max(size, 0)), np.nan)
    for index, column in enumerate(columns):
        if column.group == group:
            gathered[:, column.part] = values[:, index]
    return gathered


def _locate(
    cells: Cells, columns: list[Column], group: str, at: Rows | None = None
) -> rows.RowPlace:
    """Return a function for the source location of a row, or of its row in `at`, in the first
    column of a group.
    """
    column = _first_column(columns, group)
    return lambda row: cells.place(int(at[row]) if at is not None else row, column)


def _row_kinds(cells: Cells, columns: list[Column]) -> tuple[Truths, list[Diagnostic]]:
    """Which rows (n,) are joint targets; a row is one or a pose, and it is complete."""
    poses = [i for i, c in enumerate(columns) if c.group in ("position", *ORIENTATIONS)]
    joints = [i for i, c in enumerate(columns) if c.group == "joints"]
    filled = ~cells.empty
    some_pose = np.asarray(filled[:, poses].any(axis=1))
    some_joint = np.asarray(filled[:, joints].any(axis=1))
    findings = []
    for group, some in ((poses, some_pose), (joints, some_joint)):
        holes = some[:, None] & ~filled[:, group] if group else np.zeros((len(cells), 0), bool)
        if holes.any():
            rows_with = np.asarray(holes.any(axis=1))
            row = int(np.argmax(rows_with))
            column = group[int(np.argmax(holes[row]))]
            findings.append(
                EMPTY_CELL(**cells.place(row, column), more=rows.more_rows(rows_with, cells.place))
            )
    for rule, wrong in (
        (_NO_TARGET, ~some_pose & ~some_joint),
        (_BOTH_TARGETS, some_pose & some_joint),
    ):
        if wrong.any():
            findings.append(
                rule(**cells.place(int(np.argmax(wrong))), more=rows.more_rows(wrong, cells.place))
            )
    return some_joint, findings


def _orientation(
    cells: Cells,
    columns: list[Column],
    values: Floats,
    group: str,
    at: Rows,
) -> tuple[Floats, list[Diagnostic]]:
    """Canonical quaternions of the rows `at`, however the table states them."""
    locate = _locate(cells, columns, group, at)
    if group == "quaternion":
        return unit_quaternions(_group_columns(columns, values, group, 4)[at], locate)
    angles = _group_columns(columns, values, group, 3)[at]
    findings = position_findings(angles, locate, "the angle", most=LARGEST_ANGLE)
    if findings:
        return angles, findings
    if group == "rotvec":
        angle = np.linalg.norm(angles, axis=1)
        axis = angles / np.where(angle > 0, angle, 1.0)[:, None]
        return rotations.canonical(rotations.about(axis, angle)), []
    order: Any = group.removeprefix("euler_").upper()
    return rotations.from_euler(angles, order), []


def _move_kinds(
    cells: Cells, columns: list[Column], of_joints: Truths, process: Process
) -> tuple[NDArray[np.uint8], list[Diagnostic]]:
    """A `Kind` for each row (n,); without a motion column the default for every row."""
    default = rows.default_kind(process)
    column = _first_column(columns, "motion")
    if column is None:
        kinds = np.where(of_joints, Kind.JOINT, default).astype(np.uint8)
        return rows.beginning_kinds(kinds), []
    index, table = cells.codes(column)
    words = {"": default, **rows.KIND_WORDS}
    kinds = np.array([words.get(t.strip().lower(), default) for t in table], np.uint8)[index]
    findings = [
        rows.UNKNOWN_KIND(
            **cells.place(int(np.argmax(index == code)), column),
            name=shown(text),
            more=rows.more_rows(index == code, cells.place),
        )
        for code, text in enumerate(table[:_MOST_CODES])
        if text.strip().lower() not in words
    ]
    stated = ~cells.empty[:, column]
    wrong = of_joints & stated & (kinds != Kind.JOINT)
    if wrong.any() and not findings:
        row = int(np.argmax(wrong))
        motion = Kind(int(kinds[row])).name.lower()
        findings.append(_JOINTS_ONLY_JOINT(**cells.place(row, column), motion=motion))
    kinds = np.where(of_joints, np.uint8(Kind.JOINT), kinds)
    findings += rows.arc_findings(kinds, lambda row: cells.place(row, column))
    return kinds if stated[:1].any() else rows.beginning_kinds(kinds), findings


def _configurations(
    cells: Cells, columns: list[Column], values: Floats
) -> tuple[NDArray[np.int8] | None, list[Diagnostic]]:
    """Configuration columns (n, 6) as in a `Path`, None if the table has none."""
    column = _first_column(columns, "configuration")
    if column is None:
        return None, []
    given = _group_columns(columns, values, "configuration", 6)
    absent = np.isnan(given)
    none = absent.all(axis=1)
    whole = np.where(absent, 0.0, given)
    wrong = ~none & (
        absent.any(axis=1)
        | (whole != np.round(whole)).any(axis=1)
        | ~np.isin(whole[:, :3], (0, 1)).all(axis=1)
        | (np.abs(whole) > 127).any(axis=1)
    )
    if wrong.any():
        place = cells.place(int(np.argmax(wrong)), column)
        return None, [_NO_CONFIGURATION(**place, more=rows.more_rows(wrong, cells.place))]
    configurations = whole.astype(np.int8)
    configurations[none] = (UNSTATED, 0, 0, 0, 0, 0)
    return configurations, []


def _row_motions(
    cells: Cells, columns: list[Column], values: Floats, process: Process
) -> tuple[rows.RowMotions, list[Diagnostic]]:
    """Speeds, blends, tools and frames of the rows."""
    findings: list[Diagnostic] = []
    motions = rows.default_motions(len(cells), process)
    speed, blend = (motions.speed, motions.speeds), (motions.blend, motions.blends)
    quantities = ("speed", "rotation", "joint")
    for group, rule, minimum in (
        # More than 0: the least number above it.
        *((g, rows.TOO_SLOW, np.nextafter(0.0, 1.0)) for g in quantities),
        ("blend", rows.NEGATIVE, 0.0),
        ("wait", rows.NEGATIVE, 0.0),
    ):
        column = _first_column(columns, group)
        if column is None:
            continue
        low = values[:, column] < minimum
        if low.any():
            row = int(np.argmax(low))
            findings.append(
                rule(
                    **cells.place(row, column),
                    what=shown(cells.header[column]),
                    value=float(values[row, column]),
                    more=rows.more_rows(low, cells.place),
                )
            )
        known = values[:, [column]]
        known[np.isnan(known)] = 0.0
        most = 100.0 if group == "joint" else LARGEST_POSITION
        findings += position_findings(
            known, _locate(cells, columns, group), shown(cells.header[column]), most=most
        )
        findings += _too_many_values(cells, column, values[:, column]) if group != "wait" else []
    if not findings:
        if any(_first_column(columns, g) is not None for g in quantities):
            parts = [_group_columns(columns, values, g, 1)[:, 0] for g in quantities]
            speed = rows.speeds_of(parts[0], parts[1], parts[2], process)
        if _first_column(columns, "blend") is not None:
            blend = rows.blends_of(_group_columns(columns, values, "blend", 1)[:, 0], process)
    tool, tools, wrong = _name_indices(cells, columns, "tool", process)
    frame, frames, also = _name_indices(cells, columns, "frame", process)
    findings += [*wrong, *also]
    return rows.RowMotions(
        speed[0], blend[0], tool, frame, speed[1], blend[1], tools, frames
    ), findings


def _too_many_values(cells: Cells, column: int, values: Floats) -> list[Diagnostic]:
    different = len(np.unique(values))
    if different <= rows.MOST_DIFFERENT:
        return []
    what, most = shown(cells.header[column]), rows.MOST_DIFFERENT
    place = cells.header_place(column)
    return [rows.TOO_MANY_SPEEDS(**place, count=different, what=what, most=most)]


def _name_indices(
    cells: Cells, columns: list[Column], group: str, process: Process
) -> tuple[NDArray[np.int32], tuple[str, ...], list[Diagnostic]]:
    """Tool or frame index (n,) and table; an empty cell is the default."""
    default = getattr(process.defaults, group)
    table = getattr(process, group + "s")
    find = rows.known_tool if group == "tool" else rows.known_frame
    rule = rows.UNKNOWN_TOOL if group == "tool" else rows.UNKNOWN_FRAME
    column = _first_column(columns, group)
    texts = [""]
    index = np.zeros(len(cells), dtype=np.int32)
    if column is not None:
        index, texts = cells.codes(column)
    entries: list[str] = []
    findings: list[Diagnostic] = []
    for code, text in enumerate(texts):
        wanted = text.strip() or default
        entries.append(find(wanted, process) or default)
        if find(wanted, process) is None and len(findings) < _MOST_CODES:
            where = index == code
            findings.append(
                rule(
                    **cells.place(int(np.argmax(where)), column),
                    name=shown(wanted),
                    more=rows.more_rows(where, cells.place),
                    cure=rows.cure_for(group, wanted, table),
                )
            )
    return index, tuple(entries), findings

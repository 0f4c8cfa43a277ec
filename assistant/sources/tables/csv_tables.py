"""Tables (CSV) of targets and waypoints; `headers` says what their columns may be called.

Rows with names become targets and one move each. Rows without names are waypoints: they
become one path in columns, 35 or a million of them alike. The delimiter is the one of the
header: comma, semicolon or tab. Decimal commas are refused.
"""

from __future__ import annotations

import pathlib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.diagnostics import Diagnostic, Refused, Severity, error, has_errors, info
from assistant.base.source_text import read_bytes
from assistant.program.expressions import JointValue, Name, Number
from assistant.program.geometry import BASE, JointTarget, Pose, Target
from assistant.program.motion import Kind, Path, configuration_of
from assistant.program.program import identifier
from assistant.program.statements import (
    Comment,
    Move,
    MoveCircular,
    MoveJoints,
    SetSignal,
    Statement,
    Wait,
)
from assistant.sources.contours.path_tolerance import shortest_piece
from assistant.sources.process import Process
from assistant.sources.reading import Reading
from assistant.sources.tables import rows
from assistant.sources.tables.columns import ColumnTable, output_signal, table_of
from assistant.sources.tables.delimited_text import Cells, read_cells
from assistant.sources.tables.headers import columns_of, shown
from assistant.sources.tables.rows import metres_finding

ERROR: Final = Severity.ERROR
_MIXED = error(
    "TB133",
    "rows without names mix poses and joints",
    "add a `name` column, or make two files of it",
)
_LEFT_OUT = info("TB136", "the columns {names} are left out, as their `_` asks")


def read(path: pathlib.Path, process: Process) -> Reading:
    """The pseudo-program of a table; raises Unreadable or Refused."""
    return read_table(read_bytes(path), str(path), path.stem, process)


def read_table(data: bytes, path: str, stem: str, process: Process) -> Reading:
    """The pseudo-program of the bytes of a table, named after a file's stem."""
    cells = read_cells(data, path, _check_header)
    columns, _ = columns_of(cells.header)
    name, notes = rows.program_name(stem, path)
    table = table_of(cells, columns, process)
    notes = [*notes, *cells.findings, *table.findings]
    if left := [c for c in columns if c.group == "left out"]:
        names = ", ".join(shown(cells.header[c.part]) for c in left)
        notes.append(_LEFT_OUT(path=path, line=cells.header_line, names=names))
    if set(table.motions.frames) <= {BASE} and not table.of_joints.any():
        notes += metres_finding(table.positions, {"path": path})
    if any(c.group == "name" for c in columns):
        program, more = _named(name, table, process)
        notes += more
    else:
        program, more = _waypoints(name, table, process)
        notes += more
    if has_errors(notes):
        raise Refused(*notes)
    return Reading(program, tuple(notes))


def _check_header(header: tuple[str, ...], where: Mapping[str, Any]) -> None:
    _, problems = columns_of(header)
    if problems:
        raise Refused(
            *(p.rule(**where, place=f"column {p.index + 1}", **p.fields) for p in problems)
        )


def _waypoints(name: str, table: ColumnTable, process: Process) -> tuple[Any, list[Diagnostic]]:
    """The program of rows without names: one path, or moves to joints."""
    comments = tuple(_one_line(c) for c in table.cells.comments)
    motions, external, stated = table.motions, table.external, table.configurations
    others = (motions.speed, motions.blend, motions.tool, motions.frame, external, stated)
    if table.of_joints.any():
        if not table.of_joints.all():
            row = int(np.argmax(table.of_joints))
            raise Refused(_MIXED(**table.cells.place(row)))
        joints = np.nan_to_num(table.joints)
        kept = _kept(table, joints, others, process)
        motions = motions.approached() if table.begins else motions
        body = [
            MoveJoints(JointValue(_joint_target(table, row)), motions.of(row))
            for row in np.flatnonzero(kept).tolist()
        ]
        program = rows.program_of(name, body, process, comments=comments)
        return program, _repeated(table, kept)
    kept = _kept(table, table.positions, others, process)
    findings = _repeated(table, kept)
    off = 0.0
    if process.merges:
        at = np.flatnonzero(kept)
        columns = [None if column is None else column[at] for column in (external, stated)]
        row_data = (table.positions[at], table.quaternions[at], table.kinds[at])
        needed, off = rows.needed_rows(*row_data, motions.those(kept), process.tolerance, *columns)
        findings += _thinned(table, at[~needed], off, process.tolerance)
        kept[at[~needed]] = False
    # Nothing is copied where all rows stay, as they do in most tables.
    left: Any = slice(None) if kept.all() else kept
    positions, kinds, motions = table.positions[left], table.kinds[left], motions.those(left)
    if table.begins:
        at_work = table.states_speed or not rows.begins_with_approach(kinds)
        motions = motions.approached(None if at_work else process.defaults.travel)
    path = Path.of(
        name,
        positions,
        table.quaternions[left],
        kinds=kinds,
        configurations=None if stated is None else stated[left],
        external=None if external is None else external[left],
        **motions.rounded(positions, kinds, process.tolerance - off),
    )
    return rows.paths_program(name, [path], process, comments), findings


def _thinned(table: ColumnTable, rows_out: Rows, off: float, tolerance: float) -> list[Diagnostic]:
    """A note of the rows that the tolerance does not need."""
    if not rows_out.size:
        return []
    place = table.cells.place(int(rows_out[0]))
    return [
        rows.THINNED_ROWS(
            **place,
            count=len(rows_out),
            short=shortest_piece(tolerance),
            deviation=off,
            first=f"line {place['line']}",
        )
    ]


def _kept(
    table: ColumnTable, positions: Floats, others: Sequence[NDArray[Any] | None], process: Process
) -> Truths:
    """The rows that are not left out."""
    if not process.merges:
        return np.ones(len(positions), dtype=np.bool_)
    return rows.moving_rows(positions, table.quaternions, table.kinds, *others)


def _repeated(table: ColumnTable, kept: Truths) -> list[Diagnostic]:
    """A note of the rows that are left out."""
    if kept.all():
        return []
    row, count = int(np.argmin(kept)), int(np.count_nonzero(~kept))
    place = table.cells.place(row)
    return [rows.REPEATED(**place, count=count, first=f"line {place['line']}")]


def _named(name: str, table: ColumnTable, process: Process) -> tuple[Any, list[Diagnostic]]:
    """The program of rows with names: targets, and a move to each in turn."""
    cells, column = table.cells, table.first("name")
    assert column is not None
    names = rows.RowNames()
    targets: dict[str, Target] = {}
    joint_targets: dict[str, JointTarget] = {}
    body: list[Statement] = []
    via = ""
    lines = _lines(cells)
    motions = table.motions.approached() if table.begins else table.motions
    reached: list[str] = []
    for row, line in enumerate(lines):
        where = {"path": cells.path, "line": line, "place": f"column {shown(cells.header[column])}"}
        target = names.of(cells.text(row, column), where, f"line {line}")
        body += _comments(table, row)
        motion = motions.of(row)
        kind = Kind(int(table.kinds[row]))
        if table.of_joints[row]:
            joint_targets[target] = _joint_target(table, row)
            body.append(MoveJoints(Name(target), motion))
        else:
            targets[target] = _target(table, row)
            if kind is Kind.END:
                body.append(MoveCircular(Name(via), Name(target), motion))
            elif kind is not Kind.VIA:
                interpolation: Any = kind.name.lower()
                body.append(Move(interpolation, Name(target), motion))
        via = target
        reached.append(target)
        body += _after(table, row, process)
    comments = tuple(_one_line(c) for c in cells.comments)
    program = rows.program_of(name, body, process, targets, joint_targets, comments)
    findings = [*names.findings]
    if cornered := rows.set_in_corners(program):
        place = cells.place(reached.index(cornered[0]), table.first("set"))
        findings.append(rows.SET_IN_CORNER(**place, names=shown(", ".join(cornered), 120)))
    if left := rows.left_by_joints(program):
        place = cells.place(reached.index(next(iter(left.values()))), table.first("motion"))
        findings.append(rows.LEFT_BY_JOINTS(**place, names=shown(", ".join(left), 120)))
    return program, findings


def _lines(cells: Cells) -> list[int]:
    """The line of each row."""
    feeds = np.flatnonzero(cells.octets == ord("\n"))
    lines: list[int] = (np.searchsorted(feeds, cells.starts[:, 0]) + 1).tolist()
    return lines


def _target(table: ColumnTable, row: int) -> Target:
    pose = Pose.of(table.positions[row], table.quaternions[row])
    stated = table.configurations
    configuration = configuration_of(stated[row]) if stated is not None else None
    if table.external is None:
        return Target(pose, configuration)
    return Target(pose, configuration, tuple(table.external[row].tolist()))


def _joint_target(table: ColumnTable, row: int) -> JointTarget:
    joints = tuple(table.joints[row].tolist())
    if table.external is None:
        return JointTarget(joints)
    return JointTarget(joints, tuple(table.external[row].tolist()))


def _comments(table: ColumnTable, row: int) -> Iterator[Statement]:
    column = table.first("comment")
    if column is not None and (text := _one_line(table.cells.text(row, column))):
        yield Comment(text)


def _after(table: ColumnTable, row: int, process: Process) -> Iterator[Statement]:
    """The signals that are set after a move, and the wait for what they cause."""
    waits = list[Statement]()
    for index, column in enumerate(table.columns):
        value = float(table.values[row, index]) if column.group in ("set", "wait") else np.nan
        if np.isnan(value):
            continue
        number = Number(int(value) if value.is_integer() else value)
        if column.group == "wait":
            waits.append(Wait(number))
        else:
            yield SetSignal(
                output_signal(column.detail, process) or identifier(column.detail), number
            )
    yield from waits


def _one_line(text: str) -> str:
    """A comment from a cell: printable characters on one line."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())

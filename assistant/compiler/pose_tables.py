"""Columns of a table that hold poses, converted from one convention to another."""

from __future__ import annotations

import csv
import io
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any, Final

from assistant.base.diagnostics import Refused, error
from assistant.base.source_text import read_bytes
from assistant.languages.pose_conventions import Convention, convention, read, write
from assistant.program.se3 import Unit
from assistant.sources.tables.delimited_text import read_cells

_NO_COLUMNS: Final = error(
    "TB454",
    "the table has no column {names}; it has {there}",
    "name the columns of the pose in their order: --columns {wanted}",
)
_TWO_UNITS: Final = error(
    "TB455",
    "the column `{name}` is in {stated}, not in {unit}",
    "leave the unit out: the name of the column tells it",
)
_COLUMN_COUNT: Final = error(
    "TB456", "{count} columns are named for {names}", "name {wanted}, in this order"
)
_POSITIONS: Final = 3


def convert_table(
    path: pathlib.Path,
    source: str,
    target: str,
    *,
    unit: Unit | None = None,
    to_unit: Unit | None = None,
    columns: Sequence[str] = (),
) -> bytes:
    """Return a table whose columns of a convention are replaced by those of another, as CSV.

    columns: their names in the table, in the order of the convention; without them columns are
    found by the names of the convention, also with their unit (`x_mm`, `A_deg`). Other columns
    follow as they are. Raises Unreadable and Refused.
    """
    given, wanted = convention(source), convention(target)
    cells = read_cells(read_bytes(path), str(path), lambda _header, _where: None)
    places, found = _places(cells.header, given, columns, {"path": str(path)})
    if found and unit and found != unit:
        column = cells.header[places[0]]
        raise Refused(_TWO_UNITS(path=str(path), name=column, stated=found, unit=unit))
    ordered = sorted(places)
    values = cells.numbers(ordered)[:, [ordered.index(place) for place in places]]
    unit = found or unit or given.unit
    there = to_unit or wanted.unit or unit
    rows = write(read(values, source, unit=unit), target, to_unit=there)
    others = [index for index in range(len(cells.header)) if index not in places]
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow([*column_names(wanted, there), *(cells.header[index] for index in others)])
    for number, row in enumerate(rows):
        kept = [cells.text(number, index) for index in others]
        table.writerow([*number_texts(row, wanted, there), *kept])
    return out.getvalue().encode()


def column_names(one: Convention, unit: Unit | None) -> tuple[str, ...]:
    """Names of the columns of a convention with their units, as tables of waypoints have them."""
    if one.form == "matrix":
        return one.names
    places = tuple(f"{name}_{unit}" for name in one.names[:_POSITIONS])
    if one.form == "quaternion":
        return (*places, *(f"q_{part}" for part in one.order))
    if one.form == "rotation-vector":
        return (*places, *(f"rotvec_{axis}_{one.angle}" for axis in "xyz"))
    return (*places, *(f"{name}_{one.angle}" for name in one.columns))


def number_texts(row: Sequence[float], one: Convention, unit: Unit | None) -> list[str]:
    """The numbers of a pose as text: a micrometre or less, and nine digits of parts of a turn."""
    lengths = {3, 7, 11} if one.form == "matrix" else {0, 1, 2}
    digits = [
        (5 if unit == "mm" else 8) if place in lengths else (6 if one.form == "angles" else 9)
        for place in range(len(row))
    ]
    texts = [f"{value:.{most}f}" for value, most in zip(row, digits, strict=True)]
    return [_plain(text) for text in texts]


def _plain(text: str) -> str:
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text == "-0" else text


def _places(
    header: Sequence[str], one: Convention, columns: Sequence[str], where: Mapping[str, Any]
) -> tuple[list[int], Unit | None]:
    """Places of the columns of a pose, and the unit of the positions that their names state."""
    names = [name.strip().lower() for name in header]
    if columns and len(columns) != len(one.names):
        fields: dict[str, Any] = {
            "count": len(columns),
            "names": one.title,
            "wanted": " ".join(one.names),
        }
        raise Refused(_COLUMN_COUNT(**where, **fields))
    spellings = [{column.strip().lower()} for column in columns] or [
        {name.lower(), *(column_names(one, unit)[place].lower() for unit in ("mm", "m"))}
        for place, name in enumerate(one.names)
    ]
    if one.form == "angles" and not columns:
        for place, name in enumerate(one.columns, _POSITIONS):
            spellings[place].add(f"{name}_{one.angle}".lower())
    places = [next((i for i, n in enumerate(names) if n in some), -1) for some in spellings]
    missing = [one.names[i] for i, place in enumerate(places) if place < 0]
    if columns:
        missing = [column for column, place in zip(columns, places, strict=True) if place < 0]
    if missing or len(set(places)) != len(places):
        wanted, there = ",".join(one.names), ", ".join(header)[:200]
        said: dict[str, Any] = {
            "names": ", ".join(missing) or "of its own for each",
            "there": there,
        }
        raise Refused(_NO_COLUMNS(**where, **said, wanted=wanted))
    ends = {names[place].rpartition("_")[2] for place in places[:_POSITIONS]}
    units: tuple[Unit, ...] = ("mm", "m")
    return places, next((unit for unit in units if ends == {unit}), None)

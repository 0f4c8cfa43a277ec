"""Rows of numbers as they come from a controller, kept in columns, saved as CSV or NPZ."""

from __future__ import annotations

import csv
import io
import math
from array import array
from collections.abc import Mapping, Sequence
from pathlib import Path as FilePath
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused, UnknownName, error
from assistant.base.file_sets import write_or_raise
from assistant.base.source_text import path_of
from assistant.lazy import pictured

_NO_FORMAT: Final = error(
    "CN601", "a recording cannot be written as `{suffix}`", "name a file that ends in {known}"
)
_NO_ROW: Final = error(
    "CN603",
    "a row of the recording does not fit: {reason}",
    "give a value for each of {count} fields",
)
_NO_FIELD: Final = error("CN604", "the recording has no field `{name}`", "choose one of {known}")
_NOT_SAVED: Final = error(
    "CN602",
    "the recording cannot be written: {reason}; what was there before is untouched",
    "free space or name another file",
)


class Recording:
    """Fields by name; each row has a number for every component of each field.

    fields: name → names of its components, none for a single number.
    """

    def __init__(self, fields: Mapping[str, Sequence[str]]) -> None:
        self.fields = {name: tuple(parts) for name, parts in fields.items()}
        self._widths = {name: max(1, len(parts)) for name, parts in self.fields.items()}
        self._width = sum(self._widths.values())
        # One flat array: a row of Python objects for each status would take many times the memory.
        self._numbers = array("d")

    def __repr__(self) -> str:
        return f"<Recording: {len(self)} row{'s' * (len(self) != 1)} of {', '.join(self.fields)}>"

    def _repr_html_(self) -> str:
        return pictured(self)

    def __len__(self) -> int:
        return len(self._numbers) // self._width

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the columns: `field`, or `field.component`."""
        return tuple(
            f"{name}.{part}" if part else name
            for name, parts in self.fields.items()
            for part in parts or ("",)
        )

    def add(self, *values: float | Sequence[float]) -> None:
        """A row, a value for each field; raises Refused if it does not fit."""
        row = array("d")
        try:
            for name, value in zip(self.fields, values, strict=True):
                numbers = [value] if isinstance(value, (int, float)) else list(value)
                if len(numbers) != self._widths[name]:
                    reason = f"{name} has {self._widths[name]} components, not {len(numbers)}"
                    raise ValueError(reason)
                row.extend(numbers)
        except (TypeError, ValueError, OverflowError) as error:
            raise Refused(_NO_ROW(reason=error, count=len(self.fields))) from None
        self._numbers.extend(row)

    def rows(self) -> Floats:
        """(n, k): a copy of all rows, a column for each of `labels`."""
        return np.array(self._numbers, dtype=np.float64).reshape(-1, self._width)

    def column(self, name: str) -> Floats:
        """(n,) of a field that is one number, (n, k) of one of k components."""
        at = 0
        for field, width in self._widths.items():
            if field == name:
                part = self.rows()[:, at : at + width]
                return part if self.fields[name] else part[:, 0]
            at += width
        raise UnknownName(_NO_FIELD(name=str(name)[:40], known=", ".join(self.fields)))

    def save(self, path: str | FilePath) -> None:
        """Writes a `.csv` with `labels` above, or a `.npz` with an array for each field.

        The file appears whole or not at all. Raises Refused (exit status 2).
        """
        cells = dict(zip(self.labels, self.rows().T, strict=True))
        save_columns(path, cells, {name: self.column(name) for name in self.fields})


def check_place(path: str | FilePath) -> None:
    """Raise Refused (exit status 2) for a file that no recording can be: of another form, or in a
    folder that is not there. For those who record a motion, before it begins.
    """
    target = path_of(path)
    form = target.suffix.lower()
    if form not in _FORMS:
        known = " or ".join(f"`{suffix}`" for suffix in _FORMS)
        finding = _NO_FORMAT(path=str(target), suffix=target.suffix, known=known)
        raise Refused(finding, exit_status=2)
    if not target.parent.is_dir():
        reason = f"there is no folder `{target.parent}`"
        raise Refused(_NOT_SAVED(path=str(target), reason=reason), exit_status=2)


def save_columns(
    path: str | FilePath, columns: Mapping[str, Floats], arrays: Mapping[str, Floats] | None = None
) -> None:
    """Writes (n,) columns as `.csv` with their names above, or as arrays of a `.npz`.

    arrays: (n, …) of a `.npz`, where they are others. The file appears whole or not at all. Raises
    Refused (exit status 2).
    """
    check_place(path)
    target = FilePath(path)
    is_table = target.suffix.lower() == ".csv"
    data = _csv(columns) if is_table else _npz(columns if arrays is None else arrays)
    try:
        write_or_raise({target: data})
    except OSError as wrong:
        reason = wrong.strerror or str(wrong)
        raise Refused(_NOT_SAVED(path=str(target), reason=reason), exit_status=2) from None


def _csv(columns: Mapping[str, Floats]) -> bytes:
    """An empty cell for a number that is not there."""
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(columns)
    for row in zip(*(column.tolist() for column in columns.values()), strict=True):
        # repr() gives the shortest text that reads back to the same number.
        writer.writerow("" if math.isnan(value) else repr(value) for value in row)
    return text.getvalue().encode()


def _npz(arrays: Mapping[str, Floats]) -> bytes:
    """The same bytes for the same numbers: no time stamps."""
    data = io.BytesIO()
    np.savez_compressed(data, **arrays)  # type: ignore[arg-type]
    return data.getvalue()


_FORMS: Final = (".csv", ".npz")

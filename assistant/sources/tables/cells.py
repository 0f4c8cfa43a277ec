"""Cells of a delimited text in columns: found, counted and read without an object a row."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.columns import read_numbers
from assistant.base.diagnostics import Diagnostic, Refused, Severity, error
from assistant.sources.tables.headers import shown

ERROR: Final = Severity.ERROR
COMMA_DECIMAL = error(
    "TB121",
    "{cell} has a decimal comma{more}",
    "write decimal points; spreadsheets do so when the locale of the export is English",
)
NOT_FINITE = error(
    "TB122", "{cell} is no place that a robot can be at{more}", "mend or remove the row"
)
FORMULA = error("TB123", "{cell} is a formula{more}", "save the values, not the formulas")
UNIT_IN_CELL = error(
    "TB124",
    "{cell} has its unit in the cell{more}",
    "write the unit into the name of the column and numbers alone below it",
)
NOT_A_NUMBER = error("TB125", "{cell} is no number{more}", "write a number such as `-12.5`")
EMPTY_CELL = error("TB126", "the cell is empty{more}", "fill it in, or remove the row")

BLANKS: Final = b" \t"
_ROWS_AT_ONCE: Final = 1 << 14
"""Rows read at a time, so that what is made of them stays in the processor's cache."""
_WIDEST: Final = 256
_NUMERIC_BYTES: Final = b"0123456789+-.eE "
_NUMBER_HINTS: Final = (
    (re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?|[+-]?\d{1,3}(\.\d{3})+,\d+"), COMMA_DECIMAL),
    (re.compile(r"(?i)[+-]?(nan|inf|infinity|1\.#\w+)"), NOT_FINITE),
    (re.compile(r"(?s)[=@].*"), FORMULA),
    (re.compile(r"[+-]?[\d.]+\s*(mm|cm|m|in|deg|rad|°|mm/s|m/s|s|%)"), UNIT_IN_CELL),
)
"""What a cell that is no number looks like, and the rule that says what to do about it."""


Offsets = NDArray[np.int32] | NDArray[np.int64]


@dataclass(frozen=True)
class Cells:
    """n rows of k cells.

    data: the whole text as UTF-8 with line feeds. starts, ends: (n, k) offsets into it of
    the cells without outer blanks and quotes. header: names of the k columns.
    """

    data: bytes
    path: str
    header: tuple[str, ...]
    comments: tuple[str, ...]
    starts: Offsets
    ends: Offsets
    header_line: int
    findings: tuple[Diagnostic, ...] = field(default=())

    def __len__(self) -> int:
        return len(self.starts)

    @cached_property
    def octets(self) -> NDArray[np.uint8]:
        return np.frombuffer(self.data, dtype=np.uint8)

    @property
    def empty(self) -> NDArray[np.bool_]:
        """(n, k) whether a cell holds nothing."""
        return np.asarray(self.starts == self.ends)

    def text(self, row: int, column: int) -> str:
        """One cell, for the few."""
        return unescaped_cell(self.data[self.starts[row, column] : self.ends[row, column]])

    def place(self, row: int, column: int | None = None) -> dict[str, Any]:
        """Where a cell is, as the arguments of a rule."""
        offset = int(self.starts[row, column or 0])
        label = f"column {shown(self.header[column])}" if column is not None else None
        return {"path": self.path, "place": label, **line_at(self.data, offset)}

    def header_place(self, column: int) -> dict[str, Any]:
        label = f"column {column + 1}"
        return {"path": self.path, "place": label, "line": self.header_line}

    def numbers(self, columns: list[int]) -> NDArray[np.float64]:
        """The numbers (n, c) of some columns in the file's order, NaN for empty cells.

        Raises Refused with the first cell of each column that is no number.
        """
        columns = sorted(columns)
        values = np.full((len(self), len(columns)), np.nan)
        for start in range(0, len(self), _ROWS_AT_ONCE):
            rows = slice(start, start + _ROWS_AT_ONCE)
            starts, ends = self.starts[rows, columns], self.ends[rows, columns]
            present = starts < ends
            found = self._parsed(starts[present], ends[present])
            if found is None:
                raise Refused(*self._not_numbers(columns))
            values[rows][present] = found
        return values

    def codes(self, column: int) -> tuple[NDArray[np.int32], list[str]]:
        """A text column (n,) as indices into the list of its different cells."""
        table: dict[bytes, int] = {}
        parts = [np.empty(0, dtype=np.int32)]
        for start in range(0, len(self), _ROWS_AT_ONCE):
            rows = slice(start, start + _ROWS_AT_ONCE)
            cells, repeats = self._distinct_runs(rows, column)
            index = [table.setdefault(cell, len(table)) for cell in cells]
            parts.append(np.repeat(np.array(index, dtype=np.int32), repeats))
        return np.concatenate(parts), [unescaped_cell(cell) for cell in table]

    def _distinct_runs(self, rows: slice, column: int) -> tuple[list[bytes], NDArray[np.intp]]:
        """The cells of some rows with neighbours that are equal taken together."""
        starts, ends = self.starts[rows, column], self.ends[rows, column]
        lengths = ends - starts
        width = int(lengths.max(initial=1)) or 1
        if width > _WIDEST:
            pairs = zip(starts.tolist(), ends.tolist(), strict=True)
            return [self.data[a:b] for a, b in pairs], np.ones(len(starts), dtype=np.intp)
        at = np.minimum(starts[:, None] + np.arange(width), len(self.data) - 1)
        matrix = np.where(np.arange(width) < lengths[:, None], self.octets[at], 0).astype(np.uint8)
        differs = (matrix[1:] != matrix[:-1]).any(axis=1)
        heads = np.concatenate([[0], np.flatnonzero(differs) + 1])
        runs = np.diff(np.concatenate([heads, [len(starts)]]))
        texts = np.ascontiguousarray(matrix[heads]).view(f"S{width}")[:, 0]
        return texts.tolist(), runs

    def _parsed(self, starts: Offsets, ends: Offsets) -> NDArray[np.float64] | None:
        """The numbers of cells that are not empty, in order; None if one is no number."""
        if not len(starts):
            return np.empty(0)
        first, last = int(starts[0]), int(ends[-1])
        edge = np.zeros(last - first + 1, dtype=np.int8)
        edge[starts - first] = 1
        edge[ends - first] = -1
        within = np.cumsum(edge[:-1], dtype=np.int8).view(bool)
        text = np.where(within, self.octets[first:last], BLANKS[0]).astype(np.uint8).tobytes()
        if text.translate(None, _NUMERIC_BYTES):
            return None
        try:
            found = read_numbers(text)
        except ValueError:
            return None
        # a cell holds at least one number, so as many numbers as cells is one in each
        return found if len(found) == len(starts) else None

    def _not_numbers(self, columns: list[int]) -> list[Diagnostic]:
        return [finding for column in columns for finding in self._not_numbers_in(column)]

    def _not_numbers_in(self, column: int) -> list[Diagnostic]:
        rows = np.flatnonzero(self.starts[:, column] < self.ends[:, column])
        starts, ends = self.starts[rows, column], self.ends[rows, column]
        if self._parsed(starts, ends) is not None:
            return []
        low, high = 0, len(rows)  # the first bad cell lies in rows[low:high]
        while high - low > 1:
            middle = (low + high) // 2
            if self._parsed(starts[low:middle], ends[low:middle]) is None:
                high = middle
            else:
                low = middle
        rest = self._parsed(starts[high:], ends[high:]) is None
        row = int(rows[low])
        cell = self.text(row, column)
        rule = next(
            (rule for hint, rule in _NUMBER_HINTS if hint.fullmatch(cell[:200])), NOT_A_NUMBER
        )
        more = ", and so are others below it" if rest else ""
        return [rule(**self.place(row, column), cell=shown(cell), more=more)]


def unescaped_cell(cell: bytes) -> str:
    return cell.decode().replace('""', '"')


def line_at(text: bytes, offset: int) -> dict[str, Any]:
    """Line, column and excerpt of an offset, as the arguments of a rule."""
    start = text.rfind(b"\n", 0, offset) + 1
    end = text.find(b"\n", offset)
    line = text[start : end if end >= 0 else None].decode(errors="replace")
    before = text[start:offset].decode(errors="replace")
    return {
        "line": text.count(b"\n", 0, start) + 1,
        "column": len(before) + 1,
        "excerpt": line if len(line) <= 200 and line.isprintable() else None,
    }

"""Delimited text as columns of cells: delimiter, quotes, blank lines, line ends, encodings.

Cells are found, counted and read without a Python object for each row. A large table of nothing but
numbers is read by polars, the extra `fast`; the numbers are the same.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property
from importlib.util import find_spec
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.columns import read_numbers
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import (
    Diagnostic,
    Refused,
    Rule,
    Severity,
    Span,
    Unreadable,
    error,
    info,
)
from assistant.base.source_text import LINE_END_INSIDE, LINE_ENDS, SourceText, decode
from assistant.sources.tables.headers import shown
from assistant.sources.tables.rows import more_rows

ERROR: Final = Severity.ERROR
_COMMA_DECIMAL = error(
    "TB121",
    "{cell} has a decimal comma{more}",
    "write decimal points; spreadsheets do so when the locale of the export is English",
)
_NOT_FINITE = error(
    "TB122", "{cell} is no place that a robot can be at{more}", "mend or remove the row"
)
_FORMULA = error("TB123", "{cell} is a formula{more}", "save the values, not the formulas")
_UNIT_IN_CELL = error(
    "TB124",
    "{cell} has its unit in the cell{more}",
    "write the unit into the name of the column and numbers alone below it",
)
NOT_A_NUMBER = error("TB125", "{cell} is no number{more}", "write a number such as `-12.5`")
EMPTY_CELL = error("TB126", "the cell is empty{more}", "fill it in, or remove the row")

_BLANKS: Final = b" \t"
_ROWS_AT_ONCE: Final = 1 << 14
"""Rows read at a time, so that what is made of them stays in the processor's cache."""
_WIDEST: Final = 256
_FEW_CELLS: Final = 16
"""Cells that are read one by one where one of them is no number."""
_PLAIN_NUMBER: Final = re.compile(rb"[+-]?[0-9.]+([eE][+-]?[0-9]+)?")
_NUMERIC_BYTES: Final = b"0123456789+-.eE "
_NUMBER_HINTS: Final = (
    (re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?|[+-]?\d{1,3}(\.\d{3})+,\d+"), _COMMA_DECIMAL),
    (re.compile(r"(?i)[+-]?(nan|inf|infinity|1\.#\w+)"), _NOT_FINITE),
    (re.compile(r"(?s)[=@].*"), _FORMULA),
    (re.compile(r"[+-]?[\d.]+\s*(mm|cm|m|in|deg|rad|°|mm/s|m/s|s|%)"), _UNIT_IN_CELL),
)
"""Patterns of cells that are not numbers, each with the rule that states the cure."""


Offsets = NDArray[np.int32] | NDArray[np.int64]


@dataclass(frozen=True)
class Cells:
    """n rows of k cells.

    data: the whole text as UTF-8 with line feeds. header: names of the k columns. edges: (n, k)
    offsets into the text of the starts and ends of the cells, without outer blanks and quotes.
    plain: the numbers (n, k), if every cell holds one; the edges are then found when they are
    needed, from the offset `begin` of the first row on.
    """

    data: bytes
    path: str
    header: tuple[str, ...]
    comments: tuple[str, ...]
    header_line: int
    edges: tuple[Offsets, Offsets] | None
    plain: Floats | None = None
    begin: int = 0
    delimiter: int = 0
    findings: tuple[Diagnostic, ...] = field(default=())

    def __len__(self) -> int:
        return len(self.starts if self.plain is None else self.plain)

    @property
    def shape(self) -> tuple[int, int]:
        return len(self), len(self.header)

    @cached_property
    def _cut(self) -> tuple[Offsets, Offsets]:
        if self.edges is not None:
            return self.edges
        starts, ends, _ = _split_cells(self.data, self.begin, self.delimiter, self.path)
        return starts.reshape(self.shape), ends.reshape(self.shape)

    @property
    def starts(self) -> Offsets:
        return self._cut[0]

    @property
    def ends(self) -> Offsets:
        return self._cut[1]

    @cached_property
    def octets(self) -> NDArray[np.uint8]:
        return np.frombuffer(self.data, dtype=np.uint8)

    @property
    def empty(self) -> NDArray[np.bool_]:
        """(n, k) whether a cell holds nothing."""
        if self.plain is not None:
            return np.broadcast_to(np.False_, self.shape)
        return np.asarray(self.starts == self.ends)

    def text(self, row: int, column: int) -> str:
        """One cell, for the few."""
        return _unescaped_cell(self.data[self.starts[row, column] : self.ends[row, column]])

    def place(self, row: int, column: int | None = None) -> dict[str, Any]:
        """Return the source location of a cell, as the arguments of a rule."""
        offset = int(self.starts[row, column or 0])
        label = f"column {shown(self.header[column])}" if column is not None else None
        return {"path": self.path, "place": label, **_line_at(self.data, offset)}

    def header_place(self, column: int) -> dict[str, Any]:
        label = f"column {column + 1}"
        return {"path": self.path, "place": label, "line": self.header_line}

    def those(self, rows: Truths) -> Cells:
        """Some of the rows."""
        return replace(self, edges=(self.starts[rows], self.ends[rows]), plain=None)

    def numbers(self, columns: list[int]) -> NDArray[np.float64]:
        """Return the numbers (n, c) of some columns in the file's order, NaN for empty cells.

        Raises UnreadCells if one is not a number.
        """
        # Numbers are read in the file's order, in which the offsets ascend.
        columns = sorted(columns)
        if self.plain is not None:
            return self.plain[:, columns]
        values = np.full((len(self), len(columns)), np.nan)
        for start in range(0, len(self), _ROWS_AT_ONCE):
            rows = slice(start, start + _ROWS_AT_ONCE)
            starts, ends = self.starts[rows, columns], self.ends[rows, columns]
            present = starts < ends
            found = self._parsed(starts[present], ends[present])
            if found is None:
                raise self._unread(columns)
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
        return np.concatenate(parts), [_unescaped_cell(cell) for cell in table]

    def _distinct_runs(self, rows: slice, column: int) -> tuple[list[bytes], NDArray[np.intp]]:
        """The cells of some rows with neighbours that are equal taken together."""
        starts, ends = self.starts[rows, column], self.ends[rows, column]
        lengths = ends - starts
        width = int(lengths.max(initial=1)) or 1
        # The matrix is as wide as the longest cell: one long text would make it huge.
        if width > _WIDEST:
            pairs = zip(starts.tolist(), ends.tolist(), strict=True)
            return [self.data[a:b] for a, b in pairs], np.ones(len(starts), dtype=np.intp)
        at = np.minimum(starts[:, None] + np.arange(width), len(self.data) - 1)
        matrix = np.where(np.arange(width) < lengths[:, None], self.octets[at], 0).astype(np.uint8)
        differs = (matrix[1:] != matrix[:-1]).any(axis=1)
        heads = np.concatenate([[0], np.flatnonzero(differs) + 1])
        runs = np.diff(np.concatenate([heads, [len(starts)]]))
        # The view drops trailing zero bytes, which no text has.
        texts = np.ascontiguousarray(matrix[heads]).view(f"S{width}")[:, 0]
        return texts.tolist(), runs

    def _parsed(self, starts: Offsets, ends: Offsets) -> NDArray[np.float64] | None:
        """The numbers of cells that are not empty, in order; None if one is no number."""
        if not len(starts):
            return np.empty(0)
        first, last = int(starts[0]), int(ends[-1])
        # A running sum marks the bytes inside cells; all others become blanks.
        edge = np.zeros(last - first + 1, dtype=np.int8)
        edge[starts - first] = 1
        edge[ends - first] = -1
        within = np.cumsum(edge[:-1], dtype=np.int8).view(bool)
        text = np.where(within, self.octets[first:last], _BLANKS[0]).astype(np.uint8).tobytes()
        if text.translate(None, _NUMERIC_BYTES):
            return None
        try:
            found = read_numbers(text)
        except ValueError:
            return None
        # a cell holds at least one number, so as many numbers as cells is one in each
        return found if len(found) == len(starts) else None

    def _unread(self, columns: list[int]) -> UnreadCells:
        """The cells of some columns that are not numbers, each fault of a column once."""
        rows, findings = np.zeros(len(self), dtype=np.bool_), []
        for column in columns:
            wrong = self._not_numbers_in(column)
            rows[wrong] = True
            alike: dict[Rule, list[int]] = {}
            for row in wrong.tolist():
                cell = self.text(row, column)[:200]
                hints = (rule for hint, rule in _NUMBER_HINTS if hint.fullmatch(cell))
                alike.setdefault(next(hints, NOT_A_NUMBER), []).append(row)
            for rule, those in alike.items():
                cell, place = shown(self.text(those[0], column)), self.place(those[0], column)
                findings.append(
                    rule(**place, cell=cell, more=more_rows(np.array(those), self.place))
                )
        return UnreadCells(rows, sorted(findings, key=lambda one: one.line or 0))

    def _not_numbers_in(self, column: int) -> Rows:
        """The rows of a column whose cells are not numbers."""
        rows = np.flatnonzero(self.starts[:, column] < self.ends[:, column])
        wrong = []
        # Parsing in columns tells only that some cell is wrong.
        parts = [rows]
        while parts:
            part = parts.pop()
            if self._parsed(self.starts[part, column], self.ends[part, column]) is not None:
                continue
            if len(part) <= _FEW_CELLS:
                wrong += [row for row in part.tolist() if not self._is_number(row, column)]
                continue
            middle = len(part) // 2
            parts += [part[middle:], part[:middle]]
        return np.array(wrong, dtype=np.intp)

    def _is_number(self, row: int, column: int) -> bool:
        """True if a cell is a number alone."""
        start, end = self.starts[row, column], self.ends[row, column]
        if _PLAIN_NUMBER.fullmatch(self.data, start, end) is None:
            return False
        one = np.array([row])
        return self._parsed(self.starts[one, column], self.ends[one, column]) is not None


class UnreadCells(Refused):
    """Cells are not numbers. rows: which of all (n,) have one."""

    def __init__(self, rows: Truths, findings: Sequence[Diagnostic]) -> None:
        super().__init__(*findings)
        self.rows = rows


def _unescaped_cell(cell: bytes) -> str:
    return cell.decode().replace('""', '"')


def _line_at(text: bytes, offset: int) -> dict[str, Any]:
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


_NOT_TEXT = error("TB111", "the file holds zero bytes, it is no text", "export it as CSV")
_NO_LINES = error("TB112", "the file holds nothing but blanks", "export or save it again")
_NO_ROWS = error("TB113", "there is no row below the header", "export or save it again")
_RAGGED = error(
    "TB114",
    "the row has {count} cells, the header {wanted}{more}",
    "give every row as many cells as the header, with nothing between delimiters for none",
)
_COMMA_ROW = error(
    "TB115",
    "the row has {count} cells, the header {wanted}{more}; are these decimal commas?",
    "write decimal points, or save with `;` between the cells and decimal points",
)
_STRAY_QUOTE = error(
    "TB116",
    "a quotation mark stands inside a cell",
    'put the whole cell in quotation marks and double those inside it: `"5"" pipe"`',
)
_UNCLOSED_QUOTE = error(
    "TB117", "a quotation mark is never closed", "close it at the end of the cell"
)
_EMPTY_ROWS = info("TB118", "{count} rows of empty cells are left out")

_DELIMITERS: Final = b",;\t"
_QUOTE, _LINE_END = b'"'[0], b"\n"[0]
_TRIM_STEPS: Final = 16
_SPLIT_BYTES: Final = 1 << 19
"""Bytes split at a time, so that what is made of them stays in the processor's cache."""

HeaderCheck = Callable[[tuple[str, ...], Mapping[str, Any]], None]


def read_cells(data: bytes, path: str, check: HeaderCheck) -> Cells:
    """Return the cells of a delimited text; the delimiter is the one that the header uses.

    check: raises the faults of the header before any row is checked. Lines before the header that
    begin with `#` are comments; blank lines do not count. Raises Unreadable if it is not text,
    Refused for ragged rows or loose quotation marks.
    """
    text = _as_text(data, path)
    comments: list[str] = []
    at = 0
    # Comments and blank lines before the header.
    while True:
        end = text.find(b"\n", at)
        if end < 0:
            rule = _NO_ROWS if comments else _NO_LINES
            raise Unreadable(rule(path=path))
        line = text[at:end].strip()
        if line.startswith(b"#"):
            comments.append(line.lstrip(b"# ").decode())
        elif line:
            break
        at = end + 1
    delimiter = _delimiter(text[at:end])
    header_line = text.count(b"\n", 0, at) + 1
    begin = end + 1
    if text.count(b'"', at, begin) % 2 == 0:
        starts, ends, counts = _split_cells(text[:begin], at, delimiter, path)
        numbers = plain_numbers(text[begin:], delimiter, int(counts[0]))
        if numbers is not None:
            header = _header_names(text, starts, ends)
            check(header, {"path": path, "line": header_line})
            return Cells(
                text, path, header, tuple(comments), header_line, None, numbers, begin, delimiter
            )
    starts, ends, counts = _split_cells(text, at, delimiter, path)
    width = int(counts[0])
    header = _header_names(text, starts[:width], ends[:width])
    check(header, {"path": path, "line": header_line})
    starts, ends = _without_blank_lines(starts[width:], ends[width:], counts[1:], width, text, path)
    starts, ends = starts.reshape(-1, width), ends.reshape(-1, width)
    # Spreadsheets export empty rows as delimiters alone.
    filled = (starts < ends).any(axis=1)
    findings: tuple[Diagnostic, ...] = ()
    if not filled.all():
        gone = np.flatnonzero(~filled)
        findings = (
            _EMPTY_ROWS(path=path, count=len(gone), **_line_at(text, int(starts[gone[0], 0]))),
        )
        starts, ends = starts[filled], ends[filled]
    if not len(starts):
        raise Refused(_NO_ROWS(path=path, line=header_line))
    return Cells(
        text, path, header, tuple(comments), header_line, (starts, ends), findings=findings
    )


def _header_names(text: bytes, starts: Offsets, ends: Offsets) -> tuple[str, ...]:
    return tuple(_unescaped_cell(text[a:b]) for a, b in zip(starts, ends, strict=True))


def _as_text(data: bytes, path: str) -> bytes:
    # Byte order marks of UTF-16, as Excel writes it for "Unicode text".
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        data = decode(data, path, ("utf-16",)).text.encode()
    if b"\0" in data:
        raise Unreadable(_NOT_TEXT(path=path))
    if not data.isascii():
        data = decode(data, path, ("utf-8-sig", "utf-8", "cp1252")).text.encode()
    _check_returns(data, path)
    text = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in data else data
    return text if text.endswith(b"\n") else text + b"\n"


def _check_returns(data: bytes, path: str) -> None:
    """Raise Refused for a lone carriage return that some readers do not take as the end of a
    row.
    """
    if b"\r" not in data or b"\n" not in data or data.count(b"\r") == data.count(b"\r\n"):
        return
    quoted = False
    # Line ends inside quotes belong to the cell.
    for mark in re.finditer(rb'"|\r(?!\r*\n|\Z)', data):
        if mark[0] == b'"':
            quoted = not quoted
        elif not quoted:
            at = len(data[: mark.start()].decode())
            source, character = SourceText(data.decode(), path), LINE_ENDS["\r"]
            raise Refused(source.finding(LINE_END_INSIDE, Span(at, at + 1), character=character))


def _delimiter(header: bytes) -> int:
    # Delimiters inside quoted names do not count.
    bare = re.sub(rb'"[^"]*"', b"", header)
    return max(_DELIMITERS, key=lambda mark: bare.count(bytes([mark])))


def _split_cells(text: bytes, at: int, delimiter: int, path: str) -> tuple[Offsets, Offsets, Rows]:
    """Starts and ends of all cells from an offset on, and how many each line has."""
    body = np.frombuffer(text, dtype=np.uint8)[at:]
    quoted = bytes([_QUOTE]) in text
    if quoted:
        _check_quotes(text, at, body, delimiter, path)
    ends = _cell_edges(body, delimiter, quoted)
    starts = np.concatenate([np.zeros(1, ends.dtype), ends[:-1] + 1])
    # Ends at a line feed are those of the last cells of lines.
    counts = np.diff(np.flatnonzero(body[ends] == _LINE_END), prepend=-1)
    blanks = [b for b in _BLANKS if b != delimiter]
    if any(bytes([b]) in text for b in blanks):
        starts, ends = _trimmed_cells(body, starts, ends, blanks)
    if quoted:
        # Only one quote on each side: doubled ones inside belong to the text.
        outer = (ends > starts) & (body[np.minimum(starts, len(body) - 1)] == _QUOTE)
        starts, ends = _trimmed_cells(body, starts + outer, ends - outer, list(_BLANKS))
    starts += at
    ends = ends + at
    return starts, ends, counts


def _cell_edges(body: NDArray[np.uint8], delimiter: int, quoted: bool) -> Offsets:
    """Offsets of the delimiters and line ends outside quotes, found a part at a time."""
    # Half of the memory where the offsets fit.
    kind = np.int32 if len(body) < np.iinfo(np.int32).max else np.int64
    parts, within_last = [], np.uint8(0)
    for start in range(0, len(body), _SPLIT_BYTES):
        part = body[start : start + _SPLIT_BYTES]
        marks = (part == delimiter) | (part == _LINE_END)
        if quoted:
            # An odd number of quotes so far: inside. Doubled quotes cancel out.
            within = np.bitwise_xor.accumulate((part == _QUOTE).view(np.uint8)) ^ within_last
            within_last = within[-1]
            marks &= ~within.view(bool)
        parts.append((np.flatnonzero(marks) + start).astype(kind))
    return np.concatenate(parts)


def _check_quotes(
    text: bytes,
    at: int,
    body: NDArray[np.uint8],
    delimiter: int,
    path: str,
) -> None:
    """Quotes open at the start of a cell and close at its end, or are doubled."""
    quotes = np.flatnonzero(body == _QUOTE)
    # Quotes alternate, as doubled ones close and open again.
    opening, closing = quotes[::2], quotes[1::2]
    edges = np.array([delimiter, _LINE_END], dtype=np.uint8)
    inside = [b for b in _BLANKS if b != delimiter]
    before = np.where(opening > 0, body[opening - 1], _LINE_END)
    after = body[np.minimum(closing + 1, len(body) - 1)]
    # Nearly all quotes are next to an edge: only the others are looked at one by one.
    loose = [
        int(quote)
        for neighbours, marks, step in ((before, opening, -1), (after, closing, 1))
        for quote in marks[~np.isin(neighbours, [*edges, _QUOTE])]
        if not _is_at_cell_edge(body, int(quote), step, inside, edges.tolist())
    ]
    if loose:
        raise Refused(_STRAY_QUOTE(path=path, **_line_at(text, at + min(loose))))
    if len(opening) > len(closing):
        raise Refused(_UNCLOSED_QUOTE(path=path, **_line_at(text, at + int(opening[-1]))))


def _is_at_cell_edge(
    body: NDArray[np.uint8], quote: int, step: int, blanks: list[int], edges: list[int]
) -> bool:
    """True if only blanks are between a quote and the edge of its cell."""
    at = quote + step
    while 0 <= at < len(body) and body[at] in blanks:
        at += step
    return not 0 <= at < len(body) or int(body[at]) in edges


def _trimmed_cells(
    body: NDArray[np.uint8],
    starts: Offsets,
    ends: Offsets,
    blanks: list[int],
) -> tuple[Offsets, Offsets]:
    """The cells without outer blanks."""
    blank = np.zeros(256, dtype=bool)
    blank[blanks] = True
    starts, ends, last = starts.copy(), ends.copy(), len(body) - 1
    # All cells at once, a blank a step; margins are narrow.
    for _ in range(_TRIM_STEPS):
        left = (starts < ends) & blank[body[np.minimum(starts, last)]]
        starts += left
        right = (starts < ends) & blank[body[ends - 1]]
        ends -= right
        if not (left.any() or right.any()):
            return starts, ends
    stripped = bytes(blanks)
    wide = np.flatnonzero(
        (starts < ends) & (blank[body[np.minimum(starts, last)]] | blank[body[ends - 1]])
    )
    for i in wide.tolist():  # the few cells with very wide margins
        cell = body[starts[i] : ends[i]].tobytes()
        starts[i] += len(cell) - len(cell.lstrip(stripped))
        ends[i] = starts[i] + len(cell.strip(stripped))
    return starts, ends


def _without_blank_lines(
    starts: Offsets,
    ends: Offsets,
    counts: Rows,
    width: int,
    text: bytes,
    path: str,
) -> tuple[Offsets, Offsets]:
    first = np.cumsum(counts) - counts
    # A blank line is one cell without content, whatever the width is.
    blank = (counts == 1) & (starts[first] == ends[first]) if len(counts) else counts == 1
    wrong = np.flatnonzero((counts != width) & ~blank)
    if len(wrong):
        row = int(wrong[0])
        of_row = slice(first[row], first[row] + counts[row])
        cells = [text[a:b] for a, b in zip(starts[of_row], ends[of_row], strict=True)]
        # All cells are digits: the commas are likely decimal ones.
        commas = counts[row] > width and all(re.fullmatch(rb"[+-]?\d+([eE]\d+)?", c) for c in cells)
        more = more_rows(wrong, lambda row: _line_at(text, int(starts[first[row]])))
        raise Refused(
            (_COMMA_ROW if commas else _RAGGED)(
                path=path,
                count=int(counts[row]),
                wanted=width,
                more=more,
                **_line_at(text, int(starts[first[row]])),
            )
        )
    if not blank.any():
        return starts, ends
    keep = np.repeat(~blank, counts)
    return starts[keep], ends[keep]


LEAST_PLAIN_BYTES: Final = 1 << 22
"""A shorter table is read by other means before polars would be imported."""
_forked: Final[list[bool]] = []
"""Filled in a fork: the threads of polars, which may have been at work before it, are not in it."""
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=lambda: _forked.append(True))


def plain_numbers(rows: bytes, delimiter: int, width: int) -> Floats | None:
    """The numbers (n, width) of rows below a header, in columns; None if they are not plain.

    Every cell has to be a plain decimal number, and every row as long as the header. Such a table
    is read by polars, where the extra `fast` is installed. rows: the text below the header, with a
    line feed behind each row. Each number is the double nearest to its text.
    """
    if len(rows) < LEAST_PLAIN_BYTES or _forked or find_spec("polars") is None:
        return None
    mark = bytes([delimiter])
    marks = rows.translate(None, _NUMERIC_BYTES.rstrip())
    count = len(marks) // width
    if not count or marks != (mark * (width - 1) + b"\n") * count:
        return None
    import polars

    # What polars cannot read is null.
    table = polars.read_csv(
        rows,
        has_header=False,
        separator=mark.decode(),
        schema={str(column): polars.Float64 for column in range(width)},
        ignore_errors=True,
        raise_if_empty=False,
    )
    if len(table) != count or any(column.null_count() for column in table):
        return None
    numbers = np.empty((count, width), order="F")
    for index, column in enumerate(table):
        numbers[:, index] = column.to_numpy()
    return numbers if np.isfinite(numbers).all() else None

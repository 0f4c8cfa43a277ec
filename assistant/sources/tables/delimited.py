"""Delimited text split into cells: delimiter, quotes, blank lines, line ends, encodings."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Rows
from assistant.base.diagnostics import Diagnostic, Refused, Severity, Span, Unreadable, error, info
from assistant.base.source_text import LINE_END_INSIDE, LINE_ENDS, SourceText, decode
from assistant.sources.tables.cells import BLANKS, Cells, Offsets, line_at, unescaped_cell

ERROR: Final = Severity.ERROR
NOT_TEXT = error("TB111", "the file holds zero bytes, it is no text", "export it as CSV")
NO_LINES = error("TB112", "the file holds nothing but blanks", "export or save it again")
NO_ROWS = error("TB113", "there is no row below the header", "export or save it again")
RAGGED = error(
    "TB114",
    "the row has {count} cells, the header {wanted}{more}",
    "give every row as many cells as the header, with nothing between delimiters for none",
)
COMMA_ROW = error(
    "TB115",
    "the row has {count} cells, the header {wanted}{more}; are these decimal commas?",
    "write decimal points, or save with `;` between the cells and decimal points",
)
STRAY_QUOTE = error(
    "TB116",
    "a quotation mark stands inside a cell",
    'put the whole cell in quotation marks and double those inside it: `"5"" pipe"`',
)
UNCLOSED_QUOTE = error(
    "TB117", "a quotation mark is never closed", "close it at the end of the cell"
)
EMPTY_ROWS = info("TB118", "{count} rows of empty cells are left out")

DELIMITERS: Final = b",;\t"
_QUOTE, _LINE_END = b'"'[0], b"\n"[0]
_TRIM_STEPS: Final = 16
_SPLIT_BYTES: Final = 1 << 19
"""Bytes split at a time, so that what is made of them stays in the processor's cache."""

HeaderCheck = Callable[[tuple[str, ...], Mapping[str, Any]], None]


def read_cells(data: bytes, path: str, check: HeaderCheck) -> Cells:
    """The cells of a delimited text; the delimiter is the one that the header uses.

    check: raises what is wrong with the header, before a row is looked at.
    Lines before the header that begin with `#` are comments; blank lines do not count.
    Raises Unreadable if it is no text, Refused for ragged rows or loose quotation marks.
    """
    text = _as_text(data, path)
    comments: list[str] = []
    at = 0
    while True:
        end = text.find(b"\n", at)
        if end < 0:
            rule = NO_ROWS if comments else NO_LINES
            raise Unreadable(rule(path=path))
        line = text[at:end].strip()
        if line.startswith(b"#"):
            comments.append(line.lstrip(b"# ").decode())
        elif line:
            break
        at = end + 1
    delimiter = _delimiter(text[at:end])
    starts, ends, counts = _split_cells(text, at, delimiter, path)
    width = int(counts[0])
    header = tuple(
        unescaped_cell(text[a:b]) for a, b in zip(starts[:width], ends[:width], strict=True)
    )
    header_line = text.count(b"\n", 0, at) + 1
    check(header, {"path": path, "line": header_line})
    starts, ends = _without_blank_lines(starts[width:], ends[width:], counts[1:], width, text, path)
    starts, ends = starts.reshape(-1, width), ends.reshape(-1, width)
    filled = (starts < ends).any(axis=1)
    findings: tuple[Diagnostic, ...] = ()
    if not filled.all():
        gone = np.flatnonzero(~filled)
        findings = (
            EMPTY_ROWS(path=path, count=len(gone), **line_at(text, int(starts[gone[0], 0]))),
        )
        starts, ends = starts[filled], ends[filled]
    if not len(starts):
        raise Refused(NO_ROWS(path=path, line=header_line))
    return Cells(text, path, header, tuple(comments), starts, ends, header_line, findings)


def _as_text(data: bytes, path: str) -> bytes:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        data = decode(data, path, ("utf-16",)).text.encode()
    if b"\0" in data:
        raise Unreadable(NOT_TEXT(path=path))
    if not data.isascii():
        data = decode(data, path, ("utf-8-sig", "utf-8", "cp1252")).text.encode()
    _check_returns(data, path)
    text = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in data else data
    return text if text.endswith(b"\n") else text + b"\n"


def _check_returns(data: bytes, path: str) -> None:
    """Raises Refused for a carriage return alone that is no row's end for some readers."""
    if b"\n" not in data or data.count(b"\r") == data.count(b"\r\n"):
        return
    quoted = False
    for mark in re.finditer(rb'"|\r(?!\r*\n|\Z)', data):
        if mark[0] == b'"':
            quoted = not quoted
        elif not quoted:
            at = len(data[: mark.start()].decode())
            source, character = SourceText(data.decode(), path), LINE_ENDS["\r"]
            raise Refused(source.finding(LINE_END_INSIDE, Span(at, at + 1), character=character))


def _delimiter(header: bytes) -> int:
    bare = re.sub(rb'"[^"]*"', b"", header)
    return max(DELIMITERS, key=lambda mark: bare.count(bytes([mark])))


def _split_cells(text: bytes, at: int, delimiter: int, path: str) -> tuple[Offsets, Offsets, Rows]:
    """Starts and ends of all cells from an offset on, and how many each line has."""
    body = np.frombuffer(text, dtype=np.uint8)[at:]
    quoted = bytes([_QUOTE]) in text
    if quoted:
        _check_quotes(text, at, body, delimiter, path)
    ends = _cell_edges(body, delimiter, quoted)
    starts = np.concatenate([np.zeros(1, ends.dtype), ends[:-1] + 1])
    counts = np.diff(np.flatnonzero(body[ends] == _LINE_END), prepend=-1)
    blanks = [b for b in BLANKS if b != delimiter]
    if any(bytes([b]) in text for b in blanks):
        starts, ends = _trimmed_cells(body, starts, ends, blanks)
    if quoted:
        outer = (ends > starts) & (body[np.minimum(starts, len(body) - 1)] == _QUOTE)
        starts, ends = _trimmed_cells(body, starts + outer, ends - outer, list(BLANKS))
    starts += at
    ends = ends + at
    return starts, ends, counts


def _cell_edges(body: NDArray[np.uint8], delimiter: int, quoted: bool) -> Offsets:
    """Offsets of the delimiters and line ends outside quotes, found a part at a time."""
    kind = np.int32 if len(body) < np.iinfo(np.int32).max else np.int64
    parts, within_last = [], np.uint8(0)
    for start in range(0, len(body), _SPLIT_BYTES):
        part = body[start : start + _SPLIT_BYTES]
        marks = (part == delimiter) | (part == _LINE_END)
        if quoted:
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
    opening, closing = quotes[::2], quotes[1::2]
    edges = np.array([delimiter, _LINE_END], dtype=np.uint8)
    inside = [b for b in BLANKS if b != delimiter]
    before = np.where(opening > 0, body[opening - 1], _LINE_END)
    after = body[np.minimum(closing + 1, len(body) - 1)]
    loose = [
        int(quote)
        for neighbours, marks, step in ((before, opening, -1), (after, closing, 1))
        for quote in marks[~np.isin(neighbours, [*edges, _QUOTE])]
        if not _is_at_cell_edge(body, int(quote), step, inside, edges.tolist())
    ]
    if loose:
        raise Refused(STRAY_QUOTE(path=path, **line_at(text, at + min(loose))))
    if len(opening) > len(closing):
        raise Refused(UNCLOSED_QUOTE(path=path, **line_at(text, at + int(opening[-1]))))


def _is_at_cell_edge(
    body: NDArray[np.uint8], quote: int, step: int, blanks: list[int], edges: list[int]
) -> bool:
    """Whether only blanks are between a quote and the edge of its cell."""
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
    blank = (counts == 1) & (starts[first] == ends[first]) if len(counts) else counts == 1
    wrong = np.flatnonzero((counts != width) & ~blank)
    if len(wrong):
        row = int(wrong[0])
        of_row = slice(first[row], first[row] + counts[row])
        cells = [text[a:b] for a, b in zip(starts[of_row], ends[of_row], strict=True)]
        commas = counts[row] > width and all(re.fullmatch(rb"[+-]?\d+([eE]\d+)?", c) for c in cells)
        more = f" ({len(wrong)} such rows)" if len(wrong) > 1 else ""
        raise Refused(
            (COMMA_ROW if commas else RAGGED)(
                path=path,
                count=int(counts[row]),
                wanted=width,
                more=more,
                **line_at(text, int(starts[first[row]])),
            )
        )
    if not blank.any():
        return starts, ends
    keep = np.repeat(~blank, counts)
    return starts[keep], ends[keep]

"""Tables of nothing but numbers, read by polars where the extra `fast` is installed.

Every cell of such a table is a plain decimal number. Anything else (text, an empty cell, a blank, a
quotation mark, a row of another length, a malformed number) leaves the table to `delimited_text`,
which finds the same numbers, and says what is wrong where.
"""

from __future__ import annotations

import os
from importlib.util import find_spec
from typing import Final

import numpy as np

from assistant.base.arrays import Floats

LEAST_BYTES: Final = 1 << 22
"""A shorter table is read by other means before polars would be imported."""
_DIGITS: Final = b"0123456789+-.eE"
_LINE_END: Final = b"\n"
_forked: Final[list[bool]] = []
"""Filled in a fork: the threads of polars, which may have been at work before it, are not in it."""
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=lambda: _forked.append(True))


def plain_numbers(rows: bytes, delimiter: int, width: int) -> Floats | None:
    """The numbers (n, width) of rows below a header, in columns; None if they are not plain.

    rows: the text below the header, with a line feed behind each row. Each number is the double
    nearest to its text.
    """
    if len(rows) < LEAST_BYTES or _forked or find_spec("polars") is None:
        return None
    mark = bytes([delimiter])
    marks = rows.translate(None, _DIGITS)
    count = len(marks) // width
    if not count or marks != (mark * (width - 1) + _LINE_END) * count:
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

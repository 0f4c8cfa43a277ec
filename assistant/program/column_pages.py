"""Columns of numbers as a notebook shows them: their range, and the first and last rows."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from assistant.program.visible import visible

MOST_SHOWN_ROWS: Final = 8
"""Rows of a table that are shown, half of them from its end."""
MOST_SHOWN_COLUMNS: Final = 40


def columns_html(told: str, columns: Mapping[str, ArrayLike]) -> str:
    """A table of columns (n,) or (n, k) by name, whose k columns are then numbered from 1.

    told: what stands above it. Names are shown as they are, never taken as markup.
    """
    single = dict(_single_columns(columns))
    some = dict(list(single.items())[:MOST_SHOWN_COLUMNS])
    count = max((len(column) for column in some.values()), default=0)
    shown = _shown_rows(count)
    head = "".join(f"<th>{html_text(name)}</th>" for name in some)
    body = "".join(
        f"<tr><td>{'…' if row is None else row}</td>"
        + "".join(
            f"<td>{'' if row is None else _number_html(column, row)}</td>"
            for column in some.values()
        )
        + "</tr>"
        for row in shown
    )
    ranges = "".join(f"<td>{_range_html(column)}</td>" for column in some.values())
    more = len(single) - len(some)
    rest = f"<p>and {more} more columns</p>" if more > 0 else ""
    table = f"<table><thead><tr><th></th>{head}</tr></thead><tbody>{body}"
    last = f"<tr><td><small>from … to</small></td>{ranges}</tr>" if count else ""
    return f"<div><p>{html_text(told)}</p>{table}{last}</tbody></table>{rest}</div>"


def html_text(given: str) -> str:
    """A text as a page shows it, on one line, nothing in it that a page obeys."""
    return escape(visible(given))


def _single_columns(columns: Mapping[str, ArrayLike]) -> list[tuple[str, NDArray[np.generic]]]:
    """Columns (n,), those of a wider one by number."""
    found: list[tuple[str, NDArray[np.generic]]] = []
    for name, given in columns.items():
        values = np.asarray(given)
        if values.ndim == 1:
            found.append((name, values))
        else:
            wide = values.reshape(len(values), -1)
            found += [(f"{name}.{i + 1}", column) for i, column in enumerate(wide.T)]
    return found


def _shown_rows(count: int) -> list[int | None]:
    if count <= MOST_SHOWN_ROWS:
        return list(range(count))
    half = MOST_SHOWN_ROWS // 2
    return [*range(half), None, *range(count - half, count)]


def _number_html(column: NDArray[np.generic], row: int) -> str:
    if row >= len(column):
        return ""
    value = column[row]
    return f"{value:.5g}" if np.issubdtype(column.dtype, np.floating) else html_text(str(value))


def _range_html(column: NDArray[np.generic]) -> str:
    if not np.issubdtype(column.dtype, np.number):
        return ""
    finite = column[np.isfinite(column)]
    return f"<small>{finite.min():.4g} … {finite.max():.4g}</small>" if len(finite) else ""

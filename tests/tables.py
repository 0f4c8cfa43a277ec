"""Tables of small cases that one test runs through: each case costs less than a test would."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final

import pytest

Case = Callable[..., None]
_LONGEST: Final = 300
"""Characters of a row that are shown if it fails."""


def every_row(
    names: str | tuple[str, ...], rows: Mapping[str, Any] | Iterable[Any]
) -> Callable[[Case], Case]:
    """Run a test for every row of a table, and report all rows that fail.

    It replaces `pytest.mark.parametrize` where a row costs little. names: the parameters that each
    row gives values to; the others are fixtures, which all rows share. rows: of a mapping the keys
    name the rows, which are its values.
    """
    single = isinstance(names, str)
    given = (names,) if isinstance(names, str) else names
    assert not (single and isinstance(rows, Mapping)), "write `list(rows)` or `rows.values()`"
    named = rows.items() if isinstance(rows, Mapping) else ((repr(row), row) for row in rows)
    table = [
        (name, dict(zip(given, (row,) if single else row, strict=True))) for name, row in named
    ]
    assert table, "a table without rows proves nothing"

    def decorate(test: Case) -> Case:
        signature = inspect.signature(test)

        def of_table(**fixtures: Any) -> None:
            faults = list[tuple[str, BaseException]]()
            for name, values in table:
                try:
                    test(**values, **fixtures)
                except (Exception, pytest.fail.Exception) as fault:  # noqa: BLE001 - is reported
                    faults.append((name, fault))
            if faults:
                raise AssertionError(_report(faults, len(table))) from faults[0][1]

        rest = [one for name, one in signature.parameters.items() if name not in given]
        of_table.__dict__.update(test.__dict__)  # the marks below
        of_table.__name__, of_table.__doc__ = test.__name__, test.__doc__
        of_table.__qualname__, of_table.__module__ = test.__qualname__, test.__module__
        of_table.__signature__ = signature.replace(parameters=rest)  # type: ignore[attr-defined]
        return of_table

    return decorate


def _report(faults: list[tuple[str, BaseException]], number: int) -> str:
    told = [f"{name[:_LONGEST]}\n    {type(fault).__name__}: {fault}" for name, fault in faults]
    return "\n".join((f"{len(told)} of {number} rows:", *told))

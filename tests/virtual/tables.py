"""Tests of tables: each case is tried, and those that fail are named."""

from __future__ import annotations

from collections.abc import Callable, Iterable


def failures(cases: Iterable[tuple[str, Callable[[], object]]]) -> list[str]:
    """Try each case; the names of those that fail, each with its error."""
    found = []
    for name, tried in cases:
        try:
            tried()
        except Exception as error:  # noqa: BLE001 - a crash is told with its case too
            found.append(f"{name}: {type(error).__name__}: {error}")
    return found

"""Tests of many cases in one."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any


def each(cases: Iterable[Any], check: Callable[..., None]) -> None:
    """Calls a check with each case, a tuple of its arguments or the only one; tells all faults."""
    wrong = []
    for case in cases:
        try:
            check(*case) if isinstance(case, tuple) else check(case)
        except AssertionError as fault:
            wrong.append(f"{case}: {fault}")
    assert not wrong, "\n".join(wrong)

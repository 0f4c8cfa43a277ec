"""The columns of a run, and what a notebook shows of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from assistant.base.arrays import Floats
from assistant.base.columns import columns_html


class RecordedSignals(Protocol):
    """seconds: (n,) of the steps. columns: (n, k) by the name of the signal."""

    @property
    def seconds(self) -> Floats: ...

    @property
    def columns(self) -> Mapping[str, Floats]: ...


def signals_html(ran: RecordedSignals) -> str:
    """Signals in columns, below what the run says of itself."""
    return columns_html(repr(ran)[1:-1], {"s": ran.seconds, **ran.columns})

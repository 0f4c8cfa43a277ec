"""The date and the time of day of a simulated clock."""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import Final

CLOCK_START: Final = datetime(2026, 1, 1)
"""A time of no place, so that a run always tells the same."""


def date_at(seconds: float, began: datetime = CLOCK_START) -> datetime:
    """The moment when a simulated clock that started at `began` shows so many seconds."""
    return began + timedelta(seconds=seconds)

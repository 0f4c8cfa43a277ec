"""`M_Timer(1)` … `M_Timer(8)`: milliseconds since each was set."""

from __future__ import annotations

from typing import Final

TIMER_WORD: Final = "M_Timer"
MOST_TIMERS: Final = 8
"""Their count is that of the older controllers; nothing tells of more."""
MILLISECONDS: Final = 1000
"""Of a second."""

"""Numbers of interrupts (COSIROP: DEF ACT, ACT)."""

from __future__ import annotations

from typing import Final

INTERRUPT_NUMBERS: Final = range(1, 9)
ALL_INTERRUPTS: Final = 0
"""By which `Act` lets all of them come, or none."""

"""One cycle of a program that MELFA-BASIC repeats by itself (MB263)."""

from __future__ import annotations

import re

LOOP = re.compile(r"(?im)^\d+ +While 1\s+(\d+ +(?:GoSub \*)?cycle(?:\(\))?)\s+\d+ +WEnd")


def one_cycle(text: str) -> str:
    """The text without the loop around its cycle, which then does what its source does in one."""
    return LOOP.sub(r"\1", text)

"""How a slot of a controller is at a moment."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SlotNow:
    """line: number of the line that comes next. step: its place, from 1.

    runs, waits: neither where its program is reset. ends_cycle: whether it stops at the end of the
    cycle. moves: whether it has the arm. is_task: whether it is none for editing.
    """

    program: str = ""
    line: int = 0
    step: int = 1
    mode: str = "REP"
    runs: bool = False
    waits: bool = False
    ends_cycle: bool = False
    moves: bool = False
    is_task: bool = True

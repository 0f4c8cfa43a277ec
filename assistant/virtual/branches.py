"""The ways that a program can go on at its decisions, told alike for every language."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

BranchKey = tuple[str, int, int]
"""A file, where a statement stands in it, and which way it goes on, as `Kernel.branch` is told."""


@dataclass(frozen=True, slots=True)
class Branch:
    """One way. file, line: of its statement. said: the word of the statement and what it finds."""

    file: str
    line: int
    said: str


Branches = Mapping[BranchKey, Branch]
"""Those that a run can go. Of a condition that is a constant there are none."""

"""Inputs by which a person answers questions, where a cell has keys instead of a dialog.

A key counts from when it is pressed anew, and so does what tells that a number is there: what a
program of inputs alone does for the same questions (`passes.asking`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from assistant.program.passes.operator_texts import ENTERED, KEY, NUMBER

if TYPE_CHECKING:
    from assistant.virtual.kernel.task import Task


@dataclass(frozen=True, slots=True)
class Panel:
    """read: what an input is now, by its name."""

    read: Callable[[str], float]

    def key(self, task: Task, keys: Sequence[int]) -> int:
        """Waits for one of some keys, counted from 1: the first one that is pressed."""
        names = {key: KEY.format(key) for key in keys}
        task.wait(lambda: all(self.read(n) == 0.0 for n in names.values()), what="keys let go")
        while True:
            task.wait(lambda: any(self.read(n) == 1.0 for n in names.values()), what="a key")
            for key, name in names.items():
                if self.read(name) == 1.0:
                    return key

    def number(self, task: Task) -> float:
        """Waits for a number that is entered."""
        task.wait(lambda: self.read(ENTERED) == 0.0, what="the end of the number before")
        task.wait(lambda: self.read(ENTERED) == 1.0, what="a number")
        return self.read(NUMBER)

"""What is to happen at times of the clock, in their order."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count


@dataclass(slots=True, order=True)
class Timer:
    """An action at a time; it is left out if it is cancelled by then."""

    time: float
    number: int
    action: Callable[[], None] = field(compare=False)
    cancelled: bool = field(default=False, compare=False)


class Timers:
    """due: the time of the first one, infinite where there is none."""

    def __init__(self) -> None:
        self.due = math.inf
        self._heap: list[Timer] = []
        self._numbers = count()

    def add(self, moment: float, action: Callable[[], None]) -> Timer:
        timer = Timer(moment, next(self._numbers), action)
        heapq.heappush(self._heap, timer)
        self.due = self._heap[0].time
        return timer

    def fire(self, clock: float) -> None:
        """Has those act whose time has come."""
        while self._heap and self._heap[0].time <= clock:
            timer = heapq.heappop(self._heap)
            if not timer.cancelled:
                timer.action()
        self.due = self._heap[0].time if self._heap else math.inf

"""What is done one after the other on the way that a page plays."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import takewhile

from assistant.robots.timing import Simulation
from assistant.robots.timing.plan import Plan
from assistant.robots.timing.segments import History
from assistant.robots.timing.uninterrupted_moves import MovesWithoutStop


def motion_stages(simulation: Simulation, until: float) -> Iterator[tuple[float, MovesWithoutStop]]:
    """Stretches of moves with the seconds at which each begins, those of a loop in each round.

    until: seconds; those that begin later are left out.
    """
    by_plan = {id(passed.plan): passed for passed in reversed(simulation.passed)}
    played = takewhile(lambda one: one[0] <= until, _stage_plans(simulation.history, 0.0))
    for start, plan in played:
        passed = by_plan.get(id(plan))
        if passed is not None:
            yield start, passed


def _stage_plans(history: History | None, start: float) -> Iterator[tuple[float, Plan]]:
    for node in () if history is None else history.chain():
        if isinstance(node.done, Plan):
            yield start + node.start, node.done
        elif isinstance(node.done, tuple):
            inner, count = node.done
            for i in range(count if inner.last is not None else 0):
                yield from _stage_plans(inner, start + node.start + i * inner.seconds)

"""When outputs are set that moves set on their way."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, norms
from assistant.program.expressions import Expression, Number
from assistant.program.pseudo.expressions import expression_text
from assistant.program.statements import Trigger
from assistant.robots.timing.plan import Plan

TIME_PARTS: Final = 400
"""Parts of the time of a move between which its way is measured."""


@dataclass(frozen=True, slots=True)
class OutputTime:
    """An output that a move sets on its way.

    number: of the motion statement in its procedure, from 1. value: as text. seconds: after the
    move begins.
    """

    procedure: str
    number: int
    signal: str
    value: str
    seconds: float


def output_times(
    plan: Plan, rows: slice, triggers: tuple[Trigger, ...], procedure: str, number: int
) -> Iterator[OutputTime]:
    """Of the move that is some rows of a plan; places that are worked out are left out."""
    times = np.concatenate([[0.0], np.cumsum(plan.profile.seconds)])
    begin, end = float(times[rows.start]), float(times[rows.stop])
    at = np.linspace(begin, end, TIME_PARTS + 1)
    steps = norms(np.diff(plan.at(at).positions, axis=0))
    done: Floats = np.concatenate([[0.0], np.cumsum(steps)])
    for one in triggers:
        amount, ahead = (
            _number_value(one.amount),
            0.0 if one.ahead is None else _number_value(one.ahead),
        )
        if amount is None or ahead is None:
            continue
        if one.measure == "time":
            seconds = end - amount
        else:
            whole = float(done[-1])
            way = {"start": amount, "end": whole - amount, "share": whole * amount / 100.0}
            seconds = float(np.interp(way[one.measure], done, at))
        after = min(max(seconds - ahead - begin, 0.0), end - begin)
        yield OutputTime(procedure, number, one.signal, expression_text(one.value), after)


def _number_value(value: Expression) -> float | None:
    return float(value.value) if isinstance(value, Number) else None

r"""Waits with a longest time whose end is a flag (`\MaxTime`, `\TimeFlag`): as loops by a timer."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from assistant.languages.patterns import Called
from assistant.languages.rapid.lift.instructions import Meaning, of_call
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.rewriting import is_repeatable, records

TIMER: Final = "wait_time"
"""The timer of all of them: no such wait begins in another one."""


def limited(call: Called[s.Expression], meaning: Meaning) -> Iterator[p.Statement]:
    """One that tells by a flag whether its time was over."""
    options = dict(call.options)
    flag = options.pop("timeflag", None)
    wait = of_call(Called(call.word, call.given, options), meaning) if flag is not None else None
    if flag is None or not isinstance(wait, p.WaitSignal | p.WaitUntil) or wait.timeout is None:
        return
    over = meaning.expression(flag)
    if isinstance(over, e.Name | e.Index) and is_repeatable(condition(wait)):
        if over not in records(condition(wait)):
            yield from until_over(wait, over)


def condition(wait: p.WaitSignal | p.WaitUntil) -> e.Expression:
    """What is waited for."""
    if isinstance(wait, p.WaitUntil):
        return wait.condition
    return e.Binary("=", e.Name(wait.signal), wait.value)


def until_over(wait: p.WaitSignal | p.WaitUntil, over: e.Expression) -> Iterator[p.Statement]:
    """A wait with a longest time, behind which `over` tells whether that has passed.

    It is asked before the time, so that no time is enough for what holds already.
    """
    assert wait.timeout is not None
    asked = p.Assign(over, e.Unary("not", condition(wait)))
    goes_on = e.Binary("and", over, e.Binary("<", e.Elapsed(TIMER), wait.timeout))
    yield asked
    yield p.StartTimer(TIMER)
    yield p.While(goes_on, (asked,))

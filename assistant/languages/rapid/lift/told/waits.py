r"""Waits with a longest time whose end is a flag (`\MaxTime`, `\TimeFlag`): as loops by a timer."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from assistant.languages.patterns import Called
from assistant.languages.rapid.lift.instructions import NameResolver, lift_call
from assistant.languages.rapid.lift.told.calls import is_by_gateway
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import called
from assistant.program.program import Program, walk
from assistant.program.rewriting import is_repeatable, records

WAIT_TIMER: Final = "wait_time"
"""The timer of all of them: no such wait begins in another one."""


def flagged_wait(
    call: Called[s.Expression], meaning: NameResolver, program: Program
) -> Iterator[p.Statement]:
    """One that tells by a flag whether its time was over."""
    options = dict(call.options)
    flag = options.pop("timeflag", None)
    wait = lift_call(Called(call.word, call.given, options), meaning) if flag is not None else None
    if flag is None or not isinstance(wait, p.WaitSignal | p.WaitUntil) or wait.timeout is None:
        return
    over = meaning.expression(flag)
    if isinstance(over, e.Name | e.Index) and _is_free_of_effects(wait_condition(wait), program):
        if over not in records(wait_condition(wait)):
            yield from wait_until_over(wait, over)


def _is_free_of_effects(asked: e.Expression, program: Program) -> bool:
    """Whether it does not matter how often it is worked out while the program waits for it.

    How often functions of the user's are called is the controller's own; they may do no more than
    give values to variables, end the program, and ask a gateway how many bytes it has.
    """
    if is_repeatable(asked):
        return True
    known = {q.name.lower(): q for q in program.procedures}
    parts = [*records(asked)]
    pending = [x.function.lower() for x in parts if isinstance(x, e.Apply)]
    if any(isinstance(x, e.Verbatim) for x in parts) or set(pending) & set(e.TAKING):
        return False
    seen = set[str]()
    while pending:
        key = pending.pop()
        if key in seen or key not in known:
            if key not in seen and key not in e.FUNCTIONS:
                return False
            continue
        seen.add(key)
        if not all(
            isinstance(node, _QUIET_STATEMENTS) or _ends_program(node) or is_by_gateway(node)
            for node in walk(known[key].body)
        ):
            return False
        pending += called(known[key])
    return True


_QUIET_STATEMENTS: Final = (p.Assign, p.Call, p.Comment, p.If, p.For, p.While, p.Switch, p.Return)
"""Statements that give values to variables alone, and lead to them."""


def _ends_program(node: p.Statement) -> bool:
    """True if it ends the program, which it does once."""
    return isinstance(node, p.Stop) and node.end


def wait_condition(wait: p.WaitSignal | p.WaitUntil) -> e.Expression:
    """What is waited for."""
    if isinstance(wait, p.WaitUntil):
        return wait.condition
    return e.Binary("=", e.Name(wait.signal), wait.value)


def wait_until_over(wait: p.WaitSignal | p.WaitUntil, over: e.Expression) -> Iterator[p.Statement]:
    """A wait with a longest time, behind which `over` tells whether that has passed.

    It is asked before the time, so that no time is enough for what holds already.
    """
    assert wait.timeout is not None
    asked = p.Assign(over, e.Unary("not", wait_condition(wait)))
    goes_on = e.Binary("and", over, e.Binary("<", e.Elapsed(WAIT_TIMER), wait.timeout))
    yield asked
    yield p.StartTimer(WAIT_TIMER)
    yield p.While(goes_on, (asked,))

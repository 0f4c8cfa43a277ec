"""Signals, waits and settings of the cell as lines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from assistant.languages.melfa_basic.lower.expressions import Unsayable, signed_number
from assistant.languages.melfa_basic.tables.statements import STATEMENT_ROWS
from assistant.languages.melfa_basic.tables.vocabulary import timers
from assistant.languages.melfa_basic.tables.vocabulary.timers import MOST_TIMERS
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.jumping import is_plain_wait, waiting_loop
from assistant.languages.melfa_basic.tree.timers import timer_variable
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.languages.patterns import Write, Writing
from assistant.program import expressions as e
from assistant.program import statements as p

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lower.writer import Writer

TIMEOUT_ERROR: Final = 9100
"""The error that a wait ends with when its time is over: the program stops, as RAPID's does."""
MOST_HANDS: Final = 8


def write_row(w: Writer, node: p.Statement) -> None:
    """A statement that is a row of `tables.statements`."""
    writers: dict[str, Write[s.Expression]] = {
        "value": lambda value, _: w.expressions.of(value),
        "hand": lambda number, _: hand_number(number),
    }
    writing: Writing[s.Expression] = Writing(writers)
    called = STATEMENT_ROWS.write(node, writing)
    if called is None:
        raise Unsayable(f"such a {type(node).__name__}", "say it otherwise")
    w.add(s.Command(called.word, tuple(called.given)))


def hand_number(number: int) -> s.Number:
    if not 1 <= number <= MOST_HANDS:
        raise Unsayable(f"hand {number}", f"use hands 1 to {MOST_HANDS}")
    return s.Number(number)


def write_signal_wait(w: Writer, node: p.WaitSignal) -> None:
    condition = s.Binary("=", w.expressions.name(node.signal), w.expressions.of(node.value))
    _write_wait_for(w, condition, node.timeout)


def write_wait(w: Writer, node: p.WaitUntil) -> None:
    _write_wait_for(w, w.expressions.of(node.condition), node.timeout)


def _write_wait_for(w: Writer, condition: s.Expression, timeout: e.Expression | None) -> None:
    if timeout is not None:
        _write_limited_wait(w, condition, timeout)
        return
    if w.dialect.wide_wait or is_plain_wait(condition):
        w.add(s.Command("Wait", (condition,)))
    else:
        w.items += waiting_loop(w.made_label("W"), condition, s.Line())


def _write_limited_wait(w: Writer, condition: s.Expression, timeout: e.Expression) -> None:
    """A wait that ends with an error when its time is over."""
    if not w.names.wait_timer:
        raise Unsayable(f"a time limit beside {MOST_TIMERS} timers", "use fewer timers")
    passed = timer_variable(w.expressions.word(timers.TIMER_WORD), w.names.wait_timer)
    limit = _milliseconds(w, timeout)
    label = w.made_label("W")
    w.add(s.Assign(passed, s.Number(0)))
    w.items.append(s.Line(label=label))
    w.add(s.If(condition, s.Target(label + "Z")))
    w.add(s.If(s.Binary("<", passed, limit), s.Target(label)))
    w.add(s.Command("Error", (s.Number(TIMEOUT_ERROR),)))
    w.items.append(s.Line(label=label + "Z"))


def _milliseconds(w: Writer, seconds: e.Expression) -> s.Expression:
    number = e.plain_number(seconds)
    if number is not None and number < 0:
        raise Unsayable(f"a time limit of {number:g} seconds", "give a positive one")
    if number is not None:
        return signed_number(round(number * timers.MILLISECONDS, 6))
    return s.Binary("*", w.expressions.of(seconds), s.Number(timers.MILLISECONDS))


def write_timer_start(w: Writer, node: p.StartTimer) -> None:
    w.add(s.Assign(w.expressions.timer(node.timer), s.Number(0)))


def write_signal(w: Writer, node: p.SetSignal) -> None:
    pulse = None if node.pulse is None else w.expressions.of(node.pulse)
    w.add(output_assignment(w, node, pulse))


def output_assignment(
    w: Writer, one: p.SetSignal | p.Trigger, pulse: s.Expression | None = None
) -> s.Assign:
    """What gives an output its value."""
    target, value = w.expressions.output(one.signal, w.expressions.of(one.value))
    if pulse is not None and any(x == target for x in nodes(value)):
        raise Unsayable(
            f"a pulse of `{one.signal}`, a group beside other bits of its byte",
            "set it, wait and set it back",
        )
    return s.Assign(target, value, pulse)

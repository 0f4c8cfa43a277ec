"""Timers that the lines of a file set to zero and read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from assistant.languages.melfa_basic.tables.vocabulary.timers import MILLISECONDS, MOST_TIMERS
from assistant.languages.melfa_basic.text.header import Header
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.timers import timer_number
from assistant.languages.melfa_basic.tree.walk import literal, nodes
from assistant.program import expressions as e


def file_timers(code: Sequence[s.Entry], header: Header, own: bool) -> dict[int, str]:
    """Names of the timers, by number, that are set to zero and read in values and conditions.

    Any other use of a timer, such as in an interrupt or another value, keeps all its lines as
    they are. One that a wait with a time limit has made for itself is no timer of the program.
    """
    if own:
        return {int(k): name for k, name in header.names["timer"].items() if k.isdigit()}
    started: set[int] = set()
    other: set[int] = set()
    for at, item in enumerate(code):
        numbers = map(timer_number, nodes(item.statement))
        mentioned = [n for n in numbers if n is not None]
        if not mentioned:
            continue
        if 0 in mentioned:  # any timer
            return {}
        plain = list(_statement_timers(item.statement))
        of_wait = at + 1 < len(code) and _is_waiting_line(code[at + 1])
        started.update(n for n, starts in plain if starts and not of_wait)
        if of_wait or sorted(mentioned) != sorted(n for n, _ in plain):
            other.update(mentioned)
    return {n: f"timer_{n}" for n in sorted(started - other) if n <= MOST_TIMERS}


def _is_waiting_line(line: s.Entry) -> bool:
    return line.label is not None and line.label[:1] == "W" and line.label[1:].isdigit()


def _statement_timers(statement: Any) -> Iterator[tuple[int, bool]]:
    """Timers of a statement where the pseudo-program has them, and whether it starts them."""
    match statement:
        case s.Assign(target=target, value=value, delay=None) if n := timer_number(target):
            if literal(value) == 0:
                yield n, True
        case s.Assign(value=value):
            yield from _timers_read(value)
        case s.If(condition=condition, then=then, otherwise=otherwise):
            yield from _timers_read(condition)
            yield from _statement_timers(then)
            yield from _statement_timers(otherwise)
        case s.ElseIf(condition=value):
            yield from _timers_read(value)
        case s.Command(keyword="While" | "Wait" | "Dly", arguments=(value,)):
            yield from _timers_read(value)


def _timers_read(value: Any) -> Iterator[tuple[int, bool]]:
    for node in nodes(value):
        if number := timer_number(node):
            yield number, False


def elapsed_timer(node: s.Expression, timers: Mapping[int, str]) -> e.Elapsed | None:
    """The timer that a node reads."""
    name = timers.get(timer_number(node) or 0)
    return None if name is None else e.Elapsed(name)


def seconds_of(milliseconds: float) -> e.Number:
    return e.number_of(milliseconds / MILLISECONDS)

"""Waits that are written with jumps, and the small things that every statement has."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final, TypeVar

from assistant.base.diagnostics import Span
from assistant.languages.melfa_basic.lift.structure.blocks import Code
from assistant.languages.melfa_basic.lift.values.expressions import Expressions
from assistant.languages.melfa_basic.lift.values.symbols import Unliftable
from assistant.languages.melfa_basic.lift.values.timers import seconds_of
from assistant.languages.melfa_basic.tree import jumping
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.timers import timer_number
from assistant.program import expressions as e
from assistant.program import statements as p

T = TypeVar("T", bound=p.Spanned)

TIMEOUT_ERROR: Final = 9100
"""The error of a wait that took too long."""


def with_span(statement: T, span: Span | None) -> T:
    """The statement as one that stood there, if it does not know where it stood."""
    return statement if statement.span is not None else replace(statement, span=span)


def comment_text(comment: str) -> str:
    """A comment without its mark and outer blanks."""
    return comment[1:].strip() if comment.startswith("'") else comment[3:].strip()


def wait_at(
    code: Code, at: int, high: int, lift: Expressions, named: Mapping[str, int]
) -> tuple[p.Statement, int] | None:
    """A wait that begins at a line, and the line after it; None for anything else.

    named: how often jumps name each label, in upper case. Another one that leads there needs it.
    """
    if not isinstance(first := code[at], s.Line) or not _may_wait(first):
        return None
    for count, wait in ((6, _timed_wait), (3, _endless_wait)):
        lines = code[at : min(at + count, high)]
        if any(line.comment is not None for line in lines):
            continue  # a comment among them has its place
        labels = [line.label.upper() for line in lines if line.label is not None]
        if any(named[label] != 1 for label in labels):
            continue
        try:
            made = wait(lines, lift)
        except Unliftable:
            continue
        if made is not None:
            return made, at + count
    return None


def _may_wait(line: s.Line) -> bool:
    timer = isinstance(line.statement, s.Assign) and timer_number(line.statement.target) is not None
    return timer or (line.label is not None and bool(jumping.WAIT_LABEL.fullmatch(line.label)))


def _endless_wait(lines: Sequence[object], lift: Expressions) -> p.Statement | None:
    found = jumping.read_waiting_loop(lines)
    return None if found is None else wait_for(found[1], lift)


def _timed_wait(lines: Sequence[object], lift: Expressions) -> p.Statement | None:
    """`M_TIMER(1)=0`, `*W1`, `If condition Then *W1Z`, `If M_TIMER(1)<ms Then *W1`,
    `Error 9100`, `*W1Z`.
    """
    match lines:
        case (
            s.Line(label=None, statement=s.Assign(timer, s.Number(0), None)),
            s.Line(label=str() as name, statement=None),
            s.Line(label=None, statement=s.If(condition, s.Target(place=out), None)),
            s.Line(
                label=None,
                statement=s.If(s.Binary("<", clock, most), s.Target(place=again), None),
            ),
            s.Line(label=None, statement=s.Command("Error", (s.Number(number),))),
            s.Line(label=str() as last, statement=None),
        ) if (
            jumping.WAIT_LABEL.fullmatch(name)
            and again == name
            and out == last == name + "Z"
            and number == TIMEOUT_ERROR
            and timer_number(timer)
            and timer_number(timer) == timer_number(clock)
        ):
            return wait_for(condition, lift, _timeout_seconds(most, lift))
    return None


def _timeout_seconds(milliseconds: s.Expression, lift: Expressions) -> e.Expression:
    match milliseconds:
        case s.Number(value=value):
            return seconds_of(value)
        case s.Binary("*", left, s.Number(1000)):
            return lift.plain(left)
    raise Unliftable


def wait_for(
    condition: s.Expression, lift: Expressions, timeout: e.Expression | None = None
) -> p.Statement:
    """Until a signal has a value, or until any other condition holds."""
    held = lift.condition(condition)
    match held:
        case e.Binary("=", e.Name(name), e.Number() as value) if (
            name in lift.m.signals and lift.m.signals[name].kind != "analog"
        ):
            return p.WaitSignal(name, value, timeout)
    return p.WaitUntil(held, timeout)

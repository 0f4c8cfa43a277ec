"""Steps numbered anew, with every jump to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.tables.dialects import LAST_STEP
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.targets import (
    retargeted,
    steps_named,
    steps_of,
    with_steps,
)
from assistant.languages.runs.names import rows_of
from assistant.program.diagnostics import Diagnostic, Refused, Rule

Steps = NDArray[np.int64]
UNNUMBERED = 0
"""Stands for the number of a step that has none."""
EMPTY = "'"
"""The step that a blank line between others becomes: a bare one would end the program."""


def renumbered(file: s.File, first: int, step: int) -> s.File:
    """The program with its steps numbered first, first + step …, jumps to them included.

    Lines without a number get one, but for variable lines; so does a program without any.
    Raises Refused where a jump has no destination, where numbers do not ascend (which of two
    lines comes first is open then), or where the last number would be too high.
    """
    items = _all_steps(file.items)
    old = _numbers(items)
    new = first + step * np.arange(len(old), dtype=np.int64)
    findings = [*_order(file, items), *_range(file, new, first, step)]
    known = np.flatnonzero(old != UNNUMBERED)
    places = {int(number): int(new[at]) for number, at in _jumped_to(items, old, known)}

    def moved(place: str | int) -> str | int:
        return places.get(place, place) if isinstance(place, int) else place

    made: list[s.Item] = []
    at = 0
    for item in items:
        steps = new[at : at + len(steps_of(item))]
        at += len(steps)
        if len(steps):
            findings += _lost(file, item, places)
            item = with_steps(retargeted(item, moved), steps)
        made.append(item)
    if findings:
        raise Refused(*findings)
    kept = len(made) == len(file.items) and all(
        a is b for a, b in zip(made, file.items, strict=True)
    )
    return file if kept else replace(file, items=tuple(made))


# Which lines are steps


def _all_steps(items: Sequence[s.Item]) -> tuple[s.Item, ...]:
    """The items with every line that is to be a step marked as one, blank lines included."""
    numbered = [len(steps_of(item)) > 0 for item in items]
    code = [at for at, item in enumerate(items) if isinstance(item, s.Entry)]
    last = code[-1] if code and not any(numbered) else -1
    made: list[s.Item] = []
    for at, item in enumerate(items):
        if isinstance(item, s.Blank) and at < last:
            item = s.Line(UNNUMBERED, comment=EMPTY)
        elif isinstance(item, s.Line) and item.number is None:
            if not (any(numbered) and _looks_like_data(item)):
                item = replace(item, number=UNNUMBERED)
        made.append(item)
    return tuple(made)


def _looks_like_data(item: s.Line) -> bool:
    """Whether an unnumbered line is a variable line that somebody put a comment behind."""
    match item.statement:
        case s.Assign(value=s.Constant() | s.Number() | s.String() | s.Unary(operand=s.Number())):
            return item.label is None
    return False


# Numbers


def _numbers(items: Sequence[s.Item]) -> Steps:
    return np.concatenate([np.empty(0, dtype=np.int64), *map(steps_of, items)])


def _order(file: s.File, items: Sequence[s.Item]) -> list[Diagnostic]:
    """A finding for each line or table whose first number does not follow the one before it."""
    before, found = 0, []
    for item in items:
        if not isinstance(item, s.Entry) or (isinstance(item, s.Line) and not item.number):
            continue
        steps = np.concatenate([[before], steps_of(item)])
        falls = np.flatnonzero(np.diff(steps) <= 0)
        if len(falls):
            number, last = int(steps[falls[0] + 1]), int(steps[falls[0]])
            found.append(_finding(file, item, rules.NOT_ASCENDING, number=number, before=last))
        before = int(steps[-1])
    return found


def _range(file: s.File, new: Steps, first: int, step: int) -> list[Diagnostic]:
    if not len(new) or new[-1] <= LAST_STEP:
        return []
    path = file.source.path if file.source else None
    finding = rules.PAST_LAST_STEP(
        path=path, count=len(new), first=first, step=step, last=int(new[-1]), most=LAST_STEP
    )
    return [finding]


def _jumped_to(items: Sequence[s.Item], old: Steps, known: Steps) -> list[tuple[int, int]]:
    """Each number that a jump names, with the place of its line; few of many lines are named."""
    named = steps_named(items)
    if not named or not len(known):
        return []
    wanted = np.array(sorted(named), dtype=np.int64)
    places = rows_of(old[known], wanted)
    return [(n, int(known[p])) for n, p in zip(wanted.tolist(), places, strict=True) if p >= 0]


def _lost(file: s.File, item: s.Item, places: dict[int, int]) -> list[Diagnostic]:
    lost = sorted(steps_named([item]) - places.keys())
    return [_finding(file, item, rules.NO_STEP, name=number) for number in lost]


def _finding(file: s.File, item: s.Item, rule: Rule, **fields: Any) -> Diagnostic:
    if file.source is None or item.span is None:
        return rule(**fields)
    return file.source.finding(rule, item.span, **fields)

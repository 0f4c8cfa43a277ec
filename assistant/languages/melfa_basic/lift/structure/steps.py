"""Jumps to step numbers as jumps to labels, so that one mechanism reads both."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from assistant.languages.melfa_basic.lift.structure.blocks import Code, Entry
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.languages.melfa_basic.tree.line_tables import cut
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.program.rewriting import rewrite

_JUMPING = (s.Jump, s.If, s.OnJump, s.DefAct, s.OnCom)


def with_labels(code: Code) -> list[Entry]:
    """The same code with a label above every step that a jump names by its number."""
    wanted = {
        part.place
        for item in code
        if isinstance(item, s.Line) and isinstance(item.statement, _JUMPING)
        for part in nodes(item.statement)
        if isinstance(part, s.Target) and isinstance(part.place, int)
    }
    if not wanted:
        return list(code)
    taken = {item.label.upper() for item in code if isinstance(item, s.Line) and item.label}
    names = {step: _free(step, taken) for step in sorted(wanted)}
    found: set[int] = set()
    made: list[Entry] = []
    for item in code:
        if isinstance(item, MoveRows):
            made += _divided(item, names, found)
            continue
        if item.number in names and item.number not in found:
            found.add(item.number)
            made.append(s.Line(label=names[item.number], span=item.span))
        made.append(item)
    return [_renamed(item, {step: names[step] for step in found}) for item in made]


def _free(step: int, taken: set[str]) -> str:
    name = f"L{step}"
    while name in taken:
        name += "A"
    taken.add(name)
    return name


def _divided(rows: MoveRows, names: dict[int, str], found: set[int]) -> list[Entry]:
    at = np.flatnonzero(np.isin(rows.steps, list(names)))
    edges = [0, *at.tolist(), len(rows)]
    made: list[Entry] = []
    for low, high in itertools.pairwise(edges):
        if high > low:
            made.append(cut(rows, low, high))
        if high < len(rows):
            step = int(rows.steps[high])
            found.add(step)
            made.append(s.Line(label=names[step]))
    return made


def _renamed(item: Entry, names: dict[int, str]) -> Entry:
    if not isinstance(item, s.Line) or not isinstance(item.statement, _JUMPING):
        return item
    visit: Callable[[Any], Any] = lambda x: (  # noqa: E731
        s.Target(names[x.place]) if isinstance(x, s.Target) and x.place in names else x
    )
    return replace(item, statement=rewrite(item.statement, visit))

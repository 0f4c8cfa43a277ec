"""Whether a converted program says the same: both sides lifted, in one spelling."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.melfa_basic.convert import comments, names, original_names, steps, words
from assistant.languages.melfa_basic.convert.conversion import convert
from assistant.languages.melfa_basic.convert.original_names import Memory
from assistant.languages.melfa_basic.lift.files.program import lift, stem
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.targets import labelled, labels_of
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.comparison import Tolerance, compare
from assistant.program.program import Program
from assistant.program.rewriting import rewrite

if TYPE_CHECKING:
    from assistant.robots import Robot


def compared(
    before: Sequence[s.File], after: Sequence[s.File], robot: Robot | None
) -> tuple[Program, Program]:
    """The pseudo-programs of both, which must be the same.

    A form that a lift reads in one dialect only is compared in the first one: the program is
    converted back.
    """
    expected, actual = lifted(before, after, robot)
    if compare(expected, actual, ROUNDING).same or not before:
        return expected, actual
    back = convert(after, before[0].dialect)
    if not back.trees:
        return expected, actual
    found = lifted(before, back.trees, robot)
    return found if compare(*found, ROUNDING).same else (expected, actual)


ROUNDING: Final = Tolerance(1e-9, 1e-9, 0.0)
"""Of the comparison itself: numbers are not computed anew."""


def lifted(
    before: Sequence[s.File], after: Sequence[s.File], robot: Robot | None
) -> tuple[Program, Program]:
    """The pseudo-programs of both, in the words that they share; one if these are the same."""
    lowest = min(DIALECTS[tree.dialect].level for tree in (*before, *after))
    one, two = ([_plain(tree, lowest) for tree in trees] for trees in (before, after))
    said = _lifted(one, robot)
    return said, said if _text(one) == _text(two) else _lifted(two, robot)


def _text(trees: Sequence[s.File]) -> list[tuple[str | None, tuple[s.Item, ...]]]:
    """What is lifted of trees, whatever dialect they are in."""
    return [(stem(tree), tree.items) for tree in trees]


def _lifted(trees: Sequence[s.File], robot: Robot | None) -> Program:
    program: Program = rewrite(lift(trees, robot, divide=False), _without_dialect)
    return program


def _plain(tree: s.File, lowest: int) -> s.File:
    items, memory = original_names.taken_out(tree.items)
    items, made = labelled(steps.apart(items))
    jumped = {label.upper() for label in made} | set(memory.steps)
    order = (label for label in labels_of(items) if label in jumped)
    numbers = {label: f"ATSTEP{n}" for n, label in enumerate(order)}
    if lowest == 4 and DIALECTS[tree.dialect].level > 4:
        lower = DIALECTS["melfa-basic-4"]
        items = words.Words(lower, Memory(), _silent).lines(comments.fitted(items, lower))
    table = names.Names(
        *({k: v.upper() for k, v in getattr(memory, kind).items()} for kind in names.KINDS)
    )
    table.labelled |= numbers
    items = original_names.renamed(names.renamed(items, table, upper=True), table.named)
    return replace(tree, items=tuple(items), parsed=())


def _silent(item: s.Item, what: str, cure: str) -> None:
    """What cannot be said was found before."""


def _without_dialect(part: Any) -> Any:
    if isinstance(part, p.Opaque | e.Verbatim):
        return replace(part, language="", text=_upper(part.text))
    return part


_STRING: Final = re.compile(r'("[^"]*")')


def _upper(text: str) -> str:
    """In upper case outside of strings."""
    return "".join(t if t.startswith('"') else t.upper() for t in _STRING.split(text))

"""Steps numbered anew, with every jump to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from assistant.languages import step_numbers
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.tables.dialects import LAST_STEP
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.targets import retargeted, steps_named
from assistant.languages.step_numbers import UNNUMBERED, Steps, steps_of

EMPTY_STEP: Final = "'"
"""The step that a blank line between others becomes: a bare one would end the program."""

STEPS: Final = Steps(
    s.Line,
    LAST_STEP,
    named=steps_named,
    retargeted=retargeted,
    falling=rules.NOT_ASCENDING,
    past_last=rules.PAST_LAST_STEP,
    unknown=rules.NO_STEP,
)


def renumbered(file: s.File, first: int, step: int) -> s.File:
    """The program with its steps numbered first, first + step …, jumps to them included.

    Lines without a number get one, but for variable lines; so does a program without any.
    Raises Refused where that cannot be done.
    """
    made = step_numbers.renumbered(_all_steps(file.items), first, step, STEPS, file.source)
    kept = len(made) == len(file.items) and all(
        a is b for a, b in zip(made, file.items, strict=True)
    )
    return file if kept else replace(file, items=tuple(made))


def _all_steps(items: Sequence[s.Item]) -> tuple[s.Item, ...]:
    """The items with every line that is to be a step marked as one, blank lines included."""
    numbered = [len(steps_of(item)) > 0 for item in items]
    code = [at for at, item in enumerate(items) if isinstance(item, s.Entry)]
    last = code[-1] if code and not any(numbered) else -1
    made: list[s.Item] = []
    for at, item in enumerate(items):
        if isinstance(item, s.Blank) and at < last:
            item = s.Line(UNNUMBERED, comment=EMPTY_STEP)
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

"""Lines as a version has them: with step numbers or without, labels apart, comments that fit."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Final

from assistant.languages import step_numbers
from assistant.languages.melfa_basic.tables.dialects import LAST_STEP, Dialect
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.targets import retargeted
from assistant.languages.texts.words import wrapped_text


def without_steps(items: Sequence[s.Item]) -> list[s.Item]:
    """The lines without step numbers."""
    return [replace(i, number=None) if isinstance(i, s.Line) else i for i in items]


def with_steps(
    items: Sequence[s.Item], step: int, as_steps: Collection[str] = ()
) -> list[s.Item] | None:
    """The lines with ascending step numbers; None if there are more than a program may have.

    step: between numbers, made smaller if they would not fit. as_steps: labels (upper case)
    that go again, with jumps to the number of the line below them.
    """
    kept, dropped = _without_labels(items, as_steps)
    if step_numbers.steps_in(kept) > LAST_STEP:
        return None
    lines = list(step_numbers.with_ascending_steps(kept, step, LAST_STEP))
    places = {name: step_numbers.first_step(lines[at]) for name, at in dropped.items()}
    return [retargeted(item, lambda to: places.get(str(to).upper()) or to) for item in lines]


def _without_labels(
    items: Sequence[s.Item], as_steps: Collection[str]
) -> tuple[list[s.Item], dict[str, int]]:
    """The items without such labels, and the place of the item that each of them stood above."""
    kept: list[s.Item] = []
    dropped: dict[str, int] = {}
    for at, item in enumerate(items):
        below = items[at + 1] if at + 1 < len(items) else None
        if (
            isinstance(item, s.Line)
            and item.label is not None
            and item.label.upper() in as_steps
            and item.statement is None
            and item.comment is None
            and isinstance(below, s.Entry)
        ):
            dropped[item.label.upper()] = len(kept)
        else:
            kept.append(item)
    return kept, dropped


def with_lone_labels(items: Sequence[s.Item]) -> list[s.Item]:
    """The lines with each label on a line of its own."""
    made: list[s.Item] = []
    for item in items:
        if isinstance(item, s.Line) and item.label is not None and item.statement is not None:
            made += [s.Line(label=item.label, span=item.span), replace(item, label=None)]
        else:
            made.append(item)
    return made


# Comments that are too long


def with_fitting_comments(items: Sequence[s.Item], dialect: Dialect) -> list[s.Item]:
    """The lines with long comments above them, and over as many lines as they need."""
    made: list[s.Item] = []
    for item in items:
        comment = item.comment if isinstance(item, s.Line) else None
        if not isinstance(item, s.Line) or comment is None:
            made.append(item)
            continue
        room = dialect.line - STEP_LENGTH
        if item.statement is not None or item.label is not None:
            jumps = JUMP_ROOM if isinstance(item.statement, s.If | s.ElseIf) else 0
            if len(printer.line(replace(item, number=None), True).encode()) <= room - jumps:
                made.append(item)
                continue
            made += [
                s.Line(comment=part, span=item.span) for part in wrapped_text(comment, room, "' ")
            ]
            made.append(replace(item, comment=None))
        else:
            parts = wrapped_text(comment, room, "' ")
            made += [item] if len(parts) == 1 else [replace(item, comment=p) for p in parts]
    return made


STEP_LENGTH: Final = 6
"""Characters of a step number and its blank."""

JUMP_ROOM: Final = 24
"""Characters that `IF` gets for jumps in the place of a block."""

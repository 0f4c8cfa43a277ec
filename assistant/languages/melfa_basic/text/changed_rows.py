"""Tables of which some rows changed."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from assistant.languages.melfa_basic.tree.columnar import (
    MoveRows,
    PositionRows,
    move_text,
    places_of,
    position_text,
)
from assistant.languages.runs.columns import joined
from assistant.languages.runs.merging import merged
from assistant.languages.runs.names import rows_of


def positions(new: PositionRows, olds: Iterable[tuple[PositionRows, str]], newline: str) -> str:
    """The lines of a table made from others, which were read from the texts beside them."""
    width = new.values.shape[1]
    known = [(o, t) for o, t in olds if o.stem == new.stem and o.values.shape[1] == width]
    places, end = places_of(new.values), newline.encode("ascii")
    if not known:
        return position_text(new, end, places)
    old = joined([rows for rows, _ in known])
    text, at = "".join(text for _, text in known), rows_of(old.numbers, new.numbers)
    return merged(new, old, text, at, lambda rows: position_text(rows, end, places))


def moves(new: MoveRows, old: MoveRows, text: str, newline: str, upper: bool, indent: int) -> str:
    """The lines of a run of moves made from another, which was read from the text.

    indent: blanks more behind the step of a new line.
    """
    end = newline.encode("ascii")
    at = np.arange(len(new)) if len(old) == len(new) else rows_of(old.steps, new.steps)
    if new.stem != old.stem:
        at = np.full(len(new), -1, dtype=np.intp)
    return merged(new, old, text, at, lambda rows: move_text(rows, end, upper, indent), "steps")

"""Comments that are too long for a line of a dialect."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from assistant.languages.melfa_basic.tables.dialects import Dialect
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s


def fitted(items: Sequence[s.Item], dialect: Dialect) -> list[s.Item]:
    """The lines with long comments above them, and over as many lines as they need."""
    made: list[s.Item] = []
    for item in items:
        comment = item.comment if isinstance(item, s.Line) else None
        if not isinstance(item, s.Line) or comment is None:
            made.append(item)
            continue
        room = dialect.line - STEP
        if item.statement is not None or item.label is not None:
            jumps = JUMPS if isinstance(item.statement, s.If | s.ElseIf) else 0
            if _bytes(printer.line(replace(item, number=None), True)) <= room - jumps:
                made.append(item)
                continue
            made += [s.Line(comment=part, span=item.span) for part in _parts(comment, room)]
            made.append(replace(item, comment=None))
        else:
            parts = _parts(comment, room)
            made += [item] if len(parts) == 1 else [replace(item, comment=p) for p in parts]
    return made


STEP: Final = 6
"""Characters of a step number and its blank."""

JUMPS: Final = 24
"""Characters that `IF` gets for jumps in the place of a block."""


def _bytes(text: str) -> int:
    return len(text.encode("utf-8"))


def _parts(comment: str, most: int) -> list[str]:
    """A comment cut between words, each part with the mark."""
    if _bytes(comment) <= most:
        return [comment]
    parts, line = list[str](), ""
    for piece in re.split(r"(?<= )", comment):
        for char in piece if _bytes(piece) > most - 2 else [piece]:
            if _bytes(line + char) > most:
                parts.append(line.rstrip())
                line = "' "
            line += char
    return [*parts, line.rstrip()]

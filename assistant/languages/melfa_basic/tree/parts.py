"""What of a program a report on it names beside what is lifted: data and settings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from assistant.base.diagnostics import Span
from assistant.languages.language_types import Part
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import PositionRows

CLOSING_COMMANDS: Final = frozenset(
    {"Else", "EndIf", "WEnd", "Default", "End Select", "FEnd", "End", "Return"}
)
"""Commands that only close or divide a block, or end a program or subroutine."""


def report_parts(file: s.File) -> Iterator[Part]:
    """Data and statements as they stand in the text; moves are all lifted."""
    for item in file.items:
        match item:
            case s.Data(variable=variable, span=Span() as span):
                yield Part(span, variable.name)
            case PositionRows(span=Span() as span):
                lines = None if item.places is None else item.places + span.start
                yield Part(span, count=len(item), lines=lines)
            case s.Line(statement=s.Command(keyword=word)) if word in CLOSING_COMMANDS:
                pass
            case s.Line(statement=None | s.Motion() | s.ElseIf() | s.Next() | s.Case()):
                pass
            case s.Line(span=Span() as span):
                yield Part(span)

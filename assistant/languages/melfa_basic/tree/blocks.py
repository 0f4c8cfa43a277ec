"""The words of blocks: which statement opens one, parts it and closes it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, Literal

from assistant.languages.melfa_basic.tree import syntax as s

Kind = Literal["If", "For", "While", "Select"]

CLOSING: Final[Mapping[str, Kind]] = {
    "Next": "For", "WEnd": "While", "EndIf": "If", "End Select": "Select",
}  # fmt: skip
"""Word → the kind of block that it closes."""
_MIDDLE: Final[Mapping[str, Kind]] = {"Else": "If", "Default": "Select"}


def opened(statement: s.Statement | None) -> Kind | None:
    """The kind of block that a statement opens, None for none."""
    match statement:
        case s.If(then=None):
            return "If"
        case s.For():
            return "For"
        case s.Select():
            return "Select"
        case s.Command(keyword="While"):
            return "While"
    return None


def divided(statement: s.Statement | None) -> Kind | None:
    """The kind of block that a statement begins a further part of, None for none."""
    match statement:
        case s.ElseIf():
            return "If"
        case s.Case():
            return "Select"
        case s.Command(keyword=word):
            return _MIDDLE.get(word)
    return None


def closed(statement: s.Statement | None) -> tuple[Kind, ...]:
    """The kinds of the blocks that a statement closes, the inner one first.

    `Next M1,M2` closes two loops.
    """
    match statement:
        case s.Next(variables=variables):
            loops: list[Kind] = ["For"] * max(1, len(variables))
            return tuple(loops)
        case s.Command(keyword=word) if word in CLOSING:
            return (CLOSING[word],)
    return ()


def is_word(statement: s.Statement | None) -> bool:
    """Whether a statement opens, parts or closes a block."""
    return bool(opened(statement) or divided(statement) or closed(statement))

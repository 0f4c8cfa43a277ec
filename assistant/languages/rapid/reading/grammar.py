"""The grammar of RAPID as lark reads it."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from assistant.languages.lalr import Tables
from assistant.resources import load_grammar

if TYPE_CHECKING:
    from lark import Lark


@cache
def grammar() -> Lark:
    """The parser of whole files (`start`), `statements` and `items`."""
    return load_grammar(
        "rapid.lark",
        lexer="contextual",
        start=["start", "statements", "items"],
        propagate_positions=True,
        maybe_placeholders=True,
    )


@cache
def tables(start: str) -> Tables:
    """The tables of a start rule."""
    return Tables.of(grammar(), start)

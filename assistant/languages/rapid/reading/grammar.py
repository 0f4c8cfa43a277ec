"""The grammar of RAPID."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final

from assistant.languages.grammar import Grammar, acceptor, load

if TYPE_CHECKING:
    from lark import Lark

GRAMMAR_FILE: Final = "rapid.lark"
GRAMMAR_STARTS: Final = ("start", "statements", "items")


@cache
def grammar() -> Grammar:
    """Of whole files (`start`), `statements` and `items`."""
    return load(GRAMMAR_FILE, GRAMMAR_STARTS)


def by_lark() -> Lark:
    """Return lark's own parser for the same grammar."""
    return acceptor(GRAMMAR_FILE, GRAMMAR_STARTS)

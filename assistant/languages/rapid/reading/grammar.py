"""The grammar of RAPID."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final

from assistant.languages.grammar import Grammar, acceptor, load

if TYPE_CHECKING:
    from lark import Lark

FILE: Final = "rapid.lark"
STARTS: Final = ("start", "statements", "items")


@cache
def grammar() -> Grammar:
    """Of whole files (`start`), `statements` and `items`."""
    return load(FILE, STARTS)


def by_lark() -> Lark:
    """Return lark's own parser for the same grammar."""
    return acceptor(FILE, STARTS)

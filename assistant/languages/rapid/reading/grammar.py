"""The grammar of RAPID."""

from __future__ import annotations

from functools import cache

from assistant.languages.grammar import Grammar, load


@cache
def grammar() -> Grammar:
    """Of whole files (`start`), `statements` and `items`."""
    return load("rapid.lark", ("start", "statements", "items"))

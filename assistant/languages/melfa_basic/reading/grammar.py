"""The grammar of one line of MELFA-BASIC, and its words."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from assistant.languages.grammar import Grammar, load
from assistant.languages.melfa_basic.tables.vocabulary import words


@cache
def grammar() -> Grammar:
    """The rules of a code line (start `line`) and of a variable line (`data`)."""
    return load("melfa_basic.lark", ("line", "data"))


@cache
def keywords() -> Mapping[str, tuple[str, ...]]:
    """The terminals that a word in upper case may be; the first that has room is meant."""
    found = {word.upper(): terminals for word, terminals in grammar().words.items()}
    for word in words("motion"):
        found[word.upper()] = ("MOTION", *found.get(word.upper(), ()))
    for word in words("command"):
        found[word.upper()] = (*found.get(word.upper(), ()), "COMMAND")
    return found

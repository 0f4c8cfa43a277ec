"""The grammar of one line of MELFA-BASIC as lark reads it, and its words."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Final

from assistant.languages.lalr import Tables
from assistant.languages.melfa_basic.tables.vocabulary import words
from assistant.resources import load_grammar

if TYPE_CHECKING:
    from lark import Lark


@cache
def grammar() -> Lark:
    """The rules of a code line (start `line`) and of a variable line (`data`)."""
    return load_grammar("melfa_basic.lark", start=["line", "data"], maybe_placeholders=True)


@cache
def tables(start: str) -> Tables:
    """The tables of a start rule."""
    return Tables.of(grammar(), start)


@cache
def keywords() -> Mapping[str, tuple[str, ...]]:
    """The terminals that a word in upper case may be; the first that has room is meant."""
    found: dict[str, tuple[str, ...]] = {}
    for terminal in grammar().terminals:
        if _WORDS.fullmatch(terminal.pattern.value):
            for word in _WORD.findall(terminal.pattern.value.upper()):
                found[word] = (*found.get(word, ()), terminal.name)
    for word in words("motion"):
        found[word.upper()] = ("MOTION", *found.get(word.upper(), ()))
    for word in words("command"):
        found[word.upper()] = (*found.get(word.upper(), ()), "COMMAND")
    return found


def pattern(terminal: str) -> str:
    """The regular expression of a terminal that is no word."""
    found = next(t for t in grammar().terminals if t.name == terminal)
    return found.pattern.to_regexp()


_WORDS: Final = re.compile(r"#?[a-z]+(?:[ |][a-z]+)*")
"""A terminal that is one word or several."""
_WORD: Final = re.compile(r"#?[A-Z]+(?: [A-Z]+)*")

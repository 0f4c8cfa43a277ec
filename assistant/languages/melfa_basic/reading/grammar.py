"""The grammar of MELFA-BASIC as lines are read by it, and its words."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Final

from assistant.languages.grammar import Grammar, acceptor, load
from assistant.languages.melfa_basic.tables.vocabulary import words

if TYPE_CHECKING:
    from lark import Lark

GRAMMAR_FILE: Final = "melfa_basic.lark"
GRAMMAR_STARTS: Final = ("line", "data", "start")


@cache
def grammar() -> Grammar:
    """The rules of a code line (start `line`), a variable line (`data`) and a file (`start`)."""
    return load(GRAMMAR_FILE, GRAMMAR_STARTS)


def by_lark() -> Lark:
    """Return lark's own parser for the same grammar."""
    return acceptor(GRAMMAR_FILE, GRAMMAR_STARTS)


@cache
def never_names() -> frozenset[str]:
    """Words in upper case that are never names, even where the rules have no room for them."""
    listed = re.search(r"\(\?!\(\?:([a-z|]+)\)", grammar().terminals["NAME"].pattern)
    return frozenset(listed[1].upper().split("|")) if listed else frozenset()


@cache
def keywords() -> Mapping[str, tuple[str, ...]]:
    """The terminals that a word in upper case may be; the first that has room is meant."""
    found = {word.upper(): terminals for word, terminals in grammar().words.items()}
    found["ELSEIF"] = found["ELSE IF"] = ("_ELSEIF",)
    for word in words("motion"):
        found[word.upper()] = ("MOTION", *found.get(word.upper(), ()))
    for word in words("command"):
        found[word.upper()] = (*found.get(word.upper(), ()), "COMMAND")
    return found

"""Syntax errors: what is found elsewhere must not follow from what cannot be read there."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Final

from assistant.languages.checks import registry
from assistant.languages.checks.registry import Damage
from assistant.languages.rapid.tables.predefined import taken_names
from assistant.languages.rapid.tables.words import RESERVED
from assistant.languages.rapid.tree import syntax as s

MOST_STATEMENT_LINES: Final = 51
"""Of a statement; a finding of a whole routine or table is not of one damaged place."""
_NAME: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_KNOWN_WORDS: Final = RESERVED | taken_names()


def damage_of(trees: Sequence[s.File]) -> Damage | None:
    """What is damaged in the modules of a program, None for nothing.

    The lines around a damaged one are damaged as well, and so are names that a blank may have
    parted in two.
    """
    return registry.damage_of(
        trees,
        _unknown_words,
        hidden=_joined_words,
        near=1,
        most_lines=MOST_STATEMENT_LINES,
        named_lines=1,
    )


def _joined_words(text: str) -> Iterator[str]:
    """What two words beside each other would be as one."""
    yield from ((one + other).lower() for one, other in pairwise(_NAME.findall(text)))


def _unknown_words(text: str) -> Iterator[str]:
    """Names in a text that are no words of the language, in lower case."""
    for word in _NAME.findall(text):
        if word.lower() not in _KNOWN_WORDS:
            yield word.lower()

"""Words and marks of one code line, found by the grammar itself, and the blanks between them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Final

from assistant.languages.melfa_basic.reading.line import lexemes
from assistant.languages.melfa_basic.tables.words import keyword_spelling
from assistant.languages.texts.words import Word

_BLANK_RUN: Final = re.compile(r"[ \t\f]+")
_MARK_KINDS: Final = frozenset(("NAME", "FN_NAME", "SUFFIX", "REM", "HASH"))
"""Kinds of tokens that may begin like a keyword and are none; all other words are keywords."""
_TIGHT: Final = frozenset(("POSITION", "EMPTY", "LABEL"))
"""Kinds of tokens that lose the blanks within them."""
_OPERATORS: Final = frozenset(
    ("EQUALS", "SIGN", "TIMES", "BACKSLASH", "SHIFT", "COMPARISON", "CIRCUMFLEX")
)
_TIGHT_BEFORE: Final = frozenset(("COLON", "RPAR", "SEMICOLON", "SUFFIX", "DOT"))
_TIGHT_BEHIND: Final = frozenset(("COLON", "LPAR", "COMMA", "SEMICOLON", "HASH", "DOT"))
_CLAUSES: Final = frozenset(
    ("ELSE", "_WTH", "_WTHIF", "_TYPE_OF", "GOTO", "GOSUB", "_TO", "_STEP_OF")
)
"""Words that begin a part of a statement, also where the last argument before is left out."""
_HEADS: Final = frozenset(("MOTION", "COMMAND"))
"""Statements whose first argument may be left out: `Mvs ,-100`."""


@lru_cache(maxsize=1 << 14)
def code_tokens(line: str, start: str = "line") -> tuple[Word, ...]:
    """The tokens of a line that the grammar takes, without step number.

    start: the grammar's rule, `line` or `data`.
    """
    return tuple(Word(one.type, one.text, one.start) for one in lexemes(line, start))


def code_text(listed: Sequence[Word], upper: bool) -> str:
    """Words with the blanks that belong between them, keywords spelt as the tools do.

    upper: keywords in upper case. Names, numbers, strings and comments stay as they are.
    """
    return "".join(_spaced(listed, upper))


def _spaced(listed: Sequence[Word], upper: bool) -> Iterator[str]:
    for before, token, at in zip([None, *listed], listed, range(len(listed)), strict=False):
        within_is = at > 0 and "_IS" in (listed[at - 1].kind, listed[at - 2].kind if at > 1 else "")
        if before is not None and (within_is or _are_apart(before, token)):
            yield " "
        yield _spelt(token, upper)


def _spelt(token: Word, upper: bool) -> str:
    if _is_keyword(token):
        word = keyword_spelling(token.text)
        return word.upper() if upper else word
    return _BLANK_RUN.sub("", token.text) if token.kind in _TIGHT else token.text


def _is_keyword(token: Word) -> bool:
    return token.kind not in _MARK_KINDS and (token.text[0].isalpha() or token.text[0] == "#")


def _are_apart(before: Word, token: Word) -> bool:
    """Whether a blank stands between two neighbours."""
    if token.kind in _CLAUSES and before.kind != "COLON":
        return True
    if token.kind in _TIGHT_BEFORE or before.kind in _TIGHT_BEHIND:
        return False
    if token.kind == "COMMA":
        return before.kind in _HEADS
    if _is_keyword(before):
        return not (before.kind == "_COM" and token.kind == "LPAR")
    if _is_keyword(token):
        return before.kind not in _OPERATORS
    if before.kind in _OPERATORS or token.kind in _OPERATORS:
        return False
    if "LABEL" in (before.kind, token.kind):
        return True
    return _ends_word(before) and _begins_word(token)


def _begins_word(token: Word) -> bool:
    return token.text[0].isalnum() or token.text[0] in '"&.'


def _ends_word(token: Word) -> bool:
    return token.kind != "HASH" and (token.text[-1].isalnum() or token.text[-1] in '")$%&!#.')

"""The next word of a text, as what the rules of a grammar have room for at its place.

For languages in which a word may be a name wherever the rules do not expect the word, and a mark
may mean several things: the state that the tables are in decides, as in lark's own lexer.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence, Set
from typing import Any, Final

from assistant.languages.grammar import Grammar
from assistant.languages.recovery.lexemes import STRANGE

Found = tuple[str, int, int]
"""A terminal of the grammar, STRANGE for none, and the offsets that it stands between."""
Row = Mapping[str | None, Any]
"""What the tables do with each terminal at a place."""
_WORD: Final = "[A-Za-z][A-Za-z0-9_]*+"
_SECOND: Final = re.compile(r"[ \t]*+([A-Za-z]+)(?![A-Za-z0-9_])")


class ContextualLexer:
    """Finds words by the patterns of the grammar, in upper or lower case.

    plain: terminals that are told by how they begin, tried after a word. keywords: words in upper
    case → the terminals that each may be; the first that has room is meant. firm: words that
    are no names even where there is no room for them. longer: by word or mark, the terminals that
    may begin with it. joined: terminals of marks with no blank before them. instead: terminals that
    are meant in place of others where they fit. special: by the first two letters, in upper
    case, a terminal that a word may begin with besides, and its pattern.
    """

    def __init__(
        self,
        grammar: Grammar,
        keywords: Mapping[str, tuple[str, ...]],
        *,
        plain: Sequence[str],
        firm: Set[str],
        longer: Mapping[str, Sequence[str]],
        joined: Mapping[str, str],
        instead: Mapping[str, str],
        special: Mapping[str, tuple[str, re.Pattern[str]]],
    ) -> None:
        terminals = {t.name: t.regexp for t in grammar.terminals.values()}
        listed = "|".join(f"(?P<{name}>{terminals[name]})" for name in plain)
        self._next = re.compile(
            rf"[ \t\f]*+(?:(?P<NAME>{_WORD})|{listed}|(?P<MARK>.))", re.IGNORECASE
        )
        self._longer = {
            begin: [(name, re.compile(terminals[name], re.IGNORECASE)) for name in names]
            for begin, names in longer.items()
        }
        self._instead = {
            name: (other, re.compile(terminals[other])) for name, other in instead.items()
        }
        self._marks = {t.pattern: t.name for t in grammar.terminals.values() if t.plain}
        self._keywords, self._firm = keywords, firm
        self._joined, self._special = joined, special
        self._openings = {word.split()[0] for word in keywords if " " in word}

    def next(self, text: str, at: int, end: int, row: Row) -> Found | None:
        """What stands behind an offset, None at the end.

        row: what the tables do with each terminal there. A word that they have no room for is
        given as what it looks like.
        """
        found = self._next.match(text, at, end)
        if found is None:
            return None
        kind = found.lastgroup or STRANGE
        start, stop = found.span(kind)
        if kind == "NAME":
            return self._word(text, start, stop, end, row)
        mark = text[start]
        if mark in self._longer and (longer := self._longest(mark, text, start, end, row)):
            return longer
        if kind == "MARK":
            kind = self._joined.get(mark, "") if start == at else ""
            return (kind if kind in row else self._marks.get(mark, STRANGE), start, stop)
        if kind in self._instead:
            other, pattern = self._instead[kind]
            if other in row and pattern.fullmatch(text, start, stop):
                kind = other
        return (kind, start, stop)

    def _word(self, text: str, start: int, stop: int, end: int, row: Row) -> Found:
        word = text[start:stop].upper()
        if word in self._openings and (two := _SECOND.match(text, stop, end)):
            for type in self._keywords.get(f"{word} {two[1].upper()}", ()):
                if type in row:
                    return (type, start, two.end())
        for type in self._keywords.get(word, ()):
            if type in row:
                return (type, start, stop)
        if word in self._firm:
            return (self._keywords[word][0], start, stop)
        if word in self._longer and (longer := self._longest(word, text, start, end, row)):
            return longer
        if word[:2] in self._special:
            type, pattern = self._special[word[:2]]
            if type in row and (found := pattern.match(word)):
                return (type, start, start + found.end())
        return ("NAME", start, stop)

    def _longest(self, begin: str, text: str, start: int, end: int, row: Row) -> Found | None:
        for type, pattern in self._longer[begin]:
            if type in row and (found := pattern.match(text, start, end)):
                return (type, start, found.end())
        return None

"""Parsing of single lines with the tables of a grammar.

For languages with one statement a line, in which a word may be a name wherever the rules do not
expect the word, and a mark may mean several things: as in lark's contextual lexer, the state of the
parser decides which terminals are tried next.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from itertools import islice
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.languages.grammar import Grammar
from assistant.languages.lalr import END, Stack, Tables, Word
from assistant.languages.recovery.syntax import STRANGE, Lexeme, Stop

Found = tuple[str, int, int]
"""A terminal of the grammar, STRANGE for none, and the offsets that it stands between."""
Row = Mapping[str | None, Any]
"""Action of the tables for each terminal at a position."""
_WORD: Final = "[A-Za-z][A-Za-z0-9_]*+"
_SECOND: Final = re.compile(r"[ \t]*+([A-Za-z]+)(?![A-Za-z0-9_])")


class ContextualLexer:
    """Finds words by the patterns of the grammar, in upper or lower case.

    plain: terminals that are identified by their beginning, tried after a word. keywords: words in
    upper case → the terminals that each may be; the first that the tables allow is meant. firm:
    words that are not names even where the tables do not allow them. longer: by word or mark, the
    terminals that may begin with it. joined: terminals of marks with no blank before them. instead:
    terminals that are meant in place of others where they fit. special: by the first two letters,
    in upper case, a further terminal that a word may begin with, and its pattern.
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
        """Return the word after an offset, None at the end.

        row: action of the tables for each terminal there. A word that they do not allow is returned
        as the terminal that it looks like.
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
            # Some marks mean something else directly after a word than after a blank.
            kind = self._joined.get(mark, "") if start == at else ""
            return (kind if kind in row else self._marks.get(mark, STRANGE), start, stop)
        if kind in self._instead:
            other, pattern = self._instead[kind]
            if other in row and pattern.fullmatch(text, start, stop):
                kind = other
        return (kind, start, stop)

    def _word(self, text: str, start: int, stop: int, end: int, row: Row) -> Found:
        word = text[start:stop].upper()
        # Two words that belong together, such as `End Select`, are one terminal.
        if word in self._openings and (two := _SECOND.match(text, stop, end)):
            for type in self._keywords.get(f"{word} {two[1].upper()}", ()):
                if type in row:
                    return (type, start, two.end())
        for type in self._keywords.get(word, ()):
            if type in row:
                return (type, start, stop)
        # Not a name even where it does not fit, so that the finding is about the word.
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


@dataclass(frozen=True, slots=True)
class LineGrammar:
    """Reads lines.

    tables: by start rule. next: returns the word after an offset, None at the end, from the text,
    the offset, the end and the row of the tables there. most_words: of a line that are read.
    most_values: that may wait on the stack.
    """

    tables: Mapping[str, Tables]
    next: Callable[[str, int, int, Row], Found | None]
    most_words: int
    most_values: int

    def read(
        self, text: str, at: int, end: int, start: str, nodes: Any, words: list[Lexeme] | None
    ) -> Any | Stop:
        """Return the result of `nodes` for the text between two offsets, or a Stop at a misfit.

        start: rule of the grammar. words: collects the words that are read. Raises ValueError if a
        number is too large.
        """
        tables = self.tables[start]
        stack = Stack(tables.first)
        # Two more than are allowed: END, and the word that shows that there are too many.
        read = islice(self._words(text, at, end, stack, tables, words), self.most_words + 2)
        wrong = tables.drive(stack, read, nodes, most=self.most_values)
        return stack.values[0] if wrong is None else Stop(Lexeme(*wrong), start)

    def _words(
        self,
        text: str,
        at: int,
        end: int,
        stack: Stack,
        tables: Tables,
        words: list[Lexeme] | None,
    ) -> Iterator[Word]:
        """Each as what there is room for behind those before it."""
        following, rows, states = self.next, tables.rows, stack.states
        while (found := following(text, at, end, rows[states[-1]])) is not None:
            type, begin, at = found
            said = text[begin:at]
            yield type, said, begin, at
            if words is not None:
                words.append(Lexeme(type, said, begin, at))
        yield END, "", end, end

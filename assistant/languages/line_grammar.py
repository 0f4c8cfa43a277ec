"""Lines by the tables of a grammar, for languages with a statement a line."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Any

from assistant.languages.contextual_lexer import Found, Row
from assistant.languages.lalr import END, Stack, Tables, Word
from assistant.languages.recovery.lexemes import Lexeme, Stop


@dataclass(frozen=True, slots=True)
class LineGrammar:
    """Reads lines.

    tables: by start rule. next: what stands behind an offset, None at the end, from the text, the
    offset, the end and the row of the tables there. most_words: of a line that are read.
    most_values: that may wait on the stack.
    """

    tables: Mapping[str, Tables]
    next: Callable[[str, int, int, Row], Found | None]
    most_words: int
    most_values: int

    def read(
        self, text: str, at: int, end: int, start: str, nodes: Any, words: list[Lexeme] | None
    ) -> Any | Stop:
        """What `nodes` make of what stands between two offsets, or where it does not fit.

        start: rule of the grammar. words: takes those that were read. Raises ValueError where a
        number is too large.
        """
        tables = self.tables[start]
        stack = Stack(tables.first)
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

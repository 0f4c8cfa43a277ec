"""One scanner of RAPID for all who need its words: made of the terminals of the grammar."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Final

from assistant.base.source_text import with_line_feeds
from assistant.languages.grammar import WordScanner, terminals_pattern
from assistant.languages.rapid.reading.grammar import grammar
from assistant.languages.texts.words import Word

SILENT: Final = frozenset({"NOTE", "COMMENT", "BLANK"})
"""Terminals that stand between words."""
FOREIGN_BEFORE: Final = {
    "FOREIGN_COMMENT": r"//[^\r\n]*|\#[^\r\n]*|/\*[^\r\n]*",
    "FOREIGN_EQUAL": r"==",
}
FOREIGN_AFTER: Final = {
    "FOREIGN_STRING": (
        r"[\u201c\u201d\u201e\u00ab\u2018\u2019'`][^\r\n;]*?[\u201c\u201d\u00bb\u2018\u2019'`]"
    ),
    "BAD_ESCAPE": r'"(?:[^"\r\n]++|"")*+"|"[^"\r\n]*+"',
    "OPEN_STRING": r'"[^"\r\n]*(?:\r?\n[^"\r\n;]*"(?=[^"\r\n]*$)|(?=;[ \t]*$)|$)',
    "STRANGE": r".",
}
"""What other languages write, by regular expressions; none of it is a terminal of the grammar."""


FREQUENT: Final = ("BLANK", "SEMICOLON", "COMMA", "NAME", "LPAR", "RPAR", "BACKSLASH", "_ASSIGN")
"""Tried first, for speed: nothing else begins as they do, but for `:`, which is shorter."""


@cache
def scanner() -> re.Pattern[str]:
    """The terminals in the order in which they are tried, and the foreign ones around them."""
    return terminals_pattern(grammar(), FREQUENT, FOREIGN_BEFORE, FOREIGN_AFTER)


@cache
def table_words() -> WordScanner:
    """What the tables of the grammar read; a note is only one where one may stand."""
    return WordScanner(grammar(), scanner(), SILENT - {"NOTE"}, frozenset({"NOTE"}))


_WORD_KINDS: Final = {
    "NAME": "word",
    "NUMBER": "number",
    "STRING": "string",
    "HEADER": "header",
    "NOTE": "comment",
    "COMMENT": "comment",
    "BLANK": "blank",
    "TABLE": "table",
}
_HOLE: Final = re.compile(r"<\w+>")
_BREAK: Final = re.compile(r"(?P<newline>\r*\n|\r)|(?P<mark>\ufeff)")


def words(text: str, start: int = 0, end: int | None = None) -> Iterator[Word]:
    """The words between two offsets: comments and line ends are some as well, blanks are none.

    kind: `word`, `key` (a reserved word), `number`, `string`, `hole`, `mark`, `comment`, `header`
    or `newline` (a line end).
    """
    kinds = _kinds_of_terminals()
    ended = with_line_feeds(text)
    for match in scanner().finditer(ended, start, len(text) if end is None else end):
        kind, found, at = kinds[match.lastgroup], match[0], match.start()
        if ended is not text:
            found = text[at : match.end()]
        if kind == "blank":
            if found == " ":
                continue
            for part in _BREAK.finditer(found):
                yield Word(str(part.lastgroup), part[0], at + part.start())
        elif kind == "table":
            for part in _table_pattern().finditer(found):
                yield Word("number" if part["number"] else "mark", part[0], at + part.start())
        else:
            yield Word(kind, found, at)


@cache
def _kinds_of_terminals() -> Mapping[str | None, str]:
    """The kinds of all terminals and of what other languages write."""
    kinds: dict[str | None, str] = dict.fromkeys((*FOREIGN_BEFORE, *FOREIGN_AFTER), "mark")
    for name, terminal in grammar().terminals.items():
        spelling = terminal.pattern
        plain = "key" if spelling[0].isalpha() else "hole" if _HOLE.match(spelling) else "mark"
        kinds[name] = _WORD_KINDS.get(name, plain)
    return kinds


@cache
def _table_pattern() -> re.Pattern[str]:
    """What a table of numbers is made of."""
    return re.compile(rf"(?P<number>{grammar().terminals['NUMBER'].regexp})|[^ \t]")

"""Grammar, scanner and tokens of RAPID.

One scanner, made of the terminals of the grammar `rapid.lark`, serves the parser, recovery, editors
and the layout. `words` gives the words of a text; `tokens` also gives tables of alike lines as one
token each.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING, Final

from assistant.base.source_text import with_line_feeds
from assistant.languages.grammar import Grammar, WordScanner, acceptor, load, terminals_pattern
from assistant.languages.texts.words import Word

if TYPE_CHECKING:
    from lark import Lark


_GRAMMAR_FILE: Final = "rapid.lark"
_GRAMMAR_STARTS: Final = ("start", "statements", "items")


@cache
def grammar() -> Grammar:
    """Return the grammar of complete files (`start`), `statements` and `items`."""
    return load(_GRAMMAR_FILE, _GRAMMAR_STARTS)


def by_lark() -> Lark:
    """Return lark's own parser for the same grammar."""
    return acceptor(_GRAMMAR_FILE, _GRAMMAR_STARTS)


SILENT: Final = frozenset({"NOTE", "COMMENT", "BLANK"})
"""Terminals that stand between words."""
# Tried before the grammar's terminals, which would read `//` as two divisions and `==` as two
# signs.
_FOREIGN_BEFORE: Final = {
    "FOREIGN_COMMENT": r"//[^\r\n]*|\#[^\r\n]*|/\*[^\r\n]*",
    "FOREIGN_EQUAL": r"==",
}
# Tried last: they take only text that no terminal of the grammar does.
_FOREIGN_AFTER: Final = {
    "FOREIGN_STRING": (
        r"[\u201c\u201d\u201e\u00ab\u2018\u2019'`][^\r\n;]*?[\u201c\u201d\u00bb\u2018\u2019'`]"
    ),
    "BAD_ESCAPE": r'"(?:[^"\r\n]++|"")*+"|"[^"\r\n]*+"',
    "OPEN_STRING": r'"[^"\r\n]*(?:\r?\n[^"\r\n;]*"(?=[^"\r\n]*$)|(?=;[ \t]*$)|$)',
    "STRANGE": r".",
}
"""Constructs of other languages, as regular expressions; the grammar has no terminal for any of
them.
"""


_FREQUENT: Final = ("BLANK", "SEMICOLON", "COMMA", "NAME", "LPAR", "RPAR", "BACKSLASH", "_ASSIGN")
"""Tried first, for speed: nothing else begins as they do, but for `:`, which is shorter."""


@cache
def scanner() -> re.Pattern[str]:
    """The terminals in the order in which they are tried, and the foreign ones around them."""
    return terminals_pattern(grammar(), _FREQUENT, _FOREIGN_BEFORE, _FOREIGN_AFTER)


@cache
def table_words() -> WordScanner:
    """Return the word scanner for the grammar tables; a note counts only where the grammar allows
    one.
    """
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
    """Yield the words between two offsets, including comments and line ends but not blanks.

    kind: `word`, `key` (a reserved word), `number`, `string`, `hole`, `mark`, `comment`, `header`
    or `newline` (a line end).
    """
    kinds = _kinds_of_terminals()
    ended = with_line_feeds(text)
    for match in scanner().finditer(ended, start, len(text) if end is None else end):
        kind, found, at = kinds[match.lastgroup], match[0], match.start()
        # `with_line_feeds` keeps offsets, so the original line ends are at the same place.
        if ended is not text:
            found = text[at : match.end()]
        if kind == "blank":
            # A single blank is the most frequent match; the search for line ends is not worth its
            # time.
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
    kinds: dict[str | None, str] = dict.fromkeys((*_FOREIGN_BEFORE, *_FOREIGN_AFTER), "mark")
    for name, terminal in grammar().terminals.items():
        spelling = terminal.pattern
        plain = "key" if spelling[0].isalpha() else "hole" if _HOLE.match(spelling) else "mark"
        kinds[name] = _WORD_KINDS.get(name, plain)
    return kinds


@cache
def _table_pattern() -> re.Pattern[str]:
    """Return the pattern for the elements of a table of numbers."""
    return re.compile(rf"(?P<number>{grammar().terminals['NUMBER'].regexp})|[^ \t]")


_FEWEST_ROWS: Final = 8
_MOST_ROWS: Final = 1 << 16
"""Rows of one token, so that a long table comes in pieces of bounded size."""


def tokens(text: str, *, rows: bool = True, start: int = 0) -> Iterator[Word]:
    """The words of a text, and `rows`: tables of alike lines, line ends included.

    rows: False takes tables apart as well. start: of the text.
    """
    found = words(text)
    header = next(found, None)
    at = 0
    # The header is text of any form, in which rows must not be looked for.
    if header is not None and header.kind == "header":
        at = header.end
        yield header._replace(start=start)
    for table in _TABLE.finditer(text, at) if rows else ():
        if _may_be_rows(table[0]):
            yield from _moved_words(words(text, at, table.start()), start)
            yield Word("rows", table[0], start + table.start())
            at = table.end()
    yield from _moved_words(words(text, at), start)


def _moved_words(found: Iterator[Word], by: int) -> Iterator[Word]:
    return found if not by else (word._replace(start=word.start + by) for word in found)


def _may_be_rows(text: str) -> bool:
    """True if no word in a table could need upper case."""
    lower = text.lower()
    return "true" not in lower and "false" not in lower


# `MoveL \Conc,p1,...` has an option first, which `_table_lines` has no layout for.
_ROW_HEAD = r"(?:(?:LOCAL +)?+CONST +robtarget +|Move[JLC] +(?!\\))"
# Blanks are allowed only beside a mark: removing those between two words would join the words.
_ROW_REST = r"(?:[^\s;!\"()<>%]++|(?<=\W)[ \t]++|[ \t]++(?=\W))*+"
_ROW = rf"[ \t]*+{_ROW_HEAD}{_ROW_REST};[ \t]*+(?:\r?\n|\Z)"
"""A declared target or a move on one line, that needs no blank but those of its head."""

_TABLE: Final = re.compile(rf"^(?:{_ROW}){{{_FEWEST_ROWS},{_MOST_ROWS}}}+", re.MULTILINE)

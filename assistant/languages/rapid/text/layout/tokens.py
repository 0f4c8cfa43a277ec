"""Tokens of a RAPID text, with the line ends and comments between them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final, NamedTuple

from assistant.languages.rapid.tables.words import RESERVED

FEWEST_ROWS: Final = 8
MOST_ROWS: Final = 1 << 16
"""Rows of one token, so that a long table comes in pieces of bounded size."""


HOLES: Final = "TDN|DDN|RDN|PAR|ALT|DIM|SMT|VAR|EIT|CSE|EXP|ARG"
"""What is not written yet: placeholders of RAPID, `<SMT>` for a statement; `<ID>` is a name."""


class Token(NamedTuple):
    """kind: `word`, `key` (a reserved word), `number`, `string`, `hole`, `mark`, `comment`,
    `break` (a line end), `header`, or `rows` (a table of alike lines, line ends included).
    text: as written. start: its offset.
    """

    kind: str
    text: str
    start: int


def tokens(text: str, *, rows: bool = True, start: int = 0) -> Iterator[Token]:
    """Every token but blanks; rows: False takes tables apart as well. start: of the text."""
    pattern = _WITH_ROWS if rows else _PLAIN
    for match in pattern.finditer(text):
        kind = str(match.lastgroup)
        found = match[0]
        if kind == "word" and found.lower() in RESERVED:
            kind = "key"
        elif kind == "rows" and not _may_be_rows(found):
            yield from tokens(found, rows=False, start=start + match.start())
            continue
        yield Token(kind, found, start + match.start())


def _may_be_rows(text: str) -> bool:
    """Whether no word in a table could need upper case."""
    lower = text.lower()
    return "true" not in lower and "false" not in lower


_HEAD = r"(?:(?:LOCAL +)?+CONST +robtarget +|Move[JLC] +(?!\\))"
_TIGHT = r"(?:[^\s;!\"()<>%]++|(?<=\W)[ \t]++|[ \t]++(?=\W))*+"
_ROW = rf"[ \t]*+{_HEAD}{_TIGHT};[ \t]*+(?:\r?\n|\Z)"
"""A declared target or a move on one line, that needs no blank but those of its head."""

_KINDS: Final = {
    "header": r"%%%(?s:.*?)%%%",
    "comment": r"![^\r\n]*",
    "string": r'"(?:[^"\r\n]|"")*+(?:"|$)',
    "hole": rf"<(?:{HOLES})>",
    "word": r"[^\W\d]\w*|<ID>",
    "number": r"0[xobd][0-9a-f]+|(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[-+]?[0-9]+)?",
    "break": r"\r*\n|\r",
    "mark": r":=|<>|<=|>=|\S",
}
_ROWS: Final = {"rows": rf"(?-i:^(?:{_ROW}){{{FEWEST_ROWS},{MOST_ROWS}}}+)"}


def _pattern(kinds: dict[str, str]) -> re.Pattern[str]:
    groups = (f"(?P<{kind}>{pattern})" for kind, pattern in kinds.items())
    return re.compile("|".join(groups), re.IGNORECASE | re.MULTILINE)


_PLAIN: Final = _pattern(_KINDS)
_WITH_ROWS: Final = _pattern(_ROWS | _KINDS)

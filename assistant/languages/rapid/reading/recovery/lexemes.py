"""Words of a damaged text, read without a parser: what the grammar knows, and what it does not."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from typing import Final

from assistant.languages.rapid.reading.grammar import grammar

END: Final = "$END"
SILENT: Final = frozenset({"NOTE", "COMMENT", "BLANK"})

FOREIGN_BEFORE: Final = {
    "FOREIGN_COMMENT": r"//[^\r\n]*|\#[^\r\n]*|/\*[^\r\n]*",
    "FOREIGN_EQUAL": r"==",
}
FOREIGN_AFTER: Final = {
    "FOREIGN_STRING": (
        r"[\u201c\u201d\u201e\u00ab\u2018\u2019'`][^\r\n;]*?[\u201c\u201d\u00bb\u2018\u2019'`]"
    ),
    "BAD_ESCAPE": r'"(?:[^"\r\n]|"")*"',
    "OPEN_STRING": r'"[^"\r\n]*(?:\r?\n[^"\r\n;]*"(?=[^"\r\n]*$)|(?=;[ \t]*$)|$)',
    "STRANGE": r".",
}
"""What other languages write, by regular expressions; none of it is a terminal of the grammar."""


FREQUENT: Final = ("BLANK", "SEMICOLON", "COMMA", "NAME", "LPAR", "RPAR", "BACKSLASH", "_ASSIGN")
"""Tried first, for speed: nothing else begins as they do, but for `:`, which is shorter."""


@dataclass(frozen=True, slots=True)
class Lexeme:
    """type: a terminal of the grammar, END or a row above. first: on its line.

    start, end: offsets in the source; alike for what a repair puts in.
    """

    type: str
    text: str
    start: int
    end: int
    first: bool = False


def lexemes(text: str, start: int, stop: int, further: int) -> list[Lexeme]:
    """All from one offset to another and a few further, END behind the last of the text."""
    found: list[Lexeme] = []
    beyond = 0
    end = start
    for match in scanner().finditer(text, start):
        type = match.lastgroup or "STRANGE"
        if type in SILENT:
            continue
        begin, end = match.span()
        line = text.rfind("\n", 0, begin) + 1
        found.append(Lexeme(type, match[0], begin, end, not text[line:begin].strip()))
        beyond += begin >= stop
        if beyond > further:
            return found
    end = end if found else len(text[:start].rstrip())
    return [*found, Lexeme(END, "", end, end, True)]


@cache
def scanner() -> re.Pattern[str]:
    """The terminals in the order in which lark tries them, and the foreign ones around them."""
    known = sorted(
        grammar().terminals,
        key=lambda t: (-t.priority, -t.pattern.max_width, -len(t.pattern.value), t.name),
    )
    patterns = {t.name: t.pattern.to_regexp() for t in known}
    rows = {
        **{name: patterns[name] for name in FREQUENT},
        **FOREIGN_BEFORE,
        **patterns,
        **FOREIGN_AFTER,
    }
    return re.compile("|".join(f"(?P<{n}>{r})" for n, r in rows.items()), re.MULTILINE)

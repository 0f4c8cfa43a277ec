"""One scanner of RAPID for all who need its words: made of the terminals of the grammar."""

from __future__ import annotations

import re
from collections.abc import Set
from functools import cache
from typing import Final

from assistant.languages.rapid.reading.grammar import grammar

SILENT: Final = frozenset({"NOTE", "COMMENT", "BLANK"})
"""Terminals that stand between words."""
LARGE: Final = frozenset({"TABLE"})
"""Terminals that hold what others say in several words."""

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


@cache
def scanner(without: Set[str] = frozenset()) -> re.Pattern[str]:
    """The terminals in the order in which they are tried, and the foreign ones around them."""
    known = grammar()
    patterns = {name: known.terminals[name].regexp for name in known.order}
    rows = {
        **{name: patterns[name] for name in FREQUENT},
        **FOREIGN_BEFORE,
        **patterns,
        **FOREIGN_AFTER,
    }
    listed = (f"(?P<{n}>{r})" for n, r in rows.items() if n not in without)
    return re.compile("|".join(listed), re.MULTILINE)

"""The next word of a line, as what the rules have room for at that place.

`*` begins a label or multiplies, `(` begins a constant, an empty list or a bracket, `Tool` is a
statement or a name: the state that the tables are in decides, as it does in lark's own lexer.
"""

from __future__ import annotations

import re
from typing import Final

from assistant.languages.line_grammar import Found, Row
from assistant.languages.melfa_basic.reading.grammar import grammar, keywords
from assistant.languages.recovery.lexemes import STRANGE


class Lexer:
    """Finds words; the patterns are those of the grammar."""

    def __init__(self) -> None:
        flags = re.IGNORECASE
        terminals = grammar().terminals
        named = ("NUMBER", "STRING", "COMMENT", "COMPARISON", "SHIFT", "SIGN", "TIMES")
        groups = {name: terminals[name].regexp for name in ("NAME", *named)}
        listed = "|".join(f"(?P<{name}>{regexp})" for name, regexp in groups.items())
        self._next = re.compile(rf"[ \t\f]*+(?:{listed}|(?P<MARK>.))", flags)
        self._longer = {
            name: re.compile(terminals[name].regexp, flags)
            for name in ("POSITION", "EMPTY", "LABEL", "HEX", "BINARY", "REM", "_INCLUDE")
        }
        marks = {t.pattern: t.name for t in terminals.values() if t.plain}
        self._marks = marks | dict.fromkeys("$%!&#", "SUFFIX")
        self._keywords = keywords()
        self._pairs = {w: types for w, types in self._keywords.items() if " " in w}
        self._pairs["END IF"] = self._keywords["ENDIF"]
        self._openings = {pair.split()[0] for pair in self._pairs}

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
        if kind == "MARK" or kind == "TIMES":
            return self._mark(text, start, end, row, start == at)
        if kind == "NUMBER" and "STEP" in row and text[start:stop].isdigit():
            kind = "STEP"
        return (kind, start, stop)

    def _word(self, text: str, start: int, stop: int, end: int, row: Row) -> Found:
        word = text[start:stop].upper()
        if word in self._openings and (two := _SECOND.match(text, stop, end)):
            for type in self._pairs.get(f"{word} {two[1].upper()}", ()):
                if type in row:
                    return (type, start, two.end())
        for type in self._keywords.get(word, ()):
            if type in row:
                return (type, start, stop)
        if word in _FIRM:
            return (self._keywords[word][0], start, stop)
        if word == "REM" and "REM" in row:
            return ("REM", start, end)
        if word[:2] == "FN" and len(word) > 2 and "FN_NAME" in row:
            return ("FN_NAME", start, stop)
        if word[:3] == "MXT" and word[3:].isdigit() and "COMMAND" in row:
            return ("COMMAND", start, start + 3)
        return ("NAME", start, stop)

    def _mark(self, text: str, start: int, end: int, row: Row, joined: bool) -> Found:
        """`*` and `/`, brackets and all single marks: the longest that there is room for.

        joined: whether no blank stands before it, as none does before a type mark.
        """
        mark = text[start]
        for type in _LONGER.get(mark, ()):
            if type in row and (found := self._longer[type].match(text, start, end)):
                return (type, start, found.end())
        if mark in "*/":
            return ("TIMES", start, start + 1)
        type = self._marks.get(mark, STRANGE)
        if type == "SUFFIX" and not (joined and type in row):
            type = "HASH" if mark == "#" else STRANGE
        return (type, start, start + 1)


_LONGER: Final = {
    "(": ("POSITION", "EMPTY"),
    "*": ("LABEL",),
    "&": ("HEX", "BINARY"),
    "#": ("_INCLUDE",),
}
_FIRM: Final = frozenset(
    {"IF", "THEN", "ELSE", "ELSEIF", "ENDIF", "FOR", "TO", "NEXT", "WHILE", "WEND", "SELECT"}
    | {"CASE", "GOTO", "GOSUB", "CALLP", "AND", "OR", "XOR", "NOT", "MOD", "WTH", "WTHIF"}
    | {"DEF", "FUNCTION", "FEND", "MOV", "MVS", "MVR"}
)
"""Words that are no names even where there is no room for them."""
_SECOND: Final = re.compile(r"[ \t]*+([A-Za-z]+)(?![A-Za-z0-9_])")

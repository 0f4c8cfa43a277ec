"""The words of a line: `*` begins a label or multiplies, `Tool` is a statement or a name."""

from __future__ import annotations

import re
from typing import Final

from assistant.languages.contextual_lexer import ContextualLexer
from assistant.languages.melfa_basic.reading.grammar import grammar, keywords

_FIRM: Final = frozenset(
    {"IF", "THEN", "ELSE", "ELSEIF", "ENDIF", "FOR", "TO", "NEXT", "WHILE", "WEND", "SELECT"}
    | {"CASE", "GOTO", "GOSUB", "CALLP", "AND", "OR", "XOR", "NOT", "MOD", "WTH", "WTHIF"}
    | {"DEF", "FUNCTION", "FEND", "MOV", "MVS", "MVR"}
)
"""Words that are no names even where there is no room for them."""
_SPECIAL: Final = {
    "FN": ("FN_NAME", re.compile(r"FN.+")),
    "MX": ("COMMAND", re.compile(r"MXT(?=[0-9]+\Z)")),
}
"""Functions of the program, `FNAREA`, and the one command with its number, `MXT1`."""


def lexer() -> ContextualLexer:
    return ContextualLexer(
        grammar(),
        {**keywords(), "END IF": keywords()["ENDIF"]},
        plain=("NAME", "NUMBER", "STRING", "COMMENT", "COMPARISON", "SHIFT", "SIGN", "TIMES"),
        firm=_FIRM,
        longer={
            "(": ("POSITION", "EMPTY"),
            "*": ("LABEL",),
            "&": ("HEX", "BINARY"),
            "#": ("_INCLUDE",),
            "REM": ("REM",),
        },
        joined=dict.fromkeys("$%!&#", "SUFFIX"),
        instead={"NUMBER": "STEP"},
        special=_SPECIAL,
    )

"""The words of a line: `*` begins a label or multiplies, `Tool` is a statement or a name."""

from __future__ import annotations

import re
from typing import Final

from assistant.languages.line_grammar import ContextualLexer
from assistant.languages.melfa_basic.reading.grammar import grammar, keywords, never_names

_SPECIAL_WORDS: Final = {
    "FN": ("FN_NAME", re.compile(r"FN.+")),
    "MX": ("COMMAND", re.compile(r"MXT(?=[0-9]+\Z)")),
}
"""Functions of the program, `FNAREA`, and the one command with its number, `MXT1`."""


def lexer() -> ContextualLexer:
    return ContextualLexer(
        grammar(),
        {**keywords(), "END IF": keywords()["ENDIF"]},
        plain=("NUMBER", "STRING", "COMMENT", "COMPARISON", "SHIFT", "SIGN", "TIMES"),
        firm=never_names(),
        longer={
            "(": ("POSITION", "EMPTY"),
            "*": ("LABEL",),
            "&": ("HEX", "BINARY"),
            "#": ("_INCLUDE",),
            "REM": ("REM",),
        },
        joined=dict.fromkeys("$%!&#", "SUFFIX"),
        instead={"NUMBER": "STEP"},
        special=_SPECIAL_WORDS,
    )

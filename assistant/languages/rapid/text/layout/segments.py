"""What ends and divides the statements and blocks of RAPID."""

from __future__ import annotations

from typing import Final

from assistant.languages.rapid.text.layout.tokens import tokens
from assistant.languages.texts.layout import Cutter

_OPENS: Final = frozenset({"module", "record", "proc", "func", "trap", "for", "while", "test"})
_DIVIDES: Final = frozenset(
    {"else", "elseif", "<eit>", "case", "<cse>", "default", "backward", "error", "undo"}
)
_CLOSES: Final = frozenset(f"end{word}" for word in {*_OPENS, "if"})
_STATEMENT_HOLES: Final = frozenset({"<smt>", "<ddn>", "<tdn>", "<rdn>"})
_ENDED_BY: Final = {
    "elseif": frozenset({"then"}),
    "for": frozenset({"do"}),
    "while": frozenset({"do"}),
    "case": frozenset({":"}),
    "default": frozenset({":"}),
    "if": frozenset({"then", ";", "<smt>"}),
}

SEGMENT_CUTTER: Final = Cutter(
    words=tokens,
    plain=lambda text, start: tokens(text, rows=False, start=start),
    scopes=frozenset({"local", "task"}),
    opens=_OPENS,
    opening={"if": "then"},
    divides=_DIVIDES,
    closes=_CLOSES,
    alone=(_DIVIDES | _CLOSES | _STATEMENT_HOLES) - _ENDED_BY.keys(),
    end=";",
    ended_by=_ENDED_BY,
    ended_before={"test": frozenset({"case", "<cse>", "default", "endtest"})},
    named=frozenset({"module", "record", "trap"}),
    headed=frozenset({"proc", "func"}),
    bracketed=frozenset({"module", "proc", "func", "error"}),
    label=":",
)

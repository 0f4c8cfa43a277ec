"""What the toy language knows: its limits, its words, and every finding that it gives."""

from __future__ import annotations

import re
from typing import Final

from assistant.program.diagnostics import error, info, warning

NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,19}")
STEM: Final = 16
"""Characters of a longer name that stay, so that a number behind them still fits."""
DECIMALS: Final = 6
LARGEST: Final = 999_999_999
MOST_BLOCKS: Final = 50
"""Blocks inside each other."""

INSIDE: Final = ("call", "go", "line", "turn", "wait", "set", "await", "if", "while", "stop")
"""Words of lines that stand in a procedure only."""
DECLARES: Final = {
    **{word: word for word in ("procedure", "tool", "frame", "point", "joints")},
    "input": "signal",
    "output": "signal",
}
"""Word of a line → the kind of thing that it declares."""
USES: Final = {
    **dict.fromkeys(("start", "call"), ("procedure",)),
    **dict.fromkeys(("go", "line"), ("point", "", "", "tool", "frame")),
    "turn": ("joints", "", "", "tool", "frame"),
    **dict.fromkeys(("set", "await", "if", "while"), ("signal",)),
}
"""Word of a line → the kinds of things that its values name, empty for what is no name."""
EXPECTED: Final = {
    "NAME": "a name of at most 20 letters, digits and `_`",
    "NUMBER": "a number of at most 6 decimals",
    "STATE": "`on` or `off`",
    "ARM": "the name of an arm",
    "BIT": "the number of the signal",
    "$END": "nothing more",
}
"""What is said for a terminal of the grammar; any other is its own word."""

UNREAD = error("TY101", "{found} cannot stand here", "write {expected}")
MISPLACED = error("TY102", "`{word}` {why}", "delete it, or mend the line that begins its block")
NOT_ENDED = error("TY103", "this block has no `end`", "write `end` behind its last line")
UNDECLARED = error("TY201", "there is no {kind} `{name}`", "declare it, or correct the name")
TWICE = error("TY202", "{kind} `{name}` is declared already", "give it another name")
UNSAYABLE = error(
    "TY301",
    "the toy language cannot say {what}",
    "say it in moves to points, waits, and signals that are on or off",
)
LEFT_OUT = warning(
    "TY302",
    "the toy language has no {what}; it is left out",
    "check what the controller takes instead",
)
REWRITTEN = info(
    "TY303",
    "`{given}` is written `{name}`",
    "use ASCII, in a name at most 20 letters, digits and `_`",
)

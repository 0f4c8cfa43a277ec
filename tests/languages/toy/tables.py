"""What the toy language knows: its limits, its words, and every finding that it gives."""

from __future__ import annotations

import re
from typing import Final

from assistant.base.diagnostics import error, info, warning
from assistant.languages.patterns import MotionRow, Row, Rows, slots
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Frame, Target, Tool

NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,19}")
DECIMALS: Final = 6
LARGEST: Final = 999_999_999
MOST_BLOCKS: Final = 50
"""Blocks inside each other."""

TABLES: Final = {"tool": "tools", "frame": "frames", "point": "targets", "joints": "joint_targets"}
"""Word of a line → the table of a program that it is a row of."""
PLACED: Final = {"tool": Tool, "frame": Frame, "point": Target}
"""Of these, what is at a pose, by that alone."""
_HOW: Final = "{speed}, {blend}, {tool:value tool}, {frame:value frame}"
CONDITION: Final = "asked"
"""Word of the row of what `if` and `while` ask for."""
_LINES: Final = (
    MotionRow(f"go {{target:named point}}, {_HOW}", p.Move, kind="joint"),
    MotionRow(f"line {{target:named point}}, {_HOW}", p.Move, kind="linear"),
    MotionRow(f"turn {{target:named joints}}, {_HOW}", p.MoveJoints),
    Row("wait {seconds:number}", p.Wait),
    Row("set {signal:value signal} {value:state}", p.SetSignal),
    Row("await {signal:value signal} {value:state}", p.WaitSignal),
    Row("call {procedure:value procedure}", p.Call),
    Row("stop", p.Stop),
    Row(f"{CONDITION} {{left:named signal}} {{right:state}}", e.Binary, operator="="),
)
"""Statements. What stands in a slot is of a kind, and where it is a name, of a kind of things."""
ROWS: Final = Rows(*_LINES)
DECLARES: Final = {
    **{word: word for word in ("procedure", "tool", "frame", "point", "joints")},
    "input": "signal",
    "output": "signal",
}
"""Word of a line → the kind of thing that it declares."""
_USES: Final = {row.pattern.word: [slot.of for slot in slots(row.pattern)] for row in _LINES}
USES: Final = {
    "start": ["procedure"],
    **dict.fromkeys(("if", "while"), _USES.pop(CONDITION)),
    **_USES,
}
"""Word of a line → the kinds of things that its values name, empty for what is no name."""
INSIDE: Final = USES.keys() - {"start"}
"""Words of lines that stand in a procedure only."""
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
RENAMED = info("TY303", "`{given}` is written `{name}`", "use at most 20 letters, digits and `_`")
CHANGED = info("TY304", "{what} is written as {instead}", "{cure}")

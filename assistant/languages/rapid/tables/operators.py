"""Operators of RAPID, and how tightly they bind."""

from __future__ import annotations

from typing import Final

from assistant.program import expressions as e

OR, AND, RELATION, SUM, TERM, PRIMARY = range(6)
"""How tightly an expression holds together; what is looser than its place gets parentheses."""

BINARY: Final[dict[str, tuple[str, int, int, int]]] = {
    "or": ("OR", OR, OR, AND),
    "xor": ("XOR", OR, OR, AND),
    "and": ("AND", AND, AND, RELATION),
    **{o: (o, RELATION, SUM, SUM) for o in e.RELATIONS},
    "+": ("+", SUM, SUM, TERM),
    "-": ("-", SUM, SUM, TERM),
    "*": ("*", TERM, TERM, PRIMARY),
    "/": ("/", TERM, TERM, PRIMARY),
    "div": ("DIV", TERM, TERM, PRIMARY),
    "mod": ("MOD", TERM, TERM, PRIMARY),
}
"""Operator → RAPID's, its own level, and the levels that its operands must have."""

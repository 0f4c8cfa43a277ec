"""Operators of MELFA-BASIC, and how tightly they bind: one row each, both ways."""

from __future__ import annotations

from typing import Final

XOR, OR, AND, NOT, RELATION, SHIFT, SUM, REMAINDER, QUOTIENT, TERM, SIGN, POWER = range(1, 13)
"""Higher binds tighter (CR1D detailed specifications, order of operations)."""

BINARY: Final[dict[str, tuple[int, str]]] = {
    "xor": (XOR, "XOR"),
    "or": (OR, "OR"),
    "and": (AND, "AND"),
    "=": (RELATION, "="),
    "<>": (RELATION, "<> ><"),
    "<": (RELATION, "<"),
    "<=": (RELATION, "<= =<"),
    ">": (RELATION, ">"),
    ">=": (RELATION, ">= =>"),
    "<<": (SHIFT, "<<"),
    ">>": (SHIFT, ">>"),
    "+": (SUM, "+"),
    "-": (SUM, "-"),
    "mod": (REMAINDER, "MOD"),
    "div": (QUOTIENT, "\\"),
    "*": (TERM, "*"),
    "/": (TERM, "/"),
    "^": (POWER, "^"),
}
"""Operator of the pseudo-program → its level and its word, behind it others that it is written as.

Shifts are no operators of the pseudo-program; they stay as their text.
"""

PRODUCT: Final = "*"
"""Composes positions, as `@` does."""
WRITTEN: Final = {name: words.split()[0] for name, (_, words) in BINARY.items()} | {"@": PRODUCT}
"""Operator of the pseudo-program → its word."""
READ: Final = {word: name for name, (_, words) in BINARY.items() for word in words.split()}
PRECEDENCE: Final = {word: BINARY[name][0] for word, name in READ.items()}
"""By the word."""

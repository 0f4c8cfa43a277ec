"""Operators of MELFA-BASIC, and how tightly they bind: one row each, both ways."""

from __future__ import annotations

from typing import Final

XOR, OR, AND, NOT, RELATION, SHIFT, SUM, REMAINDER, QUOTIENT, TERM, SIGN, POWER = range(1, 13)
"""Higher binds tighter (CR1D detailed specifications, order of operations)."""

BINARY_OPERATORS: Final[dict[str, tuple[int, str]]] = {
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
OPERATOR_WORDS: Final = {
    name: words.split()[0] for name, (_, words) in BINARY_OPERATORS.items()
} | {"@": PRODUCT}
"""Operator of the pseudo-program → its word."""
OPERATOR_NAMES: Final = {
    word: name for name, (_, words) in BINARY_OPERATORS.items() for word in words.split()
}
OPERATOR_PRECEDENCE: Final = {
    word: BINARY_OPERATORS[name][0] for word, name in OPERATOR_NAMES.items()
}
"""By the word."""

"""Vendor statements, expressions and declarations of a program, and their effects.

A vendor statement is one for which the pseudo-program has no node: it holds text of the vendor's
language, passed through unchanged.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final, TypeVar

from assistant.base.source_text import words_of
from assistant.program.expressions import Effect, VendorTextKind, Verbatim, unknown_effect
from assistant.program.program import Declaration, Program
from assistant.program.rewriting import rewrite
from assistant.program.statements import Opaque

VendorText = Opaque | Verbatim | Declaration
"""Records that hold text of a vendor's language."""
K = TypeVar("K", Opaque, Verbatim)

_VENDOR_TEXT_KINDS: Final[dict[type, VendorTextKind]] = {
    Opaque: "statement",
    Verbatim: "expression",
    Declaration: "declaration",
}


def vendor_text_kind(kept: VendorText) -> VendorTextKind:
    return _VENDOR_TEXT_KINDS[type(kept)]


def effect_of(kept: VendorText) -> Effect:
    """Return the effect of a vendor text: anything, if it was not analysed."""
    return unknown_effect(kept.text) if kept.effect is None else kept.effect


def respelled(kept: K, text: str, old: str, new: str) -> K:
    """Return a vendor text in which a name was exchanged, except in strings; both names in lower
    case.
    """
    if kept.effect is None:
        return replace(kept, text=text)
    stays = old in words_of(text)
    return replace(kept, text=text, effect=kept.effect.renamed(old, {new, old} if stays else {new}))


def with_effects(program: Program, read: Callable[[VendorText], Effect | None]) -> Program:
    """Return the program whose vendor texts carry their effects; known effects stay unchanged.

    read: returns the effect of one, None if it cannot be analysed.
    """

    def visit(record: Any) -> Any:
        if isinstance(record, VendorText) and record.effect is None:
            effect = read(record)
            return record if effect is None else replace(record, effect=effect)
        return record

    return rewrite(program, visit)

"""Small programs of a cell with one token dropped, doubled or swapped with the next."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from tests.languages import mutations as damage
from tests.languages.mutations import Mutation, Tokens
from tests.languages.rapid.layouts import TOKENS

PROGRAMS: Final = tuple(sorted((Path(__file__).parent / "data").glob("*.mod")))
KINDS: Final = ("dropped", "doubled", "swapped")
EACH: Final = 10
"""Damages of one kind to one program."""


def mutations(each: int = EACH, seed: int = 1) -> Iterator[Mutation]:
    """The same ones each time: tokens of all kinds but comments and the header."""
    return damage.mutations(PROGRAMS, _tokens, KINDS, each, seed)


def _tokens(text: str) -> Tokens:
    return [t for t in TOKENS.finditer(text) if not (t["comment"] or t["header"])]


__all__ = ["KINDS", "PROGRAMS", "Mutation", "mutations"]

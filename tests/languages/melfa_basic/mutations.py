"""Small programs of a cell in the three dialects with one piece of damage each."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from tests.languages import mutations as damage
from tests.languages.melfa_basic.layouts import TOKENS
from tests.languages.mutations import Mutation, Tokens

PROGRAMS: Final = tuple(sorted((Path(__file__).parent / "data").glob("*.mb[456]")))
KINDS: Final = ("dropped", "doubled", "swapped")
EACH: Final = 10
"""Damages of one kind to one program."""


def language_of(program: str) -> str:
    """The dialect of a program's file, by its suffix: `.mb4`, `.mb5` or `.mb6`."""
    return f"melfa-basic-{program[-1]}"


def mutations(
    kinds: tuple[str, ...] = KINDS, each: int = EACH, seed: int = 1
) -> Iterator[Mutation]:
    """The same ones each time: tokens of all kinds but comments."""
    return damage.mutations(PROGRAMS, _tokens, kinds, each, seed)


def _tokens(text: str) -> Tokens:
    return [t for t in TOKENS.finditer(text) if not t["comment"]]


__all__ = ["KINDS", "PROGRAMS", "Mutation", "language_of", "mutations"]

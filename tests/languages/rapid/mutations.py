"""Small programs of a cell with one token dropped, doubled or swapped with the next."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from tests.languages.rapid.layouts import TOKENS

PROGRAMS: Final = tuple(sorted((Path(__file__).parent / "data").glob("*.mod")))
KINDS: Final = ("dropped", "doubled", "swapped")
EACH: Final = 10
"""Damages of one kind to one program."""


@dataclass(frozen=True, slots=True)
class Mutation:
    """A damaged program. lines: the first and last that the damage touches, counted from 1."""

    program: str
    kind: str
    tokens: tuple[str, ...]
    lines: tuple[int, int]
    text: str

    @property
    def name(self) -> str:
        where = f"{self.program}:{self.lines[0]}"
        return f"{where} {self.kind} {' '.join(self.tokens)}"


def mutations(each: int = EACH, seed: int = 1) -> Iterator[Mutation]:
    """The same ones each time: tokens of all kinds but comments and the header."""
    for path in PROGRAMS:
        text = path.read_text(encoding="utf-8")
        tokens = [t for t in TOKENS.finditer(text) if not (t["comment"] or t["header"])]
        for kind in KINDS:
            chance = random.Random(f"{path.stem} {kind} {seed}")
            places = [
                at for at in range(len(tokens) - 1) if kind != "swapped" or _differ(tokens, at)
            ]
            for at in sorted(chance.sample(places, each)):
                yield _damaged(path.stem, text, kind, tokens[at], tokens[at + 1])


def _differ(tokens: list[re.Match[str]], at: int) -> bool:
    return tokens[at][0].upper() != tokens[at + 1][0].upper()


def _damaged(
    program: str, text: str, kind: str, one: re.Match[str], next: re.Match[str]
) -> Mutation:
    between = text[one.end() : next.start()]
    if kind == "dropped":
        changed = text[: one.start()] + " " + text[one.end() :]
    elif kind == "doubled":
        changed = text[: one.end()] + " " + text[one.start() :]
    else:
        changed = f"{text[: one.start()]} {next[0]}{between or ' '}{one[0]} {text[next.end() :]}"
    last = next if kind == "swapped" else one
    lines = (text.count("\n", 0, one.start()) + 1, text.count("\n", 0, last.start()) + 1)
    tokens = (one[0], next[0]) if kind == "swapped" else (one[0],)
    return Mutation(program, kind, tokens, lines, changed)

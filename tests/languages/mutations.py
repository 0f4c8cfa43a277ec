"""Small programs with one piece of damage, in any language that can be cut into tokens."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from assistant.base.diagnostics import Diagnostic

Tokens = list[re.Match[str]]
NEAR: Final = 2
"""Lines between a damage and a finding that is about it."""


@dataclass(frozen=True, slots=True)
class Mutation:
    """A damaged program.

    program: its file name. lines: the first and last that the damage touches, counted from 1.
    """

    program: str
    kind: str
    tokens: tuple[str, ...]
    lines: tuple[int, int]
    text: str

    @property
    def name(self) -> str:
        where = f"{self.program}:{self.lines[0]}"
        return f"{where} {self.kind} {' '.join(self.tokens)}"

    def is_near(self, found: Iterable[Diagnostic]) -> bool:
        """Whether one of the findings is about the damage."""
        first, last = self.lines
        return any(first - NEAR <= f.line <= last + NEAR for f in found if f.line is not None)

    def holds(self, finding: Diagnostic) -> bool:
        """Whether a finding points into the text, shows that line and says what to do."""
        if finding.line is None or finding.column is None:
            return False
        line = self.text.split("\n")[finding.line - 1]
        here = finding.excerpt == line and 1 <= finding.column <= len(line) + 1
        return here and bool(finding.cure)


def mutations(
    programs: Sequence[Path],
    tokens_of: Callable[[str], Tokens],
    kinds: Sequence[str],
    each: int,
    seed: int = 1,
) -> Iterator[Mutation]:
    """The same ones each time: of every program and kind as many damages as are wanted.

    tokens_of: the tokens of a text that may be damaged, in order. kinds: of DAMAGES.
    """
    for path in programs:
        text = path.read_text(encoding="utf-8")
        tokens = tokens_of(text)
        for kind in kinds:
            chance = random.Random(f"{path.stem} {kind} {seed}")
            places = [at for at in range(len(tokens) - 1) if _can_be(kind, tokens, at)]
            for at in sorted(chance.sample(places, each)):
                yield _damaged(path.name, text, kind, tokens, at, chance)


def _can_be(kind: str, tokens: Tokens, at: int) -> bool:
    if kind == "swapped":
        return tokens[at][0].upper() != tokens[at + 1][0].upper()
    if kind == "misspelt":
        return len(tokens[at][0]) > 1 and tokens[at][0].isalpha()
    return True


def _damaged(
    program: str, text: str, kind: str, tokens: Tokens, at: int, chance: random.Random
) -> Mutation:
    one, next = tokens[at], tokens[at + 1]
    last = next if kind == "swapped" else one
    lines = (text.count("\n", 0, one.start()) + 1, text.count("\n", 0, last.start()) + 1)
    shown = (one[0], next[0]) if kind == "swapped" else (one[0],)
    return Mutation(program, kind, shown, lines, DAMAGES[kind](text, one, next, chance))


def _dropped(text: str, one: re.Match[str], _: re.Match[str], __: random.Random) -> str:
    return text[: one.start()] + " " + text[one.end() :]


def _doubled(text: str, one: re.Match[str], _: re.Match[str], __: random.Random) -> str:
    return text[: one.end()] + " " + text[one.start() :]


def _swapped(text: str, one: re.Match[str], next: re.Match[str], _: random.Random) -> str:
    between = text[one.end() : next.start()] or " "
    return f"{text[: one.start()]} {next[0]}{between}{one[0]} {text[next.end() :]}"


def _misspelt(text: str, one: re.Match[str], _: re.Match[str], chance: random.Random) -> str:
    """A letter is left out, typed twice, or changes places with the next."""
    word, letter = one[0], chance.randrange(len(one[0]) - 1)
    left, right = word[:letter], word[letter + 2 :]
    here, there = word[letter], word[letter + 1]
    pairs = [there, here + here + there] + [there + here] * (here.upper() != there.upper())
    return text[: one.start()] + left + chance.choice(pairs) + right + text[one.end() :]


def _line_dropped(text: str, one: re.Match[str], _: re.Match[str], __: random.Random) -> str:
    start, end = text.rfind("\n", 0, one.start()) + 1, text.find("\n", one.end()) + 1
    return text[:start] + text[end or len(text) :]


DAMAGES: Final[dict[str, Callable[[str, re.Match[str], re.Match[str], random.Random], str]]] = {
    "dropped": _dropped,
    "doubled": _doubled,
    "swapped": _swapped,
    "misspelt": _misspelt,
    "line dropped": _line_dropped,
}

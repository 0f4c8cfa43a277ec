"""What vendor text does that a program keeps as it is: asked instead of the text's words."""

from __future__ import annotations

from collections.abc import Iterable, Set
from dataclasses import dataclass, field
from typing import Final, Literal

from assistant.program.text import words_of

VendorTextKind = Literal["statement", "expression", "declaration"]
"""What a kept text is."""


@dataclass(frozen=True, slots=True)
class Effect:
    """What a kept text does where it stands; rather too much than too little.

    Names are in lower case. reads: everything that it names. writes: data that it may change or
    that it declares. calls: routines of the user's that it runs, and nobody here knows what those
    do; the language's own are told of by the rest. moves: whether it may move the robot. jumps:
    whether the program may go on elsewhere than behind it. waits: whether it may last until
    something happens, or for a time. Of a declared routine it is what its body does. What only
    happens later, in an interrupt or an error handler, is named but not done where it stands.
    """

    reads: frozenset[str] = frozenset()
    writes: frozenset[str] = frozenset()
    calls: frozenset[str] = frozenset()
    moves: bool = False
    jumps: bool = False
    waits: bool = False

    @property
    def names(self) -> frozenset[str]:
        """Everything that it reads, changes or calls."""
        return self.reads | self.writes | self.calls

    def renamed(self, old: str, new: Set[str]) -> Effect:
        """With other names for one, where it occurs."""
        named = (self.reads, self.writes, self.calls)
        reads, writes, calls = (n - {old} | new if old in n else n for n in named)
        return Effect(reads, writes, calls, self.moves, self.jumps, self.waits)


@dataclass(slots=True)
class EffectBuilder:
    """An effect as it is put together; names in any case."""

    reads: set[str] = field(default_factory=set)
    writes: set[str] = field(default_factory=set)
    calls: set[str] = field(default_factory=set)
    moves: bool = False
    jumps: bool = False
    waits: bool = False

    def declare(self, *names: str) -> None:
        """Names of what begins to be there."""
        self.reads.update(name.lower() for name in names if name)
        self.writes.update(name.lower() for name in names if name)

    def effect(self) -> Effect:
        reads, writes, calls = (
            frozenset(name.lower() for name in names)
            for names in (self.reads, self.writes, self.calls)
        )
        return Effect(reads, writes, calls, self.moves, self.jumps, self.waits)


NO_EFFECT: Final = Effect()


def combined_effect(effects: Iterable[Effect]) -> Effect:
    """What several do."""
    each = list(effects)
    return Effect(
        frozenset().union(*(one.reads for one in each)),
        frozenset().union(*(one.writes for one in each)),
        frozenset().union(*(one.calls for one in each)),
        any(one.moves for one in each),
        any(one.jumps for one in each),
        any(one.waits for one in each),
    )


def unknown_effect(text: str) -> Effect:
    """Of a text that nobody can read: it may do anything with whatever its words name."""
    words = frozenset(words_of(text))
    return Effect(words, words, words, moves=True, jumps=True, waits=True)

"""The shortest texts that a grammar has for each of its rules, and what can be said n times.

A symbol that can stand inside of itself is pumped: `A` becomes `a A b`, so that there are texts
with n times `a` on its left and n times `b` on its right. Lists grow so as well as brackets.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from assistant.languages.grammar import lark
from assistant.resources import read_grammar

Terminals = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Around:
    """What stands on the left and on the right of something."""

    left: Terminals = ()
    right: Terminals = ()

    def __len__(self) -> int:
        return len(self.left) + len(self.right)

    def inside(self, outer: Around) -> Around:
        return Around(outer.left + self.left, self.right + outer.right)


@dataclass(frozen=True, slots=True)
class Rule:
    origin: str
    symbols: Terminals


@dataclass(frozen=True, slots=True)
class Pumped:
    """around: what stands before and behind all of it. each: what is said n times. seed: inside."""

    of: str
    around: Around
    each: Around
    seed: Terminals

    def words(self, n: int) -> Terminals:
        inner = self.each.left * n + self.seed + self.each.right * n
        return self.around.left + inner + self.around.right


class Derivations:
    """The shortest derivations of a grammar.

    unsaid: terminals that no text has.
    """

    def __init__(self, file: str, starts: Sequence[str], unsaid: frozenset[str]) -> None:
        made: Any = lark(read_grammar(file), tuple(starts))
        rules = (
            Rule(str(rule.origin.name), tuple(str(one.name) for one in rule.expansion))
            for rule in made.rules
        )
        self.patterns = {str(t.name): str(t.pattern.value) for t in made.terminals}
        self.rules = [rule for rule in dict.fromkeys(rules) if unsaid.isdisjoint(rule.symbols)]
        self.of: dict[str, list[Rule]] = {}
        for rule in self.rules:
            self.of.setdefault(rule.origin, []).append(rule)

    @cached_property
    def shortest(self) -> dict[str, Terminals]:
        """The shortest text of each rule's name."""
        found: dict[str, Terminals] = {}
        changed = True
        while changed:
            changed = False
            for rule in self.rules:
                parts = [found.get(one, None if one in self.of else (one,)) for one in rule.symbols]
                if any(part is None for part in parts):
                    continue
                said = tuple(word for part in parts if part is not None for word in part)
                if rule.origin not in found or len(said) < len(found[rule.origin]):
                    found[rule.origin], changed = said, True
        return found

    def said(self, symbols: Sequence[str]) -> Terminals:
        """The shortest text of some symbols."""
        return tuple(word for one in symbols for word in self.shortest.get(one, (one,)))

    def ways(self, start: str) -> dict[str, Around]:
        """What stands around each rule's name in the shortest text of another that has it."""
        found: dict[str, Around] = {}
        left: list[tuple[int, int, str, Around]] = [(0, 0, start, Around())]
        number = 0
        while left:
            _, _, symbol, around = heapq.heappop(left)
            if symbol in found:
                continue
            found[symbol] = around
            for rule in self.of.get(symbol, ()):
                for at, one in enumerate(rule.symbols):
                    if one in self.of and one not in found and rule.origin in self.shortest:
                        further = self._beside(rule, at).inside(around)
                        number += 1
                        heapq.heappush(left, (len(further), number, one, further))
        return found

    def _beside(self, rule: Rule, at: int) -> Around:
        return Around(self.said(rule.symbols[:at]), self.said(rule.symbols[at + 1 :]))

    def pumped(self, start: str) -> Iterator[Pumped]:
        """Everything that can stand inside of itself, each way once."""
        outer = self.ways(start)
        inner = {name: self.ways(name) for name in self.of}
        met: set[tuple[Terminals, Terminals]] = set()
        for rule in self.rules:
            if rule.origin not in outer or rule.origin not in self.shortest:
                continue
            for at, symbol in enumerate(rule.symbols):
                back = inner.get(symbol, {}).get(rule.origin)
                if back is None:
                    continue
                each = back.inside(self._beside(rule, at))
                if len(each) and (each.left, each.right) not in met:
                    met.add((each.left, each.right))
                    seed = self.shortest[rule.origin]
                    yield Pumped(rule.origin, outer[rule.origin], each, seed)

    def kinds(self, start: str) -> Iterator[tuple[str, Terminals]]:
        """Each rule once, in the shortest text of a start that uses it."""
        outer, met = self.ways(start), set[Terminals]()
        for rule in self.rules:
            known = all(one in self.shortest or one not in self.of for one in rule.symbols)
            if rule.origin in outer and known:
                around = outer[rule.origin]
                said = around.left + self.said(rule.symbols) + around.right
                if said not in met:
                    met.add(said)
                    yield rule.origin, said

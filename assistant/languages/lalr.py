"""lark's tables without lark's parser: typed nodes are built as the rules of a grammar are reduced.

Does the same as lark with the same tables, but without a tree, tokens, and lines and columns in
between, which take most of lark's time. Each language finds its words, and handles one that does
not fit, in its own way.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span

if TYPE_CHECKING:
    from lark.grammar import Rule

END: Final = "$END"
"""The terminal after the last word of a text."""
NOWHERE: Final = -1
"""Offset of what stands for no text."""

Rows = list[dict[str | None, Any]]
"""For each state what a terminal does there: a state to shift to or a Reduction."""


Word = tuple[str, str, int, int]
"""A word of a text: its terminal (END after the last one), its text, and its offsets."""


class Stack:
    """State of the parser at a position of the text.

    states: one more than there are values. begins, ends: offsets of the values, NOWHERE for a value
    without text. deepest: the largest number of values so far.
    """

    __slots__ = ("begins", "deepest", "ends", "states", "values")

    def __init__(self, first: int) -> None:
        self.states = [first]
        self.values: list[Any] = []
        self.begins: list[int] = []
        self.ends: list[int] = []
        self.deepest = 0

    def keep(self, values: int) -> None:
        """Forgets all but the first values."""
        del self.states[values + 1 :], self.values[values:]
        del self.begins[values:], self.ends[values:]

    def kept(self) -> Kept:
        """Return the state that `go_back` needs to return to this position."""
        # Lists grow in place, so their length is all that has to be remembered.
        values = tuple((v, len(v) if isinstance(v, list) else 0) for v in self.values)
        return Kept(tuple(self.states), values, tuple(self.begins), tuple(self.ends))

    def go_back(self, kept: Kept) -> None:
        """Forgets all that was read since."""
        self.states[:], self.begins[:], self.ends[:] = kept.states, kept.begins, kept.ends
        self.values[:] = [v[:size] if isinstance(v, list) else v for v, size in kept.values]


@dataclass(frozen=True, slots=True, eq=False)
class Kept:
    """A stack as it was. values: each with its length then, for lists grow in place."""

    states: tuple[int, ...]
    values: tuple[tuple[Any, int], ...]
    begins: tuple[int, ...]
    ends: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Tables:
    """The tables of one start rule. END is shifted behind a whole text.

    first: state. leading: for each state the terminal that leads to it, empty for a rule.
    """

    rows: Rows
    first: int
    passing: Passing
    leading: tuple[str, ...]

    def drive(
        self,
        stack: Stack,
        words: Iterable[Word],
        nodes: Any,
        *,
        most: int = sys.maxsize,
        careful: bool = False,
    ) -> Word | None:
        """Reads words on a stack; the one that does not fit, None for a whole text.

        words: may look at the stack for what fits there; without END the last one is answered.
        nodes: as of `Reduction.reduce`. most: values that may wait on the stack. careful: leaves
        the stack as it is before a word that does not fit; else rules are done that it completes.
        """
        # Local names: this loop runs once for each word of a program.
        states, values, begins, ends = stack.states, stack.values, stack.begins, stack.ends
        settle = self.settle
        word = None
        for word in words:
            type, text, begin, end = word
            if careful and self.after(states, (type,)) is None:
                return word
            state = settle(type, states, values, begins, ends, nodes)
            if state is None:
                return word
            if type == END:
                return None
            depth = len(states)
            if depth > stack.deepest:
                if depth > most:
                    return word
                stack.deepest = depth
            states.append(state)
            values.append(text)
            begins.append(begin)
            ends.append(end)
        return word

    def settle(
        self,
        terminal: str | None,
        states: list[int],
        values: list[Any],
        begins: list[int],
        ends: list[int],
        nodes: Any,
    ) -> int | None:
        """Does the rules that a terminal completes; the state that it leads to.

        None where it does not fit. nodes: as of `Reduction.reduce`.
        """
        rows = self.rows
        action = rows[states[-1]].get(terminal)
        # Faster than `isinstance`, and no subclass exists.
        while action.__class__ is Reduction:
            # A chain of rules that hand one value on is one step.
            if action.passes:
                states[-1], action = self.passing[states[-2], states[-1], terminal]
                continue
            action.reduce(rows, states, values, begins, ends, nodes)
            action = rows[states[-1]].get(terminal)
        state: int | None = action
        return state

    def shift(self, states: list[int], terminal: str) -> bool:
        """Shifts a terminal in place, without values; False where it does not fit.

        The states are spoiled then.
        """
        while (action := self.rows[states[-1]].get(terminal)) is not None:
            if isinstance(action, int):
                states.append(action)
                return True
            # A slice of the last 0 states would delete them all.
            if action.size:
                del states[-action.size :]
            states.append(self.rows[states[-1]][action.origin])
        return False

    def after(self, states: Sequence[int], terminals: Iterable[str]) -> list[int] | None:
        """The states when these terminals have been shifted, None where one does not fit."""
        changed = list(states)
        return changed if all(self.shift(changed, one) for one in terminals) else None

    def types(self, states: Sequence[int]) -> tuple[str, ...]:
        """The terminals of the values on a stack, empty for what rules have made."""
        return tuple(map(self.leading.__getitem__, states[1:]))

    def fitting(self, states: Sequence[int]) -> frozenset[str]:
        """The terminals of the grammar, and END, that fit behind what led to these states."""
        row = self.rows[states[-1]]
        return frozenset(
            t for t in row if t is not None and t.isupper() and self.after(states, (t,))
        )


class Passing(dict[tuple[int, int, str | None], tuple[int, Any]]):
    """Rules in a row that pass one value on, as `sum` does a single `product`, in one step.

    From the last state but one, the last one and a terminal to the new last one and what the
    terminal does there, None for nothing.
    """

    def __init__(self, rows: Rows) -> None:
        super().__init__()
        self.rows = rows

    def __missing__(self, key: tuple[int, int, str | None]) -> tuple[int, Any]:
        below, top, terminal = key
        action = self.rows[top].get(terminal)
        while isinstance(action, Reduction) and action.passes:
            top = self.rows[below][action.origin]
            action = self.rows[top].get(terminal)
        self[key] = top, action
        return top, action


@dataclass(frozen=True, slots=True)
class Reduction:
    """A rule of the grammar.

    origin: the symbol that it makes, of as many symbols as size says. method: of the nodes, empty
    for a rule whose children go to the rule around it. children: rows that are not left out,
    whether what they have is taken one by one, and the Nones before them. behind: Nones behind the
    last. single: whether one child stands for the rule itself.
    """

    origin: str
    size: int
    method: str
    children: tuple[tuple[int, bool, int], ...]
    behind: int
    single: bool
    passes: bool
    """One value that stays as it is."""

    @staticmethod
    def of(rule: Rule) -> Reduction:
        options = rule.options
        size = len(rule.expansion)
        # lark says where a part in brackets is left out: True for it, False for a symbol
        gaps = [0]
        for empty in options.empty_indices or [False] * size:
            if empty:
                gaps[-1] += 1
            else:
                gaps.append(0)
        children, nones = [], 0
        for row, symbol in enumerate(rule.expansion):
            nones += gaps[row]
            if not (symbol.is_term and getattr(symbol, "filter_out", False)):
                # Rules whose names begin with `_` have no node: their children belong to the rule
                # around them.
                spread = not symbol.is_term and symbol.name.startswith("_")
                children.append((row, spread, nones))
                nones = 0
        name = rule.alias or str(rule.origin.name)
        single = bool(options.expand1) and not rule.alias
        behind = nones + gaps[size]
        return Reduction(
            str(rule.origin.name),
            size,
            "" if name.startswith("_") else name,
            tuple(children),
            behind,
            single,
            single and size == 1 and children == [(0, False, 0)] and not behind,
        )

    def packed(self) -> list[Any]:
        """Return the fields in their order, as a list that a file can hold."""
        return [getattr(self, name) for name in self.__slots__]

    @staticmethod
    def unpacked(packed: Sequence[Any]) -> Reduction:
        origin, size, method, children, *rest = packed
        return Reduction(origin, size, method, tuple(map(tuple, children)), *rest)

    def reduce(
        self,
        table: Sequence[dict[str | None, Any]],
        states: list[int],
        values: list[Any],
        begins: list[int],
        ends: list[int],
        nodes: Any,
    ) -> None:
        """Puts what the rule makes in place of the values that it is made of.

        nodes: has a method `(span, children)` for each rule that is a node.
        """
        size = self.size
        # A value without text has no place; the span is that of the first and last value with one.
        begin = end = NOWHERE
        taken: list[Any] = []
        if size:
            taken = values[-size:]
            begin, end = begins[-size], ends[-1]
            if size > 1:
                if begin == NOWHERE:
                    begin = next((b for b in begins[-size:] if b != NOWHERE), NOWHERE)
                if end == NOWHERE:
                    end = next((e for e in reversed(ends[-size:]) if e != NOWHERE), NOWHERE)
            del states[-size:], values[-size:], begins[-size:], ends[-size:]
        children: list[Any] = []
        for row, spread, nones in self.children:
            if nones:
                children += [None] * nones
            if not spread:
                children.append(taken[row])
            elif children:
                children += taken[row]
            else:
                children = taken[row]  # lists grow on their left: what they have is not copied
        if self.behind:
            children += [None] * self.behind
        if self.single and len(children) == 1:
            value = children[0]
        elif self.method:
            span = None if begin == NOWHERE else Span(begin, end)
            value = getattr(nodes, self.method)(span, children)
        else:
            value = children
        states.append(table[states[-1]][self.origin])
        values.append(value)
        begins.append(begin)
        ends.append(end)

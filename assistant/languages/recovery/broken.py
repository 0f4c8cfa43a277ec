"""A damaged place of a text, and a change that may mend it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from assistant.languages.lalr import Kept, Tables
from assistant.languages.recovery.lexemes import Lexeme
from assistant.languages.recovery.syntax import Blocks, Syntax


@dataclass(frozen=True, slots=True, eq=False)
class HalfBlock:
    """The stack as it was at a head whose last word may be forgotten.

    line_end: of the line that it stands on.
    """

    at: int
    line_end: int
    stack: Kept


class Outline:
    """Where the units of a text begin and end, looked up once for all of its damaged places."""

    def __init__(self, blocks: Blocks, text: str) -> None:
        self._blocks, self._text = blocks, text

    @cached_property
    def _begins(self) -> list[int]:
        return [found.start() for found in self._blocks.unit_begin.finditer(self._text)]

    @cached_property
    def _first_end(self) -> int:
        found = self._blocks.unit_end.search(self._text)
        return len(self._text) + 1 if found is None else found.end()

    @cached_property
    def has_items(self) -> bool:
        """Whether a declaration or routine begins anywhere."""
        return self._blocks.item.search(self._text) is not None

    def next_unit(self, at: int) -> int | None:
        """Where the first unit behind an offset begins."""
        row = bisect_right(self._begins, at)
        return self._begins[row] if row < len(self._begins) else None

    def ends_before(self, at: int) -> bool:
        """Whether a unit ends before an offset."""
        return self._first_end <= at


@dataclass(frozen=True, slots=True)
class Repair:
    """A change of the stack and of the place where reading goes on.

    kind: a key of `Wording.cures`, or `insert`, `replace`, `join`, `close`. keep: values that
    stay. put: words to shift then. resume: offset to go on from. start, end: the place to show.
    what: the word concerned. kept: a stack to go back to instead of keeping `keep` values.
    """

    kind: str
    keep: int
    put: tuple[Lexeme, ...]
    resume: int
    start: int
    end: int
    what: str = ""
    silent: bool = False
    kept: HalfBlock | None = None


@dataclass(frozen=True, slots=True)
class Broken:
    """A damaged place.

    words: from the begin of the statement to some words behind the error. error: row of the word
    that does not fit. states, types, begins: the parser's stack; of each value on it its terminal
    (empty for a node) and its offset (-1 if it was put in). base: values before the statement.
    kept: heads that may be half. outline: of the text.
    """

    syntax: Syntax
    text: str
    words: list[Lexeme]
    error: int
    tables: Tables
    states: list[int]
    types: tuple[str, ...]
    begins: tuple[int, ...]
    base: int
    kept: tuple[HalfBlock, ...]
    outline: Outline

    @property
    def word(self) -> Lexeme:
        return self.words[self.error]

    @property
    def behind_unit(self) -> bool:
        """Whether a unit ends before the place."""
        return self.outline.ends_before(self.word.start)

    @property
    def closes(self) -> bool:
        """Whether the word that does not fit begins a line and ends a block that is open."""
        ends = self.syntax.blocks.ends
        return self.word.first and any(self.word.type == ends[o] for o, _ in self.openers())

    @property
    def at_file_level(self) -> bool:
        return self.error == 0 and self.fits((self.syntax.blocks.unit,))

    @property
    def block(self) -> int:
        """Begin of the line on which the innermost open block begins."""
        begin = max((begin for _, begin in self.openers()), default=0)
        return self.text.rfind("\n", 0, begin) + 1

    @property
    def previous_end(self) -> int:
        """Where the word before the error ends."""
        if self.error:
            return self.words[self.error - 1].end
        return self.syntax.layout.code_end(self.text, self.word.start)

    def accepts(self, terminal: str) -> bool:
        return self.tables.after(self.states, (terminal,)) is not None

    def fits(self, terminals: Iterable[str]) -> bool:
        """Whether the statement may be these words."""
        return self.tables.after(self.states[: self.base + 1], terminals) is not None

    def accepted(self) -> frozenset[str]:
        return self.tables.fitting(self.states)

    def openers(self) -> list[tuple[str, int]]:
        """Blocks that are open before the statement, the outermost first: word and offset."""
        ends = self.syntax.blocks.ends
        closers = frozenset(ends.values())
        found: list[tuple[str, int]] = []
        for type, begin in zip(self.types[: self.base], self.begins, strict=False):
            if type in ends:
                found.append((type, begin))
            elif type in closers:  # read, but not yet put together
                found.pop()
        return found

    def reach(self, keep: int, put: Iterable[str], index: int) -> int:
        """Row of the first word that does not fit behind a change; -1 if the change does not."""
        stack = self.tables.after(self.states[: keep + 1], put)
        if stack is None:
            return -1
        for row in range(index, len(self.words)):
            if not self.tables.shift(stack, self.words[row].type):
                return row
        return len(self.words)

    def rest_left_out(self) -> Repair:
        at = len(self.text)
        return Repair("hole", self.base, (), at, self.word.start, self.word.end)

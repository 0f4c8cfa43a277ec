"""What the text rooms ask of a language of lines, and new files of one."""

from __future__ import annotations

import abc
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from assistant.languages.line_blocks import NO_WORD, Block, BlockWord, blocks_of
from assistant.languages.runs.columns import Run
from assistant.languages.texts.changed_lines import Code, Line


class LinePrinter(Code, abc.ABC):
    """The items of a file and how its language writes them.

    Lines of one kind may stand in tables. table: those of the program, with their step numbers.
    number: the column of tables of data that tells which row is which. blocks: whether lines are
    indented by the blocks that they stand in. most: bytes of a line that controllers take.
    """

    items: Sequence[Any]
    table: type[Run]
    number: str
    blocks: bool
    most: int

    @abc.abstractmethod
    def line(self, item: Any) -> Line | None:
        """What a line of the program says, None for any other item; its code can be hashed."""

    @abc.abstractmethod
    def word(self, code: Any) -> BlockWord:
        """What the code of a line is to blocks."""

    @abc.abstractmethod
    def text(self, at: int, newline: str, level: int = 0) -> str:
        """Prints the item at an index with its line ends.

        Raises ValueError for a table with a number that none is printed as.
        """

    @abc.abstractmethod
    def respelled(self, at: int, text: str) -> str:
        """The text of an item that is neither a line of the program nor a table, laid out."""

    @abc.abstractmethod
    def rows(self, table: Any, newline: str, indent: int) -> Callable[[Any], str]:
        """Prints rows of a table. indent: blanks more behind the numbers of lines."""

    @abc.abstractmethod
    def as_data(self, item: Any) -> Run | None:
        """A table of data as it is, a line that could be in one as a table, None for others."""

    def levels(self, said: Sequence[Line | None]) -> list[int]:
        """The level of each item, from 0; what is closed but was never opened is passed over."""
        if not self.blocks:
            return [0] * len(said)
        words = [NO_WORD if line is None else self.word(line.code) for line in said]
        blocks = blocks_of(enumerate(words))
        made: list[int] = []
        routine, choice = 0, False
        for at, (line, word) in enumerate(zip(said, words, strict=True)):
            if word.bounds:
                routine = 0
            block = blocks.around[at]
            level = routine if block is None else routine + _level_in_blocks(block, at)
            routine = 1 if word.bounds == "begins" else routine
            if line is not None and line.is_comment:
                level -= choice  # before the first part it is that one's
            elif line is not None:
                choice = bool(word.opens) and word.form == "choice"
                level = max(level - 1, 0) if word.parts else level
            made.append(level)
        return made


def _level_in_blocks(block: Block, at: int) -> int:
    """How much deeper a line is for the blocks that it stands in; in a choice two levels a part."""
    open_there = (one for one in block.chain if one.crossed is None or at < one.crossed)
    return sum(2 if one.form == "choice" else 1 for one in open_there)


def print_items(lines: LinePrinter, newline: str) -> Iterator[str]:
    """The text of each item of a new file, with its line ends."""
    said = list(map(lines.line, lines.items))
    for at, (line, level) in enumerate(zip(said, lines.levels(said), strict=True)):
        text = lines.text(at, newline, level)
        if line is not None and len(text.rstrip("\r\n").encode(errors="replace")) > lines.most:
            text = lines.text(at, newline)  # rather than too long
        yield text

"""What the layout of a text tells about its blocks: where the end of one was forgotten."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Final

TAB: Final = 4
_LINE: Final = re.compile(r"^([ \t]*)([A-Za-z_]\w*)([^\r\n]*)", re.MULTILINE)


def column(text: str, at: int) -> int:
    """How far a word stands from the left; -1 if it is not the first of its line."""
    ahead = text[text.rfind("\n", 0, at) + 1 : at]
    return -1 if ahead.strip() else len(ahead.expandtabs(TAB))


@dataclass(frozen=True, slots=True)
class Layout:
    """First words of lines, in lower case, and what they do to blocks.

    openers: → whether the rest of the line leaves a block open. closers: → the opener that each
    closes. clauses: those that stand as far from the left as the opener. before: those that may
    stand before an opener. code: a line up to its comment.
    """

    openers: Mapping[str, re.Pattern[str]]
    closers: Mapping[str, str]
    clauses: Set[str]
    before: Set[str]
    code: re.Pattern[str]

    def code_end(self, text: str, at: int) -> int:
        """Where the code before an offset ends: behind it are blanks and comments only."""
        while True:
            begin = text.rfind("\n", 0, at) + 1
            line = self.code.match(text[begin:at])
            code = line[0].rstrip() if line else ""
            if code or not begin:
                return begin + len(code)
            at = begin - 1

    def missing_end(self, text: str, begins: Sequence[int], at: int) -> int:
        """Where the end of open blocks was forgotten, as far as indentation tells; else `at`.

        begins: offsets of the blocks, the outermost first.
        """
        if not begins:
            return self.code_end(text, at)
        open_blocks: list[tuple[int, str]] = []
        indented: set[int] = set()
        for start, far, word, rest in _code_lines(text, begins[0], at):
            if open_blocks and far > open_blocks[-1][0]:
                indented.add(len(open_blocks))
            if (closed := self.closers.get(word)) is not None:
                kinds = [kind for _, kind in open_blocks]
                if kinds[-1:] == [closed] and open_blocks[-1][0] == far:
                    indented.discard(len(open_blocks))
                    open_blocks.pop()
                    continue
                if (far, closed) in open_blocks and len(open_blocks) in indented:
                    return self.code_end(text, start)
                while open_blocks and open_blocks.pop()[1] != closed:
                    pass
                continue
            outside = open_blocks and far <= open_blocks[-1][0] and len(open_blocks) in indented
            if outside and word not in self.clauses:
                return self.code_end(text, start)
            if word in self.before:
                word, _, rest = rest.strip().partition(" ")
                word = word.lower()
            if word in self.openers and self.openers[word].search(rest):
                open_blocks.append((far, word))
                indented.discard(len(open_blocks))
        return self.code_end(text, at)


def _code_lines(text: str, start: int, stop: int) -> Iterator[tuple[int, int, str, str]]:
    """Offset, indentation, first word in lower case and the rest of each line of code."""
    begin = text.rfind("\n", 0, start) + 1
    for match in _LINE.finditer(text, begin):
        if match.start(2) >= stop:
            return
        blank, word, rest = match.groups()
        yield match.start(2), len(blank.expandtabs(TAB)), word.lower(), rest

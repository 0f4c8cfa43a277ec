"""What the layout of a text tells about its blocks: where the end of one was forgotten."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Final

TAB: Final = 4
_LINE: Final = re.compile(r"^([ \t]*)([A-Za-z_]\w*)([^\r\n]*)", re.MULTILINE)
_CLAUSES: Final = frozenset(
    {"else", "elseif", "case", "default", "error", "backward", "undo", "local"}
)
_OPENERS: Final = {
    "if": re.compile(r"\bthen\b(?!.*\bendif\b)", re.IGNORECASE),
    "for": re.compile(r"\bdo\b(?!.*\bendfor\b)", re.IGNORECASE),
    "while": re.compile(r"\bdo\b(?!.*\bendwhile\b)", re.IGNORECASE),
    "test": re.compile(r"^(?!.*\bendtest\b)", re.IGNORECASE),
    "proc": re.compile(r"^(?!.*\bendproc\b)", re.IGNORECASE),
    "func": re.compile(r"^(?!.*\bendfunc\b)", re.IGNORECASE),
    "trap": re.compile(r"^(?!.*\bendtrap\b)", re.IGNORECASE),
    "module": re.compile(r"^(?!.*\bendmodule\b)", re.IGNORECASE),
}
"""First word of a line → whether the rest of the line leaves a block open."""


def column(text: str, at: int) -> int:
    """How far a word stands from the left; -1 if it is not the first of its line."""
    ahead = text[text.rfind("\n", 0, at) + 1 : at]
    return -1 if ahead.strip() else len(ahead.expandtabs(TAB))


def code_end(text: str, at: int) -> int:
    """Where the code before an offset ends: behind it are blanks and comments only."""
    while True:
        begin = text.rfind("\n", 0, at) + 1
        line = re.match(r'(?:"[^"\n]*"|[^!"\n])*', text[begin:at])
        code = line[0].rstrip() if line else ""
        if code or not begin:
            return begin + len(code)
        at = begin - 1


def missing_end(text: str, openers: Sequence[tuple[str, int]], at: int) -> int:
    """Where the end of the open blocks was forgotten, as far as indentation tells; else `at`.

    openers: their words and offsets, the outermost first.
    """
    begins = [begin for _, begin in openers if begin >= 0]
    if not begins:
        return code_end(text, at)
    open_blocks: list[tuple[int, str]] = []
    indented: set[int] = set()
    for start, far, word, rest in _lines(text, begins[0], at):
        if open_blocks and far > open_blocks[-1][0]:
            indented.add(len(open_blocks))
        if word.startswith("end") and word[3:] in _OPENERS:
            kinds = [kind for _, kind in open_blocks]
            if kinds[-1:] == [word[3:]] and open_blocks[-1][0] == far:
                indented.discard(len(open_blocks))
                open_blocks.pop()
                continue
            if (far, word[3:]) in open_blocks and len(open_blocks) in indented:
                return code_end(text, start)
            while open_blocks and open_blocks.pop()[1] != word[3:]:
                pass
            continue
        outside = open_blocks and far <= open_blocks[-1][0] and len(open_blocks) in indented
        if outside and word not in _CLAUSES:
            return code_end(text, start)
        if word == "local":
            word, _, rest = rest.strip().partition(" ")
            word = word.lower()
        if word in _OPENERS and _OPENERS[word].search(rest):
            open_blocks.append((far, word))
            indented.discard(len(open_blocks))
    return code_end(text, at)


def _lines(text: str, start: int, stop: int) -> Iterator[tuple[int, int, str, str]]:
    """Offset, indentation, first word in lower case and the rest of each line of code."""
    begin = text.rfind("\n", 0, start) + 1
    for match in _LINE.finditer(text, begin):
        if match.start(2) >= stop:
            return
        blank, word, rest = match.groups()
        yield match.start(2), len(blank.expandtabs(TAB)), word.lower(), rest

"""Tree to text: a line each, two blanks deeper in every block."""

from __future__ import annotations

from collections.abc import Iterator

from . import tables
from .tree import File, Value, word_of


def render(file: File) -> str:
    """The text; of a file that is as it was read, the very text."""
    if file.source is not None and file.lines is file.read:
        return file.source.text
    return laid_out(file)


def laid_out(file: File) -> str:
    """The text in the one layout."""
    newline = file.source.newline if file.source else "\r\n"
    return "".join(line + newline for line in _lines(file))


def _lines(file: File) -> Iterator[str]:
    depth = 0
    for line in file.lines:
        if line.word == "procedure":
            yield ""
        word = word_of(line)
        depth -= bool(word.parts or word.closes)
        yield ("  " * depth + " ".join((line.word, *map(_value, line.values)))).rstrip()
        depth += bool(word.opens or word.parts)


def _value(value: Value) -> str:
    if isinstance(value, float):
        return f"{value:.{tables.DECIMALS}f}".rstrip("0").rstrip(".")
    return str(value)

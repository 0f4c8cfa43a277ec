"""Texts that are too long for a line."""

from __future__ import annotations

import re


def wrapped(text: str, most: int, mark: str) -> list[str]:
    """A text cut between words, into parts of at most so many bytes in UTF-8.

    mark: that further parts begin with. A word that is too long by itself is cut.
    """
    if _size(text) <= most:
        return [text]
    parts, line = list[str](), ""
    for piece in re.split(r"(?<= )", text):
        for part in piece if _size(piece) > most - _size(mark) else [piece]:
            if _size(line + part) > most:
                parts.append(line.rstrip())
                line = mark
            line += part
    return [*parts, line.rstrip()]


def _size(text: str) -> int:
    return len(text.encode("utf-8"))

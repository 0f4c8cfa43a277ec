"""Texts that are too long for a line."""

from __future__ import annotations

import re


def wrapped_text(text: str, most: int, mark: str) -> list[str]:
    """A text cut between words, into parts of at most so many bytes in UTF-8.

    mark: that further parts begin with. A word that is too long by itself is cut.
    """
    if _utf8_size(text) <= most:
        return [text]
    parts, line = list[str](), ""
    for piece in re.split(r"(?<= )", text):
        for part in piece if _utf8_size(piece) > most - _utf8_size(mark) else [piece]:
            if _utf8_size(line + part) > most:
                parts.append(line.rstrip())
                line = mark
            line += part
    return [*parts, line.rstrip()]


def _utf8_size(text: str) -> int:
    return len(text.encode("utf-8"))

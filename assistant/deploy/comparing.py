"""Modules in a controller's memory, compared by what they say.

A controller prints a module from its memory in its own layout, and data with the values that it
has now. So a text that came back from there is no difference by itself; a value is.
"""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from functools import lru_cache

from assistant import languages
from assistant.base.source_text import decode, lines_of, visible


def module_form(data: bytes, language: str) -> bytes:
    """What a module says, a line each declaration or statement, without its layout."""
    return "\r\n".join(form for form, _ in _module_pieces(data, language)).encode()


def module_difference(
    before: bytes, after: bytes, language: str, labels: tuple[str, str], around: int = 3
) -> str:
    """A unified diff of two states of a module, "" if they say the same.

    What says the same is shown as it stands in the first. around: lines of context.
    """
    written: dict[str, str] = {}
    left, right = (
        [written.setdefault(form, text) for form, text in _module_pieces(data, language)]
        for data in (before, after)
    )
    lines = difflib.unified_diff(
        _visible_lines(left), _visible_lines(right), *labels, n=around, lineterm=""
    )
    return "".join(f"{line}\n" for line in lines)


@lru_cache(maxsize=32)
def _module_pieces(data: bytes, language: str) -> tuple[tuple[str, str], ...]:
    spoken = languages.get(language)
    return tuple(spoken.said(decode(data, None, (*spoken.encodings, "latin-1")).text))


def _visible_lines(texts: Sequence[str]) -> list[str]:
    """With no character in them that a terminal would obey."""
    lines = (line for text in texts for line in lines_of(text))
    return [visible(line.rstrip()) for line in lines if line.strip()]

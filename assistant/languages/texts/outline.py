"""Sections of an emitted text, which a template of programs puts in its frame."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

Numbering = Callable[[Sequence[str]], list[str]]
"""Gives the lines of a text their step numbers."""


@dataclass(frozen=True, slots=True)
class Outline:
    """How the text of a new program is divided, and what a template may write around it.

    template: its file in `templates/`. sections: divides a text; the text of each section by its
    name, together all of it but the frame. within: sections that are parts of others: of which,
    and how they are taken. name: of the program, as its text has it. frame: patterns of lines that
    a template writes beside comments, by their names, with `{name}` for that of the program.
    rank: the order of sections and of the frame; those of one rank may change places.
    complete: sections and frame lines that each template has once, one of these tuples.
    item: true of a comment that readers take for a statement about the program. numbered: how
    lines of a dialect get their numbers, None where they have none. blank: true if a text may have
    blank lines. ends: the section below which a template writes no comments, empty for none.
    """

    template: str
    sections: Callable[[str], Mapping[str, str]]
    within: Mapping[str, tuple[str, Callable[[str], str]]]
    name: Callable[[str], str]
    rank: Mapping[str, int]
    complete: tuple[tuple[str, ...], ...]
    item: Callable[[str], bool]
    frame: Mapping[str, str]
    numbered: Callable[[str], Numbering | None]
    blank: bool
    ends: str = ""

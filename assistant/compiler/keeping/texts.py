"""The text of a merged program, with what people wrote beside the program itself."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from assistant.base.source_text import comments
from assistant.deploy.text_merge import says_the_same
from assistant.program.program import Program

if TYPE_CHECKING:
    from assistant.languages import Language
    from assistant.robots import Robot

TEXT_WORD: Final = re.compile(r'"[^"\r\n]*"|[A-Za-z_]\w*|[^\w\s]')


def merged_text(
    language: Language[Any],
    program: Program,
    sides: tuple[Program, Program, Program],
    arm: Robot | None,
) -> Iterator[bytes]:
    """A merged program in the text that was compiled now, or in that of the file, or both.

    sides: the programs that it was made of: as it was written, as it is in the file, as it is now.
    That of the file is the first where it says what its program does not, as how data are declared
    and comments; it is none where the new one has changed that as well.
    """
    base, edited, made = sides
    whole, there = _in_text_of(language, edited, base, arm), _printed_bytes(language, edited)
    if says_the_same(whole, there, bytes):
        yield _in_text_of(language, program, made, arm)
        return
    now = _in_text_of(language, made, base, arm)
    if _words_in(language, now) == _words_in(language, _printed_bytes(language, made)):
        yield _in_text_of(language, program, edited, arm)
    if _words_in(language, whole) == _words_in(language, there):
        yield _in_text_of(language, program, made, arm)


def lost_comments(language: Language[Any], sides: tuple[bytes, bytes, bytes]) -> list[str]:
    """The comments that somebody wrote and that are not in the merged text.

    sides: as it was written, as it is in the file, as it is merged.
    """
    old, now, new = (Counter(_comments_in(language, data)) for data in sides)
    return [comment for comment in (now - old) - new if comment]


def _in_text_of(
    language: Language[Any], program: Program, text_of: Program, arm: Robot | None
) -> bytes:
    """A program in the text that another one was read from, as far as that says the same."""
    return language.encode(language.lower(replace(program, origin=text_of.origin), arm))


def _printed_bytes(language: Language[Any], program: Program) -> bytes:
    assert program.origin is not None
    return language.encode(program.origin.trees[0])


def _comments_in(language: Language[Any], data: bytes) -> Iterator[str]:
    text, mark = language.decode(data).text, language.comment_mark
    for span in comments(text, mark):
        yield text[span.start + len(mark) : span.end].strip()


def _words_in(language: Language[Any], data: bytes) -> Counter[str]:
    """The words of a text in any order, without its comments and numbers."""
    text, mark = language.decode(data).text, language.comment_mark
    plain, at = [], 0
    for span in comments(text, mark):
        plain.append(text[at : span.start])
        at = span.end
    plain.append(text[at:])
    return Counter(found[0] for found in TEXT_WORD.finditer("".join(plain)))

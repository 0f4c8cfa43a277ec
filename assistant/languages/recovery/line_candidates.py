"""Changes that may mend a line, in the order in which they are preferred at the same cost."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from difflib import get_close_matches
from typing import Final

from assistant.languages.lalr import END
from assistant.languages.recovery.edits import Edit
from assistant.languages.recovery.lexemes import Lexeme, Stop
from assistant.languages.recovery.line_syntax import LineSyntax

CLEAR, NEAR, UNCLEAR, TEXT, DELETED, CUT = 1, 2, 5, 6, 7, 9
"""Costs of a change: what is known, guessed, taken out."""
ALIKE: Final = 0.74
"""How much two words have in common of which one may be meant for the other."""
_TWO_WORDS: Final = re.compile(r"[ \t]*([A-Za-z]\w*)(?:[ \t]+([A-Za-z]\w*))?")
_TEXT: Final = re.compile(r"(?:[^\W\d]|[.:>-]).*")


def line_candidates(
    syntax: LineSyntax,
    text: str,
    code: int,
    stop: Stop,
    read: tuple[Lexeme, ...],
    fitting: frozenset[str],
) -> Iterator[Edit]:
    """Changes to a line.

    code: offset of its code. read: the words before the one that does not fit.
    fitting: terminals that would have fitted.
    """
    error = stop.word.start
    yield from _comment_out_prose(syntax, text, code)
    yield from _replace_foreign_words(syntax, text, code, error)
    for mistake in syntax.mistakes:
        if edit := mistake.edit(text, code, error, CLEAR):
            yield edit
    yield from _correct_words(syntax, stop, read, fitting)
    yield from _another_statement(syntax, text, stop, fitting)
    yield from _insert_word(syntax, text, stop, fitting)
    yield from _delete_words(syntax, text, stop, fitting)


def _comment_out_prose(syntax: LineSyntax, text: str, code: int) -> Iterator[Edit]:
    """A line that is plain words."""
    found = syntax.prose.match(text, code)
    if found and "=" not in found[0] and not syntax.begins(found[1]):
        what, cure = "this is text, not a statement", f"write `{syntax.comment}` before it"
        yield Edit(found.start(1), len(text), syntax.comment, what, cure, NEAR)


def _replace_foreign_words(syntax: LineSyntax, text: str, code: int, error: int) -> Iterator[Edit]:
    """Words of other languages at the begin of a statement."""
    begins = [code, *(found.end() for found in syntax.branch.finditer(text, code, error))]
    for begin in begins:
        found = _TWO_WORDS.match(text, begin)
        if found is None:
            continue
        for size in (2, 1):
            said = " ".join(word for word in found.groups()[:size] if word)
            known = syntax.foreign.get(said.lower())
            if known is not None and found[size] is not None:
                write, cure = known
                start, end = found.start(1), found.end(size)
                what = f"`{text[start:end]}` is no word of {syntax.title}"
                edit = Edit(start, end, write, what, cure, CLEAR)
                yield edit
                # and without what stands behind it
                yield replace(edit, end=len(text), text=syntax.comment, cost=UNCLEAR)
                break


def _correct_words(
    syntax: LineSyntax, stop: Stop, read: tuple[Lexeme, ...], fitting: frozenset[str]
) -> Iterator[Edit]:
    """Words that are nearly one of the language; the nearest to the error first."""
    here = [stop.word] if stop.word.type == "NAME" else []
    for word in reversed([word for word in (*read, *here) if word.type in syntax.names]):
        written = word.text
        if written.upper() in syntax.keywords and word is not stop.word:
            continue
        if (size := syntax.parted(written)) is not None:
            what = f"`{written}` has no blank behind `{written[:size]}`"
            parted, cure = f"{written[:size]} {written[size:]}", "write a blank between the two"
            yield Edit(word.start, word.end, parted, what, cure, NEAR)
        known = syntax.words
        if word is stop.word:
            known = [w for w, types in syntax.keywords.items() if fitting & set(types)]
        for near in get_close_matches(written.upper(), known, n=3, cutoff=ALIKE):
            meant = syntax.spelled(near)
            what = f"`{written}` is not known: is it `{meant}`?"
            cost = NEAR + (word is not stop.word)
            yield Edit(word.start, word.end, meant, what, f"write `{meant}`", cost)


def _another_statement(
    syntax: LineSyntax, text: str, stop: Stop, fitting: frozenset[str]
) -> Iterator[Edit]:
    """A second statement behind a whole one."""
    start = stop.word.start
    if END not in fitting or stop.word.type == END:
        return
    try:
        node = syntax.grammar.read(text, start, len(text), syntax.line, syntax.nodes(None), None)
    except ValueError:
        return
    if syntax.is_whole(node):
        second = text[start:].partition(syntax.comment)[0].strip()
        what, cure = "a line holds one statement", f"put `{second}` on a line of its own"
        yield Edit(start, len(text), syntax.comment, what, cure, NEAR)


def _insert_word(
    syntax: LineSyntax, text: str, stop: Stop, fitting: frozenset[str]
) -> Iterator[Edit]:
    """A word put in before the one that does not fit."""
    at, word = stop.word.start, stop.word
    behind = len(text[:at].rstrip()) if word.type in (END, *syntax.comments) else at
    for terminal, (written, named, cure, cost) in syntax.missing.items():
        if terminal in fitting and not (terminal == "EQUALS" and "=" in text[:at]):
            found = text[word.start : word.end]
            before = f" before `{found}`" if found and word.type != "COMMENT" else ""
            yield Edit(behind, behind, written, f"{named} is missing{before}", cure, cost)


def _delete_words(
    syntax: LineSyntax, text: str, stop: Stop, fitting: frozenset[str]
) -> Iterator[Edit]:
    """The word that does not fit, or all that stands from it on."""
    start, end = stop.word.start, max(stop.word.end, stop.word.start + 1)
    mark = syntax.comment
    word = text[start:end]
    listed = syntax.expected(fitting)
    also = f"; expected {listed}" if listed else ""
    if stop.word.type == END:
        what = "the line ends too early" + also
        yield Edit(start, start, mark, what, "complete the statement", CUT)
        return
    what = f"`{word}` cannot stand here{also}"
    if word == ")":
        yield Edit(start, end, "", "a `)` has no `(`", "take it out, or write the `(`", NEAR)
    yield Edit(start, end, "", what, f"take `{word}` out, or write what it should be", DELETED)
    if END in fitting and _TEXT.match(text, start):
        said, cure = "text stands behind the statement", f"write `{mark}` before a comment"
        yield Edit(start, len(text), mark, said, cure, TEXT)
    cure = f"write one statement a line; text behind it needs a `{mark}` before it"
    yield Edit(start, len(text), mark, what, cure, CUT)

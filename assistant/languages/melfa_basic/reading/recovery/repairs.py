"""Changes that may mend a line where the table of usual mistakes knows none."""

from __future__ import annotations

import re
from collections.abc import Iterator
from difflib import get_close_matches
from functools import cache
from typing import Final

from assistant.languages.lalr import END
from assistant.languages.melfa_basic.reading.driver import Lexeme, Stop, drive
from assistant.languages.melfa_basic.reading.grammar import keywords
from assistant.languages.melfa_basic.reading.nodes import Nodes
from assistant.languages.melfa_basic.reading.recovery.mistakes import MISTAKES, Edit, foreign
from assistant.languages.melfa_basic.reading.recovery.wording import expected
from assistant.languages.melfa_basic.tables.vocabulary import statement, words
from assistant.languages.melfa_basic.tree.syntax import Line

CLEAR, NEAR, MISSING, UNCLEAR, TEXT, DELETED, CUT = 1, 2, 4, 5, 6, 7, 9
"""Costs of a change: what is known, guessed, put in, taken out."""

_INSERTED: Final = {
    "THEN": (" Then ", "`Then` is missing", "write `Then` behind the condition", MISSING),
    "RPAR": (")", "a `)` is missing", "write it, or take out the `(` that it belongs to", MISSING),
    "COMMA": (",", "a comma is missing", "write `,` between the two", MISSING),
    "EQUALS": ("=", "a `=` is missing", "write `=` between the two", UNCLEAR),
    "TO": (" To ", "`To` is missing", "write `To` between first and last value", MISSING),
    "AS": (" As ", "`As` is missing", "write `As #1` with the number of the line", MISSING),
    "NUMBER": (" 1 ", "a value is missing", "write a number or a variable", UNCLEAR),
    "NAME": (" M1 ", "a name is missing", "write a variable", UNCLEAR),
    "GOTO": (" GoTo ", "`GoTo` is missing", "write `GoTo` or `GoSub` before the label", UNCLEAR),
    "TIMES": ("*", "an operator is missing", "write `+`, `-`, `*` or `/` between the two", TEXT),
    "HASH": ("#", "a `#` is missing", "write `#` before the number", MISSING),
    "LABEL": ("*L", "a label is missing", "write `*` and the label's name", UNCLEAR),
    "STRING": ('"x"', "a text is missing", "write it between quotes", UNCLEAR),
    "SKIP": (" Skip ", "a statement is missing", "write what is to be done", UNCLEAR),
    "POSITION": ("(0,0)", "a constant is missing", "write the constant", UNCLEAR),
}
"""What is put in: its text, what is said, the cure and the cost."""


def candidates(
    text: str, code: int, stop: Stop, read: tuple[Lexeme, ...], fitting: frozenset[str]
) -> Iterator[Edit]:
    """Changes to a line in the order in which they are to be preferred at the same cost.

    code: offset of its code. read: the words before the one that does not fit.
    fitting: terminals that would have fitted.
    """
    error = stop.word.start
    yield from _prose(text, code)
    yield from _foreign(text, code, error)
    for mistake in MISTAKES:
        if edit := mistake.edit(text, code, error, len(text)):
            yield _costing(edit, CLEAR)
    yield from _near(text, stop, read, fitting)
    yield from _another_statement(text, stop, fitting)
    yield from _inserted(text, stop, fitting)
    yield from _taken_out(text, stop, fitting)


def _costing(edit: Edit, cost: int) -> Edit:
    return Edit(edit.start, edit.end, edit.text, edit.what, edit.cure, edit.number, cost)


def _prose(text: str, code: int) -> Iterator[Edit]:
    """A line that is plain words."""
    found = _PROSE.match(text, code)
    if found and statement(found[1]) is None and "=" not in found[0]:
        end = len(text)
        yield Edit(
            found.start(1), end, "'", "this is text, not a statement",
            "write `'` before it", cost=NEAR,
        )  # fmt: skip


_PROSE: Final = re.compile(r"[ \t]*([^\W\d]+)(?:[ ,]+[^\W\d][\w'-]*){2,}[ \t.!?:]*$")


def _foreign(text: str, code: int, error: int) -> Iterator[Edit]:
    """Words of other languages at the begin of a statement."""
    begins = [code, *(found.end() for found in _BRANCH.finditer(text, code, error))]
    for begin in begins:
        found = _TWO_WORDS.match(text, begin)
        if found is None:
            continue
        for size in (2, 1):
            said = " ".join(word for word in found.groups()[:size] if word)
            known = foreign().get(said.lower())
            if known is not None and found[size] is not None:
                yield from _translated(text, found.start(1), found.end(size), *known)
                break


_BRANCH: Final = re.compile(r"\b(?:Then|Else|Wth)\b|^[ \t]*\*\w+[ \t]*:", re.IGNORECASE)
_TWO_WORDS: Final = re.compile(r"[ \t]*([A-Za-z]\w*)(?:[ \t]+([A-Za-z]\w*))?")


def _translated(text: str, start: int, end: int, write: str, cure: str) -> Iterator[Edit]:
    """The word replaced, with and without what stands behind it."""
    what = f"`{text[start:end]}` is no word of MELFA-BASIC"
    yield Edit(start, end, write, what, cure, cost=CLEAR)
    yield Edit(start, len(text), "'", what, cure, cost=UNCLEAR)


def _near(
    text: str, stop: Stop, read: tuple[Lexeme, ...], fitting: frozenset[str]
) -> Iterator[Edit]:
    """Words that are nearly one of the language; the nearest to the error first."""
    here = [stop.word] if stop.word.type == "NAME" else []
    names = [word for word in (*read, *here) if word.type in ("NAME", "FN_NAME")]
    for word in reversed(names):
        written = text[word.start : word.end]
        if written.upper() in keywords() and word is not stop.word:
            continue
        yield from _run_together(word, written)
        known = _fit_words(fitting) if word is stop.word else _words()
        for near in get_close_matches(written.upper(), known, n=3, cutoff=0.74):
            meant = near if (row := statement(near)) is None else row.word
            yield Edit(
                word.start, word.end, meant, f"`{written}` is not known: is it `{meant}`?",
                f"write `{meant}`", cost=NEAR + (word is not stop.word),
            )  # fmt: skip


def _run_together(word: Lexeme, written: str) -> Iterator[Edit]:
    """A word and what belongs behind a blank: `MOVP1`, `GOTO100`, `DLY1`."""
    for size in range(len(written) - 1, 1, -1):
        known = statement(written[:size])
        if known is not None and known.role != "part" and _OPERAND.match(written, size):
            yield Edit(
                word.start, word.end, f"{written[:size]} {written[size:]}",
                f"`{written}` has no blank behind `{written[:size]}`",
                "write a blank between the two", cost=NEAR,
            )  # fmt: skip
            return


_OPERAND: Final = re.compile(r"\d|[PJMC]\w*\d|[PJ]\w{2}", re.IGNORECASE)


@cache
def _words() -> tuple[str, ...]:
    return tuple(
        dict.fromkeys(
            [w for w in keywords() if len(w) > 1]
            + [word.upper() for word in (*words("motion"), *words("command"))]
        )
    )


@cache
def _fit_words(fitting: frozenset[str]) -> tuple[str, ...]:
    return tuple(w for w, types in keywords().items() if fitting & set(types))


def _another_statement(text: str, stop: Stop, fitting: frozenset[str]) -> Iterator[Edit]:
    """A second statement behind a whole one."""
    start = stop.word.start
    if END not in fitting or stop.word.type == END:
        return
    node = drive(text, start, len(text), "line", Nodes())
    if isinstance(node, Line) and node.statement is not None:
        second = text[start:].partition("'")[0].strip()
        yield Edit(
            start, len(text), "'", "a line holds one statement",
            f"put `{second}` on a line of its own", cost=NEAR,
        )  # fmt: skip


def _inserted(text: str, stop: Stop, fitting: frozenset[str]) -> Iterator[Edit]:
    """A word put in before the one that does not fit."""
    at = stop.word.start
    behind = len(text[:at].rstrip()) if stop.word.type in (END, "COMMENT", "REM") else at
    for terminal, (written, what, cure, cost) in _INSERTED.items():
        if terminal in fitting and not (terminal == "EQUALS" and "=" in text[:at]):
            found = text[stop.word.start : stop.word.end]
            before = f" before `{found}`" if found and stop.word.type not in ("COMMENT",) else ""
            yield Edit(behind, behind, written, what + before, cure, cost=cost)


def _taken_out(text: str, stop: Stop, fitting: frozenset[str]) -> Iterator[Edit]:
    """The word that does not fit, or all that stands from it on."""
    start, end = stop.word.start, max(stop.word.end, stop.word.start + 1)
    word = text[start:end]
    listed = expected(fitting)
    also = f"; expected {listed}" if listed else ""
    if stop.word.type == END:
        what = "the line ends too early" + also
        yield Edit(start, start, "'", what, "complete the statement", cost=CUT)
        return
    what = f"`{word}` cannot stand here{also}"
    if word == ")":
        yield Edit(start, end, "", "a `)` has no `(`", "take it out, or write the `(`", cost=NEAR)
    yield Edit(start, end, "", what, f"take `{word}` out, or write what it should be", cost=DELETED)
    if END in fitting and _TEXT.match(text, start):
        yield Edit(
            start, len(text), "'", "text stands behind the statement",
            "write `'` before a comment", cost=TEXT,
        )  # fmt: skip
    cure = "write one statement a line; text behind it needs a `'` before it"
    yield Edit(start, len(text), "'", what, cure, cost=CUT)


_TEXT: Final = re.compile(r"(?:[^\W\d]|[.:>-]).*")

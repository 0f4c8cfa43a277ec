"""A RAPID text as what stands on lines of their own: statements, headings, ends, comments."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from assistant.languages.laying_out import Form, Segment
from assistant.languages.rapid.text.layout.tokens import tokens
from assistant.languages.words import Word


def segments(text: str) -> Iterator[Segment]:
    """The segments of a text that the grammar takes; of any other text some segments."""
    read = list(tokens(text))
    at, breaks = 0, 1
    while at < len(read):
        token = read[at]
        match token.kind:
            case "break":
                at, breaks = at + 1, breaks + 1
                continue
            case "comment" | "rows" | "header":
                form: Form = token.kind
                yield Segment(form, "", [token], breaks)
                at, breaks = at + 1, int(token.kind == "rows")
            case _:
                end = _end(read, at)
                inside = read[at:end]
                word = _word(inside)
                yield Segment(_form(word, inside), word, inside, breaks)
                at, breaks = end, 0


_OPENS: Final = frozenset({"module", "record", "proc", "func", "trap", "for", "while", "test"})
_DIVIDES: Final = frozenset(
    {"else", "elseif", "<eit>", "case", "<cse>", "default", "backward", "error", "undo"}
)
_CLOSES: Final = frozenset(f"end{word}" for word in {*_OPENS, "if"})
_ALONE: Final = (_DIVIDES | _CLOSES | {"<smt>", "<ddn>", "<tdn>", "<rdn>"}) - {"elseif", "case"}
_ENDED_BY: Final = {
    "elseif": {"then"},
    "for": {"do"},
    "while": {"do"},
    "case": {":"},
    "default": {":"},
    "if": {"then", ";", "<smt>"},
}
_ENDED_BEFORE: Final = {"test": {"case", "<cse>", "default", "endtest"}}
_NAMED: Final = frozenset({"module", "record", "trap"})
_BRACKETED: Final = frozenset({"module", "proc", "func", "error"})
"""Segments that end with a pair of parentheses, if one follows."""


def _word(inside: list[Word]) -> str:
    for token in inside:
        if token.kind in ("key", "hole") and token.text.lower() not in ("local", "task"):
            return token.text.lower()
        if token.kind not in ("key", "break", "comment"):
            break
    return ""


def _form(word: str, inside: list[Word]) -> Form:
    if word in _OPENS or (word == "if" and inside[-1].text.lower() == "then"):
        return "opens"
    if word in _DIVIDES:
        return "divides"
    return "closes" if word in _CLOSES else "plain"


def _end(read: list[Word], start: int) -> int:
    """Index behind the last token of the segment that begins at an index."""
    seen = _significant(read, start)
    at = next(seen)
    word = read[at].text.lower()
    if word in ("local", "task"):
        at = next(seen, at)
        word = read[at].text.lower()
    if word in _ENDED_BEFORE:
        for following in seen:
            if read[following].text.lower() in _ENDED_BEFORE[word]:
                break
            at = following
        return at + 1
    if word in _NAMED or word in ("proc", "func", "error"):
        return _end_of_heading(read, at, word)
    if word in _ALONE and word not in _ENDED_BY:
        return at + 1
    stops = _ENDED_BY.get(word, {";"})
    label = read[at].kind == "word"
    for number, following in enumerate(seen):
        text = read[following].text.lower()
        at = following
        if text in stops or (label and number == 0 and text == ":"):
            break
    return at + 1


def _end_of_heading(read: list[Word], at: int, word: str) -> int:
    """Behind the parentheses of a heading, or behind its name if it has none."""
    depth, last = 0, at
    names = 1 if word in _NAMED else 0
    for following in _significant(read, at + 1):
        text = read[following].text
        if text == "(" and word in _BRACKETED:
            depth += 1
        elif text == ")" and depth:
            depth -= 1
            if not depth:
                return following + 1
        elif not depth:
            if word in ("proc", "func"):
                pass
            elif names:
                names -= 1
            else:
                return last + 1
        last = following
    return last + 1


def _significant(read: list[Word], start: int) -> Iterator[int]:
    """Indices of what the grammar sees; a table inside a statement is taken apart on the way."""
    at = start
    while at < len(read):
        token = read[at]
        if token.kind == "rows":  # its first line ends the statement that stands before it
            length = token.text.find("\n") + 1 or len(token.text)
            first = tokens(token.text[:length], rows=False, start=token.start)
            rest = Word("rows", token.text[length:], token.start + length)
            read[at : at + 1] = [*first, *([rest] if rest.text else [])]
            continue
        if token.kind not in ("break", "comment"):
            yield at
        at += 1

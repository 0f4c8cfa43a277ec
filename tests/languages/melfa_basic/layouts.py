"""The same program in another layout: blanks, line ends, case of words, spelling of numbers."""

from __future__ import annotations

import random
import re
from typing import Final

from assistant.languages.melfa_basic.tables import vocabulary

TOKENS: Final = re.compile(
    r"""(?P<comment>'[^\r\n]*|\bREM(?![A-Z0-9_])[^\r\n]*) | (?P<string>"[^"\r\n]*")
    | (?P<word>\#INCLUDE|[A-Z]\w*[$%&!\#]?)
    | (?P<number>(?:(?<=[(,])[+-])?(?:&H[0-9A-F]+|&B[01]+|(?:\d+\.?\d*|\.\d+)(?:E[+-]?\d+)?)
      [%&!\#]?)
    | (?P<mark><>|><|<=|=<|>=|=>|<<|>>|\S)""",
    re.VERBOSE | re.IGNORECASE,
)
BLANKS: Final = ("", "", "", " ", " ", "  ", "\t", " \t ")
LINE_ENDS: Final = ("\n", "\n", "\r\n", "\r\n")

KEYWORDS: Final = {
    part.upper()
    for row in vocabulary.statements().values()
    for part in row.word.split()
    if row.role != "part" or row.word.upper() in ("AND", "OR", "NOT", "XOR", "MOD", "THEN", "TO")
} - {word.upper() for row in vocabulary.statements().values() for word in row.words}
"""Words in any case, but for those that may be an argument, which keep their spelling."""


def scattered(text: str, chance: random.Random) -> str:
    """A printed text whose tokens are laid out at random, and which means the same."""
    tokens = list(TOKENS.finditer(text))
    if not tokens:
        return text
    out = [_line_ends(text[: tokens[0].start()].count("\n"), chance)]
    for number, token in enumerate(tokens):
        if number:
            before = tokens[number - 1]
            out.append(_gap(text[before.end() : token.start()], before, token, chance))
        out.append(_spelled(token, chance))
    blank = text[tokens[-1].end() :].count("\n") - 1
    end = _line_ends(blank + 1, chance) if blank else chance.choice(("", "\n", "\r\n"))
    return "".join((*out, end))


def _line_ends(count: int, chance: random.Random) -> str:
    return "".join(chance.choice(LINE_ENDS) for _ in range(count))


def _gap(printed: str, before: re.Match[str], after: re.Match[str], chance: random.Random) -> str:
    lines = printed.count("\n")
    if lines:
        trailing = "" if before["comment"] else chance.choice(BLANKS)
        return trailing + _line_ends(lines, chance) + chance.choice(BLANKS)
    blank = chance.choice(BLANKS)
    if not printed and after[0] in "(" and before["word"]:
        return blank
    return blank or ("" if _parts_words(before, after) else " ")


def _parts_words(before: re.Match[str], after: re.Match[str]) -> bool:
    """Whether two tokens are two without a blank between."""
    if before["string"] is not None or after["string"] is not None:
        return True
    marks = ("mark", "comment")
    if after["comment"] is not None:
        return after[0].startswith("'")
    return before.lastgroup in marks or after.lastgroup in marks


def _spelled(token: re.Match[str], chance: random.Random) -> str:
    text = token[0]
    if token["word"] is not None and text.upper() in KEYWORDS:
        return chance.choice((text, text.lower(), text.upper(), text.title()))
    if token["number"] is not None and chance.random() < 0.3:
        if text.startswith("0."):
            return text[1:]
        if "." in text and text[-1].isdigit() and "E" not in text:
            return text + "0"
        return text.lower()
    return text

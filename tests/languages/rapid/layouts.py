"""The same program in another layout: blanks, line ends, case of words, comments inside."""

from __future__ import annotations

import random
import re
from typing import Final

from assistant.languages.rapid.tables.constants import RESERVED

TOKENS: Final = re.compile(
    r"""(?P<header>\A%%%(?s:.*?)%%%) | (?P<string>"(?:[^"\\]|""|\\\\|\\[0-9A-F]{2})*")
    | (?P<comment>![^\r\n]*) | (?P<hole><[A-Z]{2,3}>) | (?P<name>[^\W\d]\w*)
    | (?P<number>0[xobd][0-9a-f]+|(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?) | (?P<mark>:=|<=|>=|<>|\S)""",
    re.VERBOSE | re.IGNORECASE,
)
BLANKS: Final = ("", "", "", " ", " ", "  ", "\t", " \t ")
EDGES: Final = (*BLANKS, "\f", " \f")
"""At either end of a line; inside, a form feed is an error."""
LINE_ENDS: Final = ("\n", "\n", "\r\n", "\r\n", "\n\n", "\n  \r\n")
INSIDE: Final = (",", ":=", "(", "[", "{")
"""Marks behind which a statement goes on, so that a comment there is none of the tree."""


def scattered(text: str, chance: random.Random) -> str:
    """A printed text whose tokens are laid out at random, and which means the same."""
    tokens = list(TOKENS.finditer(text))
    out: list[str] = []
    for number, token in enumerate(tokens):
        before = tokens[number - 1] if number else None
        if before is not None:
            out.append(_gap(text[before.end() : token.start()], before, token, chance))
            if token[0] == "\\" and _ends_argument(tokens, number - 1) and chance.random() < 0.3:
                out.append(",")
        out.append(_spelled(token, chance))
    return "".join((*out, chance.choice(("", "\n", "\r\n", " "))))


def _gap(printed: str, before: re.Match[str], after: re.Match[str], chance: random.Random) -> str:
    if after["comment"] is not None:
        breaks = "\n" in printed
    elif before["comment"] is not None:
        breaks = True
    else:
        breaks = chance.random() < 0.15
        if before[0] in INSIDE and chance.random() < 0.03:
            return f" ! between{chance.choice(LINE_ENDS)}"
    if breaks:
        return chance.choice(EDGES) + chance.choice(LINE_ENDS) + chance.choice(EDGES)
    return chance.choice(BLANKS) or printed[:1].replace("\r", " ").replace("\n", " ")


def _ends_argument(tokens: list[re.Match[str]], at: int) -> bool:
    """Whether an argument or parameter ends with that token, where a comma may follow."""
    token = tokens[at]
    if token["name"] is not None:
        return tokens[at - 1][0] == ","
    return token["number"] is not None or token["string"] is not None or token[0] in "])}"


def _spelled(token: re.Match[str], chance: random.Random) -> str:
    word = token[0].lower() in RESERVED or (token["hole"] is not None and token[0] != "<ID>")
    return chance.choice((token[0], token[0].lower(), token[0].title())) if word else token[0]

"""Odd but valid layouts of RAPID: blanks, lines, comments and the case of words."""

from __future__ import annotations

import re
from random import Random
from typing import Final

_TOKEN: Final = re.compile(r'"(?:[^"]|"")*"|![^\n]*|\b[A-Za-z]\w*|[ ]+|:=|<=|>=|<>|.|\n', re.DOTALL)


def odd(text: str, rng: Random) -> str:
    """The same program, laid out by chance; comments and strings stay."""
    style = rng.random()
    if style < 0.4:
        return text
    case = rng.choice((str, str, str.upper, str.lower))
    made = []
    for token in _TOKEN.findall(text):
        if token[0] in '"!\n':
            made.append(token)
        elif token.isspace():
            made.append(rng.choice((token, token, "  ", "\t", "\n" if style > 0.9 else token)))
        elif token[0].isalpha():
            made.append(case(token))
        elif token in (":=", ",", "+", "[") and style > 0.7 and rng.random() < 0.3:
            made.append(rng.choice((f" {token} ", token + " ", f"{token}\t")))
        else:
            made.append(token)
    text = "".join(made)
    return text.replace("\n", "\r\n") if rng.random() < 0.3 else text

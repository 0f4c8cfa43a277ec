"""What a module says, without its layout: how two states of a module in memory are compared.

A controller keeps the words of a module that it has loaded, but not how they stood: blanks, line
ends and where comments are may be others when it is read back, and data has the value that it has
now, printed anew. Modules of real controllers show how: a num with six digits at most
(`0.0142213`, `1264.86`), whole numbers without a point, `9E+09`. So the numbers of data are
compared by what six digits say of them (15 of a dnum), whole numbers and those of statements
exactly. Comments count for nothing.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from typing import Final

from assistant.languages.rapid.reading.scanner import words
from assistant.languages.texts.words import Word

UNCOMPARED: Final = frozenset({"comment", "header", "newline"})
SCOPES: Final = frozenset({"local", "task"})
STORAGES: Final = frozenset({"const", "pers", "var"})
PIECE_BEGINS: Final = frozenset(
    (
        *("module", "endmodule", "proc", "endproc", "func", "endfunc", "trap", "endtrap"),
        *("record", "endrecord", "alias", "if", "elseif", "else", "endif", "for", "endfor"),
        *("while", "endwhile", "test", "case", "default", "endtest", "error", "undo", "backward"),
    )
)
"""Words that begin a piece, where no bracket is open."""
PIECE_ENDS: Final = frozenset({";", "then", "do", "else"})
"""Words that end one."""
DIGITS: Final = 6
DIGITS_OF: Final = {"dnum": 15}
BEFORE_SIGN: Final = frozenset({"[", "(", ",", ":="})
"""Before a `-` that is the sign of a number."""


def module_pieces(text: str) -> Iterator[tuple[str, str]]:
    """The declarations and statements of a text: what each says, and how it is written there."""
    piece: list[Word] = []
    depth = 0
    for word in words(text):
        if word.kind in UNCOMPARED:
            continue
        low = word.text.lower()
        begins = low in PIECE_BEGINS or low in SCOPES or low in STORAGES
        if piece and depth == 0 and begins and piece[-1].text.lower() not in SCOPES:
            yield _piece(piece, text)
            piece = []
        piece.append(word)
        depth = max(0, depth + (low in "([{") - (low in ")]}")) if word.kind == "mark" else depth
        if low in PIECE_ENDS and depth == 0:
            yield _piece(piece, text)
            piece = []
    if piece:
        yield _piece(piece, text)


def _piece(piece: list[Word], text: str) -> tuple[str, str]:
    last = piece[-1]
    return _compared_form(piece), text[piece[0].start : last.start + len(last.text)]


def _compared_form(piece: list[Word]) -> str:
    lows = [word.text.lower() for word in piece]
    kind = next((i for i in (0, 1) if i < len(lows) and lows[i] in STORAGES), None)
    data = kind is not None and ":=" in lows
    digits = 0
    if data and kind is not None:
        digits = DIGITS_OF.get(lows[kind + 1], DIGITS)
    found: list[str] = []
    for i, word in enumerate(piece):
        if word.kind == "string":
            found.append(word.text)
        elif word.kind == "number":
            value = _compared_number(lows[i], digits)
            if value == "0" and len(found) > 1 and found[-1] == "-" and found[-2] in BEFORE_SIGN:
                found.pop()  # `-0.00` is printed for what is nothing
            found.append(value)
        elif lows[i] == "," and i + 1 < len(lows) and lows[i + 1] == "\\":
            continue  # that comma may be left out
        else:
            found.append(lows[i])
    return " ".join(found)


def _compared_number(text: str, digits: int) -> str:
    """digits: that count of one with a point or an exponent; 0 for all of them."""
    if text.startswith(("0x", "0b", "0o")):
        return str(int(text, 0))
    plain = text.removeprefix("0d")
    value = float(plain)
    if plain.isdecimal() and math.isfinite(value):
        return str(int(plain))
    if digits == 0 or digits > DIGITS:
        shown = f"{value:.{digits}G}" if digits else repr(value)
    else:
        shown = f"{_as_num(value):.{digits}G}"
    back = float(shown)
    return str(int(back)) if back.is_integer() and abs(back) < 1e15 else repr(back)


def _as_num(value: float) -> float:
    """As a num holds it."""
    try:
        return float(struct.unpack("<f", struct.pack("<f", value))[0])
    except OverflowError:
        return value

"""Letters beyond ASCII in the letters of ASCII, for comments: to be read, not to be read back."""

from __future__ import annotations

import re
import unicodedata
from typing import Final

from assistant.program.program import plain_letters

_ROWS: Final = {
    "": "アイウエオ", "k": "カキクケコ", "g": "ガギグゲゴ", "s": "サシスセソ", "z": "ザジズゼゾ",
    "t": "タチツテト", "d": "ダヂヅデド", "n": "ナニヌネノ", "h": "ハヒフヘホ", "b": "バビブベボ",
    "p": "パピプペポ", "m": "マミムメモ", "r": "ラリルレロ",
}  # fmt: skip
_SINGLE: Final = {
    "ヤ": "ya", "ユ": "yu", "ヨ": "yo", "ワ": "wa", "ヲ": "o", "ン": "n", "ヴ": "vu", "シ": "shi",
    "チ": "chi", "ツ": "tsu", "フ": "fu", "ジ": "ji", "ヂ": "ji", "ヅ": "zu",
}  # fmt: skip
_SYLLABLES: Final = {
    kana: consonant + vowel
    for consonant, row in _ROWS.items()
    for kana, vowel in zip(row, "aiueo", strict=True)
} | _SINGLE
"""Katakana in the letters of Hepburn, as road signs in Japan have them."""

_SMALL: Final = {"ァ": "a", "ィ": "i", "ゥ": "u", "ェ": "e", "ォ": "o"}
_GLIDES: Final = {"ャ": "a", "ュ": "u", "ョ": "o"}
_SIGNS: Final = {
    "、": ", ", "。": ". ", "・": " ", "「": '"', "」": '"', "『": '"', "』": '"',
    "【": "[", "】": "]", "〜": "-", "～": "-", "—": "-", "–": "-", "―": "-",
    "‘": "'", "’": "'", "“": '"', "”": '"',
    "→": "->", "←": "<-", "⇒": "=>", "°": " deg", "×": "x", "μ": "u", "µ": "u", "φ": "dia. ",
    "Φ": "dia. ", "Ø": "dia. ", "★": "*", "☆": "*", "■": "#", "□": "#", "●": "*", "○": "o",
    "※": "*", "±": "+/-", "≦": "<=", "≧": ">=", "≤": "<=", "≥": ">=", "≠": "<>", "…": "...",
}  # fmt: skip
_HIRAGANA: Final = {chr(code): chr(code + 0x60) for code in range(0x3041, 0x3097)}
_KANA: Final = re.compile(r"[ァ-ヴー]+")


def in_ascii(text: str) -> str:
    r"""The text in ASCII: kana as they are spoken, accents left out, `\u539f` for what has none."""
    if text.isascii():
        return text
    text = unicodedata.normalize("NFKC", "".join(_SIGNS.get(c, c) for c in text))
    text = "".join(_SIGNS.get(c, _HIRAGANA.get(c, c)) for c in text)
    text = plain_letters(_KANA.sub(lambda found: _spoken(found[0]), text))
    return text.encode("ascii", "backslashreplace").decode("ascii")


def _spoken(kana: str) -> str:
    """Katakana in the letters of Hepburn."""
    said, double = "", False
    for c in kana:
        if c == "ッ":
            double = True
        elif c == "ー":
            said += said[-1:]
        elif c in _GLIDES:
            stem = said[:-1] if said.endswith("i") else said
            said = stem + ("" if stem.endswith(("sh", "ch", "j")) else "y") + _GLIDES[c]
        elif c in _SMALL:
            said = said[:-1] + _SMALL[c] if said[-1:] in ("e", "i", "u") else said + _SMALL[c]
        else:
            syllable = _SYLLABLES.get(c, c)
            said += (syllable[:1].replace("c", "t") if double else "") + syllable
            double = False
    return said

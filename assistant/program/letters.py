"""Letters beyond ASCII in letters of ASCII, for names and comments: to be read, not read back."""

from __future__ import annotations

import re
import unicodedata
from typing import Final

LETTERS: Final = {
    "ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "æ": "ae", "ø": "oe", "å": "aa", "œ": "oe",
    "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ẞ": "SS", "Æ": "Ae", "Ø": "Oe", "Å": "Aa", "Œ": "Oe",
    "ð": "d", "đ": "d", "ł": "l", "þ": "th", "ı": "i",
    "Ð": "D", "Đ": "D", "Ł": "L", "Þ": "Th",
}  # fmt: skip
"""Letters that are more than one of ASCII with an accent, as their languages write them there."""

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


_HAN: Final = re.compile("[\u2e80-\u2fdf\u3400-\u9fff\uf900-\ufaff\U00020000-\U0003ffff]")
"""Characters that are read in several ways, by their languages and the words that they stand in."""
_NOTHING: Final = re.compile("(?!)")


def in_ascii(text: str) -> str:
    r"""The text of a comment: letters as they are spelled in Latin ones, `\u539f` for what is none.

    Characters of Chinese and Japanese stay the numbers that they have: no reading is right in both.
    """
    if text.isascii():
        return text
    text = unicodedata.normalize("NFKC", "".join(_SIGNS.get(c, c) for c in text))
    spelled = _spelled(_kana("".join(_SIGNS.get(c, c) for c in text)), kept=_HAN)
    return spelled.encode("ascii", "backslashreplace").decode("ascii")


def plain_letters(text: str) -> str:
    """The text of a name: letters of LETTERS spelled out, others without accents or in Latin ones.

    Characters of Chinese and Japanese are read as in Mandarin: `外形` is `WaiXing`. What is no
    letter anywhere stays.
    """
    return text if text.isascii() else _spelled(_kana(unicodedata.normalize("NFC", text)))


def _spelled(text: str, kept: re.Pattern[str] = _NOTHING) -> str:
    letters = (c if kept.match(c) else _latin(c) for c in unicodedata.normalize("NFC", text))
    spelled = "".join(letters)
    return spelled.upper() if text.replace("ß", "").isupper() else spelled


def _latin(character: str) -> str:
    """A character in the letters of ASCII, itself if nobody writes it so."""
    if character.isascii():
        return character
    if character in LETTERS:
        return LETTERS[character]
    parts = unicodedata.normalize("NFKD", character)
    bare = "".join(c for c in parts if not unicodedata.combining(c))
    if bare.isascii():
        return bare
    from anyascii import anyascii

    return str(anyascii(character)) or character


def _kana(text: str) -> str:
    """Kana as they are spoken."""
    katakana = "".join(_HIRAGANA.get(c, c) for c in text)
    return _KANA.sub(lambda found: _spoken(found[0]), katakana)


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

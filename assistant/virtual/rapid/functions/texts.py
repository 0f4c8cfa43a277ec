"""Functions of strings, whose characters count from 1."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.virtual.rapid.ends import Fault, NotSimulated
from assistant.virtual.rapid.given import Given, takes
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import joined, whole
from assistant.virtual.rapid.values import NUMBERS, text_of


def _position(given: Given, text: str) -> int:
    """From 0, of a character that is there."""
    place = whole(given.number(1), "the place of a character")
    if not 1 <= place <= len(text):
        raise Fault(f"there is no character {place} among {len(text)}", "ERR_OUTOFBND")
    return place - 1


def _part(given: Given) -> str:
    text = given.text(0)
    start = _position(given, text)
    length = whole(given.number(2), "a length")
    if not 0 <= length <= len(text) - start:
        message = f"{length} characters from the {start + 1}. of {len(text)}"
        raise Fault(message, "ERR_OUTOFBND")
    return text[start : start + length]


def _find(given: Given) -> float:
    r"""The first character of a set, or with \NotInSet that is in none; else one behind the end."""
    text, chosen = given.text(0), given.text(2)
    start, wanted = _position(given, text), not given.has("notinset")
    hits = (i for i in range(start, len(text)) if (text[i] in chosen) is wanted)
    return float(next(hits, len(text)) + 1)


def _match(given: Given) -> float:
    text, pattern = given.text(0), given.text(2)
    found = text.find(pattern, _position(given, text))
    return float((len(text) if found < 0 else found) + 1)


def _member(given: Given) -> bool:
    text = given.text(0)
    return text[_position(given, text)] in given.text(2)


def _mapped(given: Given) -> str:
    text, before, after = given.text(0), given.text(1), given.text(2)
    if len(before) != len(after):
        raise Fault("StrMap between sets of other sizes")
    return text.translate(str.maketrans(before, after))


def _number(given: Given) -> str:
    decimals = whole(given.number(1), "the number of decimals")
    form = "E" if given.has("exp") else "f"
    return f"{given.number(0):.{decimals}{form}}"


def _value(given: Given) -> str:
    return joined(text_of(given.value(0)))


def _parsed(given: Given) -> bool:
    """StrToVal: whether a string is a value of the data that it is put into."""
    text, place = given.text(0).strip(), given.place(1)
    if place.shape.type == "bool" and not place.shape.sizes:
        if text.upper() in ("TRUE", "FALSE"):
            place.set(text.upper() == "TRUE")
            return True
        return False
    if place.shape.type not in NUMBERS or place.shape.sizes:
        raise NotSimulated(f"StrToVal of {place.shape.type}")
    try:
        place.set(float(text))
    except ValueError:
        return False
    return True


TABLE: Final[Mapping[str, Function]] = dict(
    (
        takes("StrLen", 1, lambda given: float(len(given.text(0)))),
        takes("StrPart", 3, _part),
        takes("StrFind", 3, _find, "notinset"),
        takes("StrMatch", 3, _match),
        takes("StrMemb", 3, _member),
        takes("StrMap", 3, _mapped),
        takes("StrToVal", 2, _parsed),
        takes("NumToStr", 2, _number, "exp"),
        takes("DnumToStr", 2, _number, "exp"),
        takes("ValToStr", 1, _value),
    )
)

"""Changes to inputs that know lines, words and numbers, for texts and for what holds texts."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from random import Random
from typing import Final

from tests.fuzz.target import Target

EXTREMES: Final = (
    *("9" * 400, "0x" + "F" * 400, "1" + "0" * 5000),
    *("0", "-0", "1", "-1", "2", "7", "0.5", "-0.0", "1e-320", "1e308", "1e309", "-1e400"),
    *("127", "128", "255", "256", "32767", "32768", "-32769", "65535", "65536", "8388608"),
    *("2147483647", "2147483648", "4294967296", "9223372036854775807", "9223372036854775808"),
    *(
        "1" + "0" * 30,
        "9" * 400,
        "1" + "0" * 5000,
        "1.7976931348623157e308",
        "5e-324",
        "nan",
        "inf",
    ),
    *("0x7FFFFFFF", "&HFFFF", "9E9", "9e+09", "1.", ".5", "1e", "00012", "1_000", "-", "+1"),
)
"""Numbers at and behind the ends of what machines, controllers and files have."""
ODD: Final = (
    *("\r", "\r\n", "\v", "\f", "\x1c", "\x1d", "\x1e", "\x85", "\u2028", "\u2029"),
    *(
        "\0",
        "\x1a",
        "\x1b[31m",
        "\t",
        "\ufeff",
        "\ufffe",
        "ü",
        "µ",
        "ß",
        "ı",
        "İ",
        "日本",
        "１",
        "²",
    ),
    *("\U0001f916", "\u202e", "\u00a0", "\u200b", "\\", '"', "'", "`", "{", "}", "{0}", "%s", "%"),
)
"""Characters that readers disagree about."""
BYTES: Final = (
    b"\xff",
    b"\x80",
    b"\xc3",
    b"\xed\xa0\x80",
    b"\xff\xfe",
    b"\0\0\0\0",
    b"\xef\xbb\xbf",
)
_WORDS: Final = re.compile(r"\w+|[^\w\s]|[ \t]+|\n|\s")
_NUMBER: Final = re.compile(r"\d+(?:\.\d*)?(?:[eE][+-]?\d+)?")
MOST_AT_ONCE: Final = 4


@dataclass(frozen=True, slots=True)
class Stock:
    """What changes are made with: words of the target, and other inputs to take parts from."""

    words: Sequence[str]
    others: Sequence[bytes]
    together: int
    most: int


def stock(target: Target, others: Sequence[bytes]) -> Stock:
    """others: seeds, kept cases and corpus."""
    words = dict.fromkeys(target.words())
    for data in others[:50]:
        words |= dict.fromkeys(re.findall(r"\w+|[^\w\s]+", data.decode("latin-1"))[:500])
    return Stock(tuple(words) or ("a",), others or (b"",), target.together, target.most)


def changed(data: bytes, stock: Stock, chance: Random) -> bytes:
    """The input with a few changes; the same ones for the same chance."""
    for _ in range(chance.randint(1, MOST_AT_ONCE)):
        data = chance.choice(CHANGES)(data, stock, chance)
        if len(data) > stock.most:
            start = chance.choice((0, 0, 0, chance.randrange(len(data))))
            data = data[start : start + stock.most]
    return data


def _cut(parts: list[str], chance: Random, longest: int = 8) -> slice:
    start = chance.randrange(len(parts) + 1)
    return slice(start, min(len(parts), start + chance.randint(0, longest)))


def _of_words(change: Callable[[list[str], Stock, Random], None]) -> Callable[..., bytes]:
    def done(data: bytes, stock: Stock, chance: Random) -> bytes:
        words = _WORDS.findall(_text(data)) or [""]
        change(words, stock, chance)
        return _bytes("".join(words))

    return done


def _of_lines(change: Callable[[list[str], Stock, Random], None]) -> Callable[..., bytes]:
    def done(data: bytes, stock: Stock, chance: Random) -> bytes:
        lines = _lines(data, stock.together)
        change(lines, stock, chance)
        return _bytes("".join(lines))

    return done


def _text(data: bytes) -> str:
    return data.decode("utf-8", "surrogateescape")


def _bytes(text: str) -> bytes:
    return text.encode("utf-8", "surrogateescape")


def _lines(data: bytes, together: int) -> list[str]:
    plain = _text(data).split("\n")
    lines = [line + "\n" for line in plain[:-1]] + plain[-1:]
    return ["".join(lines[n : n + together]) for n in range(0, len(lines), together)]


def _word(words: list[str], stock: Stock, chance: Random) -> None:
    words[chance.randrange(len(words))] = chance.choice(stock.words)


def _word_more(words: list[str], stock: Stock, chance: Random) -> None:
    words.insert(chance.randrange(len(words) + 1), f"{chance.choice(stock.words)} ")


def _words_less(words: list[str], stock: Stock, chance: Random) -> None:
    del words[_cut(words, chance)]


def _words_again(words: list[str], stock: Stock, chance: Random) -> None:
    taken = words[_cut(words, chance)]
    at = chance.randrange(len(words) + 1)
    words[at:at] = taken


def _words_swapped(words: list[str], stock: Stock, chance: Random) -> None:
    one, other = chance.randrange(len(words)), chance.randrange(len(words))
    words[one], words[other] = words[other], words[one]


def _number(words: list[str], stock: Stock, chance: Random) -> None:
    numbers = [at for at, word in enumerate(words) if _NUMBER.fullmatch(word)]
    if numbers:
        words[chance.choice(numbers)] = chance.choice(EXTREMES)


def _odd(words: list[str], stock: Stock, chance: Random) -> None:
    words.insert(chance.randrange(len(words) + 1), chance.choice(ODD))


def _case(words: list[str], stock: Stock, chance: Random) -> None:
    at = chance.randrange(len(words))
    words[at] = words[at].swapcase()


def _nested(words: list[str], stock: Stock, chance: Random) -> None:
    at = chance.randrange(len(words))
    words[at] *= chance.choice((2, 3, 16, 200))


def _lines_less(lines: list[str], stock: Stock, chance: Random) -> None:
    del lines[_cut(lines, chance, 4)]


def _lines_again(lines: list[str], stock: Stock, chance: Random) -> None:
    taken = lines[_cut(lines, chance, 4)] * chance.choice((1, 1, 1, 2, 20))
    at = chance.randrange(len(lines) + 1)
    lines[at:at] = taken


def _lines_swapped(lines: list[str], stock: Stock, chance: Random) -> None:
    one, other = chance.randrange(len(lines)), chance.randrange(len(lines))
    lines[one], lines[other] = lines[other], lines[one]


def _lines_of_another(lines: list[str], stock: Stock, chance: Random) -> None:
    others = _lines(chance.choice(stock.others), stock.together)
    at = chance.randrange(len(lines) + 1)
    lines[at:at] = others[_cut(others, chance, 6)]


def _lines_joined(lines: list[str], stock: Stock, chance: Random) -> None:
    at = chance.randrange(len(lines))
    lines[at] = lines[at].rstrip("\r\n") + chance.choice(("", " "))


def _byte(data: bytes, stock: Stock, chance: Random) -> bytes:
    at = chance.randrange(len(data) + 1)
    made = chance.choice((*BYTES, bytes([chance.randrange(256)])))
    return data[:at] + made + data[at + chance.choice((0, 1, len(made))) :]


def _bit(data: bytes, stock: Stock, chance: Random) -> bytes:
    if not data:
        return data
    at = chance.randrange(len(data))
    return data[:at] + bytes([data[at] ^ 1 << chance.randrange(8)]) + data[at + 1 :]


def _bytes_less(data: bytes, stock: Stock, chance: Random) -> bytes:
    at = chance.randrange(len(data) + 1)
    return data[:at] + data[at + chance.randint(1, 40) :]


CHANGES: Final[tuple[Callable[[bytes, Stock, Random], bytes], ...]] = (
    *map(_of_words, (_word, _word, _word_more, _word_more, _words_less, _words_again)),
    *map(_of_words, (_words_swapped, _number, _number, _odd, _case, _nested)),
    *map(_of_lines, (_lines_less, _lines_less, _lines_again, _lines_again, _lines_swapped)),
    *map(_of_lines, (_lines_of_another, _lines_of_another, _lines_of_another, _lines_joined)),
    *(_byte, _bit, _bytes_less),
)
"""Those that lead far in most kinds of inputs stand several times."""

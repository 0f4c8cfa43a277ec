"""Expressions of MELFA-BASIC against an evaluator that knows nothing of the project's parser.

It reads a row of tokens by the levels of table 4-12 (CR1D 4-151), from left to right inside each.
What the manuals leave open is set: quotients go to 0, shifts have 32 bits, a truth is 1.
"""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Callable

import pytest

from assistant import languages
from assistant.virtual import melfa
from assistant.virtual.melfa import Given, Options
from assistant.virtual.melfa.values import Value

Number = float | int | bool

LEVELS: tuple[tuple[str, ...], ...] = (
    ("Xor",),
    ("Or",),
    ("And",),
    ("Not",),
    ("=", "<>", "<", "<=", ">", ">="),
    ("<<", ">>"),
    ("+", "-"),
    ("Mod",),
    ("\\",),
    ("*", "/"),
    ("sign",),
    ("^",),
)
"""From those that bind least to those that bind most."""
LARGEST = 1e9


class Open(Exception):
    """What the manuals leave open, or what no number is."""


def evaluated(tokens: list[str]) -> Number:
    value, rest = _level(tokens, 0)
    assert not rest
    return value


def _level(tokens: list[str], level: int) -> tuple[Number, list[str]]:
    """The value of the longest row at the front that binds at a level or more, and what follows."""
    if level == len(LEVELS):
        return _single(tokens)
    words = LEVELS[level]
    if words in (("Not",), ("sign",)):
        return _prefixed(tokens, level)
    left, rest = _level(tokens, level + 1)
    while rest and rest[0] in words:
        sign = rest[0]
        below = level + 1
        if sign == "^" and rest[1] in "+-":  # an exponent may have a sign of its own
            below = LEVELS.index(("sign",))
            right, rest = _signed_single(rest[1:])
        else:
            right, rest = _level(rest[1:], below)
        left = _kept(APPLY[sign](left, right))
    return left, rest


def _prefixed(tokens: list[str], level: int) -> tuple[Number, list[str]]:
    if LEVELS[level] == ("Not",) and tokens[0] == "Not":
        value, rest = _prefixed(tokens[1:], level)
        return (not value if isinstance(value, bool) else ~_whole(value)), rest
    if LEVELS[level] == ("sign",) and tokens[0] in ("+", "-"):
        value, rest = _prefixed(tokens[1:], level)
        return (-value if tokens[0] == "-" else +value), rest
    return _level(tokens, level + 1)


def _signed_single(tokens: list[str]) -> tuple[Number, list[str]]:
    if tokens[0] in "+-":
        value, rest = _signed_single(tokens[1:])
        return (-value if tokens[0] == "-" else value), rest
    return _single(tokens)


def _single(tokens: list[str]) -> tuple[Number, list[str]]:
    if tokens[0] == "(":
        value, rest = _level(tokens[1:], 0)
        assert rest[0] == ")"
        return value, rest[1:]
    return (float(tokens[0]) if "." in tokens[0] else int(tokens[0])), tokens[1:]


def _whole(value: Number) -> int:
    return int(math.copysign(math.floor(abs(value) + 0.5), value))


def _kept(value: Number) -> Number:
    if isinstance(value, complex) or not abs(value) < LARGEST:
        raise Open
    return value


def _quotient(a: Number, b: Number) -> Number:
    if _whole(b) == 0:
        raise Open
    return math.trunc(_whole(a) / _whole(b))


def _divided(a: Number, b: Number) -> Number:
    if b == 0:
        raise Open
    return a / b


def _power(a: Number, b: Number) -> Number:
    if a == 0 or abs(b) > 20:
        raise Open
    return float(a) ** float(b)


def _shifted(sign: int) -> Callable[[Number, Number], Number]:
    def made(a: Number, b: Number) -> Number:
        if not 0 <= _whole(b) <= 20:
            raise Open
        bits = _whole(a) & 0xFFFFFFFF
        bits = (bits << _whole(b) if sign > 0 else bits >> _whole(b)) & 0xFFFFFFFF
        return bits - (1 << 32) if bits >> 31 else bits

    return made


def _logic(of: Callable[[int, int], int]) -> Callable[[Number, Number], Number]:
    def made(a: Number, b: Number) -> Number:
        if isinstance(a, bool) and isinstance(b, bool):
            return bool(of(a, b))
        return of(_whole(a), _whole(b))

    return made


APPLY: dict[str, Callable[[Number, Number], Number]] = {
    "Xor": _logic(lambda a, b: a ^ b),
    "Or": _logic(lambda a, b: a | b),
    "And": _logic(lambda a, b: a & b),
    "=": lambda a, b: a == b,
    "<>": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
    "<<": _shifted(1),
    ">>": _shifted(-1),
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "Mod": lambda a, b: _whole(a) - _whole(b) * _whole(_quotient(a, b)),
    "\\": _quotient,
    "*": lambda a, b: a * b,
    "/": _divided,
    "^": _power,
}
BINARY = tuple(APPLY)


def drawn(rng: random.Random, depth: int = 0) -> list[str]:
    """A row of operands and operators, in brackets here and there."""
    tokens = ["Not"] if rng.random() < 0.1 else []
    for at in range(rng.randint(2, 5)):
        if at:
            sign = rng.choice(BINARY)
            tokens.append(sign)
            if sign in ("And", "Or", "Xor") and rng.random() < 0.3:
                tokens.append("Not")
        if rng.random() < 0.15:
            tokens.append(rng.choice("+-"))
        if depth < 2 and rng.random() < 0.15:
            tokens += ["(", *drawn(rng, depth + 1), ")"]
        else:
            tokens.append(rng.choice((str(rng.randint(0, 12)), f"{rng.randint(0, 9)}.25", "2.5")))
    return tokens


def run(rows: list[list[str]], level: int) -> list[Value | None]:
    shown: list[Value | None] = []

    def show(given: Given) -> int:
        shown.append(given.arguments[0])
        return 0

    lines = [f"{10 * at} M99=Show({' '.join(row)})" for at, row in enumerate(rows, 1)]
    tree = languages.get(f"melfa-basic-{level}").parse("\n".join(lines))
    assert not tree.findings, tree.findings
    options = Options(quotients="zero", bits=32)
    done = melfa.run(tree, options=options, commands={"Show": show})
    assert done.ended == "end", done.message
    return shown


def defined(row: list[str]) -> Number | None:
    """What a row comes to, None where that is open."""
    try:
        return evaluated(row)
    except (Open, OverflowError):
        return None


def agree(rows: list[list[str]], level: int) -> None:
    wanted = [value for row in rows if (value := defined(row)) is not None]
    kept = [row for row in rows if defined(row) is not None]
    for row, value, found in zip(kept, wanted, run(kept, level), strict=True):
        assert found == pytest.approx(value, rel=1e-9, abs=1e-9), " ".join(row)


OPERANDS = (
    ("7", "12", "5"), ("20", "6", "4"), ("2.5", "3", "2"), ("9", "1", "3"), ("3", "4", "1"),
    ("4", "6", "3"), ("8", "5", "5"), ("1", "0", "2"), ("0", "3", "3"), ("2", "6", "2"),
    ("0", "0", "1"), ("0", "0", "2"), ("0", "2", "1"),
)  # fmt: skip


@pytest.mark.one_in(3)
@pytest.mark.parametrize("level", [4, 5, 6])
def test_every_pair_of_operators(level: int) -> None:
    agree([[a, x, b, y, c] for x, y in PAIRS for a, b, c in OPERANDS], level)


PAIRS = tuple(itertools.product(BINARY, BINARY))


def test_the_operands_tell_the_levels_apart() -> None:
    """A pair of operators of two levels comes to something else if it is taken the other way."""
    levels = {sign: at for at, level in enumerate(LEVELS) for sign in level}
    for first, second in PAIRS:
        if levels[first] == levels[second] or {levels[first], levels[second]} <= SIMILAR:
            continue
        assert any(
            defined([a, first, b, second, c]) != defined(other)
            for a, b, c in OPERANDS
            for other in ([a, first, "(", b, second, c, ")"], ["(", a, first, b, ")", second, c])
        ), f"{first} and {second}"


SIMILAR = {LEVELS.index((sign,)) for sign in ("And", "Or", "Xor")}
"""Of these a test of their own has operands."""


@pytest.mark.parametrize("level", [4, 5, 6])
def test_random_expressions(level: int) -> None:
    rng = random.Random(level)
    agree([drawn(rng) for _ in range(150)], level)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_many_random_expressions(seed: int) -> None:
    rng = random.Random(1000 + seed)
    agree([drawn(rng) for _ in range(2000)], 4 + seed % 3)


@pytest.mark.parametrize("level", [4, 5, 6])
def test_logic_of_all_small_numbers(level: int) -> None:
    words = ("And", "Or", "Xor")
    agree(
        [
            [a, x, b, y, c]
            for x, y in itertools.product(words, words)
            for a, b, c in (("1", "2", "3"), ("6", "3", "1"), ("5", "6", "4"))
        ],
        level,
    )


def test_the_evaluator_itself() -> None:
    """By hand, so that a mistake in its table shows as well."""
    cases = {
        "2 ^ 3 * 2": 16, "- 2 ^ 2": -4, "12 \\ 5 * 2": 1, "12 \\ 5 Mod 2": 0, "10 + 17 Mod 7": 13,
        "1 << 2 + 1": 8, "16 >> 2 > 3": True, "Not 1 = 2": True, "6 Or 3 And 1": 7,
        "1 Xor 3 Or 2": 2, "2 ^ - 2": 0.25, "7.5 \\ 2": 4, "- 7 \\ 2": -3, "- 7 Mod 3": -1,
        "17 Mod 7 - 1": 2, "10 - 4 - 3": 3, "100 / 5 / 2": 10,
    }  # fmt: skip
    for text, wanted in cases.items():
        assert evaluated(text.split()) == wanted, text

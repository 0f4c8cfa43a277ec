"""Expressions as RAPID's interpreter takes them, beside an evaluator that shares nothing with it.

The evaluator reads the text itself, by the priorities of the reference (1.3): `* / DIV MOD`, then
`+ -`, then relations, then AND, then XOR, OR and NOT, equal and from the left.
"""

from __future__ import annotations

import math
import operator
import random
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.virtual.rapid_cell import said

Value = np.float32 | bool
BINARY: dict[str, tuple[int, Callable[[Any, Any], Any]]] = {
    "*": (5, operator.mul),
    "/": (5, operator.truediv),
    "DIV": (5, lambda a, b: np.float32(math.trunc(int(a) / int(b)))),
    "MOD": (5, lambda a, b: np.float32(math.fmod(int(a), int(b)))),
    "+": (4, operator.add),
    "-": (4, operator.sub),
    "<": (3, operator.lt),
    "<=": (3, operator.le),
    ">": (3, operator.gt),
    ">=": (3, operator.ge),
    "=": (3, operator.eq),
    "<>": (3, operator.ne),
    "AND": (2, lambda a, b: bool(a) and bool(b)),
    "OR": (1, lambda a, b: bool(a) or bool(b)),
    "XOR": (1, lambda a, b: bool(a) is not bool(b)),
}
NAMES = {"a": np.float32(7), "b": np.float32(-3), "c": np.float32(0.1), "t": True, "f": False}
DATA = "VAR num a:=7;\nVAR num b:=-3;\nVAR num c:=0.1;\nVAR bool t:=TRUE;\nVAR bool f:=FALSE;"


def worth(text: str) -> Value:
    """What an expression is worth, by climbing the priorities of its operators."""
    words = re.findall(r"\d+\.?\d*|\w+|<=|>=|<>|[-+*/<>=()]", text)

    def climb(least: int) -> Value:
        left = begin()
        while words and words[0] in BINARY and BINARY[words[0]][0] >= least:
            level, does = BINARY[words.pop(0)]
            left = does(left, climb(level + 1))
        return left

    def begin() -> Value:
        word = words.pop(0)
        if word == "(":
            inside = climb(1)
            assert words.pop(0) == ")"
            return inside
        if word == "NOT":  # as weak as OR: all of AND behind it belongs to it
            return not climb(2)
        if word == "-":  # before the first term of a sum
            return -climb(5)
        return NAMES[word] if word in NAMES else np.float32(word)

    found = climb(1)
    assert not words
    return found


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2+3*4", 14),
        ("2-3-4", -5),
        ("-2*3+10", 4),
        ("14 DIV 4*2", 6),
        ("NOT t AND f", True),
        ("t OR t AND f", True),
        ("t XOR t OR t", True),
        ("1+1=2 AND 3<4", True),
    ],
)
def test_the_evaluator_of_the_test_is_right(text: str, value: object) -> None:
    assert worth(text) == value


class Writer:
    """Random expressions. A divisor is a literal, so that it is whole and not 0."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)

    def number(self, deep: int, whole: bool = False) -> str:
        term = self.term(deep, whole)
        sign = "-" if self.random.random() < 0.2 else ""
        for _ in range(self.random.choice((0, 1, 1, 2))):
            term += self.random.choice("+-") + self.term(deep, whole)
        return sign + term

    def term(self, deep: int, whole: bool) -> str:
        text = self.factor(deep, whole)
        for _ in range(self.random.choice((0, 0, 1, 2))):
            kind = self.random.choice(("*", "DIV", "MOD") if whole else ("*", "/"))
            if kind == "*":
                text += "*" + self.factor(deep, whole)
            else:
                text += f" {kind} {self.random.randint(1, 9)}"
        return text

    def factor(self, deep: int, whole: bool) -> str:
        if deep and self.random.random() < 0.4:
            return f"({self.number(deep - 1, whole)})"
        names = ("a", "b") if whole else ("a", "b", "c")
        return self.random.choice((str(self.random.randint(0, 9)), *names))

    def truth(self, deep: int) -> str:
        text = "NOT " if self.random.random() < 0.3 else ""
        text += self.relation(deep)
        for _ in range(self.random.choice((0, 1, 2, 3))):
            text += f" {self.random.choice(('AND', 'OR', 'XOR'))} " + self.relation(deep)
        return text

    def relation(self, deep: int) -> str:
        drawn = self.random.random()
        if drawn < 0.4:
            return self.random.choice("tf")
        if deep and drawn < 0.7:
            return f"({self.truth(deep - 1)})"
        sign = self.random.choice(("<", "<=", ">", ">=", "=", "<>"))
        return self.number(0, True) + sign + self.number(0, True)


@pytest.mark.parametrize("seed", range(3))
def test_random_expressions_are_worth_the_same(seed: int) -> None:
    writer = Writer(seed)
    numbers = [writer.number(2, whole=i % 2 == 0) for i in range(60)]
    truths = [writer.truth(2) for _ in range(60)]
    lines = [f"reg1:={text};\nTPWrite NumToStr(reg1,6);" for text in numbers]
    lines += [f"TPWrite ValToStr({text});" for text in truths]
    found = said("\n".join(lines), data=DATA)
    for text, told in zip(numbers, found, strict=False):
        expected = worth(text)
        assert float(told) == pytest.approx(float(expected), rel=1e-5, abs=2e-6), text
    for text, told in zip(truths, found[len(numbers) :], strict=True):
        assert told == ("TRUE" if worth(text) else "FALSE"), text

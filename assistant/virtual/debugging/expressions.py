"""Expressions of an editor about data of a program that is held: values, comparisons, logic.

They read what the debugger shows and call nothing, so that asking changes nothing.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping
from typing import Final

from assistant.base.data_classes import dataclass

Value = float | bool | str
Read = Callable[[str], str]
"""The value of a piece of data as it is shown; raises LookupError for one that is not known."""
Evaluate = Callable[[Read], Value]
"""An expression that was read."""

_TOKEN: Final = re.compile(
    r"""\s*(?:
    (?P<number>\d+(?:\.\d*)?(?:[eE][-+]?\d+)?|\.\d+)
    |(?P<text>"(?:[^"]|"")*")
    |(?P<name>[A-Za-z_][\w$%\#&!]*(?:\{[^{}]*\}|\([^()]*\)|\.[A-Za-z_]\w*)*)
    |(?P<sign><=|>=|<>|!=|==|=|<|>|\+|-|\*|/|\(|\))
    )""",
    re.VERBOSE,
)
_SHOWN_NUMBER: Final = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_WORDS: Final = {"true": True, "false": False}
_LOGIC: Final = frozenset({"and", "or", "xor", "not", "mod", "div"})
_MOST: Final = 1000
"""Characters of an expression."""


class Wrong(LookupError):
    """An expression that cannot be read or worked out."""


def read_expression(text: str) -> Evaluate:
    """Read an expression; raises Wrong if the text is not one."""
    if len(text) > _MOST:
        raise Wrong(f"an expression of {len(text)} characters")
    reader = _Reader(_tokens(text))
    found = reader.alternatives()
    if reader.at < len(reader.tokens):
        raise Wrong(f"`{text}`: `{reader.tokens[reader.at].text}` is not expected there")
    return found


def is_true(value: Value) -> bool:
    """The truth of a condition; a number counts as true unless it is 0."""
    if isinstance(value, str):
        raise Wrong(f"`{value}` is no condition")
    return bool(value)


def shown(value: Value) -> str:
    """A value as an editor shows it."""
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    return value if isinstance(value, str) else f"{value:.9g}"


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str
    text: str


def _tokens(text: str) -> list[_Token]:
    found, at = [], 0
    text = text.strip()
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise Wrong(f"`{text}`: `{text[at:].strip()[:10]}` is not expected there")
        kind = str(match.lastgroup)
        word = match[kind]
        if kind == "name" and (name := word.split("(")[0].lower()) in _LOGIC and name != word:
            if "(" in word:  # `NOT(a)` is no call
                word, match_end = word[: len(name)], match.start(kind) + len(name)
                found.append(_Token("word", word.lower()))
                at = match_end
                continue
        if kind == "name" and word.lower() in _LOGIC:
            kind, word = "word", word.lower()
        found.append(_Token(kind, word))
        at = match.end()
    return found


def _divided(left: float, right: float) -> float:
    if right == 0.0:
        raise Wrong("a division by 0")
    return left / right


def _whole(does: Callable[[int, int], int]) -> Callable[[float, float], float]:
    def works(left: float, right: float) -> float:
        if right == 0.0 or left != int(left) or right != int(right):
            raise Wrong("DIV and MOD take whole numbers, and none is divided by 0")
        return float(does(int(left), int(right)))

    return works


_SUMS: Final[Mapping[str, Callable[[float, float], float]]] = {
    "+": operator.add,
    "-": operator.sub,
}
_PRODUCTS: Final[Mapping[str, Callable[[float, float], float]]] = {
    "*": operator.mul,
    "/": _divided,
    "mod": _whole(operator.mod),
    "div": _whole(operator.floordiv),
}
_ORDER: Final[Mapping[str, Callable[[float, float], bool]]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_SAME: Final = {"=": True, "==": True, "<>": False, "!=": False}


class _Reader:
    """Tokens, read one after the other: OR below AND below NOT below comparisons below sums."""

    def __init__(self, tokens: list[_Token]) -> None:
        self.tokens, self.at = tokens, 0

    def _next(self, *wanted: str) -> str | None:
        if self.at < len(self.tokens):
            token = self.tokens[self.at]
            if token.kind in ("sign", "word") and token.text in wanted:
                self.at += 1
                return token.text
        return None

    def alternatives(self) -> Evaluate:
        found = self._all_of()
        while (word := self._next("or", "xor")) is not None:
            found = _logical(word, found, self._all_of())
        return found

    def _all_of(self) -> Evaluate:
        found = self._negated()
        while self._next("and"):
            found = _logical("and", found, self._negated())
        return found

    def _negated(self) -> Evaluate:
        if self._next("not"):
            inner = self._negated()
            return lambda read: not is_true(inner(read))
        return self._compared()

    def _compared(self) -> Evaluate:
        left = self._sum()
        sign = self._next(*_ORDER, *_SAME)
        return left if sign is None else _comparison(sign, left, self._sum())

    def _sum(self) -> Evaluate:
        found = self._product()
        while (sign := self._next(*_SUMS)) is not None:
            found = _arithmetic(_SUMS[sign], found, self._product())
        return found

    def _product(self) -> Evaluate:
        found = self._signed()
        while (sign := self._next(*_PRODUCTS)) is not None:
            found = _arithmetic(_PRODUCTS[sign], found, self._signed())
        return found

    def _signed(self) -> Evaluate:
        if self._next("-"):
            inner = self._signed()
            return lambda read: -_number(inner(read))
        if self._next("+"):
            return self._signed()
        return self._operand()

    def _operand(self) -> Evaluate:
        if self._next("("):
            inner = self.alternatives()
            if not self._next(")"):
                raise Wrong("a bracket is not closed")
            return inner
        if self.at >= len(self.tokens):
            raise Wrong("the expression ends where a value is wanted")
        token = self.tokens[self.at]
        self.at += 1
        if token.kind == "number":
            value = float(token.text)
            return lambda _: value
        if token.kind == "text":
            text = token.text[1:-1].replace('""', '"')
            return lambda _: text
        if token.kind != "name":
            raise Wrong(f"`{token.text}` stands where a value is wanted")
        if token.text.lower() in _WORDS:
            truth = _WORDS[token.text.lower()]
            return lambda _: truth
        return lambda read: _value(read(token.text))


def _logical(word: str, left: Evaluate, right: Evaluate) -> Evaluate:
    if word == "and":
        return lambda read: is_true(left(read)) and is_true(right(read))
    if word == "or":
        return lambda read: is_true(left(read)) or is_true(right(read))
    return lambda read: is_true(left(read)) != is_true(right(read))


def _comparison(sign: str, left: Evaluate, right: Evaluate) -> Evaluate:
    if sign in _SAME:
        return lambda read: _equal(left(read), right(read)) == _SAME[sign]
    return lambda read: _ORDER[sign](_number(left(read)), _number(right(read)))


def _equal(left: Value, right: Value) -> bool:
    if isinstance(left, str) or isinstance(right, str):
        if type(left) is not type(right):
            raise Wrong(f"`{shown(left)}` and `{shown(right)}` cannot be compared")
        return left == right
    return float(left) == float(right)


def _arithmetic(does: Callable[[float, float], float], left: Evaluate, right: Evaluate) -> Evaluate:
    return lambda read: does(_number(left(read)), _number(right(read)))


def _number(value: Value) -> float:
    if isinstance(value, str):
        raise Wrong(f"`{value}` is no number")
    return float(value)


def _value(text: str) -> Value:
    """Type of a value by the way it is shown."""
    told = text.strip()
    if told.lower() in _WORDS:
        return _WORDS[told.lower()]
    if _SHOWN_NUMBER.fullmatch(told):
        return float(told)
    if len(told) > 1 and told[0] == told[-1] == '"':
        return told[1:-1].replace('""', '"')
    return told

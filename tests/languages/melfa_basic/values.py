"""Random names, literals and expressions of MELFA-BASIC, each of the type that is wanted.

Types by the letter that MELFA-BASIC names such variables with: M a number, C a text, P a
position, J joints. Expressions are shallow and drawn in few choices, so that thousands are made
in a minute and a failing one is small.
"""

from __future__ import annotations

import string
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, Final

from hypothesis import strategies as st

from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.tables.variables import RESERVED_WORDS
from assistant.languages.melfa_basic.tree import syntax as s

DEPTH: Final = 2
"""Operators and calls of an expression inside each other."""

Strategy = st.SearchStrategy[Any]

LEVELS: Final = {dialect.level: dialect for dialect in DIALECTS.values()}
"""4, 5, 6 → MELFA-BASIC IV, V, VI."""


def or_none(strategy: Strategy) -> Strategy:
    return st.none() | strategy


def some(items: Strategy, least: int = 0, most: int = 3) -> Strategy:
    return st.lists(items, min_size=least, max_size=most).map(tuple)


# ---------------------------------------------------------------------------------- names

TAKEN: Final = {part for word in RESERVED_WORDS for part in (word, *word.split())} | {
    "OFF", "ON", "TO", "IS", "AS", "PI",
}  # fmt: skip
ODD_NAMES: Final[Mapping[str, tuple[str, ...]]] = {
    "M": ("M1", "MIF", "MENDIF", "MTO_1", "M007", "MNOT", "M_01", "E1", "COUNT", "X", "M_20"),
    "C": ("C1", "CREM", "C_01", "CNAME"),
    "P": ("P1", "P10", "P007", "P_01", "PX", "PLOAD", "P_"),
    "J": ("J1", "JHOME", "J_01", "J99"),
}


@cache
def names(kind: str, level: int) -> Strategy:
    """Names of variables of a type, within the length that the version allows."""
    dialect = LEVELS[level]
    letters = string.ascii_uppercase if dialect.upper else string.ascii_letters
    more = st.text(letters + string.digits, max_size=dialect.names - 1)
    made = more.map(lambda text: kind + text)
    usual = tuple(f"{kind}{n}" for n in range(1, 6))
    return st.one_of(
        st.sampled_from(usual),
        st.sampled_from(ODD_NAMES[kind]),
        made,
        st.just(kind.ljust(dialect.names, "X")),
    ).filter(_free)


def _free(name: str) -> bool:
    return name.upper() not in TAKEN and vocabulary.status(name) is None


LABEL_NAMES: Final = ("L1", "START", "PICK", "LOOP9", "IFX", "L_1", "ENDING", "Z")


@cache
def labels(level: int) -> Strategy:
    """Few names, so that most of them are jumped to and stand there."""
    spelled = LABEL_NAMES if level == 4 else (*LABEL_NAMES, "Place", "Assembly_Error_1")
    return st.sampled_from(spelled)


# ------------------------------------------------------------------------------- literals

DECIMALS: Final = st.one_of(
    st.integers(0, 10**9),
    st.integers(0, 99999).map(lambda n: n / 100),
    st.floats(0, 1e12, allow_nan=False),
    st.sampled_from((0, 0.5, 1e-7, 1e22, 1e15, 1.5e17)),
)
SMALL: Final = st.integers(0, 40).map(s.Number)
TEXTS: Final = st.one_of(
    st.sampled_from(("", "it's", "10 END", "Rem", "*L", "ロボット", "COM1:", "a;b,c", "\t")),
    st.text(st.characters(exclude_categories=["Cs", "Cc"], exclude_characters='"'), max_size=8),
)
COORDINATES: Final = st.one_of(
    st.integers(-999, 999),
    st.integers(-99999, 99999).map(lambda n: n / 100),
    st.sampled_from((0.0, 1e-7, 123456.789, -0.5, 360)),
).map(float)
FLAGS: Final = st.one_of(
    st.sampled_from((0, 7, 6, 3, 4, 1048576, 15728640, -1)), st.integers(0, 0xFFFFFFFF)
)


@cache
def numbers(level: int) -> Strategy:
    """Number literals of any base."""
    suffixes = st.sampled_from(("", "", "", "", "%", "#", "!") if level > 4 else ("",))
    return st.one_of(
        SMALL,
        st.builds(s.Number, DECIMALS, st.just(10), suffixes),
        st.builds(s.Number, st.integers(0, 0xFFFFFFFF), st.sampled_from((2, 16))),
    )


STRINGS: Final = TEXTS.map(s.String)
CONSTANTS: Final = st.builds(
    s.Constant,
    some(or_none(COORDINATES), 2, 8),
    or_none(st.tuples(or_none(FLAGS), or_none(FLAGS))),
)
JOINTS: Final = st.builds(s.Constant, some(COORDINATES, 5, 8))
FULL: Final = st.builds(
    s.Constant,
    st.lists(COORDINATES, min_size=6, max_size=8).map(tuple),
    st.tuples(FLAGS, FLAGS),
)
"""Positions that are written out."""

# -------------------------------------------------------------------------------- variables

COMPONENTS: Final = {
    "P": ("X", "Y", "Z", "A", "B", "C", "L1", "L2", "FL1", "FL2"),
    "J": tuple(f"J{n}" for n in range(1, 9)),
}


def _suffixes(kind: str, level: int) -> Strategy:
    if kind == "C":
        return st.just("$")
    if kind == "M" and level > 4:
        return st.sampled_from(("", "", "", "%", "!", "#", "&"))
    return st.just("")


@cache
def variables(kind: str, level: int) -> Strategy:
    """Plain variables of a type."""
    return st.builds(s.Variable, names(kind, level), _suffixes(kind, level))


@cache
def targets(kind: str, level: int, depth: int = 1) -> Strategy:
    """What may be assigned to: variables, elements and components."""
    plain = variables(kind, level)
    index = some(expressions("M", level, depth - 1) if depth else SMALL, 1)
    element = st.builds(s.Variable, names(kind, level), _suffixes(kind, level), index)
    every = [plain, plain, element]
    for whole, parts in COMPONENTS.items() if kind == "M" else ():
        every.append(
            st.builds(
                s.Variable,
                names(whole, level),
                st.just(""),
                or_none(index),
                st.sampled_from(parts),
            )
        )
    return st.one_of(every)


@cache
def _status(kind: str, level: int, depth: int) -> Strategy:
    """Status variables, with their subscripts or without any."""
    rows = [
        row
        for row in vocabulary.variables().values()
        if row.type == kind and level in row.dialects and row.readable
    ]

    def indexed(row: Any) -> Strategy:
        if not row.index:
            return st.just(s.Variable(row.name))
        index = st.tuples(*[expressions("M", level, depth - 1) for _ in row.index])
        return st.builds(s.Variable, st.just(row.name), st.just(""), or_none(index))

    return st.sampled_from(rows).flatmap(indexed)


@cache
def _calls(kind: str, level: int, depth: int) -> Strategy:
    """Calls of the functions that give a type."""
    rows = [
        row
        for row in vocabulary.functions().values()
        if row.result == kind and level in row.dialects
    ]

    def call(row: Any) -> Strategy:
        given = []
        for argument in row.arguments:
            if argument.assigned:
                given.append(variables(argument.types[0], level))
            else:
                given.append(expressions(argument.types[0], level, depth - 1))
        name, suffix = row.name.removesuffix("$"), "$" if row.name.endswith("$") else ""
        full = st.tuples(*given)
        least = st.tuples(*given[: row.least]) if row.least else full
        return st.builds(s.Variable, st.just(name), st.just(suffix), full | least)

    return st.sampled_from(rows).flatmap(call)


# ------------------------------------------------------------------------------ expressions

RELATIONS: Final = ("=", "<>", "<", "<=", ">", ">=", "><", "=<", "=>")
NUMERIC: Final = ("+", "-", "*", "/", "\\", "MOD", "^", "<<", ">>", "AND", "OR", "XOR")

USER_FUNCTIONS: Final = (
    s.DefFunction(
        "FNMAVE",
        "",
        (s.Variable("MA"), s.Variable("MB")),
        s.Binary("/", s.Binary("+", s.Variable("MA"), s.Variable("MB")), s.Number(2)),
    ),
    s.DefFunction(
        "FNCTWICE", "$", (s.Variable("C1", "$"),), s.Binary("+", *2 * (s.Variable("C1", "$"),))
    ),
)
"""Functions that a program defines itself where it calls them."""


@cache
def expressions(kind: str, level: int, depth: int = DEPTH) -> Strategy:
    """Whatever gives a value of a type."""
    plain = variables(kind, level)
    literal = {"M": numbers(level), "C": STRINGS, "P": CONSTANTS, "J": plain}[kind]
    if depth <= 0:
        return plain | literal
    rest = (level, depth - 1)
    made = [plain, literal, targets(kind, level, depth - 1), _status(kind, level, depth)]
    made += [_calls(kind, level, depth), _OPERATIONS[kind](*rest)]
    return st.one_of(made)


@cache
def conditions(level: int, depth: int = DEPTH) -> Strategy:
    """What `If`, `While` and `Wait` take."""
    return st.one_of(_compared(level, depth - 1), expressions("M", level, depth))


def _binary(operators: tuple[str, ...], left: Strategy, right: Strategy) -> Strategy:
    return st.builds(s.Binary, st.sampled_from(operators), left, right)


def _compared(level: int, depth: int) -> Strategy:
    number, text = expressions("M", level, depth), expressions("C", level, depth)
    return st.one_of(_binary(RELATIONS, number, number), _binary(("=", "<>"), text, text))


def _number(level: int, depth: int) -> Strategy:
    number = expressions("M", level, depth)
    function = st.builds(s.Variable, st.just("FNMAVE"), st.just(""), st.tuples(number, number))
    return st.one_of(
        _binary(NUMERIC, number, number),
        _compared(level, depth),
        st.builds(s.Unary, st.sampled_from(("+", "-", "NOT")), number),
        function,
    )


def _text(level: int, depth: int) -> Strategy:
    text = expressions("C", level, depth)
    called = st.builds(s.Variable, st.just("FNCTWICE"), st.just("$"), st.tuples(text))
    return _binary(("+",), text, text) | called


def _position(level: int, depth: int) -> Strategy:
    position, number = expressions("P", level, depth), expressions("M", level, depth)
    return st.one_of(
        _binary(("+", "-", "*", "/"), position, position),
        _binary(("*", "/"), position, number),
        st.builds(s.Pallet, number, number),
    )


def _joints(level: int, depth: int) -> Strategy:
    joints, number = expressions("J", level, depth), expressions("M", level, depth)
    return _binary(("+", "-"), joints, joints) | _binary(("*", "/"), joints, number)


_OPERATIONS: Final[Mapping[str, Callable[[int, int], Strategy]]] = {
    "M": _number,
    "C": _text,
    "P": _position,
    "J": _joints,
}

"""Functions that only MELFA-BASIC has, as other languages are told them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from assistant.languages.melfa_basic.lift.values.elementwise import POSE_FIELDS
from assistant.languages.melfa_basic.lift.values.symbols import (
    VENDOR_ONLY_NAME,
    Symbols,
    Unliftable,
)
from assistant.languages.melfa_basic.tables.functions import FIRST_HAND_CHECK, HAND_CHECKS
from assistant.languages.melfa_basic.tables.library import LIBRARY_FUNCTIONS, library
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program import expressions as e
from assistant.program.program import ValueType


class ArgumentReader(Protocol):
    """What lifts the expressions of a file."""

    m: Symbols

    def plain(self, node: s.Expression) -> e.Expression:
        """Any value."""

    def number(self, node: s.Expression) -> e.Expression:
        """One that is no truth."""

    def rounded(self, node: s.Expression) -> e.Expression:
        """One that is whole."""

    def type_of(self, node: s.Expression | None) -> ValueType:
        """Its type."""


def library_function(key: str, given: Sequence[s.Expression], lift: ArgumentReader) -> e.Expression:
    """What says a function: plain words, an input, or mostly a procedure of the library.

    key: in upper case. Raises Unliftable where there is nothing.
    """
    match key, given:
        case "LEFT", (whole, s.Number(count) as number) if count >= 1:
            return e.Apply("part", (lift.plain(whole), e.Number(1), lift.rounded(number)))
        case "RIGHT", (s.Variable(arguments=None) as whole, s.Number(count)) if count >= 1:
            text, last = lift.plain(whole), round(count)
            first = e.Binary("-", e.Apply("length", (text,)), e.Number(last - 1))
            return e.Apply("part", (text, first, e.Number(last)))
        case "M_HNDCQ", (hand,) if isinstance(known := lift.m.value(hand), float):
            if 1 <= round(known) <= HAND_CHECKS:
                return e.Name(lift.m.signal("M_IN", FIRST_HAND_CHECK - 1 + round(known)))
        case "ZONE", (_, _, _):
            elements = (
                e.Member(_position_with_elements(one, lift), field)
                for one in given
                for field in POSE_FIELDS
            )
            return e.Apply(VENDOR_ONLY_NAME.format("in_box"), tuple(elements))
    name = LIBRARY_FUNCTIONS.get(key, {}).get(len(given))
    if name is None:
        raise Unliftable
    kinds = [one.type for one in library()[name].parameters]
    if any(
        (kind == "position") != (lift.type_of(value) == "position")
        for kind, value in zip(kinds, given, strict=True)
    ):
        raise Unliftable
    values = (
        lift.rounded(value) if kind == "integer" else lift.number(value)
        for kind, value in zip(kinds, given, strict=True)
    )
    return e.Apply(VENDOR_ONLY_NAME.format(name), tuple(values))


def _position_with_elements(node: s.Expression, lift: ArgumentReader) -> e.Expression:
    """A position whose elements can be named."""
    made = lift.plain(node)
    if lift.type_of(node) != "position" or not isinstance(made, e.Name | e.Index | e.Here):
        raise Unliftable
    return made

"""Expressions of RAPID as those of the pseudo-program, and the text of the date.

An expression that the pseudo-program cannot express becomes `Verbatim`, its text unchanged. `CDate`
writes the date as 2026-01-31 (functions manual), other languages write it with slashes: the date of
one language is put together from the parts of the other one's.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import replace
from functools import reduce
from typing import Any, Final

from assistant.languages.patterns import Reading
from assistant.languages.rapid.tables import equivalents
from assistant.languages.rapid.tables.constants import COMPONENTS
from assistant.languages.rapid.tables.equivalents import BINARY
from assistant.languages.rapid.tables.signals import SIGNAL_READ_BY
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.text.printer import expression as printed
from assistant.languages.rapid.text.verbatim import LANGUAGE
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number
from assistant.languages.rapid.tree.walk import called
from assistant.languages.records import aggregate
from assistant.program import expressions as e
from assistant.program.analysis.uses import declared
from assistant.program.geometry import BASE, FLANGE
from assistant.program.program import Program, Signal
from assistant.program.rewriting import rewrite
from assistant.program.statement_index import records_in_procedures

_OPERATORS: Final = {row[0]: name for name, row in BINARY.items()}
_OF_ARM: Final = {word.lower(): name for name, word in equivalents.ARM_FUNCTIONS.items()}
_COMPONENTS: Final = {pair: name for name, pair in COMPONENTS.items()}

Original = Callable[[str], str]


def lift_expression(node: s.Expression, original: Original = str) -> e.Expression:
    """original: gives a shortened name back."""
    return Expressions(original).of(node)


class Expressions:
    """Lifts expressions.

    original: gives a shortened name back. timers: lower-case names of the clocks that are timers.
    used: signals as functions read them, filled as expressions are lifted.
    """

    def __init__(self, original: Original = str, timers: Collection[str] = ()) -> None:
        self.original, self._timers = original, timers
        self.used: list[tuple[str, Signal]] = []
        self.reading: Reading[s.Expression] = Reading(
            {
                "value": lambda node, _: self.of(node),
                "position": lambda node, _: self._part(node, "trans"),
                "turned": lambda node, _: self._part(node, equivalents.ORIENTATION_COMPONENT),
                "timer": lambda node, _: self._timer(node),
                "tool": lambda node, _: self._named(node, tool_name),
                "frame": lambda node, _: self._named(node, frame_name),
            },
            called,
            literal_number,
        )

    def of(self, node: s.Expression) -> e.Expression:
        number = literal_number(node)
        if number is not None:
            # `-0` is 0: the sign would not come back from the text.
            return e.Number(number if number else 0)
        match node:
            case s.StringLiteral(value):
                return e.Text(value)
            case s.BoolLiteral(value):
                return e.Truth(value)
            case s.NameRef(name):
                return e.Name(self.original(name))
            case s.Group(inner):
                return self.of(inner)
            case s.AggregateNode(items):
                return aggregate(tuple(map(self.of, items)))
            case s.Component(s.Component(value, part), name) if (
                known := _COMPONENTS.get((part.lower(), name.lower()))
            ) and not isinstance(value, s.Placeholder):
                return e.Member(self.of(value), known)
            case s.Component(value, name) if not isinstance(value, s.Placeholder):
                if name.lower() not in COMPONENTS:
                    return e.Member(self.of(value), name)
            case s.Element(value, indices) if not isinstance(value, s.Placeholder):
                if not any(isinstance(i, s.Whole) for i in indices):
                    lifted = [self.of(i) for i in indices if not isinstance(i, s.Whole)]
                    return e.Index(self.of(value), tuple(lifted))
            case s.Prefix("NOT", operand):
                return e.Unary("not", self.of(operand))
            case s.Prefix("-", operand):
                return negated(self.of(operand))
            case s.Prefix("+", operand):
                return self.of(operand)
            case s.Infix(operator, left, right) if operator in _OPERATORS:  # or mistaken, as `:=`
                name_ = _OPERATORS[operator]
                return e.Binary(name_, self.of(left), self.of(right))  # type: ignore[arg-type]
            case s.FunctionCall():
                return self._call(node)
        return verbatim_of(node)

    def _call(self, node: s.FunctionCall) -> e.Expression:
        call = called(node)
        if call is None:
            return verbatim_of(node)
        said: e.Expression | None = equivalents.FUNCTION_ROWS.read(call, self.reading)
        if said is not None:
            return said
        name, key = self.original(node.name), node.name.lower()
        match call.given:
            case (value, s.NameRef(tool)) if key in _OF_ARM and value and not call.options:
                if tool.lower() == FLANGE:
                    return e.Apply(_OF_ARM[key], (self.of(value),))
        given = tuple(self.of(argument) for argument in call.given if argument is not None)
        # A routine of RAPID with the name of a neutral function does something else.
        if call.options or name in e.FUNCTIONS:
            return verbatim_of(node)
        if key in equivalents.SIGNAL_FUNCTIONS and len(given) == 1:
            if not isinstance(given[0], e.Name):
                return verbatim_of(node)
            self.used.append((given[0].name, SIGNAL_READ_BY[key]))
            return given[0]
        # A form that no row matches has no equivalent, unlike a function of the program.
        if key in equivalents.FUNCTION_ROWS and key not in equivalents.NO_OTHER:
            return verbatim_of(node)
        return e.Apply(name, given)

    def oriented(self, target: s.Expression, value: s.Expression) -> e.Expression | None:
        """The target that `target:=value` turns to angles, as a whole with them."""
        place, other = (
            self._part(target, equivalents.ORIENTATION_COMPONENT),
            self._part(value, equivalents.ORIENTATION_COMPONENT),
        )
        if place is not None and other is not None:
            return e.Apply("oriented", (place, *(e.Member(other, name) for name in e.ANGLES)))
        call = called(value)
        found = None if call is None else self.reading.fields(equivalents.ORIENTATION, call)
        if found is None or place is None:
            return None
        return e.Apply("oriented", (place, *(found[name] for name in e.ANGLES)))

    def _part(self, node: s.Expression, name: str) -> e.Expression | None:
        """The target of which a node is the position or orientation."""
        if isinstance(node, s.Component) and node.name.lower() == name:
            return None if isinstance(node.value, s.Placeholder) else self.of(node.value)
        return None

    def _timer(self, node: s.Expression) -> str | None:
        known = isinstance(node, s.NameRef) and node.name.lower() in self._timers
        return self._named(node, str) if known else None

    def _named(self, node: s.Expression, meant: Callable[[str], str]) -> str | None:
        return meant(self.original(node.name)) if isinstance(node, s.NameRef) else None


def verbatim_of(node: s.Expression) -> e.Verbatim:
    """An expression as its text."""
    text = printed(node)
    return e.Verbatim(LANGUAGE, text, effect=verbatim.effect_of_nodes((node,), text))


def negated(operand: e.Expression) -> e.Expression:
    if isinstance(operand, e.Number):
        # Keeps 0 without a sign.
        return e.Number(-operand.value if operand.value else operand.value)
    return e.Unary("-", operand)


def tool_name(name: str) -> str:
    return FLANGE if name.lower() == FLANGE else name


def frame_name(name: str) -> str:
    return BASE if name.lower() in ("", "wobj0", BASE) else name


_RAPID_DATE: Final = "cdate"
_NEUTRAL_DATE: Final = "date_today"
_DATE_PARTS: Final = ((1, 4), (6, 2), (9, 2))
"""First character and length of year, month and day."""


def with_neutral_dates(program: Program) -> Program:
    """The program with dates as other languages have them."""
    return _with_date_function(program, _RAPID_DATE, _NEUTRAL_DATE, "-")


def with_own_dates(program: Program) -> Program:
    """The program with dates of RAPID."""
    return _with_date_function(program, _NEUTRAL_DATE, _RAPID_DATE, "/")


def with_neutral_radian(program: Program) -> Program:
    """The program with angles in radian as other languages have them.

    The name `pi` is its value by now, unless the program declares another one.
    """

    def visit(part: Any) -> Any:
        match part:
            case e.Binary("/", e.Binary("*", value, e.Number(math.pi)), e.Number(180)):
                return e.Binary("*", value, e.Number(e.DEGREE))
            case e.Binary("/", e.Binary("*", value, e.Number(180)), e.Number(math.pi)):
                return e.Binary("/", value, e.Number(e.DEGREE))
        return part

    return replace(program, procedures=rewrite(program.procedures, visit))


def with_own_radian(program: Program) -> Program:
    """The program with angles in radian as people write them in RAPID, `300*pi/180`."""
    # Another name of the program hides that of the constant.
    pi = e.Number(math.pi) if "pi" in declared(program) else e.Name("pi")

    def visit(part: Any) -> Any:
        match part:
            case e.Binary("*", value, e.Number(e.DEGREE)):
                return e.Binary("/", e.Binary("*", value, pi), e.Number(180))
            case e.Binary("/", value, e.Number(e.DEGREE)):
                return e.Binary("/", e.Binary("*", value, e.Number(180)), pi)
        return part

    return replace(program, procedures=rewrite(program.procedures, visit))


def _with_date_function(program: Program, old: str, new: str, between: str) -> Program:
    used = any(part.function.lower() == old for part in records_in_procedures(program, e.Apply))
    # A routine of the program with that name is not the date.
    if not used or program.procedure(old) is not None:
        return program
    pieces = [e.Apply("part", (e.Apply(new), e.Number(a), e.Number(n))) for a, n in _DATE_PARTS]
    first, *others = pieces
    made = reduce(_joined_by(between), others, first)

    def visit(part: Any) -> Any:
        match part:
            case e.Apply(name, ()) if name.lower() == old:
                return made
        return part

    return replace(program, procedures=rewrite(program.procedures, visit))


def _joined_by(between: str) -> Any:
    def join(left: e.Expression, right: e.Expression) -> e.Expression:
        return e.Binary("+", e.Binary("+", left, e.Text(between)), right)

    return join

"""Names and expressions of the pseudo-program in RAPID.

Names that RAPID cannot have get another one; the header of a module keeps the original. Expressions
get parentheses where RAPID's priorities or readers need them. `RECORDS` rounds the values of
records to the decimals that are printed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.languages.patterns import Writing
from assistant.languages.rapid import rules
from assistant.languages.rapid.tables import equivalents
from assistant.languages.rapid.tables.constants import (
    COMPONENTS,
    LONGEST_NAME,
    LONGEST_STRING,
    RESERVED,
    UNUSED,
)
from assistant.languages.rapid.tables.equivalents import BINARY, OR, PRIMARY, SUM, TERM
from assistant.languages.rapid.tables.predefined import taken_names
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.syntax import (
    JOINT_PLACES,
    POSITION_PLACES,
    QUATERNION_PLACES,
    SIZES_PLACES,
)
from assistant.languages.rapid.tree.walk import function_call
from assistant.languages.records import Decimals, Values
from assistant.languages.scoped_names import Naming, Scopes
from assistant.program import expressions as e
from assistant.program.geometry import FLANGE
from assistant.program.program import Program


def _declared_names(program: Program) -> Iterator[str]:
    """Yield the names in RAPID declarations of the program; raises Refused if a declaration is not
    RAPID.
    """
    for declaration in program.declarations:
        if declaration.language == verbatim.LANGUAGE:
            for item in verbatim.items(declaration.text):
                if hasattr(item, "name"):
                    yield item.name


NAMES: Final = Scopes(
    longest=LONGEST_NAME,
    reserved=taken_names() | RESERVED,
    kept=_declared_names,
    flange=FLANGE,
    base="",
    renamed=rules.SHORTENED,
    language="RAPID",
)


RECORDS: Final = Decimals(
    POSITION_PLACES, QUATERNION_PLACES, JOINT_PLACES, SIZES_PLACES, rules.NOT_FINITE
)


def not_expressible(what: str, cure: str) -> Refused:
    """RAPID has no words for it."""
    return Refused(rules.NO_MEANING(what=what, cure=cure))


class Expressions:
    """names: of the whole program. value: RAPID's name of a variable, target or signal."""

    def __init__(self, names: Naming, value: Callable[[str], str]) -> None:
        self._names, self._value = names, value
        self.writing: Writing[s.Expression] = Writing(
            {
                "value": lambda x, _: self.lower(x),
                "position": lambda x, _: s.Component(self._variable(x), "trans"),
                "turned": lambda x, _: self.orientation(x),
                "timer": lambda x, _: s.NameRef(names.get("timers", x)),
                "tool": lambda x, _: s.NameRef(names.get("tools", x)),
                # No move names the base, but `CRobT` does.
                "frame": lambda x, _: s.NameRef(names.get("frames", x) or "wobj0"),
            },
            function_call,
            lambda value: number(value)[0],
        )

    def lower(self, expression: e.Expression, level: int = OR) -> s.Expression:
        """Lower an expression, in parentheses if it binds less tightly than `level`; raises Refused
        if RAPID cannot express it.
        """
        node, own = self._lower(expression)
        return node if own >= level else s.Group(node)

    def _lower(self, x: e.Expression) -> tuple[s.Expression, int]:
        match x:
            case e.Number(value):
                return number(value)
            case e.Truth(value):
                return s.BoolLiteral(value), PRIMARY
            case e.Text(value):
                return text(value), PRIMARY
            case e.Name(name):
                return s.NameRef(self._value(name)), PRIMARY
            case e.TargetValue(record) | e.JointValue(record) | e.PoseValue(record):
                return bracketed(RECORDS.values(record)), PRIMARY
            case e.Aggregate(items):
                return s.AggregateNode(tuple(self.lower(i) for i in items)), PRIMARY
            case e.Member(_, name) if name.lower() in e.ANGLES:
                call = equivalents.FUNCTION_ROWS.write(x, self.writing)
                assert call is not None
                return function_call(call), PRIMARY
            case e.Member(value, name):
                node = self._variable(value)
                for part in COMPONENTS.get(name, (name,)):
                    node = s.Component(node, part)
                return node, PRIMARY
            case e.Index(value, indices):
                node = self._variable(value)
                return s.Element(node, tuple(self.lower(i) for i in indices)), PRIMARY
            case e.Unary("not", operand):
                # `NOT a AND b` negates both in RAPID, which no reader expects.
                return s.Prefix("NOT", self.lower(operand, PRIMARY)), OR
            case e.Unary(_, operand):
                # A sign belongs to a sum: `a*-1` is not RAPID.
                return s.Prefix("-", self.lower(operand, TERM)), SUM
            case e.Binary(operator, left, right) if operator in BINARY:
                name, own, first, second = BINARY[operator]
                sides = (
                    self.lower(side, PRIMARY if _in_doubt(operator, side) else level)
                    for side, level in ((left, first), (right, second))
                )
                return s.Infix(name, *sides), own
            case e.Binary() | e.Apply() | e.Elapsed() | e.Here():
                call = equivalents.FUNCTION_ROWS.write(x, self.writing)
                if call is not None:
                    return function_call(call), PRIMARY
                assert isinstance(x, e.Apply)
                return self._apply(x.function, x.arguments), PRIMARY
            case e.Verbatim():
                return self._verbatim(x)

    def orientation(self, x: e.Expression) -> s.Component:
        return s.Component(self._variable(x), equivalents.ORIENTATION_COMPONENT)

    def oriented(self, angles: tuple[e.Expression, ...]) -> s.FunctionCall:
        """The orientation of angles about x, y and z."""
        said = dict(zip(e.ANGLES, angles, strict=True))
        call = self.writing.called(equivalents.ORIENTATION, said)
        assert call is not None
        return function_call(call)

    def _variable(self, x: e.Expression) -> s.Variable:
        node = self.lower(x, PRIMARY)
        if isinstance(node, s.NameRef | s.Component | s.Element):
            return node
        raise not_expressible("a component of an expression", "put the value into a variable first")

    def _apply(self, function: str, given: tuple[e.Expression, ...]) -> s.FunctionCall:
        if function in equivalents.ARM_FUNCTIONS and len(given) == 1:
            values = (self.lower(given[0]), s.NameRef(FLANGE))
            return s.FunctionCall(
                equivalents.ARM_FUNCTIONS[function], tuple(map(s.Positional, values))
            )
        if function in e.FUNCTIONS:
            what = f"the function `{function}` of {len(given)} arguments"
            raise not_expressible(what, "compute the value otherwise")
        name = self._names.get("procedures", function)
        return s.FunctionCall(name, tuple(s.Positional(self.lower(a)) for a in given))

    def _verbatim(self, x: e.Verbatim) -> tuple[s.Expression, int]:
        if x.language != verbatim.LANGUAGE:
            raise Refused(rules.OTHER_LANGUAGE(**verbatim.foreign(x)))
        node = verbatim.expression(x.text)
        return node, OR if isinstance(node, s.Prefix | s.Infix) else PRIMARY


def _in_doubt(operator: str, operand: e.Expression) -> bool:
    return isinstance(operand, e.Binary) and e.needs_parentheses_for_readers(
        operator, operand.operator
    )


def number(value: float) -> tuple[s.Expression, int]:
    if not math.isfinite(value):
        raise Refused(rules.NOT_FINITE(what="an expression"))
    size = abs(value)
    # Beyond 15 digits a float is not printed exactly as a whole number.
    written = str(int(size)) if size == int(size) and size < 1e15 else repr(float(size))
    literal = s.NumberLiteral("9E9" if size == UNUSED else written)
    if math.copysign(1.0, value) < 0 and value != 0:
        return s.Prefix("-", literal), SUM
    return literal, PRIMARY


def text(value: str) -> s.StringLiteral:
    if len(value) > LONGEST_STRING:
        raise Refused(rules.LONG_STRING(length=len(value), place=value[:20]))
    if any(ord(c) > 255 for c in value):
        raise not_expressible(f"the characters of {value[:30]!a}", "use letters of Latin-1 only")
    return s.StringLiteral(value)


def bracketed(values: Values) -> s.Expression:
    """The node of values, see `records`."""
    match values:
        case list():
            return s.AggregateNode(tuple(map(bracketed, values)))
        case bool():
            return s.BoolLiteral(values)
        case str():
            return s.StringLiteral(values)
    return number(values)[0]

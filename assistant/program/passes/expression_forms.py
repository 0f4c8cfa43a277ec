"""Expressions for languages that lack truth values, whole numbers or some functions.

Elsewhere a number that is not 0 holds as well. In a language whose numbers are of one type a
variable of whole numbers is rounded.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.declared_types import KnownTypes, is_number, is_truth
from assistant.program.analysis.integer_inference import NumberFacts
from assistant.program.program import Procedure, Program, Variable
from assistant.program.rewriting import head, map_bodies, records
from assistant.program.statement_index import records_in_body

_OPPOSITE: Final[dict[str, Any]] = {
    "=": "<>", "<>": "=", "<": ">=", ">=": "<", ">": "<=", "<=": ">", "and": "or", "or": "and",
}  # fmt: skip


def without_truth_values(value: e.Expression) -> e.Expression:
    """An expression without truth values and `not`; signs of numbers are part of them.

    For a language whose truths are numbers, and whose `not` works on bits.
    """
    match value:
        case e.Truth(truth):
            return e.Number(int(truth))
        case e.Unary("-", e.Number(number)):
            return e.Number(-number)
        case e.Unary("not", operand):
            return opposite(operand)
    return value


def opposite(value: e.Expression) -> e.Expression:
    """Return the negation of a truth value."""
    match value:
        case e.Binary("and" | "or" as operator, left, right):
            return e.Binary(_OPPOSITE[operator], opposite(left), opposite(right))
        case e.Binary(operator, left, right) if operator in _OPPOSITE:
            return e.Binary(_OPPOSITE[operator], left, right)
        case e.Number(number):
            return e.Number(int(number == 0))
    # Anything else holds if it is not 0.
    return e.Binary("=", value, e.Number(0))


def floor(x: e.Expression) -> e.Expression:
    """Return the largest integer below or equal to x: one less than the truncated value if that is
    larger.

    The remainder of a number after truncation is greater than -1 and less than 1.
    """
    # The remainder is above -1: 1 added makes it positive, so truncation rounds down.
    whole = e.Apply("trunc", (x,))
    rest = e.Binary("+", e.Binary("-", x, whole), e.Number(1))
    return e.Binary("-", e.Binary("+", whole, e.Apply("trunc", (rest,))), e.Number(1))


_MOST_DECIMALS: Final = 15
"""A float has no more digits than these for sure."""


def fixed_text(value: e.Expression, places: float) -> e.Expression:
    """A number as text with so many decimals at most, and no more than a float has."""
    if places <= 0:
        return e.Apply("text", (e.Apply("round", (value,)),))
    power = e.Number(10 ** int(min(places, _MOST_DECIMALS)))
    whole = e.Apply("round", (e.Binary("*", value, power),))
    return e.Apply("text", (e.Binary("/", whole, power),))


def two_at_a_time(x: e.Apply) -> e.Expression:
    """The smallest or largest of two at a time."""
    one, *others = x.arguments
    for other in others:
        one = e.Apply(x.function, (one, other))
    return one


def with_shift_parts(x: e.Apply, parts: int | None = None) -> e.Apply:
    """A moved target with so many parts of what it is moved by, or with none of 0 at the end."""
    given, none = x.arguments, e.Number(0)
    if parts is not None:
        # The first argument is the target.
        return e.Apply(x.function, given + (none,) * (1 + parts - len(given)))
    while len(given) > 4 and given[-1] in (none, e.Number(0.0)):
        given = given[:-1]
    return e.Apply(x.function, given)


def with_conditions(statement: p.Statement, known: KnownTypes) -> p.Statement:
    """The statement with its own conditions as truth values; bodies are left alone."""
    match statement:
        case p.If(branches):
            made = tuple(replace(b, condition=condition(b.condition, known)) for b in branches)
            return replace(statement, branches=made)
        case p.Interrupt(ends=ends) if ends is not None:
            inner = condition(statement.condition, known), condition(ends, known)
            return replace(statement, condition=inner[0], ends=inner[1])
        case p.Move() | p.MoveCircular() | p.MoveJoints() if statement.until is not None:
            return replace(statement, until=condition(statement.until, known))
        case p.While() | p.WaitUntil() | p.Interrupt():
            return replace(statement, condition=condition(statement.condition, known))
    return statement


def compared(x: e.Expression, known: KnownTypes) -> e.Expression:
    """A truth that is compared with 0 or 1 as itself: it is compared with truths only."""
    match x:
        case e.Binary("=" | "<>" as operator, left, e.Number(value)) if value in (
            0,
            1,
        ) and is_truth(left, known):
            return e.Unary("not", left) if (operator == "=") == (value == 0) else left
    return x


def as_truth(x: e.Expression) -> e.Expression:
    """The value of a truth: 0 and 1 stand for them elsewhere."""
    return e.Truth(x.value != 0) if isinstance(x, e.Number) else x


def condition(x: e.Expression, known: KnownTypes) -> e.Expression:
    """The expression, or that it is not 0 if it is a number."""
    match x:
        case e.Number(value):
            return e.Truth(value != 0)
        case e.Binary("and" | "or" | "xor", left, right):
            return replace(x, left=condition(left, known), right=condition(right, known))
        case e.Unary("not", operand):
            return e.Unary("not", condition(operand, known))
    return e.Binary("<>", x, e.Number(0)) if is_number(x, known) else x


def with_rounded_values(program: Program) -> Program:
    """The program with `round` wherever a variable of whole numbers is given what may be none.

    That is an assignment, the first value of a loop, a parameter, a result, and what a routine
    gives back in a number of the caller's.
    """
    declared = [*program.variables.values()]
    for procedure in program.procedures:
        declared += procedure.variables.values()
        declared += procedure.parameters  # type: ignore[arg-type]
    kinds = {one.type for one in declared} | {q.result for q in program.procedures}
    return _Rounding(program).done() if "integer" in kinds else program


@dataclass
class _Rounding:
    program: Program

    def __post_init__(self) -> None:
        self.numbers = NumberFacts(self.program)
        self.callees = {q.name.lower(): q for q in self.program.procedures}
        self.common = {n.lower(): v.type for n, v in self.program.variables.items()}

    def done(self) -> Program:
        return replace(
            self.program, procedures=tuple(map(self._procedure, self.program.procedures))
        )

    def _procedure(self, procedure: Procedure) -> Procedure:
        kinds = self.common | {n.lower(): v.type for n, v in procedure.variables.items()}
        kinds |= {one.name.lower(): one.type for one in procedure.parameters}
        inside = _Inside(self, procedure, kinds)
        taken = [
            _rounded(e.Name(one.name))
            for at, one in enumerate(procedure.parameters)
            if one.type == "integer" and not one.dimensions and self._is_given_parts(procedure, at)
        ]
        body = (*taken, *inside.body(procedure.body))
        return procedure if body == procedure.body else replace(procedure, body=body)

    def _is_given_parts(self, procedure: Procedure, at: int) -> bool:
        """True if a call may pass a number that is not an integer to a parameter by value."""
        if procedure.parameters[at].mode != "in":
            return False
        for caller in self.program.procedures:
            calls = [(one.procedure, one.arguments) for one in records_in_body(caller, p.Call)]
            calls += [(one.function, one.arguments) for one in records_in_body(caller, e.Apply)]
            for called, given in calls:
                if called.lower() != procedure.name.lower() or at >= len(given):
                    continue
                if given[at] is not None and not self.numbers.of(given[at], caller).whole:
                    return True
        return False


@dataclass
class _Inside:
    """Rounds inside one procedure. kinds: the types of the names that it knows."""

    whole: _Rounding
    procedure: Procedure
    kinds: Mapping[str, str]

    def body(self, statements: tuple[p.Statement, ...]) -> tuple[p.Statement, ...]:
        return tuple(one for node in statements for one in self._said(node))

    def _said(self, node: p.Statement) -> Iterator[p.Statement]:
        node = map_bodies(node, self.body)
        match node:
            case p.Assign(target, value) if self._is_integer(target):
                yield replace(node, value=self._round(value))
            case p.For(variable, first) if self.kinds.get(variable.lower()) == "integer":
                yield replace(node, first=self._round(first))
            case p.Return(value) if value is not None and self.procedure.result == "integer":
                yield replace(node, value=self._round(value))
            case _:
                yield node
        for place in self._given_back(node):
            yield _rounded(place)

    def _round(self, value: e.Expression) -> e.Expression:
        if isinstance(value, e.Verbatim) or self.whole.numbers.of(value, self.procedure).whole:
            return value
        return e.Apply("round", (value,))

    def _is_integer(self, place: Any) -> bool:
        match place:
            case e.Name(name) | e.Index(e.Name(name)):
                return self.kinds.get(name.lower()) == "integer"
        return False

    def _given_back(self, node: p.Statement) -> Iterator[e.Expression]:
        """Variables of whole numbers that a routine of the program may change as any number."""
        for part in records(head(node)):
            match part:
                case p.Call(called, arguments) | e.Apply(called, arguments):
                    callee = self.whole.callees.get(called.lower())
                    parameters = () if callee is None else callee.parameters
                    for parameter, given in zip(parameters, arguments, strict=False):
                        number = parameter.mode == "inout" and parameter.type == "number"
                        if number and not parameter.dimensions and self._is_integer(given):
                            yield given


def _rounded(place: Any) -> p.Assign:
    return p.Assign(place, e.Apply("round", (place,)))


def with_one_kind_of_numbers(program: Program) -> Program:
    """The program with numbers for variables, parameters and results of whole numbers."""
    return replace(
        program,
        variables=_with_number_types(program.variables),
        procedures=tuple(
            replace(
                q,
                variables=_with_number_types(q.variables),
                parameters=tuple(map(_as_number_type, q.parameters)),
                result="number" if q.result == "integer" else q.result,
            )
            for q in program.procedures
        ),
    )


def _with_number_types(variables: Mapping[str, Variable]) -> dict[str, Variable]:
    return {name: _as_number_type(variable) for name, variable in variables.items()}


def _as_number_type(declared: Any) -> Any:
    return replace(declared, type="number") if declared.type == "integer" else declared

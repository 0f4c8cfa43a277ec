"""Values of targets and expressions of a program, as far as its text states them.

`Names` resolves the target expressions of a moving statement; `Values` evaluates numbers and
conditions with the variables that are known where the program has come to.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import Any, Final, TypeVar

from assistant.base import rotations
from assistant.base.data_classes import dataclass
from assistant.program.analysis.uses import changed_locals, changed_variables
from assistant.program.expressions import (
    Aggregate,
    Apply,
    Binary,
    Expression,
    Index,
    JointValue,
    Member,
    Name,
    Number,
    TargetValue,
    Truth,
    Unary,
)
from assistant.program.geometry import BASE, FLANGE, Frame, JointTarget, Pose, Target, Tool
from assistant.program.program import Procedure, Program, Variable
from assistant.program.rewriting import map_expressions, records
from assistant.program.statements import Assign, Comment, Follow, If, Opaque, Return, Statement
from assistant.program.vendor_statements import effect_of

V = TypeVar("V")
ValueOf = Callable[[str], Expression | None]
"""Looks a name in lower case up."""


@dataclass(frozen=True, slots=True)
class Place:
    """A target and the pose that a move goes to: its own, or one `moved` from there."""

    target: Target
    pose: Pose
    moved: bool = False


class Names:
    """The names of a program; without regard to case, a procedure's own ones first.

    A variable that nothing in the program changes counts as a constant with its first value. So
    does persistent data where it is, or is part of, a place: that is its best known value. A
    condition is not decided by it, as an operator or another task may set it between two runs.
    """

    def __init__(self, program: Program) -> None:
        self._program = program
        self.tools = {FLANGE: Tool()} | _lowered(program.tools)
        self.frames = {BASE: Frame()} | _lowered(program.frames)
        self.shared_targets = _lowered(program.targets)
        self.shared_joints = _lowered(program.joint_targets)
        lasting = dict(_lasting_values(program.variables, lambda: changed_variables(program)))
        self.shared_values = {name: value for name, (value, _) in lasting.items()}
        self.shared_constants = {
            name: value for name, (value, storage) in lasting.items() if storage != "persistent"
        }
        self.own: dict[str, Expression | None] = {}

    def enter(self, procedure: Procedure) -> None:
        """Takes over the variables and parameters of a procedure."""
        names = (one.name for one in procedure.parameters)
        self.own = {name.lower(): None for name in (*names, *procedure.variables)}
        program = self._program
        found = _lasting_values(procedure.variables, lambda: changed_locals(program, procedure))
        self.own |= {name: value for name, (value, _) in found}

    def tool(self, name: str) -> Tool | None:
        return self.tools.get(name.lower())

    def frame(self, name: str) -> Frame | None:
        return self.frames.get(name.lower())

    def place(self, expression: Expression, depth: int = 8) -> Place | None:
        """Return the target of a move; None if it is known only when the program runs."""
        match expression:
            case TargetValue():
                return Place(expression.target, expression.target.pose)
            case Name():
                key = expression.name.lower()
                if key not in self.own and key in self.shared_targets:
                    target = self.shared_targets[key]
                    return Place(target, target.pose)
                value = self.lasting(key)
                return self.place(value, depth - 1) if value is not None and depth else None
            case Index():
                value = self.element(expression, self.lasting)
                return self.place(value, depth - 1) if value is not None and depth else None
            case Apply(function=name, arguments=(first, *rest)) if name in SHIFTS and depth:
                place = self.place(first, depth - 1)
                numbers = [self.number(one, value_of=self.lasting) for one in rest]
                shift = SHIFTS[name](*[n for n in numbers if n is not None])
                if place is None or None in numbers or shift is None:
                    return None
                pose = place.pose
                if name == "offset":
                    x, y, z = (a + b for a, b in zip(pose.position, shift.position, strict=True))
                    return Place(place.target, Pose((x, y, z), pose.quaternion), moved=True)
                return Place(place.target, pose @ shift, moved=True)
        return None

    def joints(self, expression: Expression) -> JointTarget | None:
        match expression:
            case JointValue():
                return expression.target
            case Name():
                key = expression.name.lower()
                if key not in self.own and key in self.shared_joints:
                    return self.shared_joints[key]
                value = self.lasting(key)
                return value.target if isinstance(value, JointValue) else None
            case Index():
                value = self.element(expression, self.lasting)
                return value.target if isinstance(value, JointValue) else None
        return None

    def element(self, place: Index, value_of: ValueOf | None = None) -> Expression | None:
        """Return an element of an array; None if only running the program tells which or what."""
        found: Expression | None = place.value
        if isinstance(found, Name):
            found = (value_of or self.constant)(found.name.lower())
        for index in place.indices:
            number = self.number(index, value_of=value_of)
            if number is None or not isinstance(found, Aggregate):
                return None
            if number != int(number) or not 1 <= number <= len(found.items):
                return None
            found = found.items[int(number) - 1]
        return found

    def constant(self, key: str) -> Expression | None:
        return self.own[key] if key in self.own else self.shared_constants.get(key)

    def lasting(self, key: str) -> Expression | None:
        """The value of a constant, or of persistent data that the program does not change."""
        return self.own[key] if key in self.own else self.shared_values.get(key)

    def number(
        self, expression: Expression, depth: int = 8, value_of: ValueOf | None = None
    ) -> float | None:
        """The value of a number that the text tells; value_of: `constant` unless stated."""
        match expression:
            case Number(value=value):
                return float(value)
            case Unary(operator="-", operand=operand):
                inner = self.number(operand, depth, value_of)
                return None if inner is None else -inner
            case Binary(operator="+" | "-" | "*" as operator, left=left, right=right):
                a = self.number(left, depth, value_of)
                b = self.number(right, depth, value_of)
                if a is None or b is None:
                    return None
                return a + b if operator == "+" else a - b if operator == "-" else a * b
            case Name(name=name) if depth:
                meant = (value_of or self.constant)(name.lower())
                return None if meant is None else self.number(meant, depth - 1, value_of)
        return None


def _offset(x: float = 0.0, y: float = 0.0, z: float = 0.0, *rest: float) -> Pose | None:
    return None if rest else Pose((x, y, z))


def _relative(
    x: float = 0.0, y: float = 0.0, z: float = 0.0,
    rx: float = 0.0, ry: float = 0.0, rz: float = 0.0, *rest: float,
) -> Pose | None:  # fmt: skip
    """A move in the tool frame; None for turns about several axes, whose order languages
    disagree about.
    """
    turns = [turn for turn in zip("XYZ", (rx, ry, rz), strict=True) if turn[1]]
    if rest or len(turns) > 1 or not math.isfinite(x + y + z + rx + ry + rz):
        return None
    q = [1.0, 0.0, 0.0, 0.0]
    for axis, degrees in turns:
        q = rotations.canonical(rotations.about(rotations.AXES[axis], degrees)).tolist()
    return Pose((x, y, z), (q[0], q[1], q[2], q[3]))


SHIFTS: Final = {"offset": _offset, "relative": _relative}


def _lasting_values(
    variables: Mapping[str, Variable], changed: Callable[[], Collection[str]]
) -> Iterator[tuple[str, tuple[Expression, str]]]:
    """Values and storage of variables, by name in lower case, that nothing gives another value.

    changed: returns the names of those that may change.
    """
    valued = {n.lower(): one for n, one in variables.items() if one.initial is not None}
    # Most programs have only constants, which nothing needs to be searched for.
    variable = any(one.storage != "constant" for one in valued.values())
    others = changed() if variable else ()
    for name, one in valued.items():
        if one.initial is not None and (one.storage == "constant" or name not in others):
            yield name, (one.initial, one.storage)


def _lowered(table: Mapping[str, V]) -> dict[str, V]:
    return {name.lower(): value for name, value in table.items()}


KnownValues = dict[str, Expression | None]

_MOST_CALL_DEPTH: Final = 16
"""Functions that are called within each other."""
_COMPARISONS: Final[dict[str, Callable[[float, float], bool]]] = {
    "=": lambda a, b: a == b,
    "<>": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
}
_UNKNOWN: Final = Name("")
"""Stands for a value that is not known: no name of a program."""


class Values:
    """Looks expressions up in the names of a program.

    names: with the values of variables that are known now in `own`.
    """

    def __init__(self, program: Program, names: Names) -> None:
        self.names = names
        self.functions = {
            one.name.lower(): one for one in program.procedures if one.result is not None
        }
        self.depth = 0

    def number(self, expression: Expression) -> float | None:
        return self.names.number(self.settled(expression))

    def place(self, expression: Expression) -> Place | None:
        return self.names.place(self.settled(expression))

    def truth(self, expression: Expression) -> bool | None:
        """True if a condition holds; None if it is known only when the program runs."""
        return self._truth(self.settled(expression))

    def value(self, expression: Expression) -> Expression | None:
        """The number, truth, target or array that an expression stands for now."""
        settled = self.settled(expression)
        number = self.names.number(settled)
        if number is not None:
            return Number(number)
        place = self.names.place(settled)
        if place is not None:
            target = place.target
            return TargetValue(type(target)(place.pose, target.configuration, target.external))
        if isinstance(settled, Name):
            settled = self.names.constant(settled.name.lower()) or settled
        return settled if isinstance(settled, Truth | Aggregate) else None

    def settled(self, expression: Expression) -> Expression:
        """The expression with its array elements, components and function calls looked up."""
        return map_expressions(expression, self._settled)

    def _settled(self, part: Expression) -> Expression:
        found: Expression | None = None
        match part:
            case Index():
                found = self.names.element(part)
            case Member(value=value, field="x" | "y" | "z" as axis):
                place = self.names.place(value)
                found = None if place is None else Number(place.pose.position["xyz".index(axis)])
            case Apply(function=name, arguments=arguments) if name.lower() in self.functions:
                found = self._result(self.functions[name.lower()], arguments)
        return part if found is None else found

    def _result(self, function: Procedure, arguments: Sequence[Expression]) -> Expression | None:
        """Return the result of a function, if it only computes."""
        if self.depth >= _MOST_CALL_DEPTH:
            return None
        given = self.given(function, arguments)
        outer, self.depth = self.names.own, self.depth + 1
        self.names.own = {**outer, **local_values(function), **given}
        try:
            found = self._returned(function.body)
            return None if found is _UNKNOWN else found
        finally:
            self.names.own, self.depth = outer, self.depth - 1

    def given(self, procedure: Procedure, arguments: Sequence[Expression]) -> KnownValues:
        """Values of the parameters of a call, in lower case."""
        pairs = zip(procedure.parameters, arguments, strict=False)
        return {parameter.name.lower(): self.value(argument) for parameter, argument in pairs}

    def _returned(self, body: Sequence[Statement]) -> Expression | None:
        """The value that a body returns; None if it does what is no computing, or `_UNKNOWN` if
        it goes on behind its end.
        """
        for statement in body:
            match statement:
                case Comment():
                    continue
                case Assign(target=Name(name), value=value):
                    self.names.own[name.lower()] = self.value(value)
                case Return(value=value) if value is not None:
                    return self.value(value)
                case If():
                    chosen = self.chosen(statement)
                    found = None if chosen is None else self._returned(chosen)
                    if found is not _UNKNOWN:
                        return found
                case _:
                    return None
        return _UNKNOWN

    def chosen(self, statement: If) -> Sequence[Statement] | None:
        """The body that is run; None if only running the program tells."""
        for branch in statement.branches:
            holds = self.truth(branch.condition)
            if holds is None:
                return None
            if holds:
                return branch.body
        return statement.otherwise

    def _truth(self, expression: Expression) -> bool | None:
        match expression:
            case Truth(value=value):
                return value
            case Unary(operator="not", operand=operand):
                inner = self._truth(operand)
                return None if inner is None else not inner
            case Binary(operator="and" | "or" as operator, left=left, right=right):
                sides = {self._truth(left), self._truth(right)}
                deciding = operator == "or"
                if deciding in sides:
                    return deciding
                return None if None in sides else not deciding
            case Binary(operator=operator, left=left, right=right) if operator in _COMPARISONS:
                a, b = self.names.number(left), self.names.number(right)
                return None if a is None or b is None else _COMPARISONS[operator](a, b)
            case Name(name=name):
                meant = self.names.constant(name.lower())
                return meant.value if isinstance(meant, Truth) else None
        return None


def first_values(variables: Mapping[str, Variable], assigned: set[str]) -> KnownValues:
    """Values of variables, in lower case, before anything is assigned.

    assigned: persistent ones of these names may have been changed by an earlier run.
    """
    return {
        name.lower(): variable.initial
        for name, variable in variables.items()
        if isinstance(variable.initial, Number | Truth | TargetValue | Aggregate)
        and not (variable.storage == "persistent" and name.lower() in assigned)
    }


def local_values(procedure: Procedure) -> KnownValues:
    """The variables of a procedure as a call begins; None for what has no value that is known."""
    unknown: KnownValues = {name.lower(): None for name in procedure.variables}
    return {**unknown, **first_values(procedure.variables, set())}


def loop_rounds(first: float, last: float, step: float | None) -> int:
    """Return the number of rounds of a loop from first to last; see `For`."""
    by = step if step is not None else (1.0 if last >= first else -1.0)
    if by == 0.0 or not math.isfinite(first + last + by):
        return 0
    return max(0, math.floor((last - first) / by + 1e-9) + 1)


def root_variable(target: Expression) -> str:
    """The variable, in lower case, that a target of an assignment is of."""
    while isinstance(target, Member | Index):
        target = target.value
    return target.name.lower() if isinstance(target, Name) else ""


def may_read(statement: Statement, name: str) -> bool:
    """True if a statement may read a variable; name: in lower case."""
    if isinstance(statement, Opaque):
        return name in effect_of(statement).names
    parts: Any = records(statement)
    return not isinstance(statement, Follow) and any(
        isinstance(part, Name) and part.name.lower() == name for part in parts
    )

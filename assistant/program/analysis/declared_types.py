"""Types of expressions and spellings of names, as far as the declarations of a program give them.

A program writes names in any case.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Mapping
from typing import Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure, Program, Signal, ValueType, walk
from assistant.program.statement_index import once_per_program, records_in_body
from assistant.program.undeclared_names import timers

KnownTypes = Mapping[str, str]
"""Lower-case names of values and functions: `text`, or anything else for other values."""

COMPONENTS: Final = frozenset(
    ("x", "y", "z", *e.ANGLES, *e.EXTERNAL, *(f"j{axis}" for axis in range(1, 7)))
)
"""Components of positions and joints, which are numbers; other members belong to records."""

_TEXTS: Final = (
    "text", "fixed", "part", "character", "received", "date_today", "time_of_day",
)  # fmt: skip
"""The type, and functions that give one."""
_LITERALS: Final = (e.Number, e.Truth, e.TargetValue, e.JointValue, e.PoseValue)
_ARITHMETIC: Final = ("+", "-", "*", "/", "div", "mod", "^")
_TRUTHS: Final = (*e.LOGICAL, *e.RELATIONS)
_NUMBERS: Final = ("number", "integer")


def known_types(program: Program, procedure: Procedure) -> KnownTypes:
    """Return the known types of the names that a procedure sees."""
    shared = _shared(program)
    known: dict[str, str] = {n.lower(): v.type for n, v in procedure.variables.items()}
    known |= {q.name.lower(): q.type for q in procedure.parameters}
    for loop in records_in_body(procedure, p.For):
        if loop.variable.lower() not in shared:
            known.setdefault(loop.variable.lower(), "number")
    return ChainMap(known, shared) if known else shared


@once_per_program
def _shared(program: Program) -> dict[str, str]:
    """Return the known types of the names that all procedures see."""
    known = {q.name.lower(): str(q.result) for q in program.procedures if q.result is not None}
    for table, kind in (
        (program.targets, "position"),
        (program.joint_targets, "joints"),
        (program.signals, "number"),
    ):
        known |= {n.lower(): kind for n in table}
    known |= {n.lower(): v.type for n, v in program.variables.items()}
    return known


def of_operation(operator: str, left: ValueType, right: ValueType) -> ValueType:
    """The type of what an operation gives; logic of numbers is that of their bits."""
    given = left, right
    whole = operator in ("div", "mod")
    if operator in e.RELATIONS:
        return "truth"
    for kind in _WIDEST:
        if kind in given and not (kind == "number" and (whole or operator in e.LOGICAL)):
            return kind
    if whole or (operator in e.LOGICAL and "truth" not in given):
        return "integer"
    return "number" if operator in ("/", "^") else left


_WIDEST: Final[tuple[ValueType, ...]] = ("position", "joints", "text", "number")


def is_value(x: e.Expression, known: KnownTypes) -> bool:
    """True if an expression surely is not a text."""
    match x:
        case e.Name(name):
            return known.get(name.lower(), "text") not in _TEXTS
        case e.Index(value):
            return is_value(value, known)
        case e.Member(_, field):
            return field in COMPONENTS
        case e.Unary() | e.Elapsed() | e.Here():
            return True
        case e.Binary("+", left, right):
            return is_value(left, known) and is_value(right, known)
        case e.Binary():
            return True
        case e.Apply(function):
            return (function in e.FUNCTIONS and function not in _TEXTS) or known.get(
                function.lower(), "text"
            ) not in _TEXTS
    return isinstance(x, _LITERALS)


def is_truth(x: e.Expression, known: KnownTypes) -> bool:
    match x:
        case e.Name(name) | e.Index(e.Name(name)):
            return known.get(name.lower()) == "truth"
        case e.Binary(operator):
            return operator in _TRUTHS
        case e.Unary("not") | e.Truth():
            return True
    return False


def is_number(x: e.Expression, known: KnownTypes) -> bool:
    match x:
        case e.Name(name):
            return known.get(name.lower()) in _NUMBERS
        case e.Index(value):
            return is_number(value, known)
        case e.Member(_, field):
            return field in COMPONENTS
        case e.Unary("-") | e.Number():
            return True
        case e.Binary(operator):
            return operator in _ARITHMETIC
    return False


def is_position(x: e.Expression, known: KnownTypes) -> bool:
    """True if an expression is a target, which has more than its pose."""
    match x:
        case e.Name(name) | e.Index(e.Name(name)):
            return known.get(name.lower()) == "position"
    return isinstance(x, e.TargetValue)


class Spelling:
    """Names in one procedure after another; those of the program before the first is entered.

    A name that is declared nowhere is spelled as it is given.
    """

    def __init__(self, program: Program) -> None:
        tables = (program.signals, program.joint_targets, program.targets, program.variables)
        self._shared = {name.lower(): name for table in tables for name in table}
        self._procedures = {q.name.lower(): q for q in program.procedures}
        self._timers = {name.lower(): name for name in timers(program)}
        self._signals = {name.lower(): signal for name, signal in program.signals.items()}
        self._own: dict[str, str] = {}

    def enter(self, procedure: Procedure) -> None:
        """Names mean from here on what they mean in the procedure."""
        loops = [node.variable for node in walk(procedure.body) if isinstance(node, p.For)]
        own = (*(q.name for q in procedure.parameters), *procedure.variables)
        self._own = {name.lower(): name for name in reversed((*own, *loops))}
        for name in loops:  # a loop over a variable of the program counts that one
            if name.lower() in self._shared and name.lower() not in {n.lower() for n in own}:
                self._own.pop(name.lower(), None)

    def name(self, name: str) -> str:
        """Return the declared spelling of a variable, target or signal."""
        return self._own.get(name.lower()) or self._shared.get(name.lower(), name)

    def timer(self, name: str) -> str:
        return self._timers.get(name.lower(), name)

    def procedure(self, name: str) -> Procedure | None:
        return self._procedures.get(name.lower())

    def signal(self, name: str) -> Signal | None:
        """Return the signal of a name, None for other names."""
        return None if name.lower() in self._own else self._signals.get(name.lower())

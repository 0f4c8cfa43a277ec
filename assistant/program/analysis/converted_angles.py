"""Values that hang on the unit of an angle: one language works them out in radian, another in
degrees.

The conversion rounds, so that such a value may be a little less in one language and a little more
in the other. A variable is of the kind of the worst value that it is given anywhere.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any, Final, Literal

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import base_variable
from assistant.program.program import Program, walk
from assistant.program.rewriting import head, records
from assistant.program.statement_index import records_in_procedures, statements_with

Hanging = Literal[0, 1, 2]
"""0: on no angle. 1: an angle that the program states, which is converted alike wherever it stands.
2: worked out with a converted angle.
"""
_OF_ANGLES: Final = frozenset(("sin", "cos", "tan", "asin", "acos", "atan", "atan2"))
_JOINTS: Final = frozenset(f"j{number}" for number in range(1, 9))
_WHOLE: Final = ("trunc", "floor")
"""Functions that cut a number off. `round` does not: the edges of it are the halves."""
_DONE: Final = frozenset((*_WHOLE, "round", "length", "code"))
"""Functions whose result is whole."""
_Place = tuple[str, str]
"""The procedure that owns a variable, empty for the program's, and its name: lower case. A result
of a function has no name."""


def doubtful_angles(program: Program) -> Iterator[tuple[p.Statement, str]]:
    """Yield the statements in which a converted angle meets an edge: one of `EDGES`."""
    said = records_in_procedures(program, e.Binary, e.Apply, e.Member)
    if not any(map(_is_angle, itertools.chain(said, records(program.variables)))):
        return
    hanging = _HangingOnAngles(program)
    for procedure in program.procedures:
        owner = procedure.name.lower()
        for statement, parts in statements_with(procedure, e.Binary, e.Apply, e.Member, e.Name):
            found = (hanging.edge(part, owner) for part in (statement, *parts))
            yield from ((statement, edge) for edge in dict.fromkeys(filter(None, found)))


EDGES: Final = {
    "=": "is compared with a value that it is to equal",
    "whole": "is cut off to a whole number",
    "switch": "chooses among cases",
    "count": "bounds a counted loop",
}


def _is_angle(part: Any) -> bool:
    match part:
        case e.Binary("*" | "/", _, e.Number(e.DEGREE)):
            return True
        case e.Apply(function):
            return function in _OF_ANGLES
        case e.Member(field=component):
            return component in e.ANGLES or component in _JOINTS
    return False


class _HangingOnAngles:
    """How much the variables and values of a program hang on converted angles."""

    def __init__(self, program: Program) -> None:
        self._procedures = {q.name.lower(): q for q in program.procedures}
        self._own = {
            q.name.lower(): {one.name.lower() for one in q.parameters}
            | {name.lower() for name in q.variables}
            for q in program.procedures
        }
        self._found: dict[_Place, Hanging] = {}
        given = [
            (("", name.lower()), "", one.initial)
            for name, one in program.variables.items()
            if one.initial is not None
        ]
        for procedure in program.procedures:
            owner = procedure.name.lower()
            given += [
                ((owner, name.lower()), owner, one.initial)
                for name, one in procedure.variables.items()
                if one.initial is not None
            ]
            for statement in walk(procedure.body):
                given += self._given(statement, owner)
        # Values only get worse, so this ends.
        changed = True
        while changed:
            changed = False
            for place, owner, value in given:
                now = self.of(value, owner)
                if now > self._found.get(place, 0):
                    self._found[place] = now
                    changed = True

    def _given(
        self, statement: p.Statement, owner: str
    ) -> Iterator[tuple[_Place, str, e.Expression]]:
        """Yield what a statement gives a variable: where, the procedure of the value, the value."""
        match statement:
            # To set an angle of a position changes nothing else of it.
            case p.Assign(target, value) if not _is_angle(target):
                yield self._place(base_variable(target), owner), owner, value
            case p.Return(value) if value is not None:
                yield (owner, ""), owner, value
            case p.For(name, first, _, _, step):
                for value in (first, step):
                    if value is not None:
                        yield self._place(name.lower(), owner), owner, value
        for part in records(head(statement)):
            match part:
                case p.Call(name, arguments) | e.Apply(name, arguments):
                    callee = self._procedures.get(name.lower())
                    if callee is None:
                        continue
                    pairs = zip(callee.parameters, arguments, strict=False)
                    for parameter, value in pairs:
                        place = callee.name.lower(), parameter.name.lower()
                        yield place, owner, value
                        if parameter.mode == "inout" and (whole := base_variable(value)):
                            back = self._place(whole, owner)
                            yield back, place[0], e.Name(parameter.name)

    def _place(self, name: str, owner: str) -> _Place:
        return (owner if name in self._own.get(owner, ()) else "", name)

    def edge(self, part: Any, owner: str) -> str | None:
        """Return the edge that a value meets in a part of a statement, None for none."""
        match part:
            case e.Binary("=" | "<>", left, right) if self._apart(left, right, owner):
                return "="
            case e.Apply(function, (value, *_)) if function in _WHOLE:
                return "whole" if self.of(value, owner) == 2 else None
            case e.Binary("div" | "mod", left, right):
                kinds = self.of(left, owner), self.of(right, owner)
                return "whole" if 2 in kinds else None
            case p.Switch(subject, cases):
                values = itertools.chain.from_iterable(case.values for case in cases)
                if any(self._apart(subject, value, owner) for value in values):
                    return "switch"
            case p.For(_, first, last, _, step):
                bounds = (first, last, *(() if step is None else (step,)))
                return "count" if any(self.of(one, owner) == 2 for one in bounds) else None
        return None

    def _apart(self, left: e.Expression, right: e.Expression, owner: str) -> bool:
        """True if two values that are equal in one language may be unequal in another."""
        kinds = {self.of(left, owner), self.of(right, owner)}
        # A stated angle is like another stated one, and never 0.
        return 2 in kinds or (kinds == {0, 1} and e.Number(0) not in (left, right))

    def of(self, value: e.Expression, owner: str) -> Hanging:
        match value:
            case e.Name(name):
                return self._found.get(self._place(name.lower(), owner), 0)
            case e.Binary("*", inner, e.Number(e.DEGREE)) if e.plain_number(inner) is not None:
                return 1 if e.plain_number(inner) else 0
            case e.Member() | e.Binary() | e.Apply() if _is_angle(value):
                return 2
            case e.Apply(function) if function in _DONE:
                return 0
            case e.Apply(function) if function.lower() in self._procedures:
                return self._found.get((function.lower(), ""), 0)
            case e.Binary(operator) if operator in (*e.RELATIONS, *e.LOGICAL, "div", "mod"):
                return 0
            case e.Binary(_, left, right):
                return 2 if max(self.of(left, owner), self.of(right, owner)) else 0
            case e.Apply(_, arguments) | e.Aggregate(arguments):
                return max((self.of(one, owner) for one in arguments), default=0)
            case e.Unary(_, inner) | e.Member(inner) | e.Index(inner):
                return self.of(inner, owner)
        return 0

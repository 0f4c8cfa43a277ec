"""Whole numbers in variables, for a language whose numbers are of one type."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.contents import records_in_body
from assistant.program.program import Procedure, Program, Variable
from assistant.program.rewriting import head, map_bodies, records
from assistant.program.wholes import NumberFacts


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
        """Whether a call gives a parameter by value what may be no whole number."""
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

"""Outputs that are given a value that the program works out, as the pseudo-program means it.

Any number but 0 is 1 in a digital signal, and what a group cannot hold stops the program. For a
language that writes of a number the bits that there is room for.
"""

from __future__ import annotations

import itertools
from collections import ChainMap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.signals import read_by_another_name
from assistant.program.passes.endings import FOR_GOOD
from assistant.program.passes.legalising import Legalisation
from assistant.program.program import Procedure, Program, Signal, ValueType, Variable
from assistant.program.rewriting import Body, map_bodies

_TRUTHS: Final = (*e.RELATIONS, "and", "or")
ZERO: Final = e.Number(0)


def with_checked_outputs(job: Legalisation) -> Program:
    """The program with a choice of 0 and 1, or a stop behind a group's range, before each.

    One that a language of the same kin said stays as it is.
    """
    program, origin = job.program, job.program.origin
    if origin is not None and origin.language in job.can.kin:
        return program
    taken = {n.lower() for t in (program.variables, program.targets, program.signals) for n in t}
    taken |= {name.lower() for q in program.procedures for name in q.variables}
    shared = _SharedNames.of(program)
    return replace(
        program,
        procedures=tuple(_OutputChecks(shared, q, taken).checked() for q in program.procedures),
    )


def find_outputs_of_two_names(job: Legalisation) -> None:
    """Errors where what is read has another name where it is set, for signals known by names."""
    for statement, name, other in read_by_another_name(job.program):
        with job.findings.at(statement.span):
            job.cannot(
                f"that `{name}` is read, which is set as part of `{other}`",
                "read and set the output by one name, or keep its value in a variable",
            )


@dataclass(frozen=True, slots=True)
class _SharedNames:
    """Of a program, by names in lower case: signals, types of variables and of results."""

    signals: Mapping[str, Signal]
    kinds: dict[str, ValueType]
    results: Mapping[str, ValueType | None]

    @staticmethod
    def of(program: Program) -> _SharedNames:
        return _SharedNames(
            {name.lower(): signal for name, signal in program.signals.items()},
            {name.lower(): v.type for name, v in program.variables.items()},
            {q.name.lower(): q.result for q in program.procedures},
        )


class _OutputChecks:
    """One procedure. taken: names in lower case that a variable may not have."""

    def __init__(self, shared: _SharedNames, procedure: Procedure, taken: set[str]) -> None:
        self.procedure, self.taken = procedure, taken
        self.signals, self.results = shared.signals, shared.results
        own = {q.name.lower(): q.type for q in procedure.parameters}
        own |= {name.lower(): v.type for name, v in procedure.variables.items()}
        self.kinds = ChainMap(own, shared.kinds)
        self.kept: dict[str, Variable] = {}

    def checked(self) -> Procedure:
        body = self.body(self.procedure.body)
        if body == self.procedure.body:
            return self.procedure
        variables = {**self.procedure.variables, **self.kept}
        return replace(self.procedure, body=body, variables=variables)

    def body(self, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            node = map_bodies(node, self.body)
            parts = self.set(node, made) if isinstance(node, p.SetSignal) else (node,)
            made += (x if x.span else replace(x, span=node.span) for x in parts)
        return tuple(made)

    def set(self, node: p.SetSignal, above: list[p.Statement]) -> Iterator[p.Statement]:
        signal = self.signals.get(node.signal.lower())
        if signal is None or signal.kind == "analog" or self.fits(node.value, signal):
            yield node
        elif signal.kind == "digital":
            one, zero = (replace(node, value=e.Number(n)) for n in (1, 0))
            is_set = p.Branch(e.Binary("<>", node.value, ZERO), (one,))
            yield p.If((is_set,), (zero,))
        else:
            value = node.value
            if not isinstance(value, e.Name):
                value = self.keep()
                yield p.Assign(value, node.value)
            most = e.Number((1 << signal.bits) - 1)
            outside = e.Binary("or", e.Binary("<", value, ZERO), e.Binary(">", value, most))
            if not (above and _is_guarded(above[-1], outside)):
                yield p.If((p.Branch(outside, (FOR_GOOD,)),))
            yield replace(node, value=value)

    def fits(self, value: e.Expression, signal: Signal) -> bool:
        """Whether it is known to be a truth, or what as many bits can hold; or is no number."""
        match value:
            case e.Number() | e.Truth() | e.Verbatim() | e.Unary("not"):
                return True
            case e.Binary(operator):
                return operator in _TRUTHS
            case e.Apply(name):
                return self.results.get(name.lower()) == "truth"
            case e.Name(name) if name.lower() not in self.kinds:
                other = self.signals.get(name.lower())
                return other is not None and other.kind != "analog" and other.bits <= signal.bits
            case e.Name(name):
                return self.kinds[name.lower()] == "truth"
        return False

    def keep(self) -> e.Name:
        """A variable of the procedure's own that a value is kept in while it is looked at."""
        if not self.kept:
            free = (f"out_{n}" for n in itertools.count(1))
            name = next(n for n in free if n not in self.taken)
            self.taken.add(name)
            self.kept[name] = Variable("number")
        return e.Name(next(iter(self.kept)))


def _is_guarded(node: p.Statement, outside: e.Expression) -> bool:
    """Whether a statement leaves the program where a condition holds: it is checked already."""
    match node:
        case p.If((p.Branch(condition, (stop,)),), ()):
            return condition == outside and stop == FOR_GOOD
    return False

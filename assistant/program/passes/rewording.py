"""Statements one after the other, each as a language says it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any, ClassVar

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.kinds import KnownTypes, known_types
from assistant.program.analysis.spelling import Spelling
from assistant.program.passes.legalising import Legalisation
from assistant.program.program import Procedure, Variable
from assistant.program.rewriting import Body, map_bodies, map_expressions, map_head

Changes = Mapping[type, Callable[[Any, Any], Iterable[p.Statement]]]


class Rewording:
    """Findings stand at the statements that they are about, and so does what is made of these.

    changes: by kind of a statement what is made of one, given this object and the statement. Its
    expressions are said by then; the bodies that it holds are the change's own business.
    spelling, known: of names in the procedure at hand. choices: how many `switch` are around the
    place.
    """

    changes: ClassVar[Changes] = {}

    def __init__(self, job: Legalisation) -> None:
        self.job, self.spelling = job, Spelling(job.program)
        self.known: KnownTypes = {}
        self.choices = 0

    def enter(self, procedure: Procedure) -> None:
        """What follows stands in a procedure."""
        self.spelling.enter(procedure)
        self.known = known_types(self.job.program, procedure)

    def procedure(self, procedure: Procedure) -> Procedure:
        """A procedure with its variables and statements as the language says them."""
        self.enter(procedure)
        owner = procedure.name
        variables = {n: self.variable(v, n, owner) for n, v in procedure.variables.items()}
        return replace(procedure, body=self.body(procedure.body), variables=variables)

    def variable(self, variable: Variable, name: str, owner: str = "") -> Variable:  # noqa: ARG002
        """A variable as the language declares it. owner: the procedure whose own it is, or none."""
        return replace(variable, initial=map_expressions(variable.initial, self.expression))

    def expression(self, x: e.Expression) -> e.Expression:
        """An expression as the language says it; what is in it is said already."""
        return x

    def whole(self, node: p.Statement) -> p.Statement:
        """A statement whose expressions are said, with what depends on more than one of them."""
        return node

    def body(self, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            with self.job.findings.at(node.span):
                parts = self.statement(node)
                made += (x if x.span else replace(x, span=node.span) for x in parts)
        return tuple(made)

    def statement(self, node: p.Statement) -> Iterable[p.Statement]:
        node = self.whole(map_head(node, self.expression))
        change = self.changes.get(type(node))
        return (self.inside(node),) if change is None else change(self, node)

    def inside(self, node: p.Statement) -> p.Statement:
        """A statement with the bodies that it holds as the language says them."""
        said: p.Statement = map_bodies(node, self.body)
        return said

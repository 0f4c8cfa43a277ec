"""Conditions that no step holds, worked out in several steps before what asks or gives them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Final, Literal, Protocol

from assistant.languages.melfa_basic.lower.expressions import Expressions, Unsayable
from assistant.languages.melfa_basic.lower.names import naming
from assistant.languages.melfa_basic.tables.dialects import LAST_STEP, Dialect
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure, Program, TakenNames, Variable, identifier
from assistant.program.rewriting import Body, map_bodies, records

if TYPE_CHECKING:
    from assistant.robots import Robot

VARIABLE_ROOM: Final = 30
"""Bytes of a step that are left for the variable which the parts of a condition go to."""

FEW_RECORDS: Final = 6
"""Records of a condition, its names and numbers among them: of two comparisons there are 7."""


def with_short_conditions(
    program: Program, dialect: Dialect, robot: Robot | None, *, products: bool
) -> Program:
    """The program with a variable for each condition that is too long for a step.

    All parts are worked out in their order, as the one step would do it.
    """
    if not dialect.blocks or not any(map(_may_be_long, program.statements())):
        return program
    names = naming(program, dialect, products)
    said = Expressions(program, dialect, names, robot, lambda: names.position)
    taken = TakenNames((program.name, *program.variables, *program.signals, *program.targets))
    taken.update((*program.joint_targets, *program.tools, *program.frames))
    for q in program.procedures:
        taken.update((q.name, *q.variables, *(one.name for one in q.parameters)))
    most = dialect.line - len(f"{LAST_STEP} ")

    def fits(value: e.Expression, target: e.Name | None = None, /) -> bool:
        try:
            step: s.Statement = s.If(said.of(value), None)
            room = VARIABLE_ROOM
            if target is not None:
                step, room = s.Assign(said.place(target), said.of(value)), 0
        except Unsayable:
            return True  # which is told where it is written
        return len(printer.line(s.Line(statement=step), dialect.upper).encode()) + room <= most

    procedures = []
    for procedure in program.procedures:
        said.procedure = procedure
        procedures.append(_ConditionShortening(procedure, fits, taken).procedure())
    same = all(a is b for a, b in zip(procedures, program.procedures, strict=True))
    return program if same else replace(program, procedures=tuple(procedures))


def _may_be_long(node: p.Statement) -> bool:
    """Whether a statement asks so much that it is worth a look at its length."""
    match node:
        case p.If((p.Branch(asked), *_)) | p.Return(asked) | p.Assign(_, asked):
            return isinstance(asked, e.Binary) and sum(1 for _ in records(asked)) > FEW_RECORDS
    return False


class FitsStep(Protocol):
    """True if a condition fits into a step: as that of an `If`, or assigned to a variable."""

    def __call__(self, value: e.Expression, target: e.Name | None = None, /) -> bool: ...


class _ConditionShortening:
    """One procedure. taken: names, with those made here."""

    def __init__(self, owner: Procedure, fits: FitsStep, taken: TakenNames) -> None:
        self.owner, self.fits, self.taken = owner, fits, taken
        self.new: dict[str, Variable] = {}

    def procedure(self) -> Procedure:
        body = self.body(self.owner.body)
        if not self.new:
            return self.owner
        return replace(self.owner, body=body, variables={**self.owner.variables, **self.new})

    def body(self, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            inner = map_bodies(node, self.body)
            match inner:
                case p.If((first, *others)):
                    asked = self.asked(first.condition, inner, made)
                    if asked is not None:
                        branches = (replace(first, condition=asked), *others)
                        inner = replace(inner, branches=branches)
                case p.Assign(e.Name() as target, value) if self.fits(value, target):
                    pass
                case p.Return(e.Binary() as value) | p.Assign(_, e.Binary() as value):
                    asked = self.asked(value, inner, made)
                    inner = inner if asked is None else replace(inner, value=asked)
            made.append(inner)
        return tuple(made)

    def asked(
        self, whole: e.Expression, node: p.Statement, made: list[p.Statement]
    ) -> e.Expression | None:
        """The variable that is asked instead of what is too long; None where nothing is to do."""
        match whole:
            case e.Binary("and" | "or" as word) if not self.fits(whole):
                parts = [*_chain_operands(whole, word)]
            case _:
                return None
        if not all(map(self.fits, parts)):
            return None
        name = identifier("condition", self.taken)
        self.taken.add(name)
        self.new[name] = Variable("truth")
        before: e.Expression | None = None
        value, *left = parts
        for part in left:
            longer = e.Binary(word, value, part)
            if self.fits(longer):
                value = longer
                continue
            made.append(p.Assign(e.Name(name), _joined_chain(word, before, value), span=node.span))
            before, value = e.Name(name), part
        made.append(p.Assign(e.Name(name), _joined_chain(word, before, value), span=node.span))
        return e.Name(name)


def _joined_chain(
    word: Literal["and", "or"], before: e.Expression | None, value: e.Expression
) -> e.Expression:
    """A chain of one operator behind what it goes on from."""
    match value:
        case _ if before is None:
            return value
        case e.Binary(operator, left, right) if operator == word:
            return e.Binary(word, _joined_chain(word, before, left), right)
    return e.Binary(word, before, value)


def _chain_operands(value: e.Expression, word: str) -> Iterator[e.Expression]:
    """What one operator joins, in its order."""
    match value:
        case e.Binary(operator, left, right) if operator == word:
            yield from _chain_operands(left, word)
            yield right
        case _:
            yield value

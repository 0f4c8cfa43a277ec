"""Procedures, calls, texts and sums that are too long for a line.

The parameters of a procedure whose head or call is too long become variables of the program, as in
a language without parameters; arrays remain parameters. What is added from left to right may be
added in as many lines, and what is sent over a channel piece by piece.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.expressions import unknown_effect
from assistant.program.passes.legalisation import Legalisation
from assistant.program.passes.procedure_forms import recursive_procedures
from assistant.program.program import (
    Procedure,
    Program,
    TakenNames,
    ValueType,
    Variable,
    identifier,
)
from assistant.program.rewriting import Body, map_bodies, records
from assistant.program.statement_index import records_in_body

HEAD: Final = 24
"""Characters of the words around the parameters, and around a call."""
_DECLARED: Final = 10
"""Characters of the words around the name of one parameter."""


@dataclass(frozen=True, slots=True)
class LineWidths:
    """About how many characters something takes. most: of a line. names: of a name at most."""

    most: int
    names: int

    def of(self, value: e.Expression) -> int:
        return 1 + sum(map(self._of, records(value)))

    def _of(self, part: Any) -> int:
        match part:
            case e.Name(name) | e.Apply(name):
                return min(len(name), self.names) + 3
            case e.Text(text):
                return len(text) + 2
            case e.Number(number):
                return len(f"{number:g}")
            case e.Binary() | e.Unary() | e.Index():
                return 4
            case e.Member():
                return 8  # an angle stands in a function that turns it into degrees
        return 6

    def head(self, procedure: Procedure) -> int:
        names = (min(len(q.name), self.names) + _DECLARED for q in procedure.parameters)
        return HEAD + self.names + sum(names)

    def call(self, arguments: tuple[e.Expression, ...]) -> int:
        return HEAD + self.names + sum(map(self.of, arguments))


def procedures_too_long(program: Program, widths: LineWidths) -> frozenset[str]:
    """Return lower-case names of the procedures whose head, or a call of which, is longer than a
    line.

    Procedures that call themselves, that take only arrays, or whose parameters vendor texts name
    are not included.
    """
    known = {q.name.lower(): q for q in program.procedures if q.parameters}
    found = {name for name, q in known.items() if widths.head(q) > widths.most}
    for procedure in program.procedures if known else ():
        for part in records_in_body(procedure, p.Call, e.Apply):
            match part:
                case p.Call(name, arguments) | e.Apply(name, arguments):
                    key = name.lower()
                    if key in known and key not in found and widths.call(arguments) > widths.most:
                        found.add(key)
    # As variables, parameters would exist once for all calls of a recursive procedure.
    if found:
        found -= {q.name.lower() for q in recursive_procedures(program)}
    return frozenset(name for name in found if _has_free_parameters(known[name]))


def _has_free_parameters(procedure: Procedure) -> bool:
    """True if its parameters may become variables."""
    own = {q.name.lower() for q in procedure.parameters}
    plain = not all(q.dimensions for q in procedure.parameters)
    return plain and own.isdisjoint(_names_in_vendor_text(procedure))


def _names_in_vendor_text(procedure: Procedure) -> Iterator[str]:
    """Yield names in lower case that vendor texts of a procedure mention."""
    for part in records(procedure.body):
        if isinstance(part, p.Opaque | e.Verbatim):
            effect = unknown_effect(part.text) if part.effect is None else part.effect
            yield from effect.names


_TEXTS: Final = ("text", "part", "fixed", "character")
"""Functions that give a text, beside those of the program's own."""
_KINDS: Final[tuple[ValueType, ...]] = ("text", "number")


def with_short_sums(job: Legalisation) -> Program:
    """The program with several statements for those that are longer than a line."""
    can, program = job.can.procedures, job.program
    widths = None if can is None else LineWidths(can.longest, can.longest_name)
    if widths is None or not any(_is_too_long(node, widths) for node in program.statements()):
        return program
    taken = TakenNames((program.name, *program.variables, *program.signals, *program.targets))
    for q in program.procedures:
        taken.update((q.name, *q.variables, *(one.name for one in q.parameters)))
    procedures = tuple(
        _SumSplitter(program, q, widths, taken).procedure() for q in program.procedures
    )
    return replace(program, procedures=procedures)


def _is_too_long(node: p.Statement, widths: LineWidths) -> bool:
    match node:
        case p.Assign(target, e.Binary("+") as value):
            return widths.of(target) + widths.of(value) > widths.most
        case p.Send(parts=parts):
            return sum(map(widths.of, parts)) > widths.most
    return False


class _SumSplitter:
    """One procedure. taken: names of the program, with those that are made."""

    def __init__(
        self, program: Program, owner: Procedure, widths: LineWidths, taken: TakenNames
    ) -> None:
        self.program, self.owner, self.widths, self.taken = program, owner, widths, taken
        self.own = {q.name.lower(): q for q in program.procedures}
        self.new: dict[str, Variable] = {}

    def procedure(self) -> Procedure:
        body = self.body(self.owner.body)
        return replace(self.owner, body=body, variables={**self.owner.variables, **self.new})

    def body(self, body: Body) -> Body:
        return tuple(made for node in body for made in self.parted(node))

    def parted(self, node: p.Statement) -> Iterator[p.Statement]:
        if not _is_too_long(node, self.widths):
            yield map_bodies(node, self.body)
            return
        match node:
            case p.Send(parts=parts):
                yield from self.sent(node, [one for part in parts for one in self.pieces(part)])
            case p.Assign(target, value):
                yield from self.assigned(node, target, self.added(value))

    def sent(self, node: p.Send, parts: Sequence[e.Expression]) -> Iterator[p.Statement]:
        """Pieces, of which only the last one ends a line if they did together."""
        groups = [*self.groups(parts, 0)]
        for group in groups[:-1]:
            yield replace(node, kind="piece", parts=tuple(group))
        yield replace(node, parts=tuple(groups[-1]))

    def pieces(self, part: e.Expression) -> Iterator[e.Expression]:
        parts = self.added(part)
        yield from parts if any(map(self.is_text, parts)) else (part,)

    def added(self, value: e.Expression) -> list[e.Expression]:
        """Return the terms of a sum, from left to right; for texts also those in brackets."""
        parts = list(_summands(value))
        # Texts may be added in any grouping; sums of numbers would round otherwise.
        while any(map(self.is_text, parts)) and any(map(_is_sum, parts)):
            parts = [inner for part in parts for inner in _summands(part)]
        return parts

    def assigned(
        self, node: p.Assign, target: e.Expression, parts: Sequence[e.Expression]
    ) -> Iterator[p.Statement]:
        # The target appears twice in each line after the first.
        groups = [*self.groups(parts, self.widths.of(target) * 2)]
        later = [record for group in groups[1:] for part in group for record in records(part)]
        into = target if isinstance(target, e.Name) else None
        # The target is read by a later part: its value must not change before the end.
        if into is None or any(self.touches(record, into) for record in later):
            into = self.kept(parts)
        if len(groups) < 2 or into is None:
            yield node
            return
        before: e.Expression | None = None
        for group in groups:
            for part in group:
                before = part if before is None else e.Binary("+", before, part)
            assert before is not None
            yield replace(node, target=into, value=before)
            before = into
        if into != target:
            yield replace(node, value=into)

    def groups(self, parts: Sequence[e.Expression], beside: int) -> Iterator[list[e.Expression]]:
        """Yield parts that fit in one line together. beside: characters of the rest of the line."""
        group: list[e.Expression] = []
        size = beside
        for part in parts:
            if group and size + self.widths.of(part) > self.widths.most:
                yield group
                group, size = [], beside
            group.append(part)
            size += self.widths.of(part)
        yield group

    def touches(self, record: object, target: e.Name) -> bool:
        """True if a part may read the variable that collects the value."""
        match record:
            case e.Name(name):
                return name.lower() == target.name.lower()
            case e.Apply(function):
                return function.lower() in self.own
        return isinstance(record, e.Verbatim)

    def kept(self, parts: Sequence[e.Expression]) -> e.Name | None:
        """A variable to put a value together in; None for one whose type is not sure."""
        kinds = set(map(self.kind, parts))
        for kind in _KINDS:
            if kind in kinds:
                name = identifier("together", self.taken)
                self.taken.add(name)
                self.new[name] = Variable(kind)
                return e.Name(name)
        return None

    def is_text(self, part: e.Expression) -> bool:
        return self.kind(part) == "text"

    def kind(self, part: e.Expression) -> str:
        """Return the type of a part if the part alone shows it, else an empty text."""
        match part:
            case e.Text():
                return "text"
            case e.Number():
                return "number"
            case e.Apply(function):
                own = self.own.get(function.lower())
                if own is not None:
                    return own.result or ""
                return "text" if function.lower() in _TEXTS else ""
        return ""


def _is_sum(part: e.Expression) -> bool:
    return isinstance(part, e.Binary) and part.operator == "+"


def _summands(value: e.Expression) -> Iterator[e.Expression]:
    """Yield the terms of a sum, from left to right."""
    match value:
        case e.Binary("+", left, right):
            yield from _summands(left)
            yield right
        case _:
            yield value

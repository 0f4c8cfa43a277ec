"""Procedures of so many parameters that no line holds their head, or a call of them.

Their parameters become variables of the program, as in a language without parameters; arrays
remain parameters.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.contents import records_in_body
from assistant.program.effects import unknown_effect
from assistant.program.passes.procedures import recursive_procedures
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import records

HEAD: Final = 24
"""Of the words around the parameters, and those that a call stands in."""
DECLARED: Final = 10
"""Of the words around the name of one parameter."""


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
        names = (min(len(q.name), self.names) + DECLARED for q in procedure.parameters)
        return HEAD + self.names + sum(names)

    def call(self, arguments: tuple[e.Expression, ...]) -> int:
        return HEAD + self.names + sum(map(self.of, arguments))


def procedures_too_long(program: Program, widths: LineWidths) -> frozenset[str]:
    """Lower-case names of the procedures whose head, or a call of which, no line holds.

    Without those that call themselves, that take arrays alone, or whose parameters kept texts name.
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
    if found:
        found -= {q.name.lower() for q in recursive_procedures(program)}
    return frozenset(name for name in found if _has_free_parameters(known[name]))


def _has_free_parameters(procedure: Procedure) -> bool:
    """Whether its parameters may be other variables."""
    own = {q.name.lower() for q in procedure.parameters}
    plain = not all(q.dimensions for q in procedure.parameters)
    return plain and own.isdisjoint(_names_in_vendor_text(procedure))


def _names_in_vendor_text(procedure: Procedure) -> Iterator[str]:
    """Names in lower case that kept texts of a procedure speak of."""
    for part in records(procedure.body):
        if isinstance(part, p.Opaque | e.Verbatim):
            effect = unknown_effect(part.text) if part.effect is None else part.effect
            yield from effect.names

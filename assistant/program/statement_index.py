"""Index of the bodies of procedures by kind of record, made once for all passes and rules.

Most passes and rules are about a few kinds of statements or expressions that most programs do not
have. Here they learn that at once, and where those are, without a walk through the program.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from typing import Any, TypeVar
from weakref import ReferenceType, ref

from assistant.program.expressions import Name, Verbatim
from assistant.program.program import Procedure, Program, walk
from assistant.program.rewriting import head, records
from assistant.program.statements import Opaque, Statement
from assistant.program.vendor_statements import effect_of

T = TypeVar("T")


class _StatementIndex:
    """Records of a body, in order of the text.

    heads: each statement with its records outside its inner bodies; the statement itself first.
    places: by the kind of a record, the numbers of heads that contain one.
    """

    __slots__ = ("heads", "places")

    def __init__(self, body: tuple[Statement, ...]) -> None:
        self.heads: list[tuple[Statement, tuple[Any, ...]]] = []
        self.places: dict[type, list[int]] = {}
        places = self.places
        for at, statement in enumerate(walk(body)):
            said = tuple(records(head(statement)))
            self.heads.append((statement, said))
            for kind in set(map(type, said)):
                places.setdefault(kind, []).append(at)

    def at(self, kinds: tuple[type, ...]) -> Iterable[int]:
        """Numbers of the heads that have records of the kinds."""
        found = [self.places[kind] for kind in kinds if kind in self.places]
        return sorted({at for some in found for at in some}) if len(found) > 1 else chain(*found)


def _statement_index(procedure: Procedure) -> _StatementIndex:
    """Return the index of a procedure's body, computed at the first request."""
    if not procedure.known:
        procedure.known.append(_StatementIndex(procedure.body))
    found: _StatementIndex = procedure.known[0]
    return found


def once_per_program(work: Callable[[Program], T]) -> Callable[[Program], T]:
    """Cache the result of `work` for the last program."""
    last: list[tuple[ReferenceType[Program], T]] = []

    def remembered(program: Program) -> T:
        for asked, found in last:
            if asked() is program:
                return found
        found = work(program)
        last[:] = [(ref(program), found)]
        return found

    return remembered


def statements_with(
    where: Program | Procedure, *kinds: type[T]
) -> Iterator[tuple[Statement, list[T]]]:
    """Statements whose heads have records of the kinds, in order of the text, with those.

    kinds: as they are, not what they are derived from.
    """
    for procedure in where.procedures if isinstance(where, Program) else (where,):
        known = _statement_index(procedure)
        for at in known.at(kinds):
            statement, said = known.heads[at]
            yield statement, [part for part in said if type(part) in kinds]


def statements_with_vendor_text(
    where: Program | Procedure,
) -> Iterator[tuple[Statement, list[Opaque | Verbatim]]]:
    """Statements that keep text of a vendor's language, in order of the text, with all of it."""
    for statement, said in statements_with(where, Opaque, Verbatim):
        yield statement, [part for part in said if isinstance(part, Opaque | Verbatim)]


def records_in_body(procedure: Procedure, *kinds: type[T]) -> Iterator[T]:
    """Records of the kinds in the body of a procedure, in order of the text.

    Statements are as they stand, branches and cases have no bodies. kinds: see `saying`.
    """
    for statement, said in statements_with(procedure, *kinds):
        for part in said:
            yield statement if isinstance(statement, type(part)) else part


def records_in_procedures(program: Program, *kinds: type[T]) -> Iterator[T]:
    """Records of the kinds in the procedures of a program: their bodies, and their own data.

    kinds: see `saying`.
    """
    for procedure in program.procedures:
        yield from records_in_body(procedure, *kinds)
        for part in records(procedure.variables) if procedure.variables else ():
            if type(part) in kinds:
                yield part


def names_in_procedures(program: Program) -> Iterator[str]:
    """Yield every name in the procedures of a program; those of vendor texts in lower case."""
    for part in records_in_procedures(program, Name, Opaque, Verbatim):
        if isinstance(part, Name):
            yield part.name
        elif isinstance(part, Opaque | Verbatim):
            yield from sorted(effect_of(part).names)


def has_record(program: Program, *kinds: type) -> bool:
    """True if a record of one of the kinds is anywhere in the procedures of a program."""
    return any(True for _ in records_in_procedures(program, *kinds))

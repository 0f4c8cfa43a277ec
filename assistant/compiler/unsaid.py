"""What a translation does not say although nothing is wrong with it.

That is what stands in statements or procedures that are not said, and calls of procedures that are
not said, or not in full.
"""

from __future__ import annotations

from collections.abc import Iterator, Set

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import along_calls
from assistant.program.diagnostics import Diagnostic, Span, error, warning
from assistant.program.program import Program, bodies, walk
from assistant.program.rewriting import head, records

STANDS_IN = error("CO013", "it stands in something that is not said", "see to that first")
NOT_IN_FULL = warning(
    "CO014",
    "`{name}` is called, and not all that it does is said",
    "see to its statements; the call itself is said",
)
CALLS_NOTHING = error(
    "CO015", "`{name}` is called, which is not said", "see to that procedure first"
)


def unsaid(program: Program, wrong: Set[Span | None]) -> Iterator[tuple[Span, Diagnostic]]:
    """Statements of a program that cross less than they seem to, and why.

    wrong: the spans of what is not said.
    """
    if not wrong:
        return
    inside = _inside(program, wrong)
    yield from ((span, STANDS_IN(span=span)) for span in inside if span not in wrong)
    named = {q.name.lower(): q for q in program.procedures}
    gone = {key for key, q in named.items() if q.span in wrong}
    lacking = {
        key: frozenset({key} if any(one.span in wrong for one in (q, *walk(q.body))) else ())
        for key, q in named.items()
    }
    lacks = along_calls(program, lacking)
    for procedure in program.procedures:
        for statement in walk(procedure.body):
            span = statement.span
            if span is None or span in wrong or span in inside:
                continue
            for name in dict.fromkeys(_called(statement)):
                if lacks.get(name):
                    rule = CALLS_NOTHING if name in gone else NOT_IN_FULL
                    yield span, rule(span=span, name=named[name].name)


def _inside(program: Program, wrong: Set[Span | None]) -> dict[Span, None]:
    """What stands in statements and procedures that are not said."""
    found: dict[Span, None] = {}
    for procedure in program.procedures:
        whole = procedure.span in wrong
        for statement in walk(procedure.body):
            if whole and statement.span is not None:
                found[statement.span] = None
            elif statement.span in wrong:
                inner = (one for body in bodies(statement) for one in walk(body))
                found |= {one.span: None for one in inner if one.span is not None}
    return found


def _called(statement: p.Statement) -> Iterator[str]:
    """The procedures and functions that a statement itself calls, in lower case."""
    for part in records(head(statement)):
        match part:
            case p.Call(procedure=name) | e.Apply(function=name):
                yield name.lower()

"""What a translation does not say although nothing is wrong with it.

That is what stands in statements or procedures that are not said, and calls of procedures that are
not said, or not in full.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set

from assistant.base.diagnostics import Diagnostic, Severity, Span, error, has_errors, warning
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import along_calls
from assistant.program.program import Program, bodies, walk
from assistant.program.rewriting import head, records

CALLS_PARTLY_TRANSLATED = warning(
    "CO013",
    "`{name}` is called, and not all that it does is said",
    "see to its statements; the call itself is said",
)
CALLS_NOT_TRANSLATED = error(
    "CO014", "`{name}` is called, which is not said", "see to that procedure first"
)


def add_losses(program: Program, found: Mapping[Span, list[Diagnostic]]) -> None:
    """Adds to what is found about the parts of a program, by their spans, what they lose by others.

    What stands in what is not said is not said for the same reasons; calls of it are told of.
    """
    wrong: set[Span | None] = {span for span, told in found.items() if has_errors(told)}
    if not wrong:
        return
    for span, holder in _losses_inside(program, wrong).items():
        if span in found and span not in wrong:
            found[span].extend(f for f in found[holder] if f.severity is Severity.ERROR)
            wrong.add(span)
    for span, finding in _losses_by_calls(program, wrong):
        if span in found:
            found[span].append(finding)


def _losses_inside(program: Program, wrong: Set[Span | None]) -> dict[Span, Span]:
    """What stands in procedures and statements that are not said, each with the one it stands in.

    wrong: the spans of what is not said.
    """
    found: dict[Span, Span] = {}
    for procedure in program.procedures:
        whole = procedure.span if procedure.span in wrong else None
        for statement in walk(procedure.body):
            span = statement.span
            if span is not None and whole is not None:
                found.setdefault(span, whole)
            elif span is not None and span in wrong:
                for inner in (one for body in bodies(statement) for one in walk(body)):
                    if inner.span is not None:
                        found.setdefault(inner.span, span)
    return found


def _losses_by_calls(
    program: Program, wrong: Set[Span | None]
) -> Iterator[tuple[Span, Diagnostic]]:
    """Calls of what is not said, or not in full: spans of their statements, and what is found.

    wrong: the spans of what is not said, and of what stands in it.
    """
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
            if span is None or span in wrong:
                continue
            for name in dict.fromkeys(_names_called(statement)):
                if lacks.get(name):
                    rule = CALLS_NOT_TRANSLATED if name in gone else CALLS_PARTLY_TRANSLATED
                    yield span, rule(span=span, name=named[name].name)


def _names_called(statement: p.Statement) -> Iterator[str]:
    """The procedures and functions that a statement itself calls, in lower case."""
    for part in records(head(statement)):
        match part:
            case p.Call(procedure=name) | e.Apply(function=name):
                yield name.lower()

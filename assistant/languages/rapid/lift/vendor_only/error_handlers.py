"""Error handlers of RAPID: read, and reduced to what they do about one error.

A handler asks for the error by `ERRNO`. If the error is known, so are the branches taken: what is
left of the handler has no `ERRNO`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any, Final

from assistant.base.diagnostics import Span
from assistant.languages.rapid.lift.statements import StatementLift
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.expressions import Effect
from assistant.program.program import walk
from assistant.program.rewriting import Body, head, map_bodies, map_expressions, map_spans, records
from assistant.program.vendor_statements import effect_of

ERRNO: Final = "errno"
_ANY_ERROR: Final = "long_jmp_all_err"
WAIT_TIMEOUT: Final = "err_wait_maxtime"
_MOST_STATEMENTS: Final = 40
"""Maximum statements for one error in a handler: they are repeated wherever that error may
occur.
"""


def handlers_of(node: p.Statement) -> tuple[s.Handler, ...]:
    """Return the handlers in a vendor statement, empty for any other statement."""
    if isinstance(node, p.Opaque) and node.language == verbatim.LANGUAGE:
        return verbatim.understood(verbatim.error_handlers, node.text) or ()
    return ()


def handles(handler: s.Handler | None, error: str) -> bool:
    """True if a handler covers an error, given by its lower-case name: a handler without a list
    covers any.
    """
    if handler is None:
        return False
    listed = {one.name.lower() for one in handler.numbers if isinstance(one, s.NameRef)}
    # A handler without a list is for every error.
    return not handler.numbers or error in listed or _ANY_ERROR in listed


def raised_error(node: p.Statement) -> str | None:
    """Return the lower-case name of the error that a vendor statement raises, empty if it raises
    the current one again.
    """
    match _single_statement(node):
        case s.RaiseError(s.NameRef(name)):
            return name.lower()
        case s.RaiseError(None):
            return ""
    return None


def exit_word(node: p.Statement) -> str:
    """`RETRY`, `TRYNEXT` or `ExitCycle` in upper case, if a statement is that alone."""
    match _single_statement(node):
        case s.Word(said):
            return said
        case s.ProcedureCall(str(name), ()):
            return name.upper()
    return ""


def _single_statement(node: p.Statement) -> s.StatementNode | None:
    if isinstance(node, p.Opaque) and node.language == verbatim.LANGUAGE and not handlers_of(node):
        match verbatim.understood(verbatim.statements, node.text):
            case (one,):
                return one
    return None


def reduced_handler(
    handler: s.Handler, error: str, lift: StatementLift, span: Span | None
) -> Body | None:
    """Return the statements of a handler for one error; None if they read more of the error than
    its identity.
    """
    body = tuple(_with_known_error(lift.block(handler.body), error))
    body = tuple(_with_error_name(node, error) for node in body)
    body = _with_own_lines(map_spans(body, lambda _: span))
    nodes = [*walk(body)]
    # The statements are repeated at each place, where labels would clash.
    if len(nodes) > _MOST_STATEMENTS or any(isinstance(one, p.Label | p.Goto) for one in nodes):
        return None
    return None if any(map(_asks_error, nodes)) else body


def _with_own_lines(body: Body) -> Body:
    """Statements of one span, whose messages are no comments at the end of others' lines."""
    made: list[p.Statement] = []
    for node in body:
        node = map_bodies(node, _with_own_lines)
        if isinstance(node, p.Message | p.Comment) and node.span is not None:
            begin = node.span.start
            # One position less, so that the printer does not take it for a comment at the end of a
            # line of that span.
            node = replace(node, span=Span(begin, max(begin, node.span.end - 1)))
        made.append(node)
    return tuple(made)


def _with_error_name(node: p.Statement, error: str) -> p.Statement:
    """A statement with the name of the error in place of `ERRNO`."""

    def known(x: e.Expression) -> e.Expression:
        return e.Name(error) if isinstance(x, e.Name) and x.name.lower() == ERRNO else x

    return map_expressions(node, known)


def _asks_error(node: p.Statement) -> bool:
    for record in records(head(node)):
        match record:
            case e.Name(name) if name.lower() == ERRNO:
                return True
            case p.Opaque() | e.Verbatim():
                effect: Effect = effect_of(record)
                if ERRNO in effect.names:
                    return True
    return False


def _with_known_error(body: Iterable[p.Statement], error: str) -> Iterator[p.Statement]:
    """Yield statements with only the branches that run for one error."""
    for node in body:
        node = map_bodies(node, lambda inner: tuple(_with_known_error(inner, error)))
        node = _with_known_head(node, error)
        match node:
            case p.If(branches, otherwise):
                yield from _taken_branches(branches, otherwise, node)
            case p.Switch(e.Name(name), cases, otherwise) if name.lower() == ERRNO:
                yield from _taken_case(cases, otherwise, error, node)
            case _:
                yield node


def _with_known_head(node: Any, error: str) -> Any:
    if not isinstance(node, p.If):
        return node
    branches = tuple(
        replace(b, condition=map_expressions(b.condition, lambda x: _known_comparison(x, error)))
        for b in node.branches
    )
    return replace(node, branches=branches)


def _known_comparison(x: e.Expression, error: str) -> e.Expression:
    """A comparison with `ERRNO` as a truth, and what follows from that."""
    match x:
        case e.Binary("=" | "<>" as operator, e.Name(one), e.Name(other)) if ERRNO in (
            one.lower(),
            other.lower(),
        ):
            asked = other if one.lower() == ERRNO else one
            return e.Truth((asked.lower() == error) is (operator == "="))
        case e.Binary("and", e.Truth(value), other) | e.Binary("and", other, e.Truth(value)):
            return other if value else e.Truth(False)
        case e.Binary("or", e.Truth(value), other) | e.Binary("or", other, e.Truth(value)):
            return e.Truth(True) if value else other
        case e.Unary("not", e.Truth(value)):
            return e.Truth(not value)
    return x


def _taken_branches(
    branches: Iterable[p.Branch], otherwise: Body, node: p.If
) -> Iterator[p.Statement]:
    """An `if` without the branches that are never taken, or what is always done of it."""
    kept: list[p.Branch] = []
    for branch in branches:
        # A condition that always holds makes its branch the last one.
        if branch.condition == e.Truth(True):
            otherwise = branch.body
            break
        if branch.condition != e.Truth(False):
            kept.append(branch)
    if kept:
        yield replace(node, branches=tuple(kept), otherwise=otherwise)
    else:
        yield from otherwise


def _taken_case(
    cases: Iterable[p.Case], otherwise: Body, error: str, node: p.Switch
) -> Iterator[p.Statement]:
    """The body that an error selects; the question itself where that is not by a name."""
    for case in cases:
        # A case by a number cannot be compared with the name of the error.
        if not all(isinstance(value, e.Name) for value in case.values):
            yield node
            return
        names = {value.name.lower() for value in case.values if isinstance(value, e.Name)}
        if error in names:
            yield from case.body
            return
    yield from otherwise

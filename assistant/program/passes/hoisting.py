"""Statements that must stand before another one, whatever control flow that one is part of."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.rewriting import Body, map_bodies

POLL: Final = 0.01
"""Seconds between two looks at a condition that takes statements to work out."""


@dataclass(slots=True)
class Taken:
    """A statement with what was taken out of it: what stands before and after it."""

    statement: Any
    before: list[p.Statement] = field(default_factory=list)
    after: list[p.Statement] = field(default_factory=list)


Take = Callable[[p.Statement], Taken]
"""Takes out of a statement's own expressions; the bodies that it holds are not its business."""


def hoisted(body: Body, take: Take) -> Body:
    """The body with what `take` finds in front of and behind each statement.

    What a loop's condition needs is worked out before each turn; the conditions of an `If` in
    their order, each only if those before it do not hold.
    """
    made: list[p.Statement] = []
    for node in body:
        made += (x if x.span else replace(x, span=node.span) for x in _one(node, take))
    return tuple(made)


def _one(node: p.Statement, take: Take) -> Iterator[p.Statement]:
    if isinstance(node, p.If) and node.branches:
        yield from _if(node, take)
        return
    taken = take(node)
    before = taken.before
    inside = map_bodies(taken.statement, lambda b: hoisted(b, take))
    match inside:
        case p.While() if before:
            inside = replace(inside, body=(*inside.body, *before))
        case p.WaitUntil(condition, None) if before:
            again = (p.Wait(e.Number(POLL)), *before)
            inside = p.While(e.Unary("not", condition), again)
    yield from before
    yield inside
    yield from taken.after


def _if(node: p.If, take: Take) -> Iterator[p.Statement]:
    first, *rest = node.branches
    taken = take(p.If((replace(first, body=()),)))
    (test,) = taken.statement.branches
    branch = replace(test, body=hoisted(first.body, take))
    yield from taken.before
    if not rest:
        yield replace(node, branches=(branch,), otherwise=hoisted(node.otherwise, take))
        return
    match tuple(_if(replace(node, branches=tuple(rest)), take)):
        case (p.If(others, otherwise),):
            yield replace(node, branches=(branch, *others), otherwise=otherwise)
        case several:
            yield replace(node, branches=(branch,), otherwise=several)

"""Where comments and blank lines stand, as far as what is said does not depend on it.

A comment at the end of a line has the span of the statement there: a language of lines says it in
front of the statement, a language of words behind it.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Final

from assistant.program import statements as p
from assistant.program.diagnostics import Span
from assistant.program.program import Program, bodies
from assistant.program.rewriting import Body, map_bodies
from assistant.program.text import starts_of

_BLANK_ABOVE: Final = re.compile(r"\n[ \t]*\r?\n[ \t]*(?:[0-9]+[ \t]+)?\Z")
_FAR: Final = 400
"""Characters in front of a statement that are looked at."""


def with_blank_lines(program: Program) -> Program:
    """The program with an empty comment where its source has blank lines above a statement.

    A source that is no program of a language tells of none.
    """
    if program.origin is None:
        return program
    texts = [tree.source.text if tree.source else "" for tree in program.origin.trees]
    starts = starts_of([tree.source for tree in program.origin.trees])

    def parted(span: Span) -> bool:
        at = bisect_right(starts, span.start) - 1
        end = span.start - starts[at]
        return _BLANK_ABOVE.search(texts[at][max(0, end - _FAR) : end]) is not None

    def body(statements: Body) -> Body:
        return tuple(_spaced(statements, parted, body))

    procedures = (replace(q, body=body(q.body)) for q in program.procedures)
    return replace(program, procedures=tuple(procedures))


def _spaced(
    statements: Body, parted: Callable[[Span], bool], body: Callable[[Body], Body]
) -> Iterator[p.Statement]:
    """before: what stands above; what was made of one statement has nothing in between."""
    before: p.Statement | None = None
    for one in statements:
        if before is not None and before != p.Comment(""):
            if one.span is not None and one.span != before.span and parted(one.span):
                yield p.Comment("")
        yield map_bodies(one, body)
        before = one


def with_comments_in_front(program: Program) -> Program:
    """Comments at the end of a line are said in front of the statement of that line."""
    return _rearranged(program, _in_front)


def with_comments_behind(program: Program) -> Program:
    """Comments at the end of a line are said behind the statement of that line."""
    return _rearranged(program, _behind)


def _rearranged(program: Program, order: Callable[[Body], Body]) -> Program:
    def body(statements: Body) -> Body:
        return tuple(map_bodies(one, body) for one in order(statements))

    procedures = (replace(q, body=body(q.body)) for q in program.procedures)
    return replace(program, procedures=tuple(procedures))


def _in_front(statements: Body) -> Body:
    made: list[p.Statement] = []
    for one in statements:
        at = len(made)
        if isinstance(one, p.Comment) and made and not bodies(made[-1]):
            while at and one.stands_at_end_of(made[at - 1]):
                at -= 1
        made.insert(at, one)
    return tuple(made)


def _behind(statements: Body) -> Body:
    made: list[p.Statement] = []
    held: p.Comment | None = None
    for one, below in zip(statements, (*statements[1:], None), strict=False):
        if isinstance(one, p.Comment) and below is not None and not bodies(below):
            if one.stands_at_end_of(below) and not (made and made[-1].span == one.span):
                held = one
                continue
        made.append(one)
        if held is not None and (below is None or below.span != held.span):
            made.append(held)
            held = None
    return tuple(made)

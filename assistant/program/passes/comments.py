"""Comments and blank lines of a program, in the form that a language takes.

A comment at the end of a line has the span of the statement there: a language of lines prints it
before the statement, a language of words after it.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import ClassVar, Final

from assistant.base.diagnostics import Span
from assistant.base.source_text import in_ascii, starts_of
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.passes.legalisation import Changes, Legalisation, Rewording
from assistant.program.program import Program, bodies
from assistant.program.rewriting import Body, map_bodies


def plain_comment(r: Rewording, node: p.Comment) -> Iterator[p.Statement]:
    """A comment in lines that the language takes."""
    yield from (replace(node, text=line) for line in comment_lines(node.text, r.job))


def as_comment(r: Rewording, node: p.Message) -> Iterator[p.Statement]:
    """A message as a comment, for a language without any."""
    shown = "".join(map(_part_text, node.parts))
    line = comment_lines("message: " + shown, r.job)[0]
    if r.job.can.comments.message is not None:
        r.job.findings.append(r.job.can.comments.message(text=line))
    yield p.Comment(line)


def _part_text(part: e.Expression) -> str:
    """A part of a message for people: what is computed is told by the name of its variable."""
    match part:
        case e.Text(value):
            return value
        case e.Name(name) | e.Apply("text" | "fixed", (e.Name(name), *_)):
            return f"{{{name}}}"
    return "..."


class _InLines(Rewording):
    changes: ClassVar[Changes] = {p.Comment: plain_comment}


def with_plain_comments(job: Legalisation) -> Program:
    """The program with comments, and the name of its robot, in lines that the language takes."""
    said, program = _InLines(job), job.program
    return replace(
        program,
        comments=tuple(line for text in program.comments for line in comment_lines(text, job)),
        robot=program.robot and " ".join(comment_lines(program.robot, job)),
        procedures=tuple(map(said.procedure, program.procedures)),
    )


def comment_lines(text: str, job: Legalisation) -> list[str]:
    """A comment in lines that fit; control characters become blanks."""
    can = job.can.comments
    plain = in_ascii(text) if can.ascii else text
    plain = "".join(c if c.isprintable() else " " for c in plain).strip()
    if plain != text.strip() and not isinstance(text, p.OwnText):
        job.changed(f"the comment `{text.strip()}`", f"`{plain}`", "use one line of ASCII")
    made: list[str] = []
    while can.most_bytes is not None and len(plain.encode("utf-8")) > can.most_bytes:
        most = can.most_bytes
        while len(plain[:most].encode("utf-8")) > can.most_bytes:
            most -= 1
        cut = plain.rfind(" ", most // 2, most)
        cut = most if cut < 0 else cut
        made.append(plain[:cut].strip())
        plain = plain[cut:].strip()
    return [*made, plain]


_BLANK_ABOVE: Final = re.compile(r"\n[ \t]*\r?\n[ \t]*(?:[0-9]+[ \t]+)?\Z")


_FAR: Final = 400
"""Characters in front of a statement that are searched."""


def with_blank_lines(program: Program) -> Program:
    """Return the program with an empty comment for blank lines above a statement in its source.

    A program that was not lifted from a language's source has no blank lines.
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
    """Yield the statements with empty comments for blank lines. before: the statement above; the
    statements made from one statement have nothing in between.
    """
    before: p.Statement | None = None
    for one in statements:
        if before is not None and before != p.Comment(""):
            if one.span is not None and one.span != before.span and parted(one.span):
                yield p.Comment("")
        yield map_bodies(one, body)
        before = one


def with_comments_in_front(program: Program) -> Program:
    """Move comments at the end of a line in front of the statement of that line."""
    return _rearranged(program, _in_front)


def with_comments_behind(program: Program) -> Program:
    """Move comments at the end of a line after the statement of that line."""
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

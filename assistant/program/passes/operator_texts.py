"""Messages, questions, comments and blank lines: what people read or answer.

A part of a message is a value only if it is known to be no text. Names that other files declare are
not known: in a language whose messages take one text they stay as they are, and so must be texts.

For languages without dialogs a question waits for inputs. A key is an input that is on while it is
pressed; a number is at a group of inputs, and is taken when another one goes on. Each answer begins
with the release, so that none answers twice.

A comment at the end of a line has the span of the statement there: a language of lines prints it
before the statement, a language of words after it.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import reduce
from typing import ClassVar, Final

from assistant.base.diagnostics import Span
from assistant.base.source_text import in_ascii, starts_of
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.declared_types import KnownTypes, is_value, known_types
from assistant.program.passes.legalisation import Changes, Legalisation, Rewording
from assistant.program.program import Procedure, Program, Signal, bodies
from assistant.program.rewriting import Body, map_bodies, records

_VALUE_LENGTH: Final = 10
"""Assumed number of characters of a value."""


def message_parts(x: p.Message, known: KnownTypes) -> tuple[e.Expression, ...]:
    """Return the parts of a message in display order: values as they are, texts as they are."""
    found: list[e.Expression] = []
    for part in _summands(x.parts, lambda one: not is_value(one, known)):
        match part:
            case e.Apply("text", (value,)) if is_value(value, known):
                found.append(value)
            case _:
                found.append(part)
    return tuple(found)


def _summands(
    values: Iterable[e.Expression], joins: Callable[[e.Expression], bool]
) -> Iterator[e.Expression]:
    """The values with the operands of each sum that joins instead of it, inner ones too."""
    pending = list(reversed(tuple(values)))
    while pending:
        match pending.pop():
            case e.Binary("+", left, right) as whole if joins(whole):
                pending += [right, left]
            case single:
                yield single


def lines_of_parts(parts: Iterable[e.Expression], longest: int) -> list[list[e.Expression]]:
    """The parts of as many messages as it takes if none may have more characters than that."""
    rows: list[list[e.Expression]] = [[]]
    room = longest
    for part in parts:
        pieces: list[e.Expression] = [part]
        if isinstance(part, e.Text):
            text = part.value
            cut = [e.Text(text[i : i + longest]) for i in range(0, len(text), longest)]
            pieces = [*cut] or [part]
        for piece in pieces:
            length = len(piece.value) if isinstance(piece, e.Text) else _VALUE_LENGTH
            if rows[-1] and length > room:
                rows.append([])
                room = longest
            rows[-1].append(piece)
            room -= length
    return rows


def short_messages(r: Rewording, node: p.Message) -> Iterator[p.Statement]:
    """Yield as many messages as the limit of characters per message requires."""
    shown, most = message_parts(node, r.known) or (e.Text(""),), r.job.can.longest_message
    rows = [list(shown)] if most is None else lines_of_parts(shown, most)
    if len(rows) > 1:
        r.job.changed(
            f"a message of more than {most} characters",
            f"{len(rows)} messages",
            "write a shorter one",
        )
    yield from (p.Message(tuple(row), span=node.span) for row in rows)


def with_values(program: Program) -> Program:
    """A lifted program in which messages show values that need no conversion."""
    if not any(isinstance(x, p.Message) for x in program.statements()):
        return program

    def shown(procedure: Procedure) -> Procedure:
        known = known_types(program, procedure)

        def body(statements: tuple[p.Statement, ...]) -> tuple[p.Statement, ...]:
            return tuple(map(said, statements))

        def said(x: p.Statement) -> p.Statement:
            if isinstance(x, p.Message):
                return replace(x, parts=message_parts(x, known))
            inner: p.Statement = map_bodies(x, body)
            return inner

        return replace(procedure, body=body(procedure.body))

    return replace(program, procedures=tuple(map(shown, program.procedures)))


KEY: Final = "operator_key_{}"
"""The input of a key, counted from 1."""
NUMBER: Final = "operator_number"
ENTERED: Final = "operator_entered"
"""The input that tells that the number is there."""
_PREFIX: Final = "operator_"
_BITS: Final = 15
"""Bits of a number: with one more, controllers may read it as a negative one."""
_MOST: Final = 2**_BITS - 1


def is_operators(name: str) -> bool:
    """True if a signal is one for an operator's answer."""
    return name.lower().startswith(_PREFIX)


def asked_for_key(
    answer: e.Expression | None,
    keys: Sequence[int],
    values: Sequence[e.Expression],
    counts: Sequence[e.Expression | None] = (),
) -> Iterator[p.Statement]:
    """Waits until one of some keys is pressed, the first of which gives the answer its value.

    answer: None if nobody asks which. values: of the keys, in their order. counts: conditions under
    which each of them counts, None for one that always does; none at all if all of them do.
    """
    names = [KEY.format(key) for key in keys]
    each = [_signal_is(name, 1) for name in names]
    free = [_signal_is(name, 0) for name in names]
    for at, one in enumerate(counts):
        if one is not None:
            each[at] = e.Binary("and", each[at], one)
            free[at] = e.Unary("not", each[at])
    yield p.WaitUntil(_all_of_parts("and", free))
    pressed = p.WaitUntil(_all_of_parts("or", each))
    if answer is None or len(keys) == 1:
        yield pressed
        yield from () if answer is None else (p.Assign(answer, values[0]),)
        return
    # whoever lets a key go before it is looked at has to press again
    none = e.Number(_NO_KEY)
    yield p.Assign(answer, none)
    chosen = (
        p.Branch(one, (p.Assign(answer, value),)) for one, value in zip(each, values, strict=True)
    )
    yield p.While(e.Binary("=", answer, none), (pressed, p.If(tuple(chosen))))


_NO_KEY: Final = -1
"""Value that no key has."""


def asked_for_number(
    answer: e.Expression, least: e.Expression | None = None, most: e.Expression | None = None
) -> Iterator[p.Statement]:
    """Waits until a number is entered, and again while it is not from the least to the most."""
    taken = (
        p.WaitUntil(_signal_is(ENTERED, 0)),
        p.WaitUntil(_signal_is(ENTERED, 1)),
        p.Assign(answer, e.Name(NUMBER)),
    )
    yield from taken
    wrong: list[e.Expression] = []
    wrong += [] if least is None else [e.Binary("<", answer, least)]
    wrong += [] if most is None else [e.Binary(">", answer, most)]
    if wrong:
        yield p.While(_all_of_parts("or", wrong), taken)


def with_answers(program: Program) -> Program:
    """The program with the signals that its questions are answered by."""
    known = {name.lower() for name in program.signals}
    found: dict[str, Signal] = {}
    for one in records(program.procedures):
        if isinstance(one, e.Name) and is_operators(one.name) and one.name not in known:
            number = one.name == NUMBER
            kind, bits = ("group", _BITS) if number else ("digital", 1)
            found[one.name] = Signal(kind, "input", bits=bits)  # type: ignore[arg-type]
    ordered = {name: found[name] for name in sorted(found)}
    return replace(program, signals={**program.signals, **ordered}) if found else program


def _signal_is(signal: str, value: int) -> e.Expression:
    return e.Binary("=", e.Name(signal), e.Number(value))


def _all_of_parts(operator: e.BinaryOperator, parts: Iterable[e.Expression]) -> e.Expression:
    return reduce(lambda left, right: e.Binary(operator, left, right), parts)


def plain_comment(r: Rewording, node: p.Comment) -> Iterator[p.Statement]:
    """A comment in lines that the language takes."""
    yield from (replace(node, text=line) for line in comment_lines(node.text, r.job))


def as_comment(r: Rewording, node: p.Message) -> Iterator[p.Statement]:
    """A message as a comment, for a language without any."""
    shown = "".join(part.value if isinstance(part, e.Text) else "..." for part in node.parts)
    line = comment_lines("message: " + shown, r.job)[0]
    if r.job.can.comments.message is not None:
        r.job.findings.append(r.job.can.comments.message(text=line))
    yield p.Comment(line)


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
    if plain != text.strip():
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

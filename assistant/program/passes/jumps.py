"""Jumps that plain statements express: waits, loops without end, early returns, jumps to the next
statement.

Languages without blocks write them with labels. `*W`, `If M_In(9)=0 Then GoTo *W` waits until the
input is set; `*CYCLE` and `GoTo *CYCLE` below it repeat what stands between them for ever; a jump
to a label in front of the end of a procedure returns from it.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace

from assistant.base.diagnostics import Span
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.passes.expression_forms import opposite
from assistant.program.program import (
    Procedure,
    Program,
    labels_in_texts,
    last_statement,
    walk,
)
from assistant.program.rewriting import Body, map_bodies, records


def without_needless_jumps(program: Program) -> Program:
    """The program with waits, loops and returns in place of the jumps that mean these."""

    def settled(one: Procedure) -> Procedure:
        # What is left out may have stood between a jump and its label.
        while (made := _Jumps(program, one).procedure()) != one:
            one = made
        return one

    procedures = (
        settled(one) if any(isinstance(node, p.Label) for node in walk(one.body)) else one
        for one in program.procedures
    )
    return replace(program, procedures=tuple(procedures))


class _Jumps:
    """The jumps of a procedure. named: how many lead to each label, by its name."""

    def __init__(self, program: Program, whole: Procedure) -> None:
        self.program, self.whole = program, whole
        self.named = _named(whole.body)
        self.in_texts = labels_in_texts(whole.body)

    def procedure(self) -> Procedure:
        body = self._with_loops(self._with_waits(self.whole.body))
        returning = frozenset(self._returning(body)) if self.whole.result is None else frozenset()
        body = _without_jumps_to_next(_with_returns(body, returning - self.in_texts))
        return replace(self.whole, body=self._without_left_labels(body))

    # ------------------------------------------------------------------------------ waits

    def _with_waits(self, statements: Body) -> Body:
        """With a wait for each label that only the question below it jumps to."""
        made: list[p.Statement] = []
        for one in statements:
            label = last_statement(made)
            wait = self._wait(label, one) if isinstance(label, p.Label) else None
            if label is None or wait is None:
                made.append(map_bodies(one, self._with_waits))
            else:
                made.remove(label)
                made.append(wait)
        return tuple(made)

    def _wait(self, label: p.Label, node: p.Statement) -> p.Statement | None:
        match node:
            case p.If((p.Branch(condition, body),), ()):
                jumps = [one for one in body if not isinstance(one, p.Comment)]
            case _:
                return None
        alone = self.named[label.name] == 1 and label.name not in self.in_texts
        if not alone or len(jumps) != len(body) or not _is_jump_to(jumps, label.name):
            return None
        if not _is_of_comparisons(condition) or self._calls(condition):
            return None
        met = self._plain(opposite(condition))
        match met:
            case e.Binary("=", e.Name(name), e.Number() as value) if self._is_waited_for(name):
                return p.WaitSignal(name, value, span=node.span)
        return p.WaitUntil(met, span=node.span)

    def _is_waited_for(self, name: str) -> bool:
        signal = self.program.signals.get(name)
        return signal is not None and signal.kind != "analog"

    def _calls(self, condition: e.Expression) -> bool:
        """True if a condition is more than a question: it has text, or calls a procedure."""
        return any(
            isinstance(part, e.Verbatim)
            or (isinstance(part, e.Apply) and self.program.procedure(part.function) is not None)
            for part in records(condition)
        )

    def _plain(self, condition: e.Expression) -> e.Expression:
        """With `input=1` for `input<>0` of signals that have two values."""
        match condition:
            case e.Binary("and" | "or" as operator, left, right):
                return e.Binary(operator, self._plain(left), self._plain(right))
            case e.Binary("<>", e.Name(name) as signal, e.Number(0 | 1 as value)):
                known = self.program.signals.get(name)
                if known is not None and known.kind == "digital":
                    return e.Binary("=", signal, e.Number(1 - int(value)))
        return condition

    # ------------------------------------------------------------------------------ loops

    def _with_loops(self, statements: Body) -> Body:
        """With a loop without end for each label that a jump below it, in the same body, repeats
        from.
        """
        for at, label in enumerate(statements):
            if not isinstance(label, p.Label):
                continue
            ends = [i for i, x in enumerate(statements) if i > at and _is_jump_to((x,), label.name)]
            if not ends:
                continue
            inner, end = statements[at + 1 : ends[-1]], statements[ends[-1]]
            if not self._is_entered_from(inner, label.name, 1) or not self._is_closed(inner):
                continue
            body = self._without_repeats(inner, label.name)
            if body is not None:
                loop = p.While(e.Truth(True), self._with_loops(body), span=end.span)
                rest = self._with_loops(statements[ends[-1] + 1 :])
                return (*statements[:at], loop, *rest)
        return tuple(map_bodies(one, self._with_loops) for one in statements)

    def _is_entered_from(self, body: Body, label: str, others: int = 0) -> bool:
        """True if all jumps to a label, but for so many, stand in a body."""
        return label not in self.in_texts and self.named[label] == _named(body)[label] + others

    def _is_closed(self, body: Body) -> bool:
        """True if nothing jumps into a body."""
        labels = [one.name for one in walk(body) if isinstance(one, p.Label)]
        return all(self._is_entered_from(body, name) for name in labels)

    def _without_repeats(self, body: Body, label: str) -> Body | None:
        """The body of a loop whose questions jump to its begin no more: what stands below such a
        question is its other branch. None if a jump to there stands deeper.
        """
        for at, one in enumerate(body):
            jumps = _named((one,))[label]
            if not jumps:
                continue
            rest = self._without_repeats(body[at + 1 :], label)
            match one:
                case p.If((p.Branch(condition, asked),), ()) if (
                    jumps == 1 and rest is not None and self._is_closed(body[at + 1 :])
                ):
                    last = last_statement(list(asked))
                    if last is None or not _is_jump_to((last,), label):
                        return None
                    kept = tuple(x for x in asked if x is not last)
                    if not kept and not _is_of_comparisons(condition):
                        return None
                    return (*body[:at], *_question(condition, kept, rest, one.span))
            return None
        return body

    # ---------------------------------------------------------------------------- returns

    def _returning(self, body: Body) -> Iterator[str]:
        """Labels in front of the end of the procedure, or of a return."""
        waiting: list[str] = []
        for one in body:
            match one:
                case p.Label(name):
                    waiting.append(name)
                case p.Return(None):
                    yield from waiting
                    waiting = []
                case p.Comment():
                    pass
                case _:
                    waiting = []
        yield from waiting

    # ----------------------------------------------------------------------------- labels

    def _without_left_labels(self, body: Body) -> Body:
        """Without the labels that jumps led to which are left out, and returns behind a jump."""
        left = _named(body)
        gone = {name for name in self.named if not left[name]} - self.in_texts

        def within(statements: Body) -> Body:
            made: list[p.Statement] = []
            for one in statements:
                if isinstance(one, p.Label) and one.name in gone:
                    continue
                leaves = isinstance(last_statement(made), p.Goto | p.Return)
                # A function has to have a result at its end, reached or not.
                if leaves and isinstance(one, p.Goto | p.Return) and self.whole.result is None:
                    continue
                made.append(map_bodies(one, within))
            return tuple(made)

        return within(body) if gone else body


def _question(
    condition: e.Expression, asked: Body, otherwise: Body, span: Span | None
) -> Iterator[p.Statement]:
    """A question with two branches, either of which may be empty."""
    match otherwise:
        case (p.If(branches, others),) if asked:
            yield p.If((p.Branch(condition, asked), *branches), others, span=span)
        case _ if asked:
            yield p.If((p.Branch(condition, asked),), otherwise, span=span)
        case ():
            return
        case _:
            yield p.If((p.Branch(opposite(condition), otherwise),), span=span)


def _named(body: Body) -> Counter[str]:
    return Counter(one.label for one in walk(body) if isinstance(one, p.Goto))


def _is_jump_to(statements: Sequence[p.Statement], label: str) -> bool:
    match statements:
        case [p.Goto(name)]:
            return name == label
    return False


def _is_of_comparisons(condition: e.Expression) -> bool:
    match condition:
        case e.Binary("and" | "or", left, right):
            return _is_of_comparisons(left) and _is_of_comparisons(right)
        case e.Binary(operator):
            return operator in e.RELATIONS
    return False


def _with_returns(body: Body, returning: frozenset[str]) -> Body:
    def within(statements: Body) -> Body:
        return tuple(
            p.Return(span=one.span)
            if isinstance(one, p.Goto) and one.label in returning
            else map_bodies(one, within)
            for one in statements
        )

    return within(body) if returning else body


def _without_jumps_to_next(statements: Body) -> Body:
    made: list[p.Statement] = []
    for at, one in enumerate(statements):
        if not (isinstance(one, p.Goto) and one.label in _labels_at(statements[at + 1 :])):
            made.append(map_bodies(one, _without_jumps_to_next))
    return tuple(made)


def _labels_at(body: Body) -> set[str]:
    """The labels that a body begins with, comments among them or not."""
    first = itertools.takewhile(lambda x: isinstance(x, p.Label | p.Comment), body)
    return {one.name for one in first if isinstance(one, p.Label)}

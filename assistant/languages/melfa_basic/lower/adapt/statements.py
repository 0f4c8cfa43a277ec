"""Statements in the form that their text is read back as."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.lower.adapt.data import plain_variables
from assistant.languages.melfa_basic.lower.adapt.expressions import plain_expression
from assistant.languages.melfa_basic.lower.adapt.paths import plain_path
from assistant.languages.melfa_basic.lower.statements import opaque_line
from assistant.languages.melfa_basic.text import printer
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure
from assistant.program.rewriting import Body, map_bodies, map_head, records

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lower.adapt.context import Context

MOST_COMMENT: Final = 100
"""Bytes of a comment line that is written."""


def plain_procedure(context: Context, procedure: Procedure) -> Procedure:
    """The procedure with its statements in plain form."""
    context.enter(procedure)
    body = _Plain(context).body(procedure.body)
    while body and body[-1] == p.Return():
        body = body[:-1]
    return replace(
        procedure,
        body=body,
        local=False,
        variables=plain_variables(context, procedure.variables),
    )


def comment_lines(text: str) -> list[str]:
    """A comment in lines that fit a step; control characters become blanks."""
    plain = "".join(c if c.isprintable() else " " for c in text).strip()
    lines: list[str] = []
    while len(plain.encode("utf-8")) > MOST_COMMENT:
        most = MOST_COMMENT
        while len(plain[:most].encode("utf-8")) > MOST_COMMENT:
            most -= 1
        cut = plain.rfind(" ", most // 2, most)
        cut = most if cut < 0 else cut
        lines.append(plain[:cut].strip())
        plain = plain[cut:].strip()
    return [*lines, plain]


class _Plain:
    """The statements of one procedure. selects: how many `Switch` are around the place."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self.selects = 0

    def body(self, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            with self.context.findings.at(node.span):
                made += (x if x.span else replace(x, span=node.span) for x in self.statement(node))
        return tuple(made)

    def statement(self, node: p.Statement) -> Iterable[p.Statement]:
        node = map_head(node, lambda x: plain_expression(self.context, x, deep=False))
        change = CHANGES.get(type(node))
        if change is not None:
            return change(self, node)
        return (map_bodies(node, self.body),)

    # --------------------------------------------------------------------------- moves

    def move(self, node: Any) -> Iterator[p.Statement]:
        joint = isinstance(node, p.MoveJoints) or getattr(node, "kind", "") == "joint"
        yield replace(node, motion=self.context.motion(node.motion, joint))

    def follow(self, node: p.Follow) -> Iterator[p.Statement]:
        if len(node.path):
            yield replace(node, path=plain_path(self.context, node.path))

    # ------------------------------------------------------------------------- signals

    def start_timer(self, node: p.StartTimer) -> Iterator[p.Statement]:
        yield replace(node, timer=self.context.timer(node.timer))

    def set_signal(self, node: p.SetSignal) -> Iterator[p.Statement]:
        self.fits(node.signal, node.value)
        yield replace(node, signal=self.context.spelled(node.signal))

    def wait_signal(self, node: p.WaitSignal) -> Iterator[p.Statement]:
        """One for another value than a number is a wait for a condition."""
        signal = self.context.spelled(node.signal)
        if isinstance(node.value, e.Number):
            self.fits(signal, node.value)
            yield replace(node, signal=signal)
            return
        condition = e.Binary("=", e.Name(signal), node.value)
        yield p.WaitUntil(condition, node.timeout, span=node.span)

    def wait_until(self, node: p.WaitUntil) -> Iterator[p.Statement]:
        """One for a signal and a number is a wait for the signal."""
        match node.condition:
            case e.Binary("=", e.Name(name), e.Number() as value) if self.context.is_signal(name):
                self.fits(name, value)
                yield p.WaitSignal(name, value, node.timeout, span=node.span)
            case e.Name(name) if self.context.is_signal(name):
                yield p.WaitSignal(name, e.Number(1), node.timeout, span=node.span)
            case _:
                yield node

    def fits(self, name: str, value: e.Expression) -> None:
        """An error where a digital signal or a group is to have what its bits cannot hold."""
        signal = self.context.signal(name)
        if signal is None or signal.kind == "analog" or not isinstance(value, e.Number):
            return
        most = (1 << signal.bits) - 1
        if not (0 <= value.value <= most and value.value == int(value.value)):
            bits = "1 bit" if signal.bits == 1 else f"{signal.bits} bits"
            self.context.findings.append(
                rules.NO_FIT(bits=bits, name=name, value=value.value, most=most)
            )

    # ------------------------------------------------------------------------- control

    def for_(self, node: p.For) -> Iterator[p.Statement]:
        yield map_bodies(replace(node, variable=self.context.spelled(node.variable)), self.body)

    def switch(self, node: p.Switch) -> Iterator[p.Statement]:
        """A case of no value is never chosen."""
        node = replace(node, cases=tuple(case for case in node.cases if case.values))
        nested = self.selects and not self.context.dialect.nested_select
        if nested or not _selectable(node):
            if sum(len(c.values) for c in node.cases) > 1:
                self.compared_once(node.subject)
            if node.cases:
                yield map_bodies(_as_if(node), self.body)
            else:
                yield from self.body(node.otherwise)
            return
        self.selects += 1
        yield map_bodies(node, self.body)
        self.selects -= 1

    def compared_once(self, subject: e.Expression) -> None:
        """An error where a subject calls functions, which each comparison would do again."""
        for record in records(subject):
            if isinstance(record, e.Apply) and self.context.program.procedure(record.function):
                self.context.findings.append(rules.CANNOT_SAY(
                    what=f"that `{record.function}` is called once for all cases here",
                    cure="assign it to a variable, and choose by that",
                ))  # fmt: skip

    def call(self, node: p.Call) -> Iterator[p.Statement]:
        """Calls say the unit of what they call, if that is another one."""
        callee = self.context.program.procedure(node.procedure)
        if callee is None:
            yield node
            return
        unit = None if callee.unit == self.context.unit else callee.unit
        yield replace(node, procedure=callee.name, unit=unit)

    def stop(self, node: p.Stop) -> Iterator[p.Statement]:
        """An end for good: `End` would begin the next cycle, a start goes on behind one `Hlt`."""
        if node.end:
            self.context.findings.append(rules.ENDED())
            halt = (p.Stop(span=node.span),)
            yield p.While(e.Number(1), halt, span=node.span)
        else:
            yield node

    # ---------------------------------------------------------------------------- text

    def comment(self, node: p.Comment) -> Iterator[p.Statement]:
        for line in comment_lines(node.text):
            yield replace(node, text=line)

    def message(self, node: p.Message) -> Iterator[p.Statement]:
        text = "".join(q.value if isinstance(q, e.Text) else "..." for q in node.parts)
        line = next(iter(comment_lines("message: " + text)))
        self.context.findings.append(rules.MESSAGE(text=line))
        yield p.Comment(line)

    def opaque(self, node: p.Opaque) -> Iterator[p.Statement]:
        """The vendor text in its canonical layout, if this language has it."""
        dialect = self.context.dialect
        line = opaque_line(node, dialect)
        if line is None:
            yield node
        else:
            yield replace(node, language=dialect.name, text=printer.line(line, dialect.upper))


def _selectable(node: p.Switch) -> bool:
    """Whether each case is one number, all that `Case` can say."""
    return bool(node.cases) and all(
        len(c.values) == 1 and isinstance(c.values[0], e.Number) for c in node.cases
    )


def _as_if(node: p.Switch) -> p.If:
    branches = []
    for case in node.cases:
        tests: list[e.Expression] = [e.Binary("=", node.subject, v) for v in case.values]
        condition = tests[0]
        for test in tests[1:]:
            condition = e.Binary("or", condition, test)
        branches.append(p.Branch(condition, case.body))
    return p.If(tuple(branches), node.otherwise)


CHANGES: Final[dict[type, Callable[[_Plain, Any], Iterable[p.Statement]]]] = {
    p.Move: _Plain.move,
    p.MoveCircular: _Plain.move,
    p.MoveJoints: _Plain.move,
    p.Follow: _Plain.follow,
    p.StartTimer: _Plain.start_timer,
    p.SetSignal: _Plain.set_signal,
    p.WaitSignal: _Plain.wait_signal,
    p.WaitUntil: _Plain.wait_until,
    p.For: _Plain.for_,
    p.Switch: _Plain.switch,
    p.Call: _Plain.call,
    p.Stop: _Plain.stop,
    p.Comment: _Plain.comment,
    p.Message: _Plain.message,
    p.Opaque: _Plain.opaque,
}

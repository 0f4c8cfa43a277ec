"""Statements in the form that their text is read back as."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

from assistant.languages.melfa_basic.lower.adapt.data import plain_variables
from assistant.languages.melfa_basic.lower.adapt.expressions import plain_expression
from assistant.languages.melfa_basic.lower.adapt.paths import plain_path
from assistant.languages.melfa_basic.lower.adapt.triggers import plain_trigger, with_triggers
from assistant.languages.melfa_basic.lower.statements import opaque_line
from assistant.languages.melfa_basic.text import printer
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.passes.comments import as_comment, plain_comment
from assistant.program.passes.endings import end_for_good
from assistant.program.passes.places import constants
from assistant.program.passes.rewording import Changes, Rewording
from assistant.program.passes.switches import plain_switch
from assistant.program.passes.waits import fit, set_signal, wait_signal, wait_until
from assistant.program.program import Procedure

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lower.adapt.context import Context


def plain_procedure(context: Context, procedure: Procedure) -> Procedure:
    """The procedure with its statements in plain form."""
    plain = _Plain(context)
    plain.enter(procedure)
    context.constants = constants(context.program, procedure)
    body = plain.body(procedure.body)
    while body and body[-1] == p.Return():
        body = body[:-1]
    return replace(
        procedure,
        body=body,
        local=False,
        variables=plain_variables(context, procedure.variables),
    )


class _Plain(Rewording):
    """The statements of one procedure."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.job)
        self.context = context

    def expression(self, x: e.Expression) -> e.Expression:
        return plain_expression(self.context, x, deep=False)

    def move(self, node: Any) -> Iterator[p.Statement]:
        joint = isinstance(node, p.MoveJoints) or getattr(node, "kind", "") == "joint"
        motion = self.context.motion(node.motion, joint)
        if not node.triggers:
            yield replace(node, motion=motion)
            return
        triggers = tuple(plain_trigger(self.context, one) for one in node.triggers)
        for one in triggers:
            fit(self, one.signal, one.value)
        yield from with_triggers(self.context, replace(node, motion=motion, triggers=triggers))

    def follow(self, node: p.Follow) -> Iterator[p.Statement]:
        if len(node.path):
            yield replace(node, path=plain_path(self.context, node.path))

    def opaque(self, node: p.Opaque) -> Iterator[p.Statement]:
        """The vendor text in its canonical layout, if this language has it."""
        dialect = self.context.dialect
        line = opaque_line(node, dialect)
        if line is None:
            yield node
        else:
            yield replace(node, language=dialect.name, text=printer.line(line, dialect.upper))

    changes: ClassVar[Changes] = {
        p.Move: move,
        p.MoveCircular: move,
        p.MoveJoints: move,
        p.Follow: follow,
        p.SetSignal: set_signal,
        p.WaitSignal: wait_signal,
        p.WaitUntil: wait_until,
        p.Switch: plain_switch,
        p.Stop: end_for_good,
        p.Comment: plain_comment,
        p.Message: as_comment,
        p.Opaque: opaque,
    }

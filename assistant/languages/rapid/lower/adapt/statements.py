"""Procedures and statements as RAPID can say them, with a finding for each change."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.statements import statements_of
from assistant.languages.rapid.lower.adapt.expressions import (
    sayable_expression,
    sayable_variable,
)
from assistant.languages.rapid.lower.adapt.motions import Motions
from assistant.languages.rapid.tables.hands import gripper
from assistant.languages.rapid.text import verbatim
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.kinds import is_position, is_truth
from assistant.program.diagnostics import has_errors
from assistant.program.geometry import Target
from assistant.program.passes.accelerations import one_acceleration
from assistant.program.passes.comments import plain_comment
from assistant.program.passes.conditions import as_truth, compared, with_conditions
from assistant.program.passes.legalising import Legalising
from assistant.program.passes.messages import short_messages
from assistant.program.passes.plain_expressions import floor
from assistant.program.passes.points import move_at
from assistant.program.passes.rewording import Rewording
from assistant.program.passes.switches import plain_switch
from assistant.program.program import Procedure, identifier
from assistant.program.rewriting import is_repeatable


class StatementAdapter(Rewording):
    """targets: those that paths of a single one become, filled as procedures are adapted."""

    def __init__(self, job: Legalising, motions: Motions) -> None:
        super().__init__(job)
        self.program, self.motions = job.program, motions
        self.signals = {n.lower(): g for n, g in job.program.signals.items()}
        self.targets: dict[str, Target] = {}

    def procedure(self, procedure: Procedure) -> Procedure:
        with self.job.findings.at(procedure.span):
            return self._procedure(procedure)

    def _procedure(self, procedure: Procedure) -> Procedure:
        self.enter(procedure)
        variables = {
            n: sayable_variable(v, n, self.job, procedure.name)
            for n, v in procedure.variables.items()
        }
        for name, variable in variables.items():
            if variable.storage == "persistent":
                self.job.cannot(f"the persistent `{name}` inside a procedure", "declare it outside")
            if variable.local:
                variables[name] = replace(variable, local=False)
        return replace(procedure, body=self.body(procedure.body), variables=variables)

    def expression(self, x: e.Expression) -> e.Expression:
        match x:
            case e.Apply("floor", (inner,)) if is_repeatable(inner):
                x = floor(inner)
            case e.Apply("inverse", (inner,)) if is_position(inner, self.known):
                self.job.cannot(
                    "the inverse of a target", "work it out beforehand, or take a pose for it"
                )
        return compared(sayable_expression(x, self.job), self.known)

    def whole(self, node: p.Statement) -> p.Statement:
        return with_conditions(node, self.known)


Changed = list[p.Statement]


def _motion(a: StatementAdapter, x: Any) -> Changed:
    triggers = tuple(replace(one, value=_bit(one.value)) for one in x.triggers)
    return [replace(x, motion=a.motions.motion(x.motion), triggers=triggers)]


def _follow(a: StatementAdapter, x: p.Follow) -> Changed:
    if not len(x.path):
        a.job.changed(f"the path `{x.path.name}`, which has no targets", "nothing", "leave it out")
        return []
    path = a.motions.path(x.path)
    if len(path) > 1 or has_errors(a.job.findings):
        return [replace(x, path=path)]
    name = identifier(f"{path.name}_1", {*a.program.targets, *a.targets, *a.program.variables})
    a.targets[name] = path.target(0)
    return [move_at(path, 0, e.Name(name))]


def _wait_signal(a: StatementAdapter, x: p.WaitSignal) -> Changed:
    value = _bit(x.value)
    signal = a.signals.get(x.signal.lower())
    if signal is not None and signal.kind == "analog":
        condition = e.Binary("=", e.Name(x.signal), value)
        return [p.WaitUntil(condition, x.timeout, span=x.span)]
    return [replace(x, value=value)]


def _bit(value: e.Expression) -> e.Expression:
    return e.Number(int(value.value)) if isinstance(value, e.Truth) else value


def _assign(a: StatementAdapter, x: p.Assign) -> Changed:
    return [replace(x, value=as_truth(x.value)) if is_truth(x.target, a.known) else x]


def _set_signal(_: StatementAdapter, x: p.SetSignal) -> Changed:
    value = _bit(x.value)
    hand = gripper(x.signal, value) if x.pulse is None else None
    if hand is not None:
        return [replace(hand, span=x.span)]
    return [replace(x, value=value)]


def _opaque(a: StatementAdapter, x: p.Opaque) -> Changed:
    if x.language != verbatim.LANGUAGE:
        a.job.findings.append(rules.OTHER_LANGUAGE(**verbatim.foreign(x)))
        return [x]
    return list(statements_of(x.text, a.program))


StatementAdapter.changes = {
    p.Move: _motion,
    p.MoveCircular: _motion,
    p.MoveJoints: _motion,
    p.Follow: _follow,
    p.WaitSignal: _wait_signal,
    p.Assign: _assign,
    p.SetSignal: _set_signal,
    p.SetAcceleration: one_acceleration,
    p.Comment: plain_comment,
    p.Message: short_messages,
    p.Switch: plain_switch,
    p.Opaque: _opaque,
}

"""Procedures, variables and statements as RAPID can say them, with a finding for each change."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from assistant.base.diagnostics import Declared, Refused, has_errors
from assistant.languages.legalisation import PartLegaliser
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.expressions import (
    frame_name,
    lift_expression,
    negated,
    tool_name,
)
from assistant.languages.rapid.lift.statements import statements_of
from assistant.languages.rapid.lower.adapt.motions import MotionAdapter
from assistant.languages.rapid.tables.hands import gripper
from assistant.languages.rapid.tables.words import UNUSED
from assistant.languages.rapid.text import verbatim
from assistant.languages.records import aggregate
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.declared_types import is_position, is_truth
from assistant.program.analysis.uses import changed_by_others
from assistant.program.geometry import Target
from assistant.program.motion import FINE
from assistant.program.passes.expression_forms import (
    as_truth,
    compared,
    floor,
    two_at_a_time,
    with_conditions,
    with_shift_parts,
)
from assistant.program.passes.legalisation import Legalisation, Rewording
from assistant.program.passes.motions import declared_value, one_acceleration
from assistant.program.passes.operator_texts import plain_comment, short_messages
from assistant.program.passes.paths import move_at
from assistant.program.passes.switches import plain_switch
from assistant.program.program import Procedure, Variable, identifier
from assistant.program.rewriting import is_steady, map_expressions


class StatementAdapter(Rewording):
    """targets: those that paths of a single one become, filled as procedures are adapted."""

    def __init__(self, job: Legalisation, motions: MotionAdapter, written: PartLegaliser) -> None:
        super().__init__(job)
        self.program, self.motions, self.written = job.program, motions, written
        self.signals = {n.lower(): g for n, g in job.program.signals.items()}
        self.targets: dict[str, Target] = {}
        self.changing = changed_by_others(job.program)
        starts = (x for x in job.program.statements() if isinstance(x, p.StartTimer))
        self.restarted = {x.timer.lower() for x in starts}

    def procedure(self, procedure: Procedure) -> Procedure:
        with self.job.findings.at(procedure.span):
            return super().procedure(procedure)

    def variable(self, variable: Variable, name: str, owner: str = "") -> Variable:
        """With a type that RAPID has."""
        if variable.storage == "constant" and variable.initial is None:
            about = Declared(name, "variables", owner)
            self.job.cannot(f"the constant `{name}` without a value", "give it one", about)
        if owner and variable.storage == "persistent":
            self.job.cannot(f"the persistent `{name}` inside a procedure", "declare it outside")
        initial = variable.initial
        if variable.type == "position" and variable.size:
            initial = map_expressions(initial, _unset_target)
        if variable.type == "truth":
            initial = map_expressions(initial, as_truth)
        initial = map_expressions(initial, self.plain)
        return replace(variable, initial=initial, local=variable.local and not owner)

    def expression(self, x: e.Expression) -> e.Expression:
        match x:
            case e.Elapsed(timer) if timer.lower() not in self.restarted:
                self.job.cannot(f"the time of `{timer}`, which nothing restarts", "restart it")
            case e.Apply("floor", (inner,)) if is_steady(inner, self.changing):
                x = floor(inner)
            case e.Apply("floor"):
                cure = "assign the value to a variable first"
                self.job.cannot("the whole number below a value that is read once", cure)
            case e.Apply("inverse", (inner,)) if is_position(inner, self.known):
                self.job.cannot(
                    "the inverse of a target", "work it out beforehand, or take a pose for it"
                )
        return compared(self.plain(x), self.known)

    def plain(self, x: e.Expression) -> e.Expression:
        """An expression in the form that its text is read back as."""
        match x:
            case e.Unary("-", operand):
                return negated(operand)
            case e.Number(value) if value == 0:
                return e.Number(0)
            case e.Aggregate(items):
                made = aggregate(items)
                return x if isinstance(made, e.Aggregate) else self.plain(made)
            case e.TargetValue(target):
                what = "a written out target"
                return e.TargetValue(self.written.target(target, what, what))
            case e.JointValue(joints):
                what = "a written out joint target"
                return e.JointValue(self.written.joints(joints, what, what))
            case e.PoseValue(pose):
                return e.PoseValue(self.written.pose(pose, "a pose") or pose)
            case e.Apply("relative", given) if 4 < len(given) < 7:
                return with_shift_parts(x, 6)
            case e.Here(tool, frame):
                return e.Here(tool_name(tool), frame_name(frame))
            case e.Apply("min" | "max", (_, _, _, *_)):
                return two_at_a_time(x)
            case e.Verbatim(verbatim.LANGUAGE):
                return _understood(x)
        return x

    def whole(self, node: p.Statement) -> p.Statement:
        return with_conditions(node, self.known)


def _understood(x: e.Verbatim) -> e.Expression:
    try:
        known = lift_expression(verbatim.expression(x.text), str)
    except Refused:
        return x  # a finding when it is built
    return x if known == x else known


def _unset_target(x: e.Expression) -> e.Expression:
    """A target that no move takes, as one that was given no value: its orientation is none."""
    if x != e.NEVER_GIVEN:
        return x
    parts = ([0] * 3, [0] * 4, [0] * 4, [UNUSED] * 6)
    return e.Aggregate(tuple(e.Aggregate(tuple(map(e.Number, part))) for part in parts))


Adaptation = list[p.Statement]


def _motion(a: StatementAdapter, x: Any) -> Adaptation:
    triggers = tuple(replace(one, value=_bit_value(one.value)) for one in x.triggers)
    motion = a.motions.motion(_stopping_motion(a, x) if x.until is not None else x.motion)
    return [replace(x, motion=motion, triggers=triggers)]


def _stopping_motion(a: StatementAdapter, x: p.MoveStatement) -> p.Motion:
    """The motion of a move that is broken off, which the program has to wait for."""
    if declared_value(x.motion.blend, a.program.blends) == FINE:
        return x.motion
    a.job.changed(
        "a corner behind a move that may be broken off", "a stop there",
        "let the robot stop at its end",
    )  # fmt: skip
    return replace(x.motion, blend=FINE)


def _follow(a: StatementAdapter, x: p.Follow) -> Adaptation:
    if not len(x.path):
        a.job.changed(f"the path `{x.path.name}`, which has no targets", "nothing", "leave it out")
        return []
    path = a.motions.path(x.path, x.row_span)
    if len(path) > 1 or has_errors(a.job.findings):
        return [replace(x, path=path)]
    name = identifier(f"{path.name}_1", {*a.program.targets, *a.targets, *a.program.variables})
    a.targets[name] = path.target(0)
    return [move_at(path, 0, e.Name(name))]


def _wait_signal(a: StatementAdapter, x: p.WaitSignal) -> Adaptation:
    value = _bit_value(x.value)
    signal = a.signals.get(x.signal.lower())
    if signal is not None and signal.kind == "analog":
        condition = e.Binary("=", e.Name(x.signal), value)
        return [p.WaitUntil(condition, x.timeout, span=x.span)]
    return [replace(x, value=value)]


def _bit_value(value: e.Expression) -> e.Expression:
    return e.Number(int(value.value)) if isinstance(value, e.Truth) else value


def _assign(a: StatementAdapter, x: p.Assign) -> Adaptation:
    return [replace(x, value=as_truth(x.value)) if is_truth(x.target, a.known) else x]


def _set_signal(_: StatementAdapter, x: p.SetSignal) -> Adaptation:
    value = _bit_value(x.value)
    hand = gripper(x.signal, value) if x.pulse is None else None
    if hand is not None:
        return [replace(hand, span=x.span)]
    return [replace(x, value=value)]


def _opaque(a: StatementAdapter, x: p.Opaque) -> Adaptation:
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

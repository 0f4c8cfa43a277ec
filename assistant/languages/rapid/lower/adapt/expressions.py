"""Expressions and variables in the form that their text in RAPID is read back as."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from assistant.languages.rapid.lift.expressions import (
    frame_name,
    lift,
    negative,
    tool_name,
)
from assistant.languages.rapid.lower.adapt.data import sayable_joints, sayable_pose, sayable_target
from assistant.languages.rapid.tables.words import UNUSED
from assistant.languages.rapid.text import verbatim
from assistant.languages.records import aggregate
from assistant.program import expressions as e
from assistant.program.diagnostics import Refused
from assistant.program.passes.conditions import as_truth
from assistant.program.passes.legalising import Legalising
from assistant.program.passes.plain_expressions import in_pairs, shifted
from assistant.program.program import Variable
from assistant.program.rewriting import map_expressions
from assistant.program.subjects import Declared


def sayable_expression(x: e.Expression, job: Legalising) -> e.Expression:
    """An expression in the form that its text is read back as."""
    match x:
        case e.Unary("-", operand):
            return negative(operand)
        case e.Number(value) if value == 0:
            return e.Number(0)
        case e.Aggregate(items):
            made = aggregate(items)
            return x if isinstance(made, e.Aggregate) else sayable_expression(made, job)
        case e.TargetValue(target):
            return e.TargetValue(sayable_target(target, "a written out target", job))
        case e.JointValue(target):
            return e.JointValue(sayable_joints(target, "a written out joint target", job))
        case e.PoseValue(pose):
            return e.PoseValue(sayable_pose(pose, job))
        case e.Apply("relative", given) if 4 < len(given) < 7:
            return shifted(x, 6)
        case e.Here(tool, frame):
            return e.Here(tool_name(tool), frame_name(frame))
        case e.Apply("min" | "max", (_, _, _, *_)):
            return in_pairs(x)
        case e.Verbatim(verbatim.LANGUAGE):
            return _understood(x)
    return x


def _understood(x: e.Verbatim) -> e.Expression:
    try:
        known = lift(verbatim.expression(x.text), str)
    except Refused:
        return x  # a finding when it is built
    return x if known == x else known


def _unset(x: e.Expression) -> e.Expression:
    """A target that no move takes, as one that was given no value: its orientation is none."""
    if x != e.NEVER_GIVEN:
        return x
    parts = ([0] * 3, [0] * 4, [0] * 4, [UNUSED] * 6)
    return e.Aggregate(tuple(e.Aggregate(tuple(map(e.Number, part))) for part in parts))


def sayable_variable(variable: Variable, name: str, job: Legalising, owner: str = "") -> Variable:
    """With a type that RAPID has. owner: procedure whose own it is, empty for the program's."""
    if variable.storage == "constant" and variable.initial is None:
        about = Declared(name, "variables", owner)
        job.cannot(f"the constant `{name}` without a value", "give it one", about)
    if variable.type == "position" and variable.size:
        variable = replace(variable, initial=map_expressions(variable.initial, _unset))
    if variable.type == "truth":
        variable = replace(variable, initial=map_expressions(variable.initial, as_truth))
    change = partial(sayable_expression, job=job)
    return replace(variable, initial=map_expressions(variable.initial, change))

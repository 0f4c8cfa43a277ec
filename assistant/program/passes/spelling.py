"""Names as their declarations spell them, wherever they are used."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.spelling import Spelling
from assistant.program.path import Path
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import rewrite


def with_declared_names(program: Program) -> Program:
    """The program with every name as it was declared, and calls that say another unit than theirs.

    Tools, frames, speeds and blends are the business of motions.
    """
    spelling = Spelling(program)
    variables = _respelled(program.variables, spelling, None)
    return replace(
        program,
        variables=variables,
        procedures=tuple(_respelled_procedure(q, spelling) for q in program.procedures),
    )


def _respelled_procedure(procedure: Procedure, spelling: Spelling) -> Procedure:
    spelling.enter(procedure)
    return replace(
        procedure,
        variables=_respelled(procedure.variables, spelling, procedure.unit),
        body=_respelled(procedure.body, spelling, procedure.unit),
    )


def _respelled(value: Any, spelling: Spelling, unit: str | None) -> Any:
    """unit: in which it stands."""

    def visit(node: Any) -> Any:
        match node:
            case e.Name(name):
                return replace(node, name=spelling.name(name))
            case e.Elapsed(timer) | p.StartTimer(timer):
                return replace(node, timer=spelling.timer(timer))
            case e.Member(field=field):
                return replace(node, field=field.lower())
            case e.Apply(function) if function.lower() in e.FUNCTIONS:
                return replace(node, function=function.lower())
            case e.Apply(function) if called := spelling.procedure(function):
                return replace(node, function=called.name)
            case p.SetSignal(name) | p.WaitSignal(name) | p.Trigger(name):
                return replace(node, signal=spelling.name(name))
            case p.For(name):
                return replace(node, variable=spelling.name(name))
            case p.Call(name) if called := spelling.procedure(name):
                other = None if called.unit == unit else called.unit
                return replace(node, procedure=called.name, unit=other)
        return node

    return rewrite(value, visit, (Path, p.Motion, e.TargetValue, e.JointValue, e.PoseValue))

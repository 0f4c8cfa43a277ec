"""Tools, frames and variables as MELFA-BASIC can say them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.lower.adapt.expressions import plain_expression
from assistant.program import rotations
from assistant.program.geometry import BASE, FLANGE, IDENTITY, Frame, Tool
from assistant.program.program import Program, Variable
from assistant.program.subjects import Declared

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lower.adapt.context import Context


def with_plain_data(context: Context, program: Program) -> Program:
    """The program with everything but its procedures in plain form."""
    for declaration in program.declarations:
        with context.findings.at(declaration.span):
            context.job.cannot(
                what=f"the {declaration.language} declaration `{declaration.text[:40]}`",
                cure="leave it out or say it in plain statements",
            )
    return replace(
        program,
        tools=dict(_tools(context, program)),
        frames=dict(_frames(context, program)),
        speeds={},
        blends={},
        targets={
            n: context.target(n, t, Declared(n, "targets")) for n, t in program.targets.items()
        },
        joint_targets={
            n: context.joints(n, t, Declared(n, "joint_targets"))
            for n, t in program.joint_targets.items()
        },
        variables=plain_variables(context, program.variables),
    )


def plain_variables(context: Context, variables: Mapping[str, Variable]) -> dict[str, Variable]:
    """Variables with their first values in plain form."""
    made = {}
    for name, variable in variables.items():
        made[name] = variable
        if variable.initial is not None:
            with context.findings.at(variable.span):
                initial = plain_expression(context, variable.initial)
            made[name] = replace(variable, initial=initial)
    return made


def _tools(context: Context, program: Program) -> Iterator[tuple[str, Tool]]:
    for name, tool in program.tools.items():
        if name.lower() == FLANGE and tool.tip == IDENTITY:
            continue
        about = Declared(name, "tools")
        if not tool.held:
            context.findings.append(rules.HELD(name=name, about=about))
        if tool.load is not None:
            context.findings.append(rules.LOAD(name=name, about=about))
        if context.five_axis is not None:
            turned = rotations.angle_between(tool.tip.quaternion, IDENTITY.quaternion)
            if math.hypot(*tool.tip.position[:2]) > 0.01 or turned > 0.01:
                context.findings.append(rules.FIVE_AXIS_TOOL(name=name, about=about))
        context.finite(f"the tool `{name}`", (*tool.tip.position, *tool.tip.quaternion), about)
        yield name, replace(tool, load=None)


def _frames(context: Context, program: Program) -> Iterator[tuple[str, Frame]]:
    for name, frame in program.frames.items():
        if name.lower() == BASE and frame.pose == IDENTITY:
            continue
        about = Declared(name, "frames")
        if frame.held or frame.mechanism:
            context.findings.append(rules.HELD(name=name, about=about))
        if frame.object != IDENTITY:
            context.findings.append(rules.FRAME_JOINED(name=name, about=about))
            frame = replace(frame, user=frame.pose, object=IDENTITY)
        context.finite(f"the frame `{name}`", (*frame.user.position, *frame.user.quaternion), about)
        yield name, frame

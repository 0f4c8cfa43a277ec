"""Data that a program declares as RAPID has them: tools, work objects, speeds, zones, targets."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from assistant.languages.rapid.lift.timers import TYPE as CLOCK
from assistant.languages.rapid.lower.expressions import (
    Expressions,
    finite,
    joints_node,
    numbers_node,
    pose_node,
    target_node,
)
from assistant.languages.rapid.lower.motions import motions
from assistant.languages.rapid.lower.names import Naming
from assistant.languages.rapid.tables.motions import (
    speed_name,
    speed_values,
    zone_name,
    zone_values,
)
from assistant.languages.rapid.tables.words import (
    LEAST_CENTRE,
    LEAST_MASS,
    SPEEDS,
    TYPE_OF_VALUE,
    ZONES,
)
from assistant.languages.rapid.text.verbatim import LANGUAGE
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.runs import POSITION_PLACES, QUATERNION_PLACES
from assistant.program.geometry import BASE, FLANGE, Frame, Load, Tool
from assistant.program.motion import Blend, Speed
from assistant.program.program import Program, Variable
from assistant.program.timers import timers

TASK: Final = "TASK"
SIZES_PLACES: Final = 6
"""Decimals of masses, inertias, speeds and zone sizes."""


def data(program: Program, names: Naming) -> Iterator[s.Data]:
    """The data that a program declares; raises Refused for what RAPID cannot say.

    What was one task's own where it was read stays that: a pseudo-program is of one task.
    """
    own = _of_task(program)
    for node in _data(program, names):
        yield replace(node, scope=TASK) if node.name.lower() in own else node


def _of_task(program: Program) -> set[str]:
    """Lower-case names of the data that were read as `TASK`."""
    origin = program.origin
    files = origin.trees if origin is not None and origin.language == LANGUAGE else ()
    items = (item for file in files for module in file.modules for item in module.items)
    return {i.name.lower() for i in items if isinstance(i, s.Data) and i.scope == TASK}


def _data(program: Program, names: Naming) -> Iterator[s.Data]:
    expressions = Expressions(names, names.value)
    for name, tool in program.tools.items():
        if name != FLANGE:
            yield s.Data("", "PERS", "tooldata", names.get("tools", name), (), tool_node(tool))
    for name, frame in program.frames.items():
        if name != BASE:
            yield s.Data("", "PERS", "wobjdata", names.get("frames", name), (), frame_node(frame))
    speeds = {names.get("speeds", n): v for n, v in program.speeds.items()}
    blends = {names.get("blends", n): v for n, v in program.blends.items()}
    for speed, blend in motions(program):
        if isinstance(speed, Speed) and (name := speed_name(speed)) not in SPEEDS:
            speeds[name] = speed
        if isinstance(blend, Blend) and (name := zone_name(blend)) not in ZONES:
            blends[name] = blend
    for name, speed in speeds.items():
        finite(speed_values(speed), f"the speed `{name}`")
        sizes = numbers_node(speed_values(speed), SIZES_PLACES)
        yield s.Data("", "CONST", "speeddata", name, (), sizes)
    for name, blend in blends.items():
        finite(zone_values(blend), f"the zone `{name}`")
        sizes = numbers_node(zone_values(blend), SIZES_PLACES)
        zone = s.AggregateNode((s.BoolLiteral(blend.fine), *sizes.items))
        yield s.Data("", "CONST", "zonedata", name, (), zone)
    for name, joints in program.joint_targets.items():
        short = names.get("values", name)
        yield s.Data("", "CONST", "jointtarget", short, (), joints_node(joints))
    for name, variable in program.variables.items():
        yield variable_node(names.get("values", name), variable, expressions)
    for name in timers(program):
        yield s.Data("", "VAR", CLOCK, names.get("timers", name))
    for name, target in program.targets.items():
        short = names.get("values", name)
        yield s.Data("", "CONST", "robtarget", short, (), target_node(target))


def variable_node(name: str, variable: Variable, expressions: Expressions) -> s.Data:
    storage = {"constant": "CONST", "variable": "VAR", "persistent": "PERS"}[variable.storage]
    value = None if variable.initial is None else expressions.lower(variable.initial)
    return s.Data(
        "LOCAL" if variable.local else "",
        storage,
        TYPE_OF_VALUE[variable.type],
        name,
        tuple(s.NumberLiteral(str(extent)) for extent in variable.size),
        value,
    )


def tool_node(tool: Tool) -> s.AggregateNode:
    load = tool.load or Load(LEAST_MASS, LEAST_CENTRE)
    return s.AggregateNode((s.BoolLiteral(tool.held), pose_node(tool.tip), load_node(load)))


def load_node(load: Load) -> s.AggregateNode:
    numbers = [load.mass, *load.centre, *load.axes, *load.inertia]
    finite(numbers, "the load of a tool")
    return s.AggregateNode(
        (
            *numbers_node([load.mass], SIZES_PLACES).items,
            numbers_node(list(load.centre), POSITION_PLACES),
            numbers_node(list(load.axes), QUATERNION_PLACES),
            *numbers_node(list(load.inertia), SIZES_PLACES).items,
        )
    )


def frame_node(frame: Frame) -> s.AggregateNode:
    return s.AggregateNode(
        (
            s.BoolLiteral(frame.held),
            s.BoolLiteral(not frame.mechanism),
            s.StringLiteral(frame.mechanism),
            pose_node(frame.user),
            pose_node(frame.object),
        )
    )

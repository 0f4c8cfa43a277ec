"""Data that a program declares as RAPID has them: tools, work objects, speeds, zones, targets."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Final

from assistant.languages.rapid.lift.clocks import CLOCK_TYPE as CLOCK
from assistant.languages.rapid.lower.expressions import RECORDS, Expressions, bracketed
from assistant.languages.rapid.tables.motions import (
    speed_name,
    speed_values,
    zone_name,
    zone_values,
)
from assistant.languages.rapid.tables.triggers import TRIGGER_TYPE as TRIGGER
from assistant.languages.rapid.tables.words import (
    LEAST_CENTRE,
    LEAST_MASS,
    SPEEDS,
    TYPE_OF_VALUE,
    ZONES,
)
from assistant.languages.rapid.text.verbatim import LANGUAGE
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.runs import SIZES_PLACES
from assistant.languages.scoped_names import Naming
from assistant.program.analysis.motion_use import stated_motions
from assistant.program.geometry import BASE, FLANGE, Load
from assistant.program.motion import Blend, Speed
from assistant.program.program import Program, Variable
from assistant.program.undeclared_names import timers

TASK: Final = "TASK"
LOCAL: Final = "LOCAL"
MOTION_TYPES: Final = ("speeddata", "zonedata", TRIGGER)
NO_LOAD: Final = Load(LEAST_MASS, LEAST_CENTRE)
"""Of a tool that states none."""


def data_nodes(program: Program, names: Naming) -> Iterator[s.Data]:
    """The data that a program declares; raises Refused for what RAPID cannot say.

    What was one task's own where it was read stays that: a pseudo-program is of one task.
    """
    own, local = _task_data(program), _own_to_module(program)
    for node in _module_data(program, names):
        if node.name.lower() in own:
            yield replace(node, scope=TASK)
        else:
            yield replace(node, scope=LOCAL) if local(node) else node


def scope_of_paths(program: Program) -> str:
    """Of the targets of paths."""
    return LOCAL if program.interface is not None and program.interface.local else ""


def _own_to_module(program: Program) -> Callable[[s.Data], bool]:
    """Whether data are seen in their module alone: others do not call them, or have the like.

    The latter are speeds and zones that are called by what they are, and what is set on the way of
    moves. What units that are loaded use as well is seen by all.
    """
    stands = program.interface
    if stands is None or any(one.unit is not None for one in program.procedures):
        return lambda node: False  # noqa: ARG005
    if stands.local:
        return lambda node: True  # noqa: ARG005
    if not (stands.prefix or stands.called or not stands.main):
        return lambda node: False  # noqa: ARG005
    named = {name.lower() for name in (*program.speeds, *program.blends)}
    return lambda node: node.type in MOTION_TYPES and node.name.lower() not in named


def _task_data(program: Program) -> set[str]:
    """Lower-case names of the data that were read as `TASK`."""
    origin = program.origin
    files = origin.trees if origin is not None and origin.language == LANGUAGE else ()
    items = (item for file in files for module in file.modules for item in module.items)
    return {i.name.lower() for i in items if isinstance(i, s.Data) and i.scope == TASK}


def _module_data(program: Program, names: Naming) -> Iterator[s.Data]:
    expressions = Expressions(names, names.value)
    yield from (
        node for node in _equipment_nodes(program, names) if not _is_on_controller(node, program)
    )
    speeds = {names.get("speeds", n): v for n, v in program.speeds.items()}
    blends = {names.get("blends", n): v for n, v in program.blends.items()}
    for speed, blend in stated_motions(program):
        if isinstance(speed, Speed) and (name := speed_name(speed)) not in SPEEDS:
            speeds[name] = speed
        if isinstance(blend, Blend) and (name := zone_name(blend)) not in ZONES:
            blends[name] = blend
    for name, speed in speeds.items():
        sizes = RECORDS.rounded(speed_values(speed), SIZES_PLACES, f"the speed `{name}`")
        yield s.Data("", "CONST", "speeddata", name, (), bracketed(sizes))
    for name, blend in blends.items():
        sizes = RECORDS.rounded(zone_values(blend), SIZES_PLACES, f"the zone `{name}`")
        yield s.Data("", "CONST", "zonedata", name, (), bracketed([blend.fine, *sizes]))
    for name, joints in program.joint_targets.items():
        short = names.get("values", name)
        yield s.Data("", "CONST", "jointtarget", short, (), bracketed(RECORDS.values(joints)))
    for name, variable in program.variables.items():
        yield variable_node(names.get("values", name), variable, expressions)
    for name in timers(program):
        yield s.Data("", "VAR", CLOCK, names.get("timers", name))
    for name in names.triggers.values() if program.procedures else ():  # else of one module beside
        yield s.Data("", "VAR", TRIGGER, name)
    for name, target in program.targets.items():
        short = names.get("values", name)
        yield s.Data("", "CONST", "robtarget", short, (), bracketed(RECORDS.values(target)))


def _equipment_nodes(program: Program, names: Naming) -> Iterator[s.Data]:
    """Tools and work objects."""
    for name, tool in program.tools.items():
        if name != FLANGE:
            value = RECORDS.values(replace(tool, load=tool.load or NO_LOAD))
            yield s.Data("", "PERS", "tooldata", names.get("tools", name), (), bracketed(value))
    for name, frame in program.frames.items():
        if name != BASE:
            value = bracketed(RECORDS.values(frame))
            yield s.Data("", "PERS", "wobjdata", names.get("frames", name), (), value)


def controller_data_nodes(program: Program, names: Naming) -> Iterator[s.Data]:
    """Tools and work objects that the controller has."""
    return (node for node in _equipment_nodes(program, names) if _is_on_controller(node, program))


def _is_on_controller(node: s.Data, program: Program) -> bool:
    return program.interface is not None and node.name.lower() in program.interface.there


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

"""Data of a module: tools, work objects, speeds, zones, targets, and paths as columns.

Declarations of what a program has in its tables; the targets and moves of a path as runs; and the
passes that concern them: rounding of targets and loads, and tools and work objects that a program
sets to a pose. `table = taught` becomes `table.uframe:=taught;`, and `table.oframe` the identity
where it is declared otherwise; of a robtarget, position and orientation are taken. A tool is
`grip.tframe`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.diagnostics import Refused
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.clocks import CLOCK_TYPE as CLOCK
from assistant.languages.rapid.lower.expressions import RECORDS, Expressions, bracketed
from assistant.languages.rapid.tables.constants import (
    LEAST_CENTRE,
    LEAST_MASS,
    SPEEDS,
    TYPE_OF_VALUE,
    UNUSED,
    ZONES,
)
from assistant.languages.rapid.tables.equivalents import (
    speed_name,
    speed_values,
    zone_name,
    zone_values,
)
from assistant.languages.rapid.tables.predefined import signature
from assistant.languages.rapid.tables.signals import TRIGGER_TYPE as TRIGGER
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.text.verbatim import LANGUAGE
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.syntax import (
    CIRCULAR,
    JOINT_PLACES,
    POSITION_PLACES,
    QUATERNION_PLACES,
    SIZES_PLACES,
    MotionNames,
    MoveRun,
    TargetRun,
    moves_text,
    targets_text,
)
from assistant.languages.records import load_of
from assistant.languages.runs.columns import Entries, Names
from assistant.languages.runs.paths import setting_codes
from assistant.languages.scoped_names import Naming
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.declared_types import is_position
from assistant.program.analysis.motion_use import stated_motions
from assistant.program.geometry import BASE, FLANGE, IDENTITY, Load
from assistant.program.motion import UNSTATED, Blend, Kind, Path, Speed
from assistant.program.passes.legalisation import Changes, Legalisation, Loads, Positions, Rewording
from assistant.program.program import Procedure, Program, Variable
from assistant.program.undeclared_names import timers
from assistant.robots.configurations import to_confdata

TASK: Final = "TASK"
LOCAL: Final = "LOCAL"
_MOTION_TYPES: Final = ("speeddata", "zonedata", TRIGGER)
NO_LOAD: Final = Load(LEAST_MASS, LEAST_CENTRE)
"""Load of a tool that states no load."""


def data_nodes(program: Program, names: Naming) -> Iterator[s.Data]:
    """Yield the data that a program declares; raises Refused for data that RAPID cannot express.

    Data read as local to one task remain so: a pseudo-program belongs to one task.
    """
    own, local = _task_data(program), _own_to_module(program)
    for node in _module_data(program, names):
        if node.name.lower() in own:
            yield replace(node, scope=TASK)
        else:
            yield replace(node, scope=LOCAL) if local(node) else node


def scope_of_paths(program: Program) -> str:
    """Return the scope of the targets of paths."""
    return LOCAL if program.interface is not None and program.interface.local else ""


def _own_to_module(program: Program) -> Callable[[s.Data], bool]:
    """Return a predicate for data local to their module: other modules do not use them, or have
    similar data.

    The second case covers speeds and zones named after their values, and data for outputs that
    moves set. Data that loaded units use as well are global.
    """
    stands = program.interface
    if stands is None or any(one.unit is not None for one in program.procedures):
        return lambda node: False  # noqa: ARG005
    if stands.local:
        return lambda node: True  # noqa: ARG005
    if not (stands.prefix or stands.called or not stands.main):
        return lambda node: False  # noqa: ARG005
    named = {name.lower() for name in (*program.speeds, *program.blends)}
    return lambda node: node.type in _MOTION_TYPES and node.name.lower() not in named


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
        # Predefined ones need no declaration.
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
    constants = {n: v for n, v in program.variables.items() if v.storage == "constant"}
    changing = {n: v for n, v in program.variables.items() if n not in constants}
    for name, variable in constants.items():
        yield variable_node(names.get("values", name), variable, expressions)
    for name, target in program.targets.items():
        short = names.get("values", name)
        yield s.Data("", "CONST", "robtarget", short, (), bracketed(RECORDS.values(target)))
    for name, variable in changing.items():
        yield variable_node(names.get("values", name), variable, expressions)
    for name in timers(program):
        yield s.Data("", "VAR", CLOCK, names.get("timers", name))
    for name in names.triggers.values() if program.procedures else ():  # else of one module beside
        yield s.Data("", "VAR", TRIGGER, name)


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


_SHORTEST_RUN: Final = 8
"""Rows of a run; fewer are single declarations or statements, as they are when read."""


def path_targets(path: Path, stem: str, scope: str) -> list[s.TargetRunNode | s.Data]:
    """The declarations of a path's targets, `stem_1` and so on."""
    run = _target_run(path, stem)
    if len(run) >= _SHORTEST_RUN:
        return [s.TargetRunNode(scope, run)]
    # Through text, so that short paths are the same nodes as when they are read.
    return list(verbatim.items(targets_text(run, scope, "", "\n")))  # type: ignore[arg-type]


def path_moves(path: Path, stem: str, names: Naming) -> list[s.StatementNode]:
    """The moves through a path's targets."""
    run = _move_run(path, stem, names)
    if len(run) >= _SHORTEST_RUN:
        return [s.MoveRunNode(run)]
    return list(verbatim.statements(moves_text(run, "", "\n")))


def speed_name_in(names: Naming, speed: Speed | e.Name) -> str:
    """Return the name of a speed in a program."""
    return names.get("speeds", speed.name) if isinstance(speed, e.Name) else speed_name(speed)


def blend_name_in(names: Naming, blend: Blend | e.Name) -> str:
    return names.get("blends", blend.name) if isinstance(blend, e.Name) else zone_name(blend)


def frame_name_in(names: Naming, frame: str) -> str:
    """Empty for the base, which no move names."""
    return "" if frame.lower() == BASE else names.get("frames", frame)


def _target_run(path: Path, stem: str) -> TargetRun:
    """The targets of a path, rounded as they are printed."""
    if not (np.isfinite(path.positions).all() and np.isfinite(path.quaternions).all()):
        raise Refused(rules.NOT_FINITE(what=f"the path `{path.name}`"))
    values = np.empty((len(path), 17))
    np.round(path.positions, POSITION_PLACES, out=values[:, 0:3])
    np.round(path.quaternions, QUATERNION_PLACES, out=values[:, 3:7])
    values[:, 7:11] = to_confdata(path.configurations)
    external = np.where(np.isnan(path.external), UNUSED, path.external)
    np.round(external, JOINT_PLACES, out=values[:, 11:17])
    # Adding 0.0 turns -0.0 into 0.0, which is printed without a sign.
    return TargetRun(_target_names(path, stem), values + 0.0)


def _target_names(path: Path, stem: str) -> Names:
    return Names.numbered(f"{stem}_".encode("ascii"), np.arange(1, len(path) + 1))


def _move_run(path: Path, stem: str, names: Naming) -> MoveRun:
    via = path.kinds == Kind.VIA
    ends = np.flatnonzero(~via)
    # Moves share few combinations of settings: each is named once, not once a row.
    _, first, index = np.unique(setting_codes(path)[ends], return_index=True, return_inverse=True)
    table: dict[MotionNames, int] = {}
    rows = []
    for row in ends[first].tolist():
        speed, blend = path.speeds[path.speed[row]], path.blends[path.blend[row]]
        tool, frame = path.tools[path.tool[row]], path.frames[path.frame[row]]
        named = names.get("tools", tool), frame_name_in(names, frame)
        motion = MotionNames(speed_name_in(names, speed), blend_name_in(names, blend), *named)
        # Different settings may have the same names in RAPID.
        rows.append(table.setdefault(motion, len(table)))
    # From the kinds of a path to rows of PLAIN_MOVES; a via point has no move of its own.
    kinds = np.array([0, 1, 0, 2], dtype=np.uint8)[path.kinds[ends]]
    whole, arcs = _target_names(path, stem), kinds == CIRCULAR
    vias = whole.rows(np.flatnonzero(via)).spread(np.flatnonzero(arcs), len(ends))
    motions = Entries(tuple(table), np.array(rows, dtype=np.int32)[index])
    return MoveRun(kinds, whole.rows(ends), vias if arcs.any() else Names.none(len(ends)), motions)


def _stated_branches(branches: NDArray[np.int8]) -> NDArray[np.int8]:
    """Arm branches (n, 6) with zeros for unstated ones."""
    return np.where(branches[:, :1] == UNSTATED, np.int8(0), branches)


def _written_load(load: Load) -> Load:
    return load_of(*RECORDS.values(load))


_LOADS: Final = Loads(
    least=NO_LOAD, missing=rules.NO_LOAD, centre="0.001 mm before the flange", written=_written_load
)
POSITIONS: Final = Positions(
    decimals=RECORDS.joint,
    not_finite=rules.NOT_FINITE,
    branches=_stated_branches,
    unstated=rules.NO_CONFIGURATION,
    unused=UNUSED,
    quaternions=True,
    padded=True,
    loads=_LOADS,
)


_TOOL_FRAME: Final = "tframe"
_USER_FRAME: Final = "uframe"
_OBJECT_FRAME: Final = "oframe"
_MOUNT_TYPES: Final = ("tooldata", "wobjdata")
_RAPID_NAME: Final = "rapid"
_POSE_PARTS: Final = ("trans", "rot")
"""Those of a position that are a pose."""


def with_set_mounts(job: Legalisation) -> Program:
    """The program with parts of tools and frames for those that it sets to a pose."""
    program = job.program
    if not (program.frames or program.tools):
        return program
    said = _Mounts(job)
    return replace(program, procedures=tuple(map(said.procedure, program.procedures)))


class _Mounts(Rewording):
    """own: names, in lower case, that the procedure at hand calls something else."""

    def __init__(self, job: Legalisation) -> None:
        super().__init__(job)
        program = job.program
        self.frames = {name.lower(): frame for name, frame in program.frames.items()}
        self.tools = {name.lower() for name in program.tools}
        self.shadows = {name.lower() for name in program.variables}
        self.own: set[str] = set()
        texts = (one.text for one in program.declarations if one.language == _RAPID_NAME)
        self.kept = _mounts_in(verbatim.items, texts)
        self.records = self.kept

    def enter(self, procedure: Procedure) -> None:
        super().enter(procedure)
        self.own = self.shadows | {name.lower() for name in procedure.variables}
        self.own |= {parameter.name.lower() for parameter in procedure.parameters}
        texts = (one.text for one in procedure.body if isinstance(one, p.Opaque))
        self.records = self.kept | _mounts_in(verbatim.statements, texts)

    def assign(self, node: p.Assign) -> Iterator[p.Statement]:
        name = node.target.name.lower() if isinstance(node.target, e.Name) else ""
        # A local name hides the tool or frame, and a complete value needs no parts.
        if name in self.own or name not in {*self.frames, *self.tools} or self.is_whole(node.value):
            yield node
            return
        outer = _USER_FRAME if name in self.frames else _TOOL_FRAME
        yield replace(node, target=e.Member(node.target, outer), value=self.pose(node.value))
        # The pose is the whole frame, so a declared object frame must not be added to it.
        if name in self.frames and self.frames[name].object != IDENTITY:
            yield replace(
                node, target=e.Member(node.target, _OBJECT_FRAME), value=e.PoseValue(IDENTITY)
            )

    def is_whole(self, value: e.Expression) -> bool:
        """True if a value is a complete tool or frame, or a record of one."""
        match value:
            case e.Name(name):
                low = name.lower()
                known = low in self.frames or low in self.tools or low in self.records
                return known and low not in self.own
            case e.Index(e.Name(name)):
                return name.lower() in self.records - self.own
            case e.Apply(name):
                routine = signature(name)
                told = routine is not None and routine.result in _MOUNT_TYPES
                return told or name.lower() in self.records
        return isinstance(value, e.Aggregate | e.Verbatim)

    def pose(self, value: e.Expression) -> e.Expression:
        match value:
            case e.TargetValue(target):
                return e.PoseValue(target.pose)
            case e.Name() | e.Index() if is_position(value, self.known):
                return e.Aggregate(tuple(e.Member(value, part) for part in _POSE_PARTS))
            case e.Apply("inverse", (inner,)):
                return e.inverse(self.pose(inner))
        return value

    changes: ClassVar[Changes] = {p.Assign: assign}


def _mounts_in(read: Callable[[str], Any], texts: Iterable[str]) -> frozenset[str]:
    """Return the lower-case names of the tools and work objects that vendor texts declare.

    The names include functions that return one.
    """
    nodes = (node for text in texts for node in verbatim.understood(read, text) or ())
    return frozenset(
        node.name.lower()
        for node in nodes
        if isinstance(node, s.Data | s.Routine) and node.type.lower() in _MOUNT_TYPES
    )

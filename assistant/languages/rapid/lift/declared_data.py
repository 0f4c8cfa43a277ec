"""Data that modules declare: tools, work objects, speeds, zones, targets and variables.

`DataLift` reads the single declarations. `PathLift` reads long runs of targets and of moves through
them column by column, rows of 17 numbers as in a `TargetRun`: a run of moves through consecutively
numbered targets becomes a path, other targets stay single ones.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows
from assistant.base.diagnostics import span_over
from assistant.languages.rapid.lift.expressions import lift_expression
from assistant.languages.rapid.tables.constants import UNUSED, VALUE_OF_TYPE
from assistant.languages.rapid.tables.equivalents import BLENDS, SPEEDS, speed_of, zone_of
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.changed_data import changed_names
from assistant.languages.rapid.tree.literals import literal_number, literal_values
from assistant.languages.rapid.tree.syntax import CIRCULAR, TARGET_PARTS, TargetRun
from assistant.languages.rapid.tree.walk import nodes
from assistant.languages.records import frame_of, shape, target, tool_of
from assistant.languages.runs.columns import Names, joined_runs
from assistant.languages.runs.paths import (
    NamedTargets,
    PathRows,
    Stretch,
    setting_columns,
    values_at,
)
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import BASE, FLANGE, Frame, JointTarget, Target, Tool
from assistant.program.motion import UNSTATED, Blend, Kind, Path, Speed, ValueNames
from assistant.program.program import TakenNames, Variable, identifier
from assistant.robots.configurations import from_confdata

T = TypeVar("T", Speed, Blend)
_STORAGES: Final = {"CONST": "constant", "VAR": "variable", "PERS": "persistent"}


class DataLift:
    """Lift the data of modules.

    speeds, blends: by lower-case name, also unnamed ones. start: offset of the current module's
    text.
    """

    def __init__(
        self,
        modules: Sequence[s.Module],
        starts: Sequence[int],
        original: Callable[[str], str],
    ) -> None:
        self.original = original
        self.start = 0
        self.tools: dict[str, Tool] = {}
        self.frames: dict[str, Frame] = {}
        self.speeds: dict[str, Speed] = {}
        self.blends: dict[str, Blend] = {}
        self._spelled: dict[str, str] = {}
        self.joint_targets: dict[str, JointTarget] = {}
        self.targets: dict[str, Target] = {}
        self.variables: dict[str, Variable] = {}
        self._held: set[int] = set()
        self._names: set[str] = set()
        assigned = _assigned_names(modules)
        self._extents = dict(_constant_extents(modules))
        for module, self.start in zip(modules, starts, strict=True):
            for item in module.items:
                if isinstance(item, s.Data) and item.name.lower() not in self._names:
                    # Data that nothing assigns is as good as a constant.
                    constant = item.storage == "CONST" or item.name.lower() not in assigned
                    if self._take(item, constant):
                        self._held.add(id(item))
                        self._names.add(item.name.lower())

    def holds(self, item: s.Data) -> bool:
        return id(item) in self._held

    def named(self, table: ValueNames[T], values: Mapping[str, T]) -> dict[str, T]:
        """Those of some speeds or blends that have names."""
        return {self.original(self._spelled[n]): v for n, v in table.named(values).items()}

    def _take(self, item: s.Data, constant: bool) -> bool:
        """Record the data; True if the pseudo-program can hold it."""
        type, name = item.type.lower(), self.original(item.name)
        if item.dimensions and type not in VALUE_OF_TYPE:
            return False
        value = literal_values(item.value)
        if type == "tooldata" and (tool := tool_of(value)) and name.lower() != FLANGE:
            self.tools[name] = tool
        elif type == "wobjdata" and (frame := frame_of(value)) and name.lower() != BASE:
            self.frames[name] = frame
        elif (
            type == "speeddata"
            and constant
            and (speed := _value_of_other_name(SPEEDS, item, self.speeds))
        ):
            self.speeds[item.name.lower()] = speed
            self._spelled[item.name.lower()] = item.name
        elif (
            type == "zonedata"
            and constant
            and (blend := _value_of_other_name(BLENDS, item, self.blends))
        ):
            self.blends[item.name.lower()] = blend
            self._spelled[item.name.lower()] = item.name
        elif type == "speeddata" and constant and shape(value) == "nnnn":
            self.speeds[item.name.lower()] = speed_of(value)
            self._spelled[item.name.lower()] = item.name
        elif type == "zonedata" and constant and shape(value) == "bnnnnnn":
            zone = zone_of(value[0], value[1:])
            # A stop point with sizes is not the one that would be written back.
            if zone.radius is None and any(value[1:]):
                return False
            self.blends[item.name.lower()] = zone
            self._spelled[item.name.lower()] = item.name
        elif type in VALUE_OF_TYPE:
            variable = self.variable(item)
            if variable is None:
                return False
            match fixed_target(variable):
                case Target() as target:
                    self.targets[name] = target
                case JointTarget() as joints:
                    self.joint_targets[name] = joints
                case None:
                    self.variables[name] = variable
        else:
            return False
        return True

    def _extent(self, node: s.Expression) -> float | int | None:
        """Return one extent of an array: a number, or a constant that is one."""
        if isinstance(node, s.NameRef):
            return self._extents.get(node.name.lower())
        return literal_number(node)

    def variable(self, item: s.Data) -> Variable | None:
        """A variable, None if the pseudo-program has none of that kind."""
        type = VALUE_OF_TYPE.get(item.type.lower())
        if type is None:
            return None
        size = [self._extent(d) for d in item.dimensions]
        storage: Any = _STORAGES.get(item.storage)  # none in a damaged text
        if storage is None or not all(isinstance(n, int) and n > 0 for n in size):
            return None
        initial = None if item.value is None else lift_expression(item.value, self.original)
        extents = tuple(n for n in size if isinstance(n, int))
        span = item.span and item.span.moved(self.start)
        return Variable(type, initial, extents, storage, item.scope == "LOCAL", span)


def _value_of_other_name(table: ValueNames[T], item: s.Data, known: Mapping[str, T]) -> T | None:
    """The value of data that have the one of other data, which are constant; None for others."""
    if not isinstance(item.value, s.NameRef):
        return None
    low = item.value.name.lower()
    return known.get(low, table.predefined.get(low))


def _constant_extents(modules: Sequence[s.Module]) -> Iterator[tuple[str, int]]:
    """Constant whole numbers, which extents of arrays may be, by lower-case name."""
    for module in modules:
        for item in module.items:
            if isinstance(item, s.Data) and item.storage == "CONST" and not item.dimensions:
                value = literal_number(item.value) if item.value is not None else None
                if isinstance(value, int):
                    yield item.name.lower(), value


def fixed_target(variable: Variable) -> Target | JointTarget | None:
    """The target that a variable always is, None if it is one that can be assigned or no target."""
    if variable.storage != "constant" or variable.size:
        return None
    match variable.initial:
        case e.TargetValue(target):
            return target
        case e.JointValue(joints):
            return joints
    return None


def _assigned_names(modules: Sequence[s.Module]) -> set[str]:
    """Names in lower case of data that a statement assigns to, or that a call may change."""
    items = (item for module in modules for item in module.items)
    if any(isinstance(i, s.Data) and i.type.lower() in _NAMED_VALUE_TYPES for i in items):
        return changed_names(modules)
    return set()


_NAMED_VALUE_TYPES: Final = ("speeddata", "zonedata")
"""Types of data that the pseudo-program holds only if they are constant."""
_NAMED_ITEMS: Final = (s.Data, s.Routine, s.Record, s.Alias)
_MOVE_KINDS: Final = {0: "joint", 1: "linear"}
_PATH_KINDS: Final = np.array([Kind.JOINT, Kind.LINEAR, Kind.END], dtype=np.uint8)

_MOST_WRITTEN: Final = 100
"""Moves in a row to targets that are written out; more are a path, whose targets have names."""

Motions = Callable[[str, str, str, str], p.Motion]


class PathLift:
    """Which targets moves go through, and how often anything names them."""

    def __init__(
        self, modules: Sequence[s.Module], data: DataLift, original: Callable[[str], str]
    ) -> None:
        self.data, self.original = data, original
        runs = [i.run for m in modules for i in m.items if isinstance(i, s.TargetRunNode)]
        self.table = joined_runs(
            [TargetRun(Names.none(0), np.empty((0, TARGET_PARTS[-1][1]))), *runs]
        )
        self.known = NamedTargets(self.table.names)
        self._taken = TakenNames(
            i.name for m in modules for i in m.items if isinstance(i, _NAMED_ITEMS)
        )
        # Without runs there are no targets to count.
        seen = list(nodes(tuple(modules))) if runs else []
        named = (node.name for node in seen if isinstance(node, s.NameRef))
        # Names in columns are ASCII, so others cannot be targets of a run.
        self.known.count(Names.of([name for name in named if name.isascii()]))
        for run in (node.run for node in seen if isinstance(node, s.MoveRunNode)):
            self.known.count(run.names)
            self.known.count(run.vias)

    def statements(self, node: s.MoveRunNode, motion: Motions) -> Iterator[p.Statement]:
        run, index, spans = node.run, node.run.motions.index, node.row_span
        motions = [motion(m.speed, m.zone, m.tool, m.frame) for m in run.motions.table]
        if run.values is not None and len(run) > _MOST_WRITTEN and _have_orientations(run.values):
            name = identifier("written", self._taken)  # the program gives these targets no names
            self._taken.add(name)
            whole = _path(name, run.values, run.kinds, index, motions)
            yield p.Follow(replace(whole, places=node.rows), span=node.span)
            return
        if run.values is not None:
            each = zip(run.values.tolist(), index, run.kinds, strict=True)
            for at, (values, row, kind) in enumerate(each):
                word: Any = _MOVE_KINDS[int(kind)]
                yield p.Move(word, _target_value(values), motions[row], span=spans(at))
            return
        rows = PathRows(run.names, run.vias, run.kinds == CIRCULAR, _PATH_KINDS[run.kinds])
        places, alone = self.known.alone(rows.names)
        for part in rows.stretches(alone):
            path = self._path(rows, part, places, index, motions) if part.numbered else None
            moves = rows.moves[part.start : part.stop]
            if path is not None:
                span = span_over(spans(int(moves[0])), spans(int(moves[-1])))
                yield p.Follow(replace(path, places=_relative_spans(node, moves)), span=span)
                continue
            made = rows.one_by_one(part, self.original, lambda move: motions[index[move]])
            for move, one in zip(np.unique(moves).tolist(), made, strict=True):
                yield replace(one, span=spans(move))

    def _path(
        self,
        rows: PathRows,
        part: Stretch,
        places: Rows,
        index: NDArray[np.int32],
        motions: Sequence[p.Motion],
    ) -> Path | None:
        taken = slice(part.start, part.stop)
        at = places[taken]
        stem = rows.names.stems[rows.names.stem[part.start]].decode("ascii")
        # Paths name their targets `name_1` and so on; other numbered names are not theirs.
        if not stem.endswith("_") or len(stem) < 2:
            return None
        values = values_at(at, self.table.values)
        if not _have_orientations(values):
            return None
        # These targets belong to the path, so the program does not list them once more.
        self.known.taken[at] = True
        name = self.original(stem[:-1])
        return _path(name, values, rows.kinds[taken], index[rows.moves[taken]], motions)

    def targets(self) -> dict[str, Target]:
        """The targets that are in no path."""
        left = dict(self.data.targets)
        for row in np.flatnonzero(~self.known.taken):
            name = self.original(self.table.names.name(int(row)))
            values = [float(v) for v in self.table.values[row]]
            if any(values[3:7]):
                left[name] = target(values)
                continue
            # A target without an orientation is no pose, but a program may assign it one.
            self.data.variables[name] = Variable("position", _target_value(values), (), "constant")
        return left


def _relative_spans(node: s.MoveRunNode, moves: Rows) -> Rows | None:
    """Spans of some moves of a run, counted from the first of them."""
    return None if node.rows is None else node.rows[moves] - node.rows[moves[0], 0]


def _target_value(values: Sequence[float]) -> e.Expression:
    """Return a robtarget as an expression; one without orientation becomes plain numbers."""
    if any(values[3:7]):
        return e.TargetValue(target(values))
    return e.Aggregate(
        tuple(e.Aggregate(tuple(map(e.Number, values[a:b]))) for a, b in TARGET_PARTS)
    )


def _have_orientations(values: Floats) -> bool:
    """True if every target has an orientation."""
    return bool(values[:, 3:7].any(axis=1).all())


def _path(
    name: str,
    values: Floats,
    kinds: NDArray[np.uint8],
    motion: NDArray[np.int32],
    motions: Sequence[p.Motion],
) -> Path:
    """values: (n, 17) as of a TargetRun. motion: (n,) rows of motions."""
    return Path.of(
        name,
        values[:, 0:3],
        rotations.canonical(values[:, 3:7]),
        kinds=kinds,
        configurations=configurations(values[:, 7:11]),
        # 9E9 marks an axis that is not used.
        external=np.where(values[:, 11:17] >= UNUSED, np.nan, values[:, 11:17]),
        **setting_columns(motions, motion),
    )


def configurations(confdata: Floats) -> NDArray[np.int8]:
    """Neutral columns; unstated where confdata are no small whole numbers."""
    sane = ((np.abs(confdata) <= 127) & (confdata == np.rint(confdata))).all(axis=1)
    # Unsound rows are computed as zeros and marked afterwards.
    columns = from_confdata(np.where(sane[:, None], confdata, 0))
    columns[~sane, 0] = UNSTATED
    return columns

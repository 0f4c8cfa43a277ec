"""Lines gathered into columns, and the position variables of a file by name or by column.

`gathered` puts neighbouring lines of one kind into the columns that the parser reads them as;
`Positions` finds the values of a file's position variables: X, Y, Z in mm, A, B, C in degrees.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Ints, Truths
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import (
    FEWEST,
    KEYWORDS,
    MVR,
    MoveRows,
    PositionRows,
)
from assistant.languages.melfa_basic.tree.walk import literal
from assistant.languages.runs import columns as alike
from assistant.languages.runs.columns import joined_runs, sorted_rows
from assistant.program import expressions as e
from assistant.program.geometry import UNUSED_AXIS, JointTarget, Pose, Target
from assistant.program.motion import UNSTATED, configuration_of

if TYPE_CHECKING:
    from assistant.robots import Robot


_NUMBERED: Final = re.compile(r"([A-Za-z][A-Za-z_]*)(0|[1-9][0-9]{0,8})")


def split_name(variable: s.Expression | None) -> tuple[str, int] | None:
    """Stem and number of a plain variable such as `P12`, None for any other expression."""
    if not isinstance(variable, s.Variable):
        return None
    if variable.suffix or variable.arguments is not None or variable.component:
        return None
    return split_numbered(variable.name)


def split_numbered(name: str) -> tuple[str, int] | None:
    """Stem and number of a name such as `P12`, None for any other."""
    found = _NUMBERED.fullmatch(name)
    return (found.group(1), int(found.group(2))) if found else None


def gathered(items: Iterable[s.Item]) -> Iterator[s.Item]:
    """The same lines, neighbours of one stem as one table, lone ones as lines."""
    listed = list(items)
    for item in alike.gather_runs(
        listed, map(_table_row, listed), _table_of_rows, lambda _, run: run, FEWEST
    ):
        # A table that is left with a single row is a line, as the parser would read it.
        if isinstance(item, MoveRows | PositionRows) and 0 < len(item) < FEWEST:
            yield from rows_as_lines(item)
        else:
            yield item


def _table_row(item: s.Item) -> alike.Row | None:
    """Return the table that a line may be a row of, and its values there; None if it is not
    plain.
    """
    match item:
        case MoveRows(stem=stem) if len(item):
            return (MoveRows, stem), item
        case PositionRows(stem=stem, values=values) if len(item):
            return (PositionRows, stem, values.shape[1]), item
        # Labels, comments and appended statements have no column.
        case s.Line(
            label=None,
            statement=s.Motion(keyword=keyword, arguments=arguments, type=None, append=None),
            comment=None,
        ) if keyword in KEYWORDS:
            found = [name for name in map(split_name, arguments) if name is not None]
            wanted = 3 if keyword == KEYWORDS[MVR] else 1
            if len({stem for stem, _ in found}) != 1 or not len(arguments) == len(found) == wanted:
                return None
            # Moves other than arcs have no start and no via, which -1 stands for.
            stem, numbers = found[0][0], [-1, -1, *(number for _, number in found)][-3:]
            row = [item.number or 0, KEYWORDS.index(keyword), *numbers]
            return (MoveRows, stem), (stem, row)
        case s.Data(variable=variable, value=s.Constant(values=values, flags=flags), type=""):
            name = split_name(variable)
            if name is None or flags is None or len(values) not in (6, 7, 8):
                return None
            if None in values or None in flags:
                return None
            return (PositionRows, name[0], len(values)), (*name, values, flags)
    return None


def _table_of_rows(rows: list[Any]) -> MoveRows | PositionRows:
    stem, *columns = zip(*rows, strict=True)
    if len(columns) == 1:
        return MoveRows(stem[0], *np.array(columns[0], dtype=np.int64).T)
    numbers, values, flags = columns
    return PositionRows(
        stem[0],
        np.array(numbers, dtype=np.int64),
        np.array(values, dtype=np.float64),
        np.array(flags, dtype=np.int64),
    )


def position_rows(item: s.Item) -> PositionRows | None:
    """A plain position line as a table of one row, a table as it is, None for anything else."""
    if isinstance(item, PositionRows):
        return item if len(item) else None
    row = _table_row(item) if isinstance(item, s.Data) else None
    table = None if row is None else _table_of_rows([row[1]])
    return table if isinstance(table, PositionRows) else None


def rows_as_lines(rows: MoveRows | PositionRows) -> Iterator[s.Line | s.Data]:
    """The rows as the nodes that the grammar gives for their lines; for few, not for many."""

    def variable(number: int) -> s.Variable:
        return s.Variable(f"{rows.stem}{number}")

    if isinstance(rows, PositionRows):
        for number, values, flags in zip(rows.numbers, rows.values, rows.flags, strict=True):
            numbers = tuple(float(v) for v in values)
            constant = s.Constant(numbers, (int(flags[0]), int(flags[1])))
            yield s.Data(variable(int(number)), constant)
        return
    columns = (rows.steps, rows.kinds, rows.start, rows.via, rows.end)
    for step, kind, *numbers in np.stack(columns, axis=1).tolist():
        places = tuple(variable(number) for number in numbers if number >= 0)
        yield s.Line(step or None, None, s.Motion(KEYWORDS[kind], places))


NO_FLAGS: Final = -1

Elements = dict[tuple[int, ...], s.Constant]
"""Constants of an array by their indices."""

Plain = dict[tuple[int, ...], e.Expression]
"""Numbers and texts of an array by their indices; of a single variable by none."""


class Positions:
    """Values (n, 8), NaN where undefined, and flags (n, 2), NO_FLAGS where absent.

    names: single constants, by name in upper case, in their order. elements: those of arrays, by
    name in upper case. plain: numbers and texts that the file keeps, likewise.
    """

    def __init__(self, file: s.File) -> None:
        self.names: dict[str, tuple[str, s.Constant]] = {}
        self.tables: dict[str, list[PositionRows]] = {}
        self.elements: dict[str, tuple[str, Elements]] = {}
        self.plain: dict[str, tuple[str, Plain]] = {}
        for item in file.items:
            match item:
                case PositionRows():
                    self.tables.setdefault(item.stem.upper(), []).append(item)
                case s.Data(variable=variable, value=s.Constant() as constant):
                    # The tools write a position that was never taught with zeros and empty flags.
                    undefined = constant.flags == (None, None) and not any(constant.values)
                    if variable.arguments is None and not undefined:
                        self.names.setdefault(variable.key, (variable.name, constant))
                    at = _element_indices(variable)
                    if at and not undefined:
                        known = self.elements.setdefault(variable.key, (variable.name, {}))
                        known[1][at] = constant
                case s.Data(variable=variable, value=value) if (
                    kept := _stored_value(value)
                ) is not None:
                    values = self.plain.setdefault(variable.key, (variable.name, {}))
                    values[1][_element_indices(variable)] = kept
        single: dict[str, list[tuple[int, s.Constant]]] = {stem: [] for stem in self.tables}
        for key, (_, constant) in self.names.items():
            name = split_name(s.Variable(key))
            if name is not None:
                single.setdefault(name[0].upper(), []).append((name[1], constant))
        self.columns = {stem: self._columns(stem, found) for stem, found in single.items()}

    def _columns(self, stem: str, single: Sequence[tuple[int, s.Constant]]) -> PositionRows:
        """The positions of a stem in the order of their numbers."""
        parts = [PositionRows(stem, np.empty(0, np.int64), np.empty((0, 8)), np.empty((0, 2), int))]
        for rows in self.tables.get(stem, ()):
            wide = np.full((len(rows), 8), np.nan)
            wide[:, : rows.values.shape[1]] = rows.values
            parts.append(replace(rows, values=wide))
        # A table holds positions; joints are found by their names alone.
        for at, constant in single if stem[0] == "P" else ():
            parts.append(PositionRows(stem, np.array([at]), *_constant_row(constant)))
        table = joined_runs(parts)
        return table.rows(np.argsort(table.numbers, kind="stable"))

    @cached_property
    def slides(self) -> bool:
        """True if a position states an additional axis other than 0."""
        alone = (constant for _, constant in self.names.values())
        inside = (one for _, kept in self.elements.values() for one in kept.values())
        if any(any(one.values[6:]) for one in (*alone, *inside)):
            return True
        tables = (rows.values[:, 6:] for found in self.tables.values() for rows in found)
        return any(bool(np.nan_to_num(axes).any()) for axes in tables)

    def find(self, stem: str, numbers: Ints) -> tuple[Floats, Ints, Truths]:
        """Values, flags and whether there are any, of the positions of these numbers."""
        known = self.columns.get(stem.upper())
        if known is None or not len(known):
            n = len(numbers)
            return np.full((n, 8), np.nan), np.zeros((n, 2), np.int64), np.zeros(n, bool)
        at = sorted_rows(known.numbers, numbers)
        return known.values[at], known.flags[at], at >= 0

    def constant(self, name: str) -> s.Constant | None:
        """The constant of one variable."""
        if name.upper() in self.names:
            return self.names[name.upper()][1]
        split = split_name(s.Variable(name))
        if split is None or split[0].upper() not in self.tables:
            return None
        values, flags, found = self.find(split[0], np.array([split[1]]))
        if not found[0]:
            return None
        numbers = tuple(float(v) for v in values[0] if v == v)
        return s.Constant(numbers, (int(flags[0, 0]), int(flags[0, 1])))

    def spelling(self, key: str) -> str:
        """A name, given in upper case, as the file spells it."""
        return self.names[key][0] if key in self.names else key

    def all_names(self) -> Iterator[str]:
        """Every name as written, tables expanded."""
        for written, _ in self.names.values():
            yield written
        for tables in self.tables.values():
            for rows in tables:
                for number in rows.numbers.tolist():
                    yield f"{rows.stem}{number}"


def _element_indices(variable: s.Variable) -> tuple[int, ...]:
    """Return the indices of an element of an array; empty for a single variable."""
    return tuple(int(a.value) for a in variable.arguments or () if isinstance(a, s.Number))


def _stored_value(value: s.Expression) -> e.Expression | None:
    """Return the number or text stored for a variable."""
    if isinstance(value, s.String):
        return e.Text(value.value)
    number = literal(value)
    return None if number is None else e.Number(number)


def _constant_row(constant: s.Constant) -> tuple[Floats, Ints]:
    values = np.full((1, 8), np.nan)
    for i, value in enumerate(constant.values[:8]):
        values[0, i] = np.nan if value is None else value
    one, two = constant.flags or (None, None)
    if one is None:
        return values, np.array([[NO_FLAGS, 0]])
    return values, np.array([[one, two or 0]])


def configurations(flags: Ints, robot: Robot | None) -> NDArray[np.int8]:
    """(n, 6) neutral columns; UNSTATED where there are no flags."""
    absent = flags[:, 0] == NO_FLAGS
    # Rows without flags need any valid ones for the conversion; they are marked below.
    columns = poses.configurations_of(np.where(absent[:, None], 7, flags), robot)
    columns[absent] = (UNSTATED, 0, 0, 0, 0, 0)
    return columns


def target_of(constant: s.Constant, robot: Robot | None) -> Target:
    values, flags = _constant_row(constant)
    position, quaternion, external = poses.from_values(values, robot)
    configuration = configuration_of(configurations(flags, robot)[0])
    pose = Pose.of(position[0], quaternion[0])
    return Target(pose, configuration, tuple(float(v) for v in external[0]))


def joints_of(constant: s.Constant, robot: Robot | None) -> JointTarget:
    values = [0.0 if v is None else v for v in constant.values]
    joints, more = values[:6], values[6:8]
    # Arms of fewer axes leave places of their joints empty.
    if robot is not None and len(robot.axes) < 6 and len(joints) > max(robot.places):
        joints = [joints[place] for place in robot.places]
    return JointTarget(tuple(joints), tuple([*more, *[UNUSED_AXIS] * 6][:6]))

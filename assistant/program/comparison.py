"""Comparison of two pseudo-programs: equal or not, and by how much their targets differ."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field, fields, is_dataclass, replace
from typing import Any, Final, TypeAlias

import numpy as np

from assistant.base import rotations
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Inner, Span
from assistant.program import statements as p
from assistant.program.geometry import Pose
from assistant.program.motion import Path
from assistant.program.program import Procedure, Program, walk
from assistant.program.pseudo.printer import part_text
from assistant.program.rewriting import Body, map_bodies

_MOST_MISMATCHES: Final = 20
"""After so many the comparison stops: the first ones tell what is wrong."""


@dataclass(frozen=True, slots=True)
class Tolerance:
    """Allowed differences: mm per component, degrees of rotation, relative for other numbers."""

    position: float = 0.0
    angle: float = 0.0
    number: float = 0.0


@dataclass(frozen=True, slots=True)
class Mismatch:
    """A difference between two programs.

    about: its position in the program. message: the found and the expected value. span: of the
    statement or procedure that contains it, as in the expected program.
    """

    about: Inner
    message: str
    span: Span | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Comparison:
    """statements, targets: how many were compared, a row of a path counting as one of each.

    position, angle: the largest deviation of a target in mm and degrees, and where it is.
    """

    statements: int
    targets: int
    position: float
    angle: float
    worst: str
    mismatches: tuple[Mismatch, ...]

    @property
    def same(self) -> bool:
        return not self.mismatches


_Steps: TypeAlias = tuple[str, ...]
"""The fields, names and rows that lead to a part of a program, see `Inner`."""
_EXACT: Final = Tolerance()


def compare(expected: Program, actual: Program, tolerance: Tolerance = _EXACT) -> Comparison:
    """Compares every declaration and statement of two programs.

    Procedures are matched by name, so that their order in the text does not count.
    """
    walk = _Walk(tolerance)
    for part in fields(Program):
        if part.name != "procedures" and part.compare:
            walk.value(getattr(expected, part.name), getattr(actual, part.name), (part.name,))
    walk.value(_by_name(expected), _by_name(actual), ("procedure",))
    return Comparison(
        sum(1 for _ in expected.statements()) + walk.rows,
        walk.targets,
        walk.position,
        walk.angle,
        str(Inner(walk.worst)),
        tuple(walk.mismatches),
    )


def with_labels_in_order(program: Program) -> Program:
    """The program with its labels called by their order, to compare whatever they were called."""
    listed = (node for procedure in program.procedures for node in walk(procedure.body))
    names = dict.fromkeys(node.name for node in listed if isinstance(node, p.Label))
    order = {name: f"L{at}" for at, name in enumerate(names)}

    def renamed(body: Body) -> Body:
        return tuple(_relabelled(map_bodies(node, renamed), order) for node in body)

    procedures = (replace(one, body=renamed(one.body)) for one in program.procedures)
    return replace(program, procedures=tuple(procedures))


def _relabelled(node: p.Statement, order: Mapping[str, str]) -> p.Statement:
    match node:
        case p.Label(name):
            return replace(node, name=order[name])
        case p.Goto(label):
            return replace(node, label=order.get(label, label))
    return node


def _by_name(program: Program) -> dict[str, Procedure]:
    return {procedure.name: procedure for procedure in program.procedures}


@dataclass
class _Walk:
    tolerance: Tolerance
    targets: int = 0
    rows: int = 0
    position: float = 0.0
    angle: float = 0.0
    worst: _Steps = ()
    mismatches: list[Mismatch] = field(default_factory=list)
    span: Span | None = None

    def value(self, expected: Any, actual: Any, steps: _Steps) -> None:
        """Any part of a program; records, tuples and tables are compared part by part."""
        if len(self.mismatches) >= _MOST_MISMATCHES:
            return
        # The innermost statement with a span is where a mismatch is reported.
        around, self.span = self.span, getattr(expected, "span", None) or self.span
        self._value(expected, actual, steps)
        self.span = around

    def _value(self, expected: Any, actual: Any, steps: _Steps) -> None:
        if isinstance(expected, (int, float)) and isinstance(actual, (int, float)):
            self._number(expected, actual, steps)
        elif type(expected) is not type(actual):
            self._differ(steps, _short(expected), _short(actual))
        elif isinstance(expected, Path):
            self._path(expected, actual, ("path", expected.name))
        elif isinstance(expected, Pose):
            self.targets += 1
            self._poses(
                np.array([expected.position, actual.position]),
                np.array([expected.quaternion, actual.quaternion]),
                steps,
            )
        elif isinstance(expected, Mapping):
            self._table(expected, actual, steps)
        elif isinstance(expected, tuple):
            if len(expected) != len(actual):
                self._differ(steps, f"{len(expected)} items", f"{len(actual)} items")
            for i, (mine, theirs) in enumerate(zip(expected, actual, strict=False), 1):
                self.value(mine, theirs, (*steps, str(i)))
        elif is_dataclass(expected):
            for part in fields(expected):
                if part.compare:
                    self.value(
                        getattr(expected, part.name),
                        getattr(actual, part.name),
                        (*steps, part.name),
                    )
        elif expected != actual:
            self._differ(steps, _short(expected), _short(actual))

    def _number(self, expected: float, actual: float, steps: _Steps) -> None:
        # True equals 1 in Python, but not in a program.
        if isinstance(expected, bool) is not isinstance(actual, bool):
            self._differ(steps, _short(expected), _short(actual))
        elif math.isnan(expected) or math.isnan(actual):
            if math.isnan(expected) is not math.isnan(actual):
                self._differ(steps, _short(expected), _short(actual))
        elif not math.isclose(
            expected, actual, rel_tol=self.tolerance.number, abs_tol=self.tolerance.number
        ):
            self._differ(steps, _short(expected), _short(actual))

    def _table(self, expected: Mapping[str, Any], actual: Mapping[str, Any], steps: _Steps) -> None:
        for name in expected.keys() - actual.keys():
            self._differ((*steps, name), "it", "nothing")
        for name in actual.keys() - expected.keys():
            self._differ((*steps, name), "nothing", "it")
        for name, mine in expected.items():
            if name in actual:
                self.value(mine, actual[name], (*steps, name))

    def _poses(
        self,
        positions: np.ndarray[Any, np.dtype[np.float64]],
        quaternions: np.ndarray[Any, np.dtype[np.float64]],
        steps: _Steps,
    ) -> None:
        """Positions (2, …, 3) and quaternions (2, …, 4), expected before actual."""
        apart = np.abs(positions[0] - positions[1]).reshape(-1, 3)
        turned = rotations.angle_between(quaternions[0], quaternions[1]).reshape(-1)
        distance = np.linalg.norm(apart, axis=1)
        many = len(distance) > 1
        row = int(distance.argmax())
        if distance[row] > self.position:
            self.position = float(distance[row])
            self.worst = (*steps, f"row {row + 1}") if many else steps
        self.angle = max(self.angle, float(turned.max(initial=0.0)))
        # NaN must not pass as within the tolerance
        off = ~((apart.max(axis=1) <= self.tolerance.position) & (turned <= self.tolerance.angle))
        for row in np.flatnonzero(off)[:_MOST_MISMATCHES]:
            where = (*steps, f"row {row + 1}") if many else steps
            self._differ(where, "the pose", f"one {distance[row]:.4g} mm, {turned[row]:.4g}° away")

    def _path(self, expected: Path, actual: Path, steps: _Steps) -> None:
        self.value(expected.name, actual.name, (*steps, "name"))
        if len(expected) != len(actual):
            self._differ(steps, f"{len(expected)} targets", f"{len(actual)} targets")
            return
        if not len(expected):
            return
        self.targets += len(expected)
        self.rows += len(expected)
        for start in range(0, len(expected), 65536):  # keeps the memory of a long path flat
            mine, theirs = (p.rows(start, start + 65536) for p in (expected, actual))
            label = (*steps, f"from row {start + 1}") if start else steps
            self._poses(
                np.stack([mine.positions, theirs.positions]),
                np.stack([mine.quaternions, theirs.quaternions]),
                label,
            )
            self._columns(mine, theirs, label)

    def _columns(self, mine: Path, theirs: Path, steps: _Steps) -> None:
        for column in ("kinds", "configurations"):
            equal = getattr(mine, column) == getattr(theirs, column)
            self._rows(np.flatnonzero(~equal.reshape(len(mine), -1).all(axis=1)), column, steps)
        close = np.isclose(
            mine.external,
            theirs.external,
            rtol=0.0,
            atol=self.tolerance.position,
            equal_nan=True,
        )
        self._rows(np.flatnonzero(~close.all(axis=1)), "external axes", steps)
        for column in ("speed", "blend", "tool", "frame"):
            table, other = getattr(mine, column + "s"), getattr(theirs, column + "s")
            # Pairs of table entries instead of rows: few tables, many rows.
            paired = getattr(mine, column) * len(other) + getattr(theirs, column)
            for pair in np.flatnonzero(np.bincount(paired)):
                first, second = divmod(int(pair), len(other))
                self.value(table[first], other[second], (*steps, column))

    def _rows(self, rows: np.ndarray[Any, np.dtype[np.intp]], column: str, steps: _Steps) -> None:
        if len(rows):
            self._differ(
                (*steps, f"row {rows[0] + 1}"), column, f"other {column} in {len(rows)} rows"
            )

    def _differ(self, steps: _Steps, expected: str, actual: str) -> None:
        self.mismatches.append(Mismatch(Inner(steps), f"{expected} became {actual}", self.span))


def _short(value: object) -> str:
    text = part_text(value)
    return text if len(text) <= 120 else text[:117] + "…"

"""Points of contours as offsets of their starts, and long paths as arrays of targets.

What stays as it is, as nobody could read it otherwise or it would not be the same, is a finding.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from assistant.base.diagnostics import Declared, Diagnostic, warning
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import declared
from assistant.program.geometry import Target
from assistant.program.motion import Kind, Path, configuration_row
from assistant.program.passes.paths import COLUMNS, move_at
from assistant.program.program import Program, TakenNames, Variable, identifier
from assistant.program.rewriting import map_expressions, records

STAYS_PLAIN: Final = warning(
    "CO621",
    "the points of {paths} stay targets instead of {points}: {why}",
    '{cure}, or write points = "targets" in [style]',
)
_COUNTER: Final = "i"
_LONG: Final = 8
"""Rows of a path from which on it is an array."""
_LOOP: Final = 3
"""Rows under the same settings from which on they are a loop."""
_MOST_POINTS: Final = 5000
"""Rows up to which a path gets another form; nobody reads longer ones."""
_START: Final = "_start"
"""End of the name of the target where a contour begins."""
_SAME: Final = 1e-9
"""Difference of external axes that counts as none."""
_DECIMALS: Final = 4
"""Decimals of mm of offsets."""
_NEAR: Final = 1e-6
"""Difference of quaternions, 1 - |a·b|, that counts as none."""
_NEIGHBOURS: Final = 12
"""Statements before and after a move among which the path of its contour is."""
_TOO_LONG: Final = f"it has more than {_MOST_POINTS} points", "divide it"
"""Why a path keeps its targets, and the cure."""


class _Points:
    """Base of the forms of points.

    left: names of the paths that keep targets, by the reason and its cure.
    """

    form: str

    def __init__(self, given: Program) -> None:
        self.given = given
        self.taken = taken_names(given)
        self.left: dict[tuple[str, str], list[str]] = {}

    def keep(self, path: Path, why: str, cure: str) -> None:
        """Note that a path keeps its targets."""
        self.left.setdefault((why, cure), []).append(path.name)

    def findings(self) -> tuple[Diagnostic, ...]:
        return tuple(
            STAYS_PLAIN(
                paths=_in_words(names), points=self.form, why=why, cure=cure,
                about=Declared(names[0], "paths"),
            )
            for (why, cure), names in self.left.items()
        )  # fmt: skip


def _in_words(paths: list[str]) -> str:
    more = len(paths) - 1
    return f"`{paths[0]}`" + (f" and {more} more path{'s' * (more != 1)}" if more else "")


class OffsetForm(_Points):
    """Targets of contours as offsets of their starts."""

    form = "offsets"

    def program(self) -> tuple[Program, tuple[Diagnostic, ...]]:
        uses = Counter(
            name
            for procedure in self.given.procedures
            for name in {x.name.lower() for x in records(procedure) if isinstance(x, e.Name)}
        )
        self.targets = {name.lower(): one for name, one in self.given.targets.items()}
        self.once = {name for name in self.targets if uses[name] == 1}
        self.gone: set[str] = set()
        procedures = tuple(
            replace(one, body=tuple(self.body(one.body))) for one in self.given.procedures
        )
        kept = {n: t for n, t in self.given.targets.items() if n.lower() not in self.gone}
        program = replace(self.given, procedures=procedures, targets=kept)
        return (program if self.gone or self.changed else self.given), self.findings()

    changed = False

    def body(self, body: tuple[p.Statement, ...]) -> Iterator[p.Statement]:
        start = ""
        for at, node in enumerate(body):
            # The approach above a start is the first statement that names it.
            begun = _start_named(node)
            start = begun or start
            if isinstance(node, p.Follow):
                why = self.unfit(node.path, start)
                if why is None:
                    self.changed = True
                    yield from self.moves(node, start)
                    continue
                self.keep(node.path, *why)
            elif start and not begun and isinstance(node, p.Move | p.MoveCircular):
                if not self.keeps_targets(body, at, start):
                    node = map_expressions(node, partial(self.target, start))
            yield node

    def keeps_targets(self, body: tuple[p.Statement, ...], at: int, start: str) -> bool:
        """True if the path of the contour of a move keeps its targets."""
        around = body[max(at - _NEIGHBOURS, 0) : at + _NEIGHBOURS]
        near = [x for x in around if isinstance(x, p.Follow)]
        return any(
            _is_of(x.path.name, start) and self.unfit(x.path, start) is not None for x in near
        )

    def unfit(self, path: Path, start: str) -> tuple[str, str] | None:
        """Return why a path cannot be offsets, and the cure; None if it can."""
        if not start:
            return "no target has a name where it starts, as contours of a drawing have one", (
                "follow contours of a drawing"
            )
        if len(path) > _MOST_POINTS:
            return _TOO_LONG
        base = self.targets[start.lower()]
        turn = np.array(base.pose.quaternion)
        if np.abs(np.abs(path.quaternions @ turn) - 1.0).max(initial=0.0) > _NEAR:
            return "the tool turns on the path, and offsets only shift", "leave out `tangential`"
        wanted = configuration_row(base.configuration)
        if (path.configurations != np.array(wanted, dtype=np.int8)).any():
            return "the arm changes its configuration on the path, and offsets keep it", (
                "place the work where one configuration reaches all of the path"
            )
        mine = np.array([np.nan if x is None else x for x in base.external], dtype=np.float64)
        if not np.isclose(path.external, mine, rtol=0.0, atol=_SAME, equal_nan=True).all():
            return "external axes move on the path, and offsets keep them", "keep them still"
        return None

    def moves(self, node: p.Follow, start: str) -> Iterator[p.Statement]:
        path = node.path
        base = np.array(self.targets[start.lower()].pose.position)
        shifts = np.round(path.positions - base, _DECIMALS) + 0.0
        via: e.Expression | None = None
        for row, (kind, shift) in enumerate(zip(path.kinds.tolist(), shifts.tolist(), strict=True)):
            point = _offset(start, shift)
            if kind == Kind.VIA:
                via = point
            elif kind == Kind.END and via is not None:
                motion = move_at(path, row, point).motion
                yield p.MoveCircular(via, point, motion, span=node.span)
            else:
                yield replace(move_at(path, row, point), span=node.span)

    def target(self, start: str, value: e.Expression) -> e.Expression:
        """Return another target of a contour as an offset of its start, if it is only shifted."""
        if not isinstance(value, e.Name) or value.name.lower() not in self.once - {start.lower()}:
            return value
        if not value.name.lower().startswith(start.lower().removesuffix(_START) + "_"):
            return value
        base, other = self.targets[start.lower()], self.targets[value.name.lower()]
        if not _is_shifted(base, other):
            return value
        self.changed = True
        self.gone.add(value.name.lower())
        shift = np.array(other.pose.position) - np.array(base.pose.position)
        return _offset(start, (np.round(shift, _DECIMALS) + 0.0).tolist())


def _is_of(path: str, start: str) -> bool:
    """True if a path, or a part of one, belongs to the contour that has a start."""
    return f"{path.lower()}_".startswith(start.lower().removesuffix(_START) + "_")


def _start_named(node: p.Statement) -> str:
    """Return the start of a contour that a move goes to, or to a position above it; else empty."""
    target = node.target if isinstance(node, p.Move) else None
    while isinstance(target, e.Apply) and target.arguments:
        target = target.arguments[0]
    named = isinstance(target, e.Name) and target.name.lower().endswith(_START)
    return target.name if named and isinstance(target, e.Name) else ""


def _offset(start: str, shift: list[float]) -> e.Expression:
    if not any(shift):
        return e.Name(start)
    return e.Apply("offset", (e.Name(start), *map(e.number_of, shift)))


def _is_shifted(one: Target, other: Target) -> bool:
    """True if two targets differ by their positions alone."""
    turned = abs(float(np.dot(one.pose.quaternion, other.pose.quaternion)))
    return (
        abs(turned - 1.0) <= _NEAR
        and one.configuration == other.configuration
        and np.array_equal(np.array(one.external), np.array(other.external), equal_nan=True)
    )


class ArrayForm(_Points):
    """Long paths as arrays of targets, with loops along rows under the same settings."""

    form = "arrays"

    def program(self) -> tuple[Program, tuple[Diagnostic, ...]]:
        self.made: dict[str, Variable] = {}
        procedures = tuple(
            replace(one, body=tuple(x for node in one.body for x in self.statement(node)))
            for one in self.given.procedures
        )
        if not self.made:
            return self.given, self.findings()
        variables = {**self.given.variables, **self.made}
        program = replace(self.given, procedures=procedures, variables=variables)
        return program, self.findings()

    def statement(self, node: p.Statement) -> Iterator[p.Statement]:
        if not isinstance(node, p.Follow) or len(node.path) < _LONG:
            yield node
            return
        path = node.path
        if len(path) > _MOST_POINTS:
            self.keep(path, *_TOO_LONG)
            yield node
            return
        name = identifier(f"{path.name}_points", self.taken)
        self.taken.add(name)
        values = tuple(e.TargetValue(path.target(row)) for row in range(len(path)))
        self.made[name] = Variable("position", e.Aggregate(values), (len(path),), "constant")
        yield from self.moves(node, name)

    def moves(self, node: p.Follow, name: str) -> Iterator[p.Statement]:
        path = node.path

        def element(index: e.Expression) -> e.Expression:
            return e.Index(e.Name(name), (index,))

        row = 0
        while row < len(path):
            if path.kinds[row] == Kind.VIA:
                via, end = element(e.Number(row + 1)), element(e.Number(row + 2))
                motion = move_at(path, row + 1, end).motion
                yield p.MoveCircular(via, end, motion, span=node.span)
                row += 2
                continue
            stop = _same_until(path, row)
            # The target before an arc is written out: after a loop, its index is not known.
            if stop < len(path) and path.kinds[stop] == Kind.VIA:
                stop -= 1
            if stop - row >= _LOOP:
                body = (replace(move_at(path, row, element(e.Name(_COUNTER))), span=node.span),)
                first, last = e.Number(row + 1), e.Number(stop)
                yield p.For(_COUNTER, first, last, body, p.ONE, span=node.span)
                row = stop
            else:
                yield replace(move_at(path, row, element(e.Number(row + 1))), span=node.span)
                row += 1


def _same_until(path: Path, row: int) -> int:
    """Return the first row after one that is another kind of move, or has other settings."""
    same = path.kinds[row:] == path.kinds[row]
    for column in COLUMNS:
        values = getattr(path, column)
        same = same & (values[row:] == values[row])
    other = np.flatnonzero(~same)
    return row + int(other[0]) if len(other) else len(path)


def taken_names(program: Program) -> TakenNames:
    """Return the names of a program that no constant or array may have."""
    taken = TakenNames((program.name, *declared(program)))
    taken.update(one.name for one in program.procedures)
    for node in program.statements():
        if isinstance(node, p.Follow):
            taken.add(node.path.name)
    return taken

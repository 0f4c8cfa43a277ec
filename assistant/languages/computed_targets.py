"""Targets that are worked out as the program runs, put together in a variable first.

For a language that has position constants of numbers only: `offset(p, 10*i, 0, 0)` is a copy of
`p` whose X is moved, in a position variable of the procedure.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.languages.records import target
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Configuration, Pose, Target
from assistant.program.passes.hoisted_statements import Taken, hoisted
from assistant.program.program import Procedure, Program, ValueType, Variable
from assistant.program.rewriting import head, map_expressions, map_head, records

AXES: Final = ("x", "y", "z")
WHOLE: Final = "trans"
"""The component of a position that is its X, Y and Z together."""


def with_computed_targets(program: Program) -> Program:
    """The program with variables for the targets that statements work out."""
    taken = {n.lower() for t in (program.variables, program.targets, program.signals) for n in t}
    taken |= {name.lower() for q in program.procedures for name in q.variables}
    made = tuple(_computed(procedure, taken) for procedure in program.procedures)
    return replace(program, procedures=made)


def _computed(procedure: Procedure, taken: set[str]) -> Procedure:
    taking = _Targets(taken)
    body = hoisted(procedure.body, taking)
    if body == procedure.body:
        return procedure
    return replace(procedure, body=body, variables={**procedure.variables, **taking.variables})


class _Targets:
    """Takes targets out of statements.

    taken: names (lower case) that a variable may not have. variables: those that it needed.
    """

    def __init__(self, taken: set[str]) -> None:
        self.taken = taken
        self.variables: dict[str, Variable] = {}
        self.known: dict[str, str] = {}
        self.end: e.Expression | None = None
        """The target of the last move, which the next arc starts at."""

    def __call__(self, node: p.Statement) -> Taken:
        made = self.taken_from(node)
        if isinstance(made.statement, p.MoveStatement):
            self.end = made.statement.target
        return made

    def taken_from(self, node: p.Statement) -> Taken:
        # Written out poses are worked out here, so that only values of the running program need
        # variables.
        node = map_head(node, _folded)
        made = Taken(node)
        # Places are counted anew for each statement, so that statements share their variables.
        used = 0
        elsewhere = _read_elsewhere(node)
        along = _along(node)

        # The points of an arc leave the variable alone that its start is in.
        kept = self.end if isinstance(node, p.MoveCircular) else None

        def free(stem: str) -> e.Name:
            nonlocal used
            used += 1
            if (place := self.place(stem, used)) in tuple(records(kept)):
                used += 1
                place = self.place(stem, used)
            return place

        def visit(value: e.Expression) -> e.Expression:
            nonlocal used
            if isinstance(value, e.PoseValue):
                used += 1
                place = self.place("pose", used, "pose")
                made.before.append(p.Assign(place, value))
                return place
            if value in elsewhere:
                place = free("at")
                made.before.append(p.Assign(place, value))
                return place
            parts, shift = _parts(value), _shift(value)
            if parts is not None:
                place = free("at")
                made.before += _put_together(place, *parts)
                return place
            if shift is not None:
                value, factors = shift
                for still, moved in factors:
                    place = free("by")
                    made.before += _put_together(place, still, moved, added=False)
                    value = e.Binary("@", value, place)
            return value

        match node:
            # The assignment is the very form that poses are put in.
            case p.Assign(e.Name() | e.Index(), e.PoseValue()):
                return made
            case p.Assign(place, value) if (parts := _parts(value)) is not None:
                base, components, added = parts
                plain = not elsewhere and not _inner(value)
                fits = isinstance(place, e.Name) or place == base
                own = base == place and not added
                # The target itself can hold the parts, without a variable in between.
                if plain and fits and _in_order(place, components, keeps=own):
                    made.after += _put_together(place, *parts)
                    if made.after:
                        # The first of several takes the place of the statement itself.
                        made.statement = made.after.pop(0)
                        return made
            case p.Assign(e.Member(place, field), value) if field.lower() == WHOLE:
                axes = _components(value)
                if axes is not None and _in_order(place, axes, keeps=True):
                    made.after += _assigned(place, axes)
                    made.statement = made.after.pop(0)
                    return made
                if axes is not None:
                    # A part needs the old value of an earlier one, so the new value is put together
                    # in a copy.
                    copy = self.place("at", 1)
                    made.before += (p.Assign(copy, place), *_assigned(copy, axes))
                    made.statement = replace(node, target=place, value=copy)
                    return made
        if along is None:
            made.statement = map_head(node, visit)
            return made
        # Both parts are visited as one value, and the move is put together again with what was made
        # of them.
        move = map_head(replace(along[0], target=e.Aggregate(along[1:])), visit)
        place, distance = move.target.items
        still = e.Number(0)
        made.statement = replace(move, target=e.Apply("relative", (place, still, still, distance)))
        return made

    def place(self, stem: str, number: int, type: ValueType = "position") -> e.Name:
        """A variable of the procedure for a place; the same ones serve every statement."""
        key = f"{stem}_{number}"
        if key not in self.known:
            free = (f"{stem}_{k}" for k in itertools.count(1))
            name = next(n for n in free if n not in self.taken)
            self.taken.add(name)
            self.known[key] = name
            self.variables[name] = Variable(type)
        return e.Name(self.known[key])


def _folded(value: e.Expression) -> e.Expression:
    """The inverse of a pose that is written out, and the product of two, worked out."""
    match value:
        case e.Apply("inverse", (e.PoseValue(pose),)):
            return e.PoseValue(pose.inverse())
        case e.Binary("@", e.PoseValue(one), e.PoseValue(two)):
            return e.PoseValue(one @ two)
    return value


def _read_elsewhere(node: p.Statement) -> set[e.Expression]:
    """Present positions that a statement reads in a tool or frame that cannot hold for it."""
    found = {r for r in records(head(node)) if isinstance(r, e.Here)}
    if isinstance(node, p.MoveStatement):
        own = node.motion.tool.lower(), node.motion.frame.lower()
        return {r for r in found if (r.tool.lower(), r.frame.lower()) != own}
    # A single reading can be done in the tool and frame that it states; several may differ.
    return set(found) if len(found) > 1 else set()


_Moved = tuple[e.TargetValue, dict[str, e.Expression]]
"""Shift of a target in its tool: the known part, and the components that are not known."""


def _along(node: p.Statement) -> tuple[p.Move, e.Expression, e.Expression] | None:
    """Return a move to a target at a distance along its tool, with both; it has a special form."""
    match node:
        case p.Move(target=e.Apply("relative", (base, x, y, z, *turns))):
            return (node, base, z) if all(map(_is_zero, (x, y, *turns))) else None
    return None


def _shift(value: e.Expression) -> tuple[e.Expression, tuple[_Moved, ...]] | None:
    """Return a target that is shifted in its tool, and its shifts in order; None for others.

    A known shift with turns about one axis at most has a separate form. Turns are about x, then the
    new y, then the new z.
    """
    match value:
        case e.Apply("relative", (base, x, y, z, *turns)):
            pass
        case _:
            return None
    computed = {a: v for a, v in zip(AXES, (x, y, z), strict=True) if e.plain_number(v) is None}
    given = (*turns, *(e.Number(0),) * 3)[:3]
    angles = [e.plain_number(v) for v in given]
    # Turns of unknown angles do not commute, so each becomes a shift of its own.
    if None in angles:
        return base, tuple(_one_by_one((x, y, z), computed, given))
    known = [n or 0.0 for n in angles]
    # A shift with a turn about one axis has a form of its own.
    if not computed and sum(a != 0.0 for a in known) <= 1:
        return None
    turn = rotations.from_euler(np.array(known), "XYZ")
    return base, ((_moved_by((x, y, z), turn), computed),)


def _one_by_one(
    shift: tuple[e.Expression, ...],
    computed: dict[str, e.Expression],
    turns: tuple[e.Expression, ...],
) -> Iterator[_Moved]:
    """A shift with the first turn, then the other turns."""
    pairs = [pair for pair in zip(e.ANGLES, turns, strict=True) if not _is_zero(pair[1])]
    for at, (angle, turn) in enumerate(pairs):
        first = at == 0
        still = _moved_by(shift if first else (), np.array([1.0, 0.0, 0.0, 0.0]))
        yield still, {**(computed if first else {}), angle: turn}


def _moved_by(shift: tuple[e.Expression, ...], turn: Floats) -> e.TargetValue:
    position = np.array([e.plain_number(v) or 0.0 for v in shift] or [0.0] * 3)
    return e.TargetValue(Target(Pose.of(position, turn), Configuration()))


_Parts = tuple[e.Expression, dict[str, e.Expression], bool]
"""Parts of a computed target: another target, components, and true if they are added to its own."""


def _parts(value: e.Expression) -> _Parts | None:
    """Return the parts of a computed target, None for others."""
    match value:
        case e.Apply(function, (base, x, y, z)) if function.lower() == "offset":
            shift = {a: v for a, v in zip(AXES, (x, y, z), strict=True) if not _is_zero(v)}
            if all(e.plain_number(v) is not None for v in (x, y, z)):
                return None
            return base, shift, True
        case e.Apply("oriented", (base, x, y, z)):
            return base, dict(zip(e.ANGLES, (x, y, z), strict=True)), False
        case e.Aggregate((e.Aggregate(place), e.Aggregate(turn), e.Aggregate(arm), outer)):
            numbers = [e.plain_number(v) for v in (*turn, *arm)]
            external = outer.items if isinstance(outer, e.Aggregate) else ()
            outside = [e.plain_number(v) for v in external]
            if (len(place), len(turn), len(arm), len(outside)) != (3, 4, 4, 6):
                return None
            known = [n for n in numbers if n is not None]
            beyond = [n for n in outside if n is not None]
            # Orientation and configuration have to be known, and a zero quaternion is no
            # orientation.
            if len(known) != 8 or len(beyond) != 6 or not any(known[:4]):
                return None
            whole = target([*(e.plain_number(v) or 0.0 for v in place), *known, *beyond])
            worked = {a: v for a, v in zip(AXES, place, strict=True) if e.plain_number(v) is None}
            return e.TargetValue(whole), worked, False
    return None


def _inner(value: e.Expression) -> bool:
    """True if a computed target is made of another one."""
    return any(r is not value and _parts(r) for r in records(value) if isinstance(r, e.Expression))


def _in_order(place: e.Expression, parts: Mapping[str, e.Expression], keeps: bool) -> bool:
    """True if the components can be set in order: none needs the old value of an earlier one.

    keeps: the target has its own components until they are set; else it is another target by then.
    """
    if not keeps:
        return not any(r == place for r in records(tuple(parts.values())))
    gone: set[e.Expression] = set()
    # Components are set one after the other: each may read its own old value, but none that was set
    # before.
    for name, value in parts.items():
        own = {r for r in records(value) if isinstance(r, e.Member) and r.value == place}
        others = map_expressions(value, lambda x: e.Number(0) if x in own else x)  # noqa: B023
        if own & gone or any(r == place for r in records(others)):
            return False
        gone.add(e.Member(place, name))
    return True


def _put_together(
    place: e.Expression, base: e.Expression, parts: dict[str, e.Expression], added: bool
) -> Iterator[p.Statement]:
    if base != place:
        yield p.Assign(place, base)
    for axis, value in parts.items():
        component = e.Member(place, axis)
        if value != component:
            yield p.Assign(component, _sum(component, value) if added else value)


def _assigned(place: e.Expression, parts: Mapping[str, e.Expression]) -> Iterator[p.Statement]:
    return (p.Assign(e.Member(place, name), value) for name, value in parts.items())


def _sum(component: e.Expression, value: e.Expression) -> e.Expression:
    match value:
        case e.Unary("-", operand):
            return e.Binary("-", component, operand)
        # `x - 5` in place of `x + -5`, which not every language can write.
        case e.Number(number) if number < 0:
            return e.Binary("-", component, e.Number(-number))
    return e.Binary("+", component, value)


def _components(value: e.Expression) -> dict[str, e.Expression] | None:
    match value:
        case e.Aggregate((x, y, z)):
            return dict(zip(AXES, (x, y, z), strict=True))
        case e.Member(place, field) if field.lower() == WHOLE:
            return {axis: e.Member(place, axis) for axis in AXES}
    return None


def _is_zero(value: e.Expression) -> bool:
    return e.plain_number(value) == 0

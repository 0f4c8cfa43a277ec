"""Targets that are worked out as the program runs, put together in a variable first.

For a language that has position constants of numbers only: `offset(p, 10*i, 0, 0)` is a copy of
`p` whose X is moved, in a position variable of the procedure.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from assistant.languages.records import target
from assistant.program import expressions as e
from assistant.program import rotations
from assistant.program import statements as p
from assistant.program.geometry import Configuration, Pose, Target
from assistant.program.passes.hoisting import Taken, hoisted
from assistant.program.program import Procedure, Program, Variable
from assistant.program.rewriting import head, map_head, records

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

    def __call__(self, node: p.Statement) -> Taken:
        made = Taken(node)
        used = 0
        elsewhere = _read_elsewhere(node)
        goal = isinstance(node, p.Move) and isinstance(node.target, e.Apply)

        def visit(value: e.Expression) -> e.Expression:
            nonlocal used
            if value in elsewhere:
                used += 1
                place = self.place("at", used)
                made.before.append(p.Assign(place, value))
                return place
            parts, shift = _parts(value), _shift(value, goal)
            if parts is None and shift is None:
                return value
            used += 1
            if parts is not None:
                place = self.place("at", used)
                made.before += _put_together(place, *parts)
                return place
            assert shift is not None
            base, still, moved = shift
            place = self.place("by", used)
            made.before += _put_together(place, still, moved, added=False)
            return e.Binary("@", base, place)

        match node:
            case p.Assign(e.Name() as place, value) if (parts := _parts(value)) is not None:
                changes = any(r == place for r in records(parts[1]))
                if not changes and not elsewhere and not _inner(value):
                    made.after += _put_together(place, *parts)
                    made.statement = made.after.pop(0)
                    return made
            case p.Assign(e.Member(place, field), value) if field.lower() == WHOLE:
                components = _components(value)
                if components is not None:
                    pairs = zip(AXES, components, strict=True)
                    made.after += (p.Assign(e.Member(place, axis), x) for axis, x in pairs)
                    made.statement = made.after.pop(0)
                    return made
        made.statement = map_head(node, visit)
        return made

    def place(self, stem: str, number: int) -> e.Name:
        """A position variable of the procedure; the same ones serve every statement."""
        key = f"{stem}_{number}"
        if key not in self.known:
            free = (f"{stem}_{k}" for k in itertools.count(1))
            name = next(n for n in free if n not in self.taken)
            self.taken.add(name)
            self.known[key] = name
            self.variables[name] = Variable("position")
        return e.Name(self.known[key])


def _read_elsewhere(node: p.Statement) -> set[e.Expression]:
    """Present positions that a statement reads in a tool or frame that cannot hold for it."""
    found = {r for r in records(head(node)) if isinstance(r, e.Here)}
    if isinstance(node, p.MoveStatement):
        own = node.motion.tool.lower(), node.motion.frame.lower()
        return {r for r in found if (r.tool.lower(), r.frame.lower()) != own}
    return set(found) if len(found) > 1 else set()


def _shift(
    value: e.Expression, in_move: bool
) -> tuple[e.Expression, e.TargetValue, dict[str, e.Expression]] | None:
    """Of a target that is moved in its tool: target, what is known of the shift, what is not.

    A distance along the tool alone has a form of its own in a move, and so has a shift that is
    known and turns about one axis at most. A turn has to be known; it is one about x, then the
    new y, then the new z.
    """
    match value:
        case e.Apply("relative", (base, x, y, z, *turns)):
            computed = {
                a: v for a, v in zip(AXES, (x, y, z), strict=True) if e.plain_number(v) is None
            }
            known = [e.plain_number(v) for v in turns]
            if None in known:
                return None
            angles = [n or 0.0 for n in (*known, 0.0, 0.0, 0.0)[:3]]
            about_several = sum(a != 0.0 for a in angles) > 1
            along = in_move and _is_zero(x) and _is_zero(y) and not any(angles)
            if along or (not computed and not about_several):
                return None
            position = tuple(e.plain_number(v) or 0.0 for v in (x, y, z))
            turn = rotations.from_euler(np.array(angles), "XYZ")
            moved = Target(Pose.of(np.array(position), turn), Configuration())
            return base, e.TargetValue(moved), computed
    return None


def _parts(value: e.Expression) -> tuple[e.Expression, dict[str, e.Expression], bool] | None:
    """What a computed target is made of, and whether the components are added; None for others."""
    match value:
        case e.Apply(function, (base, x, y, z)) if function.lower() == "offset":
            shift = {a: v for a, v in zip(AXES, (x, y, z), strict=True) if not _is_zero(v)}
            if all(e.plain_number(v) is not None for v in (x, y, z)):
                return None
            return base, shift, True
        case e.Aggregate((e.Aggregate(place), e.Aggregate(turn), e.Aggregate(arm), outer)):
            numbers = [e.plain_number(v) for v in (*turn, *arm)]
            external = outer.items if isinstance(outer, e.Aggregate) else ()
            outside = [e.plain_number(v) for v in external]
            if (len(place), len(turn), len(arm), len(outside)) != (3, 4, 4, 6):
                return None
            known = [n for n in numbers if n is not None]
            beyond = [n for n in outside if n is not None]
            if len(known) != 8 or len(beyond) != 6 or not any(known[:4]):
                return None
            whole = target([*(e.plain_number(v) or 0.0 for v in place), *known, *beyond])
            worked = {a: v for a, v in zip(AXES, place, strict=True) if e.plain_number(v) is None}
            return e.TargetValue(whole), worked, False
    return None


def _inner(value: e.Expression) -> bool:
    """Whether a computed target is made of another one."""
    return any(r is not value and _parts(r) for r in records(value) if isinstance(r, e.Expression))


def _put_together(
    place: e.Name, base: e.Expression, parts: dict[str, e.Expression], added: bool
) -> Iterator[p.Statement]:
    if base != place:
        yield p.Assign(place, base)
    for axis, value in parts.items():
        component = e.Member(place, axis)
        yield p.Assign(component, _sum(component, value) if added else value)


def _sum(component: e.Expression, value: e.Expression) -> e.Expression:
    match value:
        case e.Unary("-", operand):
            return e.Binary("-", component, operand)
        case e.Number(number) if number < 0:
            return e.Binary("-", component, e.Number(-number))
    return e.Binary("+", component, value)


def _components(value: e.Expression) -> tuple[e.Expression, ...] | None:
    match value:
        case e.Aggregate((x, y, z)):
            return x, y, z
        case e.Member(place, field) if field.lower() == WHOLE:
            return tuple(e.Member(place, axis) for axis in AXES)
    return None


def _is_zero(value: e.Expression) -> bool:
    return e.plain_number(value) == 0

"""Angles of positions that are set one by one, for a language that sets an orientation as a whole.

Where angles are stored as they are set, the ones behind each other make one orientation together.
A language of quaternions reads the angles of each anew, of which two sets are the same: those that
are set right behind each other become one assignment.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import replace
from typing import Any, Final

import numpy as np

from assistant.program import expressions as e
from assistant.program import rotations
from assistant.program import statements as p
from assistant.program.analysis.uses import base_variable
from assistant.program.contents import records_in_procedures
from assistant.program.geometry import Pose
from assistant.program.passes.legalising import Legalisation
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import (
    Body,
    is_repeatable,
    map_bodies,
    map_expressions,
    records,
    rewrite,
)

STEEPEST: Final = 90.0
"""Degrees about y: beyond them the same orientation is read back as other angles."""
ANGLE_DECIMALS: Final = 9
"""Decimals of angles that are worked out."""


def with_whole_angles(job: Legalisation) -> Program:
    """The program that sets all angles of a position at once."""

    def body(statements: Body) -> Body:
        made: list[p.Statement] = []
        group: list[p.Assign] = []
        for node in statements:
            if group and not _continues_group(group, node):
                made += _one_assignment(group, job)
                group = []
            if _sets_angle(node):
                group.append(node)  # type: ignore[arg-type]
            else:
                made.append(map_bodies(node, body))
        return (*made, *_one_assignment(group, job))

    procedures = (replace(q, body=body(q.body)) for q in job.program.procedures)
    return replace(job.program, procedures=tuple(procedures))


def _sets_angle(node: p.Statement) -> bool:
    match node:
        case p.Assign(e.Member(_, field)):
            return field.lower() in e.ANGLES
    return False


def _position_set(node: Any) -> Any:
    return node.target.value


def _continues_group(group: list[p.Assign], node: p.Statement) -> bool:
    """Whether a statement sets another angle of the same place."""
    if not _sets_angle(node) or _position_set(node) != _position_set(group[0]):
        return False
    return is_repeatable(_position_set(node)) and all(is_repeatable(one.value) for one in group)


def _one_assignment(group: list[p.Assign], job: Legalisation) -> Iterator[p.Statement]:
    if not group:
        return
    place = _position_set(group[0])
    known: dict[str, e.Expression] = {name: e.Member(place, name) for name in e.ANGLES}
    for node in group:
        match node.target:
            case e.Member(_, field):
                known[field.lower()] = _value_with_angles(node.value, place, known)
    about_y = e.plain_number(known["about_y"])
    same = known["about_y"] == e.Member(place, "about_y")
    whole = all(known[name] != e.Member(place, name) for name in e.ANGLES)
    if not (whole or same or (about_y is not None and abs(about_y) <= STEEPEST)):
        with job.findings.at(group[0].span):
            job.changed(
                what="an angle about y that is set without the other two",
                instead="that of an orientation whose angle about y is within 90 degrees",
                cure="set all three angles of a position together",
            )
    turned = e.Apply("oriented", (place, *known.values()))
    yield p.Assign(place, turned, span=group[0].span)


def _value_with_angles(
    value: e.Expression, place: e.Expression, known: Mapping[str, e.Expression]
) -> e.Expression:
    """A value that reads angles of the place as they are set by then."""

    def visit(x: e.Expression) -> e.Expression:
        match x:
            case e.Member(inner, field) if inner == place and field.lower() in known:
                return known[field.lower()]
        return x

    return map_expressions(value, visit)


def with_read_angles(program: Program) -> Program:
    """The program in which a position is turned by the angles that it is read back with.

    For a language that stores angles as they are set: 200 degrees about z are read back as -160
    from an orientation. What nothing reads stays as it is set.
    """
    if not any(map(_is_angle, records_in_procedures(program, e.Member))):
        return program
    said = rewrite(program.procedures, _without_copies)
    if not any(map(_is_angle, records(said))):
        return program

    def body(statements: Body, poses: Set[str]) -> Body:
        return tuple(one for node in statements for one in each(node, poses))

    def each(node: p.Statement, poses: Set[str]) -> Iterator[p.Statement]:
        match node:
            case p.Assign(place, e.Apply("oriented", (turned, *given))) if not _copies(given):
                numbers = [e.plain_number(one) for one in given]
                if None in numbers:
                    yield node
                    again: e.Expression = e.Apply("relative", (place, *(e.Number(0),) * 3))
                    if base_variable(place) in poses:
                        again = e.Binary("@", place, e.PoseValue(Pose()))
                    yield p.Assign(place, again, span=node.span)
                else:
                    said = map(e.number_of, _read_back([n or 0.0 for n in numbers]))
                    yield replace(node, value=e.Apply("oriented", (turned, *said)))
            case _:
                yield map_bodies(node, lambda statements: body(statements, poses))

    procedures = (
        replace(q, body=body(q.body, _pose_names(program, q))) for q in program.procedures
    )
    return replace(program, procedures=tuple(procedures))


def _pose_names(program: Program, procedure: Procedure) -> frozenset[str]:
    """Names in lower case of poses in a procedure: targets have no products with poses."""
    known = {name.lower(): one.type for name, one in program.variables.items()}
    known |= {one.name.lower(): one.type for one in procedure.parameters}
    known |= {name.lower(): one.type for name, one in procedure.variables.items()}
    return frozenset(name for name, type in known.items() if type == "pose")


def _without_copies(x: Any) -> Any:
    """A target that is turned as another one is, without the angles that it is given."""
    match x:
        case e.Apply("oriented", (turned, *given)) if _copies(given):
            return turned
    return x


def _is_angle(record: Any) -> bool:
    return isinstance(record, e.Member) and record.field.lower() in e.ANGLES


def _copies(given: Sequence[e.Expression]) -> bool:
    """Whether angles are all those of one position."""
    first = given[0] if given else None
    if not isinstance(first, e.Member):
        return False
    return list(given) == [e.Member(first.value, name) for name in e.ANGLES]


def _read_back(angles: Sequence[float]) -> list[float]:
    """Angles about x, y and z as they are read from the orientation that they make."""
    turn = rotations.from_euler(np.array(angles[::-1]), "ZYX")
    return [
        round(float(angle), ANGLE_DECIMALS) + 0.0 for angle in rotations.to_euler(turn, "ZYX")[::-1]
    ]

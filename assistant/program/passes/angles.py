"""Angles of positions that are set one by one, for a language that sets an orientation as a whole.

Where angles are stored as they are set, the ones behind each other make one orientation together.
A language of quaternions reads the angles of each anew, of which two sets are the same: those that
are set right behind each other become one assignment.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.passes.legalising import Legalising
from assistant.program.program import Program
from assistant.program.rewriting import Body, is_repeatable, map_bodies, map_expressions

STEEPEST = 90.0
"""Degrees about y: beyond them the same orientation is read back as other angles."""


def with_whole_angles(job: Legalising) -> Program:
    """The program that sets all angles of a position at once."""

    def body(statements: Body) -> Body:
        made: list[p.Statement] = []
        group: list[p.Assign] = []
        for node in statements:
            if group and not _goes_on(group, node):
                made += _together(group, job)
                group = []
            if _sets_angle(node):
                group.append(node)  # type: ignore[arg-type]
            else:
                made.append(map_bodies(node, body))
        return (*made, *_together(group, job))

    procedures = (replace(q, body=body(q.body)) for q in job.program.procedures)
    return replace(job.program, procedures=tuple(procedures))


def _sets_angle(node: p.Statement) -> bool:
    match node:
        case p.Assign(e.Member(_, field)):
            return field.lower() in e.ANGLES
    return False


def _place(node: Any) -> Any:
    return node.target.value


def _goes_on(group: list[p.Assign], node: p.Statement) -> bool:
    """Whether a statement sets another angle of the same place."""
    if not _sets_angle(node) or _place(node) != _place(group[0]):
        return False
    return is_repeatable(_place(node)) and all(is_repeatable(one.value) for one in group)


def _together(group: list[p.Assign], job: Legalising) -> Iterator[p.Statement]:
    if not group:
        return
    place = _place(group[0])
    known: dict[str, e.Expression] = {name: e.Member(place, name) for name in e.ANGLES}
    for node in group:
        match node.target:
            case e.Member(_, field):
                known[field.lower()] = _with(node.value, place, known)
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


def _with(
    value: e.Expression, place: e.Expression, known: Mapping[str, e.Expression]
) -> e.Expression:
    """A value that reads angles of the place as they are set by then."""

    def visit(x: e.Expression) -> e.Expression:
        match x:
            case e.Member(inner, field) if inner == place and field.lower() in known:
                return known[field.lower()]
        return x

    return map_expressions(value, visit)

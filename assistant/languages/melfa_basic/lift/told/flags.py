"""Flags of positions that are taken from another one: its configuration, elsewhere.

`P1.FL1=P2.FL1` beside `P1.FL2=P2.FL2` gives P1 the branch and the turns of P2. One of both alone
would be half a configuration, and stays as its text.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Target
from assistant.program.program import Procedure, Program, Variable
from assistant.program.rewriting import Body, map_bodies, records
from assistant.program.statement_index import records_in_procedures

_FLAG_ASSIGNMENT: Final = re.compile(r"(\w+)\.FL([12])\s*=\s*(\w+)\.FL([12])", re.IGNORECASE)
_POSE_COMPONENTS: Final = ("x", "y", "z", "about_x", "about_y", "about_z")
"""Components that a position keeps."""
CONFIGURED_POSITION: Final = "configured"
"""The variable that stands between both positions, if that is free."""


def with_flags(program: Program) -> Program:
    """The program in which both flags of a position are assigned as its configuration."""
    if not any(
        _FLAG_ASSIGNMENT.match(one.text) for one in records_in_procedures(program, p.Opaque)
    ):
        return program
    if any(
        isinstance(one, Target) and not np.isnan(one.external).all() for one in records(program)
    ):
        return program  # the places of additional axes would be taken over as well
    taken = {one.name.lower() for one in records(program) if isinstance(one, e.Name)}
    held = next(
        name
        for name in _numbered(CONFIGURED_POSITION)
        if name not in taken | _declared_positions(program)
    )
    changed = [_with_configurations(procedure, program, held) for procedure in program.procedures]
    if changed == list(program.procedures):
        return program
    variables = {**program.variables, held: Variable("position")}
    return replace(program, procedures=tuple(changed), variables=variables)


def _numbered(name: str) -> Iterator[str]:
    yield name
    number = 2
    while True:
        yield f"{name}_{number}"
        number += 1


def _declared_positions(program: Program) -> set[str]:
    own = (name for one in program.procedures for name in one.variables)
    return {name.lower() for name in (*program.variables, *program.targets, *own)}


def _with_configurations(procedure: Procedure, program: Program, held: str) -> Procedure:
    names = {name.upper(): name for name in (*program.targets, *program.variables)}
    names |= {name.upper(): name for name in procedure.variables}
    positions = {**program.variables, **procedure.variables}

    def body(statements: Body) -> Body:
        return tuple(one for node in pairs(statements) for one in node)

    def pairs(statements: Body) -> Iterator[Body]:
        at = 0
        while at < len(statements):
            whole = _configuration_assigned(statements[at : at + 2], names, positions, held)
            yield whole or (map_bodies(statements[at], body),)
            at += 2 if whole else 1

    made = body(procedure.body)
    return procedure if made == procedure.body else replace(procedure, body=made)


def _configuration_assigned(
    pair: Body, names: Mapping[str, str], positions: Mapping[str, Variable], held: str
) -> Body:
    """What two statements are together, nothing if they do not set both flags of one position."""
    found = [
        _FLAG_ASSIGNMENT.fullmatch(one.text.strip()) for one in pair if isinstance(one, p.Opaque)
    ]
    if len(found) != len(pair) or len(pair) != 2 or not all(found):
        return ()
    parts = [one.groups() for one in found if one is not None]
    flags = {(one, other) for _, one, _, other in parts}
    both = {(to.upper(), source.upper()) for to, _, source, _ in parts}
    (to, source), *more = both
    if more or flags != {("1", "1"), ("2", "2")} or not {to, source} <= set(names):
        return ()
    target, other, between = e.Name(names[to]), e.Name(names[source]), e.Name(held)
    if names[to] not in positions:
        return ()
    span = pair[0].span
    return (
        p.Assign(between, other, span=span),
        *(p.Assign(e.Member(between, c), e.Member(target, c), span=span) for c in _POSE_COMPONENTS),
        p.Assign(target, between, span=pair[1].span),
    )

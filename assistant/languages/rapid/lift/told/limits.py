"""The limit of VelSet, as speeds that other languages state.

`VelSet 100,80` lets no move be faster than 80 mm/s until another one. Where a move states more, the
limit is kept in a variable that every VelSet sets; speeds are cut to its values where these are
known, and worked out from it elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

from assistant.languages.rapid.lift.instructions import NameResolver
from assistant.languages.rapid.lift.told.calls import instruction_of
from assistant.languages.rapid.tables.words import SPEED_CAP
from assistant.languages.rapid.tree.calls import called
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.possible_values import Numbers, PossibleValues, numbers_of_all
from assistant.program.analysis.uses import declared
from assistant.program.motion import ComputedSpeed, Kind, Path, Speed
from assistant.program.passes.motions import declared_value
from assistant.program.program import Procedure, Program, TakenNames, Variable, identifier
from assistant.program.rewriting import Body, map_bodies, with_vendor_statements_replaced
from assistant.program.statement_index import records_in_procedures

LIMIT_NAME: Final = "speed_limit"
"""Name of the variable that holds mm/s that a move may state; a number behind it where taken."""
_FULL: Final = e.Number(100)


def with_speed_limit(program: Program) -> tuple[Program, str]:
    """The program in which a variable holds the limit of VelSet, and its name, empty for none.

    There is none where no move states more than any of the limits.
    """
    given = [
        found
        for node in records_in_procedures(program, p.Opaque)
        if (found := _vel_set_values(node)) is not None
    ]
    if not given:
        return program, ""
    numbers = [e.plain_number(NameResolver().known(most) or most) for _, most in given]
    if None not in numbers and _is_within_limit(program, min(n for n in numbers if n is not None)):
        return program, ""
    taken = TakenNames(declared(program))
    name = identifier(LIMIT_NAME, taken)

    def kept(node: p.Opaque) -> Iterator[p.Statement]:
        if (found := _vel_set_values(node)) is not None:
            yield p.Assign(e.Name(name), _speed_before_override(*found), span=node.span)
        yield node

    def plain(body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            if isinstance(node, p.SetOverride):  # whose limit is that which a program begins with
                cap = _speed_before_override(node.percent, e.Number(SPEED_CAP))
                made.append(p.Assign(e.Name(name), cap, span=node.span))
            made.append(map_bodies(node, plain))
        return tuple(made)

    program = replace(
        program,
        procedures=tuple(replace(q, body=plain(q.body)) for q in program.procedures),
        variables={**program.variables, name: Variable("number", e.Number(SPEED_CAP))},
    )
    return with_vendor_statements_replaced(program, kept), name


def _vel_set_values(node: p.Opaque) -> tuple[e.Expression, e.Expression] | None:
    """The share in percent and the limit in mm/s that a text sets."""
    call = instruction_of(node)
    if call is None or str(call.name).lower() != "velset":
        return None
    said = called(call)
    match said.given if said is not None and not said.options else ():
        case (share, most) if share is not None and most is not None:
            meaning = NameResolver()
            return meaning.expression(share), meaning.expression(most)
    return None


def _speed_before_override(share: e.Expression, most: e.Expression) -> e.Expression:
    """The speed that a move may state, which is then slowed down to a share."""
    part, cap = e.plain_number(share), e.plain_number(most)
    if part == 100:
        return most
    if part and cap is not None:
        return e.number_of(cap * 100 / part)
    return e.Binary("/", e.Binary("*", most, _FULL), share)


def _is_within_limit(program: Program, limit: float) -> bool:
    """True if no move of a program states more than a limit in mm/s."""
    motions = records_in_procedures(program, p.Motion)
    paths = [one.path for one in program.statements() if isinstance(one, p.Follow)]
    stated = [*(one.speed for one in motions), *(x for path in paths for x in path.speeds)]
    known = [declared_value(one, program.speeds) for one in stated]
    kept = any(isinstance(one, p.Opaque) and _is_path_or_move(one) for one in program.statements())
    return not kept and all(isinstance(one, Speed) and one.tcp <= limit for one in known)


def _is_path_or_move(node: p.Opaque) -> bool:
    call = instruction_of(node)
    return call is not None and str(call.name).lower().startswith(("move", "trigg", "search"))


def with_limited_speeds(program: Program, name: str) -> Program:
    """The program whose moves state no more than the limit that the variable holds."""
    if not name:
        return program
    possible = PossibleValues(program)
    procedures = [_SpeedLimiter(program, possible, name, q).done() for q in program.procedures]
    program = replace(program, procedures=tuple(procedures))
    if any(one == e.Name(name) for one in _read_names(program, name)):
        return program
    kept = {key: one for key, one in program.variables.items() if key != name}
    procedures = [replace(q, body=_without_assignments(q.body, name)) for q in procedures]
    return replace(program, procedures=tuple(procedures), variables=kept)


def _read_names(program: Program, name: str) -> Iterator[e.Name]:
    """Names in use, without those that the limit is assigned to."""
    targets = {
        id(node.target)
        for node in program.statements()
        if isinstance(node, p.Assign) and node.target == e.Name(name)
    }
    yield from (one for one in records_in_procedures(program, e.Name) if id(one) not in targets)


def _without_assignments(body: Body, name: str) -> Body:
    """A body without the assignments to a variable."""
    return tuple(
        map_bodies(node, lambda inner: _without_assignments(inner, name))
        for node in body
        if not (isinstance(node, p.Assign) and node.target == e.Name(name))
    )


class _SpeedLimiter:
    """The moves of one procedure."""

    def __init__(
        self, program: Program, possible: PossibleValues, name: str, procedure: Procedure
    ) -> None:
        self.program, self.name, self.procedure = program, name, procedure
        self.numbers = numbers_of_all(possible, e.Name(name), procedure)

    def done(self) -> Procedure:
        return replace(self.procedure, body=self.body(self.procedure.body))

    def body(self, body: Body) -> Body:
        return tuple(part for node in body for part in self.each(node))

    def each(self, node: p.Statement) -> Iterator[p.Statement]:
        limits = self.numbers(node)
        match node:
            case p.Move() | p.MoveCircular() | p.MoveJoints():
                speed = self.speed(node.motion.speed, limits)
                yield replace(node, motion=replace(node.motion, speed=speed))
            case p.Follow(path):
                speeds = tuple(self.speed(one, limits) for one in path.speeds)
                fixed = tuple(one for one in speeds if not isinstance(one, ComputedSpeed))
                if len(fixed) == len(speeds):
                    yield replace(node, path=replace(path, speeds=fixed))
                else:
                    yield from _path_moves(path, speeds, node)
            case _:
                yield map_bodies(node, self.body)

    def speed(
        self, speed: Speed | ComputedSpeed | e.Name, limits: Numbers
    ) -> Speed | ComputedSpeed | e.Name:
        known = declared_value(speed, self.program.speeds) if isinstance(speed, e.Name) else speed
        if isinstance(known, e.Name):
            return speed  # nothing declares it, which is told of
        if isinstance(known, ComputedSpeed):
            stated = known.tcp if known.tcp is not None else e.Name(self.name)
            return replace(known, tcp=_minimum(stated, e.Name(self.name)))
        if limits and all(one >= known.tcp for one in limits):
            return speed
        if limits is not None and len(limits) == 1:
            return replace(known, tcp=min(known.tcp, *limits))
        tcp: e.Expression = e.Name(self.name)
        if known.tcp != float("inf"):
            tcp = _minimum(e.number_of(known.tcp), tcp)
        return ComputedSpeed(
            tcp,
            e.number_of(known.rotation),
            e.number_of(known.external_linear),
            e.number_of(known.external_rotary),
            None if known.joint is None else e.number_of(known.joint),
        )


def _minimum(one: e.Expression, other: e.Expression) -> e.Expression:
    return one if one == other else e.Apply("min", (one, other))


def _path_moves(
    path: Path, speeds: Sequence[Speed | ComputedSpeed | e.Name], node: p.Follow
) -> Iterator[p.Statement]:
    """The moves of a path whose speeds are worked out."""
    via: e.Expression | None = None
    for row in range(len(path)):
        target = e.TargetValue(path.target(row))
        motion = p.Motion(
            speeds[path.speed[row]],
            path.blends[path.blend[row]],
            path.tools[path.tool[row]],
            path.frames[path.frame[row]],
        )
        if path.kinds[row] == Kind.VIA:
            via = target
        elif via is not None:
            yield p.MoveCircular(via, target, motion, span=node.row_span(row))
            via = None
        else:
            kind = "joint" if path.kinds[row] == Kind.JOINT else "linear"
            yield p.Move(kind, target, motion, span=node.row_span(row))  # type: ignore[arg-type]

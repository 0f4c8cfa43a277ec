"""Positions: computed components, angles set one by one, the robot's base, rows of tables.

For a language that has components of data alone, `here(grip in base).x` becomes a variable with the
position, and a part of it; the positions of a computed distance become variables, too.

If angles are stored as they are set, consecutive ones form one orientation. A language of
quaternions reads the angles anew from each, and two sets of angles are the same orientation:
assignments of angles that directly follow each other become one.

Five-axis arms get targets in the robot's base, as their orientations depend on the position.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import base_variable, declared, names_in
from assistant.program.geometry import BASE, IDENTITY, Frame, Pose, Target, Tool
from assistant.program.passes.hoisted_statements import Taken, hoisted
from assistant.program.passes.legalisation import Legalisation
from assistant.program.program import (
    Declaration,
    Procedure,
    Program,
    TakenNames,
    Variable,
    identifier,
)
from assistant.program.rewriting import (
    Body,
    is_repeatable,
    map_bodies,
    map_expressions,
    map_head,
    records,
    rewrite,
    with_vendor_statements_replaced,
)
from assistant.program.statement_index import records_in_procedures

_POSITION_STEM = "here"


def with_named_places(job: Legalisation) -> Program:
    """Return the program that assigns a position to a variable before it uses a part of it."""
    program = job.program
    if not any(map(_unnamed, records_in_procedures(program, e.Member, e.Apply))):
        return program
    taken = taken_names(program)
    made = tuple(with_named_positions(procedure, taken) for procedure in program.procedures)
    return replace(program, procedures=made)


def taken_names(program: Program) -> set[str]:
    """Names in lower case that no further variable of a procedure may have."""
    taken = {n.lower() for t in (program.variables, program.targets, program.signals) for n in t}
    taken |= {name.lower() for q in program.procedures for name in (q.name, *q.variables)}
    return taken | {one.name.lower() for q in program.procedures for one in q.parameters}


def _unnamed(record: object) -> tuple[e.Expression, ...]:
    """The positions of an expression that have to be in variables."""
    match record:
        case e.Member(value=e.Here() as place):
            return (place,)
        case e.Apply("distance", given):
            return tuple(x for x in given if isinstance(x, e.Here | e.Apply | e.TargetValue))
    return ()


def with_named_positions(procedure: Procedure, taken: set[str]) -> Procedure:
    """A procedure with such positions in variables."""
    known: dict[int, e.Name] = {}

    def place(number: int) -> e.Name:
        """The same variables serve every statement."""
        if number not in known:
            names = (f"{_POSITION_STEM}_{k}" for k in itertools.count(1))
            name = next(n for n in names if n not in taken)
            taken.add(name)
            known[number] = e.Name(name)
        return known[number]

    def take(node: p.Statement) -> Taken:
        made, places = Taken(node), dict[e.Expression, e.Name]()
        # An interrupt asks its condition later, when the variable is out of date.
        if isinstance(node, p.Interrupt):  # its condition is asked later, and elsewhere
            return made

        def part(value: e.Expression) -> e.Expression:
            for one in _unnamed(value):
                if one not in places:
                    places[one] = place(len(places))
                    made.before.append(p.Assign(places[one], one))
            match value:
                case e.Member(value=e.Here() as one):
                    return replace(value, value=places[one])
                case e.Apply("distance", given):
                    return replace(value, arguments=tuple(places.get(x, x) for x in given))
            return value

        made.statement = map_head(node, part)
        return made

    body = hoisted(procedure.body, take)
    new = {name.name: Variable("position") for name in known.values()}
    return replace(procedure, body=body, variables={**procedure.variables, **new})


_STEEPEST: Final = 90.0
"""Degrees about y: beyond them the same orientation is read back as other angles."""
_ANGLE_DECIMALS: Final = 9
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
    """True if a statement sets another angle of the same position."""
    if not _sets_angle(node) or _position_set(node) != _position_set(group[0]):
        return False
    # A call in the place or in a value could change the position between two angles.
    return is_repeatable(_position_set(node)) and all(is_repeatable(one.value) for one in group)


def _one_assignment(group: list[p.Assign], job: Legalisation) -> Iterator[p.Statement]:
    if not group:
        return
    place = _position_set(group[0])
    # Angles that are not set are read from the position itself.
    known: dict[str, e.Expression] = {name: e.Member(place, name) for name in e.ANGLES}
    for node in group:
        match node.target:
            case e.Member(_, field):
                known[field.lower()] = _value_with_angles(node.value, place, known)
    about_y = e.plain_number(known["about_y"])
    same = known["about_y"] == e.Member(place, "about_y")
    # All three angles, or an angle about y within 90 degrees, are read back as they are set.
    whole = all(known[name] != e.Member(place, name) for name in e.ANGLES)
    if not (whole or same or (about_y is not None and abs(about_y) <= _STEEPEST)):
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
                    # A shift by nothing has the controller work out the angles anew.
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
    """True if the angles are all those of one position."""
    first = given[0] if given else None
    if not isinstance(first, e.Member):
        return False
    return list(given) == [e.Member(first.value, name) for name in e.ANGLES]


def _read_back(angles: Sequence[float]) -> list[float]:
    """Angles about x, y and z as they are read from the orientation that they make."""
    # Angles are given about x, y, z and composed as Rz·Ry·Rx.
    turn = rotations.from_euler(np.array(angles[::-1]), "ZYX")
    return [
        round(float(angle), _ANGLE_DECIMALS) + 0.0
        for angle in rotations.to_euler(turn, "ZYX")[::-1]
    ]


def in_base(job: Legalisation) -> Program:
    """Targets and paths in robot coordinates: five axes code orientation by position.

    Only what a frame is used for moves; a named target of one frame becomes one in the base.
    """
    program, findings, can = job.program, job.findings, job.can.five_axes
    if can is None:
        return program
    frames = {n.lower(): f.pose for n, f in program.frames.items()}
    used: dict[str, str] = {}
    set_ones = {n.lower() for n in _assigned(program)}
    targets = dict(program.targets)

    def moved(target: Target, pose: Pose) -> Target:
        return replace(target, pose=pose @ target.pose)

    def place(value: e.Expression, frame: str) -> e.Expression:
        match value:
            case e.TargetValue(target=target):
                return e.TargetValue(moved(target, frames[frame]))
            case e.Name(name=name):
                key = next((n for n in targets if n.lower() == name.lower()), None)
                # One target in two frames would have two positions in the base.
                if key is not None and used.setdefault(key, frame) == frame:
                    return value
            # A shift in the axes of the tool is the same in any frame; one in the axes of the
            # frame only where these are those of the base.
            case e.Apply("relative", (inner, *shift)):
                return e.Apply("relative", (place(inner, frame), *shift))
            case e.Apply("offset" | "oriented" as function, (inner, *shift)) if np.array_equal(
                frames[frame].quaternion, IDENTITY.quaternion
            ):
                return e.Apply(function, (place(inner, frame), *shift))
        job.cannot(
            what=f"a computed or shared target of frame `{frame}` on an arm of five axes",
            cure="give the target in the robot's base",
        )
        return value

    def still(frame: str) -> None:
        if frame in set_ones:
            job.cannot(
                what=f"a move in frame `{frame}`, which the program sets, on an arm of five axes",
                cure="give the frame its place before the program is written",
            )

    def move(node: p.MoveStatement) -> p.Statement:
        frame = node.motion.frame.lower()
        if frame == BASE or frame not in frames:
            # A move in the base claims its target for the base.
            if isinstance(node, p.Move) and isinstance(node.target, e.Name):
                used.setdefault(node.target.name, BASE)
            return node
        still(frame)
        findings.append(can.to_base(name=node.motion.frame))
        motion = replace(node.motion, frame=BASE)
        if isinstance(node, p.MoveJoints):
            return replace(node, motion=motion)
        if isinstance(node, p.MoveCircular):
            return replace(
                node, motion=motion, via=place(node.via, frame), target=place(node.target, frame)
            )
        return replace(node, motion=motion, target=place(node.target, frame))

    def follow(node: p.Follow) -> p.Follow:
        path = node.path
        if all(f.lower() == BASE or f.lower() not in frames for f in path.frames):
            return node
        positions, quaternions = path.positions.copy(), path.quaternions.copy()
        for row, name in enumerate(path.frames):
            pose, rows = frames.get(name.lower()), path.frame == row
            if pose is None or name.lower() == BASE or not rows.any():
                continue
            still(name.lower())
            findings.append(can.to_base(name=name))
            positions[rows] = rotations.rotate(pose.quaternion, positions[rows]) + pose.position
            quaternions[rows] = rotations.canonical(
                rotations.multiply(pose.quaternion, quaternions[rows])
            )
        return replace(
            node,
            path=replace(
                path, positions=positions, quaternions=quaternions,
                frames=(BASE,), frame=np.zeros(len(path), dtype=np.int32),
            ),
        )  # fmt: skip

    def visit(node: Any) -> Any:
        match node:
            case p.Move() | p.MoveCircular() | p.MoveJoints():
                return move(node)
            case p.Follow():
                return follow(node)
        return node

    procedures = rewrite(program.procedures, visit)
    for name, frame in used.items():
        if frame != BASE and name in targets:
            targets[name] = moved(targets[name], frames[frame])
    return replace(program, procedures=procedures, targets=targets)


def _assigned(program: Program) -> Iterator[str]:
    """Names that statements assign to, or to a part of."""
    for node in program.statements():
        if isinstance(node, p.Assign):
            place = node.target
            while isinstance(place, e.Member | e.Index):
                place = place.value
            if isinstance(place, e.Name):
                yield place.name


RowTable = tuple[Declaration, Sequence[Tool | Frame]]
"""A table's declaration, and its rows."""
RowName = Callable[[str, int], str | None]
"""Return the name of a row from the name of its table and its number from 1; None for an unknown
row.
"""


def with_table_rows(
    program: Program,
    tables: Mapping[str, RowTable],
    said: Callable[[p.Opaque, RowName], p.Statement],
) -> Program:
    """Return the program whose moves name rows, if nothing else reads or changes the tables.

    tables: by lower-case name. said: returns the statement for a vendor text whose rows are named.
    """
    names: dict[tuple[str, int], str] = {}
    taken = TakenNames(declared(program))

    def named(table: str, place: int) -> str | None:
        key = table.lower(), place
        if key[0] not in tables or not 0 < place <= len(tables[key[0]][1]):
            return None
        if key not in names:
            names[key] = identifier(f"{table}_{place}", taken)
            taken.add(names[key].lower())
        return names[key]

    changed = with_vendor_statements_replaced(program, lambda node: (said(node, named),))
    # Any other use of the tables would miss rows that are taken out of them.
    if not tables.keys().isdisjoint(name.lower() for name in names_in(changed.procedures)):
        return program
    rows = {name: tables[table][1][place - 1] for (table, place), name in names.items()}
    dropped = [declaration for declaration, _ in tables.values()]
    return replace(
        changed,
        declarations=tuple(d for d in program.declarations if d not in dropped),
        tools=program.tools | {n: v for n, v in rows.items() if isinstance(v, Tool)},
        frames=program.frames | {n: v for n, v in rows.items() if isinstance(v, Frame)},
    )

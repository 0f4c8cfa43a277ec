"""Angles and flags of positions, held beside them for other languages.

MELFA-BASIC stores A, B and C as they are written: 200 degrees stay 200, and B may exceed 90. An
orientation of another language keeps none of that: it is read back within 180 and 90 degrees. So a
position whose angles are read, or set one by one, gets three numbers beside it that hold them. One
that is only turned on by `P.C=P.C+…` needs none: its orientation is the same either way.

`P1.FL1=P2.FL1` beside `P1.FL2=P2.FL2` gives P1 the branch and the turns of P2: its configuration.
One of the two alone would be half a configuration, and stays a vendor statement.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field, replace
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Findings
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.tables.poses import plain_pose
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.line_tables import Positions
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import base_variable, declared, handed_over
from assistant.program.geometry import Pose, Target
from assistant.program.program import (
    Procedure,
    Program,
    TakenNames,
    Variable,
    bodies,
    identifier,
    walk,
)
from assistant.program.rewriting import (
    Body,
    head,
    is_steady,
    map_bodies,
    map_expressions,
    map_head,
    records,
    rewrite,
)
from assistant.program.statement_index import records_in_procedures

_ANGLE_SUFFIXES: Final = {"about_x": "A", "about_y": "B", "about_z": "C"}
"""Suffixes of the number variables next to a position, after the position's name."""
_SAME_ANGLE: Final = 1e-9
_PositionKey = tuple[str, str]
"""A position variable: the procedure whose own it is, empty for the program's, and its name, both
in lower case."""
_ThreeAngles = tuple[e.Expression, e.Expression, e.Expression]


def with_angles_beside(program: Program, findings: Findings) -> Program:
    """The program whose positions have their angles beside them where those count."""
    if not any(map(_is_angle, records_in_procedures(program, e.Member))) and not any(
        one.function == "oriented" for one in records_in_procedures(program, e.Apply)
    ):
        return program
    work = _AngleNumbers(program, findings)
    work.find()
    return work.done()


def _is_angle(record: Any) -> bool:
    return isinstance(record, e.Member) and record.field.lower() in _ANGLE_SUFFIXES


@dataclass
class _AngleNumbers:
    """beside: by position the names of its three numbers. taken: names that are not free.

    indices: variables of indices that are worked out once.
    """

    program: Program
    findings: Findings
    beside: dict[_PositionKey, tuple[str, str, str]] = field(default_factory=dict)
    owner: Procedure | None = None
    taken: TakenNames = field(default_factory=TakenNames)
    indices: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        signals = self.program.signals.items()
        self.inputs = {name.lower() for name, one in signals if one.direction == "input"}

    # ------------------------------------------------------------------------- which ones

    def find(self) -> None:
        """Notes the positions whose angles count, and those whose angles these take over."""
        wanted: set[_PositionKey] = set()
        copied: dict[_PositionKey, set[_PositionKey]] = {}
        for procedure in self.program.procedures:
            self.owner = procedure
            for group in _angle_groups(procedure.body):
                wanted |= self._strong(group)
            for node in walk(procedure.body):
                if isinstance(node, p.Assign) and (key := self.key(node.target)) is not None:
                    if not isinstance(node.target, e.Member):
                        sources = copied.setdefault(key, set())
                        sources |= {k for k in self._sources(node.value) if k is not None}
        # A position that gives its angles to another one needs its own beside it as well.
        pending = list(wanted)
        while pending:
            for source in copied.get(pending.pop(), ()):
                if source not in wanted:
                    wanted.add(source)
                    pending.append(source)
        self.taken = TakenNames(declared(self.program))
        for key in sorted(wanted):
            name = self.variable(key)[0]
            three = [
                identifier(f"{name}_{letter}", self.taken) for letter in _ANGLE_SUFFIXES.values()
            ]
            self.taken.update(three)
            self.beside[key] = (three[0], three[1], three[2])

    def _strong(self, group: tuple[p.Statement, ...]) -> set[_PositionKey]:
        """Positions whose angles a statement, or sets that stand together, read or need."""
        sets = [node for node in group if isinstance(node, p.Assign)]
        fields = {node.target.field.lower() for node in sets if isinstance(node.target, e.Member)}
        whole = fields == set(_ANGLE_SUFFIXES)
        found: set[_PositionKey] = set()
        for node in group:
            skipped: list[e.Expression] = []
            if len(group) > 1 or _sets_angle(node):
                assert isinstance(node, p.Assign)
                # A relative turn needs no stored angle, and three sets together replace the old
                # angles.
                key = self.key(node.target)
                turns = _turning(node)
                if turns is not None:
                    skipped = [node.target, turns]
                elif whole:
                    skipped = [node.target]
                elif key is not None:
                    found.add(key)
            for record in records(head(node)):
                if _is_angle(record) and not any(record is one for one in skipped):
                    if (key := self.key(record)) is not None and self.is_variable(key):
                        found.add(key)
        return found

    def _sources(self, value: e.Expression) -> Iterator[_PositionKey | None]:
        match value:
            case e.Apply("offset", (inner, *_)):
                yield from self._sources(inner)
            case e.Name() | e.Index():
                key = self.key(value)
                if key is not None and self.is_variable(key):
                    yield key

    # --------------------------------------------------------------------------- variables

    def key(self, place: Any) -> _PositionKey | None:
        """The position variable or target that a place is, or is a component of."""
        name = base_variable(place)
        if not name:
            return None
        owner = self.owner
        if owner is not None and (
            any(name == one.lower() for one in owner.variables)
            or any(name == one.name.lower() for one in owner.parameters)
        ):
            return owner.name.lower(), name
        return "", name

    def is_variable(self, key: _PositionKey) -> bool:
        return key[0] != "" or any(key[1] == name.lower() for name in self.program.variables)

    def variable(self, key: _PositionKey) -> tuple[str, Variable | None]:
        """A position variable as it is spelled and declared; None for a parameter."""
        tables: list[Mapping[str, Variable]] = [self.program.variables]
        if key[0]:
            tables = [q.variables for q in self.program.procedures if q.name.lower() == key[0]]
        for table in tables:
            for name, variable in table.items():
                if name.lower() == key[1]:
                    return name, variable
        return key[1], None

    # ---------------------------------------------------------------------------- rewriting

    def done(self) -> Program:
        procedures = []
        for procedure in self.program.procedures:
            self.owner = procedure
            body = self.body(procedure.body)
            variables = {**procedure.variables, **self._declared(procedure.name.lower())}
            procedures.append(replace(procedure, body=body, variables=variables))
        self.owner = None
        counted = dict.fromkeys(self.indices, Variable("integer"))
        variables = {**self.program.variables, **self._declared(""), **counted}
        return replace(self.program, procedures=tuple(procedures), variables=variables)

    def _declared(self, owner: str) -> dict[str, Variable]:
        found: dict[str, Variable] = {}
        for key, three in self.beside.items():
            if key[0] != owner:
                continue
            name, variable = self.variable(key)
            if variable is None:  # a parameter
                self.refuse(name, "the program is given it by another one")
                continue
            first = self._first(name, variable)
            for number, one in enumerate(three):
                initial = None if first is None else first[number]
                found[one] = Variable(
                    "number", initial, variable.size, variable.storage, variable.local
                )
        return found

    def _first(self, name: str, variable: Variable) -> _ThreeAngles | None:
        """The first values of the numbers beside a variable."""
        match variable.initial:
            case None:
                return None
            case e.TargetValue(target):
                return self.raw(target.pose, name)
            case e.Aggregate(items) if len(variable.size) == 1:
                rows = [self._element(name, at, one) for at, one in enumerate(items, 1)]
                return tuple(e.Aggregate(tuple(row[k] for row in rows)) for k in range(3))  # type: ignore[return-value]
        self.refuse(name, "the values that it begins with are not known one by one")
        return None

    def _element(self, name: str, at: int, value: e.Expression) -> _ThreeAngles:
        if isinstance(value, e.TargetValue):
            return self.raw(value.target.pose, name, (at,))
        return (e.Number(0), e.Number(0), e.Number(0))  # nothing was taught there

    def body(self, statements: Body) -> Body:
        made: list[p.Statement] = []
        for at, node in enumerate(statements):
            after = statements[at + 1] if at + 1 < len(statements) else None
            made += self.each(node, after)
        return tuple(made)

    def each(self, node: p.Statement, after: p.Statement | None) -> Iterator[p.Statement]:
        if isinstance(node, p.Assign):
            indices, node = self.indexed_once(node)
            yield from indices
        node = map_head(node, self.read) if not _sets_angle(node) else node
        match node:
            case p.Assign(e.Member(place, part), value) if _sets_angle(node):
                key = self.key(place)
                value = map_expressions(value, self.read)
                if key is None or key not in self.beside:
                    yield replace(node, value=value)
                    return
                own = dict(zip(_ANGLE_SUFFIXES, self.numbers(place, key), strict=True))
                yield p.Assign(own[part.lower()], value, span=node.span)
                # Further angles of the same position follow: it is turned once, after the last of
                # them.
                if _position_set(after) != place:
                    angles = {**own, part.lower(): _within_turn(value, own[part.lower()])}
                    turned = e.Apply("oriented", (place, *angles.values()))
                    yield p.Assign(place, turned, span=node.span)
            case p.Assign(e.Name() | e.Index() as place, value) if self.key(place) in self.beside:
                yield node
                with self.findings.at(node.span):
                    yield from self.taken_over(node, place, value)
            case p.Call(name, arguments):
                for one in self._handed(name, arguments):
                    with self.findings.at(node.span):
                        self.refuse(self.variable(one)[0], f"`{name}` may change it")
                yield node
            case _:
                yield map_bodies(node, self.body)

    def taken_over(
        self, node: p.Assign, place: e.Expression, value: e.Expression
    ) -> Iterator[p.Statement]:
        """Sets the numbers beside a position to what it is given."""
        key = self.key(place) or ("", "")
        given = self.angles(value, place)
        if given is None:
            self.refuse(self.variable(key)[0], "the angles of what it is given are not known")
            return
        for one, angle in zip(self.numbers(place, key), given, strict=True):
            if one != angle:
                yield p.Assign(one, angle, span=node.span)

    def angles(self, value: e.Expression, place: e.Expression) -> _ThreeAngles | None:
        """The angles of a value as they are stored, once it is assigned to a place."""
        match value:
            case e.Apply("offset", (inner, *_)):
                return self.angles(inner, place)
            case e.Apply("oriented", (_, x, y, z)):
                return x, y, z
            case e.Apply("relative") | e.Binary("@") | e.Here():
                return (
                    e.Member(place, "about_x"), e.Member(place, "about_y"),
                    e.Member(place, "about_z"),
                )  # fmt: skip
            case e.TargetValue(target):
                return self.raw(target.pose)
            case e.Name() | e.Index():
                key = self.key(value)
                if key in self.beside:
                    return self.numbers(value, key)
                for name, target in self.program.targets.items():
                    if isinstance(value, e.Name) and name.lower() == value.name.lower():
                        return self.raw(target.pose, name)
        return None

    def read(self, x: e.Expression) -> e.Expression:
        """An angle that is read: of a variable the number beside it, of a constant its value."""
        match x:
            case e.Member(place, part) if _is_angle(x):
                at = list(_ANGLE_SUFFIXES).index(part.lower())
                key = self.key(place)
                if key in self.beside:
                    return self.numbers(place, key)[at]
                if isinstance(place, e.Name):
                    for name, target in self.program.targets.items():
                        if name.lower() == place.name.lower():
                            return self.raw(target.pose, name)[at]
                if isinstance(place, e.TargetValue):
                    return self.raw(place.target.pose)[at]
        return x

    def numbers(self, place: e.Expression, key: Any) -> _ThreeAngles:
        """The numbers beside a place, with its indices."""
        one, two, three = (e.Name(name) for name in self.beside[key])
        if isinstance(place, e.Index):
            at = place.indices
            return e.Index(one, at), e.Index(two, at), e.Index(three, at)
        return one, two, three

    def indexed_once(self, node: p.Assign) -> tuple[list[p.Statement], p.Assign]:
        """The statement with indices in variables that may differ each time they are worked out."""
        made: list[p.Statement] = []

        def once(x: Any) -> Any:
            if not isinstance(x, e.Index) or self.key(x) not in self.beside:
                return x
            # An index that may change is computed once, so that position and numbers get the same
            # element.
            if all(is_steady(index, self.inputs) for index in x.indices):
                return x
            names = []
            for index in x.indices:
                name = e.Name(self.index_name(len(made)))
                made.append(p.Assign(name, index, span=node.span))
                names.append(name)
            return replace(x, indices=tuple(names))

        return made, rewrite(node, once)

    def index_name(self, number: int) -> str:
        """The variable for one of the indices of a statement."""
        while len(self.indices) <= number:
            self.indices.append(identifier("index", self.taken))
            self.taken.add(self.indices[-1])
        return self.indices[number]

    def _handed(self, name: str, arguments: tuple[Any, ...]) -> Iterator[_PositionKey]:
        for procedure in self.program.procedures:
            if procedure.name.lower() == name.lower():
                for one in handed_over(procedure, arguments):
                    key = self.key(one)
                    if key in self.beside:
                        yield key

    def refuse(self, name: str, why: str) -> None:
        self.findings.append(rules.ANGLES(name=name, why=why))

    # --------------------------------------------------------------------------- raw angles

    def raw(self, pose: Pose, name: str = "", indices: tuple[int, ...] = ()) -> _ThreeAngles:
        """The angles of a position as the source writes them."""
        # A constant of the source with the same orientation has the angles as they were written.
        for values in self._written(name, indices):
            if _have_same_angles(plain_pose(values), pose):
                x, y, z = ((value or 0.0) + 0.0 for value in (*values, *(0.0,) * 6)[3:6])
                return e.number_of(x), e.number_of(y), e.number_of(z)
        found = rotations.to_euler(np.array(pose.quaternion), "ZYX")[::-1]
        x, y, z = (round(float(angle), 6) + 0.0 for angle in found)
        return e.number_of(x), e.number_of(y), e.number_of(z)

    def _written(self, name: str, indices: tuple[int, ...]) -> Iterator[tuple[float | None, ...]]:
        trees = self.program.origin.trees if self.program.origin is not None else ()
        # A position may have got a number after its name to be unique.
        names = [name.upper(), name.upper().rpartition("_")[0]] if name else []
        for tree in trees:
            known = Positions(tree)
            for one in names:
                elements = known.elements.get(one, ("", {}))[1]
                found = elements.get(indices) if indices else known.constant(one)
                if found is not None:
                    yield found.values
        if not names:
            for tree in trees:
                for line in tree.items:
                    if isinstance(line, s.Line):
                        yield from _constant_of(line)


def _constant_of(line: s.Line) -> Iterator[tuple[float | None, ...]]:
    yield from (node.values for node in nodes(line.statement) if isinstance(node, s.Constant))


def _have_same_angles(one: Pose, other: Pose) -> bool:
    return bool(
        np.allclose(one.position, other.position, atol=1e-6)
        # A quaternion and its negative are one orientation.
        and abs(abs(float(np.dot(one.quaternion, other.quaternion))) - 1.0) <= _SAME_ANGLE
    )


def _within_turn(value: e.Expression, beside: e.Expression) -> e.Expression:
    """A number of more than a turn within it, which few digits tell exactly; else what it is in."""
    number = e.plain_number(value)
    return (
        beside if number is None or abs(number) <= 360 else e.number_of(math.remainder(number, 360))
    )


def _sets_angle(node: p.Statement | None) -> bool:
    """True if a statement sets one angle of a position."""
    return isinstance(node, p.Assign) and _is_angle(node.target)


def _position_set(node: p.Statement | None) -> e.Expression | None:
    """The position that a statement sets one angle of."""
    match node:
        case p.Assign(e.Member(place)) if _sets_angle(node):
            return place
    return None


def _turning(node: p.Assign) -> e.Expression | None:
    """The reading in `P.C=P.C+…`, which turns a position on about z, or about its own x by A."""
    match node:
        case p.Assign(e.Member(_, part) as own, e.Binary("+" | "-", left, right)):
            others = any(map(_is_angle, records(right)))
            # C turns about the base's z and A about the tool's x; B is between, and turns about
            # neither.
            if part.lower() != "about_y" and left == own and not others:
                return left
    return None


def _angle_groups(body: Iterable[p.Statement]) -> Iterator[tuple[p.Statement, ...]]:
    """Statements of a body and those inside them: sets of angles of one place together."""
    group: list[p.Statement] = []
    for node in body:
        if group and _position_set(node) != _position_set(group[0]):
            yield tuple(group)
            group = []
        if _sets_angle(node):
            group.append(node)
            continue
        yield (node,)
        for inner in bodies(node):
            yield from _angle_groups(inner)
    if group:
        yield tuple(group)


_FLAG_ASSIGNMENT: Final = re.compile(r"(\w+)\.FL([12])\s*=\s*(\w+)\.FL([12])", re.IGNORECASE)
_POSE_COMPONENTS: Final = ("x", "y", "z", "about_x", "about_y", "about_z")
"""Components that a position keeps."""
_CONFIGURED_POSITION: Final = "configured"
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
        for name in _numbered(_CONFIGURED_POSITION)
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
    """Combine two statements that set both flags of one position; return nothing for any others."""
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
        # Only a whole position carries a configuration: take that of the source, then put each
        # element of the target back into it.
        *(p.Assign(e.Member(between, c), e.Member(target, c), span=span) for c in _POSE_COMPONENTS),
        p.Assign(target, between, span=pair[1].span),
    )

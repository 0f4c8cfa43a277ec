"""Speed limits of `VelSet`, and joint moves that state their time, as speeds of moves.

`VelSet 100,80` lets no move be faster than 80 mm/s until the next one. Where a move states more,
each VelSet sets a variable to the limit: speeds are cut to it where it is known, and computed from
it elsewhere. `MoveAbsJ` with the option `T` gets a share of the axes' fastest speeds, computed as
the program runs from how far each axis turns: from where the arm is or, in a corner, from the
joints that the move before leads to. Speeds are mm/s and deg/s, times seconds.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Findings, Span
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.statements import NameResolver, lift_call
from assistant.languages.rapid.lift.vendor_statements import instruction_of, word_of
from assistant.languages.rapid.tables.constants import SPEED_CAP
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree.walk import called
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.possible_values import Numbers, PossibleValues, numbers_of_all
from assistant.program.analysis.uses import declared
from assistant.program.motion import Blend, ComputedSpeed, Kind, Path, Speed
from assistant.program.passes.motions import declared_value
from assistant.program.program import (
    Parameter,
    Procedure,
    Program,
    TakenNames,
    Variable,
    identifier,
)
from assistant.program.rewriting import Body, map_bodies, with_vendor_statements_replaced
from assistant.program.statement_index import records_in_procedures
from assistant.program.vendor_statements import effect_of

if TYPE_CHECKING:
    from assistant.robots import Robot


_LIMIT_NAME: Final = "speed_limit"
"""Name of the variable for the maximum speed of a move, in mm/s; a number is appended if the name
is taken.
"""
_FULL: Final = e.Number(100)


def with_speed_limit(program: Program) -> tuple[Program, str]:
    """Return the program in which a variable holds the limit of VelSet, and the name of that
    variable, empty without one.

    The variable is omitted if no move states a higher speed than any of the limits.
    """
    given = [
        found
        for node in records_in_procedures(program, p.Opaque)
        if (found := _vel_set_values(node)) is not None
    ]
    if not given:
        return program, ""
    numbers = [e.plain_number(NameResolver().known(most) or most) for _, most in given]
    # A computed limit may be any; a fixed one that no move reaches needs no variable.
    if None not in numbers and _is_within_limit(program, min(n for n in numbers if n is not None)):
        return program, ""
    taken = TakenNames(declared(program))
    name = identifier(_LIMIT_NAME, taken)

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
    # The override slows a move after its stated speed was cut, so the limit counts before the
    # override.
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
    # A move that stays as text may state any speed.
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
    # A limit that no speed needs goes again, with its assignments.
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
        # No possible limit is lower, so the speed stays as it is.
        if limits and all(one >= known.tcp for one in limits):
            return speed
        if limits is not None and len(limits) == 1:
            return replace(known, tcp=min(known.tcp, *limits))
        tcp: e.Expression = e.Name(self.name)
        # An unlimited speed has no number to compare with the limit.
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


_FASTEST_AXIS: Final = 720.0
"""deg/s of each axis if no robot is named: as fast as any axis of the catalogue turns, so
that a move never takes less time than it states."""
_AXIS_COUNT: Final = 6
_SHORTEST_TIME: Final = 0.001
"""Seconds of a move that states no time at all: as fast as the axes turn."""
_TIME_OPTION: Final = "t"
_CLEAR_PATH: Final = "clearpath"
_WAIT_STANDSTILL: Final = "WaitRob\\InPos;"


def with_timed_moves(program: Program, arm: Robot | None, findings: Findings) -> Program:
    """Return the program whose timed joint moves to joint targets use a percentage of the axis
    speeds.

    If another move may leave the arm in a corner with unknown joints, the arm stops before each
    timed move.
    """
    meaning = NameResolver(
        speeds={name.lower(): speed for name, speed in program.speeds.items()},
        blends={name.lower(): blend for name, blend in program.blends.items()},
    )
    nodes = [*program.statements()]
    if not any(_timed_move(node, meaning) for node in nodes):
        return program
    stands = not all(_is_end_known(node, meaning, program) for node in nodes)
    timing = _TimedMoveLowering(program, meaning, arm, findings, stands=stands)
    procedures = tuple(replace(q, body=timing.body(q.body)) for q in program.procedures)
    return replace(
        program,
        procedures=(*procedures, timing.share()),
        variables={**program.variables, **timing.variables},
    )


@dataclass(frozen=True, slots=True)
class _TimedMove:
    """A joint move without its time, and the seconds that it takes."""

    move: p.MoveJoints
    seconds: e.Expression


def _timed_move(node: p.Statement, meaning: NameResolver) -> _TimedMove | None:
    call = instruction_of(node) if isinstance(node, p.Opaque) else None
    if call is None or word_of(call) != "moveabsj":
        return None
    known = called(call)
    options = {} if known is None else dict(known.options)
    name = next((one for one in options if one.lower() == _TIME_OPTION), None)
    seconds = options.pop(name, None) if name is not None else None
    if known is None or seconds is None:
        return None
    move = lift_call(replace(known, options=options), meaning)
    if not isinstance(move, p.MoveJoints):
        return None
    return _TimedMove(replace(move, span=node.span), meaning.expression(seconds))


def _is_end_known(node: p.Statement, meaning: NameResolver, program: Program) -> bool:
    """True if the joints at which a statement leaves the arm are known, or it stops there."""
    match node:
        case p.MoveJoints():
            return True
        case p.Move(motion=motion) | p.MoveCircular(motion=motion):
            return _is_stop_point(motion, program)
        case p.Follow(path):
            # Only where a path ends matters for the move after it.
            last = path.blends[path.blend[-1]]
            known = declared_value(last, program.blends)
            return isinstance(known, Blend) and known.fine
        case p.Travel():
            return False
        case p.Opaque():
            moves = effect_of(node).moves and not node.text.lower().startswith(_CLEAR_PATH)
            return not moves or _timed_move(node, meaning) is not None
    return True


def _is_stop_point(motion: p.Motion, program: Program) -> bool:
    known = declared_value(motion.blend, program.blends)
    return isinstance(known, Blend) and known.fine


class _TimedMoveLowering:
    """Works out the shares of one program. stands: the arm stops before each timed move.
    variables: new ones. span: of the first move.
    """

    def __init__(
        self,
        program: Program,
        meaning: NameResolver,
        arm: Robot | None,
        findings: Findings,
        *,
        stands: bool,
    ) -> None:
        self.stands = stands
        self.program, self.meaning, self.arm, self.findings = program, meaning, arm, findings
        taken = TakenNames((*declared(program), *(q.name for q in program.procedures)))
        names = []
        for stem in ("timed_from", "timed_to", "timed_known", "timed_percent", "seconds_to_turn"):
            names.append(identifier(stem, taken))
            taken.add(names[-1])
        self.begin, self.end, self.known, self.percent = map(e.Name, names[:4])
        self.function = names[4]
        self.span: Span | None = None
        self.variables = {
            names[0]: Variable("joints"),
            names[1]: Variable("joints"),
            names[3]: Variable("number"),
        }
        if not stands:
            self.variables[names[2]] = Variable("truth", e.Truth(False))

    def body(self, body: Body) -> Body:
        return tuple(part for node in body for part in self.each(node))

    def each(self, node: p.Statement) -> Iterator[p.Statement]:
        timed = _timed_move(node, self.meaning)
        if timed is not None:
            yield from self.move(timed)
            return
        if self.stands:
            yield map_bodies(node, self.body)
            return
        # The arm stops anywhere on its path, so where it stands is not known.
        if isinstance(node, p.Opaque) and node.text.lower().startswith(_CLEAR_PATH):
            yield p.Assign(self.known, e.Truth(False))
        yield map_bodies(node, self.body)
        match node:
            # In a corner the arm does not reach the target, but leads on from it.
            case p.MoveJoints(target) if not _is_stop_point(node.motion, self.program):
                yield p.Assign(self.begin, target)
                yield p.Assign(self.known, e.Truth(True))
            case p.Move() | p.MoveCircular() | p.MoveJoints() | p.Follow():
                yield p.Assign(self.known, e.Truth(False))

    def move(self, timed: _TimedMove) -> Iterator[p.Statement]:
        move, loss = timed.move, _SHARE_OF_ARM if self.arm is not None else _SHARE_OF_ANY_ARM
        self.span = self.span or move.span
        with self.findings.at(move.span):
            self.findings.append(rules.LEFT_OUT(what=r"\T", loss=loss[0], cure=loss[1]))
        here = p.Assign(self.begin, e.Apply("joints_here", ()))
        if self.stands:
            yield p.Opaque(verbatim.LANGUAGE, _WAIT_STANDSTILL, span=move.span)
            yield here
        else:
            asked = e.Unary("not", self.known)
            # In a corner the arm is still under way, so the joints that the move before leads to
            # count.
            yield p.If((p.Branch(asked, (here, p.Assign(self.known, e.Truth(True)))),))
        yield p.Assign(self.end, move.target)
        way = e.Apply(self.function, (self.begin, self.end))
        plain = e.plain_number(timed.seconds)
        seconds = (
            e.number_of(max(plain, _SHORTEST_TIME))
            if plain is not None
            else e.Apply("max", (timed.seconds, e.number_of(_SHORTEST_TIME)))
        )
        share = e.Binary("/", e.Binary("*", e.Number(100), way), seconds)
        # Controllers take whole percents from 1 to 100.
        least = e.Apply("max", (e.Number(1), share))
        yield p.Assign(self.percent, e.Apply("min", (e.Number(100), least)))
        speed = ComputedSpeed(None, joint=self.percent)
        yield replace(move, motion=replace(move.motion, speed=speed))
        if not self.stands:
            yield p.Assign(self.begin, self.end)

    def share(self) -> Procedure:
        """A function: the seconds that the slowest axis takes from some joints to others."""
        longest = e.Name("longest")
        speeds = (
            [_FASTEST_AXIS] * _AXIS_COUNT if self.arm is None else [*map(float, self.arm.speeds)]
        )
        body: list[p.Statement] = [p.Assign(longest, e.Number(0))]
        for at, fastest in enumerate(speeds[:_AXIS_COUNT], 1):
            parts = (e.Member(e.Name(name), f"j{at}") for name in ("start", "goal"))
            way = e.Apply("abs", (e.Binary("-", *parts),))
            seconds = e.Binary("/", way, e.number_of(fastest))
            body.append(p.Assign(longest, e.Apply("max", (longest, seconds)), span=self.span))
        body.append(p.Return(longest))
        parameters = tuple(Parameter(name, "joints") for name in ("start", "goal"))
        variables = {"longest": Variable("number")}
        return Procedure(self.function, tuple(body), parameters, variables, "number")


_SHARE_OF_ARM: Final = (
    "the move gets the share of the axes' fastest speeds with which the slowest of them takes that "
    "long, without its ramps, and at least 1 %",
    "see that the program can wait that much longer, and run it slowly first",
)
_SHARE_OF_ANY_ARM: Final = (
    "the move gets the share of the speed of axes that turn by "
    f"{_FASTEST_AXIS:g} degrees a second, "
    "at least 1 %: it takes longer with slower axes",
    "name the robot with --robot",
)

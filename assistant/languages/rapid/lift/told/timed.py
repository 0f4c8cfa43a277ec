r"""Joint moves that state how long they take (`MoveAbsJ …\T:=`), for languages without such times.

The share of the axes' fastest speeds is worked out as the program runs: from how far each axis has
to turn from the joints that the move begins in. These are where the arm stands or, in a corner,
what the move before led to.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Findings, Span
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.instructions import NameResolver, lift_call
from assistant.languages.rapid.lift.told.calls import instruction_of, word_of
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree.calls import called
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import declared
from assistant.program.motion import Blend, ComputedSpeed
from assistant.program.passes.motions import declared_value
from assistant.program.program import (
    Parameter,
    Procedure,
    Program,
    TakenNames,
    Variable,
    identifier,
)
from assistant.program.rewriting import Body, map_bodies
from assistant.program.vendor_statements import effect_of

if TYPE_CHECKING:
    from assistant.robots import Robot

FASTEST_AXIS: Final = 720.0
"""deg/s of each axis if no robot is named: as fast as any axis of the catalogue turns, so
that a move never takes less time than it states."""
AXIS_COUNT: Final = 6
SHORTEST_TIME: Final = 0.001
"""Seconds of a move that states no time at all: as fast as the axes turn."""
_TIME_OPTION: Final = "t"
_CLEAR_PATH: Final = "clearpath"
_WAIT_STANDSTILL: Final = "WaitRob\\InPos;"


def with_timed_moves(program: Program, arm: Robot | None, findings: Findings) -> Program:
    """The program whose joint moves to joints get a share of the axes' speeds for their times.

    Where another move may leave the arm in a corner to which nothing states the joints, it stops
    before each of them.
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
        if isinstance(node, p.Opaque) and node.text.lower().startswith(_CLEAR_PATH):
            yield p.Assign(self.known, e.Truth(False))
        yield map_bodies(node, self.body)
        match node:
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
            yield p.If((p.Branch(asked, (here, p.Assign(self.known, e.Truth(True)))),))
        yield p.Assign(self.end, move.target)
        way = e.Apply(self.function, (self.begin, self.end))
        plain = e.plain_number(timed.seconds)
        seconds = (
            e.number_of(max(plain, SHORTEST_TIME))
            if plain is not None
            else e.Apply("max", (timed.seconds, e.number_of(SHORTEST_TIME)))
        )
        share = e.Binary("/", e.Binary("*", e.Number(100), way), seconds)
        least = e.Apply("max", (e.Number(1), share))
        yield p.Assign(self.percent, e.Apply("min", (e.Number(100), least)))
        speed = ComputedSpeed(None, joint=self.percent)
        yield replace(move, motion=replace(move.motion, speed=speed))
        if not self.stands:
            yield p.Assign(self.begin, self.end)

    def share(self) -> Procedure:
        """A function: the seconds that the slowest axis takes from some joints to others."""
        longest = e.Name("longest")
        speeds = [FASTEST_AXIS] * AXIS_COUNT if self.arm is None else [*map(float, self.arm.speeds)]
        body: list[p.Statement] = [p.Assign(longest, e.Number(0))]
        for at, fastest in enumerate(speeds[:AXIS_COUNT], 1):
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
    f"the move gets the share of the speed of axes that turn by {FASTEST_AXIS:g} degrees a second, "
    "at least 1 %: it takes longer with slower axes",
    "name the robot with --robot",
)

"""Legalisation: the capabilities of a language, and the passes that bring a program within them.

`legalise` runs passes one after the other; `pass_trace` shows the program after each. `Rewording`
makes of one statement after the other what the language has for it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from functools import wraps
from typing import Any, ClassVar, Final, Literal

import numpy as np
from numpy.typing import NDArray

from assistant.base.diagnostics import Findings, Rule, Subject
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.declared_types import KnownTypes, Spelling, known_types
from assistant.program.geometry import Load
from assistant.program.motion import Blend, Speed
from assistant.program.program import Procedure, Program, Variable
from assistant.program.rewriting import Body, map_bodies, map_expressions, map_head, rewrite
from assistant.program.statements import Measure

PassWatcher = Callable[[str, Program], None]
"""Takes the name of a pass, and the program as it is then."""

_pass_watcher: Final[ContextVar[PassWatcher | None]] = ContextVar("watcher", default=None)


@contextmanager
def pass_trace(watcher: PassWatcher) -> Iterator[None]:
    """What is compiled meanwhile is shown to a watcher."""
    token = _pass_watcher.set(watcher)
    try:
        yield
    finally:
        _pass_watcher.reset(token)


def traced(name: str, program: Program) -> Program:
    """The program itself, which is shown to whoever watches."""
    watcher = _pass_watcher.get()
    if watcher is not None:
        watcher(name, program)
    return program


@dataclass(frozen=True, slots=True, kw_only=True)
class Units:
    """How long paths go to units of their own, which the program loads or calls.

    most: targets of a unit. least_most: fewer of them count as that. least: targets of a piece.
    counted: what has so many at most, all that a unit holds or the paths of one procedure.
    part, unit, path: format of the names of a piece's procedure (of the path's name and the number
    of the piece) and of its unit (the same), both if that is empty, and of its path (of the
    procedure's name). straight: a piece begins with a straight move where one is near.
    most_steps: of a path in one unit, None without limit; first, steps: those that its first row,
    and a change of a column, take beside one for each move.
    split: has the fields name, count and parts.
    """

    most: int
    least_most: int
    least: int
    counted: Literal["unit", "procedure"]
    part: str
    unit: str
    path: str
    straight: bool
    split: Rule
    most_steps: int | None = None
    first: int = 0
    steps: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Variables:
    """What a language makes of variables.

    external: of a name and its variable, whether it is one of all programs of a controller, and no
    program gives it its first value. persistent: that it gets its first value at each start
    (name). carried: that it gets it in each cycle (name). repeated: that the cycle stands in a
    loop, as some keep what one leaves to the next (names).
    """

    external: Callable[[str, Variable], bool]
    persistent: Rule
    carried: Rule
    repeated: Rule


@dataclass(frozen=True, slots=True, kw_only=True)
class NameForm:
    """Names of a language whose programs do not say what something was called before.

    longest: characters of a name. legal: gives the nearest name of legal characters. renamed: tells
    of a name (given) that is written as another one (name).
    """

    longest: int
    legal: Callable[[str], str]
    renamed: Rule
    reserved: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True, kw_only=True)
class Switches:
    """Of a language whose cases are one number each. nested: one may stand inside another."""

    nested: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Comments:
    """Comments of one line. ascii: that has no letters but those. most_bytes: of a line.

    message: tells of a message that becomes a comment (text); None where messages are said.
    """

    ascii: bool = False
    most_bytes: int | None = None
    message: Rule | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Acceleration:
    """Of a language with one acceleration, in percent, not under the least.

    cure, cure_of_least: of a change for the one reason and for either.
    """

    least: float
    cure: str
    cure_of_least: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Corners:
    """Of a language in which each corner has a size.

    size: mm of one that the controller is to choose, at a speed. name: of a blend.
    """

    size: Callable[[Speed], float]
    name: Callable[[Blend], str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Loops:
    """Of a language whose loops have variables of their own.

    refused: tells of a counter (name) that is used so that it cannot be one, and why. changed: of
    a loop (what) that is said as another one (instead), with a cure.
    """

    refused: Rule
    changed: Rule
    cure: str


@dataclass(frozen=True, slots=True, kw_only=True)
class FiveAxes:
    """Rules of arms of five axes: orientations that they do not reach.

    unreachable: has the fields name and angle. over_the_back: name. to_base: a frame (name) whose
    targets are said in the base.
    """

    unreachable: Rule
    over_the_back: Rule
    to_base: Rule


@dataclass(frozen=True, slots=True, kw_only=True)
class Mounts:
    """What a language has no words for of tools and frames, each told of by its name.

    held: a tool that the robot does not hold, a frame that moves. load: of a tool. joined: a frame
    of two parts. bent: a tool whose tip is not on the flange's axis, for an arm of five axes.
    """

    held: Rule
    load: Rule
    joined: Rule
    bent: Rule


@dataclass(frozen=True, slots=True, kw_only=True)
class Loads:
    """Of a language in which each tool has a load, and none is less than the least.

    missing: tells of a tool (name) that states none. centre: the least one's in words. written:
    a load with the decimals that are written.
    """

    least: Load
    missing: Rule
    centre: str
    written: Callable[[Load], Load]


@dataclass(frozen=True, slots=True, kw_only=True)
class Positions:
    """How a language writes positions and joints.

    decimals: of joints and external axes. farthest: mm or degrees that each number is below.
    not_finite: tells of a number in something (what) that is not. branches: arm branches (n, 6)
    int8 as they are written, where unstated ones get one. unstated: tells of a target (about) or
    of targets of a path (place) that had none; None where they are counted. external: how many
    external axes a target may have, of which the first ones are used, by all targets of a path
    alike; None where any of the six may be. unused: a value from there on stands for none.
    quaternions: orientations are written as quaternions, of which two are the same.
    joints: of a joint target. own: those of the arm, of the ones that are stated. padded: missing
    ones are written as 0.
    """

    decimals: int
    not_finite: Rule
    branches: Callable[[NDArray[np.int8]], NDArray[np.int8]]
    farthest: float = math.inf
    unstated: Rule | None = None
    external: int | None = None
    unused: float = math.nan
    quaternions: bool = False
    joints: int = 6
    own: Callable[[tuple[float, ...]], tuple[float, ...]] = tuple
    padded: bool = False
    mounts: Mounts | None = None
    loads: Loads | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Motions:
    """Of a language whose moves state mm/s or, of the joints, percents, and mm of a corner.

    fastest: mm/s that are taken for 100 percent. unknown: tells of a name that is not declared, and
    what it should be. percent: of a joint move's percent that was worked out of a speed (tcp).
    computed_percent: of one that the program works out, where 100 percent are so many mm/s (tcp).
    speed_part: of more that a speed states (part). blend_part: of more that a blend does.
    """

    fastest: float
    unknown: Rule
    percent: Rule
    computed_percent: Rule
    speed_part: Rule
    blend_part: Rule


@dataclass(frozen=True, slots=True, kw_only=True)
class Arrays:
    """The most dimensions of an array, and the most elements of one dimension."""

    dimensions: int
    elements: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Procedures:
    """What a language makes of procedures.

    functions: they have parameters, results and variables of their own; else as_variables tells of
    one (name) whose parameters and result become variables of the program, and recursive of one
    (name) that calls itself though its data exist once. longest: characters of a head or a call
    that a line holds; the parameters of longer ones become variables, too. longest_name: of a name.
    """

    functions: bool
    as_variables: Rule
    recursive: Rule
    longest: int = 1_000_000
    longest_name: int = 32


@dataclass(frozen=True, slots=True, kw_only=True)
class Outputs:
    """How a language sets outputs on the ways of moves, and for a time.

    measures: what it measures places by. known: whether that is what the pseudo-program means by
    them on every way. unlike: tells of one (name) on the way of a move (what) that others may count
    otherwise. pulse: of one (name) that may be on when a pulse begins. behind: of one (name) that
    is set behind a move which stops there, None where it can be set at its very end. timed: of one
    (name) that is set a time before or behind a place (when), and is where a robot of a speed in
    mm/s is then; None where times can be told. most_pulses: that may run at a time, None for any
    number. waiting: tells of one (name) that waits for another one (before), as no more run. most:
    that are set on one way, None for any number. before: tells of one (name) that is set before its
    move instead of as it begins, as there are more.
    """

    measures: frozenset[Measure]
    known: bool
    unlike: Rule
    pulse: Rule
    behind: Rule | None = None
    timed: Rule | None = None
    most_pulses: int | None = None
    waiting: Rule | None = None
    most: int | None = None
    before: Rule | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Capabilities:
    """What a language can say of what programs ask for, and the rules that tell of the rest.

    A table that is None is of what the language says as it stands: the pass leaves it alone.

    kin: languages whose programs mean by their values what this one does. cannot_say: has the
    fields what and cure. changed: has those and instead; None where nobody is told. no_fit: tells
    of a number (value) that the bits (in words) of a signal (name) cannot hold, up to most. ended:
    of an end for good. longest_message: characters of one.
    """

    kin: frozenset[str]
    cannot_say: Rule
    changed: Rule | None = None
    no_fit: Rule | None = None
    ended: Rule | None = None
    names: NameForm | None = None
    units: Units | None = None
    procedures: Procedures | None = None
    arrays: Arrays | None = None
    variables: Variables | None = None
    loops: Loops | None = None
    switches: Switches | None = None
    outputs: Outputs | None = None
    comments: Comments = Comments()
    acceleration: Acceleration | None = None
    longest_message: int | None = None
    five_axes: FiveAxes | None = None


@dataclass(frozen=True, slots=True)
class Legalisation:
    """A program on its way into a language. findings: what is said differently, or not at all."""

    program: Program
    can: Capabilities
    findings: Findings

    def cannot(self, what: str, cure: str, about: Subject | str | None = None) -> None:
        """An error: the language has no words for it."""
        self.findings.append(self.can.cannot_say(what=what, cure=cure, about=about))

    def changed(
        self, what: str, instead: str, cure: str, about: Subject | str | None = None
    ) -> None:
        """Something is said differently."""
        if self.can.changed is not None:
            told = self.can.changed(what=what, instead=instead, cure=cure, about=about)
            self.findings.append(told)


Pass = Callable[[Legalisation], Program]


def pure(change: Callable[[Program], Program]) -> Pass:
    """A pass that needs nothing but the program, and finds nothing."""

    @wraps(change)
    def changed(job: Legalisation) -> Program:
        return change(job.program)

    return changed


def legalise(job: Legalisation, passes: Sequence[Pass]) -> Program:
    """The program after all passes, each shown under its name to whoever watches."""
    for one in passes:
        name = getattr(one, "__name__", "").replace("_", "-")
        job = replace(job, program=traced(name, one(job)))
    return job.program


Changes = Mapping[type, Callable[[Any, Any], Iterable[p.Statement]]]


class Rewording:
    """Findings stand at the statements that they are about, and so does what is made of these.

    changes: by kind of a statement what is made of one, given this object and the statement. Its
    expressions are said by then; the bodies that it holds are the change's own business.
    spelling, known: of names in the procedure at hand. choices: how many `switch` are around the
    place.
    """

    changes: ClassVar[Changes] = {}

    def __init__(self, job: Legalisation) -> None:
        self.job, self.spelling = job, Spelling(job.program)
        self.known: KnownTypes = {}
        self.choices = 0

    def enter(self, procedure: Procedure) -> None:
        """What follows stands in a procedure."""
        self.spelling.enter(procedure)
        self.known = known_types(self.job.program, procedure)

    def procedure(self, procedure: Procedure) -> Procedure:
        """A procedure with its variables and statements as the language says them."""
        self.enter(procedure)
        owner = procedure.name
        variables = {n: self.variable(v, n, owner) for n, v in procedure.variables.items()}
        return replace(procedure, body=self.body(procedure.body), variables=variables)

    def variable(self, variable: Variable, name: str, owner: str = "") -> Variable:  # noqa: ARG002
        """A variable as the language declares it. owner: the procedure whose own it is, or none."""
        return replace(variable, initial=map_expressions(variable.initial, self.expression))

    def expression(self, x: e.Expression) -> e.Expression:
        """An expression as the language says it; what is in it is said already."""
        return x

    def whole(self, node: p.Statement) -> p.Statement:
        """A statement whose expressions are said, with what depends on more than one of them."""
        return node

    def body(self, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            with self.job.findings.at(node.span):
                parts = self.statement(node)
                made += (x if x.span else replace(x, span=node.span) for x in parts)
        return tuple(made)

    def statement(self, node: p.Statement) -> Iterable[p.Statement]:
        node = self.whole(map_head(node, self.expression))
        change = self.changes.get(type(node))
        return (self.inside(node),) if change is None else change(self, node)

    def inside(self, node: p.Statement) -> p.Statement:
        """A statement with the bodies that it holds as the language says them."""
        said: p.Statement = map_bodies(node, self.body)
        return said


Change = Callable[[Any], Any]


def leaving_out(told: Rule, changes: Mapping[type, tuple[str, Change]]) -> Pass:
    """A pass that changes the records of some types.

    told: tells what is left out. changes: of a type what that is, empty where nothing is lost by
    it, and the record without it.
    """

    def with_parts_left_out(job: Legalisation) -> Program:
        def plain(part: Any) -> Any:
            what, change = changes.get(type(part), ("", lambda same: same))
            made = change(part)
            if what and made != part:
                job.findings.append(told(what=what))
            return made

        return rewrite(job.program, plain)

    return with_parts_left_out

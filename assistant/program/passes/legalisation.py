"""Legalisation: the capabilities of a language, and the passes that bring a program within them.

`legalise` runs passes one after the other; `pass_trace` shows the program after each. `Rewording`
makes of one statement after the other what the language has for it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import field, replace
from functools import wraps
from typing import Any, ClassVar, Final, Literal

import numpy as np
from numpy.typing import NDArray

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Findings, Rule, Subject
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.declared_types import KnownTypes, Spelling, known_types
from assistant.program.geometry import Load
from assistant.program.motion import Blend, Speed
from assistant.program.program import Procedure, Program, ValueType, Variable
from assistant.program.rewriting import Body, map_bodies, map_expressions, map_head, rewrite
from assistant.program.statements import Measure

PassWatcher = Callable[[str, Program], None]
"""Takes the name of a pass, and the program as it is then."""

_pass_watcher: Final[ContextVar[PassWatcher | None]] = ContextVar("watcher", default=None)


@contextmanager
def pass_trace(watcher: PassWatcher) -> Iterator[None]:
    """Show the program to a watcher after each pass while the context is open."""
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
    """Limits from which on paths move to separate units, which the program loads or calls.

    most: targets of a unit. least_most: smaller limits count as this value. least: targets of a
    piece. counted: the subject of the limit, a complete unit or the paths of one procedure. part,
    unit, path: format of the names of a piece's procedure (from the path's name and the number of
    the piece), of its unit (the same), both if that is empty, and of its path (from the procedure's
    name). straight: True if a piece begins with a straight move when one is near. most_steps: of a
    path in one unit, None without limit; first, steps: steps that its first row, and a change of a
    column, take besides one for each move. split: has the fields name, count and parts. packed:
    reports that paths of a procedure move to units together (name, count, parts), None if they do
    not.
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
    packed: Rule | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Variables:
    """Rules for variables of a language.

    external: takes a name and its variable; True if all programs of a controller share it, and no
    program gives it its first value. persistent: reports that it gets its first value at each start
    (name). carried: reports that it gets it in each cycle (name). repeated: reports that the cycle
    is in a loop, as some variables keep their values for the next cycle (names).
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
    """Switches of a language whose cases are one number each. nested: True if one may be inside
    another.
    """

    nested: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Comments:
    """Comments of one line. ascii: True if only ASCII letters are allowed. most_bytes: of a line.

    message: reports a message that becomes a comment (text); None if the language has messages.
    """

    ascii: bool = False
    most_bytes: int | None = None
    message: Rule | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Acceleration:
    """Acceleration of a language with one value, in percent, not less than `least`.

    cure, cure_of_least: cures of a change for the first reason, and for either reason.
    """

    least: float
    cure: str
    cure_of_least: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Corners:
    """Corners of a language in which each corner has a size.

    size: mm of a corner that the controller chooses, at a speed. name: of a blend.
    """

    size: Callable[[Speed], float]
    name: Callable[[Blend], str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Loops:
    """Loops of a language with separate loop variables.

    refused: reports a counter (name) that cannot be a loop variable, and why. changed: reports a
    loop (what) that is translated as another one (instead), with a cure.
    """

    refused: Rule
    changed: Rule
    cure: str


@dataclass(frozen=True, slots=True, kw_only=True)
class FiveAxes:
    """Rules of arms with five axes: orientations that they do not reach.

    unreachable: has the fields name and angle. over_the_back: name. to_base: a frame (name) whose
    targets are written in the base.
    """

    unreachable: Rule
    over_the_back: Rule
    to_base: Rule


@dataclass(frozen=True, slots=True, kw_only=True)
class Mounts:
    """Tools and frames that a language cannot express, each reported by its name.

    held: a tool that the robot does not hold, a frame that moves. load: of a tool. joined: a frame
    of two parts. bent: a tool whose tip is not on the flange's axis, for an arm of five axes.
    """

    held: Rule
    load: Rule
    joined: Rule
    bent: Rule


@dataclass(frozen=True, slots=True, kw_only=True)
class Loads:
    """Loads of a language in which each tool has a load, not less than `least`.

    missing: reports a tool (name) that states no load. centre: the centre of the least load in
    words. written: returns a load with the decimals that are written.
    """

    least: Load
    missing: Rule
    centre: str
    written: Callable[[Load], Load]


@dataclass(frozen=True, slots=True, kw_only=True)
class Positions:
    """Form in which a language writes positions and joints.

    decimals: of joints and external axes. farthest: upper bound of each number, mm or degrees.
    not_finite: reports a number in something (what) that is not finite. branches: arm branches (n,
    6) int8 as they are written, with a branch for unstated ones. unstated: reports a target (about)
    or targets of a path (place) without a branch; None if they are counted. external: number of
    external axes that a target may have; the first ones are used, by all targets of a path alike;
    None if any of the six may be used. unused: values from this one on mean an unused axis.
    quaternions: True if orientations are written as quaternions; two quaternions are the same
    orientation. joints: of a joint target. own: those of the arm among the stated ones. padded:
    True if missing ones are written as 0.
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
    """Motions of a language whose moves state mm/s or, for joint moves, percent, and mm of a
    corner.

    fastest: mm/s that count as 100 percent. unknown: reports an undeclared name, and what it should
    be. percent: reports a joint move's percent that was computed from a speed (tcp).
    computed_percent: reports one that the program computes, with 100 percent for a speed in mm/s
    (tcp). speed_part: reports a further part of a speed (part). blend_part: reports a further part
    of a blend.
    """

    fastest: float
    unknown: Rule
    percent: Rule
    computed_percent: Rule
    speed_part: Rule
    blend_part: Rule


@dataclass(frozen=True, slots=True, kw_only=True)
class Arrays:
    """The most dimensions of an array, and the most elements of one dimension.

    listed: types of arrays that the controller keeps beside the program, where a person may teach
    their elements; those that nothing changes need no assignments.
    """

    dimensions: int
    elements: int
    listed: frozenset[ValueType] = frozenset()


@dataclass(frozen=True, slots=True, kw_only=True)
class Procedures:
    """Rules for procedures of a language.

    functions: True if they have parameters, results and local variables; else as_variables reports
    a procedure (name) whose parameters and result become variables of the program, and recursive
    reports one (name) that calls itself though its data exist once. longest: characters of a head
    or a call in a line; the parameters of longer ones become variables, too. longest_name: of a
    name.
    """

    functions: bool
    as_variables: Rule
    recursive: Rule
    longest: int = 1_000_000
    longest_name: int = 32


@dataclass(frozen=True, slots=True, kw_only=True)
class Outputs:
    """Output settings of a language during moves, and for a time.

    measures: its units for positions on a path. known: True if they have the pseudo-program's
    meaning on every path. unlike: reports an output (name) during a move (what) whose position
    others may count differently. pulse: reports one (name) that may be on when a pulse begins.
    scaled: reports an analog signal (name), whose values other controllers may count otherwise.
    behind: reports one (name) that is set after a move that stops there, None if it can be set at
    its very end. timed: reports one (name) that is set a time before or after a position (when),
    and is set at the robot's position for a speed in mm/s; None if the language has times.
    most_pulses: number of simultaneous pulses, None for any number. waiting: reports one (name)
    that waits for another one (before), because no more can run. most: number of outputs on one
    path, None for any number. before: reports one (name) that is set before its move instead of at
    its start, because the move has more outputs.
    """

    measures: frozenset[Measure]
    known: bool
    unlike: Rule
    pulse: Rule
    scaled: Rule
    behind: Rule | None = None
    timed: Rule | None = None
    most_pulses: int | None = None
    waiting: Rule | None = None
    most: int | None = None
    before: Rule | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Capabilities:
    """Capabilities of a language, and the rules that report what it cannot express.

    The pass of a table that is missing (None) makes no change.

    kin: languages whose values have the same meaning as in this one. cannot_say: has the fields
    what and cure. changed: has those and instead; None if changes are not reported. no_fit: reports
    a number (value) that the bits (in words) of a signal (name) cannot hold, up to most. ended:
    reports a permanent end. longest_message: characters of one.
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
    """A program during legalisation for a language. findings: statements that are changed or cannot
    be expressed.
    """

    program: Program
    can: Capabilities
    findings: Findings

    def cannot(self, what: str, cure: str, about: Subject | str | None = None) -> None:
        """An error: the language has no words for it."""
        self.findings.append(self.can.cannot_say(what=what, cure=cure, about=about))

    def changed(
        self, what: str, instead: str, cure: str, about: Subject | str | None = None
    ) -> None:
        """Report a statement that is translated with a change."""
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
        name = getattr(one, "__name__", "").strip("_").replace("_", "-")
        job = replace(job, program=traced(name, one(job)))
    return job.program


Changes = Mapping[type, Callable[[Any, Any], Iterable[p.Statement]]]


class Rewording:
    """Rewrite statements for a language; findings and new statements get the span of the original
    statement.

    changes: by kind of a statement, a function that returns its replacement from this object and
    the statement. Its expressions are rewritten before; the change itself handles the bodies
    inside. spelling, known: of names in the present procedure. choices: number of `switch` around
    the present statement.
    """

    changes: ClassVar[Changes] = {}

    def __init__(self, job: Legalisation) -> None:
        self.job, self.spelling = job, Spelling(job.program)
        self.known: KnownTypes = {}
        self.choices = 0

    def enter(self, procedure: Procedure) -> None:
        """Enter a procedure: the following statements belong to it."""
        self.spelling.enter(procedure)
        self.known = known_types(self.job.program, procedure)

    def procedure(self, procedure: Procedure) -> Procedure:
        """Return a procedure with its variables and statements rewritten for the language."""
        self.enter(procedure)
        owner = procedure.name
        variables = {n: self.variable(v, n, owner) for n, v in procedure.variables.items()}
        return replace(procedure, body=self.body(procedure.body), variables=variables)

    def variable(self, variable: Variable, name: str, owner: str = "") -> Variable:  # noqa: ARG002
        """A variable as the language declares it. owner: the procedure whose own it is, or none."""
        return replace(variable, initial=map_expressions(variable.initial, self.expression))

    def expression(self, x: e.Expression) -> e.Expression:
        """Return an expression rewritten for the language; its parts are rewritten already."""
        return x

    def whole(self, node: p.Statement) -> p.Statement:
        """Return a statement with rewritten expressions, changed where several of them depend on
        each other.
        """
        return node

    def body(self, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            # Findings of the statement, and new statements, get the span of the original one.
            with self.job.findings.at(node.span):
                parts = self.statement(node)
                made += (x if x.span else replace(x, span=node.span) for x in parts)
        return tuple(made)

    def statement(self, node: p.Statement) -> Iterable[p.Statement]:
        node = self.whole(map_head(node, self.expression))
        change = self.changes.get(type(node))
        return (self.inside(node),) if change is None else change(self, node)

    def inside(self, node: p.Statement) -> p.Statement:
        """Return a statement with its inner bodies rewritten for the language."""
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
            # A type without words changes nothing in meaning: nothing is reported.
            if what and made != part:
                job.findings.append(told(what=what))
            return made

        return rewrite(job.program, plain)

    return with_parts_left_out

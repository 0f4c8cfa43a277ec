"""Motion state before each statement: active tool and frame, last corner, watched configurations.

Tool and frame are those of the last move, and so is whether it stopped at its target or may still
be in a corner; whether configurations of straight moves are watched holds until that is changed.
Paths lead through calls as well. A language states what its vendor statements do.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterable
from typing import Any, Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import called, callees_first, texts_in
from assistant.program.motion import Blend
from assistant.program.program import Procedure, Program, bodies
from assistant.program.rewriting import Body, head, records
from assistant.program.vendor_statements import effect_of

TOOL, FRAME, CORNER, LINES = range(4)
"""Parts of a state: see `State`."""

MotionState = tuple[frozenset[str], ...] | None
"""Possible state, in lower case; None if no path leads there.

Names of the active tool and frame; STOP if the last move ended at its target, else `corner_of` that
move, or UNKNOWN; WATCHED or OPEN for the configurations of straight moves.
"""

_ENTRY: Final = ""
"""Stands for what holds where the procedure is called."""
UNKNOWN: Final = "?"
"""Stands for what the program does not tell."""
START: Final = "<start>"
"""Stands for the tool and frame that are active before the first move."""
STOP: Final = "stop"
_WATCHED: Final = "on"
"""A straight move stops where its target states another configuration."""
OPEN: Final = "off"
"""A straight move goes on in the configuration that it begins in."""
_ANY: Final = (frozenset((UNKNOWN,)),) * 4
_CALLED: Final = (frozenset((_ENTRY,)),) * 4
_FIRST: Final = frozenset((START,))
_BEGUN: Final = (_FIRST, _FIRST, frozenset((STOP,)), frozenset((_WATCHED,)))
"""At the start of a program."""
_STARTED: Final = (*_BEGUN[:3], _ANY[3])
"""State at which a person starts a procedure that nothing calls."""


class MotionStep(enum.Enum):
    """Effect of a vendor statement on the motion state."""

    NOTHING = enum.auto()
    STOPS = enum.auto()
    """The program goes on once the robot stands at its target."""
    WATCHES = enum.auto()
    OPENS = enum.auto()
    MOVES = enum.auto()
    """It may move the robot, but calls no procedure."""
    CALLS = enum.auto()
    """It may move the robot and call any procedure."""


StepsOfText = Callable[[str], Iterable[MotionStep] | None]
"""Returns the steps of a vendor text in order; None if it may run between any two statements."""


class MotionStates:
    """The ways through a program.

    asks: which records, statements or expressions, the state is noted for. kept: what kept
    texts do.
    before: by identity of a statement that is or holds one, what may hold there, seen from its
    own procedure. after: what a call of each procedure leaves. calls: by procedure,
    then by its callers, what is active at the calls. cut: corners that a move may follow, so that
    the robot goes through them; of procedures in cut_before those that it is called in.
    """

    def __init__(self, program: Program, asks: Callable[[Any], bool], kept: StepsOfText) -> None:
        self.asks, self.kept = asks, kept
        self.blends = {name.lower(): blend for name, blend in program.blends.items()}
        self.procedures = {q.name.lower(): q for q in program.procedures}
        self.spelled: dict[str, str] = {}
        self.before: dict[int, MotionState] = {}
        self.after: dict[str, MotionState] = {}
        self.calls: dict[str, dict[str, MotionState]] = {}
        self.labels: dict[tuple[str, str], MotionState] = {}
        self.owner = ""
        self.cut: set[str] = set()
        self.cut_before: set[str] = set()
        self.any_called = self.jumped = False
        self.handled: set[str] = set()
        """Procedures with error handlers, which may move between any two statements."""
        declared = {name for d in program.declarations for name in effect_of(d).names}
        self.elsewhere = {name for name in self.procedures if name in declared}
        """Procedures that are perhaps called by what is kept as its text."""
        own = {name: tuple(called(procedure)) for name, procedure in self.procedures.items()}
        pending = dict.fromkeys(callees_first(own))
        while pending:
            name = self.owner = next(iter(pending))
            del pending[name]
            # A procedure starts with a placeholder for the state at its call.
            known, self.jumped = self.after.get(name), False
            self.leave(self.body(self.procedures[name].body, _CALLED))
            # Callers depend on what their callees leave: they are looked at again.
            if self.after[name] != known:
                pending.update(dict.fromkeys(self.calls.get(name, ())))
            # A jump back brings a state to a label that is passed already.
            if self.jumped:
                pending[name] = None
        self.entered = self._entered((program.entry or "").lower())
        # Corners before the call are those of all callers.
        for name in self.cut_before:
            self.cut |= (self.entered[name] or _ANY)[CORNER]

    def at(self, owner: Procedure, node: p.Statement) -> tuple[frozenset[str], ...]:
        """Return the possible state before a statement of a procedure that `asks` selects."""
        key = owner.name.lower()
        if key in self.handled:
            return _ANY
        return _resolved(self.before.get(id(node)), self.entered[key]) or _ANY

    def active(self, owner: Procedure, node: p.Statement) -> tuple[str | None, str | None]:
        """The tool and frame that are active before a statement, None for what is not known."""
        state = self.at(owner, node)
        return self._only(state[TOOL]), self._only(state[FRAME])

    def _only(self, names: frozenset[str]) -> str | None:
        return self.spelled.get(next(iter(names))) if len(names) == 1 else None

    def _entered(self, entry: str) -> dict[str, MotionState]:
        """Return the possible state at the calls of each procedure; at the start it is unknown."""
        roots = {n for n in self.procedures if n not in self.calls or self.any_called}
        entered: dict[str, MotionState] = {entry: self._begun(entry)}
        alone = _ANY if self.any_called else _STARTED
        entered |= dict.fromkeys(roots - {entry}, alone)
        said = texts_in(tuple(q.body for q in self.procedures.values())) if roots else set()
        entered |= dict.fromkeys(self.elsewhere | (roots & said), _ANY)  # or an interrupt calls it
        gives: dict[str, list[tuple[str, MotionState]]] = {}
        for callee, callers in self.calls.items():
            for caller, state in callers.items():
                gives.setdefault(caller, []).append((callee, state))
        pending = dict.fromkeys(gives)
        while pending:
            caller = next(iter(pending))
            del pending[caller]
            for callee, state in gives.get(caller, ()):
                known = entered.get(callee)
                entered[callee] = _merged_states(known, _resolved(state, entered.get(caller)))
                if entered[callee] != known:
                    pending[callee] = None
        return {n: entered.get(n) for n in self.procedures}

    def _begun(self, entry: str) -> MotionState:
        """State as a cycle begins, with the tool, frame and corner that the one before leaves."""
        left = _resolved(self.after.get(entry), _BEGUN)
        if left is None:
            return _BEGUN
        return tuple(
            begun | left[part] if part in (TOOL, FRAME, CORNER) else begun
            for part, begun in enumerate(_BEGUN)
        )

    # -------------------------------------------------------------------------- statements

    def body(self, body: Body, state: MotionState) -> MotionState:
        for node in body:
            state = self.statement(node, state)
        return state

    def statement(self, node: p.Statement, state: MotionState) -> MotionState:
        if not isinstance(node, p.Label) and state is None:
            # Code after a jump is reached only by a label in it.
            for inner in bodies(node):  # no way leads there but by a label in it
                self.body(inner, None)
            return None
        match node:
            case p.Label(name):
                return _merged_states(state, self.labels.get((self.owner, name.lower())))
            case p.Goto(name):
                place = self.owner, name.lower()
                known = self.labels.get(place)
                self.labels[place] = _merged_states(known, state)
                self.jumped |= self.labels[place] != known
                return None
            case p.While(_, body) | p.For(_, _, _, body):
                return self.loop(node, body, state)
            case p.If(branches, otherwise):
                ways: list[MotionState] = []
                for branch in branches:
                    state = self.read(node, branch.condition, state)
                    ways.append(self.body(branch.body, state))
                return _merged_states(*ways, self.body(otherwise, state))
            case p.Switch(_, cases, otherwise):
                state = self.read(node, head(node), state)
                ways = [self.body(case.body, state) for case in cases]
                return _merged_states(*ways, self.body(otherwise, state))
        state = self.read(node, node, state)
        match node:
            case (
                p.Move(motion=motion) | p.MoveCircular(motion=motion) | p.MoveJoints(motion=motion)
            ):
                corner = self.corner(motion.fixed[1], corner_of(node))
                return self.moved(motion.tool, motion.frame, corner, state)
            case p.Follow(path) if len(path):
                tool, frame = path.tools[path.tool[-1]], path.frames[path.frame[-1]]
                corner = self.corner(path.blends[path.blend[-1]], UNKNOWN)
                return self.moved(tool, frame, corner, state)
            case p.Call(name):
                return self.called(name, state)
            case p.Return():
                self.leave(state)
                return None
            case p.Stop(end=True):
                return None
            case p.Opaque(text=text):
                return self.opaque(text, state)
        return state

    def loop(self, node: p.While | p.For, body: Body, state: MotionState) -> MotionState:
        # Until the state at the start of the loop no longer grows.
        while True:
            begun = self.read(node, head(node), state)
            again = _merged_states(state, self.body(body, begun))
            if again == state:
                return begun
            state = again

    def read(self, node: p.Statement, value: Any, state: MotionState) -> MotionState:
        """Return the state after a value is evaluated; record that of a selected statement."""
        asked, begun = False, state
        for record in records(value):
            if self.asks(record):
                asked = True
                continue
            match record:
                case e.Verbatim():
                    if not effect_of(record).names.isdisjoint(self.procedures):
                        state = self.lost(state)
                case e.Apply(name) if name.lower() in self.procedures:
                    state = self.called(name, state)
        if asked:
            # The text may be read before or after the calls in its statement.
            between = _merged_states(begun, state)
            self.before[id(node)] = _merged_states(self.before.get(id(node)), between)
        return state

    def corner(self, blend: Blend | e.Name, otherwise: str) -> str:
        """STOP for a blend that is a stop."""
        known = self.blends.get(blend.name.lower()) if isinstance(blend, e.Name) else blend
        return STOP if known is not None and known.fine else otherwise

    def moved(self, tool: str, frame: str, corner: str, state: MotionState) -> MotionState:
        lines = (state or _ANY)[LINES]
        # A move leaves the corner of the move before it.
        self.lost(state)
        for name in (tool, frame):
            self.spelled.setdefault(name.lower(), name)
        active = (tool.lower(), frame.lower(), corner)
        return *(frozenset((one,)) for one in active), lines

    def called(self, name: str, state: MotionState) -> MotionState:
        key = name.lower()
        if key not in self.procedures:
            return self.lost(state)
        callers = self.calls.setdefault(key, {})
        callers[self.owner] = _merged_states(callers.get(self.owner), state)
        return _resolved(self.after.get(key), state)

    def leave(self, state: MotionState) -> None:
        self.after[self.owner] = _merged_states(self.after.get(self.owner), state)

    def opaque(self, text: str, state: MotionState) -> MotionState:
        """Behind a statement that is kept as its text."""
        steps = self.kept(text)
        if steps is None:
            self.handled.add(self.owner)
            return self.lost(state)
        for step in steps:
            match step:
                case MotionStep.MOVES | MotionStep.CALLS:
                    self.any_called |= step is MotionStep.CALLS
                    return self.lost(state)
                case MotionStep.STOPS:
                    state = _with_part(state, CORNER, STOP)
                case MotionStep.WATCHES | MotionStep.OPENS:
                    state = _with_part(
                        state, LINES, _WATCHED if step is MotionStep.WATCHES else OPEN
                    )
        return state

    def lost(self, state: MotionState) -> MotionState:
        """Return the state after a possible motion of the robot, which has left its last corner."""
        corners = (state or _ANY)[CORNER]
        self.cut |= corners
        if _ENTRY in corners:
            self.cut_before.add(self.owner)
        return _ANY


def _with_part(state: MotionState, part: int, value: str) -> MotionState:
    if state is None:
        return None
    return *state[:part], frozenset((value,)), *state[part + 1 :]


def corner_of(move: p.Statement) -> str:
    """Return the identifier of the corner of a move."""
    return str(id(move))


def _merged_states(*ways: MotionState) -> MotionState:
    """Return the possible state where several paths meet."""
    known = [way for way in ways if way is not None]
    return tuple(map(_union, zip(*known, strict=True))) if known else None


def _union(sets: Iterable[frozenset[str]]) -> frozenset[str]:
    return frozenset().union(*sets)


def _resolved(state: MotionState, given: MotionState) -> MotionState:
    """A state with what held at the call in place of `_ENTRY`; None if none leads there."""
    if state is None or given is None:
        return None
    return tuple(
        (names - {_ENTRY}) | outer if _ENTRY in names else names
        for names, outer in zip(state, given, strict=True)
    )

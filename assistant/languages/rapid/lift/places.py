r"""Where `CRobT` reads the robot's position, as far as it does not say so itself.

Without `\Tool` it reads in the active tool, without `\WObj` in the active work object: those of
the move that the robot made last (RAPID reference manual, CRobT). Which move that is depends on
the way that leads to the place, also through calls.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid import syntax as s
from assistant.languages.rapid import verbatim
from assistant.languages.rapid.lift.expressions import here
from assistant.languages.rapid.signatures import signature
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.diagnostics import Refused
from assistant.program.program import Procedure, Program, bodies
from assistant.program.rewriting import Body, head, map_bodies, map_head, records

State = tuple[frozenset[str], frozenset[str]] | None
"""The tools and frames that may be active, in lower case; None where no way leads to."""

ENTRY: Final = ""
"""Stands for what is active where the procedure is called."""
UNKNOWN: Final = "?"
"""Stands for a tool or frame that the program does not tell."""
_ANY: Final = (frozenset((UNKNOWN,)), frozenset((UNKNOWN,)))
_CALLED: Final = (frozenset((ENTRY,)), frozenset((ENTRY,)))

DIFFERS: Final = e.Reason(
    "it reads in the tool and work object of the move before, which the program does not tell",
    r"write both, as `CRobT(\Tool:=tool0\WObj:=wobj0)`",
)


def with_places(program: Program, original: Callable[[str], str] = str) -> Program:
    """The program with the tool and frame of each `CRobT` that leaves them to the move before.

    One that differs with the way stays as its text. original: gives a shortened name back.
    """
    if not any(map(_reads, records(program.procedures))):
        return program
    flow = _Flow(program)
    made = tuple(_said(flow, q, q.body, original) for q in program.procedures)
    changed = (replace(q, body=b) for q, b in zip(program.procedures, made, strict=True))
    return replace(program, procedures=tuple(changed))


def _said(flow: _Flow, owner: Procedure, body: Body, original: Callable[[str], str]) -> Body:
    made: list[p.Statement] = []
    for node in body:
        if id(node) in flow.before:
            tool, frame = flow.active(owner, node)

            def change(
                x: e.Expression, tool: str | None = tool, frame: str | None = frame
            ) -> e.Expression:
                if not (isinstance(x, e.Verbatim) and _reads(x)):
                    return x
                call = verbatim.expression(x.text)
                assert isinstance(call, s.FunctionCall)
                return here(call, original, tool, frame) or replace(x, reason=DIFFERS)

            node = map_head(node, change)
        made.append(map_bodies(node, lambda inner: _said(flow, owner, inner, original)))
    return tuple(made)


class _Flow:
    """The ways through a program.

    before: by identity of a statement that reads the position, what may be active there, seen
    from its own procedure. after: what a call of each procedure leaves. calls: by procedure,
    then by its callers, what is active at the calls.
    """

    def __init__(self, program: Program) -> None:
        self.procedures = {q.name.lower(): q for q in program.procedures}
        self.spelled: dict[str, str] = {}
        self.before: dict[int, State] = {}
        self.after: dict[str, State] = {}
        self.calls: dict[str, dict[str, State]] = {}
        self.labels: dict[tuple[str, str], State] = {}
        self.owner = ""
        self.any_called = False
        self.handled: set[str] = set()
        """Procedures with error handlers, which may move between any two statements."""
        declared = " ".join(d.text.lower() for d in program.declarations)
        self.elsewhere = {name for name in self.procedures if name in declared}
        """Procedures that are perhaps called by what is kept as its text."""
        while True:
            known = (dict(self.after), dict(self.labels))
            for name, procedure in self.procedures.items():
                self.owner = name
                self.leave(self.body(procedure.body, _CALLED))
            if known == (self.after, self.labels):
                break
        self.entered = self._entered((program.entry or "").lower())

    def active(self, owner: Procedure, node: p.Statement) -> tuple[str | None, str | None]:
        """The tool and frame that are active before a statement, None for what is not known."""
        key = owner.name.lower()
        if key in self.handled:
            return None, None
        state = _resolved(self.before[id(node)], self.entered[key])
        tool, frame = (self._only(names) for names in state or _ANY)
        return tool, frame

    def _only(self, names: frozenset[str]) -> str | None:
        return self.spelled.get(next(iter(names))) if len(names) == 1 else None

    def _entered(self, entry: str) -> dict[str, State]:
        """What may be active where each procedure is called; nobody knows at the start."""
        roots = {n for n in self.procedures if n not in self.calls or self.any_called}
        entered: dict[str, State] = dict.fromkeys((entry, *roots, *self.elsewhere), _ANY)
        while True:
            known = dict(entered)
            for callee, callers in self.calls.items():
                for caller, state in callers.items():
                    given = _resolved(state, entered.get(caller))
                    entered[callee] = _joined(entered.get(callee), given)
            if entered == known:
                return {n: entered.get(n) for n in self.procedures}

    # -------------------------------------------------------------------------- statements

    def body(self, body: Body, state: State) -> State:
        for node in body:
            state = self.statement(node, state)
        return state

    def statement(self, node: p.Statement, state: State) -> State:
        if not isinstance(node, p.Label) and state is None:
            for inner in bodies(node):  # no way leads there but by a label in it
                self.body(inner, None)
            return None
        match node:
            case p.Label(name):
                return _joined(state, self.labels.get((self.owner, name.lower())))
            case p.Goto(name):
                place = self.owner, name.lower()
                self.labels[place] = _joined(self.labels.get(place), state)
                return None
            case p.While(_, body) | p.For(_, _, _, body):
                return self.loop(node, body, state)
            case p.If(branches, otherwise):
                ways: list[State] = []
                for branch in branches:
                    state = self.read(node, branch.condition, state)
                    ways.append(self.body(branch.body, state))
                return _joined(*ways, self.body(otherwise, state))
            case p.Switch(_, cases, otherwise):
                state = self.read(node, head(node), state)
                ways = [self.body(case.body, state) for case in cases]
                return _joined(*ways, self.body(otherwise, state))
        state = self.read(node, node, state)
        match node:
            case (
                p.Move(motion=motion) | p.MoveCircular(motion=motion) | p.MoveJoints(motion=motion)
            ):
                return self.moved(motion.tool, motion.frame)
            case p.Follow(path) if len(path):
                return self.moved(path.tools[path.tool[-1]], path.frames[path.frame[-1]])
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

    def loop(self, node: p.While | p.For, body: Body, state: State) -> State:
        while True:
            begun = self.read(node, head(node), state)
            again = _joined(state, self.body(body, begun))
            if again == state:
                return begun
            state = again

    def read(self, node: p.Statement, value: Any, state: State) -> State:
        """What is active once a value is worked out; notes a statement that reads the position."""
        reading, begun = False, state
        for record in records(value):
            match record:
                case e.Verbatim(text=text) if _reads(record):
                    reading = True
                case e.Verbatim(text=text):
                    for name in self.procedures:
                        if name in text.lower():
                            state = _ANY
                case e.Apply(name) if name.lower() in self.procedures:
                    state = self.called(name, state)
        if reading:
            between = _joined(begun, state)
            self.before[id(node)] = _joined(self.before.get(id(node)), between)
        return state

    def moved(self, tool: str, frame: str) -> State:
        for name in (tool, frame):
            self.spelled.setdefault(name.lower(), name)
        return frozenset((tool.lower(),)), frozenset((frame.lower(),))

    def called(self, name: str, state: State) -> State:
        key = name.lower()
        if key not in self.procedures:
            return _ANY
        callers = self.calls.setdefault(key, {})
        callers[self.owner] = _joined(callers.get(self.owner), state)
        return _resolved(self.after.get(key), state)

    def leave(self, state: State) -> None:
        self.after[self.owner] = _joined(self.after.get(self.owner), state)

    def opaque(self, text: str, state: State) -> State:
        """Behind a statement that is kept as its text."""
        try:
            read = verbatim.statements(text)
        except Refused:  # an error handler, for one
            self.handled.add(self.owner)
            return _ANY
        for node in read:
            if not isinstance(node, s.Data) and not _stands_still(node):
                self.any_called |= not _is_standard(node)
                return _ANY
        return state


def _is_standard(node: s.StatementNode) -> bool:
    return (
        isinstance(node, s.ProcedureCall)
        and isinstance(node.name, str)
        and signature(node.name) is not None
    )


def _stands_still(node: s.StatementNode) -> bool:
    """Whether it is an instruction that is given no tool, so that it makes no other one active."""
    if not isinstance(node, s.ProcedureCall) or not isinstance(node.name, str):
        return False
    known = signature(node.name)
    if known is None or known.open:
        return False
    return not any(q.type == "tooldata" for slot in known.slots for q in slot.alternatives)


def _reads(record: Any) -> bool:
    match record:
        case e.Verbatim(verbatim.LANGUAGE, text):
            return text.lower().startswith("crobt(")
    return False


def _joined(*ways: State) -> State:
    """What may be active where several ways meet."""
    known = [way for way in ways if way is not None]
    if not known:
        return None
    return _union(t for t, _ in known), _union(f for _, f in known)


def _union(sets: Iterable[frozenset[str]]) -> frozenset[str]:
    return frozenset().union(*sets)


def _resolved(state: State, given: State) -> State:
    """A state with what was active at the call in place of `ENTRY`; None if none leads there."""
    if state is None or given is None:
        return None
    tools, frames = state
    return _put(tools, given[0]), _put(frames, given[1])


def _put(names: frozenset[str], given: frozenset[str]) -> frozenset[str]:
    return (names - {ENTRY}) | given if ENTRY in names else names

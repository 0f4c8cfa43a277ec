"""Which errors the procedures of RAPID raise, take, and leave to those that call them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

from assistant.base.diagnostics import Findings
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.instructions import NameResolver
from assistant.languages.rapid.lift.statements import StatementLift
from assistant.languages.rapid.lift.told import handlers as h
from assistant.languages.rapid.lift.told import searching
from assistant.languages.rapid.lift.told.waits import wait_condition
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure, Program, TakenNames, identifier, walk
from assistant.program.rewriting import Body, is_repeatable

EXIT_CYCLE: Final = "exitcycle"
"""Stands for the end of the cycle, which no handler is for."""
ZERO: Final = e.Number(0)


@dataclass(frozen=True, slots=True)
class _Handled:
    """A procedure apart from its handler. text: that says the handler, None if it has none."""

    procedure: Procedure
    handler: s.Handler | None
    text: p.Opaque | None


class RaisedErrors:
    """numbers: by which errors are told. leaves: by procedure, what it may leave to its callers.

    label: counts the places that are jumped to.
    """

    def __init__(self, program: Program, lift: StatementLift, findings: Findings) -> None:
        self.program, self.lift, self.findings = program, lift, findings
        self.meaning = NameResolver(
            speeds={name.lower(): one for name, one in program.speeds.items()},
            blends={name.lower(): one for name, one in program.blends.items()},
        )
        self.known = {q.name.lower(): self._apart(q) for q in program.procedures}
        self.entry = (program.entry or "").lower()
        self.taken = TakenNames(n for q in program.procedures for n in q.variables)
        self.taken.update(program.variables, program.signals, program.targets)
        self.error = e.Name(identifier("error_number", self.taken))
        self.numbers: dict[str, int] = {EXIT_CYCLE: -1}
        self.called = {key: _called_names(one.procedure.body) for key, one in self.known.items()}
        self.callers: dict[str, set[str]] = {key: set() for key in self.known}
        for key, names in self.called.items():
            for name in names & self.known.keys():
                self.callers[name].add(key)
        self.begun = {key: _own_errors(one.procedure.body) for key, one in self.known.items()}
        """By procedure, the errors that its own statements may raise."""
        self.above: dict[str, set[str]] = {}
        self.about: dict[tuple[str, str], Body | None] = {}
        self.leaves: dict[str, frozenset[str]] = dict.fromkeys(self.known, frozenset())
        self._settle()
        self.at = 0

    def _apart(self, procedure: Procedure) -> _Handled:
        """A procedure and its error handler; its others are left out, with a finding."""
        body, handler, text = [], None, None
        for node in procedure.body:
            found = h.handlers_of(node)
            if not found:
                body.append(node)
                continue
            with self.findings.at(node.span):
                for one in found:
                    if one.kind == "ERROR":
                        handler, text = one, node
                    else:
                        loss, cure = _OTHER_HANDLERS[one.kind]
                        what = f"{one.kind} of {procedure.name}"
                        self.findings.append(rules.LEFT_OUT(what=what, loss=loss, cure=cure))
        assert text is None or isinstance(text, p.Opaque)
        return _Handled(replace(procedure, body=tuple(body)), handler, text)

    # ------------------------------------------------------------------------- which errors

    def _settle(self) -> None:
        """Finds what each procedure leaves to those that call it."""
        pending = dict.fromkeys(reversed(self.known))
        while pending:
            key, _ = pending.popitem()
            one = self.known[key].procedure
            if one.result is not None or key == self.entry:
                continue
            found = frozenset(
                after
                for error in self.raised(key)
                for after in self._after(key, error)
                if after == EXIT_CYCLE or key in self._taken_above(after)
            )
            if found != self.leaves[key]:
                self.leaves[key] = found
                pending |= dict.fromkeys(self.callers[key])

    def raised(self, key: str) -> set[str]:
        """What may happen in a procedure, without what its handler does."""
        left = {name for one in self.called[key] for name in self.leaves.get(one, ())}
        return left | self.begun[key]

    def _after(self, key: str, error: str) -> set[str]:
        """What of an error in a procedure is left behind its handler."""
        handler = self.known[key].handler
        if error == EXIT_CYCLE or not h.handles(handler, error):
            return {error}
        body = self.left(key, error)
        names = (h.raised_error(node) for node in walk(body or ()))
        return {name or error for name in names if name is not None}

    def left(self, key: str, error: str) -> Body | None:
        """What the handler of a procedure does about an error, None if that is not said."""
        if (key, error) not in self.about:
            one, body = self.known[key], None
            if one.handler is not None and one.text is not None and h.handles(one.handler, error):
                body = h.reduced_handler(one.handler, error, self.lift, one.text.span)
            self.about[key, error] = body
        return self.about[key, error]

    def _taken_above(self, error: str) -> set[str]:
        """The procedures whose callers, or theirs, have a handler for an error."""
        if error not in self.above:
            found: set[str] = set()
            pending = [key for key in self.known if self.left(key, error) is not None]
            while pending:
                for name in self.called[pending.pop()] & self.known.keys():
                    if name not in found:
                        found.add(name)
                        if not h.handles(self.known[name].handler, error):
                            pending.append(name)
            self.above[error] = found
        return self.above[error]

    def number(self, error: str) -> e.Number:
        return e.Number(self.numbers.setdefault(error, len(self.numbers)))

    def label(self, what: str) -> str:
        self.at += 1
        return identifier(f"{what}_{self.at}", self.taken)


_OTHER_HANDLERS: Final = {
    "UNDO": (
        "it is not done when somebody takes the program out of the procedure",
        "see to it in the start of the program",
    ),
    "BACKWARD": ("the program cannot be stepped backwards through it", "none is needed"),
}


def limited_wait(node: p.Statement) -> p.WaitSignal | p.WaitUntil | None:
    """A wait with a longest time."""
    if isinstance(node, p.WaitSignal | p.WaitUntil) and node.timeout is not None:
        return node if is_repeatable(wait_condition(node)) else None
    return None


def _own_errors(body: Body) -> set[str]:
    found: set[str] = set()
    for node in walk(body):
        if limited_wait(node) is not None:
            found.add(h.WAIT_TIMEOUT)
        elif searching.is_search(node):
            found |= {searching.SIGNAL_EARLY, searching.SIGNAL_MISSED}
        elif name := h.raised_error(node):
            found.add(name)
        elif h.exit_word(node) == "EXITCYCLE":
            found.add(EXIT_CYCLE)
    return found


def _called_names(body: Body) -> set[str]:
    return {node.procedure.lower() for node in walk(body) if isinstance(node, p.Call)}

"""Errors of RAPID and their handlers, as tests after the statements that may raise them.

Translated are the time limit of a wait, the errors of a search and those that a program raises
itself; a procedure that leaves an error to its callers sets a number and returns. `ExitCycle` leads
out of all procedures in the same way. Any other error stops the program, as it does without a
handler. A statement is tried again 4 times (system parameters: No Of Retry).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Findings
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.statements import NameResolver, StatementLift
from assistant.languages.rapid.lift.vendor_only import error_handlers as h
from assistant.languages.rapid.lift.vendor_only import stopped_moves
from assistant.languages.rapid.lift.vendor_only.interrupts import with_interrupt_errors
from assistant.languages.rapid.lift.vendor_only.waits import wait_condition, wait_until_over
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.io_use import with_used_signals
from assistant.program.program import Procedure, Program, TakenNames, Variable, identifier, walk
from assistant.program.rewriting import Body, is_repeatable, map_bodies, map_expressions, records

_EXIT_CYCLE: Final = "exitcycle"
"""Stands for the end of the cycle, which no handler is for."""
_ZERO: Final = e.Number(0)


@dataclass(frozen=True, slots=True)
class _Handled:
    """A procedure apart from its handler. text: that says the handler, None if it has none."""

    procedure: Procedure
    handler: s.Handler | None
    text: p.Opaque | None


class _RaisedErrors:
    """Errors that procedures raise. numbers: the numbers of errors. leaves: by procedure, the
    errors that it may leave to its callers.

    label: counts the labels that are jumped to.
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
        self.numbers: dict[str, int] = {_EXIT_CYCLE: -1}
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
        # A change for one procedure concerns its callers, which are visited again until nothing
        # changes.
        pending = dict.fromkeys(reversed(self.known))
        while pending:
            key, _ = pending.popitem()
            one = self.known[key].procedure
            # A function cannot return without a value, and nothing calls the entry.
            if one.result is not None or key == self.entry:
                continue
            found = frozenset(
                after
                for error in self.raised(key)
                for after in self._after(key, error)
                # An error that no caller handles stops the program where it occurs.
                if after == _EXIT_CYCLE or key in self._taken_above(after)
            )
            if found != self.leaves[key]:
                self.leaves[key] = found
                pending |= dict.fromkeys(self.callers[key])

    def raised(self, key: str) -> set[str]:
        """Return the errors that may occur in a procedure, without the effect of its handler."""
        left = {name for one in self.called[key] for name in self.leaves.get(one, ())}
        return left | self.begun[key]

    def _after(self, key: str, error: str) -> set[str]:
        """Return the errors that remain after a procedure's handler has treated one."""
        handler = self.known[key].handler
        if error == _EXIT_CYCLE or not h.handles(handler, error):
            return {error}
        body = self.left(key, error)
        names = (h.raised_error(node) for node in walk(body or ()))
        return {name or error for name in names if name is not None}

    def left(self, key: str, error: str) -> Body | None:
        """Return the statements of a procedure's handler for an error, None if they have no
        translation.
        """
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
                        # A handler on the way takes the error, so it goes no further down from
                        # there.
                        if not h.handles(self.known[name].handler, error):
                            pending.append(name)
            self.above[error] = found
        return self.above[error]

    def number(self, error: str) -> e.Number:
        # The end of the cycle has -1, so the other errors count from 1.
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


def _limited_wait(node: p.Statement) -> p.WaitSignal | p.WaitUntil | None:
    """A wait with a longest time."""
    if isinstance(node, p.WaitSignal | p.WaitUntil) and node.timeout is not None:
        # The condition is asked once more when the time is over.
        return node if is_repeatable(wait_condition(node)) else None
    return None


def _own_errors(body: Body) -> set[str]:
    found: set[str] = set()
    for node in walk(body):
        if _limited_wait(node) is not None:
            found.add(h.WAIT_TIMEOUT)
        elif stopped_moves.is_search(node):
            found |= {stopped_moves.SIGNAL_EARLY, stopped_moves.SIGNAL_MISSED}
        elif name := h.raised_error(node):
            found.add(name)
        elif h.exit_word(node) == "EXITCYCLE":
            found.add(_EXIT_CYCLE)
    return found


def _called_names(body: Body) -> set[str]:
    return {node.procedure.lower() for node in walk(body) if isinstance(node, p.Call)}


_RETRIES: Final = 4
"""Maximum retries of a statement (system parameters: No Of Retry)."""
_REMAINING_RETRIES: Final = "remainingretries"
_STOP: Final = p.Stop(end=True)


class _ErrorLowering:
    """One procedure. own: variables that it gets."""

    def __init__(self, errors: _RaisedErrors, key: str) -> None:
        self.errors, self.key = errors, key
        self.own: dict[str, Variable] = {}
        taken = TakenNames(errors.taken)
        self.over = e.Name(identifier("too_long", taken))
        self.tries = e.Name(identifier("retries", taken))
        self.before = e.Name(identifier("seen_before", taken))

    def body(self, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            node = map_bodies(node, self.body)
            parts = tuple(self.statement(node))
            # Statements made for another one belong to its source line.
            made += (x if x.span else replace(x, span=node.span) for x in parts)
        return tuple(made)

    def statement(self, node: p.Statement) -> Iterator[p.Statement]:
        errors = self.errors
        wait = _limited_wait(node)
        if wait is not None and self._is_taken(h.WAIT_TIMEOUT):
            self.own[self.over.name] = Variable("truth")
            yield from self.tried(
                (*wait_until_over(wait, self.over),), self.over, h.WAIT_TIMEOUT, None
            )
        elif name := h.raised_error(node):
            if self._is_taken(name):
                yield from self.tried((), None, name, None)
            else:
                # Without a handler a raised error stops the program, as in RAPID.
                with errors.findings.at(node.span):
                    errors.findings.append(rules.STOPS(name=name))
                yield _STOP
        elif stopped_moves.is_search(node):
            yield from self.searched(node)
        elif h.exit_word(node) == "EXITCYCLE":
            yield from self.exit(node)
        elif isinstance(node, p.Call) and (left := errors.leaves.get(node.procedure.lower())):
            yield from self.called(node, sorted(left))
        elif (
            isinstance(node, p.Interrupt)
            and _EXIT_CYCLE in errors.leaves[node.call.procedure.lower()]
        ):
            yield replace(node, ends=e.Binary("<>", errors.error, _ZERO))
        else:
            yield node

    def searched(self, node: p.Statement) -> Iterator[p.Statement]:
        """Yield a search, which may end in an error; the vendor statement itself if it cannot be
        expressed.
        """
        errors = self.errors
        search = stopped_moves.search_of(node, errors.program, errors.meaning)
        if search is None:
            yield node
            return
        taken = [name for name in search.errors if self._is_taken(name)]

        def fails(name: str) -> Body:
            if name in taken:
                return (p.Assign(errors.error, errors.number(name)),)
            errors.findings.append(rules.STOPS(name=name.upper()))
            return (_STOP,)

        def seen() -> e.Name:
            self.own[self.before.name] = Variable("number")
            return self.before

        with errors.findings.at(node.span):
            act = tuple(search.said(fails, seen))
            for what, why in search.losses:
                errors.findings.append(rules.LEFT_OUT(what=what, loss=why[0], cure=why[1]))
        yield from self.tried(act, None, taken[0], taken) if taken else act

    def _is_taken(self, error: str) -> bool:
        """True if this procedure or a caller has a handler for the error."""
        if self.errors.left(self.key, error) is not None:
            return True
        return error in self.errors.leaves[self.key]

    def exit(self, node: p.Statement) -> Iterator[p.Statement]:
        """The end of the cycle: out of the entry at once, else by way of all callers."""
        if self.key == self.errors.entry:
            yield p.Return()
        elif _EXIT_CYCLE in self.errors.leaves[self.key]:
            yield p.Assign(self.errors.error, self.errors.number(_EXIT_CYCLE))
            yield p.Return()
        else:
            yield node

    def called(self, node: p.Call, left: list[str]) -> Iterator[p.Statement]:
        """A call, and what becomes of the errors that it leaves."""
        error = self.errors.error
        # The end of the cycle passes through every caller; only the entry clears it.
        if left == [_EXIT_CYCLE]:
            yield node
            back: Body = (p.Return(),)
            if self.key == self.errors.entry:
                back = (p.Assign(error, _ZERO), p.Return())
            yield p.If((p.Branch(e.Binary("<>", error, _ZERO), back),))
            return
        yield from self.tried((node,), None, left[0], left)

    def tried(
        self,
        act: Body,
        over: e.Name | None,
        error: str,
        left: list[str] | None,
    ) -> Iterator[p.Statement]:
        """Yield an action and the handling of its error. over: condition of the error, None if it
        always occurs.

        left: errors of a call, which the error number identifies.
        """
        again, behind = self.errors.label("again"), self.errors.label("behind")
        number = self.errors.error
        if left is None:
            cared: Body = self.cared(error, again, behind)
        else:
            branches = tuple(
                p.Branch(
                    e.Binary("=", number, self.errors.number(one)),
                    self.cared(one, again, behind, called=True),
                )
                for one in left
            )
            # Equal treatments need no question which error it was.
            alike = all(one.body == branches[0].body for one in branches)
            cared = branches[0].body if alike else (p.If(branches),)
        # Only labels that are jumped to are written.
        jumps = {node.label for node in walk(cared) if isinstance(node, p.Goto)}
        if again in jumps or self.tries in records(cared):
            yield p.Assign(self.tries, _ZERO)
        if again in jumps:
            yield p.Label(again)
        yield from act
        if left is not None:
            yield p.If((p.Branch(e.Binary("<>", number, _ZERO), cared),))
        elif over is not None:
            yield p.If((p.Branch(over, cared),))
        else:
            yield from cared
        if behind in jumps:
            yield p.Label(behind)

    def cared(self, error: str, again: str, behind: str, called: bool = False) -> Body:
        """Return the handling of an error, with jumps to the retry and to the next statement."""
        clear: Body = (p.Assign(self.errors.error, _ZERO),) if called else ()
        if error == _EXIT_CYCLE:
            return (*clear, p.Return()) if self.key == self.errors.entry else (p.Return(),)
        body = self.errors.left(self.key, error)
        if body is not None and error in (stopped_moves.SIGNAL_EARLY, stopped_moves.SIGNAL_MISSED):
            body = stopped_moves.without_path_recovery(body)
        if body is None:
            # The called procedure has set the number of the error already.
            return tuple(self.leave(error))[-1:] if called else tuple(self.leave(error))
        body = tuple(map_expressions(node, self.left_to_try) for node in body)
        # A handler that reaches its end stops the program.
        if not _always_exits(body):
            body = (*body, _STOP)
        return (*clear, *self.settled(body, error, again, behind, tail=True))

    def left_to_try(self, x: e.Expression) -> e.Expression:
        """`RemainingRetries()` of a handler: how often it may still be tried again."""
        if isinstance(x, e.Apply) and x.function.lower() == _REMAINING_RETRIES:
            self.own[self.tries.name] = Variable("number")
            return e.Binary("-", e.Number(_RETRIES), self.tries)
        return x

    def leave(self, error: str) -> Iterator[p.Statement]:
        """An error is left to the callers, if any of them is for it."""
        if error in self.errors.leaves[self.key]:
            yield p.Assign(self.errors.error, self.errors.number(error))
            yield p.Return()
        else:
            yield _STOP

    def settled(self, body: Body, error: str, again: str, behind: str, *, tail: bool) -> Body:
        """Return the translated statements of a handler. tail: the label `behind` follows
        directly.
        """
        made: list[p.Statement] = []
        for place, node in enumerate(body):
            last = tail and place == len(body) - 1
            match h.exit_word(node), h.raised_error(node):
                case "RETRY", _:
                    made += self.again(again)
                case "TRYNEXT", _:
                    # The label follows anyway.
                    made += () if last else (p.Goto(behind),)
                case "RESETRETRYCOUNT", _:
                    self.own[self.tries.name] = Variable("number")
                    made.append(p.Assign(self.tries, _ZERO))
                case "EXITCYCLE", _:
                    made += self.exit(node)
                case _, str() as name:
                    made += self.leave(name or error)
                case _:
                    inner = partial(
                        self.settled,
                        error=error,
                        again=again,
                        behind=behind,
                        # Only branches of an IF at the end lead straight to the label; a loop body
                        # does not.
                        tail=last and isinstance(node, p.If),
                    )
                    made.append(map_bodies(node, inner))
                    made += self.stopped_by(node)
            if _always_exits((node,)):
                break  # nothing leads behind it
        return tuple(made)

    def stopped_by(self, node: p.Statement) -> Iterator[p.Statement]:
        """An error in a handler stops the program."""
        if isinstance(node, p.Call) and self.errors.leaves.get(node.procedure.lower()):
            yield p.If((p.Branch(e.Binary("<>", self.errors.error, _ZERO), (_STOP,)),))

    def again(self, label: str) -> Iterator[p.Statement]:
        """Once more, if that was not too often."""
        self.own[self.tries.name] = Variable("number")
        often = e.Binary(">=", self.tries, e.Number(_RETRIES))
        yield p.Comment(f"after {_RETRIES} retries RAPID gives up with an error")
        yield p.If((p.Branch(often, (_STOP,)),))
        yield p.Assign(self.tries, e.Binary("+", self.tries, e.Number(1)))
        yield p.Goto(label)


def _always_exits(body: Body) -> bool:
    """True if the statements of a handler always end with an explicit exit."""
    if not body:
        return False
    match body[-1]:
        case p.Return() | p.Stop(end=True):
            return True
        case p.If(branches, otherwise):
            return _always_exits(otherwise) and all(_always_exits(b.body) for b in branches)
        case p.Opaque() as node:
            return h.raised_error(node) is not None or h.exit_word(node) in (
                "RETRY",
                "TRYNEXT",
                "EXITCYCLE",
            )
    return False


def with_errors(program: Program, lift: StatementLift, findings: Findings) -> Program:
    """Return the program with the statements of its handlers where their errors may occur. lift:
    lifts those statements.
    """
    if not any(_involves_errors(node) for node in program.statements()):
        return program
    return _with_error_tests(_RaisedErrors(program, lift, findings))


def _involves_errors(node: p.Statement) -> bool:
    if h.handlers_of(node) or stopped_moves.is_search(node):
        return True
    return h.raised_error(node) is not None or h.exit_word(node) == "EXITCYCLE"


def _with_error_tests(errors: _RaisedErrors) -> Program:
    procedures = tuple(_tested_procedure(errors, key) for key in errors.known)
    signals = with_used_signals(errors.program.signals, errors.meaning.used)
    program = replace(errors.program, procedures=procedures, signals=signals)
    program = with_interrupt_errors(program, errors.error)
    procedures = program.procedures
    # No error is handed on, so no number is needed.
    if not any(record == errors.error for record in records(procedures)):
        return program
    # A run may follow one that stopped with an error.
    first: Body = (p.Assign(errors.error, _ZERO),)
    procedures = tuple(
        replace(q, body=first + q.body) if q.name.lower() == errors.entry else q for q in procedures
    )
    variables = {**program.variables, errors.error.name: Variable("number")}
    return replace(program, procedures=procedures, variables=variables)


def _tested_procedure(errors: _RaisedErrors, key: str) -> Procedure:
    one = errors.known[key]
    if one.text is not None:
        said = sorted(x for x in errors.raised(key) if errors.left(key, x) is not None)
        with errors.findings.at(one.text.span):
            errors.findings.append(rules.HANDLED(
                name=one.procedure.name, errors=", ".join(said) or "none of its errors"
            ))  # fmt: skip
    making = _ErrorLowering(errors, key)
    body = making.body(one.procedure.body)
    return replace(one.procedure, body=body, variables={**one.procedure.variables, **making.own})

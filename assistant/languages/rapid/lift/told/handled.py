"""One procedure of RAPID with what its handler does, as tests behind what may raise its errors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Final

from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.told import handlers as h
from assistant.languages.rapid.lift.told import searching
from assistant.languages.rapid.lift.told.raising import EXIT_CYCLE, ZERO, RaisedErrors, limited_wait
from assistant.languages.rapid.lift.told.waits import wait_until_over
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import TakenNames, Variable, identifier, walk
from assistant.program.rewriting import Body, map_bodies, map_expressions, records

RETRIES: Final = 4
"""How often a statement is tried again (system parameters: No Of Retry)."""
REMAINING_RETRIES: Final = "remainingretries"
_STOP: Final = p.Stop(end=True)


class ErrorLowering:
    """One procedure. own: variables that it gets."""

    def __init__(self, errors: RaisedErrors, key: str) -> None:
        self.errors, self.key = errors, key
        self.own: dict[str, Variable] = {}
        taken = TakenNames(errors.taken)
        self.over = e.Name(identifier("too_long", taken))
        self.tries = e.Name(identifier("tries", taken))
        self.before = e.Name(identifier("seen_before", taken))

    def body(self, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            node = map_bodies(node, self.body)
            parts = tuple(self.statement(node))
            made += (x if x.span else replace(x, span=node.span) for x in parts)
        return tuple(made)

    def statement(self, node: p.Statement) -> Iterator[p.Statement]:
        errors = self.errors
        wait = limited_wait(node)
        if wait is not None and self._is_taken(h.WAIT_TIMEOUT):
            self.own[self.over.name] = Variable("truth")
            yield from self.tried(
                (*wait_until_over(wait, self.over),), self.over, h.WAIT_TIMEOUT, None
            )
        elif name := h.raised_error(node):
            if self._is_taken(name):
                yield from self.tried((), None, name, None)
            else:
                with errors.findings.at(node.span):
                    errors.findings.append(rules.STOPS(name=name))
                yield _STOP
        elif searching.is_search(node):
            yield from self.searched(node)
        elif h.exit_word(node) == "EXITCYCLE":
            yield from self.exit(node)
        elif isinstance(node, p.Call) and (left := errors.leaves.get(node.procedure.lower())):
            yield from self.called(node, sorted(left))
        elif (
            isinstance(node, p.Interrupt)
            and EXIT_CYCLE in errors.leaves[node.call.procedure.lower()]
        ):
            yield replace(node, ends=e.Binary("<>", errors.error, ZERO))
        else:
            yield node

    def searched(self, node: p.Statement) -> Iterator[p.Statement]:
        """A search, which may end in an error; the text itself where it cannot be said."""
        errors = self.errors
        search = searching.search_of(node, errors.program, errors.meaning)
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
        """Whether a handler is for an error, this one or one above."""
        if self.errors.left(self.key, error) is not None:
            return True
        return error in self.errors.leaves[self.key]

    def exit(self, node: p.Statement) -> Iterator[p.Statement]:
        """The end of the cycle: out of the entry at once, else by way of all callers."""
        if self.key == self.errors.entry:
            yield p.Return()
        elif EXIT_CYCLE in self.errors.leaves[self.key]:
            yield p.Assign(self.errors.error, self.errors.number(EXIT_CYCLE))
            yield p.Return()
        else:
            yield node

    def called(self, node: p.Call, left: list[str]) -> Iterator[p.Statement]:
        """A call, and what becomes of the errors that it leaves."""
        error = self.errors.error
        if left == [EXIT_CYCLE]:
            yield node
            back: Body = (p.Return(),)
            if self.key == self.errors.entry:
                back = (p.Assign(error, ZERO), p.Return())
            yield p.If((p.Branch(e.Binary("<>", error, ZERO), back),))
            return
        yield from self.tried((node,), None, left[0], left)

    def tried(
        self,
        act: Body,
        over: e.Name | None,
        error: str,
        left: list[str] | None,
    ) -> Iterator[p.Statement]:
        """An act and what is done about its error; over: what tells of it, None for always.

        left: errors of a call, of which the number of the error tells.
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
            alike = all(one.body == branches[0].body for one in branches)
            cared = branches[0].body if alike else (p.If(branches),)
        jumps = {node.label for node in walk(cared) if isinstance(node, p.Goto)}
        if again in jumps or self.tries in records(cared):
            yield p.Assign(self.tries, ZERO)
        if again in jumps:
            yield p.Label(again)
        yield from act
        if left is not None:
            yield p.If((p.Branch(e.Binary("<>", number, ZERO), cared),))
        elif over is not None:
            yield p.If((p.Branch(over, cared),))
        else:
            yield from cared
        if behind in jumps:
            yield p.Label(behind)

    def cared(self, error: str, again: str, behind: str, called: bool = False) -> Body:
        """What is done about an error, with jumps to where it is tried again, or behind it."""
        clear: Body = (p.Assign(self.errors.error, ZERO),) if called else ()
        if error == EXIT_CYCLE:
            return (*clear, p.Return()) if self.key == self.errors.entry else (p.Return(),)
        body = self.errors.left(self.key, error)
        if body is not None and error in (searching.SIGNAL_EARLY, searching.SIGNAL_MISSED):
            body = searching.without_path_recovery(body)
        if body is None:
            return tuple(self.leave(error))[-1:] if called else tuple(self.leave(error))
        body = tuple(map_expressions(node, self.left_to_try) for node in body)
        if not _always_exits(body):
            body = (*body, _STOP)
        return (*clear, *self.settled(body, error, again, behind, tail=True))

    def left_to_try(self, x: e.Expression) -> e.Expression:
        """`RemainingRetries()` of a handler: how often it may still be tried again."""
        if isinstance(x, e.Apply) and x.function.lower() == REMAINING_RETRIES:
            self.own[self.tries.name] = Variable("number")
            return e.Binary("-", e.Number(RETRIES), self.tries)
        return x

    def leave(self, error: str) -> Iterator[p.Statement]:
        """An error is left to the callers, if any of them is for it."""
        if error in self.errors.leaves[self.key]:
            yield p.Assign(self.errors.error, self.errors.number(error))
            yield p.Return()
        else:
            yield _STOP

    def settled(self, body: Body, error: str, again: str, behind: str, *, tail: bool) -> Body:
        """Statements of a handler as they are said. tail: whether `behind` follows them."""
        made: list[p.Statement] = []
        for place, node in enumerate(body):
            last = tail and place == len(body) - 1
            match h.exit_word(node), h.raised_error(node):
                case "RETRY", _:
                    made += self.again(again)
                case "TRYNEXT", _:
                    made += () if last else (p.Goto(behind),)
                case "RESETRETRYCOUNT", _:
                    self.own[self.tries.name] = Variable("number")
                    made.append(p.Assign(self.tries, ZERO))
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
            yield p.If((p.Branch(e.Binary("<>", self.errors.error, ZERO), (_STOP,)),))

    def again(self, label: str) -> Iterator[p.Statement]:
        """Once more, if that was not too often."""
        self.own[self.tries.name] = Variable("number")
        often = e.Binary(">=", self.tries, e.Number(RETRIES))
        yield p.If((p.Branch(often, (_STOP,)),))
        yield p.Assign(self.tries, e.Binary("+", self.tries, e.Number(1)))
        yield p.Goto(label)


def _always_exits(body: Body) -> bool:
    """Whether nothing leads behind statements of a handler but what says where."""
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

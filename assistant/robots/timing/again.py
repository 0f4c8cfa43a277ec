"""Loops of which only the run tells how often they go round.

One round is timed. The ways of the others are gone through as well, as they may begin where the
round before ended, or may not be gone at all: what looks for collisions wants to know.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from assistant.program.program import walk
from assistant.program.rewriting import Body
from assistant.program.statements import Assign
from assistant.robots.timing.ledger import Ledger
from assistant.robots.timing.state import State, merged_state
from assistant.robots.timing.variables import root_variable

if TYPE_CHECKING:
    from assistant.robots.timing.walking import Walker

MOST_ROUNDS: Final = 8
"""Rounds of a loop that may begin in states of their own."""


def time_one_round(walker: Walker, body: Body, state: State, *, ever: bool) -> State | None:
    """The state behind a loop that is entered in a state, after the time of one round.

    ever: it has no end, so that it is not left out either.
    """
    assigned = {root_variable(s.target) for s in walk(body) if isinstance(s, Assign)}
    begin = state.without(assigned)
    end = walker.inner(body, begin)
    if end is None:
        return None if ever else begin
    done = state.then(end).without(assigned)
    ends = _further_rounds(walker, body, begin, end, done, assigned)
    others = [*ends] if ever else [*ends, begin]
    return merged_state([done, *(_after_same_time(done, one) for one in others)])


def _further_rounds(
    walker: Walker, body: Body, begin: State, end: State, done: State, assigned: set[str]
) -> list[State]:
    """How the rounds behind the first end, until they begin as others began."""
    begun, ends, mark = [begin], list[State](), len(walker.returned)
    with _uncounted(walker):
        for _ in range(MOST_ROUNDS):
            later = end.without(assigned).known
            changed = {name for name in later if later[name] != begin.known.get(name)}
            begin = end.without(assigned | changed)
            if any(one.same_state(begin) for one in begun):
                break
            begun.append(begin)
            following = walker.inner(body, begin)
            if following is None:
                break
            end = following
            ends.append(end)
        else:
            walker.note("a loop begins at many places; ways of its last rounds are not timed")
    walker.returned[mark:] = [_after_same_time(done, one) for one in walker.returned[mark:]]
    return ends


def _after_same_time(done: State, other: State) -> State:
    """Another state, after the time that one is after."""
    return replace(other, least=done.least, most=done.most, history=done.history)


@contextmanager
def _uncounted(walker: Walker) -> Iterator[None]:
    """What is gone through within takes no time, and is noted only if it is not known."""
    ledger, procedures = walker.ledger, dict(walker.procedures)
    counts = walker.statements, walker.called
    walker.ledger = Ledger()
    yield
    for (procedure, what), times in walker.ledger.notes.items():
        if "not timed" in what:
            ledger.notes.setdefault((procedure, what), times)
    walker.ledger, walker.procedures = ledger, procedures
    walker.statements, walker.called = counts

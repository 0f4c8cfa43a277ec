"""What interrupts may set between any two lines, while they are switched on.

A subroutine that an interrupt calls goes back to where the program was, with all that it has set.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from assistant.languages.line_graph import EXIT
from assistant.languages.settings.flow import (
    Calls,
    Either,
    LineEffects,
    MaySet,
    Steps,
    calls_in,
    sets_in,
)
from assistant.languages.settings.places import ELSEWHERE, NO_LINES, LineSet
from assistant.program.analysis.dataflow import reachable


@dataclass(frozen=True, slots=True)
class Interrupt:
    """Lines, by place: where what it calls begins, those that may switch it on, and that switch
    it off for sure. answer: the procedure that it alone calls, if that is one.
    """

    called: frozenset[int]
    on: frozenset[int]
    off: frozenset[int]
    answer: int | None = None


def with_interrupts(
    lines: LineEffects, interrupts: Sequence[Interrupt], elsewhere: frozenset[int]
) -> LineEffects:
    """The lines with what interrupts may set while each of them runs.

    All that interrupts call is among `lost`. elsewhere: settings that interrupts of other programs
    may set at any line.
    """
    if not interrupts and not elsewhere:
        return lines
    ways = _ProgramGraph(lines)
    may_set: dict[int, dict[int, LineSet]] = {}
    may_call: dict[int, list[int]] = {}
    for at in ways.all if elsewhere else ():
        may_set[at] = dict.fromkeys(elsewhere, LineSet.of([ELSEWHERE]))
    for interrupt in interrupts:
        if interrupt.answer is not None:
            own = frozenset(lines.procedures[interrupt.answer])
            for at in frozenset(ways.running(interrupt)) - own:
                may_call.setdefault(at, []).append(interrupt.answer)
            continue
        changed = ways.settings(interrupt.called)
        for at in ways.running(interrupt) if changed else ():
            here = may_set.setdefault(at, {})
            for setting, by in changed.items():
                here[setting] = here.get(setting, NO_LINES) | by
    steps = dict(lines.steps)
    for at, here in may_set.items():
        interrupted: Steps = tuple(MaySet(*one) for one in here.items())
        steps[at] = (*steps.get(at, ()), *interrupted)
    for at, called in may_call.items():
        answered: Steps = tuple(Either(((Calls((one,)),), ())) for one in called)
        steps[at] = (*steps.get(at, ()), *answered)
    return replace(lines, steps=steps)


class _ProgramGraph:
    """The ways through all procedures, from calls into what they call as well."""

    def __init__(self, lines: LineEffects) -> None:
        self.lines = lines
        self.all = [at for places in lines.procedures for at in places]
        self._after: Mapping[int, Sequence[int]] = {
            at: [to for to in ways if to != EXIT]
            for following in lines.after
            for at, ways in following.items()
        }
        self._before: dict[int, list[int]] = {}
        for at in self._after:
            for to in self._next(at):
                self._before.setdefault(to, []).append(at)

    def settings(self, starts: Iterable[int]) -> dict[int, LineSet]:
        """What may be set from some lines on, each with the lines that set it."""
        found: dict[int, set[int]] = {}
        for at in reachable(starts, self._next):
            steps = self.lines.steps.get(at, ())
            unknown = (one for one in calls_in(steps) if isinstance(one, frozenset))
            for setting in {one.setting for one in sets_in(steps)}.union(*unknown):
                found.setdefault(setting, set()).add(at)
        return {setting: LineSet.of(lines) for setting, lines in found.items()}

    def running(self, interrupt: Interrupt) -> Iterable[int]:
        """Lines that may run while an interrupt is on, and those that switch it on.

        What is come to in ways that nobody knows may run at any time; if that switches it on, then
        all may.
        """
        if not interrupt.on:
            return ()
        if self._come_to(interrupt.on, self.lines.lost):
            return self.all
        leading = reachable(interrupt.on, lambda at: self._before.get(at, ()))
        on = {
            at for at in self.all if at in interrupt.on or not leading.isdisjoint(self._callees(at))
        }
        starts = {to for at in on for to in self._after[at]} | self.lines.lost
        off = interrupt.off - interrupt.on
        return on | reachable(starts, lambda at: () if at in off else self._next(at))

    def _come_to(self, places: frozenset[int], starts: Iterable[int]) -> bool:
        """Whether any of some places can be come to."""
        found: set[int] = reachable(starts, self._next)
        return not places.isdisjoint(found)

    def _next(self, at: int) -> Iterator[int]:
        yield from self._after.get(at, ())
        yield from self._callees(at)

    def _callees(self, at: int) -> Iterator[int]:
        for number in self.lines.called(at):
            yield from self.lines.procedures[number][:1]

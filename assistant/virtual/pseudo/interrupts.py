"""Interrupts of a pseudo-program; what they mean is told in `assistant.program.statements`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

from assistant.program import statements as p
from assistant.program.expressions import Elapsed
from assistant.program.rewriting import records
from assistant.virtual.pseudo.data import Call
from assistant.virtual.pseudo.ends import NotRun, Over
from assistant.virtual.pseudo.expressions import condition
from assistant.virtual.pseudo.machine import Machine

LOOK_PERIOD: Final = 0.0071
"""Seconds between two looks at what time alone changes, as controllers of MELFA-BASIC have it."""


@dataclass(slots=True, eq=False)
class Interrupts:
    """Those of a program: as they were defined, by lower-case name, and which of them are on.

    run: makes the call of one, in the call that it was defined in.
    """

    machine: Machine
    run: Callable[[p.Call], None]
    known: dict[str, tuple[p.Interrupt, Call]] = field(default_factory=dict)
    on: set[str] = field(default_factory=set)
    open: bool = True
    busy: bool = False

    def look(self) -> None:
        """Runs what is due now."""
        while not self.busy and (due := self._due()) is not None:
            self._answer(*due)

    def _due(self) -> tuple[p.Interrupt, Call] | None:
        if not self.open:
            return None
        for name, (node, frame) in self.known.items():
            if name in self.on and self._within(frame, partial(self._holds, node)):
                return node, frame
        return None

    def _holds(self, node: p.Interrupt) -> bool:
        kernel = self.machine.task.kernel
        kernel.looking = True
        try:
            return condition(self.machine, node.condition)
        finally:
            kernel.looking = False

    def _within(self, frame: Call, does: Callable[[], Any]) -> Any:
        """What something gives, in the call that an interrupt was defined in."""
        calls, self.busy = self.machine.calls, True
        calls.append(frame)
        try:
            return does()
        finally:
            calls.pop()
            self.busy = False

    def _answer(self, node: p.Interrupt, frame: Call) -> None:
        kernel = self.machine.task.kernel
        stands = kernel.motion.stands()
        if not stands:
            kernel.motion.hold(kernel)
        before = self.machine.flange
        self._within(frame, lambda: self.run(node.call))
        ends = node.ends
        if ends is not None and self._within(frame, lambda: condition(self.machine, ends)):
            raise Over
        if stands:
            return
        if self.machine.flange is not before:
            raise NotRun("a move in an interrupt that came on the way of another one")
        kernel.motion.resume(kernel)

    def attend(self) -> None:
        """Has statements, waits and moves look for interrupts."""
        task = self.machine.task
        nodes = [node.condition for node, _ in self.known.values()]
        timed = any(isinstance(part, Elapsed) for part in records(tuple(nodes)))
        task.looks, task.sampling = self.look, LOOK_PERIOD if timed else None


def _interrupts_of(m: Machine) -> Interrupts:
    assert m.interrupts is not None
    return m.interrupts


def _define_interrupt(m: Machine, node: p.Interrupt) -> None:
    own = _interrupts_of(m)
    own.known[node.name.lower()] = node, m.call
    own.attend()


def _switch_interrupt(m: Machine, node: p.SwitchInterrupt) -> None:
    name = node.name.lower()
    if node.state == "on":
        _interrupts_of(m).on.add(name)
    else:
        _interrupts_of(m).on.discard(name)


def _switch_interrupts(m: Machine, node: p.SwitchInterrupts) -> None:
    _interrupts_of(m).open = node.state == "on"


INTERRUPT_STATEMENTS: Final[Mapping[type, Callable[[Machine, Any], None]]] = {
    p.Interrupt: _define_interrupt,
    p.SwitchInterrupt: _switch_interrupt,
    p.SwitchInterrupts: _switch_interrupts,
}

"""Interrupts of a task: which are connected and ordered, and what becomes of those that occur.

Kernel manual, Interrupts: an interrupt is answered when the next statement is entered, and at any
time while one waits or moves. Interrupts that occur while they are disabled are queued and raised
in their order; they always are disabled while a trap routine runs. Those that occur while they are
deactivated on their own are lost.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from assistant.virtual.kernel.task import Task
from assistant.virtual.rapid.ends import Fault
from assistant.virtual.rapid.scopes import Known

MOST_QUEUED: Final = 100
"""Interrupts that are defined at one time, of a task (RAPID overview, Interrupts)."""

Cancel = Callable[[], None]


@dataclass(slots=True, eq=False)
class Interrupt:
    """cancel: ends its order, None before it has one. single: it occurs once, safe: and is not
    deactivated on its own. asleep: deactivated. gone: deleted.
    """

    number: int
    trap: Known
    cancel: Cancel | None = None
    single: bool = False
    safe: bool = False
    asleep: bool = False
    gone: bool = False


@dataclass(slots=True, eq=False)
class Interrupts:
    """table: by number. run: runs the trap routine of one."""

    task: Task
    run: Callable[[Interrupt], None] = lambda _: None
    table: dict[int, Interrupt] = field(default_factory=dict)
    disabled: bool = False
    count: int = 0

    def connect(self, number: int, trap: Known) -> int:
        """A new interrupt for a variable with a number: the number that it is given."""
        if number in self.table:
            raise Fault("an interrupt that has a trap routine is connected", "ERR_ALRDYCNT")
        if len(self.table) >= MOST_QUEUED:
            raise Fault(f"more than {MOST_QUEUED} interrupts", "ERR_INOMAX")
        self.count += 1
        self.table[self.count] = Interrupt(self.count, trap)
        return self.count

    def order(
        self,
        number: int,
        begin: Callable[[Callable[[], None]], Cancel],
        single: bool = False,
        safe: bool = False,
    ) -> None:
        """begin: has a function called whenever the interrupt occurs, and tells how to end it."""
        interrupt = self.known(number)
        if interrupt.cancel is not None:
            raise Fault("an interrupt is ordered twice, without an IDelete in between")
        interrupt.single, interrupt.safe = single or safe, safe
        interrupt.cancel = begin(lambda: self.occur(interrupt))

    def occur(self, interrupt: Interrupt) -> None:
        self.task.kernel.spend()
        if interrupt.gone or interrupt.asleep:
            return
        if interrupt.single and interrupt.cancel is not None:
            interrupt.cancel()
        self.task.post(lambda: None if interrupt.gone else self.run(interrupt))

    def known(self, number: int) -> Interrupt:
        if number not in self.table:
            raise Fault("an interrupt that no trap routine is connected to", "ERR_UNKINO")
        return self.table[number]

    def delete(self, number: int) -> None:
        """Also of one that there is not: programs delete before they connect."""
        interrupt = self.table.pop(number, None)
        if interrupt is not None:
            interrupt.gone = True
            if interrupt.cancel is not None:
                interrupt.cancel()

    def sleep(self, number: int, asleep: bool) -> None:
        interrupt = self.known(number)
        if asleep and interrupt.safe:
            raise Fault("a safe interrupt is deactivated", "ERR_INOISSAFE")
        interrupt.asleep = asleep

    def disable(self, disabled: bool) -> None:
        """All of the task, whoever occurs is queued."""
        if disabled is not self.disabled:
            self.task.closed += 1 if disabled else -1
            self.disabled = disabled

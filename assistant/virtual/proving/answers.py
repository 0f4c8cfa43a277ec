"""What ends the waits of programs that are compared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from random import Random
from typing import Final

from assistant.virtual.kernel import Task
from assistant.virtual.proving.driver import Driver, Moment
from assistant.virtual.proving.wires import Wiring

PLAIN_ANSWERS: Final = 15
"""Bits of the largest number that is tried: with one more it may have a sign, or be too large for a
variable, and the manuals do not tell what becomes of it."""


@dataclass
class Answers:
    """Ends waits: with the values that let a program go on."""

    random: Random
    numbers: list[int]

    def answer(self, driver: Driver, task: Task, read: tuple[str, ...]) -> Mapping[str, float]:
        wiring, state = driver.wiring, driver.state
        tries = [*self._singly(wiring, state, read), *self._jointly(wiring, read)]
        if not tries:
            return {}
        until = task.until if task.waiting else None
        if until is None:  # a loop that only reads: one of what may help
            return self.random.choice(tries)
        for change in tries:
            if driver.would(change, until):
                return change
        return {}

    def _singly(
        self, wiring: Wiring, state: Mapping[str, float], read: tuple[str, ...]
    ) -> Iterator[Mapping[str, float]]:
        """Another value of one input."""
        for name in read:
            bits = wiring.bits(name)
            if bits == 1:
                yield wiring.spread(name, 1.0 - wiring.value(name, state))
                continue
            near = {n + by for n in self.numbers for by in (0, 1, -1)} | {
                0,
                (1 << min(bits, PLAIN_ANSWERS)) - 1,
            }
            values = sorted(value for value in near if 0 <= value < 1 << bits)
            yield from (wiring.spread(name, float(value)) for value in values)

    def _jointly(self, wiring: Wiring, read: tuple[str, ...]) -> Iterator[Mapping[str, float]]:
        """All inputs that are read at once, and numbers that are read bit by bit."""
        if len(read) > 1:
            for value in (1.0, 0.0):
                yield {wire: value for name in read for wire in wiring.wires(name)}
        for wires, _ in answer_rows(wiring, dict.fromkeys(read, Moment())):
            for number in self.numbers:
                if number < 1 << len(wires):
                    yield {wire: float(number >> i & 1) for i, wire in enumerate(wires)}


def answer_rows(wiring: Wiring, names: Mapping[str, Moment]) -> list[tuple[list[str], Moment]]:
    """Wires with numbers that follow each other: bits that are read as one number."""
    single = {
        int(n): when for n, when in names.items() if n.isdecimal() and not wiring.named.get(n)
    }
    found: list[tuple[list[str], Moment]] = []
    for number in sorted(single):
        if found and int(found[-1][0][-1]) == number - 1:
            found[-1][0].append(str(number))
        else:
            found.append(([str(number)], single[number]))
    return [(wires, when) for wires, when in found if len(wires) > 1]

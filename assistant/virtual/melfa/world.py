"""What a program acts on: arm, signals, clock, variables of all programs, and what happened."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final

from assistant.virtual.events import Event, Switched
from assistant.virtual.melfa.arm import Arm
from assistant.virtual.melfa.memory import Memory, Scope
from assistant.virtual.melfa.stops import OutOfSteps, Unknown, out_of_range

STEP_TIME: Final = 1.0
"""Milliseconds that a statement takes on the clock of M_Timer; moves take none here."""

Inputs = Callable[[int], int]
"""The state of an input, 0 or 1, by its number."""


@dataclass(slots=True)
class World:
    """outputs: bits by number. clock: milliseconds. timers: the clock when each was at 0."""

    arm: Arm
    inputs: Inputs
    most_steps: int
    events: list[Event] = field(default_factory=list)
    outputs: dict[int, int] = field(default_factory=dict)
    clock: float = 0.0
    timers: dict[int, float] = field(default_factory=dict)
    shared: Memory = field(default_factory=lambda: Memory(Scope()))
    steps: int = 0
    left: bool = False
    """Whether the last block was left by `Break` (M_BrkCq)."""

    def tick(self) -> None:
        """Counts a statement; raises OutOfSteps."""
        self.steps += 1
        self.clock += STEP_TIME
        if self.steps > self.most_steps:
            raise OutOfSteps

    def read(self, output: bool, first: int, width: int) -> int:
        """Inputs or outputs of a width as one number, the first as the lowest bit."""
        if first < 0:
            raise out_of_range(f"the signal {first}")
        numbers = range(first, first + width)
        get = (lambda n: self.outputs.get(n, 0)) if output else self.inputs
        return sum(get(n) << i for i, n in enumerate(numbers))

    def switch(self, first: int, width: int, value: int, mask: int = -1) -> None:
        """Sets outputs; each bit is an event. mask: the bits that are set."""
        if first < 0:
            raise out_of_range(f"the signal {first}")
        if not 0 <= value < 1 << width:
            raise Unknown(f"{value} in a signal of {width} bits")
        for at in range(width):
            if mask >> at & 1:
                bit = value >> at & 1
                self.outputs[first + at] = bit
                self.events.append(Switched(str(first + at), float(bit)))

    def timer(self, number: int) -> float:
        return self.clock - self.timers.get(number, 0.0)

    def set_timer(self, number: int, value: float) -> None:
        self.timers[number] = self.clock - value


def inputs_of(given: Mapping[int, int] | Inputs | None) -> Inputs:
    """Inputs as a function of their numbers; those that are not given are 0."""
    if given is None:
        return lambda _: 0
    if callable(given):
        return given
    return lambda number: int(bool(given.get(number, 0)))

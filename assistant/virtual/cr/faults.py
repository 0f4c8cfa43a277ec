"""Faults that a virtual CR controller shows on purpose, so that clients can be tried with them."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

SPOILED_ANSWERS: Final = 0x55
"""XOR of a byte that is broken on the line."""


@dataclass(eq=False)
class Faults:
    """What goes wrong with each answer, on every line. Fields may be changed at any time.

    delay: seconds before an answer. drop_after: bytes that are sent, of all lines together, until
    the controller hangs up; then it is None again. terminator: what ends answers instead of the
    right code. garbage: what comes instead of an answer. twice: whether an answer comes again.
    errors: beginnings of commands, without robot and slot, with the error number that they are
    answered with. broken: one byte of so many comes broken, 0 for none. times: answers that are
    spoilt by the delay, terminator, garbage or twice, None for all.
    """

    delay: float = 0.0
    drop_after: int | None = None
    terminator: bytes | None = None
    garbage: bytes | None = None
    twice: bool = False
    errors: Mapping[str, int] = field(default_factory=dict)
    broken: int = 0
    times: int | None = None
    _sent: int = 0
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False)

    def error(self, command: str) -> int | None:
        """The number that a command is answered with, None for as it should be."""
        body = command.split(";", 2)[-1].lstrip()
        found = [name for name in self.errors if body.startswith(name)]
        return self.errors[max(found, key=len)] if found else None

    def answers(self, text: bytes, terminator: bytes) -> list[bytes]:
        """What is sent instead of an answer."""
        if self._over():
            return [text + terminator]
        if self.delay:
            time.sleep(self.delay)
        end = terminator if self.terminator is None else self.terminator
        sent = (text if self.garbage is None else self.garbage) + end
        return [sent] * (1 + self.twice)

    def spoilt(self, data: bytes) -> tuple[bytes, bool]:
        """What arrives of some bytes, and whether the line goes on behind them."""
        with self._lock:
            if self.broken:
                marks = enumerate(data, start=self._sent + 1)
                data = bytes(b ^ SPOILED_ANSWERS if at % self.broken == 0 else b for at, b in marks)
            self._sent += len(data)
            if self.drop_after is None:
                return data, True
            if len(data) < self.drop_after:
                self.drop_after -= len(data)
                return data, True
            data, self.drop_after = data[: self.drop_after], None
            return data, False

    def _over(self) -> bool:
        """Whether as many answers were spoilt as were to be; counts this one."""
        with self._lock:
            if self.times is None:
                return False
            if self.times == 0:
                return True
            self.times -= 1
            return False

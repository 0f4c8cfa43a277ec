"""A kernel whose time passes only as far as somebody outside lets it: in lock step with a model.

    live = Stepped(make)
    live.start()
    live.advance(0.02)  # comes back when all until 0.02 s has happened

What other threads ask for is carried out at the moment at which it stands.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from assistant.virtual.kernel.live import PATIENCE, Live
from assistant.virtual.kernel.task import Ending, Task

if TYPE_CHECKING:
    from assistant.virtual.kernel.kernel import Kernel


class Stepped(Live):
    """It stands at 0 s when it starts; see `Live` for the rest."""

    def __init__(
        self,
        make: Callable[[], Kernel],
        *,
        ended: Callable[[Task, Ending], None] | None = None,
        name: str = "virtual-controller",
    ) -> None:
        super().__init__(make, ended=ended, name=name)
        self._turn = threading.Condition()
        self._allowed = 0.0
        self._freed: float | None = None
        """Since when time passes as real time does, of the monotonic clock."""
        self._until: float | None = None
        """What the kernel waits for, None while it is at work."""

    def free(self) -> None:
        """Time passes as real time does, until `advance` is called: for what waits by a clock."""
        with self._turn:
            self._freed = self._freed or time.monotonic()
            self._turn.notify_all()

    def advance(self, moment: float, timeout: float = PATIENCE) -> None:
        """Lets time pass to a moment, and comes back when all until then has happened.

        A moment that is over changes nothing. Raises TimeoutError if it takes too long.
        """
        with self._turn:
            self._allowed, self._freed = max(self.now(), moment), None
            self._turn.notify_all()
            if not self._turn.wait_for(self._stands, timeout):
                raise TimeoutError(f"the virtual controller does not come to {moment:g} s")

    def now(self) -> float:
        """Simulated seconds until which time may pass."""
        return self._allowed + (0.0 if self._freed is None else time.monotonic() - self._freed)

    def reach(self, clock: float, moment: float) -> float:
        """As of `Live`: the moment, or the one that is reached when another thread asks."""
        asked = self._wait(moment)
        return max(clock, min(moment, self.now())) if asked else max(clock, moment)

    def hold(self, clock: float) -> None:
        """Until a clock that is ahead may be there; commands come meanwhile."""
        while self.kernel.ending is None and self._wait(clock):
            self.attend()

    def _ring(self) -> None:
        super()._ring()
        with self._turn:
            self._turn.notify_all()

    def _wait(self, moment: float) -> bool:
        """Until time may pass to a moment; True if another thread asks for something before."""
        with self._turn:
            while self.now() < moment:
                if self._bell.is_set():
                    return True
                self._until = moment
                self._turn.notify_all()
                rest = None if self._freed is None or math.isinf(moment) else moment - self.now()
                self._turn.wait(rest)
                self._until = None
        return False

    def _stands(self) -> bool:
        """Whether all has happened that may, and was asked for."""
        waits = self._until is not None and self._until > self._allowed
        return self._over or (waits and not self._bell.is_set() and not self._commands)

    def _run(self) -> None:
        try:
            super()._run()
        finally:
            with self._turn:
                self._turn.notify_all()

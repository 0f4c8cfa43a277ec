"""A kernel in a thread: in real time for a virtual controller, or in lock step with a model.

`Live` lets simulated time pass as real time does. Commands of other threads are carried out between
two statements, and the end of a task leaves the other tasks and the controller alive. `Stepped`
lets time pass only as far as `advance` allows:

    live = Stepped(make)
    live.start()
    live.advance(0.02)  # returns when everything until 0.02 s has happened
    live.do(lambda kernel: kernel.board.inputs.set("di_1", 1.0))
    live.stop()
"""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from typing import TYPE_CHECKING, Final, TypeVar

from assistant.virtual.kernel.task import Ending, Task

if TYPE_CHECKING:
    from assistant.virtual.kernel.kernel import Kernel


_PATIENCE: Final = 10.0
"""Seconds that a command waits for its turn; a turn takes as long as a motion's planning."""
_MOST_ROWS: Final = 10_000
"""Rows of the log, after which past events are forgotten."""

T = TypeVar("T")


class Live:
    """A kernel in a thread, in real time. make: builds the kernel, in the thread in which it then
    runs. rate: simulated seconds for each real one. ended: is called with each task that has ended
    and its ending; it may start others.
    """

    def __init__(
        self,
        make: Callable[[], Kernel],
        *,
        rate: float = 1.0,
        ended: Callable[[Task, Ending], None] | None = None,
        name: str = "virtual-controller",
    ) -> None:
        self._make, self.rate, self._ended = make, rate, ended
        self._commands: deque[Callable[[Kernel], None]] = deque()
        self._bell = threading.Event()
        self._ready: Future[None] = Future()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._over = False
        self._began = 0.0

    # ----------------------------------------------------------------- for other threads

    def start(self) -> None:
        """Builds the kernel and lets it run; raises what `make` raises."""
        self._thread.start()
        self._ready.result()

    def stop(self) -> None:
        """Ends all tasks where they are; a command that is under way is finished."""
        if self._thread.is_alive():
            with suppress(RuntimeError):
                self.do(lambda kernel: kernel.end(Ending("stopped", "the controller is off")))
            self._thread.join()

    def do(self, command: Callable[[Kernel], T], timeout: float = _PATIENCE) -> T:
        """Has a command carried out between two statements; gives what it gives, raises what it
        raises. Raises RuntimeError if the controller is off, TimeoutError if it never has time.
        """
        # A command from the kernel's own thread would wait for itself.
        if threading.current_thread() is self._thread:
            return command(self.kernel)
        future: Future[T] = Future()

        def act(kernel: Kernel) -> None:
            try:
                future.set_result(command(kernel))
            except Exception as error:  # noqa: BLE001 - it is the caller's, who gets it
                future.set_exception(error)

        if self._over:
            raise RuntimeError("the controller is off")
        self._commands.append(act)
        self._ring()
        # The kernel may have ended between the check
        # above and the append: nobody would carry it out.
        if self._over:
            with suppress(ValueError):  # unless it was carried out at the very end
                self._commands.remove(act)
                raise RuntimeError("the controller is off")
        return future.result(timeout)

    def _ring(self) -> None:
        """Somebody asks for something."""
        self._bell.set()

    # -------------------------------------------------------------------- for the kernel

    def now(self) -> float:
        """Simulated seconds that have passed."""
        return (time.monotonic() - self._began) * self.rate

    def attend(self) -> None:
        """Carries out what other threads have asked for."""
        # Before the commands: one that is added meanwhile rings again and is not lost.
        self._bell.clear()
        while self._commands:
            self._commands.popleft()(self.kernel)
            # A command may have changed what a task waits
            # for: no time passes before they have looked.
            self.kernel.stirred = True
        # Events are told already; the log of a controller that runs for days must not grow.
        if len(self.kernel.log) > _MOST_ROWS and self.kernel.motion.stands():
            self.kernel.forget()

    def reach(self, clock: float, moment: float) -> float:
        """Waits for a moment, `clock` being the time; the one that is reached when another thread
        asks for something before.
        """
        rest = (moment - self.now()) / self.rate
        if rest > 0.0 and self._bell.wait(None if math.isinf(rest) else rest):
            # Woken by a command: only as much time has passed as really did.
            return max(clock, min(moment, self.now()))
        return max(clock, moment)

    def hold(self, clock: float) -> None:
        """Lets real time come up with a clock that is ahead; commands come meanwhile."""
        while (rest := (clock - self.now()) / self.rate) > 0.0:
            if self._bell.wait(rest):
                self.attend()

    def ended(self, task: Task, ending: Ending) -> None:
        if self._ended is not None:
            self._ended(task, ending)

    # --------------------------------------------------------------------------- its own

    def _run(self) -> None:
        try:
            self.kernel = self._make()
            self.kernel.live = self
            # The clock may begin later than 0: real time counts from where it is.
            self._began = time.monotonic() - self.kernel.clock / self.rate
        except BaseException as error:  # noqa: BLE001 - `start` raises it
            self._over = True
            self._ready.set_exception(error)
            return
        self._ready.set_result(None)
        try:
            self.kernel.run()
        finally:
            # Commands that came last get an answer: `attend`
            # carries them out, or their caller waits in vain.
            self._over = True
            self.attend()


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
        """Simulated time that the kernel waits for, None while it is at work."""

    def free(self) -> None:
        """Time passes as real time does, until `advance` is called: for what waits by a clock."""
        with self._turn:
            self._freed = self._freed or time.monotonic()
            self._turn.notify_all()

    def advance(self, moment: float, timeout: float = _PATIENCE) -> None:
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
        """Wait for a moment, as `Live` does; return it, or the time reached when another thread
        asks.
        """
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
                # The bell is not cleared here: `attend` does it before it takes the commands.
                if self._bell.is_set():
                    return True
                self._until = moment
                self._turn.notify_all()
                rest = None if self._freed is None or math.isinf(moment) else moment - self.now()
                self._turn.wait(rest)
                self._until = None
        return False

    def _stands(self) -> bool:
        """True if all allowed events and all requests are done."""
        # The kernel has reached the allowed time only if it waits for a later moment.
        waits = self._until is not None and self._until > self._allowed
        return self._over or (waits and not self._bell.is_set() and not self._commands)

    def _run(self) -> None:
        try:
            super()._run()
        finally:
            # `advance` may wait for a kernel that has ended by now.
            with self._turn:
                self._turn.notify_all()

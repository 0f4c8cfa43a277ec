"""Termination from outside: signals raised as Ctrl-C is, so that nothing is left halfway.

with raise_on_termination() as termination:
    try:
        …                   # an arm moves, programs are replaced
    except KeyboardInterrupt:
        termination.hold()  # from here on nothing interrupts
        …                   # stop it, put them back

with defer_termination():
    …                       # files take their places; a signal takes effect after the block
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Final, Never

from assistant.base.data_classes import dataclass

_TERMINATING_SIGNALS: Final = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK", "SIGQUIT", "SIGTSTP")
"""Signals that end a program from outside.

These are Ctrl-C, a pipeline that is cancelled, a terminal that is closed, and a key next to Ctrl-C.
A program that Ctrl-Z halts could no longer attend to its controller.
"""
ORDINARY_SIGNALS: Final = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
"""Those that end every command in order. Ctrl-Z halts it, and SIGQUIT ends it where it is."""
SIGNAL_EXIT_STATUS: Final = 128
"""Number that shells add to a signal's number for the exit status of a program that it ended."""
INTERRUPTED: Final = SIGNAL_EXIT_STATUS + signal.SIGINT
"""Exit status that shells expect of a program ended by Ctrl-C."""
_WAKE_INTERVAL: Final = 0.25
"""Seconds after which a signal is met at the latest that the system gave to another thread."""
SignalHandler = Callable[[int, object], None]


class Terminated(KeyboardInterrupt):
    """number: of the signal that ends this program."""

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.number = number


def wait_for_termination() -> Never:
    """Waits until a signal ends this program.

    The system may give a signal to any thread, but only the main one meets it, when it wakes.
    """
    while True:
        time.sleep(_WAKE_INTERVAL)


def is_ctrl_c(caught: KeyboardInterrupt) -> bool:
    """True if the interrupt was Ctrl-C, which is how some commands end in order."""
    return not isinstance(caught, Terminated) or caught.number == signal.SIGINT


class Termination:
    """Raises Terminated for signals until they are held. number: of the first signal, or None."""

    def __init__(self, *, once: bool = False) -> None:
        self._held, self._once = False, once
        self.number: int | None = None

    def hold(self) -> None:
        """Ignore signals from here on: the work in progress runs to its end."""
        self._held = True

    @contextmanager
    def released(self) -> Iterator[None]:
        """Meanwhile the next that comes is raised again, also where it was held."""
        held, self._held = self._held, False
        try:
            yield
        finally:
            # A `hold` inside the block stays in force.
            self._held = held or self._held

    def met(self, number: int, _frame: object) -> None:
        if not self._held:
            self._held = self._once
            raise Terminated(number)


@dataclass(frozen=True, slots=True)
class _Handler:
    """Meets signals for this module."""

    met: SignalHandler

    def __call__(self, number: int, frame: object) -> None:
        for ending in _terminations:
            if ending.number is None:
                ending.number = number
        self.met(number, frame)


_terminations: Final[list[Termination]] = []
"""Those that are waited for, the innermost last: all of them know what came."""


@contextmanager
def raise_on_termination(
    *, once: bool = False, signals: Sequence[str] = _TERMINATING_SIGNALS
) -> Iterator[Termination]:
    """Meanwhile whatever would end this program at once raises Ended instead.

    once: only the first time. What somebody ignores or handles already stays so (nohup, a program
    that uses this package); in other threads than the main one, which get no signals, nothing
    changes.
    """
    ending = Termination(once=once)
    with signals_handled(ending.met, signals):
        _terminations.append(ending)
        try:
            yield ending
        finally:
            _terminations.remove(ending)


@contextmanager
def signals_handled(
    met: SignalHandler, signals: Sequence[str] = _TERMINATING_SIGNALS
) -> Iterator[None]:
    """Call `met` instead of ending this program; see `raise_on_termination`."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    known = [getattr(signal, name) for name in signals if hasattr(signal, name)]
    before = {one: handler for one in known if _is_own_handler(handler := signal.getsignal(one))}
    try:
        for number in before:
            signal.signal(number, _Handler(met))
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _is_own_handler(handler: object) -> bool:
    """True if the handler is Python's initial one, or one of this module."""
    first = handler in (signal.SIG_DFL, signal.default_int_handler)
    return first or isinstance(handler, _Handler)


@contextmanager
def defer_termination() -> Iterator[None]:
    """Meanwhile nothing ends this program from outside: what comes is met behind the block.

    For what is short and must not be left half way.
    """
    came: list[int] = []
    with signals_handled(lambda number, _: came.append(number)):
        yield
    if came:
        # The handlers of before decide what the first signal does.
        signal.raise_signal(came[0])

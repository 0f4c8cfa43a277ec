"""What ends this program from outside, met as Ctrl-C is, so that nothing is left half way.

with told_to_end() as ending:
    try:
        …                   # an arm moves, programs are replaced
    except KeyboardInterrupt:
        ending.hold()       # from here on nothing interrupts
        …                   # stop it, put them back
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

ENDS: Final = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK", "SIGQUIT", "SIGTSTP")
"""What ends a program from outside: Ctrl-C, a pipeline that is cancelled, a terminal that is
closed, a key beside Ctrl-C. One that Ctrl-Z halts could not see to its controller any more.
"""


class Ending:
    """What comes raises KeyboardInterrupt until it is held."""

    def __init__(self, *, once: bool = False) -> None:
        self._held, self._once = False, once

    def hold(self) -> None:
        """Whatever comes from here on is let pass: what is under way goes on to its end."""
        self._held = True

    def met(self, _number: int, _frame: object) -> None:
        if not self._held:
            self._held = self._once
            raise KeyboardInterrupt


@contextmanager
def told_to_end(*, once: bool = False) -> Iterator[Ending]:
    """Meanwhile whatever would end this program at once raises KeyboardInterrupt instead.

    once: only the first time. What somebody ignores or handles already stays so (nohup, a program
    that uses this package); in other threads than the main one, which get no signals, nothing
    changes.
    """
    ending = Ending(once=once)
    with handled(ending.met):
        yield ending


@contextmanager
def handled(met: Callable[[int, object], None]) -> Iterator[None]:
    """Meanwhile that is called instead of ending this program; see `told_to_end`."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    ours = (signal.SIG_DFL, signal.default_int_handler)
    known = [getattr(signal, name) for name in ENDS if hasattr(signal, name)]
    before = {one: signal.getsignal(one) for one in known if signal.getsignal(one) in ours}
    try:
        for number in before:
            signal.signal(number, met)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)

"""A bound for transfers by their progress: what drips byte by byte does not go on for ever.

A time-out of a socket is granted to each byte anew. A `Pace` asks for so many bytes in each
time-out, and cuts the line from a thread of its own where they do not come.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Final, Self

LEAST_BYTES: Final = 1024
"""Bytes that have to go through in each time-out; fewer only at the end."""
LARGEST_TRANSFER: Final = 1 << 30
"""Bytes after which what comes is taken for garbage."""


class TransferDeadline:
    """A context manager around a transfer, which ends with a TimeoutError once the line was cut.

    seconds: of the time-out. cut: ends the line, so that whoever waits for it meets an error.
    """

    def __init__(self, seconds: float, cut: Callable[[], None]) -> None:
        self._seconds, self._cut = seconds, cut
        self._count = 0
        self._done = threading.Event()
        self._over = threading.Event()
        self._deciding = threading.Lock()
        self._thread = threading.Thread(target=self._watch, name="pace", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: object, traceback: object) -> None:
        with self._deciding:
            self._done.set()
        # Also where the last byte came just before the cut: the line is of no use any more.
        if (kind is None or issubclass(kind, Exception)) and self._over.is_set():
            raise TimeoutError from None

    def moved(self, count: int) -> None:
        """So many bytes have gone through; raises TimeoutError where they never end."""
        self._count += count
        if self._count > LARGEST_TRANSFER:
            self._over.set()
            raise TimeoutError

    def _watch(self) -> None:
        seen = 0
        while not self._done.wait(self._seconds):
            count = self._count
            if count - seen < LEAST_BYTES:
                with self._deciding:
                    if self._done.is_set():
                        return
                    self._over.set()
                self._cut()
                return
            seen = count

"""What comes by itself while a model goes on: at times that are known, or as it comes."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack
from typing import Generic, Protocol, TypeVar

from assistant.base.diagnostics import Refused
from assistant.vision.cameras.capture import STREAM_ADDRESS

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)
ValueOpening = Callable[[], AbstractContextManager[Iterator[tuple[float, T]]]]
"""Opens what gives seconds and values, one after the other."""


class ValueSource(Protocol[T_co]):
    """Opened by `begin`, closed by `end`."""

    def begin(self) -> None: ...

    def at(self, now: float) -> T_co | None:
        """The newest value at a moment of the model, None before there is one; raises Refused."""

    def end(self) -> None: ...


class RecordedValues(Generic[T]):
    """Values that have their times, counted from the beginning of the model; the last one stays."""

    def __init__(self, opening: ValueOpening[T]) -> None:
        self._opening, self._open = opening, ExitStack()

    def begin(self) -> None:
        self._coming = self._open.enter_context(self._opening())
        self._newest: T | None = None
        self._next = next(self._coming, None)

    def at(self, now: float) -> T | None:
        while self._next is not None and self._next[0] <= now + 1e-9:
            self._newest = self._next[1]
            self._next = next(self._coming, None)
        return self._newest

    def end(self) -> None:
        self._open.close()


class LiveValues(Generic[T]):
    """Values as they come, gathered in a thread of its own, so that no step waits for one."""

    def __init__(self, opening: ValueOpening[T]) -> None:
        self._opening, self._open = opening, ExitStack()

    def begin(self) -> None:
        self._newest: T | None = None
        self._failure: Refused | None = None
        self._over = threading.Event()
        coming = self._open.enter_context(self._opening())
        thread = threading.Thread(target=self._gather, args=(coming,), daemon=True)
        self._open.callback(thread.join)
        self._open.callback(self._over.set)
        thread.start()

    def at(self, now: float) -> T | None:
        del now
        if self._failure is not None:
            raise self._failure
        return self._newest

    def end(self) -> None:
        self._open.close()

    def _gather(self, coming: Iterator[tuple[float, T]]) -> None:
        try:
            for _, value in coming:
                self._newest = value
                if self._over.is_set():
                    return
        except Refused as refused:
            self._failure = refused


def value_source(opening: ValueOpening[T], *sources: str) -> ValueSource[T]:
    """Live if any source is a device or a stream; else by the times of its pictures."""
    live = any(one.isdigit() or STREAM_ADDRESS.match(one) for one in sources)
    return LiveValues(opening) if live else RecordedValues(opening)

"""The windows of a studio: one of them writes, the others only look."""

from __future__ import annotations

import secrets
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

Notify = Callable[[Mapping[str, object]], None]
"""Tells a window something; may be called from any thread."""


@dataclass(slots=True, eq=False)
class Windows:
    """Those that are open, the oldest first: that one writes until it is closed."""

    _open: dict[str, Notify] = field(default_factory=dict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def opened(self, tell: Notify) -> str:
        """A name for a new window, which nobody else can guess."""
        name = secrets.token_urlsafe(16)
        with self._lock:
            self._open[name] = tell
        self._tell_who()
        return name

    def closed(self, name: str, over: Callable[[bool], None]) -> None:
        """Of those left the oldest writes from now on.

        over: is told whether this one wrote, before another one does; calls nothing of here.
        """
        with self._lock:
            wrote = self._writer() == name
            self._open.pop(name, None)
            over(wrote)
        if wrote:
            self._tell_who()

    def writes(self, name: str) -> bool:
        with self._lock:
            writer = self._writer()
        return writer is not None and secrets.compare_digest(writer.encode(), name.encode())

    def has(self, name: str) -> bool:
        """Whether a window of that name is open."""
        with self._lock:
            return name in self._open

    def tell(self, message: Mapping[str, object]) -> None:
        """Tells all windows."""
        with self._lock:
            every = tuple(self._open.values())
        for tell in every:
            tell(message)

    def tell_one(self, name: str, message: Mapping[str, object]) -> None:
        """Tells a window, if it is still open."""
        with self._lock:
            tell = self._open.get(name)
        if tell is not None:
            tell(message)

    def _tell_who(self) -> None:
        with self._lock:
            writer, every = self._writer(), dict(self._open)
        for name, tell in every.items():
            tell({"kind": "window", "name": name, "writes": name == writer})

    def _writer(self) -> str | None:
        return next(iter(self._open), None)

"""Seeing a program after each pass that it goes through on its way into a language."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Final

from assistant.program.program import Program

PassWatcher = Callable[[str, Program], None]
"""Takes the name of a pass, and the program as it is then."""

_pass_watcher: Final[ContextVar[PassWatcher | None]] = ContextVar("watcher", default=None)


@contextmanager
def pass_trace(watcher: PassWatcher) -> Iterator[None]:
    """What is compiled meanwhile is shown to a watcher."""
    token = _pass_watcher.set(watcher)
    try:
        yield
    finally:
        _pass_watcher.reset(token)


def traced(name: str, program: Program) -> Program:
    """The program itself, which is shown to whoever watches."""
    watcher = _pass_watcher.get()
    if watcher is not None:
        watcher(name, program)
    return program

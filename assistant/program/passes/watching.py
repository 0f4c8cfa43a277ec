"""Seeing a program after each pass that it goes through on its way into a language."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Final

from assistant.program.program import Program

Watcher = Callable[[str, Program], None]
"""Takes the name of a pass, and the program as it is then."""

_watcher: Final[ContextVar[Watcher | None]] = ContextVar("watcher", default=None)


@contextmanager
def watched(watcher: Watcher) -> Iterator[None]:
    """What is compiled meanwhile is shown to a watcher."""
    token = _watcher.set(watcher)
    try:
        yield
    finally:
        _watcher.reset(token)


def passed(name: str, program: Program) -> Program:
    """The program itself, which is shown to whoever watches."""
    watcher = _watcher.get()
    if watcher is not None:
        watcher(name, program)
    return program

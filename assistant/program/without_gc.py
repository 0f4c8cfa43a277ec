"""Building large trees, and answering keys, without the cycle collector."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def without_gc() -> Iterator[None]:
    """Keeps the cycle collector still: it would look through a growing tree again and again.

    Without this the time to read a text of n lines grows faster than n.
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def freeze_loaded_objects() -> None:
    """Has the cycle collector leave alone what is there now: tables, grammars, whole programs.

    It would look through all of that again and again in the middle of an answer. For processes
    that go on answering, and that own what they have loaded.
    """
    gc.collect()
    gc.freeze()

"""The rules of a language: what each looks at, and what must be sound for it to be asked."""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar

from assistant.base.diagnostics import Diagnostic

V = TypeVar("V")

Found = Iterator[Diagnostic]
"""What a rule finds."""


class Needs(enum.Flag):
    """What a text with syntax errors may lack, so that a rule of it would say what is not so."""

    NOTHING = 0
    ORDER = enum.auto()
    """What follows each other, or belongs together."""
    NAMES = enum.auto()
    """Everything that is defined."""
    WHOLE = enum.auto()
    """All of the text."""


@dataclass(frozen=True, slots=True)
class Check(Generic[V]):
    """A rule over a view of a file or module.

    advice: it is about how a program is written, and is not asked about what was compiled: the
    program that this comes from has been checked, and its author wrote no vendor language.
    """

    find: Callable[[V], Found]
    needs: Needs = Needs.NOTHING
    advice: bool = False


def findings(
    checks: Iterable[Check[V]], view: V, lacks: Needs = Needs.NOTHING, *, compiled: bool = False
) -> Found:
    """What the checks find that can be sure of it. lacks: what syntax errors have spoilt."""
    for check in checks:
        if not (check.needs & lacks or (check.advice and compiled)):
            yield from check.find(view)

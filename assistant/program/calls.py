"""Calls of procedures."""

from __future__ import annotations

from dataclasses import dataclass

from assistant.program.expressions import Expression
from assistant.program.spanned import Spanned


@dataclass(frozen=True, slots=True)
class Call(Spanned):
    """Calls a procedure.

    unit: the program unit that holds it if that is loaded for the call (see Procedure).
    """

    procedure: str
    arguments: tuple[Expression, ...] = ()
    unit: str | None = None

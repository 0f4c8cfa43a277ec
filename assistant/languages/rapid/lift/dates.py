"""The date as text, which RAPID writes as 2026-01-31 and other languages with slashes.

Functions manual: CDate. Translated to and from RAPID, the one is made of the parts of the other.
"""

from __future__ import annotations

from dataclasses import replace
from functools import reduce
from typing import Any, Final

from assistant.program import expressions as e
from assistant.program.program import Program
from assistant.program.rewriting import rewrite
from assistant.program.statement_index import records_in_procedures

RAPID_DATE: Final = "cdate"
NEUTRAL_DATE: Final = "date_today"
_DATE_PARTS: Final = ((1, 4), (6, 2), (9, 2))
"""First character and length of year, month and day."""


def with_neutral_dates(program: Program) -> Program:
    """The program with dates as other languages have them."""
    return _with_date_function(program, RAPID_DATE, NEUTRAL_DATE, "-")


def with_own_dates(program: Program) -> Program:
    """The program with dates of RAPID."""
    return _with_date_function(program, NEUTRAL_DATE, RAPID_DATE, "/")


def _with_date_function(program: Program, old: str, new: str, between: str) -> Program:
    used = any(part.function.lower() == old for part in records_in_procedures(program, e.Apply))
    if not used or program.procedure(old) is not None:
        return program
    pieces = [e.Apply("part", (e.Apply(new), e.Number(a), e.Number(n))) for a, n in _DATE_PARTS]
    first, *others = pieces
    made = reduce(_joined_by(between), others, first)

    def visit(part: Any) -> Any:
        match part:
            case e.Apply(name, ()) if name.lower() == old:
                return made
        return part

    return replace(program, procedures=rewrite(program.procedures, visit))


def _joined_by(between: str) -> Any:
    def join(left: e.Expression, right: e.Expression) -> e.Expression:
        return e.Binary("+", e.Binary("+", left, e.Text(between)), right)

    return join

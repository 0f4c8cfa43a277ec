"""Outputs that are to be set on the way of a move, at a place that the way does not reach."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from assistant.base.diagnostics import Diagnostic, error, warning
from assistant.program.analysis.motion_use import straight_lengths
from assistant.program.expressions import Number
from assistant.program.passes.trigger_positions import constant_numbers, constant_value, sets_on_way
from assistant.program.program import Program, walk
from assistant.program.statements import Measure, MoveStatement

BEYOND_PATH = warning(
    "CK111",
    "`{name}` is set {amount:g} mm {where} of a way of {length:.2f} mm",
    "give a distance within the way, or set it before the move",
)
OUTSIDE_PATH = error(
    "CK112",
    "`{name}` is set at {amount:g} {unit} of the way of a move, which no way has",
    "write {most}",
)
ENDS: Final[Mapping[Measure, str]] = {"start": "behind the start", "end": "before the end"}
UNITS: Final[Mapping[Measure, str]] = {"start": "mm", "end": "mm", "time": "s", "share": "%"}


def outputs(program: Program) -> Iterator[Diagnostic]:
    """Places before the start, and behind the end of straight moves of known length."""
    if not sets_on_way(program):
        return
    known = straight_lengths(program)
    for procedure in program.procedures:
        numbers = constant_numbers(program, procedure)
        moves = [x for x in walk(procedure.body) if isinstance(x, MoveStatement)]
        for move, one in [(x, one) for x in moves for one in x.triggers]:
            stated = constant_value(one.amount, numbers)
            if isinstance(stated, Number):
                amount, length = float(stated.value), known.get(id(move))
                if amount < 0 or (one.measure == "share" and amount > 100):
                    unit = UNITS[one.measure]
                    most = "0 to 100 %" if one.measure == "share" else f"0 {unit} or more"
                    yield OUTSIDE_PATH(
                        name=one.signal, amount=amount, unit=unit, most=most, span=move.span
                    )
                elif length is not None and one.measure in ENDS and amount > length:
                    where = ENDS[one.measure]
                    yield BEYOND_PATH(
                        name=one.signal, amount=amount, where=where, length=length, span=move.span
                    )

"""Pulses of outputs that may be on already, after which languages leave them differently."""

from __future__ import annotations

from collections.abc import Iterator

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program

OFF_VALUES = (e.Number(0), e.Truth(False))


def doubtful_pulses(program: Program) -> Iterator[p.SetSignal]:
    """Pulses of signals that the program sets to something else than 0 as well.

    One that is set back to what it was, and one that is switched off, differ in these.
    """
    statements = tuple(program.statements())
    pulses = [x for x in statements if isinstance(x, p.SetSignal) and x.pulse is not None]
    if not pulses:
        return
    on = {
        one.signal.lower()
        for statement in statements
        for one in p.outputs(statement)
        if one.pulse is None and one.value not in OFF_VALUES
    }
    yield from (one for one in pulses if one.signal.lower() in on)

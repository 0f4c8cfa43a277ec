"""The timers of a program: what its statements start and read; nothing declares them."""

from __future__ import annotations

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program
from assistant.program.rewriting import head, records


def timers(program: Program) -> tuple[str, ...]:
    """Names as they are spelled first, in order of the text."""
    found: dict[str, str] = {}
    for statement in program.statements():
        names = sorted(part.timer for part in records(head(statement)) if isinstance(part, _TIMED))
        for name in names:
            found.setdefault(name.lower(), name)
    return tuple(found.values())


_TIMED = (p.StartTimer, e.Elapsed)

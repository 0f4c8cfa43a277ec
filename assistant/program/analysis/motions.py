"""How the moves of a program are made."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Blend, Speed
from assistant.program.program import Program


def motions(program: Program) -> Iterator[tuple[Speed | e.Name, Blend | e.Name]]:
    """Every speed and blend that a move states, each table entry of a path once."""
    for statement in program.statements():
        if isinstance(statement, p.MoveStatement):
            yield statement.motion.speed, statement.motion.blend
        elif isinstance(statement, p.Follow):
            path = statement.path
            used = (
                [path.speeds[i] for i in np.unique(path.speed)],
                [path.blends[i] for i in np.unique(path.blend)],
            )
            most = max(len(u) for u in used)
            for i in range(most):
                yield used[0][min(i, len(used[0]) - 1)], used[1][min(i, len(used[1]) - 1)]

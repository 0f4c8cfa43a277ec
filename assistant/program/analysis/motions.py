"""How the moves of a program are made."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.arrays import Ints
from assistant.program.motion import Blend, Speed
from assistant.program.path import configuration_row
from assistant.program.program import Program
from assistant.program.rewriting import records


def stated_motions(program: Program) -> Iterator[tuple[Speed | e.Name, Blend | e.Name]]:
    """Every speed and blend that a move states, each table entry of a path once."""
    for statement in program.statements():
        if isinstance(statement, p.MoveStatement):
            yield statement.motion.fixed
        elif isinstance(statement, p.Follow):
            path = statement.path
            used = (
                [path.speeds[i] for i in np.unique(path.speed)],
                [path.blends[i] for i in np.unique(path.blend)],
            )
            most = max(len(u) for u in used)
            for i in range(most):
                yield used[0][min(i, len(used[0]) - 1)], used[1][min(i, len(used[1]) - 1)]


def branches_by_frame(
    program: Program, coded: Callable[[NDArray[np.int8]], Ints]
) -> dict[str, dict[tuple[int, ...], None]]:
    """Arm branches of the targets in each frame (lower case), in the order of their first use.

    Those of a path by their numbers. coded: branches (n, 6) as the numbers (n, k) of a language.
    """
    found: dict[str, dict[tuple[int, ...], None]] = {}
    targets = {name.lower(): target for name, target in program.targets.items()}

    def use(frame: str, branches: Ints) -> None:
        found.setdefault(frame.lower(), {}).update(dict.fromkeys(map(tuple, branches.tolist())))

    for node in program.statements():
        if isinstance(node, p.Follow):
            path = node.path
            codes = coded(path.configurations)
            for row, name in enumerate(path.frames):
                use(name, np.unique(codes[path.frame == row], axis=0))
        elif isinstance(node, p.Move | p.MoveCircular):
            for value in records((node.target, getattr(node, "via", None))):
                target = value.target if isinstance(value, e.TargetValue) else None
                if isinstance(value, e.Name):
                    target = targets.get(value.name.lower())
                if target is not None:
                    branch = [configuration_row(target.configuration)]
                    use(node.motion.frame, coded(np.array(branch, dtype=np.int8)))
    return found

"""How long straight moves are, where the text of a program tells."""

from __future__ import annotations

import math
from collections.abc import Mapping

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Target, Vector
from assistant.program.program import Procedure, Program, bodies

KnownPosition = tuple[Vector, str, str] | None
"""A position in mm with the tool and frame, lower case, that it is of; None if it is not known."""


def straight_lengths(program: Program) -> dict[int, float]:
    """Mm of the straight moves that set outputs on their way, by identity of the statement.

    Of one that begins where the statement before it ends, in the same tool and frame.
    """
    targets = {name.lower(): target for name, target in program.targets.items()}
    found: dict[int, float] = {}
    for procedure in program.procedures:
        known = {k: t for k, t in targets.items() if k not in _own_names(procedure)}
        _measure_body(procedure.body, known, found)
    return found


def _own_names(procedure: Procedure) -> set[str]:
    named = (*procedure.variables, *(q.name for q in procedure.parameters))
    return {name.lower() for name in named}


def _measure_body(
    body: tuple[p.Statement, ...], targets: Mapping[str, Target], found: dict[int, float]
) -> None:
    here: KnownPosition = None
    for node in body:
        before, here = here, _position_after(node, here, targets)
        straight = isinstance(node, p.Move) and node.kind == "linear" and node.triggers
        if straight and before is not None and here is not None and before[1:] == here[1:]:
            found[id(node)] = math.dist(before[0], here[0])
        for inner in bodies(node):
            _measure_body(inner, targets, found)


def _position_after(
    node: p.Statement, here: KnownPosition, targets: Mapping[str, Target]
) -> KnownPosition:
    if isinstance(node, p.MoveStatement) and node.until is not None:
        return None
    match node:
        case p.Move(target=value, motion=motion) | p.MoveCircular(target=value, motion=motion):
            target = value.target if isinstance(value, e.TargetValue) else None
            if isinstance(value, e.Name):
                target = targets.get(value.name.lower())
            if target is None:
                return None
            return target.pose.position, motion.tool.lower(), motion.frame.lower()
        case p.Follow(path) if len(path):
            x, y, z = path.positions[-1].tolist()
            tool, frame = path.tools[path.tool[-1]], path.frames[path.frame[-1]]
            return (x, y, z), tool.lower(), frame.lower()
    return here if p.trait(node) in ("sets", "says", "waits") else None

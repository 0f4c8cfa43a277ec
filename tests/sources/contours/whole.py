"""Contours of a program as whole ways, whatever their targets are called."""

from dataclasses import replace

import numpy as np

from assistant.program.expressions import Apply, Name
from assistant.program.motion import Kind, Path
from assistant.program.statements import Follow, Move, MoveCircular


def pose(expression, targets):
    """Where a move goes: to a named target, or along the tool from it."""
    if isinstance(expression, Name):
        return targets[expression.name].pose
    assert isinstance(expression, Apply)
    assert expression.function == "relative"
    base, *shift = expression.arguments
    return pose(base, targets).offset(*(n.value for n in shift))


def whole_paths(procedure, targets):
    """A path for each contour, after its start: its rows and the move to its end."""
    found, started, rows = [], False, None
    for statement in procedure.body:
        if isinstance(statement, Follow):
            rows = statement.path
        elif isinstance(statement, MoveCircular) or (
            isinstance(statement, Move) and isinstance(statement.target, Name) and started
        ):
            found.append(_with_end(rows, statement, targets))
            started, rows = False, None
        elif isinstance(statement, Move) and isinstance(statement.target, Name):
            started = True
    return found


def _with_end(rows, move, targets):
    arc = isinstance(move, MoveCircular)
    names = [move.via.name, move.target.name] if arc else [move.target.name]
    kinds = [Kind.VIA, Kind.END] if arc else [Kind.LINEAR]
    poses = [targets[name].pose for name in names]
    end = Path.of(
        names[0].rsplit("_", 1)[0],
        [p.position for p in poses],
        [p.quaternion for p in poses],
        kinds=kinds,
        speeds=(move.motion.speed,),
        blends=(move.motion.blend,),
        tools=(move.motion.tool,),
        frames=(move.motion.frame,),
    )
    if rows is None:
        return end
    assert (rows.name, rows.speeds, rows.tools) == (end.name, end.speeds, end.tools)
    joined = ("kinds", "positions", "quaternions", "configurations", "external")
    still = np.zeros(len(end), np.int32)
    return replace(
        rows,
        **{c: np.concatenate([getattr(rows, c), getattr(end, c)]) for c in joined},
        **{c: np.concatenate([getattr(rows, c), still]) for c in ("speed", "tool", "frame")},
        blend=np.concatenate([rows.blend, still + len(rows.blends)]),
        blends=(*rows.blends, *end.blends),
    )

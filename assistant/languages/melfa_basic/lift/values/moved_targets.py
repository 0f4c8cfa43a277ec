"""Positions moved by a constant: `P1+(0,0,50)` and `P1*(0,0,50,0,0,90)`."""

from __future__ import annotations

import numpy as np

from assistant.base import rotations
from assistant.languages.melfa_basic.lift.values.symbols import Symbols, Unliftable
from assistant.languages.melfa_basic.tables.poses import plain_pose, plain_values
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.geometry import Pose


def constant_shift(node: s.Expression, symbols: Symbols) -> s.Constant | None:
    """The constant that a position is moved by, also by the name of one that never changes."""
    if isinstance(node, s.Constant):
        return node
    if isinstance(node, s.Variable) and node.arguments is None and not node.component:
        if not symbols.own and node.key not in symbols.constants.assigned:
            return symbols.positions.constant(node.key)
    if (
        isinstance(node, s.Variable)
        and node.key == "INV"
        and (pose := constant_pose(node, symbols))
    ):
        return s.Constant(plain_values(pose))
    return None


def constant_pose(node: s.Expression | None, symbols: Symbols) -> Pose | None:
    """Where a constant, or the inverse or product of such, is; None if that is not known."""
    if symbols.own or (symbols.robot is not None and symbols.robot.five_axis):
        return None
    match node:
        case s.Variable(key="INV", arguments=(inner,), component=""):
            pose = constant_pose(inner, symbols)
            return None if pose is None else pose.inverse()
        case s.Binary(operator="*", left=left, right=right):
            one, two = constant_pose(left, symbols), constant_pose(right, symbols)
            return None if one is None or two is None else one @ two
        case None:
            return None
    constant = constant_shift(node, symbols)
    if constant is None or any(constant.values[6:]) or None in constant.values:
        return None
    return plain_pose(constant.values)


def shift_amounts(operator: str, constant: s.Constant, symbols: Symbols) -> list[float]:
    """How far: mm along x, y, z, and degrees about x, the new y, the new z if it turns at all.

    operator: `+`, `-` or `*`. Raises Unliftable for what the pseudo-program has no words for.
    """
    values = [0.0 if v is None else float(v) for v in constant.values]
    values += [0.0] * (6 - len(values))
    five_axis = symbols.robot is not None and symbols.robot.five_axis
    if any(values[6:]) or (five_axis and any(values[3:]) and not symbols.own):
        raise Unliftable
    if operator == "-":
        values = [-v + 0.0 for v in values]
    turned = values[3:6]
    if operator != "*" and any(turned):
        raise Unliftable
    if sum(v != 0.0 for v in turned) > 1:  # turned about x, then the new y, then the new z
        whole = rotations.from_euler(np.array(turned[::-1]), "ZYX")
        values[3:6] = [round(float(v), 9) + 0.0 for v in rotations.to_euler(whole, "XYZ")]
    used = values[:6] if any(turned) else values[:3]
    while len(used) > 3 and used[-1] == 0.0:
        used.pop()
    return used


def is_inverse(node: s.Expression) -> bool:
    return isinstance(node, s.Variable) and node.key == "INV"

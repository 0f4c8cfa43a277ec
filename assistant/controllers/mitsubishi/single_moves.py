"""Single moves as the statements that a controller carries out, with variables of its own.

`posture` is what the controller writes behind the numbers of a position, with its closing bracket.
"""

from __future__ import annotations

from assistant.base.arrays import Floats


def joints_statement(joints: Floats) -> list[str]:
    """By the joints. joints: (6,) in degrees."""
    return [f"J99={_bracket(joints)}", "MOV J99"]


def pose_statement(pose: Floats, posture: str) -> list[str]:
    """By the joints. pose: (6,) X, Y, Z in mm, A, B, C in degrees."""
    return [_position("P99", pose, posture), "MOV P99"]


def line_to_joints_statement(joints: Floats) -> list[str]:
    """On a line to where joints bring the tool."""
    return [f"J99={_bracket(joints)}", "P99=JTOP(J99)", "MVS P99"]


def line_to_pose_statement(pose: Floats, posture: str) -> list[str]:
    """On a line."""
    return [_position("P99", pose, posture), "MVS P99"]


def arc_statement(via: Floats, pose: Floats, posture: str) -> list[str]:
    """From where the arm is, by way of a pose to another one."""
    first, last = _position("P98", via, posture), _position("P99", pose, posture)
    return ["P97=P_CURR", first, last, "MVR P97,P98,P99"]


def _position(name: str, pose: Floats, posture: str) -> str:
    return f"{name}={_bracket(pose)}({posture}"


def _bracket(values: Floats) -> str:
    return f"({','.join(f'{value:.2f}' for value in values)})"

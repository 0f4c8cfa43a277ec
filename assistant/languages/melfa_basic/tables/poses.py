"""Poses in columns to and from the X, Y, Z, A, B, C, L1, L2 and flags of MELFA-BASIC.

Six axes: R = Rz(C)·Ry(B)·Rx(A). Five axes (RV-2AJ): B is the tilt of the tool axis and A
the roll about it, C is 0 and the azimuth follows from the position (see robots.five_axis).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Ints
from assistant.program.geometry import NO_EXTERNAL, Pose, Target
from assistant.robots.configurations import FLIP, from_flags, to_flags

if TYPE_CHECKING:
    from assistant.robots import Robot


ADDITIONAL: Final = {"external_1": ("L1", "J7"), "external_2": ("L2", "J8")}
"""Components of a position and of a joint position that additional axes have.

They are mm, or radian of an axis that turns, which no program tells.
"""
UNITS: Final = Target(Pose(), None, (1.0, 1.0, *NO_EXTERNAL[2:]))
"""A position with additional axes at 1 mm or degree: the unit for other languages, for either kind
of axis.
"""

PLACES: Final = 2
"""Decimals of a position line."""

JOINTS: Final = ("J1", "J2", "J3", "J4", "J5", "J6")
"""Components of a joint position."""

ANGLES: Final = {"about_x": "A", "about_y": "B", "about_z": "C"}
"""Angles of a position, as the pseudo-program calls them and as the controller does."""

FINE_PLACES: Final = 4
"""Decimals of tools, frames and constants in statements: their angles act over the distance to what
they are multiplied with, again and again where a program adds to its own positions."""


def to_values(
    positions: Floats,
    quaternions: Floats,
    external: Floats,
    robot: Robot | None,
    places: int = PLACES,
) -> Floats:
    """(n, 6 … 8) mm and degrees; L1 and L2 as far as any row uses them, 0 where one does not."""
    if robot is not None and robot.five_axis:
        from assistant.robots.arms import closed_form

        ab = closed_form.to_ab(positions, quaternions)
        angles = np.column_stack([ab, np.zeros(len(ab))])
    else:
        angles = rotations.to_euler(quaternions, "ZYX")[..., ::-1]
    used = ~np.isnan(external[:, :2])
    # L2 alone cannot be written: L1 comes before it.
    count = 2 if used[:, 1].any() else 1 if used[:, 0].any() else 0
    extra = np.nan_to_num(external[:, :count])
    # Adding 0.0 makes 0.0 of -0.0.
    return np.round(np.column_stack([positions, angles, extra]), places) + 0.0


def from_values(values: Floats, robot: Robot | None) -> tuple[Floats, Floats, Floats]:
    """Positions (n, 3), quaternions (n, 4) and external axes (n, 6) of (n, 6 … 8) values."""
    # In a table with additional axes, NaN is kept for those that a row does not state.
    values = np.nan_to_num(values) if values.shape[1] <= 6 else values
    positions, angles = np.nan_to_num(values[:, :3]), np.nan_to_num(values[:, 3:6])
    if robot is not None and robot.five_axis:
        from assistant.robots.arms import closed_form

        quaternions = closed_form.from_ab(positions, angles[:, :2])
    else:
        quaternions = rotations.from_euler(angles[:, ::-1], "ZYX")
    external = np.full((len(values), 6), np.nan)
    external[:, : values.shape[1] - 6] = values[:, 6:8]
    return positions, quaternions, external


def flags_of(configurations: NDArray[np.int8], robot: Robot | None) -> Ints:
    """Return (n, 2) FL1 and FL2; bits without meaning for an arm, as for a wrist without flip, are
    0.
    """
    flags = to_flags(configurations)
    return flags if robot is None else flags & (robot.arm.flags, -1)


def configurations_of(flags: Ints, robot: Robot | None) -> NDArray[np.int8]:
    """Return (n, 6) columns of (n, 2) flags, without the bits that have no meaning for the arm."""
    configurations = from_flags(flags if robot is None else flags & (robot.arm.flags, -1))
    if robot is not None and robot.five_axis:
        # The wrist of five axes cannot flip.
        configurations[:, FLIP] = 0
    return configurations


def rounded_configurations(
    configurations: NDArray[np.int8], robot: Robot | None
) -> NDArray[np.int8]:
    """The configurations as they come back from their flags; unstated ones as (7,0)."""
    return configurations_of(flags_of(configurations, robot), robot)


def is_units(target: Target) -> bool:
    """True if a position is `UNITS`."""
    return target.pose == UNITS.pose and target.external[:2] == UNITS.external[:2]


def is_length(component: str, robot: Robot | None) -> bool:
    """True if a component is in mm: X, Y, Z, and of a joint position an axis that slides."""
    if robot is None or component not in robot.axes:
        return component in ("X", "Y", "Z")
    return bool(robot.sliding[robot.axes.index(component)])


def is_angle(component: str, robot: Robot | None) -> bool:
    """True if a component is that of an axis that turns, which the controller gives in radian."""
    if component in ANGLES.values():
        return robot is None or not robot.five_axis
    return component in JOINTS and not is_length(component, robot)


def plain_values(pose: Pose) -> tuple[float, ...]:
    """A tool or frame as six values."""
    angles = rotations.to_euler(np.array(pose.quaternion), "ZYX")[::-1]
    values = np.round(np.concatenate([pose.position, angles]), FINE_PLACES) + 0.0
    return tuple(float(v) for v in values)


def plain_pose(values: tuple[float | None, ...]) -> Pose:
    """A tool or frame of six values."""
    # From C back to A: the order of the rotations.
    six = np.array([v or 0.0 for v in (*values, *(0.0,) * 6)[:6]])
    return Pose.of(six[:3], rotations.from_euler(six[:2:-1], "ZYX"))

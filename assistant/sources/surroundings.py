"""What stands around the work, as far as a source asks for it: how long travel takes, and from
where the tool can come to a place. `cell.planning.approaches` answers it, which knows arms and
bodies.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic
from assistant.program.geometry import Pose, Vector

ALONG_TOOL: Vector = (0.0, 0.0, -1.0)
"""Back from a place along the tool, in the tool's own axes."""


def travel_seconds(one: tuple[float, ...], other: tuple[float, ...]) -> float:
    """Of a joint move between two of `Surroundings.places`: the axes move together."""
    return max(abs(a - b) for a, b in zip(one, other, strict=True))


@dataclass(frozen=True, slots=True)
class WayIn:
    """direction: of unit length, in the tool's axes, from the place to where the tool comes from
    or goes to. findings: what is said of it.
    """

    direction: Vector = ALONG_TOOL
    findings: tuple[Diagnostic, ...] = ()


class Surroundings(Protocol):
    """Poses are those of the tip in the base of the robot, tools the tip in the flange."""

    def places(self, positions: Floats, quaternions: Floats, tool: Pose) -> Floats | None:
        """Tips (n, 3), (n, 4) → (n, k), of which two are as many seconds apart as a joint move
        between them takes at full speed: the largest of their differences. None if one of them is
        out of reach.
        """

    def way_in(self, pose: Pose, tool: Pose, distance: float, place: str) -> WayIn:
        """From where the tool can come to a pose in a line of `distance` mm, touching nothing.

        place: the pose, for findings.
        """


SurroundingsByRobot = Callable[[str | None], Surroundings | None]
"""The surroundings by the robot that a source names, if it names one."""

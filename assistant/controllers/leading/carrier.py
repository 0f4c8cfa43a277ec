"""What takes small steps to an arm, whichever way leads there.

Who leads an arm by what it sees works out each step meanwhile: a `Carrier` takes it to the arm and
tells where the arm is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Final, Protocol, Self

import numpy as np

from assistant.base.arrays import Floats
from assistant.program.geometry import Pose

USUAL_AXES: Final = 6
"""Axes of a usual arm, which protocols count with or without them."""


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """An arm of a axes, and what it may do while it is led.

    axes: J1, J2 … of the arm. sliding: (a,) which of them slide. limits: (a, 2). full: (a,) its own
    greatest speeds a second. speeds, rises: (a,) a second (squared) that no step may exceed.
    share: part of `full` at which a motion of all axes keeps to what its tool may do; of ways in
    which the controller chooses how fast it goes. pose_of: joints (a,) → the tool in the base.
    joints_of: a pose of the tool, and joints (a,) near to which it is looked for; None if none are.
    """

    axes: tuple[str, ...]
    sliding: tuple[bool, ...]
    limits: Floats
    full: Floats
    speeds: Floats
    rises: Floats
    share: float
    pose_of: Callable[[Floats], Pose]
    joints_of: Callable[[Pose, Floats], Floats | None]

    @property
    def places(self) -> list[int]:
        """Columns of the axes where J1 is the first, whichever the arm lacks."""
        return [int(axis[1:]) - 1 for axis in self.axes]

    def numbered(self, values: Floats, missing: float) -> Floats:
        """Values of axes (…, a) with a column for each number; missing: of the others."""
        width = max(USUAL_AXES, max(self.places) + 1)
        found = np.full((*values.shape[:-1], width), missing)
        found[..., self.places] = values
        return found

    @property
    def part(self) -> float:
        """Part of its full speed that keeps to `speeds` and `share`."""
        return min(self.share, float((self.speeds / self.full).min()))

    @property
    def percent(self) -> int:
        """`part` in percent, 1 where it is less: controllers go no slower."""
        return int(np.clip(np.floor(100.0 * self.part), 1, 100))

    @property
    def slow(self) -> Floats:
        """(a,) the speeds of `percent`."""
        return np.minimum(self.speeds, self.full * self.percent / 100.0)


class Carrier(Protocol):
    """A context manager: entering makes the arm ready, leaving brings it to rest and ends the way.

    period: seconds that a step takes at least. speeds: (a,) that steps may have. waits: whether
    `move` comes back when the arm stands, so that what was seen before is of another place.
    """

    period: float
    speeds: Floats
    waits: bool

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None: ...

    def joints(self) -> Floats:
        """(a,) where the arm is, as it tells; raises Refused if it is not known any more."""

    def told(self) -> Floats:
        """(a,) where it was told to be last."""

    def move(self, to: Floats, seconds: float) -> None:
        """Has the arm be at joints (a,) in so many seconds, near to where it was told to be.

        It comes to rest there by itself if no other step follows. Raises Refused.
        """

    def rest(self) -> None:
        """Has the arm come to rest now, at its accelerations."""

"""How the arm follows the motions that programs command: the interface, and without any time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

from assistant.program.geometry import Pose
from assistant.virtual.events import Moved, Switched

if TYPE_CHECKING:
    from assistant.virtual.kernel.task import Task


class Motion(Protocol):
    """The arm of a controller."""

    def go(self, task: Task, moved: Moved, changes: Sequence[Switched] = ()) -> None:
        """Commands a motion, and waits as the controller does before the next statement.

        changes: outputs that are set on its way.
        """

    def settle(self, task: Task) -> None:
        """Waits until the arm stands at its latest target, whatever corner the motion states."""

    def stands(self) -> bool:
        """Whether the arm does not move now."""

    def where(self) -> tuple[Pose, tuple[float, ...]] | None:
        """The flange in the base and the joints in degrees while the arm moves, else None: then it
        stands where the latest motion leads.
        """


class Instant:
    """Motions take no time: the arm is where it is sent."""

    def go(self, task: Task, moved: Moved, changes: Sequence[Switched] = ()) -> None:
        task.tell(moved)
        for change in changes:
            task.switch(change.signal, change.value, change.at)

    def settle(self, task: Task) -> None:
        """The latest motion was one that ends at its target."""
        task.kernel.stop_latest()

    def stands(self) -> bool:
        return True

    def where(self) -> None:
        return None

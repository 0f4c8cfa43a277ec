"""How the arm follows the motions that programs command: the interface, and without any time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol

from assistant.program.geometry import Pose
from assistant.virtual.events import Moved, Switched

if TYPE_CHECKING:
    from assistant.virtual.kernel.kernel import Kernel
    from assistant.virtual.kernel.task import Task


class Progress(NamedTuple):
    """Of a motion: mm that are left, the percent that is done, and mm/s of the tool."""

    left: float = 0.0
    done: float = 100.0
    speed: float = 0.0


Standing = tuple[Pose, tuple[float, ...]]
"""The flange in the base, and the joints J1, J2, … in degrees."""


class Motion(Protocol):
    """The arm of a controller.

    A motion that takes time may let a program run ahead as long as nobody asks for the time: the
    times of what is logged meanwhile are put right by `catch_up`. behind: whether they are to be.
    """

    @property
    def behind(self) -> bool: ...

    def go(self, task: Task, moved: Moved, changes: Sequence[Switched] = ()) -> None:
        """Commands a motion, and waits as the controller does before the next statement.

        changes: outputs that are set on its way.
        """

    def settle(self, task: Task) -> None:
        """Waits until the arm stands at its latest target, whatever corner the motion states."""

    def stands(self) -> bool:
        """Whether the arm is where its latest motion leads."""

    def where(self) -> Standing | None:
        """Where the arm is now; None if only the motions tell, which take no time."""

    def progress(self) -> Progress | None:
        """Of the motion that is made now, or was made last; None if only the motions tell."""

    def catch_up(self, kernel: Kernel) -> None:
        """Somebody asks for the time: it is as late as the program is."""

    def rest(self) -> float:
        """The time from which on the arm stands, if nothing more is commanded."""

    def store(self, kernel: Kernel) -> None:
        """Stops the arm, and keeps what it was to do until `restore`; other motions may come."""

    def restore(self, task: Task) -> None:
        """What was kept is to be done again; the arm stays where it is until `resume`."""

    def cut(self, task: Task) -> Standing | None:
        """Ends all motions where the arm is, and tells where that is."""

    def lead(self, kernel: Kernel, joints: Sequence[float]) -> None:
        """The arm, which stood, is at these joints in degrees, where no motion led it."""

    def hold(self, kernel: Kernel) -> None:
        """Stops the arm on its way."""

    def resume(self, kernel: Kernel) -> None:
        """Lets the arm go on."""

    def forget(self) -> None:
        """Nobody will ask for what is over."""


class Instant:
    """Motions take no time: the arm is where it is sent."""

    behind = False

    def go(self, task: Task, moved: Moved, changes: Sequence[Switched] = ()) -> None:
        task.tell(moved)
        for change in changes:
            task.kernel.change(task, change)

    def settle(self, task: Task) -> None:
        """The latest motion was one that ends at its target."""
        task.kernel.stop_latest()

    def stands(self) -> bool:
        return True

    def where(self) -> None:
        return None

    def progress(self) -> None:
        return None

    def catch_up(self, kernel: Kernel) -> None:
        """There is nothing behind."""

    def rest(self) -> float:
        return -math.inf

    def store(self, kernel: Kernel) -> None:
        """Nothing is left to do."""

    def restore(self, task: Task) -> None:
        """Nothing was left to do."""

    def cut(self, task: Task) -> None:
        """The latest motion has come to its end."""

    def lead(self, kernel: Kernel, joints: Sequence[float]) -> None:
        """Who leads it knows."""

    def hold(self, kernel: Kernel) -> None:
        """The arm stands."""

    def resume(self, kernel: Kernel) -> None:
        """The arm stands."""

    def forget(self) -> None:
        """There is nothing to forget."""

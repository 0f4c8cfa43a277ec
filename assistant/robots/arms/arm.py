"""What every kind of arm can tell about itself, in columns.

Angles are radians here and mm for an axis that slides: chain values, which are the maker's own
with `Robot.zero` added.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Rows, Truths

if TYPE_CHECKING:
    from assistant.robots.arms.chain import Chain

CLOSING: Final = 1e-5
"""mm and degrees within which forward kinematics must come back to a pose."""
MISS_TOLERANCE: Final = 0.01
"""degrees; an orientation so little off what an arm of less than six axes can take counts as
its own. It is what a position printed with two decimals turns the plane of an arm by at short
reach."""
BOUNDARY: Final = 1e-6
"""degrees below a quadrant's first angle that still count to it, for joints that are
meant to be 0 or 90 and come out of arithmetic as a little less."""


@dataclass(frozen=True, slots=True)
class Link:
    """A row of standard Denavit-Hartenberg parameters, `Rz(theta)·Tz(d)·Tx(a)·Rx(alpha)`.

    a, d: mm. alpha, theta: radians. The joint is added to theta, to d if it slides.
    """

    a: float = 0.0
    d: float = 0.0
    alpha: float = 0.0
    theta: float = 0.0
    sliding: bool = False


class Arm(ABC):
    """A kind of arm with its lengths.

    kind: as a robot file names it. axes: names of the a joints. sliding: (a,) which of them
    move along their axis, in mm. branches: how many `ik` tells apart. reach: mm from axis 1 to
    the wrist of the stretched arm. angle: degrees within which a pose must be met.
    flags: the bits of Mitsubishi's FLG1 that say something of such an arm.
    spherical: whether axes 4, 5 and 6 meet, so that the wrist has its one singularity.
    rolls: 1 where axes 4 and 6 in line turn the flange to the same side, -1 where they do not.
    named: whether makers have names for its branches, so that a configuration says one.
    compared: joints by which two branches differ, one that means nothing in line left out.
    """

    kind: ClassVar[str]
    angle: ClassVar[float] = CLOSING
    flags: ClassVar[int] = 7
    spherical: ClassVar[bool] = False
    rolls: float = 1.0
    named: ClassVar[bool] = True

    @property
    @abstractmethod
    def axes(self) -> tuple[str, ...]: ...

    @property
    @abstractmethod
    def branches(self) -> int: ...

    @property
    @abstractmethod
    def compared(self) -> tuple[int, ...]: ...

    @property
    def sliding(self) -> Truths:
        return np.zeros(len(self.axes), dtype=bool)

    @property
    @abstractmethod
    def reach(self) -> float: ...

    @abstractmethod
    def fk(self, joints: Floats) -> tuple[Floats, Floats]:
        """Chain values (n, a) → flange positions (n, 3) mm, quaternions (n, 4)."""

    @abstractmethod
    def ik(
        self, positions: Floats, quaternions: Floats, branches: tuple[int, ...]
    ) -> tuple[Floats, Floats]:
        """Flange poses → chain values (a, b, n) and what keeps each from closing (b, n) mm.

        branches: which, ascending. A length of 0 closes.
        """

    @abstractmethod
    def shape(self, joints: Floats) -> NDArray[np.int8]:
        """(n, 3) columns back, down and flip of a configuration (see `Path`)."""

    @abstractmethod
    def branch(self, shape: Rows) -> Rows:
        """(n, 3) columns back, down, flip → (n,) index of the branch among those of `ik`."""

    @abstractmethod
    def words(self, shape: NDArray[np.integer]) -> str:
        """Columns (3,) back, down, flip as they are said of such an arm."""

    @abstractmethod
    def points(self, joints: Floats) -> Floats:
        """(n, k, 3) mm: base, the ends of the links in order, flange."""

    def elbow(self, joints: Floats) -> Floats | None:  # noqa: ARG002 - of some
        """(n,) radians by which the elbow is bent; None for an arm without one."""
        return None

    def wrist(self, joints: Floats) -> Floats | None:  # noqa: ARG002 - of some
        """(n,) mm of the wrist centre in front of axis 1, less than 0 behind it; None for an
        arm without one.
        """
        return None

    @abstractmethod
    def links(self) -> tuple[Link, ...]:
        """The same chain by the standard parameters of Denavit and Hartenberg."""

    @cached_property
    def whole_chain(self) -> Chain:
        """The same as joints from the base, for the frames of its links."""
        from assistant.robots.arms.chain import Chain

        links = self.links()
        return Chain.of_links(links, [(-np.pi, np.pi)] * len(links))

    def miss(self, joints: Floats, quaternions: Floats) -> Floats:  # noqa: ARG002 - of some
        """(n,) degrees that the arm cannot turn its flange by to quaternions (n, 4).

        joints: (n, a) chain values of any branch of `ik` for the pose.
        """
        return np.zeros(len(quaternions))

    @abstractmethod
    def too_far(self, positions: Floats, quaternions: Floats) -> Truths:
        """(n,) of poses out of reach, whether they are beyond it and not too near."""


def turn_between(left: Floats, right: Floats) -> Floats:
    """(n,) degrees between quaternions (n, 4)."""
    same = np.abs(np.einsum("ij,ij->i", left, right))
    return np.asarray(2.0 * np.degrees(np.arccos(np.clip(same, 0.0, 1.0))))

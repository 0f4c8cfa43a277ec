"""What a block is: ports with units, and what it does at each of its steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats


@dataclass(frozen=True, slots=True)
class Port:
    """name: of the signal. size: numbers that it has. unit: `deg`, `mm`, `mm/s`, "" for none.

    also: other sizes that an input takes. means: the numbers of each size, for messages.
    """

    name: str
    size: int = 1
    unit: str = ""
    also: tuple[int, ...] = ()
    means: str = ""

    @property
    def wanted(self) -> str:
        """The sizes that an input takes, and the numbers of each, in words."""
        sizes = " or ".join(map(str, (self.size, *self.also)))
        return f"{sizes}: {self.means}" if self.means else sizes

    def takes(self, size: int) -> bool:
        """True if signals of that size fit the input."""
        return size == self.size or size in self.also


class Block:
    """A block of a diagram; a subclass says its ports and what it does.

    direct: whether what it gives comes of what it is given in the same step; blocks that are not,
    such as delays and arms, may stand in a loop. period: seconds between its steps, None for each
    step of the diagram; between them it gives what it gave before. moves: name of the controller
    whose arm it moves, "" for none; a run has to be told that somebody confirmed that.
    """

    direct: ClassVar[bool] = True
    moves: str = ""

    def __init__(
        self,
        name: str,
        inputs: Sequence[Port] = (),
        outputs: Sequence[Port] = (),
        *,
        period: float | None = None,
    ) -> None:
        self.name = name
        self.inputs = tuple(inputs)
        self.outputs = tuple(outputs)
        self.period = period

    def begin(self) -> None:
        """Before the first step; what it opens here, `end` closes."""

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Its outputs at a moment. given: signals of its inputs; () for one that is not direct."""
        raise NotImplementedError

    def take(self, now: float, given: Sequence[Floats]) -> None:
        """All signals of a moment are there; what the block remembers changes here."""

    def end(self) -> None:
        """After the last step, whatever it was; also if `begin` of another block failed."""

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}>"


def signal(value: ArrayLike, port: Port) -> Floats:
    """A value as the signal of a port; raises ValueError for one of another size."""
    found = np.atleast_1d(np.asarray(value, dtype=np.float64))
    if found.shape != (port.size,):
        raise ValueError(f"`{port.name}` has {port.size} numbers, not {found.shape}")
    return found

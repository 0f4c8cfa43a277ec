"""Blocks that share a connection with others."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future
from typing import Any, ClassVar, Generic, TypeVar

from assistant.blocks.connections import Connection
from assistant.blocks.diagrams.block import Block, Port

T = TypeVar("T")


class Connected(Block, Generic[T]):
    """A block that has a share of its connection from the beginning of a run to its end."""

    direct: ClassVar[bool] = False

    def __init__(
        self,
        name: str,
        connection: Connection[T],
        inputs: Sequence[Port],
        outputs: Sequence[Port],
        period: float | None,
    ) -> None:
        super().__init__(name, inputs, outputs, period=period)
        self.connection = connection
        self._share: T | None = None

    @property
    def share(self) -> T:
        """What is connected to; only in a run."""
        assert self._share is not None, "a run has begun"
        return self._share

    def begin(self) -> None:
        self._shown: Future[Any] | None = None
        self._share = self.connection.take()

    def ended(self, motion: Future[Any] | None) -> bool:
        """True if a motion has ended. At the first step after its begin it counts as under way, so
        that the block is busy at one step at least, however quick the motion is.
        """
        shown, self._shown = motion is self._shown, motion
        return motion is not None and shown and motion.done()

    def end(self) -> None:
        if self._share is not None:
            self._share = None
            self.connection.leave()

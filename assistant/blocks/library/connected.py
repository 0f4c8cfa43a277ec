"""Blocks that share a connection with others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Generic, TypeVar

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
        self._share = self.connection.take()

    def end(self) -> None:
        if self._share is not None:
            self._share = None
            self.connection.leave()

"""Models in lock step with virtual controllers: their time passes with the model's, and no faster.

    with VirtualCr("rv-2aj", lock_step=True) as cell:
        cellar = operated("cell", cell.address)
        ...
        run(diagram, 5.0, 0.01, clock=LockStep(cell, connections=[cellar]), moving=["cell"])

Data that blocks send at a step reaches the controller at the time of this step, over its real
lines; the same model gives the same columns each time, and as fast as it can be computed.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any, Final, Protocol

from assistant.base.diagnostics import Refused
from assistant.blocks.connections import Connection
from assistant.blocks.rules import OUT_OF_LOCK_STEP

_PATIENCE: Final = 10.0
LOOK: Final = 2e-5
"""Seconds between two looks whether it has."""


class SteppedCell(Protocol):
    """A virtual controller with `lock_step`."""

    @property
    def port(self) -> int: ...

    @property
    def executing(self) -> bool: ...

    def advance(self, moment: float) -> None: ...

    def free(self) -> None: ...


class LockStep:
    """Clock of a run in which virtual controllers keep step with the model.

    cells: the controllers. connections: of the blocks that command them; the clock does not wait
    for a connection that cannot report whether anything is in transit (`settled`). begins: seconds
    of the controllers at which the model begins. With 0 their time is stopped while connections are
    opened; programs that must run for this need more, and until then time passes in real time.
    patience: real seconds in which data in transit over a line must arrive.
    """

    def __init__(
        self,
        *cells: SteppedCell,
        connections: Sequence[Connection[Any]] = (),
        begins: float = 0.0,
        patience: float = _PATIENCE,
    ) -> None:
        self.cells, self.connections, self.begins = cells, connections, begins
        self.patience = patience
        if begins > 0.0:
            for cell in cells:
                cell.free()

    def begin(self) -> None:
        """Raises Refused for a controller that does not come to the moment, and for a line that
        goes by real time.
        """
        for connection in self.connections:
            if getattr(connection.value, "real_time", False):
                reason = f"`{connection.name}` has a line on which both sides count real seconds"
                raise Refused(OUT_OF_LOCK_STEP(reason=reason))
        self._to(self.begins)

    def reach(self, moment: float) -> float:
        """Comes back when all that happens until a moment has happened; never late."""
        self._settle()
        self._to(self.begins + moment)
        return 0.0

    def _to(self, moment: float) -> None:
        for cell in self.cells:
            try:
                cell.advance(moment)
            except TimeoutError as error:
                raise self._given_up(str(error)) from None
        self._settle()

    def _settle(self) -> None:
        """Until nothing is on its way, so that it is the same at each run."""
        end = time.monotonic() + self.patience
        for connection in self.connections:
            one: Any = connection.value
            if not hasattr(one, "settled"):
                continue
            while not one.settled(lambda one=one: self._executing(one)):
                if time.monotonic() > end:
                    raise self._given_up(f"what `{connection.name}` was sent does not arrive")
                time.sleep(LOOK)

    def _given_up(self, reason: str) -> Refused:
        """The end of the run. Time passes again, or no stop that is sent now would be answered."""
        for cell in self.cells:
            cell.free()
        return Refused(OUT_OF_LOCK_STEP(reason=reason))

    def _executing(self, one: Any) -> bool:
        """True if the controller of this connection has a running statement."""
        port = getattr(getattr(one, "session", None), "address", None)
        return any(cell.executing for cell in self.cells if cell.port == getattr(port, "port", 0))

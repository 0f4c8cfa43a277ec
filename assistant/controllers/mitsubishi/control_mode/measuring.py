"""The status of data link control mode by itself: a measurement that goes on all the time.

The program MEASURE runs in slot 2, whatever the controller does in slot 1 meanwhile.
"""

from __future__ import annotations

from types import TracebackType
from typing import Final, Self

from assistant.base.diagnostics import Refused
from assistant.controllers.controller import Controller
from assistant.controllers.mitsubishi.control_mode import programs
from assistant.controllers.mitsubishi.control_mode.status import STOPPING_TIMEOUT, Streaming
from assistant.controllers.mitsubishi.data_link import DataLink
from assistant.controllers.mitsubishi.helpers import BorrowedState

MEASURING_SLOT: Final = "2"


class Measuring(Streaming):
    """A context manager: entering starts the program and the stream, leaving ends both.

    controller: is connected; the program is installed and started through it, and deleted
    afterwards if it was not there. None: it runs there already, in a slot that always runs. line:
    what leads to COM2 of the program. silence: seconds without a status that are an error. replace:
    another program of its name on the controller.
    """

    def __init__(
        self,
        controller: Controller | None,
        line: str | DataLink,
        *,
        silence: float = 2.0,
        timeout: float = 10.0,
        replace: bool = False,
    ) -> None:
        super().__init__(line, silence, timeout)
        self._controller, self._replace = controller, replace
        self._before: BorrowedState | None = None

    def __enter__(self) -> Self:
        self._anew()
        self._stream.link.prepare()
        try:
            if self._controller is not None:
                self._before = BorrowedState.of(self._controller, (programs.MEASURING_PROGRAM,))
                programs.install_programs(
                    self._controller, (programs.MEASURING_PROGRAM,), replace=self._replace
                )
                self._controller.load(programs.MEASURING_PROGRAM, task=MEASURING_SLOT)
                self._controller.start(MEASURING_SLOT)
            self._stream.link.open()
            self._stream.start()
            self._stream.first()
        except BaseException:
            self._end(failed=True)
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._end(failed=error is not None)

    def _end(self, *, failed: bool) -> None:
        """End the stream, restore the controller. A program that gets no stop ends within 2 s."""
        try:
            self._stream.stop(STOPPING_TIMEOUT, again=True)
        finally:
            self._stream.close()
        if self._before is not None:
            before, self._before = self._before, None
            try:
                before.put_back()
            except Refused:
                if not failed:
                    raise

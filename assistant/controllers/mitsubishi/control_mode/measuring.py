"""The status of data link control mode by itself: a measurement that goes on all the time.

The program MEASURE runs in slot 2, whatever the controller does in slot 1 meanwhile.
"""

from __future__ import annotations

from typing import Final, Self

from assistant.controllers.controller import Controller
from assistant.controllers.mitsubishi.control_mode import programs
from assistant.controllers.mitsubishi.control_mode.status import STOPPING, Streaming
from assistant.controllers.mitsubishi.data_link import DataLink

TASK: Final = "2"


class Measuring(Streaming):
    """A context manager: entering starts the program and the stream, leaving ends both.

    controller: is connected; the program is installed and started through it. None: it runs there
    already, in a slot that always runs. line: what leads to COM2 of the program. silence: seconds
    without a status that are an error. replace: another program of its name on the controller.
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

    def __enter__(self) -> Self:
        self._anew()
        self._stream.link.prepare()
        if self._controller is not None:
            programs.install(self._controller, (programs.MEASURE,), replace=self._replace)
            self._controller.load(programs.MEASURE, task=TASK)
            self._controller.start(TASK)
        try:
            self._stream.link.open()
            self._stream.start()
            self._stream.first()
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(self, *error: object) -> None:
        self._end()

    def _end(self) -> None:
        """A program that is not told so ends by itself within 2 s."""
        try:
            self._stream.stop(STOPPING, again=True)
        finally:
            self._stream.close()

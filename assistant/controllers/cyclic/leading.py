"""An arm that is led by corrections, worked out while it moves.

    with Leading(link, endpoint, axes, limits) as leading:
        here = leading.joints()
        leading.to(row, seconds)

The loop is that of all cyclic control, in its process: it keeps the limits in each cycle whatever
it is told, and the arm comes to rest when no correction follows, when this program ends, and when
the context does.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from contextlib import suppress
from types import TracebackType
from typing import Final, Self

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers.cyclic import rules
from assistant.controllers.cyclic.link import Endpoint, Link
from assistant.controllers.cyclic.process import GRACE, Ended, Feed, Progress, follow_corrections
from assistant.controllers.cyclic.report import Report, Timing
from assistant.controllers.cyclic.settings import Settings
from assistant.controllers.cyclic.space import Limits

SILENCE: Final = 1.0
"""Seconds without a word of the process after which it is not known where the arm is."""


class Leading:
    """A context manager: entering waits for the controller, leaving brings the arm to rest.

    width: how many joints. limits: of joints, with their range. report: what came of it, None
    before. Raises Refused, on entering and by all methods, for what ended it.
    """

    def __init__(
        self,
        link: Link,
        endpoint: Endpoint,
        width: int,
        limits: Limits,
        settings: Settings | None = None,
    ) -> None:
        self._settings = settings or Settings()
        self._given = (link, endpoint, width, limits)
        self._feed, self._stop = Feed(), threading.Event()
        self._news = threading.Condition()
        self._latest: Progress | None = None
        self._ended: Refused | None = None
        self._over = False
        self.report: Report | None = None
        self._thread = threading.Thread(target=self._run, name="leading", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        try:
            self._wait(self._settings.first + GRACE)
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        before = self._ended
        self._end()
        if error is None and before is None and self._ended is not None:
            raise self._ended

    def joints(self) -> tuple[float, ...]:
        """Where the arm is, as the controller told some milliseconds ago."""
        self._wait(SILENCE)
        assert self._latest is not None
        return self._latest.values

    def timing(self) -> Timing:
        """How the loop has kept its time by now."""
        return Timing() if self._latest is None else self._latest.timing

    def to(self, row: Sequence[float], seconds: float) -> None:
        """Has the arm be at a row in so many seconds, as the limits let it, and go no further."""
        if self._ended is not None:
            raise self._ended
        self._feed.put(row, seconds)

    @property
    def findings(self) -> tuple[Diagnostic, ...]:
        return () if self.report is None else self.report.findings

    def _wait(self, seconds: float) -> None:
        """Until it is known where the arm is."""
        with self._news:
            self._news.wait_for(lambda: self._over or self._latest is not None, seconds)
        if self._ended is not None:
            raise self._ended
        if self._latest is None:
            raise Refused(rules.BROKEN(reason="its process says nothing"), exit_status=2)

    def _end(self) -> None:
        self._stop.set()
        with suppress(RuntimeError):  # it was not started
            self._thread.join()

    def _run(self) -> None:
        link, endpoint, width, limits = self._given
        try:
            self.report = follow_corrections(
                *(link, endpoint, width, limits, self._feed, self._settings),
                watch=self._told,
                stop=self._stop,
            )
        except Ended as ended:
            self.report = ended.report
            asked = self._stop.is_set() and ended.findings[0].code == rules.INTERRUPTED.code
            self._ended = None if asked else ended
        except Refused as refused:
            self._ended = refused
        finally:
            with self._news:
                self._over = True
                self._news.notify_all()

    def _told(self, progress: Progress) -> None:
        with self._news:
            self._latest = progress
            self._news.notify_all()

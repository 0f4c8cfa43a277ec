"""Cyclic motion run in a separate process, which this one cannot delay.

`follow` leads an arm along a trajectory. `Leading` leads it by corrections that are computed
meanwhile:

    with Leading(link, endpoint, axes, limits) as leading:
        here = leading.joints()
        leading.to(row, seconds)

The loop in the process keeps the limits in each cycle whatever it receives. The arm comes to rest
when no correction follows, when this program ends, and when the context ends.
"""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, is_dataclass
from pathlib import Path as FilePath
from types import TracebackType
from typing import IO, Final, Self

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.worker_processes import ended_by, without_passwords
from assistant.controllers.cyclic import rules
from assistant.controllers.cyclic.loop import Delays, Endpoint, Link, Report, Timing
from assistant.controllers.cyclic.setpoint_source import Settings, correction_line
from assistant.controllers.cyclic.trajectory import Limits, Trajectory, resampled

_PATIENCE: Final = 20.0
"""Seconds of silence beyond its time-outs after which the process receives a stop."""
_GRACE: Final = 30.0
"""Seconds more after which it is killed; it ends earlier than that whatever the controller does."""
_BEAT: Final = 0.2
"""Seconds from sign to sign that this process lives; see `Settings.alive`."""
LOOK: Final = 0.05
"""Seconds from look to look whether to stop."""


@dataclass(frozen=True, slots=True)
class Progress:
    """Progress of a trajectory. seconds: since the first packet. row: of the rows at the cycle,
    below 0 in the soft start. values: position of the arm. timing: of the loop so far.
    """

    seconds: float
    row: float
    rows: int
    values: tuple[float, ...]
    timing: Timing


class Ended(Refused):
    """A trajectory that was not followed to its end; `report` is what came of it until then."""

    exit_status = 2

    def __init__(self, finding: Diagnostic, report: Report | None) -> None:
        super().__init__(finding)
        self.report = report


def follow(
    link: Link,
    endpoint: Endpoint,
    trajectory: Trajectory,
    limits: Limits,
    settings: Settings | None = None,
    *,
    watch: Callable[[Progress], None] | None = None,
    stop: threading.Event | None = None,
) -> Report:
    """Guide the arm along a trajectory; return when it is at rest at its end.

    watch: receives the position of the arm about ten times a second. stop: brings the arm to rest
    when set, as Ctrl-C does. Raises Refused before anything is sent, Ended afterwards.
    """
    settings = settings or Settings()
    speeds, rises = limits.columns(trajectory.kind, trajectory.rows.shape[1])
    rows = resampled(trajectory, limits, link.cycle)
    described = {
        **_described(link, endpoint, settings),
        "kind": trajectory.kind,
        "speeds": speeds.tolist(),
        "rises": rises.tolist(),
        "corrected": False,
        "lowest": (),
        "highest": (),
    }
    return _led(described, rows, settings, link.cycle, watch, stop, None)


def _follow_corrections(
    link: Link,
    endpoint: Endpoint,
    width: int,
    limits: Limits,
    feed: _Feed,
    settings: Settings | None = None,
    *,
    watch: Callable[[Progress], None] | None = None,
    stop: threading.Event | None = None,
) -> Report:
    """Leads joints (width) by what a feed gives, until `stop` is set, which ends it as CN715.

    limits: with the range of the joints. Else as `follow`.
    """
    settings = settings or Settings()
    speeds, rises = limits.columns("joints", width)
    if limits.lowest is None or limits.highest is None:
        raise Refused(rules.BAD_LIMITS(reason="the range of the joints is missing"), exit_status=2)
    described = {
        **_described(link, endpoint, settings),
        "kind": "joints",
        "speeds": speeds.tolist(),
        "rises": rises.tolist(),
        "corrected": True,
        "lowest": limits.lowest,
        "highest": limits.highest,
    }
    return _led(described, np.zeros((0, width)), settings, link.cycle, watch, stop, feed)


class _Feed:
    """Corrections on their way to the process of a loop; `put` may be called at any time."""

    def __init__(self) -> None:
        self._guard = threading.Lock()
        self._into: IO[str] | None = None

    def put(self, row: Sequence[float], seconds: float) -> None:
        """Has the arm be at a row in so many seconds; nothing happens when nobody listens."""
        with self._guard, suppress(OSError):
            if self._into is not None:
                os.write(self._into.fileno(), correction_line(row, seconds))

    def leads_to(self, stdin: IO[str] | None) -> None:
        """The process that takes them, None for none any more."""
        with self._guard:
            # Under the lock: `put` must not write to a pipe that is being closed.
            self._into = stdin


def _described(link: Link, endpoint: Endpoint, settings: Settings) -> dict[str, object]:
    return {
        "link": [type(link).__module__, type(link).__qualname__],
        "fields": asdict(link) if is_dataclass(link) and not isinstance(link, type) else {},
        "endpoint": asdict(endpoint),
        "settings": asdict(settings),
    }


def _led(
    described: Mapping[str, object],
    rows: Floats,
    settings: Settings,
    cycle: float,
    watch: Callable[[Progress], None] | None,
    stop: threading.Event | None,
    feed: _Feed | None,
) -> Report:
    """Run a job in its process and return its report; raises Ended."""
    with tempfile.TemporaryDirectory(prefix="robot-assistant-", ignore_cleanup_errors=True) as name:
        folder = FilePath(name)
        np.save(folder / "rows.npy", rows)
        (folder / "job.json").write_text(json.dumps(described), encoding="utf-8")
        patience = settings.first + settings.timeout + _PATIENCE
        said, why = _run(folder, patience, watch, stop, len(rows), feed)
        if "done" not in said:
            rule = rules.ERRORS.get(str(said.get("code")), rules.BROKEN)
            fields = said.get("fields") or {"reason": why}
            assert isinstance(fields, Mapping)
            raise Ended(rule(**fields), None)
        with np.load(folder / "samples.npz", allow_pickle=False) as saved:
            count = len(rows) if feed is None else said["done"]
            assert isinstance(count, int)
            report = _report(said, saved["table"], saved["delays"], count, cycle)
    if said["code"]:
        fields = said["fields"]
        assert isinstance(fields, Mapping)
        raise Ended(rules.ERRORS[str(said["code"])](**fields), report)
    return report


def _run(
    folder: FilePath,
    patience: float,
    watch: Callable[[Progress], None] | None,
    stop: threading.Event | None,
    rows: int,
    feed: _Feed | None,
) -> tuple[dict[str, object], str]:
    """Return the last report of the process, and the reason of its death for an empty report."""
    # -P: nothing is imported from the working folder, which may be anybody's.
    command = [sys.executable, "-P", "-m", "assistant.controllers.cyclic.worker", str(folder)]
    # -P keeps the working folder out; the worker finds this package by the paths of this process.
    environment = {**without_passwords(), "PYTHONPATH": os.pathsep.join(map(str, sys.path))}
    with (folder / "errors.txt").open("w+", encoding="utf-8", errors="replace") as errors:
        worker = subprocess.Popen(  # noqa: S603
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
            env=environment,
            # Ctrl-C goes to the complete session of a terminal:
            # the worker has to bring the arm to rest first.
            start_new_session=True,
        )
        assert worker.stdin is not None
        assert worker.stdout is not None
        # A thread reads: a pipe cannot be waited for with a limit on every system.
        lines: queue.Queue[str | None] = queue.Queue()
        reader = threading.Thread(target=_read, args=(worker.stdout, lines), daemon=True)
        reader.start()
        quiet = threading.Event()
        beating = threading.Thread(target=_beat, args=(worker.stdin, quiet), daemon=True)
        beating.start()
        if feed is not None:
            feed.leads_to(worker.stdin)
        last: dict[str, object] = {}
        until, asked = time.monotonic() + patience, False
        try:
            while True:
                try:
                    line = lines.get(timeout=LOOK)
                    if line is None:
                        break
                    last = json.loads(line)
                    # The grace after a request is not lengthened by further reports.
                    until = until if asked else time.monotonic() + patience
                    if watch is not None and "row" in last:
                        watch(_progress(last, rows))
                except queue.Empty:
                    pass
                except KeyboardInterrupt:
                    # The worker brings the arm to rest on its
                    # path; this process must wait for that.
                    until = 0.0
                over = time.monotonic() > until
                if over and asked:
                    break
                if over or (stop is not None and stop.is_set() and not asked):
                    asked, until = True, time.monotonic() + _GRACE
                    _silence(worker, quiet, beating, feed)
        finally:
            _silence(worker, quiet, beating, feed)
            _close(worker)
            reader.join(_GRACE)
            worker.stdout.close()
        errors.seek(0)
        why = errors.read().strip().splitlines()
    how = ended_by(worker.returncode)
    return last, why[-1] if why else f"its process ended without a word: {how}"


def _beat(stdin: IO[str], quiet: threading.Event) -> None:
    """Tells the process that this one lives, until that is over or nobody listens."""
    with suppress(OSError):
        while not quiet.wait(_BEAT):
            os.write(stdin.fileno(), b"\n")


def _silence(
    worker: subprocess.Popen[str],
    quiet: threading.Event,
    beating: threading.Thread,
    feed: _Feed | None,
) -> None:
    """Ends stdin of the process."""
    assert worker.stdin is not None
    if feed is not None:
        # No more corrections before stdin ends: writing to it would raise, or reach another file.
        feed.leads_to(None)
    quiet.set()
    # The thread may be writing to this very file.
    beating.join()
    worker.stdin.close()


def _close(worker: subprocess.Popen[str]) -> None:
    """Wait for the process, which ends after its stdin; kill it otherwise."""
    try:
        worker.wait(_GRACE)
    except subprocess.TimeoutExpired:
        worker.kill()
        worker.wait()


def _read(lines: object, into: queue.Queue[str | None]) -> None:
    assert hasattr(lines, "__iter__")
    for line in lines:
        into.put(line)
    into.put(None)


def _progress(said: Mapping[str, object], rows: int) -> Progress:
    seconds, row, values = said["seconds"], said["row"], said["values"]
    timing = said["timing"]
    assert isinstance(seconds, float)
    assert isinstance(row, float | int)
    assert isinstance(values, list)
    assert isinstance(timing, list)
    return Progress(seconds, float(row), rows, tuple(values), Timing(*timing))


def _report(
    said: Mapping[str, object], table: Floats, delays: Floats, rows: int, cycle: float
) -> Report:
    named = said["columns"]
    assert isinstance(named, list)
    columns = {str(name): table[:, i] for i, name in enumerate(named)}
    time_ = columns["time"]
    columns["time"] = time_ - time_[:1] if len(time_) else time_
    counts = {}
    for name in ("done", "asked_again", "repeated", "garbled", "missed"):
        value = said[name]
        assert isinstance(value, int)
        counts[name] = value
    return Report(
        rows=rows,
        seconds=float(columns["time"][-1]) if len(time_) else 0.0,
        cycle=cycle,
        delays=Delays.of(delays, cycle, str(said["measured"])),
        priority=str(said["priority"]),
        refused=str(said["refused"]),
        columns=columns,
        **counts,
    )


_SILENCE: Final = 1.0
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
        self._feed, self._stop = _Feed(), threading.Event()
        self._news = threading.Condition()
        self._latest: Progress | None = None
        self._heard = 0.0
        self._ended: Refused | None = None
        self._over = False
        self.report: Report | None = None
        self._thread = threading.Thread(target=self._run, name="leading", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        try:
            self._wait(self._settings.first + _GRACE)
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
        # A method has raised an earlier end already; only a new one is raised here.
        before = self._ended
        self._end()
        if error is None and before is None and self._ended is not None:
            raise self._ended

    def joints(self) -> tuple[float, ...]:
        """Return the position of the arm, which the controller reported some milliseconds ago.

        Raises Refused if the last report is older than `Settings.timeout` and none follows.
        """
        self._wait(_SILENCE)
        assert self._latest is not None
        return self._latest.values

    def timing(self) -> Timing:
        """Return the timing of the loop so far."""
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
            known = self._news.wait_for(lambda: self._over or self._is_current(), seconds)
        if self._ended is not None:
            raise self._ended
        if not known or self._latest is None:
            raise Refused(rules.BROKEN(reason="its process says nothing"), exit_status=2)

    def _is_current(self) -> bool:
        """True if the last position is no older than a silence that the loop itself allows."""
        # A process that hangs neither reports nor ends: its last position says nothing of now.
        age = time.monotonic() - self._heard
        return self._latest is not None and age <= self._settings.timeout

    def _end(self) -> None:
        self._stop.set()
        with suppress(RuntimeError):  # it was not started
            self._thread.join()

    def _run(self) -> None:
        link, endpoint, width, limits = self._given
        try:
            self.report = _follow_corrections(
                *(link, endpoint, width, limits, self._feed, self._settings),
                watch=self._told,
                stop=self._stop,
            )
        except Ended as ended:
            self.report = ended.report
            # Leaving the context asks for the stop: that end is no failure.
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
            self._latest, self._heard = progress, time.monotonic()
            self._news.notify_all()

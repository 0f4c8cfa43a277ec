"""A run in columns: what happened, how the arm moved, and what the signals were meanwhile."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping, Sequence

import numpy as np

from assistant.base.arrays import Floats
from assistant.virtual.events import Logged, Run, Switched
from assistant.virtual.kernel import Motion
from assistant.virtual.kernel.script import InputChange
from assistant.virtual.telling import event_words, log_rows

TraceColumns = Mapping[str, np.ndarray]


def event_columns(run: Run, given: Sequence[InputChange]) -> TraceColumns:
    """The log in columns, one row an event.

    event_time: seconds. event_task, event_file, event_line (0 where it has none), event_what: as
    people read it. signal, signal_value: of a change of an output or input, empty and NaN for
    other events. seconds, ended, message: of the run.
    """
    told = list(log_rows(run.log, given))
    changes = [_event_change(row) for row in told]
    places = [row.place if isinstance(row, Logged) and row.place else ("", 0) for row in told]
    tasks = [row.task if isinstance(row, Logged) else "" for row in told]
    what = [event_words(row.what if isinstance(row, Logged) else row) for row in told]
    return {
        "event_time": np.array([row.time for row in told], dtype=np.float64),
        "event_task": np.array(tasks, dtype=np.str_),
        "event_file": np.array([path for path, _ in places], dtype=np.str_),
        "event_line": np.array([line for _, line in places], dtype=np.int64),
        "event_what": np.array(what, dtype=np.str_),
        "signal": np.array([name for name, _ in changes], dtype=np.str_),
        "signal_value": np.array([value for _, value in changes], dtype=np.float64),
        "seconds": np.array(run.seconds),
        "ended": np.array(run.ended),
        "message": np.array(run.message),
    }


def motion_columns(
    run: Run, given: Sequence[InputChange], motion: Motion, period: float | None = None
) -> TraceColumns:
    """Samples of the arm and the signals from the start to the end; none if motions take no time.

    t: (k,) seconds. position: (k, 3) mm and quaternion: (k, 4) of the tool in the base. joints:
    (k, a) degrees by axes. speed: (k,) mm/s of the tool. outputs: (k, s) by output_names, inputs:
    (k, i) by input_names, each 0 before it was set. period: seconds between samples.
    """
    from assistant.virtual.motion import Timed, track_of
    from assistant.virtual.motion.track import PERIOD

    if not isinstance(motion, Timed):
        return {}
    track = track_of(motion, run.log, run.seconds, period or PERIOD)
    names = tuple(dict.fromkeys(one.name for one in given))
    inputs = _signal_steps([(one.time, names.index(one.name), one.value) for one in given], track.t)
    return {
        "t": track.t,
        "position": track.position,
        "quaternion": track.quaternion,
        "joints": track.joints,
        "axes": np.array(motion.robot.axes, dtype=np.str_),
        "speed": track.speed,
        "outputs": track.signals,
        "output_names": np.array(track.names, dtype=np.str_),
        "inputs": inputs[:, : len(names)],
        "input_names": np.array(names, dtype=np.str_),
    }


def npz(columns: TraceColumns) -> bytes:
    """The columns as a file of NumPy; the same columns give the same bytes."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, column in columns.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                np.lib.format.write_array(file, column, allow_pickle=False)
    return data.getvalue()


def _signal_steps(changes: Sequence[tuple[float, int, float]], t: Floats) -> Floats:
    """(k, n) what each of n signals is at each time, by their changes in order."""
    found = np.zeros((len(t), 1 + max((column for _, column, _ in changes), default=-1)))
    for time, column, value in changes:
        found[np.searchsorted(t, time - 1e-9) :, column] = value
    return found


def _event_change(row: Logged | InputChange) -> tuple[str, float]:
    if isinstance(row, InputChange):
        return row.name, row.value
    if isinstance(row.what, Switched):
        return row.what.signal, row.what.value
    return "", float("nan")

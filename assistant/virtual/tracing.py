"""A run in columns, as a file of NumPy: what happened, and how signals changed."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np

from assistant.virtual.events import Logged, Run, Switched
from assistant.virtual.kernel.script import Given
from assistant.virtual.telling import rows, said


def trace_npz(run: Run, given: Sequence[Given]) -> bytes:
    """The log in columns, one row an event.

    event_time: seconds. event_task, event_file, event_line (0 where it has none), event_what: as
    people read it. signal, signal_value: of a change of an output or input, empty and NaN for
    other events. seconds, ended, message: of the run.
    """
    told = list(rows(run.log, given))
    changes = [_change(row) for row in told]
    places = [row.place if isinstance(row, Logged) and row.place else ("", 0) for row in told]
    tasks = [row.task if isinstance(row, Logged) else "" for row in told]
    what = [said(row.what if isinstance(row, Logged) else row) for row in told]
    data = io.BytesIO()
    np.savez_compressed(
        data,
        event_time=np.array([row.time for row in told], dtype=np.float64),
        event_task=np.array(tasks, dtype=np.str_),
        event_file=np.array([path for path, _ in places], dtype=np.str_),
        event_line=np.array([line for _, line in places], dtype=np.int64),
        event_what=np.array(what, dtype=np.str_),
        signal=np.array([name for name, _ in changes], dtype=np.str_),
        signal_value=np.array([value for _, value in changes], dtype=np.float64),
        seconds=np.float64(run.seconds),
        ended=np.str_(run.ended),
        message=np.str_(run.message),
    )
    return data.getvalue()


def _change(row: Logged | Given) -> tuple[str, float]:
    if isinstance(row, Given):
        return row.name, row.value
    if isinstance(row.what, Switched):
        return row.what.signal, row.what.value
    return "", float("nan")

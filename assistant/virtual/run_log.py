"""The log of a run: as lines for people, as JSON records for programs, and in NumPy columns.

Columns hold the events, one row each, and samples of the arm and the signals over time: seconds,
mm, degrees, unit quaternions (w, x, y, z).
"""

from __future__ import annotations

import io
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from pathlib import PurePath
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule, error, info
from assistant.base.source_text import SourceText, visible
from assistant.program.geometry import Pose
from assistant.virtual.events import (
    Event,
    Logged,
    Moved,
    OnWay,
    Place,
    Run,
    Said,
    Stopped,
    Switched,
    Waited,
)
from assistant.virtual.kernel import Motion
from assistant.virtual.kernel.script import InputChange

_FAILED: Final = error(
    "VC211",
    "the controller stops here: {message}",
    "correct the statement or the data that it uses, or connect the line that it opens (--line "
    "COM1=10003), and run it again",
)
UNKNOWN: Final = error(
    "VC212",
    "this is not simulated: {message}",
    "give the files of what it calls as well if they are missing, else write it another way, or "
    "run what comes before it: --until",
)
_WAITING: Final = error(
    "VC213",
    "the program stands here, and nothing lets it go on: {message}",
    "set the inputs that it waits for in a script: --signals FILE, see docs/running.md",
)
STEPS: Final = error(
    "VC214",
    "the run is broken off after {message}",
    "see whether the loop around it ends; --max-steps allows more",
)
TIME: Final = error(
    "VC215",
    "the run is broken off after {message}",
    "see whether what it waits for comes; --max-time allows more, --until ends a run earlier",
)
NOTED: Final = info("VC216", "{what}", "")
_ENDINGS: Final[dict[str, Rule]] = {
    "error": _FAILED,
    "unknown": UNKNOWN,
    "stopped": _WAITING,
    "steps": STEPS,
    "time": TIME,
}
"""Rules of failed runs, by the reason of their end."""
_KINDS: Final = {"joint": "joint move", "linear": "line", "circular": "arc"}


def event_words(event: object) -> str:
    """An event in a few words, as people read it."""
    match event:
        case Moved():
            return _motion_words(event)
        case Switched(signal, value, at):
            return f"{signal} = {value:g}{_trigger_words(at)}"
        case InputChange(name=name, value=value):
            return f"input {name} = {value:g}"
        case Waited(seconds):
            return f"waits {seconds:g} s"
        case Said(text):
            return f'says "{visible(text)}"'
        case Stopped(end):
            return "ends for good" if end else "stops until it is started again"
    return visible(str(getattr(event, "text", event)))


def _motion_words(moved: Moved) -> str:
    """Return the text of a motion: its target in the base, speed and corner."""
    if moved.flange is not None:
        place = _number_row((moved.flange @ moved.tool).position)
    else:
        place = f"joints {_number_row(moved.joints or ())}"
    pace = [f"{moved.speed:g} mm/s"] if moved.speed is not None else []
    pace += [f"{moved.percent:g} %"] if moved.percent is not None else []
    corner = [f"corner {moved.blend:g} mm"] if moved.blend > 0.0 else []
    return ", ".join([f"{_KINDS[moved.kind]} to {place}", *pace, *corner])


def _number_row(values: Sequence[float]) -> str:
    return "(" + ", ".join(f"{value + 0.0:.2f}" for value in values) + ")"


def _trigger_words(at: OnWay | None) -> str:
    if at is None:
        return ""
    where = {
        "start": f"{at.amount:g} mm behind the start",
        "end": f"{at.amount:g} mm before the end",
        "time": f"{at.amount:g} s before the end",
        "share": f"at {at.amount:g} %",
    }[at.measure]
    ahead = f", {at.ahead:g} s ahead" if at.ahead else ""
    return f", on the way {where}{ahead}"


# -------------------------------------------------------------------------------------- table


@dataclass(frozen=True, slots=True)
class ColumnWidths:
    """Widths of the log's columns. task, place: characters; a task of 0 is left out."""

    task: int
    place: int

    @staticmethod
    def of(tasks: Sequence[str], sources: Sequence[SourceText]) -> ColumnWidths:
        """Wide enough for each place in the texts."""
        places = [
            f"{PurePath(source.path or '').name}:{source.text.count(chr(10)) + 1}"
            for source in sources
        ]
        widest = max(map(len, places), default=0)
        return ColumnWidths(max(map(len, tasks), default=0) if len(tasks) > 1 else 0, widest)

    def line(self, time: float, task: str, place: Place | None, what: object) -> str:
        """A row: seconds, the task if there are several, the place, what happened."""
        named = f"{task:<{self.task}}  " if self.task else ""
        return f"{time:>10.3f}  {named}{short_place(place):<{self.place}}  {event_words(what)}"


def short_place(place: Place | None) -> str:
    """A file's name without its folder, and the line."""
    return "" if place is None else f"{PurePath(place[0]).name}:{place[1]}"


def log_rows(
    log: Sequence[Logged], given: Sequence[InputChange], first: int = 0
) -> Iterator[Logged | InputChange]:
    """Events and changes of inputs, in their order.

    first: number of the row that the log begins with.
    """
    left = deque(given)
    for number, row in enumerate(log, first):
        # An input that changed before an event is listed before it.
        while left and left[0].row <= number:
            yield left.popleft()
        yield row
    yield from left


def summary(run: Run) -> str:
    """Moves, signals, statements and seconds of a run in a line."""
    moves = sum(isinstance(event, Moved) for event in run.events)
    changes = sum(isinstance(event, Switched) for event in run.events)
    counts = (
        _count_words(moves, "motion"),
        _count_words(changes, "output set", plural="outputs set"),
        _count_words(run.steps, "statement"),
    )
    return ", ".join((f"{run.seconds:.2f} s", *counts))


def _count_words(number: int, what: str, plural: str = "") -> str:
    return f"{number} {what if number == 1 else plural or what + 's'}"


# ------------------------------------------------------------------------------------ findings


def end_finding(run: Run, sources: Sequence[SourceText]) -> Diagnostic | None:
    """Why a run did not come to a good end, at its place; None if it did."""
    rule = _ENDINGS.get(run.ended)
    if rule is None:
        return None
    message = run.message
    if run.place is not None:
        # The message begins with the place, which the finding shows by itself.
        message = message.removeprefix(f"{run.place[0]}:{run.place[1]}: ")
    message = message.strip().rstrip(".") or "nothing tells why"
    return _finding_at(rule, run.place, sources, message=message)


def _finding_at(
    rule: Rule, place: Place | None, sources: Sequence[SourceText], **fields: Any
) -> Diagnostic:
    """A finding at a line of one of the texts."""
    if place is None:
        return rule(**fields)
    path, line = place
    source = next((one for one in sources if (one.path or "") == path), None)
    excerpt = None if source is None else source.line_text(line)
    return rule(path=path or None, line=line, excerpt=excerpt, **fields)


# ------------------------------------------------------------------------------------- records


def json_record(row: Logged | InputChange) -> dict[str, Any]:
    """A row of the log as JSON has it: mm, degrees, seconds, unit quaternions (w, x, y, z)."""
    if isinstance(row, InputChange):
        return {"time": row.time, "event": "input", "signal": row.name, "value": row.value}
    path, line = row.place or (None, None)
    head = {"time": row.time, "task": row.task, "file": path, "line": line}
    return {**head, **_json_event(row.what)}


def _json_event(event: Event) -> dict[str, Any]:
    match event:
        case Moved():
            return {
                "event": "motion",
                "kind": event.kind,
                "flange": _json_pose(event.flange),
                "tool": _json_pose(event.tool),
                "via": _json_pose(event.via),
                "joints": None if event.joints is None else list(event.joints),
                "speed": event.speed,
                "percent": event.percent,
                "blend": _finite_or_none(event.blend),
            }
        case Switched(signal, value, at):
            way = at and {"measure": at.measure, "amount": at.amount, "ahead": at.ahead}
            return {"event": "output", "signal": signal, "value": value, "on_way": way}
        case Waited(seconds):
            return {"event": "wait", "seconds": seconds}
        case Said(text):
            return {"event": "text", "text": text}
        case Stopped(end):
            return {"event": "stop", "end": end}
    return {"event": "note", "text": event_words(event)}


def _json_pose(pose: Pose | None) -> dict[str, Any] | None:
    if pose is None:
        return None
    return {"position": list(pose.position), "quaternion": list(pose.quaternion)}


def _finite_or_none(value: float) -> float | None:
    """JSON has no infinity: None for a corner whose size the controller takes."""
    return value if abs(value) < float("inf") else None


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
    from assistant.virtual.kernel.timed_arm import PERIOD, Timed, track_of

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
    np.savez_compressed(data, **columns)  # type: ignore[arg-type]
    return data.getvalue()


def _signal_steps(changes: Sequence[tuple[float, int, float]], t: Floats) -> Floats:
    """(k, n) what each of n signals is at each time, by their changes in order."""
    found = np.zeros((len(t), 1 + max((column for _, column, _ in changes), default=-1)))
    for time, column, value in changes:
        # 1e-9 absorbs rounding: a change at the time of a sample belongs to it.
        found[np.searchsorted(t, time - 1e-9) :, column] = value
    return found


def _event_change(row: Logged | InputChange) -> tuple[str, float]:
    if isinstance(row, InputChange):
        return row.name, row.value
    if isinstance(row.what, Switched):
        return row.what.signal, row.what.value
    return "", float("nan")

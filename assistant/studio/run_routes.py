"""Routes of a run: start, steps, break points, inputs, its log and motion, and comparison.

Two files are compared as `compare` does, and the motions of both are shown. A deviation is the
largest distance of the two tool paths, in mm and degrees, seen from either.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path as FilePath
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from assistant.base import rotations
from assistant.base.arrays import Floats, evenly_spaced, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.compiler.comparison import Comparison, compare
from assistant.compiler.motion_proof import Proving
from assistant.robots import Robot
from assistant.studio import rules
from assistant.studio.route_answers import Question, changes, finding_records, looks, view_page
from assistant.studio.runs import RunRequest, WatchedInputs
from assistant.studio.studio import Studio
from assistant.virtual.events import Moved, Run
from assistant.virtual.kernel import Ending, Task
from assistant.virtual.kernel.script import follow
from assistant.virtual.program_run import Settings, prepared
from assistant.virtual.run_log import end_finding, motion_columns

if TYPE_CHECKING:
    from assistant.studio.runs import StudioRun
    from assistant.virtual.debugging.break_points import Stride


def _likely_arm(studio: Studio, path: str) -> str | None:
    """The robot of the recipe that makes a program or of the target it was built for, else of the
    first target; by its name, or by a file as the page names it. None where nothing tells.
    """
    from assistant.project import project_of

    try:
        project = project_of(studio.folder)
    except Refused:
        return None  # what is wrong with it stands beside its file
    file = studio.place(path)
    recipes = [(place, one) for place in project.places for one in place.recipes]
    own = [one.robot or place.controller.robot for place, one in recipes if one.source == file]
    folders = set(PurePosixPath(path).parts[:-1])
    built = [place.controller.robot for place in project.places if place.name in folders]
    first = [one.robot or place.controller.robot for place, one in recipes]
    return next((name for name in (*own, *built, *first) if name), None)


_MOST_POINTS: Final = 2_000
"""Most points of each curve that the page draws."""
_MOST_COMPARED: Final = 20_000
"""Most points of each path that is compared."""
_TURN_WEIGHT: Final = 100.0
"""mm that a place counts as farther off whose tool is turned right round: where a tool turns on the
spot, or comes by again, the place is meant at which it is turned alike."""
_BLOCK_SIZE: Final = 256
"""Places whose distances from all of the other path are worked out at once."""

_MotionColumns = Mapping[str, np.ndarray]
"""Columns from `motion_columns`; empty if motions take no time."""


def _shown_motion(
    columns: _MotionColumns, robot: Robot | None, most: int = _MOST_POINTS
) -> dict[str, Any]:
    """Columns of a run as lists: samples evenly picked, the first and the last among them.

    t: seconds. position: mm, rows of x, y, z; quaternion: (w, x, y, z); orientation: degrees about
    z, y, x, each without jumps; joints: degrees, rows by `axes`; chain: the same as the scene poses
    the arm; speed: mm/s; inputs and outputs:
    rows by their names. samples: how many there are in all.
    """
    if "t" not in columns or robot is None:
        return {"samples": 0, "t": []}
    count = len(columns["t"])
    some = evenly_spaced(count, max(2, most))
    picked = ("t", "position", "quaternion", "joints", "speed", "inputs", "outputs")
    names = ("axes", "input_names", "output_names")
    angles = np.unwrap(rotations.to_euler(columns["quaternion"]), period=360.0, axis=0)
    return {
        "samples": count,
        **{name: columns[name][some].tolist() for name in picked},
        **{name: columns[name].tolist() for name in names},
        "orientation": angles[some].tolist(),
        "chain": robot.chained(columns["joints"][some]).tolist(),
    }


@dataclass(frozen=True, slots=True)
class _Deviation:
    """The place of one path that is farthest from the other path.

    distance: mm. angle: degrees, the most that the tool is turned otherwise at the place that is
    nearest. time: seconds on the path of the run that the place is on. of: 0 or 1, that run.
    """

    distance: float
    angle: float
    time: float
    of: int


def _path_deviation(
    first: _MotionColumns, second: _MotionColumns, begins: tuple[Floats, Floats]
) -> _Deviation | None:
    """Return the largest distance between two tools' paths, from either one; None without both.

    begins: seconds at which the motions of each begin. If both have the same number, a position is
    compared with those of the same motion only. Times do not matter: a slower program alone has no
    deviation.
    """
    if "t" not in first or "t" not in second:
        return None
    one, two = _moving_samples(first), _moving_samples(second)
    if len(begins[0]) != len(begins[1]):
        begins = np.zeros(1), np.zeros(1)
    found = []
    for of, (here, there) in enumerate(((one, two), (two, one))):
        distance, angle = _deviation_by_motion(here, there, begins[of], begins[1 - of])
        at = int(np.argmax(distance))
        found.append(_Deviation(float(distance[at]), float(angle.max()), float(here["t"][at]), of))
    worst = max(found, key=lambda each: each.distance)
    return _Deviation(worst.distance, max(each.angle for each in found), worst.time, worst.of)


def _deviation_by_motion(
    here: Mapping[str, Floats], there: Mapping[str, Floats], begin: Floats, other: Floats
) -> tuple[Floats, Floats]:
    """(k,) mm and degrees of each place of a path from the same motion of the other one."""
    ours = np.append(np.searchsorted(here["t"], begin), len(here["t"]))
    ours[0] = 0
    low = np.maximum(np.searchsorted(there["t"], other, side="right") - 1, 0)
    high = np.append(np.searchsorted(there["t"], other[1:]) + 1, len(there["t"]))
    low[0] = 0
    distance, angle = np.zeros(len(here["t"])), np.zeros(len(here["t"]))
    for k in range(len(begin)):
        rows, window = slice(ours[k], ours[k + 1]), slice(low[k], max(high[k], low[k] + 1))
        if ours[k] < ours[k + 1]:
            pair = ({n: c[s] for n, c in p.items()} for p, s in ((here, rows), (there, window)))
            distance[rows], angle[rows] = _distance_to_lines(*pair)
    return distance, angle


def _moving_samples(columns: _MotionColumns) -> dict[str, Floats]:
    """Samples at which the tool went on, not too many of them."""
    position, quaternion = columns["position"], columns["quaternion"]
    gone = norms(np.diff(position, axis=0)) > 0.0
    turned = np.any(np.diff(quaternion, axis=0) != 0.0, axis=1)
    kept = np.flatnonzero(np.append(True, gone | turned))
    step = -(-len(kept) // _MOST_COMPARED)
    kept = np.unique(np.append(kept[::step], kept[-1]))
    return {"t": columns["t"][kept], "position": position[kept], "quaternion": quaternion[kept]}


def _distance_to_lines(
    here: Mapping[str, Floats], there: Mapping[str, Floats]
) -> tuple[Floats, Floats]:
    """(k,) mm and degrees of each place of a path from the lines about the nearest of another.

    Places are near each other by where they are and how they are turned, see TURNED.
    """
    points, path = here["position"], there["position"]
    squares = np.einsum("ij,ij->i", path, path)
    nearest = np.empty(len(points), dtype=np.intp)
    for begin in range(0, len(points), _BLOCK_SIZE):
        rows = slice(begin, begin + _BLOCK_SIZE)
        cosine = np.abs(here["quaternion"][rows] @ there["quaternion"].T)
        unlike = squares - 2.0 * points[rows] @ path.T - 2.0 * _TURN_WEIGHT**2 * cosine
        nearest[rows] = np.argmin(unlike, axis=1)
    place, turn = path[nearest], there["quaternion"][nearest]
    best = _pose_distance(points, here["quaternion"], place, turn)
    for side in (-1, 1):
        other = np.clip(nearest + side, 0, len(path) - 1)
        way = path[other] - path[nearest]
        first, last = there["quaternion"][nearest], there["quaternion"][other]
        step = _same_side(last, first) - first
        along = np.sum((points - path[nearest]) * way, axis=1)
        along += _TURN_WEIGHT**2 * np.sum(
            (_same_side(here["quaternion"], first) - first) * step, axis=1
        )
        length = np.sum(way * way, axis=1) + _TURN_WEIGHT**2 * np.sum(step * step, axis=1)
        part = np.clip(along / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
        at, turned = path[nearest] + part[:, None] * way, rotations.between(first, last, part)
        off = _pose_distance(points, here["quaternion"], at, turned)
        nearer = (off < best)[:, None]
        place, turn = np.where(nearer, at, place), np.where(nearer, turned, turn)
        best = np.minimum(best, off)
    return norms(points - place), rotations.angle_between(here["quaternion"], turn)


def _pose_distance(points: Floats, turns: Floats, places: Floats, others: Floats) -> Floats:
    """(k,) mm squared by which poses are unlike."""
    turned = _same_side(turns, others) - others
    return np.asarray(
        np.sum((points - places) ** 2, axis=1) + _TURN_WEIGHT**2 * np.sum(turned**2, axis=1)
    )


def _same_side(quaternions: Floats, others: Floats) -> Floats:
    """(k, 4) the same rotations, each on the side of another one."""
    return np.where(np.sum(quaternions * others, axis=1) < 0.0, -1.0, 1.0)[:, None] * quaternions


_LONGEST_RUN: Final = 60.0
"""Longest run of each program here, in seconds, as the user cannot switch the signals that it waits
for.
"""


def _compare_files(first: RunRequest, second: RunRequest, script: str) -> Comparison:
    """Compare two files of the project as `compare` does. script: drives both; empty for none.

    Raises Unreadable or Refused where they cannot be compared at all.
    """
    return compare(
        first.path,
        second.path,
        robot=second.robot,
        from_robot=first.robot,
        proving=Proving(script=FilePath(script) if script else None),
    )


def _compared_motions(first: RunRequest, second: RunRequest) -> dict[str, Any]:
    """Both motions in columns, and the greatest deviation of their paths. Raises Refused where a
    program cannot be run.
    """
    pair = (first, second)
    done = [_run_program(one) for one in pair]
    runs = [run for run, _, _ in done]
    far = _path_deviation(done[0][1], done[1][1], (_start_times(runs[0]), _start_times(runs[1])))
    found = [finding for _, _, one in done for finding in one]
    return {
        "names": [first.programs.title, second.programs.title],
        "seconds": [run.seconds for run in runs],
        "motions": [
            _shown_motion(made[1], one.robot) for made, one in zip(done, pair, strict=True)
        ],
        "deviation": None if far is None else {
            "distance": far.distance, "angle": far.angle, "time": far.time, "of": far.of,
        },
        "findings": finding_records(found),
    }  # fmt: skip


def _run_program(wanted: RunRequest) -> tuple[Run, _MotionColumns, Sequence[Diagnostic]]:
    """A run, how the arm moved, and what is wrong with it."""
    settings = Settings(
        robot=wanted.robot,
        inputs=WatchedInputs({one.name: 0.0 for one in wanted.script.changes}),
        options=wanted.script.options,
    )
    kernel = prepared(wanted.programs, settings)
    given = follow(kernel, wanted.script, wanted.programs.sources())
    end = time.monotonic() + _LONGEST_RUN

    def watch(task: Task) -> None:
        if time.monotonic() > end:
            kernel.halt(task, Ending("time", f"more than {_LONGEST_RUN:g} s of this computer"))

    kernel.watch = watch
    run = kernel.run()
    wrong = end_finding(run, wanted.programs.sources())
    columns = motion_columns(run, given, kernel.motion)
    return run, columns, [] if wrong is None else [wrong]


def _start_times(run: Run) -> Floats:
    """(k,) seconds."""
    return np.array([row.time for row in run.log if isinstance(row.what, Moved)])


RUN_NAME: Final = "run"
"""Name of the run in the live table."""
_MOST_LOG_ROWS: Final = 1_000
"""Most rows of the log in one answer."""
_SCRIPT_SUFFIX: Final = ".signals.toml"
_STEP_STRIDES: Final[Mapping[str, Stride]] = {"step": "in", "over": "over", "out": "out"}
_NO_RUN_RECORD: Final = {"state": "", "inputs": [], "outputs": [], "stack": [], "data": []}


def _run_choices(studio: Studio, asked: Question) -> dict[str, Any]:
    """Robots to choose from, the one that a program most likely is for, and its signal scripts."""
    from assistant import robots
    from assistant.studio.studio import file_stamps

    path = asked.text("path", "")
    return {
        "robots": sorted(robots.names()),
        "robot": _likely_arm(studio, path) if path else None,
        "scripts": sorted(
            name for name in file_stamps(studio.folder) if name.endswith(_SCRIPT_SUFFIX)
        ),
    }


def start_run(studio: Studio, asked: Question) -> dict[str, Any]:
    """Runs a program from its beginning, in place of whatever ran before."""
    from assistant.studio.runs import StudioRun

    with studio.beginning:
        studio.drop(RUN_NAME)
        wanted = _run_request(studio, asked, asked.text("path"))
        points = {name: _line_numbers(lines) for name, lines in asked.table("points").items()}
        made = StudioRun(wanted, points, studio.windows.tell)
        studio.live[RUN_NAME] = (
            made  # before it tells anybody of its end, who then asks for its log
        )
        try:
            made.start()
        except BaseException:
            studio.live.pop(RUN_NAME, None)
            raise
        if not studio.windows.writes(asked.window):  # it has gone meanwhile
            studio.drop(RUN_NAME)
    return dict(made.now())


def _run_request(studio: Studio, asked: Question, path: str) -> RunRequest:
    """Return the requested run; raise Unreadable or Refused for programs that cannot be read or
    run.
    """
    from assistant.compiler.arms import known_robot, robot_of
    from assistant.compiler.simulated_run import programs, read_script
    from assistant.studio.runs import RunRequest
    from assistant.virtual.kernel.script import Script

    studio.file(path)
    named, script = asked.text("robot", ""), asked.text("script", "")
    if script:
        studio.file(script)
    arm = robot_of(named or None)
    found = programs([path], robot=arm)
    if arm is None and found.program is not None:
        arm = known_robot(found.program.robot)
    return RunRequest(
        found,
        arm,
        read_script(script) if script else Script(),
        path=path,
        real_time=asked.truth("real_time"),
        at_once=asked.truth("at_once"),
    )


def _line_numbers(given: object) -> list[int]:
    lines = given if isinstance(given, list) else []
    return [line for line in lines if isinstance(line, int)]


def _run_record(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    """Return the present state of the run."""
    run = studio.live.get(RUN_NAME)
    return dict(_NO_RUN_RECORD) if run is None else dict(_running_or_refused(studio).now())


def run_log(studio: Studio, asked: Question) -> dict[str, Any]:
    """Return the log: rows from a number on."""
    first = max(0, int(asked.number("first", 0)))
    rows = _running_or_refused(studio).log
    return {"first": first, "rows": rows[first : first + _MOST_LOG_ROWS], "logged": len(rows)}


def _continue_run(studio: Studio, asked: Question) -> dict[str, Any]:
    """Continue a run that is held: to the next hold, or by a step."""
    run, how = _running_or_refused(studio), asked.text("how", "on")
    run.go_on(_STEP_STRIDES.get(how))
    return dict(run.now())


def _pause_run(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    _running_or_refused(studio).pause()
    return {}


def _end_run(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    """Ends the run; what it did can be looked at until the next one."""
    run = _running_or_refused(studio)
    run.end()
    return dict(run.now())


def _set_points(studio: Studio, asked: Question) -> dict[str, Any]:
    """The break points of a file while it runs."""
    path, lines = asked.text("path"), _line_numbers(asked.values.get("lines"))
    run = studio.live.get(RUN_NAME)
    if run is not None:
        lines = _running_or_refused(studio).set_points(path, lines)
    return {"lines": lines}


def _set_signal(studio: Studio, asked: Question) -> dict[str, Any]:
    """Switches an input by hand."""
    run = _running_or_refused(studio)
    run.switch(asked.text("name").strip().lower(), asked.number("value"))
    return dict(run.now())


def _answer_question(studio: Studio, asked: Question) -> dict[str, Any]:
    """Answers what the program asks a person."""
    run = _running_or_refused(studio)
    run.answer(asked.text("text"))
    return dict(run.now())


def _run_motion(studio: Studio, asked: Question) -> dict[str, Any]:
    """Return the motion of the arm so far, in columns; see `_shown_motion`."""
    from assistant.virtual.kernel import Kernel
    from assistant.virtual.run_log import motion_columns

    run = _running_or_refused(studio)

    def columns(kernel: Kernel) -> Mapping[str, Any]:
        kernel.catch_up()
        return motion_columns(run.told(), run.given, kernel.motion)

    return _shown_motion(
        run.ask(columns), run.wanted.robot, int(asked.number("points", _MOST_POINTS))
    )


def _compare_programs(studio: Studio, asked: Question) -> dict[str, Any]:
    """Tells whether two programs do the same, and how far their motions are apart."""
    studio.comparison = None
    first, second = (_run_request(studio, asked, asked.text(key)) for key in ("first", "second"))
    shown = _compared_motions(first, second)
    try:
        done = _compare_files(first, second, asked.text("script", ""))
    except Refused as refused:
        answer, line, found = "not compared", "", list(refused.findings)
    else:
        answer, line, found = done.answer, done.line(), done.located_findings()
        studio.comparison = done
    both = [*finding_records(found), *shown["findings"]]
    return {**shown, "answer": answer, "line": line, "findings": both}


async def _comparison_page(request: Request) -> Response:
    """The page of the programs that were compared last."""
    studio: Studio = request.app.state.studio
    done = studio.comparison
    return await view_page(request, None if done is None else partial(_comparison_record, done))


def _comparison_record(done: Comparison) -> dict[str, Any]:
    from assistant.view.page import page_record
    from assistant.view.sheets import compared_sheet, shown_sheet

    return page_record(shown_sheet(compared_sheet(done)))


def _running_or_refused(studio: Studio) -> StudioRun:
    from assistant.studio.runs import StudioRun

    run = studio.live.get(RUN_NAME)
    if not isinstance(run, StudioRun):
        raise Refused(rules.NO_RUN())
    return run


_RUN_ACTIONS: Final[Mapping[str, Callable[[Studio, Question], object]]] = {
    "start": start_run,
    "go": _continue_run,
    "pause": _pause_run,
    "end": _end_run,
    "points": _set_points,
    "signal": _set_signal,
    "answer": _answer_question,
    "compare": _compare_programs,
}
RUN_ROUTES: Final = (
    looks("/run", _run_record),
    looks("/run/choices", _run_choices),
    looks("/run/log", run_log),
    looks("/run/motion", _run_motion),
    *(changes(f"/run/{name}", does) for name, does in _RUN_ACTIONS.items()),
    Route("/run/compared", _comparison_page),
)

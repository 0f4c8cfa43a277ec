"""Running a program: start, break points, steps, inputs by hand, what it did, and comparing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from assistant.base.diagnostics import Refused
from assistant.studio import rules
from assistant.studio.answering import Question, changes, finding_records, looks, view_page
from assistant.studio.studio import Studio

if TYPE_CHECKING:
    from assistant.compiler.comparison import Comparison
    from assistant.studio.running import RunRequest, StudioRun
    from assistant.virtual.debugging.break_points import Stride

RUN_NAME: Final = "run"
"""What it is called among what is live."""
MOST_LOG_ROWS: Final = 1_000
"""Of the log that are told at once."""
SCRIPT_SUFFIX: Final = ".signals.toml"
STEP_STRIDES: Final[Mapping[str, Stride]] = {"step": "in", "over": "over", "out": "out"}
NO_RUN_RECORD: Final = {"state": "", "inputs": [], "outputs": [], "stack": [], "data": []}


def run_choices(studio: Studio, asked: Question) -> dict[str, Any]:
    """Robots to choose from, the one that a program most likely is for, and its signal scripts."""
    from assistant import robots
    from assistant.studio.arms import likely_arm
    from assistant.studio.tree import file_stamps

    path = asked.text("path", "")
    return {
        "robots": sorted(robots.names()),
        "robot": likely_arm(studio, path) if path else None,
        "scripts": sorted(
            name for name in file_stamps(studio.folder) if name.endswith(SCRIPT_SUFFIX)
        ),
    }


def start_run(studio: Studio, asked: Question) -> dict[str, Any]:
    """Runs a program from its beginning, in place of whatever ran before."""
    from assistant.studio.running import StudioRun

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
    """What was asked to run; raises Unreadable or Refused for what cannot be read or run."""
    from assistant.compiler.arms import known_robot, robot_of
    from assistant.compiler.simulated_run import programs, read_script
    from assistant.studio.running import RunRequest
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


def run_record(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    """How the run stands."""
    run = studio.live.get(RUN_NAME)
    return dict(NO_RUN_RECORD) if run is None else dict(_running_or_refused(studio).now())


def run_log(studio: Studio, asked: Question) -> dict[str, Any]:
    """What happened: rows from a number on."""
    first = max(0, int(asked.number("first", 0)))
    rows = _running_or_refused(studio).log
    return {"first": first, "rows": rows[first : first + MOST_LOG_ROWS], "logged": len(rows)}


def continue_run(studio: Studio, asked: Question) -> dict[str, Any]:
    """How a run that is held goes on: to what holds it next, or by a step."""
    run, how = _running_or_refused(studio), asked.text("how", "on")
    run.go_on(STEP_STRIDES.get(how))
    return dict(run.now())


def pause_run(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    _running_or_refused(studio).pause()
    return {}


def end_run(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    """Ends the run; what it did can be looked at until the next one."""
    run = _running_or_refused(studio)
    run.end()
    return dict(run.now())


def set_points(studio: Studio, asked: Question) -> dict[str, Any]:
    """The break points of a file while it runs."""
    path, lines = asked.text("path"), _line_numbers(asked.values.get("lines"))
    run = studio.live.get(RUN_NAME)
    if run is not None:
        lines = _running_or_refused(studio).set_points(path, lines)
    return {"lines": lines}


def set_signal(studio: Studio, asked: Question) -> dict[str, Any]:
    """Switches an input by hand."""
    run = _running_or_refused(studio)
    run.switch(asked.text("name").strip().lower(), asked.number("value"))
    return dict(run.now())


def answer_question(studio: Studio, asked: Question) -> dict[str, Any]:
    """Answers what the program asks a person."""
    run = _running_or_refused(studio)
    run.answer(asked.text("text"))
    return dict(run.now())


def run_motion(studio: Studio, asked: Question) -> dict[str, Any]:
    """How the arm moved until now, in columns; see `motions.shown`."""
    from assistant.studio.motions import MOST_POINTS, shown_motion
    from assistant.virtual.kernel import Kernel
    from assistant.virtual.run_log import motion_columns

    run = _running_or_refused(studio)

    def columns(kernel: Kernel) -> Mapping[str, Any]:
        kernel.catch_up()
        return motion_columns(run.told(), run.given, kernel.motion)

    return shown_motion(
        run.ask(columns), run.wanted.robot, int(asked.number("points", MOST_POINTS))
    )


def compare_programs(studio: Studio, asked: Question) -> dict[str, Any]:
    """Tells whether two programs do the same, and how far their motions are apart."""
    from assistant.studio.comparing import compare_files, compared_motions

    studio.comparison = None
    first, second = (_run_request(studio, asked, asked.text(key)) for key in ("first", "second"))
    shown = compared_motions(first, second)
    try:
        done = compare_files(first, second, asked.text("script", ""))
    except Refused as refused:
        answer, line, found = "not compared", "", list(refused.findings)
    else:
        answer, line, found = done.answer, done.line(), done.located_findings()
        studio.comparison = done
    both = [*finding_records(found), *shown["findings"]]
    return {**shown, "answer": answer, "line": line, "findings": both}


async def comparison_page(request: Request) -> Response:
    """The page of the programs that were compared last."""
    studio: Studio = request.app.state.studio
    done = studio.comparison
    return await view_page(request, None if done is None else partial(_comparison_record, done))


def _comparison_record(done: Comparison) -> dict[str, Any]:
    from assistant.view.record import page_record
    from assistant.view.sheets import compared_sheet, shown_sheet

    return page_record(shown_sheet(compared_sheet(done)))


def _running_or_refused(studio: Studio) -> StudioRun:
    from assistant.studio.running import StudioRun

    run = studio.live.get(RUN_NAME)
    if not isinstance(run, StudioRun):
        raise Refused(rules.NO_RUN())
    return run


RUN_ACTIONS: Final[Mapping[str, Callable[[Studio, Question], object]]] = {
    "start": start_run,
    "go": continue_run,
    "pause": pause_run,
    "end": end_run,
    "points": set_points,
    "signal": set_signal,
    "answer": answer_question,
    "compare": compare_programs,
}
RUN_ROUTES: Final = (
    looks("/run", run_record),
    looks("/run/choices", run_choices),
    looks("/run/log", run_log),
    looks("/run/motion", run_motion),
    *(changes(f"/run/{name}", does) for name, does in RUN_ACTIONS.items()),
    Route("/run/compared", comparison_page),
)

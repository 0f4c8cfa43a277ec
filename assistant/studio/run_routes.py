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
from assistant.studio.answering import Asked, changes, findings, looks, view_page
from assistant.studio.studio import Studio

if TYPE_CHECKING:
    from assistant.compiler.comparison import Comparison
    from assistant.studio.running import Running, Wanted
    from assistant.virtual.debugging.break_points import Stride

RUN: Final = "run"
"""What it is called among what is live."""
MOST_ROWS: Final = 1_000
"""Of the log that are told at once."""
SCRIPT: Final = ".signals.toml"
STRIDES: Final[Mapping[str, Stride]] = {"step": "in", "over": "over", "out": "out"}
NOTHING: Final = {"state": "", "inputs": [], "outputs": [], "stack": [], "data": []}


def choices(studio: Studio, asked: Asked) -> dict[str, Any]:
    """Robots to choose from, the one that a program most likely is for, and its signal scripts."""
    from assistant import robots
    from assistant.studio.arms import likely_arm
    from assistant.studio.tree import stamps

    path = asked.text("path", "")
    return {
        "robots": sorted(robots.names()),
        "robot": likely_arm(studio, path) if path else None,
        "scripts": sorted(name for name in stamps(studio.folder) if name.endswith(SCRIPT)),
    }


def start(studio: Studio, asked: Asked) -> dict[str, Any]:
    """Runs a program from its beginning, in place of whatever ran before."""
    from assistant.studio.running import Running

    with studio.beginning:
        studio.drop(RUN)
        wanted = _wanted(studio, asked, asked.text("path"))
        points = {name: _lines(lines) for name, lines in asked.table("points").items()}
        made = Running(wanted, points, studio.windows.tell)
        studio.live[RUN] = made  # before it tells anybody of its end, who then asks for its log
        try:
            made.start()
        except BaseException:
            studio.live.pop(RUN, None)
            raise
        if not studio.windows.writes(asked.window):  # it has gone meanwhile
            studio.drop(RUN)
    return dict(made.now())


def _wanted(studio: Studio, asked: Asked, path: str) -> Wanted:
    """What was asked to run; raises Unreadable or Refused for what cannot be read or run."""
    from assistant.compiler.arms import known_robot, robot_of
    from assistant.compiler.simulated_run import programs, read_script
    from assistant.studio.running import Wanted
    from assistant.virtual.kernel.script import Script

    studio.file(path)
    named, script = asked.text("robot", ""), asked.text("script", "")
    if script:
        studio.file(script)
    arm = robot_of(named or None)
    found = programs([path], robot=arm)
    if arm is None and found.program is not None:
        arm = known_robot(found.program.robot)
    return Wanted(
        found,
        arm,
        read_script(script) if script else Script(),
        path=path,
        real_time=asked.truth("real_time"),
        at_once=asked.truth("at_once"),
    )


def _lines(given: object) -> list[int]:
    lines = given if isinstance(given, list) else []
    return [line for line in lines if isinstance(line, int)]


def now(studio: Studio, asked: Asked) -> dict[str, Any]:  # noqa: ARG001
    """How the run stands."""
    run = studio.live.get(RUN)
    return dict(NOTHING) if run is None else dict(_running(studio).now())


def log(studio: Studio, asked: Asked) -> dict[str, Any]:
    """What happened: rows from a number on."""
    first = max(0, int(asked.number("first", 0)))
    rows = _running(studio).log
    return {"first": first, "rows": rows[first : first + MOST_ROWS], "logged": len(rows)}


def go(studio: Studio, asked: Asked) -> dict[str, Any]:
    """How a run that is held goes on: to what holds it next, or by a step."""
    run, how = _running(studio), asked.text("how", "on")
    run.go_on(STRIDES.get(how))
    return dict(run.now())


def pause(studio: Studio, asked: Asked) -> dict[str, Any]:  # noqa: ARG001
    _running(studio).pause()
    return {}


def end(studio: Studio, asked: Asked) -> dict[str, Any]:  # noqa: ARG001
    """Ends the run; what it did can be looked at until the next one."""
    run = _running(studio)
    run.end()
    return dict(run.now())


def points(studio: Studio, asked: Asked) -> dict[str, Any]:
    """The break points of a file while it runs."""
    path, lines = asked.text("path"), _lines(asked.values.get("lines"))
    run = studio.live.get(RUN)
    if run is not None:
        lines = _running(studio).set_points(path, lines)
    return {"lines": lines}


def signal(studio: Studio, asked: Asked) -> dict[str, Any]:
    """Switches an input by hand."""
    run = _running(studio)
    run.switch(asked.text("name").strip().lower(), asked.number("value"))
    return dict(run.now())


def answer(studio: Studio, asked: Asked) -> dict[str, Any]:
    """Answers what the program asks a person."""
    run = _running(studio)
    run.answer(asked.text("text"))
    return dict(run.now())


def motion(studio: Studio, asked: Asked) -> dict[str, Any]:
    """How the arm moved until now, in columns; see `motions.shown`."""
    from assistant.studio.motions import MOST_POINTS, shown
    from assistant.virtual.kernel import Kernel
    from assistant.virtual.run_log import motion_columns

    run = _running(studio)

    def columns(kernel: Kernel) -> Mapping[str, Any]:
        kernel.catch_up()
        return motion_columns(run.told(), run.given, kernel.motion)

    return shown(run.ask(columns), run.wanted.robot, int(asked.number("points", MOST_POINTS)))


def compare(studio: Studio, asked: Asked) -> dict[str, Any]:
    """Tells whether two programs do the same, and how far their motions are apart."""
    from assistant.studio.comparing import compare_files, motions

    studio.comparison = None
    first, second = (_wanted(studio, asked, asked.text(key)) for key in ("first", "second"))
    shown = motions(first, second)
    try:
        done = compare_files(first, second, asked.text("script", ""))
    except Refused as refused:
        answer, line, found = "not compared", "", list(refused.findings)
    else:
        answer, line, found = done.answer, done.line(), done.located_findings()
        studio.comparison = done
    both = [*findings(found), *shown["findings"]]
    return {**shown, "answer": answer, "line": line, "findings": both}


async def side_by_side(request: Request) -> Response:
    """The page of the programs that were compared last."""
    studio: Studio = request.app.state.studio
    done = studio.comparison
    return await view_page(request, None if done is None else partial(_beside, done))


def _beside(done: Comparison) -> dict[str, Any]:
    from assistant.view.record import record
    from assistant.view.sheets import compared_sheet, shown_sheet

    return record(shown_sheet(compared_sheet(done)))


def _running(studio: Studio) -> Running:
    from assistant.studio.running import Running

    run = studio.live.get(RUN)
    if not isinstance(run, Running):
        raise Refused(rules.NO_RUN())
    return run


DOES: Final[Mapping[str, Callable[[Studio, Asked], object]]] = {
    "start": start,
    "go": go,
    "pause": pause,
    "end": end,
    "points": points,
    "signal": signal,
    "answer": answer,
    "compare": compare,
}
ROUTES: Final = (
    looks("/run", now),
    looks("/run/choices", choices),
    looks("/run/log", log),
    looks("/run/motion", motion),
    *(changes(f"/run/{name}", does) for name, does in DOES.items()),
    Route("/run/compared", side_by_side),
)

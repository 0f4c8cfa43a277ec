"""`follow`: an arm led along a trajectory, from where it stands to where that ends."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error
from assistant.cli.cells import record, robot_of_cell
from assistant.cli.confirming import confirm
from assistant.cli.moving import NO_SPEED, moving
from assistant.cli.presentation import Format, console, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.controllers.trajectory_execution import LinkOptions, Mode, Progress

NO_FOLLOW_MODE: Final = error("CL250", "no arm is led by `{by}`", "choose one of {known}")
FOLLOW_WITHOUT_ROBOT: Final = error(
    "CL251",
    "no project says which robot `{name}` moves, so a trajectory cannot be checked",
    "write robot = NAME into its table in assistant.toml",
)
NO_RECORDING: Final = error(
    "CL252", "a recording is not written as `{name}`", "end its name in .csv or .npz"
)
NO_PERIOD: Final = error("CL253", "--interval is {value:g}", "write seconds above 0")
TOO_MANY_LINES: Final = error(
    "CL254",
    "{count} lines are named, and data link control has two",
    "write --line for the control line, and --line for the status line",
)
MOST_LINES: Final = 2
RECORDING_SUFFIXES: Final = (".csv", ".npz")


@dataclass(frozen=True, slots=True)
class FollowOptions:
    """by: name of a mode. speed: percent of what the trajectory says. interval: seconds between
    points, None for what suits the mode. log: file of what was recorded.
    """

    by: str
    speed: float
    interval: float | None
    log: Path | None
    wishes: LinkOptions
    yes: bool
    format: Format


def run_follow(cell: str, trajectory: str, options: FollowOptions) -> int:
    """Checks the whole way, asks, and leads the arm along it."""
    from assistant.compiler.commanded_motion import trajectory_of_source
    from assistant.controllers import Controller

    mode = _follow_mode(options)
    with moving(cell, "follow") as motion:
        there = motion.cell
        robot = robot_of_cell(there.one)
        if robot is None:
            raise Refused(FOLLOW_WITHOUT_ROBOT(name=there.one.name), exit_status=2)
        session = there.controller if mode.operates else there.session
        mode.check(session, options.wishes)
        position = session.position() if isinstance(session, Controller) else None
        period = options.interval or mode.period
        led = trajectory_of_source(trajectory, robot, position, period, options.speed)
        print_findings(led.findings)
        way = f"{len(led.seconds)} points in {led.seconds[-1]:.1f} s, {mode.title}"
        confirm(there.one, f"leads the arm along {trajectory}: {way}", options.yes)
        motion.began = True
        try:
            with progress_bar(f"following {trajectory}", options.format) as progress:
                done = mode.run(session, led, options.wishes, progress)
        except Refused as refused:
            motion.began = not {finding.code for finding in refused.findings} <= mode.unbegun
            raise
    print_findings(done.findings)
    if options.log is not None:
        done.save(options.log)
    if options.format is Format.JSON:
        columns = {name: len(column) for name, column in done.columns.items()}
        answer = {"address": str(there.one.address), "followed": done.said, "recorded": columns}
        print_json(record(answer))
    else:
        say(f"{there.one.name}: followed {trajectory}: {done.said}")
        if options.log is not None:
            say(f"wrote {options.log}")
    return 0


def _follow_mode(options: FollowOptions) -> Mode:
    from assistant.controllers.recording import check_place
    from assistant.controllers.trajectory_execution import MODES

    if options.by not in MODES:
        raise Refused(NO_FOLLOW_MODE(by=options.by, known=", ".join(MODES)), exit_status=2)
    if not 0.0 < options.speed <= 100.0:
        raise Refused(NO_SPEED(value=options.speed), exit_status=2)
    if options.interval is not None and not options.interval > 0.0:
        raise Refused(NO_PERIOD(value=options.interval), exit_status=2)
    if options.log is not None and options.log.suffix.lower() not in RECORDING_SUFFIXES:
        raise Refused(NO_RECORDING(name=options.log), exit_status=2)
    if options.log is not None:
        check_place(options.log)
    if len(options.wishes.lines) > MOST_LINES:
        raise Refused(TOO_MANY_LINES(count=len(options.wishes.lines)), exit_status=2)
    return MODES[options.by]


@contextmanager
def progress_bar(what: str, format: Format) -> Iterator[Progress]:
    """A bar on the terminal, nothing elsewhere."""
    if format is Format.JSON or not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.progress import Progress as Bar

    with Bar(console=console(), transient=True) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda part: bar.update(task, completed=part)

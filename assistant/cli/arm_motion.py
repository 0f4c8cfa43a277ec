"""Move an arm: motors, jog, start, hand, and following a trajectory.

Each asks before, unless `--yes` is given, checks what it can beforehand, and stops the arm on
Ctrl-C or when it fails. `follow` checks the complete trajectory before the arm is moved.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Diagnostic, Refused, error, warning
from assistant.cli.controller_session import (
    Session,
    confirm,
    connected,
    joints_line,
    new_client,
    pose_line,
    record,
    robot_of_cell,
    state_lines,
)
from assistant.cli.presentation import Format, console, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.controllers import Controller, Named
    from assistant.controllers.arm_stop import Rest
    from assistant.controllers.states import Jog, State
    from assistant.controllers.trajectory_execution import LinkOptions, Mode, Progress


_BROKEN_OFF: Final = warning(
    "CL240", "broken off: the arm was stopped and stands at {where}", "look before it goes on"
)
_MAY_MOVE: Final = error(
    "CL241",
    "broken off, and it is not known whether the arm stands: {why}",
    "press the emergency stop, and look at the arm before anything else",
)
_BROKEN_OFF_BECAUSE: Final = warning(
    "CL245", "broken off: {what}", "look at the arm before it goes on"
)
NO_OVERRIDE: Final = error("CL242", "an override is 1 to 100 percent, not {value}", "write one")
NO_SPEED: Final = error(
    "CL243", "a speed is over 0 and up to 100 percent, not {value:g}", "write one"
)
_NO_JOG_DISTANCE: Final = error(
    "CL244", "{axis} by {by:g} is no motion", "write a number other than 0"
)
_LOOK_PERIOD: Final = 0.2
"""Seconds between two looks at a program that runs."""
START_TIME: Final = 0.5
"""Seconds in which a program that was started may not run yet."""


@dataclass(slots=True)
class Moving:
    """A controller whose arm may move. began: a request that moves it was made.

    caught: the exception that interrupted the motion.
    """

    cell: Session
    began: bool = False
    caught: BaseException | None = None

    def is_given_up(self, caught: BaseException) -> bool:
        """True for a second Ctrl-C, or the first one while an error was being handled."""
        return isinstance(caught, KeyboardInterrupt) and caught is not self.caught


@contextmanager
def moving(text: str, command: str) -> Iterator[Moving]:
    """A controller that is connected to, for a motion that ends well or with the arm at rest.

    Once it `began`, what breaks it off, Ctrl-C or an error, stops the arm and tells where it
    is. A second Ctrl-C gives up. What a controller refuses to begin has moved nothing, but is
    stopped all the same: a part of it may have begun before.
    """
    from assistant.base.termination import raise_on_termination
    from assistant.controllers import Controller
    from assistant.controllers.arm_stop import PATIENCE, brought_to_rest

    motion: Moving | None = None
    try:
        with raise_on_termination(), connected(text, command) as there:
            motion = Moving(there)
            with _stop_on_exit(motion):
                yield motion
    except BaseException as caught:
        if motion is None or not motion.began or _nothing_began(caught):
            raise
        one = motion.cell.one
        given_up = _MAY_MOVE(place=str(one.address), why="it was given up")
        if motion.is_given_up(caught):
            print_findings([given_up])
            raise
        notes = "; ".join(getattr(motion.caught, "__notes__", ()))
        if notes and not isinstance(motion.cell.session, Controller):
            print_findings([_BROKEN_OFF_BECAUSE(place=str(one.address), what=notes)])
            raise
        try:
            rest = brought_to_rest(lambda: new_client(one, timeout=PATIENCE))
        except KeyboardInterrupt:
            print_findings([given_up])
            raise
        print_findings([_broken_off_finding(one, rest)])
        raise


@contextmanager
def _stop_on_exit(motion: Moving) -> Iterator[None]:
    """Sends the stop on the session of the motion, before that is closed."""
    from assistant.controllers.arm_stop import stop_at_once

    try:
        yield
    except BaseException as caught:
        motion.caught = caught
        if motion.began and not _nothing_began(caught):
            sys.stdout.flush()
            if isinstance(caught, KeyboardInterrupt):
                console().print("stopping the arm; Ctrl-C again gives up")
            stop_at_once(motion.cell.session)
        raise


def _nothing_began(caught: BaseException) -> bool:
    """True if certainly no motion began, because this controller cannot do it at all."""
    from assistant.controllers import rules

    codes = {f.code for f in caught.findings} if isinstance(caught, Refused) else set()
    return codes == {rules.NOT_HERE.code}


def _broken_off_finding(one: Named, rest: Rest) -> Diagnostic:
    place = str(one.address)
    if rest.stands and rest.position is not None and rest.state is not None:
        first = next(iter(state_lines(rest.state)))
        return _BROKEN_OFF(place=place, where=f"{joints_line(rest.position)} ({first})")
    if rest.state is not None:
        return _MAY_MOVE(
            place=place, why="it was stopped, but " + next(iter(state_lines(rest.state)))
        )
    return _MAY_MOVE(place=place, why=rest.reason)


def run_motors(cell: str, on: bool, yes: bool, format: Format) -> int:
    with connected(cell, "motors") as there:
        controller = there.controller
        if on:
            confirm(there.one, "switches the motors on: the arm can move from then on", yes)
        controller.motors(on)
        state = controller.state()
    return _print_end_state(there, state, f"motors {'on' if on else 'off'}", format)


def run_jog(cell: str, jog: Jog, yes: bool, format: Format) -> int:
    """Moves one axis, if that stays within the limits of the arm, and tells where it is then."""
    from assistant.compiler.commanded_motion import check_jog

    if not 0.0 < jog.speed <= 100.0:
        raise Refused(NO_SPEED(value=jog.speed), exit_status=2)
    if jog.by == 0.0 or not abs(jog.by) < float("inf"):
        raise Refused(_NO_JOG_DISTANCE(axis=jog.axis, by=jog.by), exit_status=2)
    with moving(cell, "jog") as motion:
        there = motion.cell
        controller, robot = there.controller, robot_of_cell(there.one)
        print_findings(check_jog(jog, controller.position(), robot))
        unit = "mm" if jog.axis in ("X", "Y", "Z") else "degrees (mm of an axis that slides)"
        confirm(there.one, f"moves the arm: {jog.axis} by {jog.by:g} {unit}", yes)
        motion.began = True
        controller.jog(jog)
        position = controller.position()
    if format is Format.JSON:
        print_json({"address": str(there.one.address), "position": record(position)})
    else:
        say(joints_line(position))
        say(pose_line(position))
    return 0


def run_hand(cell: str, open: bool, number: int, yes: bool, format: Format) -> int:
    with connected(cell, "hand") as there:
        controller = there.controller
        does = "opens" if open else "closes"
        confirm(there.one, f"{does} hand {number}: what it holds may fall", yes)
        controller.hand(number, open=open)
    done = f"hand {number} {'open' if open else 'closed'}"
    if format is Format.JSON:
        print_json({"address": str(there.one.address), "hand": number, "open": open})
    else:
        say(f"{there.one.name}: {done}")
    return 0


def run_start(
    cell: str,
    program: str | None,
    task: str,
    *,
    forever: bool,
    wait: bool,
    override: int | None,
    yes: bool,
    format: Format,
) -> int:
    """Starts what is loaded, or a program, and waits for its end; 1 if it came to a fault."""
    from assistant.compiler.commanded_motion import check_position

    if override is not None and not 1 <= override <= 100:
        raise Refused(NO_OVERRIDE(value=override), exit_status=2)
    with moving(cell, "start") as motion:
        there = motion.cell
        controller = there.controller
        print_findings(check_position(controller.position(), robot_of_cell(there.one)))
        what = f"starts `{program}`" if program else "starts what is loaded"
        lasts = " again and again" if forever else ""
        confirm(there.one, f"{what}{lasts}: the arm moves as the program says", yes)
        if override is not None:
            controller.set_override(override)
        if program:
            controller.load(program, task)
        motion.began = True
        controller.start(task, forever=forever)
        state = _wait_for_end(controller, there, format) if wait else controller.state()
    _print_end_state(there, state, "the program has ended" if wait else "started", format)
    return 1 if state.faults or state.emergency else 0


def _wait_for_end(controller: Controller, there: Session, format: Format) -> State:
    shown = format is Format.TEXT
    if shown:
        say(f"{there.one.name}: started; Ctrl-C stops it")
        sys.stdout.flush()
    began = time.monotonic()
    while (state := controller.state()).running or time.monotonic() < began + START_TIME:
        time.sleep(_LOOK_PERIOD)
    return state


def _print_end_state(there: Session, state: State, done: str, format: Format) -> int:
    if format is Format.JSON:
        print_json({"address": str(there.one.address), "state": record(state)})
        return 0
    say(f"{there.one.name}: {done}")
    for line in state_lines(state):
        say(line)
    return 0


_NO_FOLLOW_MODE: Final = error("CL250", "no arm is led by `{by}`", "choose one of {known}")
_FOLLOW_WITHOUT_ROBOT: Final = error(
    "CL251",
    "no project says which robot `{name}` moves, so a trajectory cannot be checked",
    "write robot = NAME into its table in assistant.toml",
)
NO_RECORDING: Final = error(
    "CL252", "a recording is not written as `{name}`", "end its name in .csv or .npz"
)
_NO_PERIOD: Final = error("CL253", "--interval is {value:g}", "write seconds above 0")
_TOO_MANY_LINES: Final = error(
    "CL254",
    "{count} lines are named, and data link control has two",
    "write --line for the control line, and --line for the status line",
)
_MOST_LINES: Final = 2
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
            raise Refused(_FOLLOW_WITHOUT_ROBOT(name=there.one.name), exit_status=2)
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
        raise Refused(_NO_FOLLOW_MODE(by=options.by, known=", ".join(MODES)), exit_status=2)
    if not 0.0 < options.speed <= 100.0:
        raise Refused(NO_SPEED(value=options.speed), exit_status=2)
    if options.interval is not None and not options.interval > 0.0:
        raise Refused(_NO_PERIOD(value=options.interval), exit_status=2)
    if options.log is not None and options.log.suffix.lower() not in RECORDING_SUFFIXES:
        raise Refused(NO_RECORDING(name=options.log), exit_status=2)
    if options.log is not None:
        check_place(options.log)
    if len(options.wishes.lines) > _MOST_LINES:
        raise Refused(_TOO_MANY_LINES(count=len(options.wishes.lines)), exit_status=2)
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

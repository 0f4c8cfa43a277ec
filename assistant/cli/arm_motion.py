"""Move an arm: motors, jog, start, hand, and following a trajectory.

Each asks before, unless `--yes` is given, checks what it can beforehand, and stops the arm on
Ctrl-C or when it fails. `follow` checks the complete trajectory before the arm is moved.
"""

from __future__ import annotations

import enum
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error, warning
from assistant.cli.command import Option, argument, command, option, options
from assistant.cli.controller_session import (
    CellArgument,
    Session,
    YesOption,
    confirm,
    connected,
    joints_line,
    named_by,
    new_client,
    pose_line,
    print_state,
    print_there,
    robot_of_cell,
    state_lines,
)
from assistant.cli.options import FormatOption
from assistant.cli.presentation import Format, console, print_findings, say

if TYPE_CHECKING:
    from assistant.controllers import Controller, Named
    from assistant.controllers.arm_stop import Rest
    from assistant.controllers.states import State
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


class Switch(enum.StrEnum):
    ON = "on"
    OFF = "off"


class HandState(enum.StrEnum):
    OPEN = "open"
    CLOSE = "close"


class JogFrame(enum.StrEnum):
    BASE = "base"
    TOOL = "tool"


def follow_modes() -> Iterable[str]:
    from assistant.controllers.trajectory_execution import MODES

    return MODES


def servo_modes() -> Iterable[str]:
    from assistant.controllers.setpoint_streams import MODES

    return MODES


RecordingOption = Annotated[
    Path | None, Option("Write what was recorded.", metavar="FILE.csv|.npz")
]
LinesOption = Annotated[
    tuple[str, ...], Option("HOST:PORT or serial port of a line; repeatable, in order.", "--line")
]
ReplaceProgramsOption = Annotated[
    bool, Option("Our programs replace others of their names.", "--replace")
]


@options
class LinkedOptions:
    """The link by which an arm is led."""

    port: int | None = option("UDP port; default the usual one.", min=1, max=65535)
    lines: LinesOption
    cycle: float | None = option("Seconds of a cycle.", min=0.0005, max=1.0)
    replace: ReplaceProgramsOption

    @property
    def wishes(self) -> LinkOptions:
        from assistant.controllers.trajectory_execution import LinkOptions

        return LinkOptions(self.port, self.lines, self.cycle, self.replace)


def check_recording(log: Path | None) -> None:
    """Raise Refused for a file in which a recording cannot be written."""
    from assistant.controllers.recording import check_place

    if log is None:
        return
    if log.suffix.lower() not in RECORDING_SUFFIXES:
        raise Refused(NO_RECORDING(name=log), exit_status=2)
    check_place(log)


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
        if one.virtual is not None:  # its arm ends with the command
            raise
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


@command
class Motors:
    """Switch the motors of an arm on or off."""

    cell: CellArgument
    state: Switch = argument("What they shall be.")
    yes: YesOption
    format: FormatOption

    def run(self) -> int:
        on = self.state is Switch.ON
        with connected(self.cell, "motors") as there:
            controller = there.controller
            if on:
                confirm(
                    there.one, "switches the motors on: the arm can move from then on", self.yes
                )
            controller.motors(on)
            state = controller.state()
        done = f"motors {'on' if on else 'off'}"
        print_state(there, state, done, self.format)
        return 0


@command
class Jog:
    """Move one axis of an arm by hand. Asks before; Ctrl-C stops the arm."""

    cell: CellArgument
    axis: str = argument("J1 … J8, or X Y Z A B C of the frame.")
    by: float = argument("Degrees, or mm.")
    frame: JogFrame = option("Of X … C.", default=JogFrame.BASE)
    speed: float = option("Percent.", default=10.0)
    yes: YesOption
    format: FormatOption

    def run(self) -> int:
        """Move one axis if it stays within the limits of the arm, and print where it is then."""
        from assistant.compiler.commanded_motion import check_jog
        from assistant.controllers.states import Jog as Jogging

        frame: Literal["tool", "base"] = "tool" if self.frame is JogFrame.TOOL else "base"
        jog = Jogging(self.axis.upper(), self.by, frame, self.speed)
        if not 0.0 < jog.speed <= 100.0:
            raise Refused(NO_SPEED(value=jog.speed), exit_status=2)
        if jog.by == 0.0 or not abs(jog.by) < float("inf"):
            raise Refused(_NO_JOG_DISTANCE(axis=jog.axis, by=jog.by), exit_status=2)
        with moving(self.cell, "jog") as motion:
            there = motion.cell
            controller, robot = there.controller, robot_of_cell(there.one)
            print_findings(check_jog(jog, controller.position(), robot))
            unit = "mm" if jog.axis in ("X", "Y", "Z") else "degrees (mm of an axis that slides)"
            confirm(there.one, f"moves the arm: {jog.axis} by {jog.by:g} {unit}", self.yes)
            motion.began = True
            controller.jog(jog)
            position = controller.position()
        lines = (joints_line(position), pose_line(position))
        print_there(there, self.format, {"position": position}, lines)
        return 0


@command
class Hand:
    """Open or close a hand. Asks before."""

    cell: CellArgument
    state: HandState = argument("What it shall do.")
    number: int = option("Which one.", default=1, min=1)
    yes: YesOption
    format: FormatOption

    def run(self) -> int:
        opens = self.state is HandState.OPEN
        with connected(self.cell, "hand") as there:
            controller = there.controller
            does = "opens" if opens else "closes"
            confirm(there.one, f"{does} hand {self.number}: what it holds may fall", self.yes)
            controller.hand(self.number, open=opens)
        done = f"hand {self.number} {'open' if opens else 'closed'}"
        answer = {"hand": self.number, "open": opens}
        print_there(there, self.format, answer, (f"{there.one.name}: {done}",))
        return 0


@command
class Start:
    """Start a program on a controller. Asks before; Ctrl-C stops it."""

    cell: CellArgument
    program: str | None = argument("Program to load before; default what is loaded.", default=None)
    task: str = option("Task or slot; default the first.", default="")
    forever: bool = option("Again and again.")
    wait: bool = option(
        "Stay until it ends; Ctrl-C stops it then.", "--wait/--no-wait", default=True
    )
    override: int | None = option("Percent of the speed.")
    yes: YesOption
    format: FormatOption

    def run(self) -> int:
        """Starts what is loaded, or a program, and waits for its end; 1 if it came to a fault."""
        from assistant.compiler.commanded_motion import check_position

        if self.override is not None and not 1 <= self.override <= 100:
            raise Refused(NO_OVERRIDE(value=self.override), exit_status=2)
        with moving(self.cell, "start") as motion:
            there = motion.cell
            controller = there.controller
            print_findings(check_position(controller.position(), robot_of_cell(there.one)))
            what = f"starts `{self.program}`" if self.program else "starts what is loaded"
            lasts = " again and again" if self.forever else ""
            confirm(there.one, f"{what}{lasts}: the arm moves as the program says", self.yes)
            if self.override is not None:
                controller.set_override(self.override)
            if self.program:
                controller.load(self.program, self.task)
            motion.began = True
            controller.start(self.task, forever=self.forever)
            state = (
                _wait_for_end(controller, there, self.format) if self.wait else controller.state()
            )
        done = "the program has ended" if self.wait else "started"
        print_state(there, state, done, self.format)
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


@command
class Follow:
    """Lead an arm along a trajectory. Checks all of it and asks before; Ctrl-C stops the arm."""

    cell: CellArgument
    trajectory: str = argument("A table, an array, or a program that only moves.")
    by: str = option("Way to lead it.", choices=follow_modes)
    speed: float = option("Percent of what the trajectory says.", default=100.0)
    interval: float | None = option("Seconds between points; default what suits the way.")
    log: RecordingOption
    link: LinkedOptions
    yes: YesOption
    format: FormatOption

    def run(self) -> int:
        """Checks the whole way, asks, and leads the arm along it."""
        from assistant.compiler.commanded_motion import trajectory_of_source
        from assistant.controllers import Controller
        from assistant.controllers.controller import require_lasting

        mode, wishes = self._mode(), self.link.wishes
        require_lasting(named_by(self.cell))  # no program waits there to be led
        with moving(self.cell, "follow") as motion:
            there = motion.cell
            robot = robot_of_cell(there.one)
            if robot is None:
                raise Refused(_FOLLOW_WITHOUT_ROBOT(name=there.one.name), exit_status=2)
            session = there.controller if mode.operates else there.session
            mode.check(session, wishes)
            position = session.position() if isinstance(session, Controller) else None
            period = self.interval or mode.period
            led = trajectory_of_source(self.trajectory, robot, position, period, self.speed)
            print_findings(led.findings)
            way = f"{len(led.seconds)} points in {led.seconds[-1]:.1f} s, {mode.title}"
            confirm(there.one, f"leads the arm along {self.trajectory}: {way}", self.yes)
            motion.began = True
            try:
                with progress_bar(f"following {self.trajectory}", self.format) as progress:
                    done = mode.run(session, led, wishes, progress)
            except Refused as refused:
                motion.began = not {finding.code for finding in refused.findings} <= mode.unbegun
                raise
        print_findings(done.findings)
        if self.log is not None:
            done.save(self.log)
        columns = {name: len(column) for name, column in done.columns.items()}
        lines = [f"{there.one.name}: followed {self.trajectory}: {done.said}"]
        lines += [] if self.log is None else [f"wrote {self.log}"]
        print_there(there, self.format, {"followed": done.said, "recorded": columns}, lines)
        return 0

    def _mode(self) -> Mode:
        from assistant.controllers.trajectory_execution import MODES

        if self.by not in MODES:
            raise Refused(_NO_FOLLOW_MODE(by=self.by, known=", ".join(MODES)), exit_status=2)
        if not 0.0 < self.speed <= 100.0:
            raise Refused(NO_SPEED(value=self.speed), exit_status=2)
        if self.interval is not None and not self.interval > 0.0:
            raise Refused(_NO_PERIOD(value=self.interval), exit_status=2)
        check_recording(self.log)
        if len(self.link.lines) > _MOST_LINES:
            raise Refused(_TOO_MANY_LINES(count=len(self.link.lines)), exit_status=2)
        return MODES[self.by]


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

"""Explore the free space of a robot: charts made, extended, joined and compared.

Without `--cell` an arm is watched, or moves slowly at random, up to a contact: an input of the
controller, a key, or a camera that sees a touch. The flange moves at most at the manual reduced
speed of ISO 10218-1, 250 mm/s. Chart and log are written however it ends. With a cell file, or from
recordings and programs, nothing moves. `explore compare` exits with 1 if free space is occupied.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, error
from assistant.base.termination import is_ctrl_c
from assistant.cli.arm_motion import (
    START_TIME,
    LinesOption,
    ReplaceProgramsOption,
    moving,
    servo_modes,
)
from assistant.cli.command import (
    Argument,
    Option,
    argument,
    command_group,
    command_of,
    option,
    options,
)
from assistant.cli.controller_session import YesOption, confirm, connected, robot_of_cell
from assistant.cli.learning import box_of, range_of
from assistant.cli.options import FormatOption
from assistant.cli.presentation import Format, print_answer, print_findings, say, working
from assistant.cli.source_input import keep_sources
from assistant.cli.teaching import END_KEYS, terminal_keys

if TYPE_CHECKING:
    from assistant.base.arrays import Floats
    from assistant.cell.exploration.occupancy import Occupancy
    from assistant.compiler.exploration import (
        ExplorationRequest,
        ExplorationResult,
        ExplorationStart,
    )
    from assistant.controllers import Controller
    from assistant.robots import Robot
    from assistant.vision.exploration import AnyContacts, Contacts, ExplorationLog, PictureRegion
    from assistant.vision.servoing.bounds import Guard


NO_CHART_NAME: Final = error("CL280", "a chart is not written as `{name}`", "end its name in .npz")
ONLY_MOVED: Final = error(
    "CL288",
    "{what}, and --cell is missing",
    "name the controller, and add --cell with the file of its cell",
)
ONLY_STILL: Final = error(
    "CL289",
    "`{option}` is for a cell in which nothing moves, and --cell moves an arm",
    "leave out one of them",
)
CHART_SUFFIX: Final = ".npz"


explore: Final = command_group(
    "Chart the space about a robot by where it has been without contact."
)
ExploredCellOption = Annotated[Path, Option("File of the cell, with the robot.", "--cell")]
ChartOption = Annotated[
    Path, Option("The chart, .npz; one that is there is gone on with.", "--chart", "-c")
]
ControllerArgument = Annotated[
    str, Argument("Name of a controller of the project, or its address.")
]
HiddenOption = Annotated[
    Path | None, Option("Cell file of what is really there: contacts with that end a run.")
]


@options
class ChartingOptions:
    """The robot, and how finely the space about it is charted."""

    robot: str | None = option("Its name in the cell, if there are several.", "--robot", "-r")
    size: float | None = option("Size of the chart's cells, mm; default 10, or that of the chart.")
    thinner: float = option(
        "mm by which the bodies of the robot are rounder than it is, at most.", default=0.0
    )

    def request(self, cell: Path, chart: Path) -> ExplorationRequest:
        from assistant.compiler.exploration import ExplorationRequest

        return ExplorationRequest(cell, chart, self.robot, self.size, self.thinner)


@options
class ContactOptions:
    """Sources of contacts."""

    contact: str | None = option(
        "Input of the controller that is not 0 in contact.", metavar="SIGNAL"
    )
    key: bool = option("Each key that is pressed is a contact; q ends it.")
    camera: Path | None = option(
        "File of cameras: a picture that differs from the first one is a contact.",
        metavar="CAMERAS.toml",
    )
    region: str | None = option("Part of the pictures, in pixels.", metavar="LEFT,TOP,RIGHT,BOTTOM")

    @property
    def is_given(self) -> bool:
        """True if there is a source at all."""
        return self.contact is not None or self.key or self.camera is not None


@options
class RecordingOptions:
    """Options for recording an arm: duration and file."""

    seconds: float | None = option("Seconds after which it ends.", min=0.0)
    log: Path | None = option(
        "Write joints, poses and contacts, for `recorded`.", metavar="FILE.csv"
    )


def check_moving(hidden: Path | None) -> None:
    """Raise Refused for an option of a cell in which nothing moves."""
    if hidden is not None:
        raise Refused(ONLY_STILL(option="--hidden"), exit_status=2)


def prepare_chart(asked: ExplorationRequest, read: Sequence[str]) -> ExplorationStart:
    """Start an exploration; raise Refused for an invalid chart name or one that would overwrite an
    input.
    """
    from assistant.compiler.exploration import start_exploration

    check_chart_name(asked.chart)
    keep_sources([str(asked.cell), *read], [asked.chart])
    return start_exploration(asked)


def check_chart_name(path: Path) -> None:
    if path.suffix.lower() != CHART_SUFFIX or not path.stem:
        raise Refused(NO_CHART_NAME(name=path), exit_status=2)


def report_exploration(
    begun: ExplorationStart, found: ExplorationResult, what: str, format: Format
) -> int:
    from assistant.cell.exploration.occupancy import save_map

    save_map(found.occupancy, begun.asked.chart)
    return report_chart(ExplorationSummary(found, what, [begun.asked.chart]), format)


@dataclass(frozen=True, slots=True)
class ExplorationSummary:
    """Result of exploring. what: the runs that its rows count. written: files."""

    found: ExplorationResult
    what: str
    written: Sequence[Path]


def report_chart(done: ExplorationSummary, format: Format) -> int:
    """Print the result and the free space so far; returns the exit status."""
    found = done.found
    rows = [dict(zip(("runs", "new", "litres"), row, strict=True)) for row in found.runs]
    chart = chart_record(found.occupancy)
    lines = [f"{done.what:>24} {'new cells':>12} {'litres free':>12}"]
    lines += [f"{runs:>24,} {new:>12,} {litres:>12.1f}" for runs, new, litres in found.runs]
    lines.append("")
    if found.contacts:
        where = f", {found.placeless} of them nobody knows where" if found.placeless else ""
        lines.append(f"contacts: {found.contacts}{where}")
    lines += chart_lines(found.occupancy)
    answer = {"explored": rows, "contacts": found.contacts, "chart": chart}
    if format is Format.TEXT:
        print_findings(found.findings, explained=True)
        for line in (*lines, f"wrote {', '.join(map(str, done.written))}"):
            say(line)
    else:
        print_answer(format, answer, (), found.findings, done.written)
    return 0


def chart_record(occupancy: Occupancy) -> dict[str, Any]:
    from assistant.cell.exploration.occupancy import CellState

    counts = occupancy.counts()
    return {
        "robot": occupancy.robot,
        "cell_mm": occupancy.size,
        "runs": occupancy.runs,
        "free": counts[CellState.FREE],
        "occupied": counts[CellState.OCCUPIED],
        "litres": occupancy.litres,
        "box_mm": [low_high.tolist() for low_high in _free_box(occupancy)],
    }


def _free_box(occupancy: Occupancy) -> Sequence[Any]:
    """Lowest and highest corner (3,) of the free cells in mm of the base; none without any."""
    from assistant.cell.exploration.occupancy import CellState

    cells = occupancy.cells(CellState.FREE)
    if not len(cells):
        return ()
    return cells.min(axis=0) * occupancy.size, (cells.max(axis=0) + 1) * occupancy.size


def chart_lines(occupancy: Occupancy) -> list[str]:
    record = chart_record(occupancy)
    out = [
        f"robot    {record['robot']}",
        f"cells    {record['cell_mm']:g} mm",
        f"runs     {record['runs']:,}",
        f"free     {record['free']:,} cells, {record['litres']:.1f} l",
        f"occupied {record['occupied']:,} cells",
    ]
    if record["box_mm"]:
        low, high = ([f"{value:g}" for value in corner] for corner in record["box_mm"])
        out.append(f"between  ({', '.join(low)}) and ({', '.join(high)}) mm of the base")
    return out


NO_BOUNDS: Final = error(
    "CL282",
    "no bounds of the arm are given, so it does not move",
    "add --range JOINT=LOW:HIGH for joints, or --box X,Y,Z, each of them LOW:HIGH, for the flange",
)
NO_CONTACT: Final = error(
    "CL283",
    "no source of contacts is given, so the arm does not move",
    "add --contact with an input of the controller, --key, or --camera",
)
OTHER_ARM: Final = error(
    "CL284",
    "{name} moves a {one}, and `{arm}` of {cell} is a {other}",
    "name the cell file of that arm, or the arm with --robot",
)
NO_LOG: Final = error(
    "CL285", "a log is not written as `{name}`", "name a .csv file that is not a folder"
)
BAD_REGION: Final = error(
    "CL286", "`{given}` is not a region of a picture", "write LEFT,TOP,RIGHT,BOTTOM in pixels"
)
NO_SPEED: Final = error(
    "CL287",
    "--speed is {value:g}",
    "write mm/s from 0.1 to {most:g}",
)
NO_RANGE: Final = error(
    "CL290",
    "{axis} cannot move between {low:g} and {high:g}: a {robot} has it between {least:g} and "
    "{most:g}",
    "write a lower and a higher value inside these limits",
)
FASTEST_FLANGE: Final = 250.0
"""Highest speed of the flange in mm/s: the manual reduced speed of ISO 10218-1."""
LARGEST_SPEED_SHARE: Final = 0.1
"""Largest part of the full speed of each axis."""
FASTEST_TURN: Final = 30.0
"""Highest turning speed of the flange in degrees/s."""
REFUSED_BEFORE_MOTION: Final = frozenset({"VS221", "CK456"})
"""Codes of what is refused before the first move."""
LOOK_PERIOD: Final = 0.05
"""Seconds between two looks at an arm that others move."""


@command_of(explore)
class Wander:
    """Move at random up to each contact: on this computer, or with --cell a real or virtual arm."""

    where: str = argument(
        "File of a cell, in which nothing moves; or with --cell the controller of an arm.",
        metavar="CELL|CONTROLLER",
    )
    chart: ChartOption
    hidden: HiddenOption
    runs: int = option("Random moves, a run each.", default=50, min=1)
    seed: int | None = option("Of what is random; default another one as the chart grows.", min=0)
    charting: ChartingOptions
    cell: Path | None = option("File of the cell of an arm that really moves.")
    contacts: ContactOptions
    range: tuple[str, ...] = option(
        "Degrees between which a joint may move; repeatable.", metavar="JOINT=LOW:HIGH"
    )
    box: str | None = option("Box of the base for the flange, mm, each LOW:HIGH.", metavar="X,Y,Z")
    speed: float = option("mm/s of the flange, at most 250.", default=50.0)
    by: str = option("Way to lead the arm, as of `servo`.", default="jog", choices=servo_modes)
    port: int | None = option("UDP port of the way; default the usual one.", min=1)
    lines: LinesOption
    replace: ReplaceProgramsOption
    recording: RecordingOptions
    yes: YesOption
    format: FormatOption

    def run(self) -> int:
        if self.cell is not None:
            check_moving(self.hidden)
            return self._move_arm(self.charting.request(self.cell, self.chart))
        from assistant.compiler.exploration import explore_by_random_moves

        self._check_still()
        asked = self.charting.request(Path(self.where), self.chart)
        with working("exploring"):
            begun = prepare_chart(asked, [] if self.hidden is None else [str(self.hidden)])
            found = explore_by_random_moves(begun, self.hidden, self.runs, self.seed)
        return report_exploration(begun, found, "runs", self.format)

    def _check_still(self) -> None:
        """Raise Refused for what is only for an arm that moves: its options, or a controller."""
        given: dict[str, object] = {
            "--contact": self.contacts.contact,
            "--key": self.contacts.key,
            "--camera": self.contacts.camera,
            "--region": self.contacts.region,
            "--range": self.range,
            "--box": self.box,
            "--seconds": self.recording.seconds,
            "--log": self.recording.log,
            "--line": self.lines,
            "--port": self.port,
            "--replace": self.replace,
        }
        left_out: tuple[object, ...] = (None, False, ())
        option = next((name for name, value in given.items() if value not in left_out), None)
        if option is not None:
            raise Refused(ONLY_MOVED(what=f"`{option}` is for an arm that moves"), exit_status=2)
        if not Path(self.where).suffix and not Path(self.where).exists():
            what = f"`{self.where}` is not a cell file but a controller"
            raise Refused(ONLY_MOVED(what=what), exit_status=2)

    def _move_arm(self, asked: ExplorationRequest) -> int:
        """Move an arm at random; the chart and the log are written however it ends."""
        import numpy as np

        from assistant.cli.visual_servoing import joints_nearby, setpoint_mode
        from assistant.controllers.trajectory_execution import LinkOptions
        from assistant.vision.exploration import RandomExplorer, empty_log
        from assistant.vision.rules import EXPLORATION_TIME_OVER
        from assistant.vision.servoing.bounds import Bounds as Limits
        from assistant.vision.servoing.bounds import Guard

        mode = setpoint_mode(self.by)
        wishes = LinkOptions(self.port, self.lines, None, self.replace)
        if not self.range and self.box is None:
            raise Refused(NO_BOUNDS(), exit_status=2)
        if not self.contacts.is_given:
            raise Refused(NO_CONTACT(), exit_status=2)
        if not 0.1 <= self.speed <= FASTEST_FLANGE:
            raise Refused(NO_SPEED(value=self.speed, most=FASTEST_FLANGE), exit_status=2)
        begun = _prepare_explorer(asked, self.recording.log, self.contacts)
        explorer, robot = begun.explorer, begun.explorer.placed.robot
        ranges, box = _joint_ranges(self.range, robot), None
        if self.box is not None:
            sides = box_of(self.box)
            box = (tuple(sides[:, 0].tolist()), tuple(sides[:, 1].tolist()))
        guard = Guard(robot, Limits(self.speed, FASTEST_TURN, LARGEST_SPEED_SHARE, box=box))
        log, done = empty_log(guard), None
        try:
            with moving(self.where, "explore") as motion, ExitStack() as open_:
                there = motion.cell
                _check_arm(begun, there.one.name, robot_of_cell(there.one))
                session = there.controller if mode.operates else there.session
                mode.check(session, wishes)
                carrier = mode.make(session, guard.arm(), wishes, joints_nearby(session, robot))
                contacts, ended = open_.enter_context(
                    _open_contacts(
                        self.contacts,
                        begun,
                        lambda: there.controller,
                        lambda: carrier.joints() if motion.began else joints_nearby(session, robot),
                    )
                )
                faster = [*mode.faster(guard.arm(), str(there.one.address))]
                print_findings(faster)
                what = f"moves the arm at random, {self.runs} times, {self._bounds_text()}"
                most = "" if faster else f", at {self.speed:g} mm/s at most"
                confirm(there.one, f"{what}{most}, {mode.title}", self.yes)
                wanderer = RandomExplorer(
                    explorer,
                    carrier,
                    guard,
                    contacts,
                    log,
                    ranges,
                    np.inf if self.recording.seconds is None else self.recording.seconds,
                    explorer.occupancy.runs if self.seed is None else self.seed,
                    ended,
                    _progress_display(self.runs, self.format),
                )
                motion.began = True
                try:
                    open_.enter_context(carrier)
                    wanderer.check()
                    wanderer.wander(self.runs)
                except Refused as refused:
                    codes = {finding.code for finding in refused.findings}
                    motion.began = not codes <= REFUSED_BEFORE_MOTION | mode.unbegun
                    raise
        finally:  # once the arm stands: learning takes its time
            if log.rows:
                done = _saved(begun, log, self.recording.log)
        assert done is not None
        if wanderer.moves < self.runs and not ended():
            print_findings([EXPLORATION_TIME_OVER(moves=wanderer.moves)])
        return report_chart(done, self.format)

    def _bounds_text(self) -> str:
        parts = [*self.range, *([] if self.box is None else [f"the flange in {self.box}"])]
        return f"within {', '.join(parts)}"


@command_of(explore)
class Manual:
    """Learn while you jog or lead an arm by hand, until Ctrl-C. This moves nothing."""

    controller: ControllerArgument
    cell: ExploredCellOption
    chart: ChartOption
    contacts: ContactOptions
    charting: ChartingOptions
    recording: RecordingOptions
    format: FormatOption

    def run(self) -> int:
        """Record an arm that the operator moves, until the time is over, q, or Ctrl-C."""
        asked = self.charting.request(self.cell, self.chart)
        begun = _prepare_explorer(asked, self.recording.log, self.contacts)
        with connected(self.controller, "explore") as there, ExitStack() as open_:
            controller = there.controller
            _check_arm(begun, there.one.name, robot_of_cell(there.one))
            watched = _WatchedArm(begun)
            watched.controller = controller
            contacts, ended = open_.enter_context(
                _open_contacts(self.contacts, begun, lambda: controller, watched.joints)
            )
            if self.format is Format.TEXT:
                ends = "q or Ctrl-C ends it" if self.contacts.key else "Ctrl-C ends it"
                say(f"{there.one.name}: move the arm by hand, slowly; {ends}")
                sys.stdout.flush()
            try:
                while not watched.is_over(self.recording.seconds) and not ended():
                    watched.look(contacts)
            except KeyboardInterrupt as caught:
                if not is_ctrl_c(caught):
                    raise
            finally:
                done = _saved(begun, watched.log, self.recording.log)
        return report_chart(done, self.format)


@command_of(explore)
class Running:
    """Start a program and learn while it moves the arm; a contact stops it. Asks before."""

    controller: ControllerArgument
    cell: ExploredCellOption
    chart: ChartOption
    program: str | None = option("Program of the controller; default what is loaded.")
    contacts: ContactOptions
    override: int = option("Percent of its speed.", default=10)
    charting: ChartingOptions
    recording: RecordingOptions
    yes: YesOption
    format: FormatOption

    def run(self) -> int:
        """Record an arm that a program moves; a contact stops the program, and gives status 1."""
        from assistant.cli.arm_motion import NO_OVERRIDE

        if not 1 <= self.override <= 100:
            raise Refused(NO_OVERRIDE(value=self.override), exit_status=2)
        if not self.contacts.is_given:
            raise Refused(NO_CONTACT(), exit_status=2)
        asked = self.charting.request(self.cell, self.chart)
        begun = _prepare_explorer(asked, self.recording.log, self.contacts)
        watched, done = _WatchedArm(begun), None
        try:
            with moving(self.controller, "explore") as motion, ExitStack() as open_:
                there = motion.cell
                controller = watched.controller = there.controller
                _check_arm(begun, there.one.name, robot_of_cell(there.one))
                contacts, ended = open_.enter_context(
                    _open_contacts(self.contacts, begun, lambda: controller, watched.joints)
                )
                what = f"starts `{self.program}`" if self.program else "starts what is loaded"
                what = f"{what} at {self.override} %: the arm moves as the program says"
                confirm(there.one, what, self.yes)
                if self.program:
                    controller.load(self.program)
                motion.began = True
                with _slow_override(controller, self.override):
                    if not watched.look(contacts):
                        controller.start()
                        began, stops = time.monotonic(), False
                        while not stops and not watched.is_over(self.recording.seconds):
                            stops = watched.look(contacts, controller.stop) or ended()
                            late = time.monotonic() > began + START_TIME
                            if not stops and late and not controller.state().running:
                                break
        finally:  # once the arm stands: learning takes its time
            if watched.log.rows:
                done = _saved(begun, watched.log, self.recording.log)
        assert done is not None
        status = report_chart(done, self.format)
        return 1 if watched.log.contacts else status


@contextmanager
def _slow_override(controller: Controller, percent: int) -> Iterator[None]:
    """Run at an override. In the end the program is stopped first, and the override set back then.

    A program that is not known to have stopped keeps the override.
    """
    from assistant.controllers.arm_stop import stop_at_once

    before = controller.state().override
    controller.set_override(percent)
    try:
        yield
        controller.stop()
    except BaseException:
        stop_at_once(controller)
        with suppress(Refused):
            if before is not None and not controller.state().running:
                controller.set_override(before)
        raise
    if before is not None:
        controller.set_override(before)


class _WatchedArm:
    """An arm that others move, looked at again and again; the time begins with the first look.

    controller: is set once it is connected.
    """

    controller: Controller

    def __init__(self, begun: ExplorationStart) -> None:
        from assistant.vision.exploration import empty_log
        from assistant.vision.servoing.bounds import Bounds as Limits
        from assistant.vision.servoing.bounds import Guard

        self.guard: Guard = Guard(begun.explorer.placed.robot, Limits())
        self.log: ExplorationLog = empty_log(self.guard)
        self._began: float | None = None

    def joints(self) -> Floats:
        import numpy as np

        from assistant.compiler.taught_targets import own_joints

        return np.array(own_joints(self.controller.position(), self.guard.robot))

    def is_over(self, seconds: float | None) -> bool:
        return seconds is not None and self._seconds() > seconds

    def _seconds(self) -> float:
        now = time.monotonic()
        self._began = now if self._began is None else self._began
        return now - self._began

    def look(self, contacts: AnyContacts, halt: Callable[[], None] = lambda: None) -> bool:
        """Add a row to the log; True if the arm is in contact. halt: is called at once then."""
        time.sleep(LOOK_PERIOD)
        touching = contacts.touching()
        if touching:
            halt()
        self.log.note(self._seconds(), self.joints(), touching, self.guard.robot)
        return touching


def _prepare_explorer(
    asked: ExplorationRequest, log: Path | None, contacts: ContactOptions
) -> ExplorationStart:
    """Return the explorer; raises Refused for a log that cannot be written, or over its sources."""
    from assistant.controllers.recording import check_place

    if log is not None:
        if log.suffix.lower() != ".csv" or log.is_dir():
            raise Refused(NO_LOG(name=log), exit_status=2)
        check_place(log)
        read = [asked.cell, *([contacts.camera] if contacts.camera else [])]
        keep_sources([str(path) for path in read], [log])
    return prepare_chart(asked, [])


def _check_arm(begun: ExplorationStart, name: str, robot: Robot | None) -> None:
    """Raise Refused if the controller, by its project, moves another arm than the cell has."""
    placed = begun.explorer.placed
    if robot is not None and robot.name != placed.robot.name:
        finding = OTHER_ARM(
            name=name,
            one=robot.title,
            arm=placed.name,
            cell=begun.asked.cell,
            other=placed.robot.title,
        )
        raise Refused(finding, exit_status=2)


def _joint_ranges(texts: Sequence[str], robot: Robot) -> Floats | None:
    """Ranges (a, 2) of --range, with the limits of the other joints; None without any."""
    from assistant.cell.exploration.explorer import ranges_of
    from assistant.learning.rules import NO_AXIS

    if not texts:
        return None
    ranges = ranges_of(robot)
    for axis, (low, high) in map(range_of, texts):
        if axis not in robot.axes:
            known = ", ".join(robot.axes)
            raise Refused(NO_AXIS(robot=robot.title, axis=axis, known=known), exit_status=2)
        at = robot.axes.index(axis)
        least, most = robot.limits[at].tolist()
        if not least <= low < high <= most:
            ends = {"least": least, "most": most}
            finding = NO_RANGE(axis=axis, low=low, high=high, robot=robot.title, **ends)
            raise Refused(finding, exit_status=2)
        ranges[at] = low, high
    return ranges


@contextmanager
def _open_contacts(
    contact: ContactOptions,
    begun: ExplorationStart,
    controller: Callable[[], Controller],
    joints: Callable[[], Floats],
) -> Iterator[tuple[AnyContacts, Callable[[], bool]]]:
    """Open the sources of contacts; also gives what is True once the operator ends it."""
    from assistant.vision.exploration import AnyContacts, InputContacts, KeyContacts

    each: list[Contacts] = []
    with ExitStack() as open_:
        if contact.contact is not None:
            each.append(InputContacts(controller(), contact.contact))
            each[-1].touching()  # an input that is not there is refused before anybody is asked
        key: KeyContacts | None = None
        if contact.key:
            key = KeyContacts(open_.enter_context(terminal_keys()), END_KEYS)
            each.append(key)
        if contact.camera is not None:
            each += _open_cameras(contact, begun, joints, open_)
        yield AnyContacts(each), lambda: key is not None and key.ended


def _open_cameras(
    contact: ContactOptions, begun: ExplorationStart, joints: Callable[[], Floats], open_: ExitStack
) -> Iterator[Contacts]:
    """Open each camera of the file as a source; raises Refused for one without a source."""
    from assistant.vision.cameras.camera_file import read_cameras
    from assistant.vision.exploration import open_contact_camera
    from assistant.vision.rules import NO_SERVO_SOURCE

    assert contact.camera is not None
    rig, name = read_cameras(contact.camera), begun.explorer.placed.name
    for camera in rig.cameras.values():
        source = rig.sources.get(camera.name, "")
        if not source:
            raise Refused(NO_SERVO_SOURCE(camera=camera.name), exit_status=2)
        yield open_.enter_context(
            open_contact_camera(
                camera,
                source,
                rig.folder,
                _picture_region(contact.region),
                lambda: {name: joints()},
            )
        )


def _picture_region(text: str | None) -> PictureRegion | None:
    if text is None:
        return None
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != 4 or not all(part.isascii() and part.isdigit() for part in parts):
        raise Refused(BAD_REGION(given=text), exit_status=2)
    left, top, right, bottom = (int(part[:6]) for part in parts)
    return left, top, right, bottom


def _progress_display(runs: int, format: Format) -> Callable[[int, int, float], None]:
    def show(move: int, contacts: int, litres: float) -> None:
        if format is Format.TEXT:
            say(f"move {move} of {runs}: {litres:.1f} l free, contacts: {contacts}")
            sys.stdout.flush()

    return show


def _saved(begun: ExplorationStart, log: ExplorationLog, file: Path | None) -> ExplorationSummary:
    """Learn from the log, and write chart and log."""
    from assistant.cell.exploration.occupancy import save_map
    from assistant.compiler.exploration import learn_from_runs, start_exploration

    found = learn_from_runs(start_exploration(begun.asked), log.clear(), log.contacts)
    save_map(found.occupancy, begun.asked.chart)
    written = [begun.asked.chart]
    if file is not None:
        log.recording.save(file)
        written.append(file)
    return ExplorationSummary(found, "runs without contact", written)

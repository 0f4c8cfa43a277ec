"""Explore the free space of a robot: charts made, extended, joined and compared.

Without `--cell` an arm is watched, or moves slowly at random, up to a contact: an input of the
controller, a key, or a camera that sees a touch. The flange moves at most at the manual reduced
speed of ISO 10218-1, 250 mm/s. Chart and log are written however it ends. With a cell file, or from
recordings and programs, nothing moves. `explore compare` exits with 1 if free space is occupied.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.diagnostics import Refused, error, has_errors
from assistant.base.termination import is_ctrl_c
from assistant.cli.arm_motion import START_TIME, moving
from assistant.cli.compilation import keep_sources, working
from assistant.cli.controller_session import confirm, connected, robot_of_cell
from assistant.cli.learning import box_of, range_of
from assistant.cli.presentation import Format, print_findings, print_json, say
from assistant.cli.teaching import END_KEYS, terminal_keys

if TYPE_CHECKING:
    from assistant.base.arrays import Floats
    from assistant.cell.exploration.occupancy import Occupancy
    from assistant.cli.simulation import SimulationOptions
    from assistant.compiler.exploration import (
        ExplorationRequest,
        ExplorationResult,
        ExplorationStart,
    )
    from assistant.controllers import Controller
    from assistant.controllers.trajectory_execution import LinkOptions
    from assistant.robots import Robot
    from assistant.vision.exploration import AnyContacts, Contacts, ExplorationLog, PictureRegion
    from assistant.vision.servoing.bounds import Guard


NO_CHART_NAME: Final = error("CL280", "a chart is not written as `{name}`", "end its name in .npz")
NO_UNTIL: Final = error("CL281", "--until is {value:g}", "write seconds above 0")
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


def check_still(where: str, given: Mapping[str, object]) -> None:
    """Raise Refused for what is only for an arm that moves: its options, or a controller."""
    left_out: tuple[object, ...] = (None, False, [])
    option = next((name for name, value in given.items() if value not in left_out), None)
    if option is not None:
        raise Refused(ONLY_MOVED(what=f"`{option}` is for an arm that moves"), exit_status=2)
    if not Path(where).suffix and not Path(where).exists():
        what = f"`{where}` is not a cell file but a controller"
        raise Refused(ONLY_MOVED(what=what), exit_status=2)


def check_moving(hidden: Path | None) -> None:
    """Raise Refused for an option of a cell in which nothing moves."""
    if hidden is not None:
        raise Refused(ONLY_STILL(option="--hidden"), exit_status=2)


def run_wander(
    asked: ExplorationRequest, hidden: Path | None, runs: int, seed: int | None, format: Format
) -> int:
    from assistant.compiler.exploration import explore_by_random_moves

    with working("exploring"):
        begun = prepare_chart(asked, [] if hidden is None else [str(hidden)])
        found = explore_by_random_moves(begun, hidden, runs, seed)
    return _report_exploration(begun, found, "runs", format)


def run_recorded(
    asked: ExplorationRequest, recordings: Sequence[Path], contact: str | None, format: Format
) -> int:
    from assistant.compiler.exploration import explore_by_recordings

    with working("reading what was recorded"):
        begun = prepare_chart(asked, [str(path) for path in recordings])
        found = explore_by_recordings(begun, recordings, contact)
    return _report_exploration(begun, found, "runs of each recording", format)


def run_program(
    asked: ExplorationRequest,
    source: str,
    options: SimulationOptions,
    until: float | None,
    hidden: Path | None,
    format: Format,
) -> int:
    """1 if the robot cannot run the program; then the chart stays as it is."""
    from assistant.cli.simulation import report_errors, solved_source
    from assistant.compiler.arms import InCell
    from assistant.compiler.exploration import explore_by_program
    from assistant.robots.timing import simulate

    if until is not None and not until > 0.0:
        raise Refused(NO_UNTIL(value=until), exit_status=2)
    with working(f"going through {source}"):
        begun = prepare_chart(asked, [source, *([] if hidden is None else [str(hidden)])])
        explorer = begun.explorer
        named = None if asked.robot is None else explorer.placed.robot
        scene = replace(explorer.scene, runs=asked.robot)
        done = solved_source(source, options, InCell(scene, named))
        if has_errors(done.findings):
            robot = done.solution.robot
            return report_errors(source, robot, done.findings, format, "gone through")
        simulation = simulate(done.solution, acceleration=options.acceleration)
        try:
            found = explore_by_program(begun, done.program, simulation, until, hidden)
        except Refused as caught:
            findings = [done.places.finding(one).within(source) for one in caught.findings]
            raise Refused(*findings, exit_status=caught.exit_status) from None
    return _report_exploration(begun, found, "runs", format)


def prepare_chart(asked: ExplorationRequest, read: Sequence[str]) -> ExplorationStart:
    """Start an exploration; raise Refused for an invalid chart name or one that would overwrite an
    input.
    """
    from assistant.compiler.exploration import start_exploration

    _check_chart_name(asked.chart)
    keep_sources([str(asked.cell), *read], [asked.chart])
    return start_exploration(asked)


def _check_chart_name(path: Path) -> None:
    if path.suffix.lower() != CHART_SUFFIX or not path.stem:
        raise Refused(NO_CHART_NAME(name=path), exit_status=2)


def _report_exploration(
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
    from assistant.findings.formats import finding_record

    found, what = done.found, done.what
    if format is Format.JSON:
        rows = [dict(zip(("runs", "new", "litres"), row, strict=True)) for row in found.runs]
        findings = [finding_record(one) for one in found.findings]
        answer = {
            "explored": rows,
            "contacts": found.contacts,
            "chart": _chart_record(found.occupancy),
        }
        written = [str(path) for path in done.written]
        print_json(answer | {"findings": findings, "written": written})
        return 0
    print_findings(found.findings, explained=True)
    say(f"{what:>24} {'new cells':>12} {'litres free':>12}")
    for runs, new, litres in found.runs:
        say(f"{runs:>24,} {new:>12,} {litres:>12.1f}")
    say("")
    if found.contacts:
        where = f", {found.placeless} of them nobody knows where" if found.placeless else ""
        say(f"contacts: {found.contacts}{where}")
    for line in _chart_lines(found.occupancy):
        say(line)
    say(f"wrote {', '.join(str(path) for path in done.written)}")
    return 0


def _chart_record(occupancy: Occupancy) -> dict[str, Any]:
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


def _chart_lines(occupancy: Occupancy) -> list[str]:
    record = _chart_record(occupancy)
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


def run_chart_shown(path: Path, output: Path | None, format: Format) -> int:
    """output: a picture of it that is written."""
    from assistant.base.file_sets import write_all
    from assistant.cell.exploration.occupancy import load_map
    from assistant.report.figures import format_of
    from assistant.report.workspace import explored_picture

    kind = "" if output is None else format_of(output.name)
    occupancy = load_map(path)
    written: list[str] = []
    if output is not None:
        keep_sources([str(path)], [output])
        written = [str(one) for one in write_all({output: explored_picture(occupancy, kind)})]
    if format is Format.JSON:
        print_json({"chart": str(path), **_chart_record(occupancy), "written": written})
        return 0
    for line in [*_chart_lines(occupancy), *(f"wrote {one}" for one in written)]:
        say(line)
    return 0


def run_charts_merged(paths: Sequence[Path], output: Path, format: Format) -> int:
    from assistant.cell.exploration.occupancy import load_map, save_map

    _check_chart_name(output)
    keep_sources([str(path) for path in paths], [output])
    merged = load_map(paths[0])
    for path in paths[1:]:
        other = load_map(path)
        with _at_chart(path):
            merged = merged.merged(other)
    save_map(merged, output)
    if format is Format.JSON:
        print_json({"chart": _chart_record(merged), "written": [str(output)]})
        return 0
    for line in _chart_lines(merged):
        say(line)
    say(f"wrote {output}")
    return 0


def run_charts_compared(old: Path, new: Path, format: Format) -> int:
    """1 if what was free is not any more."""
    from assistant.cell.exploration.occupancy import load_map

    before, after = load_map(old), load_map(new)
    with _at_chart(new):
        found = before.compared(after)
    if format is Format.JSON:
        print_json({"old": str(old), "new": str(new), **asdict(found)})
    else:
        litre = before.size**3 / 1e6
        for count, what in (
            (found.same, "are known alike"),
            (found.gained, f"are known in {new} only"),
            (found.lost, f"are known in {old} only"),
            (found.freed, "were occupied and are free"),
            (found.blocked, "were free and are occupied"),
        ):
            say(f"{count:>12,} cells ({count * litre:.1f} l) {what}")
    return 1 if found.blocked else 0


@contextmanager
def _at_chart(path: Path) -> Iterator[None]:
    """Attach the chart's path to the findings of Refused."""
    try:
        yield
    except Refused as refused:
        findings = [finding.within(str(path)) for finding in refused.findings]
        raise Refused(*findings, exit_status=refused.exit_status) from None


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


@dataclass(frozen=True, slots=True)
class ContactOptions:
    """Sources of contacts. signal: an input of the controller. key: keys of the operator. cameras:
    file of cameras whose pictures change. region: of the pictures, as it was typed.
    """

    signal: str | None = None
    key: bool = False
    cameras: Path | None = None
    region: str | None = None

    @property
    def is_given(self) -> bool:
        """True if there is a source at all."""
        return self.signal is not None or self.key or self.cameras is not None


@dataclass(frozen=True, slots=True)
class WatchOptions:
    """Options for watching and recording an arm. seconds: None for no limit. yes: without a
    question.
    """

    contact: ContactOptions
    seconds: float | None
    log: Path | None
    yes: bool
    format: Format


@dataclass(frozen=True, slots=True)
class MotionBounds:
    """ranges, box: the words of --range and --box. speed: mm/s of the flange. by, wishes: the mode
    that leads the arm, and its options.
    """

    ranges: Sequence[str]
    box: str | None
    speed: float
    by: str
    wishes: LinkOptions


def run_wander_arm(
    cell: str,
    asked: ExplorationRequest,
    bounds: MotionBounds,
    live: WatchOptions,
    runs: int,
    seed: int | None,
) -> int:
    """Move an arm at random; the chart and the log are written however it ends."""
    from assistant.cli.visual_servoing import joints_nearby, setpoint_mode
    from assistant.vision.exploration import RandomExplorer, empty_log
    from assistant.vision.rules import EXPLORATION_TIME_OVER
    from assistant.vision.servoing.bounds import Bounds as Limits
    from assistant.vision.servoing.bounds import Guard

    mode = setpoint_mode(bounds.by)
    if not bounds.ranges and bounds.box is None:
        raise Refused(NO_BOUNDS(), exit_status=2)
    if not live.contact.is_given:
        raise Refused(NO_CONTACT(), exit_status=2)
    if not 0.1 <= bounds.speed <= FASTEST_FLANGE:
        raise Refused(NO_SPEED(value=bounds.speed, most=FASTEST_FLANGE), exit_status=2)
    begun = _prepare_explorer(asked, live)
    explorer, robot = begun.explorer, begun.explorer.placed.robot
    ranges, box = _joint_ranges(bounds.ranges, robot), None
    if bounds.box is not None:
        sides = box_of(bounds.box)
        box = (tuple(sides[:, 0].tolist()), tuple(sides[:, 1].tolist()))
    guard = Guard(robot, Limits(bounds.speed, FASTEST_TURN, LARGEST_SPEED_SHARE, box=box))
    log, done = empty_log(guard), None
    try:
        with moving(cell, "explore") as motion, ExitStack() as open_:
            there = motion.cell
            _check_arm(begun, there.one.name, robot_of_cell(there.one))
            session = there.controller if mode.operates else there.session
            mode.check(session, bounds.wishes)
            carrier = mode.make(session, guard.arm(), bounds.wishes, joints_nearby(session, robot))
            contacts, ended = open_.enter_context(
                _open_contacts(
                    live.contact,
                    begun,
                    lambda: there.controller,
                    lambda: carrier.joints() if motion.began else joints_nearby(session, robot),
                )
            )
            faster = [*mode.faster(guard.arm(), str(there.one.address))]
            print_findings(faster)
            what = f"moves the arm at random, {runs} times, {_bounds_text(bounds)}"
            most = "" if faster else f", at {bounds.speed:g} mm/s at most"
            confirm(there.one, f"{what}{most}, {mode.title}", live.yes)
            wanderer = RandomExplorer(
                explorer,
                carrier,
                guard,
                contacts,
                log,
                ranges,
                np.inf if live.seconds is None else live.seconds,
                explorer.occupancy.runs if seed is None else seed,
                ended,
                _progress_display(live, runs),
            )
            motion.began = True
            try:
                open_.enter_context(carrier)
                wanderer.check()
                wanderer.wander(runs)
            except Refused as refused:
                codes = {finding.code for finding in refused.findings}
                motion.began = not codes <= REFUSED_BEFORE_MOTION | mode.unbegun
                raise
    finally:  # once the arm stands: learning takes its time
        if log.rows:
            done = _saved(begun, log, live)
    assert done is not None
    if wanderer.moves < runs and not ended():
        print_findings([EXPLORATION_TIME_OVER(moves=wanderer.moves)])
    return report_chart(done, live.format)


def run_manual(cell: str, asked: ExplorationRequest, live: WatchOptions) -> int:
    """Record an arm that the operator moves, until the time is over, q, or Ctrl-C."""
    begun = _prepare_explorer(asked, live)
    with connected(cell, "explore") as there, ExitStack() as open_:
        controller = there.controller
        _check_arm(begun, there.one.name, robot_of_cell(there.one))
        watched = _WatchedArm(begun)
        watched.controller = controller
        contacts, ended = open_.enter_context(
            _open_contacts(live.contact, begun, lambda: controller, watched.joints)
        )
        if live.format is Format.TEXT:
            ends = "q or Ctrl-C ends it" if live.contact.key else "Ctrl-C ends it"
            say(f"{there.one.name}: move the arm by hand, slowly; {ends}")
            sys.stdout.flush()
        try:
            while not watched.is_over(live.seconds) and not ended():
                watched.look(contacts)
        except KeyboardInterrupt as caught:
            if not is_ctrl_c(caught):
                raise
        finally:
            done = _saved(begun, watched.log, live)
    return report_chart(done, live.format)


def run_running(
    cell: str, program: str | None, asked: ExplorationRequest, live: WatchOptions, override: int
) -> int:
    """Record an arm while a program moves it; a contact stops the program, and gives status 1."""
    from assistant.cli.arm_motion import NO_OVERRIDE

    if not 1 <= override <= 100:
        raise Refused(NO_OVERRIDE(value=override), exit_status=2)
    if not live.contact.is_given:
        raise Refused(NO_CONTACT(), exit_status=2)
    begun = _prepare_explorer(asked, live)
    watched, done = _WatchedArm(begun), None
    try:
        with moving(cell, "explore") as motion, ExitStack() as open_:
            there = motion.cell
            controller = watched.controller = there.controller
            _check_arm(begun, there.one.name, robot_of_cell(there.one))
            contacts, ended = open_.enter_context(
                _open_contacts(live.contact, begun, lambda: controller, watched.joints)
            )
            what = f"starts `{program}`" if program else "starts what is loaded"
            what = f"{what} at {override} %: the arm moves as the program says"
            confirm(there.one, what, live.yes)
            if program:
                controller.load(program)
            motion.began = True
            with _slow_override(controller, override):
                if not watched.look(contacts):
                    controller.start()
                    began, stops = time.monotonic(), False
                    while not stops and not watched.is_over(live.seconds):
                        stops = watched.look(contacts, controller.stop) or ended()
                        late = time.monotonic() > began + START_TIME
                        if not stops and late and not controller.state().running:
                            break
    finally:  # once the arm stands: learning takes its time
        if watched.log.rows:
            done = _saved(begun, watched.log, live)
    assert done is not None
    status = report_chart(done, live.format)
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


def _prepare_explorer(asked: ExplorationRequest, live: WatchOptions) -> ExplorationStart:
    """Return the explorer; raises Refused for a log that cannot be written, or over its sources."""
    from assistant.controllers.recording import check_place

    if live.log is not None:
        if live.log.suffix.lower() != ".csv" or live.log.is_dir():
            raise Refused(NO_LOG(name=live.log), exit_status=2)
        check_place(live.log)
        read = [asked.cell, *([live.contact.cameras] if live.contact.cameras else [])]
        keep_sources([str(path) for path in read], [live.log])
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


def _bounds_text(bounds: MotionBounds) -> str:
    parts = [*bounds.ranges, *([] if bounds.box is None else [f"the flange in {bounds.box}"])]
    return f"within {', '.join(parts)}"


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
        if contact.signal is not None:
            each.append(InputContacts(controller(), contact.signal))
            each[-1].touching()  # an input that is not there is refused before anybody is asked
        key: KeyContacts | None = None
        if contact.key:
            key = KeyContacts(open_.enter_context(terminal_keys()), END_KEYS)
            each.append(key)
        if contact.cameras is not None:
            each += _open_cameras(contact, begun, joints, open_)
        yield AnyContacts(each), lambda: key is not None and key.ended


def _open_cameras(
    contact: ContactOptions, begun: ExplorationStart, joints: Callable[[], Floats], open_: ExitStack
) -> Iterator[Contacts]:
    """Open each camera of the file as a source; raises Refused for one without a source."""
    from assistant.vision.cameras.camera_file import read_cameras
    from assistant.vision.exploration import open_contact_camera
    from assistant.vision.rules import NO_SERVO_SOURCE

    assert contact.cameras is not None
    rig, name = read_cameras(contact.cameras), begun.explorer.placed.name
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


def _progress_display(live: WatchOptions, runs: int) -> Callable[[int, int, float], None]:
    def show(move: int, contacts: int, litres: float) -> None:
        if live.format is Format.TEXT:
            say(f"move {move} of {runs}: {litres:.1f} l free, contacts: {contacts}")
            sys.stdout.flush()

    return show


def _saved(begun: ExplorationStart, log: ExplorationLog, live: WatchOptions) -> ExplorationSummary:
    """Learn from the log, and write chart and log."""
    from assistant.cell.exploration.occupancy import save_map
    from assistant.compiler.exploration import learn_from_runs, start_exploration

    found = learn_from_runs(start_exploration(begun.asked), log.clear(), log.contacts)
    save_map(found.occupancy, begun.asked.chart)
    written = [begun.asked.chart]
    if live.log is not None:
        log.recording.save(live.log)
        written.append(live.log)
    return ExplorationSummary(found, "runs without contact", written)

"""Places and paths that are shown to cameras, with a ball or a wand: `teach --point`.

A place is shown by a hold; a stroke is the path between two holds, written as a table of
waypoints. With `--go` the arm moves to each place and the position where it comes to rest is
stored. The arm moves by its own kinematics; with `--servo` the last part is led by what the
cameras see of the tool, so that errors of the arm's lengths do not matter.
"""

from __future__ import annotations

import itertools
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error
from assistant.cli.arm_motion import NO_SPEED, Moving, follow_modes, moving
from assistant.cli.command import option, options
from assistant.cli.controller_session import (
    YesOption,
    confirm,
    joints_line,
    named_by,
    pose_line,
    record,
    robot_of_cell,
)
from assistant.cli.options import FormatOption, RobotOption
from assistant.cli.presentation import Format, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.compiler.taught_targets import ShownTarget, TargetOptions
    from assistant.controllers import Named
    from assistant.controllers.setpoint_streams import Mode as ByPictures
    from assistant.controllers.trajectory_execution import LinkOptions, Mode
    from assistant.robots import Robot
    from assistant.vision.cameras.camera import Camera
    from assistant.vision.cameras.camera_file import Rig
    from assistant.vision.pointing.demonstrations import HeldPosition, HoldLimits
    from assistant.vision.pointing.device_tracking import Limits, Observation
    from assistant.vision.pointing.devices import Device
    from assistant.vision.servoing.servo_task import ServoFile, ServoSetup


@options
class PointingOptions:
    """Options for showing places to cameras and leading an arm there."""

    point: Path | None = option(
        "Store places that are shown to these cameras.", metavar="CAMERAS.toml"
    )
    camera: tuple[str, ...] = option("Camera that looks; repeatable, default all.")
    device: str = option("wand, ball, light, or a file.", default="wand", metavar="DEVICE")
    frames: int = option("Pictures for which a place is held.", default=30)
    rate: float = option("Pictures a second of files.", default=30.0)
    residual: float = option("Pixels by which pictures may disagree.", default=0.5)
    fastest: float = option("mm/s that a hand moves.", default=1500.0)
    robot: RobotOption
    world: str | None = option("Frame of the file in which the cameras stand.")
    stroke: bool = option("Store the way between two places, as a .csv.")
    step: float = option("mm between waypoints of a stroke.", default=5.0)
    go: bool = option("Lead the arm there; store what it reached.")
    by: str = option("Way to lead it, as of `follow`.", default="data-link", choices=follow_modes)
    port: int | None = option("UDP port of that way.", min=1, max=65535)
    lines: tuple[str, ...] = option("Line of that way; repeatable.", "--line")
    above: float = option("mm before a place from which it is led straight.", default=50.0)
    servo: Path | None = option(
        "Lead it from there by what is seen of its tool.", metavar="TASK.toml"
    )
    speed: float = option("Percent of what the file says.", default=10.0)
    yes: YesOption
    format: FormatOption


def free_names(file: Path) -> Iterator[str]:
    """p1, p2 … as far as the file has no target of that name."""
    from assistant.sources import read

    taken: set[str] = set()
    if file.exists() and file.stat().st_size:
        program = read(file).program
        taken = {name.lower() for name in (*program.targets, *program.joint_targets)}
    return (name for i in itertools.count(1) if (name := f"p{i}") not in taken)


@dataclass(slots=True)
class _ShownPlaces:
    """Positions shown to cameras, and the counts and reasons collected meanwhile."""

    rig: Rig
    cameras: tuple[Camera, ...]
    device: Device
    options: PointingOptions
    into: Path
    wanted: TargetOptions
    good: int = 0
    count: int = 0
    reasons: Counter[str] = field(default_factory=Counter)

    @contextmanager
    def looks(self) -> Iterator[Iterator[Observation]]:
        from assistant.vision.pointing.device_tracking import (
            check_cameras,
            open_moments,
            track_device,
        )

        check_cameras(self.cameras)
        with open_moments(self.rig, self.cameras, self.options.rate) as given:
            fastest = self.options.fastest
            looks = track_device(given, self.device, self.cameras, self.limits, fastest)
            yield self._counted(looks)

    def _counted(self, looks: Iterator[Observation]) -> Iterator[Observation]:
        for look in looks:
            self.count += 1
            if isinstance(look.seen, Diagnostic):
                self.reasons[look.seen.message] += 1
            else:
                self.good += 1
            yield look

    @contextmanager
    def holds(self) -> Iterator[Iterator[HeldPosition]]:
        from assistant.vision.pointing.demonstrations import find_holds

        with self.looks() as looks:
            yield find_holds(looks, self.device, self.cameras, self.limits, self.still, self.tell)

    @property
    def still(self) -> HoldLimits:
        from assistant.vision.pointing.demonstrations import HoldLimits

        return HoldLimits(self.options.frames)

    @property
    def limits(self) -> Limits:
        from assistant.vision.pointing.device_tracking import Limits

        return Limits(residual=self.options.residual)

    def tell(self, finding: Diagnostic) -> None:
        sys.stdout.flush()
        print_findings([finding])

    def ended(self, name: str) -> Refused:
        """Return the refusal for pictures that ended before anything was shown."""
        from assistant.vision.rules import POSITION_NOT_SHOWN

        most = self.reasons.most_common(1)
        mostly = f"; mostly {most[0][0]}" if most else ""
        return Refused(
            POSITION_NOT_SHOWN(
                name=name,
                seen=self.good,
                count=self.count,
                mostly=mostly,
                frames=self.options.frames,
            )
        )


def _next_place(
    name: str,
    holds: Iterator[HeldPosition],
    shown: _ShownPlaces,
    robot: Robot | None,
    near: Sequence[float] | None = None,
) -> tuple[HeldPosition, ShownTarget] | None:
    """The next place that is shown and reached; None when there are no pictures any more."""
    import numpy as np

    from assistant.compiler.taught_targets import DEVICE_TILTED, OUT_OF_REACH, target_of_shown

    options = shown.options
    if options.format is Format.TEXT:
        say(f"{name}: hold the {shown.device.name} still; Ctrl-C ends")
        sys.stdout.flush()
    start = None if near is None else np.array(near)
    for held in holds:
        try:
            place = target_of_shown(
                shown.into, name, held.pose, robot, shown.wanted, start, options.world
            )
        except Refused as refused:
            if not {f.code for f in refused.findings} <= {OUT_OF_REACH.code, DEVICE_TILTED.code}:
                raise
            print_findings(refused.findings)
            continue
        print_findings(place.findings)
        return held, place
    return None


def _place_line(place: ShownTarget) -> str:
    x, y, z = place.pose.position
    q = ", ".join(f"{part:.5f}" for part in place.pose.quaternion)
    return f"x {x:.2f}  y {y:.2f}  z {z:.2f} mm  quaternion ({q})"


def _certainty(held: HeldPosition) -> str:
    return f"{held.frames} moments within {held.spread:.2f} mm, mean known to {held.sigma:.2f} mm"


def _pointing_record(held: HeldPosition, place: ShownTarget) -> dict[str, object]:
    return {
        "name": place.name,
        "position": list(place.pose.position),
        "quaternion": list(place.pose.quaternion),
        "joints": None if place.joints is None else place.joints.tolist(),
        "frames": held.frames,
        "spread_mm": held.spread,
        "turned_degrees": held.turned,
        "residual_px": held.residual,
        "covariance": held.covariance.tolist(),
    }


_NO_CONTROLLER: Final = error(
    "CL510",
    "no controller of the project is named, and --go leads an arm",
    "name the controller as the first word",
)
_NOT_TOGETHER: Final = error("CL512", "{one} and {other} do not go together", "leave one of them")
_NOT_CSV: Final = error(
    "CL513", "a stroke is written as a table, and `{name}` is none", "end its name in .csv"
)
_NO_ARM: Final = error("CL519", "--servo says how an arm is led, and none is", "add --go")
_FILE_EXISTS: Final = error(
    "CL514", "`{name}` is there already", "name another file, or add --replace"
)
_NO_COUNT: Final = error("CL515", "{option} is {value:g}", "write {cure}")


def store_shown(
    words: Sequence[str],
    trigger: str | None,
    options: PointingOptions,
    into: Path,
    wanted: TargetOptions,
) -> int:
    """Store places that are shown. words: perhaps a controller, and names; without names p1, p2 …
    until the pictures end. trigger: an option of another moment to store.
    """
    if trigger is not None:
        raise Refused(_NOT_TOGETHER(one="--point", other=trigger), exit_status=2)
    from assistant.vision.cameras.camera_file import read_cameras
    from assistant.vision.pointing.devices import device_of

    _check_options(options, into, wanted)
    one, names = _split_controller(words)
    assert options.point is not None
    rig = read_cameras(options.point)
    cameras = tuple(rig[name] for name in options.camera or rig.cameras)
    shown = _ShownPlaces(rig, cameras, device_of(options.device), options, into, wanted)
    if options.go:
        if one is None:
            raise Refused(_NO_CONTROLLER(), exit_status=2)

        return _run_pointed_arm(words[0], names, shown)
    robot = _robot_of(one, options)
    if options.stroke:
        return _store_stroke(shown, robot)
    return _store_places(names, shown, robot)


def _check_options(options: PointingOptions, into: Path, wanted: TargetOptions) -> None:
    """Raises Refused for options that mean nothing."""
    least = (
        (options.frames, "--frames", 2, "a whole number from 2"),
        (options.rate, "--rate", 0.1, "pictures a second"),
        (options.residual, "--residual", 0.01, "pixels above 0"),
        (options.fastest, "--fastest", 1.0, "mm a second"),
        (options.step, "--step", 0.1, "mm from 0.1"),
    )
    for value, named, low, cure in least:
        if not low <= value < 1e6:
            raise Refused(_NO_COUNT(option=named, value=value, cure=cure), exit_status=2)
    if not 0.0 <= options.above <= 500.0:
        cure = "0 to 500 mm"
        raise Refused(_NO_COUNT(option="--above", value=options.above, cure=cure), exit_status=2)
    if not 0.0 < options.speed <= 100.0:
        raise Refused(NO_SPEED(value=options.speed), exit_status=2)
    if options.stroke:
        others = {"--go": options.go, "--world": options.world, "--joints": wanted.joints}
        wrong = next((name for name, given in others.items() if given), None)
        if wrong is not None:
            raise Refused(_NOT_TOGETHER(one="--stroke", other=wrong), exit_status=2)
        if into.suffix.lower() != ".csv":
            raise Refused(_NOT_CSV(name=into), exit_status=2)
        if into.exists() and not wanted.again:
            raise Refused(_FILE_EXISTS(name=into))
    if options.go and options.robot is not None:
        raise Refused(_NOT_TOGETHER(one="--go", other="--robot"), exit_status=2)
    if options.servo is not None and not options.go:
        raise Refused(_NO_ARM(), exit_status=2)


def _split_controller(words: Sequence[str]) -> tuple[Named | None, Sequence[str]]:
    """The first word is a controller if the project has one of that name, or it is an address."""
    if not words:
        return None, ()
    from assistant.controllers import controllers_of

    known = "://" in words[0] or words[0] in controllers_of(Path.cwd())
    return (named_by(words[0]), words[1:]) if known else (None, words)


def _robot_of(one: Named | None, options: PointingOptions) -> Robot | None:
    from assistant.compiler.arms import robot_of

    if options.robot is not None:
        return robot_of(options.robot)
    return None if one is None else robot_of_cell(one)


def _store_places(names: Sequence[str], shown: _ShownPlaces, robot: Robot | None) -> int:
    """Each place that is shown, as a target, until there are no names or no pictures any more."""
    from assistant.compiler.taught_targets import check_names, store_target

    options = shown.options
    check_names(shown.into, names, robot, shown.wanted)
    stored: list[dict[str, object]] = []
    with shown.holds() as holds:
        for name in names or free_names(shown.into):
            found = _next_place(name, holds, shown, robot)
            if found is None:
                if names or not stored:
                    raise shown.ended(name)
                break
            held, place = found
            store_target(shown.into, place, shown.wanted)
            stored.append(_pointing_record(held, place))
            if options.format is Format.TEXT:
                say(f"{name}: {_place_line(place)}, {_certainty(held)}, stored in {shown.into}")
                sys.stdout.flush()
    if options.format is Format.JSON:
        print_json({"file": str(shown.into), "device": shown.device.name, "stored": stored})
    return 0


def _store_stroke(shown: _ShownPlaces, robot: Robot | None) -> int:
    """The way between two holds, as a table of waypoints."""
    from dataclasses import replace

    from assistant.base.file_sets import write_files
    from assistant.compiler.taught_targets import turned_into_plane
    from assistant.vision.pointing.demonstrations import Smoothing, find_strokes

    options = shown.options
    if options.format is Format.TEXT:
        say(f"hold the {shown.device.name} still, lead it along the way, and hold it still again")
        sys.stdout.flush()
    smoothing = Smoothing(options.step)
    with shown.looks() as looks:
        ways = find_strokes(
            looks, shown.device, shown.cameras, shown.limits, shown.still, smoothing, shown.tell
        )
        way = next(ways, None)
    if way is None:
        raise shown.ended("the stroke")
    turned = turned_into_plane(way.positions, way.quaternions, robot)
    table = replace(way, quaternions=turned).csv()
    write_files({shown.into.name: table.encode("ascii")}, shown.into.parent)
    if options.format is Format.JSON:
        print_json(
            {
                "file": str(shown.into),
                "waypoints": len(way.positions),
                "length_mm": way.length,
                "scatter_mm": way.scatter,
            }
        )
    else:
        say(
            f"{len(way.positions)} waypoints along {way.length:.1f} mm, "
            f"what was seen {way.scatter:.2f} mm about them, stored in {shown.into}"
        )
    return 0


_NO_ROBOT: Final = error(
    "CL511",
    "no project says which robot `{name}` moves, so it is led nowhere",
    "write robot = NAME into its table in assistant.toml",
)
_NO_POINTING_MODE: Final = error(
    "CL517", "no arm is led to a place by `{by}`", "choose one of {known}"
)


@dataclass(frozen=True, slots=True)
class _ArmLeader:
    """mode: by which the arm is led. pictures: and file, by which from `above` on, None for not."""

    motion: Moving
    robot: Robot
    shown: _ShownPlaces
    mode: Mode
    wishes: LinkOptions
    pictures: tuple[ByPictures, ServoFile] | None

    def led(self, place: ShownTarget, held: HeldPosition) -> dict[str, float]:
        """Asks, and leads the arm to a place; how far it is from there. Raises Refused."""
        from assistant.compiler.commanded_motion import trajectory_of_program
        from assistant.compiler.taught_targets import (
            check_reached,
            own_joints,
            program_to_target,
            tip_at,
        )

        options, controller = self.shown.options, self.motion.cell.controller
        position = controller.position()
        way = program_to_target(place, options.above, to_its_end=self.pictures is None)
        into = str(self.shown.into)
        led = trajectory_of_program(
            way, self.robot, position, self.mode.period, options.speed, into
        )
        print_findings(led.findings)
        seen = self._set_up(place)
        how = self.mode.title if seen is None else f"{self.mode.title}, then {seen.title}"
        what = f"leads the arm to `{place.name}` at {_place_line(place)}, {_certainty(held)}, {how}"
        confirm(self.motion.cell.one, what, options.yes)
        self.motion.began = True
        self.mode.run(controller, led, self.wishes, lambda _: None)
        if seen is None:
            joints = own_joints(controller.position(), self.robot)
            off, turned = check_reached(place, tip_at(place, joints, self.robot))
        else:
            off, turned = self._by_pictures(seen)
        self.motion.began = False
        return {"off_mm": off, "off_degrees": turned}

    def _set_up(self, place: ShownTarget) -> ServoSetup | None:
        from assistant.compiler.taught_targets import tip_of
        from assistant.program.geometry import IDENTITY
        from assistant.vision.servoing.servo_task import set_up_servo

        if self.pictures is None:
            return None
        file = replace(self.pictures[1], target=None, place=place.tip, goal=IDENTITY)
        return set_up_servo(replace(file, tip=tip_of(place)), self.shown.rig, self.robot)

    def _by_pictures(self, seen: ServoSetup) -> tuple[float, float]:
        """Mm and degrees that are left as the cameras see it."""
        import numpy as np

        from assistant.compiler.taught_targets import own_joints
        from assistant.vision.servoing.servo_loop import servo
        from assistant.vision.servoing.servo_task import open_eyes

        assert self.pictures is not None
        mode, cell = self.pictures[0], self.motion.cell
        near = np.array(own_joints(cell.controller.position(), self.robot))
        session = cell.controller if mode.operates else cell.session
        carrier = mode.make(session, seen.guard.arm(), self.wishes, near)
        with open_eyes(seen, carrier.joints) as eyes, carrier:
            done = servo(eyes, seen.law, carrier, seen.guard, seen.file.settings)
        return done.distance, done.turn


def _run_pointed_arm(cell: str, names: Sequence[str], shown: _ShownPlaces) -> int:
    """The arm is led to each place, and where it comes to rest is stored."""
    from assistant.compiler.taught_targets import check_names
    from assistant.controllers.trajectory_execution import MODES, LinkOptions

    options = shown.options
    if options.by not in MODES:
        known = ", ".join(MODES)
        raise Refused(_NO_POINTING_MODE(by=options.by, known=known), exit_status=2)
    mode, wishes = (
        MODES[options.by],
        LinkOptions(options.port, options.lines, None, shown.wanted.again),
    )
    pictures = _servo_pictures(options.servo, options.by)
    stored: list[dict[str, object]] = []
    with moving(cell, "teach --go") as motion:
        there = motion.cell
        controller, robot = there.controller, robot_of_cell(there.one)
        if robot is None:
            raise Refused(_NO_ROBOT(name=there.one.name), exit_status=2)
        mode.check(controller, wishes)
        check_names(shown.into, names, robot, shown.wanted)
        leader = _ArmLeader(motion, robot, shown, mode, wishes, pictures)
        with ExitStack() as looking:
            # Cameras by which the arm is led are let go of in between.
            holds = None if pictures else looking.enter_context(shown.holds())
            for name in names or free_names(shown.into):
                done = _store_next(name, holds, leader)
                if done is None:
                    if names or not stored:
                        raise shown.ended(name)
                    break
                stored.append(done)
    if options.format is Format.JSON:
        answer = {"address": str(there.one.address), "file": str(shown.into), "stored": stored}
        print_json(record(answer))
    return 0


def _servo_pictures(file: Path | None, by: str) -> tuple[ByPictures, ServoFile] | None:
    if file is None:
        return None
    from assistant.controllers.setpoint_streams import MODES
    from assistant.vision.servoing.servo_task import read_servo

    return MODES[by], read_servo(file, led_elsewhere=True)


def _store_next(
    name: str, holds: Iterator[HeldPosition] | None, leader: _ArmLeader
) -> dict[str, object] | None:
    """Leads the arm to the next place and stores where it is then; None without a place."""
    from assistant.compiler.taught_targets import own_joints, teach_target

    shown, robot = leader.shown, leader.robot
    options, controller = shown.options, leader.motion.cell.controller
    near = own_joints(controller.position(), robot)
    with ExitStack() as looking:
        looked = looking.enter_context(shown.holds()) if holds is None else holds
        found = _next_place(name, looked, shown, robot, near)
    if found is None:
        return None
    held, place = found
    off = leader.led(place, held)
    position = controller.position()
    print_findings(teach_target(shown.into, name, position, robot, shown.wanted).findings)
    if options.format is Format.TEXT:
        shown_line = joints_line if shown.wanted.joints else pose_line
        say(
            f"{name}: {shown_line(position)}, {off['off_mm']:.2f} mm and "
            f"{off['off_degrees']:.2f} degrees from what was shown, stored in {shown.into}"
        )
        sys.stdout.flush()
    return {**_pointing_record(held, place), "reached": position, **off}

"""`teach --point`: places that somebody shows to two cameras, into a file; `--go` leads the arm."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.cli.cells import joints_line, named_by, pose_line, record, robot_of_cell
from assistant.cli.confirming import confirmed
from assistant.cli.moving import NO_SPEED, Moving, moving
from assistant.cli.presentation import Format, print_findings, print_json, say
from assistant.program.diagnostics import Diagnostic, Refused, error

if TYPE_CHECKING:
    from assistant.compiler.shown_places import Place
    from assistant.compiler.teaching import Wanted
    from assistant.controllers import Named
    from assistant.controllers.following import Mode, Wishes
    from assistant.robots import Robot
    from assistant.vision.cameras.camera import Camera
    from assistant.vision.cameras.camera_file import Rig
    from assistant.vision.pointing.devices import Device
    from assistant.vision.pointing.holding import Held, Still
    from assistant.vision.pointing.locating import Limits
    from assistant.vision.pointing.tracking import Look

NO_CONTROLLER: Final = error(
    "CL510",
    "no controller of the project is named, and --go leads an arm",
    "name the controller as the first word",
)
NO_ROBOT: Final = error(
    "CL511",
    "no project says which robot `{name}` moves, so it is led nowhere",
    "write robot = NAME into its table in assistant.toml",
)
NOT_TOGETHER: Final = error("CL512", "{one} and {other} do not go together", "leave one of them")
NOT_CSV: Final = error(
    "CL513", "a stroke is written as a table, and `{name}` is none", "end its name in .csv"
)
THERE: Final = error("CL514", "`{name}` is there already", "name another file, or add --replace")
NO_COUNT: Final = error("CL515", "{option} is {value:g}", "write {cure}")
NO_MODE: Final = error("CL517", "no arm is led to a place by `{by}`", "choose one of {known}")


@dataclass(frozen=True, slots=True)
class Options:
    """cameras: file of cameras. use: names of those that look, () for all. device: name or file.
    frames: moments of a hold. rate: pictures a second of files. robot: named by hand. world: frame
    of the cameras in the file. stroke: a way instead of places, with waypoints each `step` mm.
    go: the arm is led to each place, by a mode, from `above` mm before it, at `speed` percent.
    """

    cameras: Path
    into: Path
    wanted: Wanted
    use: tuple[str, ...] = ()
    device: str = "wand"
    frames: int = 30
    rate: float = 30.0
    residual: float = 0.8
    fastest: float = 1500.0
    robot: str | None = None
    world: str | None = None
    stroke: bool = False
    step: float = 5.0
    go: bool = False
    by: str = "data-link"
    wishes: Wishes | None = None
    above: float = 50.0
    speed: float = 10.0
    yes: bool = False
    format: Format = Format.TEXT


def run_point(words: Sequence[str], on: str | None, now: bool, options: Options) -> int:
    """words: perhaps a controller, and names; without names p1, p2 … until the pictures end."""
    other = "--on" if on is not None else "--now" if now else None
    if other is not None:
        raise Refused(NOT_TOGETHER(one="--point", other=other), exit_status=2)
    from assistant.vision.cameras.camera_file import read_cameras
    from assistant.vision.pointing.device_file import device_of

    _check(options)
    one, names = _controller(words)
    rig = read_cameras(options.cameras)
    cameras = tuple(rig[name] for name in options.use or rig.cameras)
    shown = _Shown(rig, cameras, device_of(options.device), options)
    if options.go:
        if one is None:
            raise Refused(NO_CONTROLLER(), exit_status=2)
        return _led(words[0], names, shown)
    robot = _robot(one, options)
    if options.stroke:
        return _stroke(shown, robot)
    return _places(names, shown, robot)


def _check(options: Options) -> None:
    """Raises Refused for options that mean nothing."""
    least = (
        (options.frames, "--frames", 2, "a whole number from 2"),
        (options.rate, "--rate", 0.1, "pictures a second"),
        (options.residual, "--residual", 0.01, "pixels above 0"),
        (options.fastest, "--fastest", 1.0, "mm a second"),
        (options.step, "--step", 0.1, "mm from 0.1"),
    )
    for value, option, low, cure in least:
        if not low <= value < 1e6:
            raise Refused(NO_COUNT(option=option, value=value, cure=cure), exit_status=2)
    if not 0.0 <= options.above <= 500.0:
        cure = "0 to 500 mm"
        raise Refused(NO_COUNT(option="--above", value=options.above, cure=cure), exit_status=2)
    if not 0.0 < options.speed <= 100.0:
        raise Refused(NO_SPEED(value=options.speed), exit_status=2)
    if options.stroke:
        others = {"--go": options.go, "--world": options.world, "--joints": options.wanted.joints}
        wrong = next((name for name, given in others.items() if given), None)
        if wrong is not None:
            raise Refused(NOT_TOGETHER(one="--stroke", other=wrong), exit_status=2)
        if options.into.suffix.lower() != ".csv":
            raise Refused(NOT_CSV(name=options.into), exit_status=2)
        if options.into.exists() and not options.wanted.again:
            raise Refused(THERE(name=options.into))
    if options.go and options.robot is not None:
        raise Refused(NOT_TOGETHER(one="--go", other="--robot"), exit_status=2)


def _controller(words: Sequence[str]) -> tuple[Named | None, Sequence[str]]:
    """The first word is a controller if the project has one of that name, or it is an address."""
    if not words:
        return None, ()
    from assistant.controllers import controllers_of

    known = "://" in words[0] or words[0] in controllers_of(Path.cwd())
    return (named_by(words[0]), words[1:]) if known else (None, words)


def _robot(one: Named | None, options: Options) -> Robot | None:
    from assistant.compiler.arms import robot_of

    if options.robot is not None:
        return robot_of(options.robot)
    return None if one is None else robot_of_cell(one)


# ------------------------------------------------------------------------------- what is shown


@dataclass(slots=True)
class _Shown:
    """Places that come from cameras, and what was told of them meanwhile."""

    rig: Rig
    cameras: tuple[Camera, ...]
    device: Device
    options: Options
    good: int = 0
    count: int = 0
    reasons: Counter[str] = field(default_factory=Counter)

    @contextmanager
    def looks(self) -> Iterator[Iterator[Look]]:
        from assistant.vision.pointing.locating import check_cameras
        from assistant.vision.pointing.moments import moments
        from assistant.vision.pointing.tracking import tracked

        check_cameras(self.cameras)
        with moments(self.rig, self.cameras, self.options.rate, self.tell) as given:
            fastest = self.options.fastest
            looks = tracked(given, self.device, self.cameras, self.limits, fastest)
            yield self._counted(looks)

    def _counted(self, looks: Iterator[Look]) -> Iterator[Look]:
        for look in looks:
            self.count += 1
            if isinstance(look.seen, Diagnostic):
                self.reasons[look.seen.message] += 1
            else:
                self.good += 1
            yield look

    @contextmanager
    def holds(self) -> Iterator[Iterator[Held]]:
        from assistant.vision.pointing.holding import holds

        with self.looks() as looks:
            yield holds(looks, self.device, self.cameras, self.limits, self.still, self.tell)

    @property
    def still(self) -> Still:
        from assistant.vision.pointing.holding import Still

        return Still(self.options.frames)

    @property
    def limits(self) -> Limits:
        from assistant.vision.pointing.locating import Limits

        return Limits(residual=self.options.residual)

    def tell(self, finding: Diagnostic) -> None:
        sys.stdout.flush()
        print_findings([finding])

    def ended(self, name: str) -> Refused:
        """What to say when the pictures ended before something was shown."""
        from assistant.vision.pointing.rules import NOT_SHOWN

        most = self.reasons.most_common(1)
        mostly = f"; mostly {most[0][0]}" if most else ""
        return Refused(
            NOT_SHOWN(
                name=name,
                seen=self.good,
                count=self.count,
                mostly=mostly,
                frames=self.options.frames,
            )
        )


# ----------------------------------------------------------------------------- into the files


def _places(names: Sequence[str], shown: _Shown, robot: Robot | None) -> int:
    """Each place that is shown, as a target, until there are no names or no pictures any more."""
    from assistant.cli.teaching import free_names
    from assistant.compiler.shown_places import check_names, store

    options = shown.options
    check_names(options.into, names, robot, options.wanted)
    stored: list[dict[str, object]] = []
    with shown.holds() as holds:
        for name in names or free_names(options.into):
            found = _next(name, holds, shown, robot)
            if found is None:
                if names or not stored:
                    raise shown.ended(name)
                break
            held, place = found
            store(options.into, place, options.wanted)
            stored.append(_record(held, place))
            if options.format is Format.TEXT:
                say(f"{name}: {_said(place)}, {_sureness(held)}, stored in {options.into}")
                sys.stdout.flush()
    if options.format is Format.JSON:
        print_json({"file": str(options.into), "device": shown.device.name, "stored": stored})
    return 0


def _next(
    name: str,
    holds: Iterator[Held],
    shown: _Shown,
    robot: Robot | None,
    near: Sequence[float] | None = None,
) -> tuple[Held, Place] | None:
    """The next place that is shown and reached; None when there are no pictures any more."""
    import numpy as np

    from assistant.compiler.shown_places import OUT_OF_REACH, TILTED, placed

    options = shown.options
    if options.format is Format.TEXT:
        say(f"{name}: hold the {shown.device.name} still; Ctrl-C ends")
        sys.stdout.flush()
    start = None if near is None else np.array(near)
    for held in holds:
        try:
            place = placed(
                options.into, name, held.pose, robot, options.wanted, start, options.world
            )
        except Refused as refused:
            if not {f.code for f in refused.findings} <= {OUT_OF_REACH.code, TILTED.code}:
                raise
            print_findings(refused.findings)
            continue
        print_findings(place.findings)
        return held, place
    return None


def _said(place: Place) -> str:
    x, y, z = place.pose.position
    q = ", ".join(f"{part:.5f}" for part in place.pose.quaternion)
    return f"x {x:.2f}  y {y:.2f}  z {z:.2f} mm  quaternion ({q})"


def _sureness(held: Held) -> str:
    return f"{held.frames} moments within {held.spread:.2f} mm, mean known to {held.sigma:.2f} mm"


def _record(held: Held, place: Place) -> dict[str, object]:
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


def _stroke(shown: _Shown, robot: Robot | None) -> int:
    """The way between two holds, as a table of waypoints."""
    from dataclasses import replace

    from assistant.compiler.shown_places import turned_into_plane
    from assistant.program.system.writing import write_files
    from assistant.vision.pointing.strokes import Smoothing, strokes

    options = shown.options
    if options.format is Format.TEXT:
        say(f"hold the {shown.device.name} still, lead it along the way, and hold it still again")
        sys.stdout.flush()
    smoothing = Smoothing(options.step)
    with shown.looks() as looks:
        ways = strokes(
            looks, shown.device, shown.cameras, shown.limits, shown.still, smoothing, shown.tell
        )
        way = next(ways, None)
    if way is None:
        raise shown.ended("the stroke")
    turned = turned_into_plane(way.positions, way.quaternions, robot)
    table = replace(way, quaternions=turned).csv()
    write_files({options.into.name: table.encode("ascii")}, options.into.parent)
    if options.format is Format.JSON:
        print_json(
            {
                "file": str(options.into),
                "waypoints": len(way.positions),
                "length_mm": way.length,
                "scatter_mm": way.scatter,
            }
        )
    else:
        say(
            f"{len(way.positions)} waypoints along {way.length:.1f} mm, "
            f"what was seen {way.scatter:.2f} mm about them, stored in {options.into}"
        )
    return 0


# ----------------------------------------------------------------------------- leading the arm


def _led(cell: str, names: Sequence[str], shown: _Shown) -> int:
    """The arm is led to each place, and where it comes to rest is stored."""
    from assistant.cli.teaching import free_names
    from assistant.compiler.shown_places import check_names
    from assistant.controllers.following import MODES, Wishes

    options = shown.options
    if options.by not in MODES:
        known = ", ".join(MODES)
        raise Refused(NO_MODE(by=options.by, known=known), exit_status=2)
    mode, wishes = MODES[options.by], options.wishes or Wishes()
    stored: list[dict[str, object]] = []
    with moving(cell, "teach --go") as motion:
        there = motion.cell
        controller, robot = there.controller, robot_of_cell(there.one)
        if robot is None:
            raise Refused(NO_ROBOT(name=there.one.name), exit_status=2)
        mode.check(controller, wishes)
        check_names(options.into, names, robot, options.wanted)
        with shown.holds() as holds:
            for name in names or free_names(options.into):
                done = _one_led(name, holds, shown, motion, robot, mode, wishes)
                if done is None:
                    if names or not stored:
                        raise shown.ended(name)
                    break
                stored.append(done)
    if options.format is Format.JSON:
        answer = {"address": str(there.one.address), "file": str(options.into), "stored": stored}
        print_json(record(answer))
    return 0


def _one_led(
    name: str,
    holds: Iterator[Held],
    shown: _Shown,
    motion: Moving,
    robot: Robot,
    mode: Mode,
    wishes: Wishes,
) -> dict[str, object] | None:
    """Leads the arm to the next place and stores where it is then; None without a place."""
    from assistant.compiler.following import led_by
    from assistant.compiler.shown_places import check_reached, tip_at, way_to
    from assistant.compiler.teaching import own_joints, teach

    options, one = shown.options, motion.cell.one
    controller = motion.cell.controller
    found = _next(name, holds, shown, robot, own_joints(controller.position(), robot))
    if found is None:
        return None
    held, place = found
    position = controller.position()
    way = way_to(place, options.above)
    led = led_by(way, robot, position, mode.period, options.speed, str(options.into))
    print_findings(led.findings)
    what = f"leads the arm to `{name}` at {_said(place)}, {_sureness(held)}, {mode.title}"
    confirmed(one, what, options.yes)
    motion.began = True
    mode.run(controller, led, wishes, lambda _: None)
    position = controller.position()
    motion.began = False
    joints = own_joints(position, robot)
    off, turned = check_reached(place, tip_at(place, joints, robot))
    print_findings(teach(options.into, name, position, robot, options.wanted).findings)
    if options.format is Format.TEXT:
        shown_line = joints_line if options.wanted.joints else pose_line
        say(
            f"{name}: {shown_line(position)}, {off:.2f} mm and {turned:.2f} degrees from what was "
            f"shown, stored in {options.into}"
        )
        sys.stdout.flush()
    return {**_record(held, place), "reached": position, "off_mm": off, "off_degrees": turned}

"""`teach --point`: places and ways that somebody shows to cameras, into a file."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error
from assistant.cli.cells import named_by, robot_of_cell
from assistant.cli.moving import NO_SPEED
from assistant.cli.presentation import Format, print_json, say
from assistant.cli.shown import (
    PointingOptions,
    ShownPlaces,
    certainty,
    next_place,
    place_line,
    pointing_record,
)

if TYPE_CHECKING:
    from assistant.controllers import Named
    from assistant.robots import Robot

NO_CONTROLLER: Final = error(
    "CL510",
    "no controller of the project is named, and --go leads an arm",
    "name the controller as the first word",
)
NOT_TOGETHER: Final = error("CL512", "{one} and {other} do not go together", "leave one of them")
NOT_CSV: Final = error(
    "CL513", "a stroke is written as a table, and `{name}` is none", "end its name in .csv"
)
NO_ARM: Final = error("CL519", "--servo says how an arm is led, and none is", "add --go")
FILE_EXISTS: Final = error(
    "CL514", "`{name}` is there already", "name another file, or add --replace"
)
NO_COUNT: Final = error("CL515", "{option} is {value:g}", "write {cure}")


def run_point(words: Sequence[str], on: str | None, now: bool, options: PointingOptions) -> int:
    """words: perhaps a controller, and names; without names p1, p2 … until the pictures end."""
    other = "--on" if on is not None else "--now" if now else None
    if other is not None:
        raise Refused(NOT_TOGETHER(one="--point", other=other), exit_status=2)
    from assistant.vision.cameras.camera_file import read_cameras
    from assistant.vision.pointing.device_file import device_of

    _check_options(options)
    one, names = _split_controller(words)
    rig = read_cameras(options.cameras)
    cameras = tuple(rig[name] for name in options.use or rig.cameras)
    shown = ShownPlaces(rig, cameras, device_of(options.device), options)
    if options.go:
        if one is None:
            raise Refused(NO_CONTROLLER(), exit_status=2)
        from assistant.cli.pointing_arms import run_pointed_arm

        return run_pointed_arm(words[0], names, shown)
    robot = _robot_of(one, options)
    if options.stroke:
        return _store_stroke(shown, robot)
    return _store_places(names, shown, robot)


def _check_options(options: PointingOptions) -> None:
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
            raise Refused(FILE_EXISTS(name=options.into))
    if options.go and options.robot is not None:
        raise Refused(NOT_TOGETHER(one="--go", other="--robot"), exit_status=2)
    if options.servo is not None and not options.go:
        raise Refused(NO_ARM(), exit_status=2)


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


def _store_places(names: Sequence[str], shown: ShownPlaces, robot: Robot | None) -> int:
    """Each place that is shown, as a target, until there are no names or no pictures any more."""
    from assistant.cli.teaching import free_names
    from assistant.compiler.taught_targets import check_names, store_target

    options = shown.options
    check_names(options.into, names, robot, options.wanted)
    stored: list[dict[str, object]] = []
    with shown.holds() as holds:
        for name in names or free_names(options.into):
            found = next_place(name, holds, shown, robot)
            if found is None:
                if names or not stored:
                    raise shown.ended(name)
                break
            held, place = found
            store_target(options.into, place, options.wanted)
            stored.append(pointing_record(held, place))
            if options.format is Format.TEXT:
                say(f"{name}: {place_line(place)}, {certainty(held)}, stored in {options.into}")
                sys.stdout.flush()
    if options.format is Format.JSON:
        print_json({"file": str(options.into), "device": shown.device.name, "stored": stored})
    return 0


def _store_stroke(shown: ShownPlaces, robot: Robot | None) -> int:
    """The way between two holds, as a table of waypoints."""
    from dataclasses import replace

    from assistant.base.file_sets import write_files
    from assistant.compiler.taught_targets import turned_into_plane
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

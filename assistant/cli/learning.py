"""Learn a map from two camera pictures to joints: `learn`.

A table of errors is printed while the map learns; maps, curves and pictures of the lattice are
written in the end. Words such as `J1=-90:90` or `40x40x20` become ranges, boxes, lattices and
factors of link lengths, in degrees and mm.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeVar

from assistant.base.diagnostics import Refused, Rule, error
from assistant.cli.command import argument, command, option
from assistant.cli.options import FormatOption, complete_robot
from assistant.cli.presentation import Format, print_findings, print_json, say
from assistant.cli.source_input import keep_sources

if TYPE_CHECKING:
    from assistant.base.arrays import Floats
    from assistant.learning.experiments import Experiment, ExperimentSettings
    from assistant.learning.extended_map import ExtendedMap
    from assistant.learning.map_training import MapErrors, TrainingPlan
    from assistant.learning.observed_arm import Goals, ObservedArm
    from assistant.learning.observed_arm import ToolRule as Held
    from assistant.report.figures import LatticeStage
    from assistant.vision.cameras.camera import Camera


class ToolHold(StrEnum):
    """Orientation of the tool in a box; `free` leaves it open."""

    DOWN = "down"
    FORWARD = "forward"
    FREE = "free"


@command
class Learn:
    """Learn from two cameras which joints reach what they see, on this computer. Nothing moves."""

    robot: str = argument("A robot of the catalogue, or a robot file.", completions=complete_robot)
    output: Path = option("Map to write, .npz.", "--output", "-o")
    steps: int = option("Targets that are tried.", default=30_000, min=1, max=1_000_000)
    hold: tuple[str, ...] = option("Joint that stays; repeatable.", metavar="JOINT=DEGREES")
    range: tuple[str, ...] = option(
        "Degrees between which a joint learns; default 25 about its home; repeatable.",
        metavar="JOINT=LOW:HIGH",
    )
    box: str | None = option(
        "Targets in a box of the base, mm, each of them LOW:HIGH.", metavar="X,Y,Z"
    )
    tool: ToolHold | None = option(
        "How the tool is held in the box; free: only its place is learnt, and the "
        "posture nearest to the middle of the ranges."
    )
    turn: str = option(
        "Degrees of the held tool about its axis.", default="0:0", metavar="LOW:HIGH"
    )
    point: tuple[str, ...] = option(
        "Point of the tool that is seen, mm on the flange; repeatable.", metavar="X,Y,Z"
    )
    cameras: Path | None = option(
        "File of cameras that stand about the base; default a pair is put up."
    )
    lattice: str | None = option("Units along each axis of the lattice.", metavar="7x12x4")
    noise: float = option("Pixels of noise, one sigma.", default=0.0, min=0.0, max=100.0)
    seed: int = option("Of what is random.", default=0, min=0)
    go_on: Path | None = option("Map that goes on learning, .npz.")
    longer: tuple[str, ...] = option(
        "Link that is longer than the robot file says; repeatable.", metavar="LENGTH=FACTOR"
    )
    recorded: tuple[Path, ...] = option(
        "Learn from where an arm was: log of `explore`, `servo` or `monitor`; repeatable.",
        metavar="LOG.csv",
    )
    picture: Path | None = option("Draw the lattice at several stages, .png or .svg.")
    curve: Path | None = option("Errors over the steps, .csv, .png or .svg.")
    rivals: bool = option("Beside a calibrated pair of cameras and a regression.")
    format: FormatOption

    def run(self) -> int:
        from assistant.learning.experiments import experiment_of
        from assistant.learning.map_file import load_map, save_map
        from assistant.learning.map_training import (
            draw_test_goals,
            measure_errors,
            split_recording,
            train_and_measure,
            train_recorded,
        )

        _check_output_names(self)
        known = None if self.go_on is None else load_map(self.go_on)
        wanted = _learning_task(self)
        rows = _recorded_joints(wanted, self)
        if rows is not None:
            wanted = _task_in_recorded_ranges(wanted, rows, known)
        made = experiment_of(wanted, known)
        arm = made.arm
        for name, factor in _link_factors(self.longer):
            arm = arm.longer(name, factor)
        arm = arm.noisy(self.noise, self.seed)
        net = _initial_map(made, self) if known is None else known
        if rows is None:
            tests = draw_test_goals(arm, made.space, self.seed)
        else:
            rows, tests = split_recording(arm, rows[:, arm.columns])
        begun = net.steps
        stages: list[LatticeStage] = []
        curve: list[MapErrors] = []

        def watch(found: MapErrors) -> None:
            stages.append(_lattice_stage(net, found))
            curve.append(found)
            rate = (found.steps - begun) / found.seconds if found.seconds else 0.0
            _print_at_once(self, _error_row(f"{found.steps:>9,} {rate:>9,.0f}", found))

        for line in _table_head(net, arm, tests, recorded=rows is not None):
            _print_at_once(self, line)
        watch(_current_errors(net, arm, tests))
        if rows is None:
            train_and_measure(net, arm, made.space, _learning_plan(net, self), tests, watch)
        else:
            train_recorded(
                net,
                rows,
                arm(rows),
                _learning_plan(net, self),
                lambda seconds: watch(measure_errors(net, arm, tests, seconds)),
            )
        beside = dict(_rival_results(made, net, arm, tests, self))
        for name, found in beside.items():
            _print_at_once(self, _error_row(f"{name:>19}", found))
        files = _output_data(net, arm.task.cameras, curve, stages, tests, self)
        save_map(net, self.output, files)
        _print_result(net, arm, curve, beside, tests, [self.output, *files], self)
        return 0


_BAD_RANGE: Final = error(
    "CL521", "`{given}` is no range of a joint", "write JOINT=LOW:HIGH, as J1=-50:50"
)
_BAD_HOLD: Final = error("CL522", "`{given}` holds no joint", "write JOINT=DEGREES, as J5=0")
_BAD_BOX: Final = error(
    "CL523", "`{given}` is no box", "write LOW:HIGH,LOW:HIGH,LOW:HIGH, mm of x, y and z"
)
_BAD_POINT: Final = error("CL524", "`{given}` is no point", "write x,y,z in mm, as 0,0,60")
_BAD_LATTICE: Final = error("CL525", "`{given}` is no lattice", "write counts, as 7x12x4")
_BAD_FACTOR: Final = error(
    "CL526", "`{given}` makes no link longer", "write LENGTH=FACTOR, as a2=1.1, from 0.5 to 2"
)
_FEW_CAMERAS: Final = error(
    "CL527",
    "{count} of the cameras of {file} stand still, and two are needed",
    "name a file with two that stand about the robot; those in its hand do not count",
)
_BAD_TURN: Final = error(
    "CL528", "`{given}` is no range of turns", "write LOW:HIGH in degrees, the lower first"
)
_FARTHEST_COORDINATE: Final = 100_000.0
"""mm that a coordinate has at most: beyond, it is no place about a robot."""
_SHORTEST_LINK_FACTOR: Final = 0.5
_LONGEST_LINK_FACTOR: Final = 2.0
"""Times the length of a link."""
T = TypeVar("T")


_TOOL_RULES: Final[Mapping[ToolHold | None, Held]] = {
    None: "any",
    ToolHold.FREE: "any",
    ToolHold.DOWN: "down",
    ToolHold.FORWARD: "forward",
}


def _learning_task(options: Learn) -> ExperimentSettings:
    import numpy as np

    from assistant.compiler.arms import robot_of
    from assistant.learning.experiments import ExperimentSettings

    robot = robot_of(options.robot)
    assert robot is not None
    points = [_numbers_of(text, ",", 3, _BAD_POINT) for text in options.point]
    box = None
    if options.box is not None:
        box = box_of(options.box)
    low, high = _numbers_of(options.turn, ":", 2, _BAD_TURN)
    if not -360.0 <= low <= high <= 360.0:
        raise Refused(_BAD_TURN(given=options.turn), exit_status=2)
    return ExperimentSettings(
        robot,
        dict(_name_and_value(text, _number_or_none, _BAD_HOLD) for text in options.hold),
        np.array(points) if points else None,
        dict(map(range_of, options.range)),
        box,
        _TOOL_RULES[options.tool],
        (low, high),
        () if options.cameras is None else _fixed_cameras(options.cameras),
        options.tool is ToolHold.FREE,
    )


def box_of(text: str) -> Floats:
    """Return the box (3, 2) in mm of its words; raises Refused."""
    import numpy as np

    sides = text.split(",")
    if len(sides) != 3:
        raise Refused(_BAD_BOX(given=text), exit_status=2)
    return np.array([_numbers_of(side, ":", 2, _BAD_BOX, text) for side in sides])


def range_of(text: str) -> tuple[str, tuple[float, float]]:
    """Return a joint with the ends of its range; raises Refused."""
    return _name_and_value(text, _low_and_high, _BAD_RANGE)


def _fixed_cameras(file: Path) -> tuple[Camera, ...]:
    """Those that stand still, in the frame of the base."""
    from assistant.vision.cameras.camera import WORLD
    from assistant.vision.cameras.camera_file import read_cameras

    rig = read_cameras(file)
    still = tuple(one for one in rig.cameras.values() if one.parent == WORLD)
    if len(still) < 2:
        raise Refused(_FEW_CAMERAS(count=len(still), file=file), exit_status=2)
    return still


def _lattice_of(text: str) -> tuple[int, ...]:
    counts = text.lower().split("x")
    if not all(count.isascii() and count.isdigit() for count in counts):
        raise Refused(_BAD_LATTICE(given=text), exit_status=2)
    return tuple(int(count[:9]) for count in counts)


def _link_factors(texts: Sequence[str]) -> list[tuple[str, float]]:
    """Names of lengths with their factors."""
    found = [_name_and_value(text, _number_or_none, _BAD_FACTOR) for text in texts]
    for text, (_, factor) in zip(texts, found, strict=True):
        if not _SHORTEST_LINK_FACTOR <= factor <= _LONGEST_LINK_FACTOR:
            raise Refused(_BAD_FACTOR(given=text), exit_status=2)
    return found


def _name_and_value(text: str, value: Callable[[str], T | None], rule: Rule) -> tuple[str, T]:
    """NAME=VALUE."""
    name, equals, said = text.partition("=")
    found = value(said) if equals and name else None
    if found is None:
        raise Refused(rule(given=text), exit_status=2)
    return name, found


def _number_or_none(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _low_and_high(text: str) -> tuple[float, float] | None:
    low, _, high = text.partition(":")
    found = _number_or_none(low), _number_or_none(high)
    return None if found[0] is None or found[1] is None else (found[0], found[1])


def _numbers_of(text: str, mark: str, count: int, rule: Rule, whole: str = "") -> list[float]:
    parts = [_number_or_none(part) for part in text.split(mark)]
    if len(parts) != count or any(
        part is None or abs(part) > _FARTHEST_COORDINATE for part in parts
    ):
        raise Refused(rule(given=whole or text), exit_status=2)
    return [part for part in parts if part is not None]


_NOT_A_MAP_NAME: Final = error("CL520", "a map is not written as `{name}`", "end its name in .npz")
_NOT_A_CURVE_NAME: Final = error(
    "CL529",
    "a curve is not written as `{name}`",
    "end its name in .csv, .png or .svg, and not in that of the picture",
)
_BOX_TWICE: Final = error(
    "CL299",
    "--box and --recorded both state where the targets are",
    "leave one of them out",
)
_HOLD_TOLERANCE: Final = 0.5
"""Most degrees (mm) that a held joint may be off in a recording."""
_RANGE_MARGIN: Final = 0.5
"""Degrees (mm) by which the learnt ranges are wider than the recorded ones."""
_PICTURED_STAGES: Final = 4
"""Columns of the picture of the lattice."""
_LARGEST_UNUSED_SHARE: Final = 0.02
"""Share of units that may never have won."""
_TEST_NOISE: Final = 0.2
"""Pixels with which a map is measured as well that has learnt without."""


def _recorded_joints(asked: ExperimentSettings, options: Learn) -> Floats | None:
    """Return the joints (n, a) of recordings with held joints in place; None without recordings."""
    import numpy as np

    from assistant.cell.exploration.recordings import read_recording

    if not options.recorded:
        return None
    if options.box is not None:
        raise Refused(_BOX_TWICE(), exit_status=2)
    robot = asked.robot
    runs: list[Floats] = []
    for path in options.recorded:
        recording = read_recording(path, robot)
        print_findings(recording.findings)
        runs += recording.runs
    rows = np.concatenate([np.zeros((0, len(robot.axes))), *runs])
    for axis, value in asked.held.items():
        if axis in robot.axes:
            rows = rows[np.abs(rows[:, robot.axes.index(axis)] - value) <= _HOLD_TOLERANCE]
    return np.asarray(rows)


def _task_in_recorded_ranges(
    asked: ExperimentSettings, rows: Floats, net: ExtendedMap | None
) -> ExperimentSettings:
    """Return the task in the recorded ranges, where none are stated or learnt already."""
    import numpy as np

    if net is not None or not len(rows):
        return asked
    low, high = rows.min(axis=0) - _RANGE_MARGIN, rows.max(axis=0) + _RANGE_MARGIN
    ends = np.clip(np.stack([low, high]), *asked.robot.limits.T)
    found = {
        axis: (float(ends[0, i]), float(ends[1, i]))
        for i, axis in enumerate(asked.robot.axes)
        if axis not in asked.held
    }
    return replace(asked, ranges=found | dict(asked.ranges))


def _current_errors(net: ExtendedMap, arm: ObservedArm, tests: Goals) -> MapErrors:
    from assistant.learning.map_training import measure_errors

    return measure_errors(net, arm, tests)


def _print_at_once(options: Learn, line: str) -> None:
    """At once, as it takes its time."""
    if options.format is Format.TEXT:
        say(line)
        sys.stdout.flush()


def _table_head(
    net: ExtendedMap, arm: ObservedArm, tests: Goals, *, recorded: bool
) -> Iterator[str]:
    from assistant.learning.map_training import TEST_GOALS

    share = 0.0 if recorded else 1.0 - len(tests.pixels) / TEST_GOALS
    hidden = f", {share:.0%} of them hidden" if share else ""
    yield (
        f"{arm.robot.title}: {', '.join(arm.moves)}; {net.units:,} units, {net.task.seen} numbers "
        f"a picture, targets within {tests.diagonal:.0f} mm{hidden}"
    )
    columns = ("steps", "a second", "mean mm", "worst mm", "mean deg", "worst deg")
    yield " ".join(f"{column:>9}" for column in columns)


def _print_result(
    net: ExtendedMap,
    arm: ObservedArm,
    curve: Sequence[MapErrors],
    beside: Mapping[str, MapErrors],
    tests: Goals,
    written: Sequence[Path],
    options: Learn,
) -> None:
    from assistant.findings.formats import records_of
    from assistant.learning.map_training import measure_overrun
    from assistant.learning.rules import BEYOND_RANGES, UNITS_WITHOUT_WINS

    left, path = float((net.wins == 0.0).mean()), str(written[0])
    findings = [UNITS_WITHOUT_WINS(share=left, path=path)] if left > _LARGEST_UNUSED_SHARE else []
    if net.task.free:
        found = measure_overrun(net, arm, tests)
        if found.share:
            findings.append(
                BEYOND_RANGES(
                    share=found.share,
                    where=found.where,
                    worst=found.worst_mm,
                    rest=found.rest_mm,
                    path=path,
                )
            )
    if options.format is Format.JSON:
        answer: dict[str, object] = {"units": net.units, "workspace_mm": tests.diagonal}
        answer |= {"curve": [_error_record(one) for one in curve]}
        answer |= {"beside": {name: _error_record(found) for name, found in beside.items()}}
        answer |= {"written": [str(one) for one in written]}
        print_json(answer | {"findings": records_of(findings)})
        return
    print_findings(findings)
    say(f"wrote {', '.join(str(one) for one in written)}")


def _check_output_names(options: Learn) -> None:
    from assistant.report.figures import format_of

    if options.output.suffix.lower() != ".npz" or not options.output.stem:
        raise Refused(_NOT_A_MAP_NAME(name=options.output), exit_status=2)
    if options.picture is not None:
        format_of(options.picture.name)
    curve, picture = options.curve, options.picture
    same = curve is not None and picture is not None and curve.resolve() == picture.resolve()
    if curve is not None and (same or curve.suffix.lower() not in {".csv", ".png", ".svg"}):
        raise Refused(_NOT_A_CURVE_NAME(name=options.curve), exit_status=2)
    read = [str(one) for one in (options.cameras, Path(options.robot)) if one is not None]
    read += [str(one) for one in options.recorded]
    keep_sources(read, [one for one in (options.output, options.picture, options.curve) if one])


def _initial_map(made: Experiment, options: Learn) -> ExtendedMap:
    from assistant.learning.map_training import start_map_with_shape

    if options.lattice is None:
        return made.start(options.seed)
    shape = _lattice_of(options.lattice)
    return start_map_with_shape(shape, made.arm, made.space, made.ranges, options.seed)


def _learning_plan(net: ExtendedMap, options: Learn) -> TrainingPlan:
    from assistant.learning.extended_map import first_cooling, relearning_cooling
    from assistant.learning.map_training import MEASURED_STEPS, TrainingPlan

    again = options.go_on is not None
    cooling = (relearning_cooling if again else first_cooling)(options.steps, options.noise)
    marks = tuple(net.steps + mark for mark in MEASURED_STEPS if mark < options.steps)
    return TrainingPlan(options.steps, cooling, marks=marks, seed=options.seed + net.steps)


def _rival_results(
    made: Experiment, net: ExtendedMap, arm: ObservedArm, tests: Goals, options: Learn
) -> Iterable[tuple[str, MapErrors]]:
    """The map with noise, and the rivals without and with it."""
    from assistant.learning.experiments import CalibratedBaseline, baseline_errors, nearest_baseline
    from assistant.learning.map_training import goals_with_noise, measure_errors

    noise = options.noise or _TEST_NOISE
    blurred, seen = arm.noisy(noise, options.seed + 5), goals_with_noise(tests, noise, options.seed)
    yield f"{noise:g} px of noise", measure_errors(net, blurred, seen)
    if not options.rivals:
        return
    clear = arm.noisy(0.0)
    calibrated = CalibratedBaseline(made.arm.noisy(0.0), made.ranges)
    nearest = nearest_baseline(arm, made.ranges, 2 * options.steps, tests, options.seed)
    for name, rival in (("calibrated pair", calibrated), ("regression", nearest)):
        yield name, baseline_errors(rival, clear, tests)
        yield f"{name[:10]}, noise", baseline_errors(rival, blurred, seen)


def _error_row(head: str, found: MapErrors) -> str:
    mm = f"{_short_number(found.mm):>9} {_short_number(found.worst_mm):>9}"
    if math.isnan(found.degrees):
        return f"{head} {mm}"
    return f"{head} {mm} {_short_number(found.degrees):>9} {_short_number(found.worst_degrees):>9}"


def _short_number(value: float) -> str:
    return f"{value:.3f}" if value < 100.0 else f"{value:.1f}"


def _error_record(found: MapErrors) -> dict[str, float | int | None]:
    return {
        "steps": found.steps,
        "seconds": found.seconds,
        "mean_mm": found.mm,
        "worst_mm": found.worst_mm,
        "mean_deg": None if math.isnan(found.degrees) else found.degrees,
        "worst_deg": None if math.isnan(found.worst_degrees) else found.worst_degrees,
        "coarse_mm": found.coarse,
    }


def _lattice_stage(net: ExtendedMap, found: MapErrors) -> LatticeStage:
    from assistant.report.figures import LatticeStage

    return LatticeStage(found.steps, net.scale.pixels(net.places), found.mm)


def _output_data(
    net: ExtendedMap,
    cameras: Sequence[str],
    curve: Sequence[MapErrors],
    stages: Sequence[LatticeStage],
    tests: Goals,
    outputs: Learn,
) -> dict[Path, bytes]:
    """Return the files requested beside the map: a picture of the lattice and the error curve."""
    import numpy as np

    from assistant.base.arrays import evenly_spaced
    from assistant.report import figures as report
    from assistant.report.figures import format_of

    files: dict[Path, bytes] = {}
    if outputs.picture is not None:
        chosen = evenly_spaced(len(stages), _PICTURED_STAGES)
        some, kind = [stages[at] for at in chosen], format_of(outputs.picture.name)
        drawn = report.lattice_picture(some, net.shape, tests.pixels, cameras, kind)
        files[outputs.picture] = drawn
    if outputs.curve is not None:
        steps = [one.steps for one in curve]
        mm = np.array([(one.mm, one.worst_mm) for one in curve])
        degrees = np.array([(one.degrees, one.worst_degrees) for one in curve])
        if outputs.curve.suffix.lower() == ".csv":
            files[outputs.curve] = report.curve_csv(steps, mm, degrees)
        else:
            kind = format_of(outputs.curve.name)
            files[outputs.curve] = report.curve_picture(steps, mm, degrees, kind)
    return files

"""The times of `simulate` beside published picking cycles: `python -m benchmarks.picking`.

A picking cycle is 25 mm up, 300 mm across, 25 mm down, and back, as fast as the arm goes, with
the tool downwards. The model runs it on lines at several places, stopping at all targets, and
rounding the upper ones by 25 mm; the latter also with the 0.1 s to full speed of other arms.

The published cycles are the makers' data sheets by memory; no copy of them was at hand.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from assistant import robots
from assistant.program.expressions import TargetValue
from assistant.program.geometry import BASE, FLANGE, Pose, Target
from assistant.program.motion import FINE, MAXIMUM_SPEED, Blend
from assistant.program.program import Procedure, Program
from assistant.program.statements import Motion, Move
from assistant.robots import Robot
from assistant.robots.timing import simulate

PUBLISHED: Final = {
    "irb120-3-0.58": (0.58, 1.0),
    "irb1200-7-0.7": (0.42, 1.0),
    "irb1200-5-0.9": (0.42, 1.0),
    "irb140-6-0.81": (0.85, 5.0),
    "rv-4frl": (0.36, 1.0),
}
"""Robot → seconds of a cycle there and back, kg that it carries; unconfirmed."""

UP: Final = 25.0
ACROSS: Final = 300.0
CASES: Final = (("fine", 0.0, False), ("25 mm", 25.0, False), ("25 mm, 0.1 s", 25.0, True))
"""What is printed: corners, their mm, and whether the arm counts with the time of unknown ones."""
REACHES: Final = (0.55, 0.65, 0.75)
HEIGHTS: Final = (0.15, 0.3)
"""Parts of the reach of a robot at which the cycle is run."""


def cycle_seconds(robot: Robot, centre: tuple[float, float], rounded: float) -> float | None:
    """Seconds of one cycle, None if the arm cannot run it there.

    centre: mm in front of and above the robot's base. rounded: mm at the upper targets.
    """
    x, z = centre
    half = ACROSS / 2.0
    corners = [(-half, 0.0), (-half, UP), (half, UP), (half, 0.0)]
    places = [*corners[1:], *corners[2::-1]]
    body = [_move("joint", x, *corners[0], z, 0.0)]
    body += [_move("linear", x, y, up, z, rounded if up else 0.0) for y, up in places]
    program = Program("cycle", (Procedure("main", tuple(body)),), robot=robot.name)
    solution = robots.solve_program(program, robot)
    if any(finding.severity == "error" for finding in solution.findings):
        return None
    done = simulate(solution)
    return float(done.moves.seconds[1:].sum())


def _move(kind: str, x: float, y: float, up: float, z: float, rounded: float) -> Move:
    pose = Pose((x, y, z + up), (0.0, 0.0, 1.0, 0.0))
    motion = Motion(MAXIMUM_SPEED, Blend(rounded) if rounded else FINE, FLANGE, BASE)
    return Move("joint" if kind == "joint" else "linear", TargetValue(Target(pose)), motion)


def ratios(name: str, rounded: float, *, usual: bool = False) -> list[float]:
    """Modelled by published seconds, at each place that the arm reaches.

    usual: with the time to speed of arms of which nothing is known.
    """
    robot = robots.get(name)
    if usual:
        robot = replace(robot, accelerations=None, time_to_speed=None)
    seconds, _ = PUBLISHED[name]
    return [s / seconds for place in _places(robot) if (s := cycle_seconds(robot, place, rounded))]


def _places(robot: Robot) -> Iterator[tuple[float, float]]:
    for reach in REACHES:
        for height in HEIGHTS:
            yield reach * robot.reach, height * robot.reach


def main() -> None:
    head = f"{'robot':<15}{'published s':>12}{'kg':>4}  {'upper corners':<15}"
    print(f"{head}{'median':>7}{'least':>7}{'most':>7}")
    for name, (seconds, load) in PUBLISHED.items():
        for corners, rounded, usual in CASES:
            found = ratios(name, rounded, usual=usual)
            figures = "".join(f"{f(found):>7.2f}" for f in (np.median, min, max))
            print(f"{name:<15}{seconds:>12.2f}{load:>4g}  {corners:<15}{figures}")


if __name__ == "__main__":
    main()

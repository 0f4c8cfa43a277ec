"""The times of `simulate` for seams beside bounds of their own: `python -m benchmarks.seams`.

A seam is a long way at a programmed speed. No arm is quicker than its way by that speed, where the
way is measured on corners that are cut along parabolas, point by point; and at each end it takes
some time to come to the speed. The bound holds both, with an acceleration of the tool that is
given; so it knows nothing of the axes, and shares nothing with the model but the parabola.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant import robots
from assistant.program.motion import FINE, Blend, Kind, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow
from assistant.robots import Robot
from assistant.robots.timing import simulate

ROBOTS: Final = ("irb120-3-0.58", "irb1200-7-0.7", "irb1600-6-1.2", "rv-4frl")
SPEEDS: Final = (10.0, 50.0, 200.0, 500.0)
ZONE: Final = 5.0
ACCELERATION: Final = 5000.0
"""mm/s² of the tool, in the model and in the bound."""
DOWN: Final = (0.0, 0.0, 1.0, 0.0)

Shape = tuple[np.ndarray, float]
"""Points (n, 3) about the middle, and mm of the zone at the inner ones."""


def _shapes() -> dict[str, Shape]:
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    zigzag = np.stack([np.where(np.arange(11) % 2, 40.0, -40.0), np.linspace(-120, 120, 11)], 1)
    wave = np.linspace(-120.0, 120.0, 481)
    flat = {
        "line of 240 mm": (np.array([[0.0, -120.0], [0.0, 120.0]]), 0.0),
        "rectangle, z5": (np.array([[-40, -90], [40, -90], [40, 90], [-40, 90], [-40, -80]]), ZONE),
        "zigzag, z5": (zigzag, ZONE),
        "circle of 360 points": (50.0 * np.stack([np.cos(turn), np.sin(turn)], 1), 0.3),
        "wave of 480 points": (np.stack([15.0 * np.sin(wave / 12.0), wave], 1), 0.2),
    }
    return {k: (np.column_stack([p, 0 * p[:, 0]]).astype(float), z) for k, (p, z) in flat.items()}


SHAPES: Final = _shapes()


def estimate(robot: Robot, shape: Shape, speed: float) -> float:
    """Seconds of the model."""
    points, zone = shape
    start = np.array([0.6 * robot.reach, 0.0, 0.35 * robot.reach])
    inner = [0, *[1 if zone else 0] * (len(points) - 2), 0]
    path = Path.of(
        "seam",
        start + points,
        [DOWN] * len(points),
        kinds=[Kind.JOINT, *[Kind.LINEAR] * (len(points) - 1)],  # type: ignore[list-item]
        speeds=[Speed(speed)],
        blends=[FINE, Blend(zone or 1.0)],
        blend=inner,
    )
    program = Program("seam", (Procedure("main", (Follow(path),)),))
    done = simulate(robots.solve_program(program, robot), acceleration=ACCELERATION)
    return float(done.moves.seconds[1:].sum())


def way(shape: Shape, places: int = 1001) -> float:
    """mm, with each inner corner measured along its parabola."""
    points, zone = shape
    sides = np.diff(points, axis=0)
    lengths = np.linalg.norm(sides, axis=1)
    total = float(lengths.sum())
    u = np.linspace(0.0, 1.0, places)[:, None]
    for i in range(len(points) - 2):
        z = min(zone, lengths[i] / 2.0, lengths[i + 1] / 2.0)
        first, last = -z * sides[i] / lengths[i], z * sides[i + 1] / lengths[i + 1]
        curve = (1.0 - u) ** 2 * first + u**2 * last
        total += float(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum()) - 2.0 * z
    return total


def bound(shape: Shape, speed: float) -> float:
    """Seconds at least: the way at the speed, and coming to it and from it."""
    return way(shape) / speed + speed / ACCELERATION


def ratios(name: str, shape: str, speed: float) -> float:
    """Estimate by bound."""
    return estimate(robots.get(name), SHAPES[shape], speed) / bound(SHAPES[shape], speed)


def main() -> None:
    print(f"{'seam':<22}" + "".join(f"{speed:>15g} mm/s" for speed in SPEEDS))
    for shape in SHAPES:
        line = f"{shape:<22}"
        for speed in SPEEDS:
            found = [ratios(name, shape, speed) for name in ROBOTS]
            line += f"{f'{min(found):.3f} to {max(found):.3f}':>20}"
        print(line)


if __name__ == "__main__":
    main()

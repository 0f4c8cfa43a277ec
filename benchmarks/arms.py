"""Cases: poses of arms and their joints beside roboticstoolbox; many targets checked and timed.

The toolbox solves a sample of the same poses, and gives one answer a pose where `ik` gives every
arm branch.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np

from assistant import checks, robots
from assistant.base import rotations
from assistant.program.motion import Blend, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow
from assistant.robots import Robot, SolvedProgram
from assistant.robots.timing import simulate
from benchmarks.reading import Reading

ARMS: Final = ("irb1200-7-0.7", "rv-4frl", "rv-2aj", "rh-6frh5520")
TOOLBOX_ARM: Final = ARMS[0]
POSES: Final = 200_000
SAMPLE: Final = 1_000
"""Poses that the toolbox solves: one at a time, so that a million would take hours."""
TARGETS: Final = 1_000_000
ROW: Final = 1_000
"""Targets of one line of the surface that is scanned."""
START: Final = np.array([350.0, -200.0, 250.0])
AREA: Final = np.array([200.0, 400.0])
DOWN: Final = np.array([0.0, 0.0, 1.0, 0.0])


def joints(name: str) -> Callable[[int], tuple[Robot, np.ndarray]]:
    """Joints (n, a) anywhere inside the limits, the same ones at each run."""

    def prepare(n: int) -> tuple[Robot, np.ndarray]:
        arm = robots.get(name)
        low, high = arm.limits.T
        return arm, np.random.default_rng(1).uniform(low, high, (n, len(low)))

    return prepare


def flanges(name: str) -> Callable[[int], tuple[Robot, np.ndarray, np.ndarray]]:
    def prepare(n: int) -> tuple[Robot, np.ndarray, np.ndarray]:
        arm, angles = joints(name)(n)
        return arm, *arm.fk(angles)

    return prepare


def forward(given: tuple[Robot, np.ndarray]) -> None:
    arm, angles = given
    arm.fk(angles)


def inverse(given: tuple[Robot, np.ndarray, np.ndarray]) -> None:
    """Every branch of every pose, each proven by forward kinematics."""
    arm, positions, quaternions = given
    _, valid = arm.ik(positions, quaternions)
    if not valid.any(axis=1).all():
        raise SystemExit("a pose of joints inside the limits has no joints")


def toolbox_joints(n: int) -> tuple[Any, np.ndarray]:
    arm, angles = joints(TOOLBOX_ARM)(n)
    return arm.to_rtb().ets(), np.radians(angles)  # which the toolbox computes in C


def toolbox_flanges(n: int) -> tuple[Any, np.ndarray]:
    model, angles = toolbox_joints(n)
    return model, model.eval(angles)


def toolbox_forward(given: tuple[Any, np.ndarray]) -> None:
    model, angles = given
    model.eval(angles)


def toolbox_inverse(given: tuple[Any, np.ndarray]) -> None:
    """One answer a pose by its numerical solver, which searches again from other joints."""
    model, poses = given
    for pose in poses:
        model.ik_LM(pose)


def surface(n: int) -> tuple[Robot, Program]:
    """A tool that goes over a surface in lines, to and fro, and tilts a little as it goes."""
    at = np.arange(n)
    line, along = np.divmod(at, ROW)
    along = np.where(line % 2, ROW - 1 - along, along) / max(ROW - 1, 1)
    across = line / max(int(line[-1]), 1)
    positions = START + np.stack([AREA[0] * across, AREA[1] * along, 20.0 * np.sin(6.0 * along)], 1)
    tilt = np.radians(5.0) * np.sin(3.0 * along)
    turned = np.stack([np.cos(tilt), np.sin(tilt), 0.0 * tilt, 0.0 * tilt], 1)
    quaternions = rotations.multiply(turned, DOWN)
    path = Path.of("scan", positions, quaternions, speeds=[Speed(150.0)], blends=[Blend(0.1)])
    return robots.get("irb1200-7-0.7"), Program("scan", (Procedure("main", (Follow(path),)),))


def checked(given: tuple[Robot, Program]) -> None:
    """Reach, limits, branches and turns over the whole path, and every rule about the way."""
    arm, program = given
    travelled = robots.solve_program(program, arm)
    if travelled.findings:
        raise SystemExit(f"findings about sound targets: {travelled.findings[:3]}")
    checks.with_robot(travelled)


def travelled(n: int) -> SolvedProgram:
    arm, program = surface(n)
    return robots.solve_program(program, arm)


def timed(solution: SolvedProgram) -> None:
    """Joints, speeds and times along the whole path."""
    done = simulate(solution)
    if done.unknown or len(done.moves) != len(done.moves.seconds.nonzero()[0]):
        raise SystemExit("a target has no time")


ROBOTS: Final[dict[str, Reading]] = {
    **{f"FK, {name}": Reading((joints(name), forward), (POSES,), "poses") for name in ARMS},
    f"FK, {TOOLBOX_ARM}, roboticstoolbox": Reading(
        (toolbox_joints, toolbox_forward), (SAMPLE,), "poses"
    ),
    **{
        f"IK, all branches, {name}": Reading((flanges(name), inverse), (POSES,), "poses")
        for name in ARMS
    },
    f"IK, one answer, {TOOLBOX_ARM}, roboticstoolbox": Reading(
        (toolbox_flanges, toolbox_inverse), (SAMPLE,), "poses"
    ),
    f"whole check, {TOOLBOX_ARM}": Reading((surface, checked), (TARGETS,), "targets checked"),
    f"cycle time, {TOOLBOX_ARM}": Reading((travelled, timed), (TARGETS,), "targets timed"),
}

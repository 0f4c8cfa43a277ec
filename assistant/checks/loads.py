"""Tools that no controller accepts, or that the arm cannot carry."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from assistant.base.diagnostics import Declared, Diagnostic, warning
from assistant.checks.views import ProgramView
from assistant.robots.programming import has

NO_MASS: Final = warning(
    "CK331",
    "the tool `{name}` weighs nothing: an ABB controller stops at the first move with it "
    "(undefined load, 41439)",
    "state its mass in kg and its centre of gravity; 0.001 kg is the least that counts",
)
TOO_HEAVY: Final = warning(
    "CK332",
    "the tool `{name}` weighs {mass:g} kg, {robot} carries {payload:g} kg",
    "look whether kg were meant, or take a lighter tool or another robot",
)


def loads(view: ProgramView) -> Iterator[Diagnostic]:
    """Of tools that the program moves; what weight is not known is not told of."""
    robot = view.robot
    for name, tool in view.solution.tools.items():
        if not tool.held or tool.load is None:
            continue
        mass = tool.load.mass
        about = Declared(name, "tools", in_full=True)
        if not mass > 0.0 and has(robot, "stops-without-mass"):
            yield NO_MASS(name=name, about=about)
        elif robot.payload is not None and mass > robot.payload:
            yield TOO_HEAVY(
                name=name,
                mass=mass,
                robot=robot.title,
                payload=robot.payload,
                about=about,
            )

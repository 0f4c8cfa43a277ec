"""The picture of docs/seen-frames.md: one program, its frame where an object is seen."""

from __future__ import annotations

import io
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import numpy as np

from assistant import robots
from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.compiler.simulated_run import programs
from assistant.program.geometry import Pose
from assistant.sources.sights import Seeing, Sight
from assistant.virtual.events import Moved
from assistant.virtual.kernel.kernel import Instant
from assistant.virtual.program_run import Settings, prepared

PROGRAM: Final = Path(__file__).parent.parent / "samples" / "seen" / "seam.pseudo"
USUAL: Final = (320.0, 0.0, 200.0, 0.0)
"""x, y, z in mm and degrees about z, as the program declares it."""
SEEN: Final = (
    (312.0, 150.0, 201.0, -40.0),
    (335.0, 18.0, 203.0, 30.0),
    (370.0, -105.0, 200.0, 80.0),
)
OUTLINE: Final = np.array([[-8.0, -8.0], [56.0, -8.0], [56.0, 68.0], [28.0, 68.0], [-8.0, 24.0]])
"""Of the bracket, in its frame."""


def picture() -> bytes:
    """The way of the nozzle for three sights, beside that for the usual place; PNG."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.5, 3.0), layout="constrained")
    axes = figure.add_subplot(aspect="equal", xlabel="y, mm", ylabel="x, mm")
    axes.invert_xaxis()  # as who stands behind the robot sees it
    for number, place in enumerate((USUAL, *SEEN)):
        usual = number == 0
        colour = "0.6" if usual else f"C{number - 1}"
        outline = np.vstack([_outline(place), _outline(place)[:1]])
        axes.fill(*outline.T[::-1], color=colour, alpha=0.12)
        axes.plot(*outline.T[::-1], color=colour, linestyle=":" if usual else "-", linewidth=1.0)
        way = _way(place)
        line, told = ("--", "usual place") if usual else ("-", f"sight {number}")
        axes.plot(*way[1:4, 1::-1].T, color=colour, linestyle=line, linewidth=2.5, label=told)
    figure.legend(loc="outside right upper")
    figure.suptitle("The glue line of one program, where the bracket is seen")
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=120)
    return drawn.getvalue()


def _pose(place: tuple[float, float, float, float]) -> Pose:
    x, y, z, turn = place
    return Pose.of(np.array([x, y, z]), rotations.from_euler((turn, 0.0, 0.0), "ZYX"))


def _outline(place: tuple[float, float, float, float]) -> Floats:
    pose = _pose(place)
    corners = np.column_stack([OUTLINE, np.zeros(len(OUTLINE))])
    return np.asarray(pose.moved(corners)[:, :2])


def _way(place: tuple[float, float, float, float]) -> Floats:
    """(n, 3) mm: where the tip of the nozzle comes to in a run of the program."""
    sight = Sight("bracket", _pose(place), 0.15, 0.1, 0.98, datetime.now(UTC))
    made = programs([str(PROGRAM)], seeing=Seeing({"bracket": sight}))
    arm = robots.get("rv-4frl")
    run = prepared(made, Settings(robot=arm, motion=Instant())).run()
    tips = [one.flange @ one.tool for one in run.events if isinstance(one, Moved) and one.flange]
    return np.array([tip.position for tip in tips])

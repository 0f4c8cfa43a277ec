"""Pictures of a map that learns: its lattice as a camera would see it, and its errors."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.report.figures import new_figure, picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LINK_COLOURS: Final = ("#20639b", "#c0392b", "#3c8d5a")
"""Of links along the first three axes of a lattice."""
GOAL_COLOUR: Final = "#c9ced3"


@dataclass(frozen=True, slots=True, eq=False)
class LatticeStage:
    """After so many steps: pixels (n, d) of the units, u and v of each camera for the first point
    of the tool in front. mm: mean error.
    """

    steps: int
    pixels: Floats
    mm: float


def lattice_picture(
    stages: Sequence[LatticeStage],
    shape: tuple[int, ...],
    goals: Floats,
    cameras: Sequence[str],
    format: str = "png",
) -> bytes:
    """A row a camera, a column a stage; goals (m, d) pixels lie behind as dots.

    Of a lattice of more than three axes the middle of the others is drawn. Raises Refused, naming
    the extra, without matplotlib.
    """
    from matplotlib.collections import LineCollection

    count = len(cameras)
    drawn = new_figure(2.6 * len(stages), 2.3 * count)
    rows = drawn.subplots(count, len(stages), squeeze=False, sharex="row", sharey="row")
    links = _lattice_links(shape)
    for i, name in enumerate(cameras):
        for axes, stage in zip(rows[i], stages, strict=True):
            at = stage.pixels[:, 2 * i : 2 * i + 2]
            axes.plot(*goals[:, 2 * i : 2 * i + 2].T, ".", color=GOAL_COLOUR, markersize=1.5)
            for pairs, colour in zip(links, LINK_COLOURS, strict=False):
                axes.add_collection(LineCollection(list(at[pairs]), colors=colour, linewidths=0.5))
            axes.set_aspect("equal")
            axes.tick_params(labelsize=7)
            if i == 0:
                axes.set_title(f"{stage.steps:,} steps: {stage.mm:.3g} mm", fontsize=9)
        _picture_limits(rows[i][0], goals[:, 2 * i : 2 * i + 2], name)
    return picture(drawn, format)


def curve_picture(steps: Sequence[int], mm: Floats, degrees: Floats, format: str = "png") -> bytes:
    """Mean and worst errors (n, 2) over steps, degrees NaN where only places count."""
    drawn = new_figure(6.4, 4.0)
    axes = drawn.subplots()
    axes.plot(steps, mm[:, 0], "o-", color=LINK_COLOURS[0], label="mean, mm")
    axes.plot(steps, mm[:, 1], "o:", color=LINK_COLOURS[0], label="worst, mm")
    if np.isfinite(degrees).any():
        axes.plot(steps, degrees[:, 0], "s-", color=LINK_COLOURS[1], label="mean, degrees")
        axes.plot(steps, degrees[:, 1], "s:", color=LINK_COLOURS[1], label="worst, degrees")
    axes.set(xscale="symlog", yscale="log", xlabel="steps", ylabel="error of the tool")
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend()
    return picture(drawn, format)


def curve_csv(steps: Sequence[int], mm: Floats, degrees: Floats) -> bytes:
    """The same as a table."""
    out = io.StringIO()
    out.write("steps,mean_mm,worst_mm,mean_deg,worst_deg\n")
    for step, (mean, worst), (turn, most) in zip(steps, mm, degrees, strict=True):
        turned = f"{turn:.6g},{most:.6g}" if np.isfinite(turn) else ","
        out.write(f"{step},{mean:.6g},{worst:.6g},{turned}\n")
    return out.getvalue().encode()


def _picture_limits(axes: Axes, goals: Floats, name: str) -> None:
    """As far as the goals go, v downwards as in a picture."""
    low, high = goals.min(axis=0), goals.max(axis=0)
    more = 0.1 * (high - low)
    axes.set_xlim(low[0] - more[0], high[0] + more[0])
    axes.set_ylim(high[1] + more[1], low[1] - more[1])
    axes.set_ylabel(f"{name}, px", fontsize=8)


def _lattice_links(shape: tuple[int, ...]) -> list[Rows]:
    """Of up to three axes (m, 2) neighbours along each, in the middle of all others."""
    numbers = np.arange(int(np.prod(shape))).reshape(shape)
    middle = (slice(None),) * 3 + tuple(count // 2 for count in shape[3:])
    there = numbers[middle[: len(shape)]]
    out = []
    for axis, count in enumerate(there.shape):
        first = np.take(there, np.arange(count - 1), axis).ravel()
        last = np.take(there, np.arange(1, count), axis).ravel()
        out.append(np.column_stack([first, last]))
    return out

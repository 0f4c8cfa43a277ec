"""A picture of explored space: from above and from the side, how much of it is free."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.cell.exploration.occupancy import CellState, Occupancy
from assistant.report.figures import new_figure, picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes

EXPLORED_VIEWS: Final = (("from above", 0, 1, 2), ("from the side", 0, 2, 1))
"""Title, axes to the right and up, and the axis that is looked along."""
AXIS_LETTERS: Final = "xyz"
EXPLORED_COLOURS: Final = "YlGnBu"


def explored_picture(occupancy: Occupancy, format: str = "png") -> bytes:
    """Free cells of a chart as mm of free space along two lines of sight, contacts as dots.

    The cross is the origin of the robot's base. Raises Refused, naming the extra, without
    matplotlib.
    """
    drawn = new_figure(10.0, 5.0)
    for axes, (title, right, up, along) in zip(drawn.subplots(1, 2), EXPLORED_VIEWS, strict=True):
        _draw_view(axes, occupancy, right, up)
        axes.set_title(f"{title}: mm of free space along {AXIS_LETTERS[along]}", fontsize=10)
    return picture(drawn, format)


def _draw_view(axes: Axes, occupancy: Occupancy, right: int, up: int) -> None:
    size = occupancy.size
    free, touched = (occupancy.cells(state) for state in (CellState.FREE, CellState.OCCUPIED))
    if len(free):
        first = free.min(axis=0)
        shape = free.max(axis=0) - first + 1
        depth: Floats = np.zeros((shape[up], shape[right]))
        np.add.at(depth, (free[:, up] - first[up], free[:, right] - first[right]), size)
        low, high = first * size, (first + shape) * size
        extent = (low[right], high[right], low[up], high[up])
        shown = np.ma.masked_equal(depth, 0.0)
        image = axes.imshow(
            shown, EXPLORED_COLOURS, origin="lower", extent=extent, interpolation="nearest"
        )
        axes.figure.colorbar(image, ax=axes, shrink=0.8)
    if len(touched):
        middle = (touched + 0.5) * size
        axes.plot(middle[:, right], middle[:, up], ".", color="#c03020", label="contacts")
        axes.legend(loc="upper right", fontsize=8)
    axes.plot(0.0, 0.0, "+", color="black", markersize=12)
    axes.set_aspect("equal")
    axes.set_xlabel(f"{AXIS_LETTERS[right]} / mm")
    axes.set_ylabel(f"{AXIS_LETTERS[up]} / mm")

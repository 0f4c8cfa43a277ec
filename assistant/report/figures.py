"""Figures of matplotlib, drawn without a screen; the package is an extra."""

from __future__ import annotations

import io
from pathlib import PurePath
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused, error

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NEEDS_PLOT: Final = error(
    "CL008",
    "drawing needs matplotlib, which is not installed",
    "install it with `pip install 'robot-assistant[plot]'`",
)
NO_PICTURE: Final = error(
    "CL009", "`{name}` is no picture that can be drawn", "end its name in .png or .svg"
)
FORMATS: Final = {".png": "png", ".svg": "svg"}
"""How the name of a picture ends → its format."""


def format_of(name: str) -> str:
    """`png` or `svg` by the end of a file name; raises Refused for another."""
    known = FORMATS.get(PurePath(name).suffix.lower())
    if known is None:
        raise Refused(NO_PICTURE(name=name), exit_status=2)
    return known


def cell_edges(values: Floats) -> Floats:
    """(n + 1,) between coloured cells about values (n,) that are evenly apart."""
    half = (values[1] - values[0]) / 2.0 if len(values) > 1 else 0.5
    return np.append(values - half, values[-1] + half)


def new_figure(width: float, height: float) -> Figure:
    """An empty figure, inches; raises Refused, naming the extra, without matplotlib."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise Refused(NEEDS_PLOT(), exit_status=2) from None
    empty = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(empty)
    return empty


def picture(drawn: Figure, format: str = "png") -> bytes:
    """The bytes of a figure, without version or date: the same figure gives the same bytes."""
    import matplotlib

    nameless = {"png": {"Software": None}, "svg": {"Date": None}}[format]
    data = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "robot-assistant"}):
        drawn.savefig(data, format=format, dpi=110, metadata=nameless)
    return data.getvalue()

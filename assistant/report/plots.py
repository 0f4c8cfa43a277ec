"""Plots of poses as pictures, drawn without a screen."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.program.se3 import METRE, Unit
from assistant.report import figures
from assistant.report.track import Track

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def pose_plot(track: Track, title: str, unit: Unit = "mm") -> bytes:
    """TCP position and orientation (quaternion) over the way, lengths in a unit, as a PNG."""
    along, label = track.lengths() / METRE[unit], f"way of the TCP in {unit}"
    return _pose_figure(along, track.positions, track.quaternions, label, title, "png", unit)


def exchange_plot(
    seconds: Floats,
    positions: Floats,
    quaternions: Floats,
    title: str,
    format: str = "png",
    unit: Unit = "mm",
) -> bytes:
    """Poses that a robot answered over time: (n,) s, (n, 3) mm, (n, 4) scalar first.

    unit: of the positions in the plot. A quaternion and its negative are one orientation: each is
    drawn with the sign that is nearer to the one before.
    """
    turns = rotations.unflipped(quaternions)
    return _pose_figure(seconds, positions, turns, "time in s", title, format, unit)


def _pose_figure(
    along: Floats,
    positions: Floats,
    quaternions: Floats,
    label: str,
    title: str,
    format: str,
    unit: Unit,
) -> bytes:
    figure = figures.new_figure(8.0, 6.0)
    upper, lower = figure.subplots(2, 1, sharex=True)
    marker = "." if len(along) <= 200 else ""
    draw_pose_curves((upper, lower), along, positions, quaternions, unit, marker=marker)
    return label_poses(figure, (upper, lower), label, title, unit, format)


def draw_pose_curves(
    axes: tuple[Axes, Axes],
    along: Floats,
    positions: Floats,
    quaternions: Floats,
    unit: Unit,
    *,
    named: bool = True,
    **style: Any,
) -> None:
    """Draw positions (n, 3) mm, in a unit, and quaternions (n, 4) over (n,).

    named: in the legend. style: of the lines.
    """
    names = ("x", "y", "z"), ("q1 (w)", "q2 (x)", "q3 (y)", "q4 (z)")
    for place, columns, labels in zip(
        axes, (positions / METRE[unit], quaternions), names, strict=True
    ):
        for number, (column, name) in enumerate(zip(columns.T, labels, strict=True)):
            place.plot(along, column, color=f"C{number}", label=name if named else None, **style)


def label_poses(
    figure: Figure, axes: tuple[Axes, Axes], label: str, title: str, unit: Unit, format: str
) -> bytes:
    """Label the axes of positions above and quaternions below, and return the picture."""
    upper, lower = axes
    upper.set(ylabel=f"position of the TCP in {unit}", title=title)
    lower.set(ylabel="orientation", xlabel=label)
    for one in axes:
        one.grid(visible=True, alpha=0.3)
        one.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figures.picture(figure, format)

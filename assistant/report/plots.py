"""Plots of poses as pictures, drawn without a screen."""

from __future__ import annotations

from assistant.program import rotations
from assistant.program.arrays import Floats
from assistant.report import figures
from assistant.report.track import Track


def pose_plot(track: Track, title: str) -> bytes:
    """TCP position (mm) and orientation (quaternion) over the way (mm), as a PNG."""
    return _poses(
        track.lengths(), track.positions, track.quaternions, "way of the TCP in mm", title, "png"
    )


def exchange_plot(
    seconds: Floats, positions: Floats, quaternions: Floats, title: str, format: str = "png"
) -> bytes:
    """What a robot answered over the time: (n,) s, (n, 3) mm, (n, 4) scalar first.

    A quaternion and its negative are one orientation: each is drawn on the side of the one before.
    """
    turns = rotations.unflipped(quaternions)
    return _poses(seconds, positions, turns, "time in s", title, format)


def _poses(
    along: Floats, positions: Floats, quaternions: Floats, label: str, title: str, format: str
) -> bytes:
    figure = figures.figure(8.0, 6.0)
    upper, lower = figure.subplots(2, 1, sharex=True)
    marker = "." if len(along) <= 200 else ""
    for axis, name in enumerate("xyz"):
        upper.plot(along, positions[:, axis], marker=marker, label=name)
    for axis, name in enumerate(("q1 (w)", "q2 (x)", "q3 (y)", "q4 (z)")):
        lower.plot(along, quaternions[:, axis], marker=marker, label=name)
    upper.set(ylabel="position of the TCP in mm", title=title)
    lower.set(ylabel="orientation", xlabel=label)
    for axes in (upper, lower):
        axes.grid(visible=True, alpha=0.3)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figures.picture(figure, format)

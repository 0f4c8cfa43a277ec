"""Plots of a track as PNG files, drawn without a screen."""

from __future__ import annotations

from assistant.report import figures
from assistant.report.track import Track


def pose_plot(track: Track, title: str) -> bytes:
    """TCP position (mm) and orientation (quaternion) over the way (mm), as a PNG."""
    figure = figures.figure(8.0, 6.0)
    upper, lower = figure.subplots(2, 1, sharex=True)
    way = track.lengths()
    marker = "." if len(track) <= 200 else ""
    for axis, label in enumerate("xyz"):
        upper.plot(way, track.positions[:, axis], marker=marker, label=label)
    for axis, label in enumerate(("q1 (w)", "q2 (x)", "q3 (y)", "q4 (z)")):
        lower.plot(way, track.quaternions[:, axis], marker=marker, label=label)
    upper.set(ylabel="position of the TCP in mm", title=title)
    lower.set(ylabel="orientation", xlabel="way of the TCP in mm")
    for axes in (upper, lower):
        axes.grid(visible=True, alpha=0.3)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figures.picture(figure)

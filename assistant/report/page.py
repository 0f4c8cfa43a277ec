"""A one-page HTML report: the drawing, the path over it, the programs and their proofs."""

from __future__ import annotations

import base64
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.program.arrays import Floats
from assistant.program.path import Kind
from assistant.report.track import Track
from assistant.resources import resource

MARGIN: Final = 15.0
"""mm of white around the picture."""


@dataclass(frozen=True, slots=True)
class Polyline:
    """points (n, 2) mm, drawn with a style class of the page."""

    points: Floats
    style: str


@dataclass(frozen=True, slots=True)
class Label:
    """A name at a point; `anchor` keeps it inside the picture."""

    x: float
    y: float
    text: str
    anchor: str


@dataclass(frozen=True, slots=True)
class Picture:
    """A plan view: y upwards, as drawings have it; `box` is an SVG viewBox."""

    polylines: tuple[tuple[str, str], ...]
    """SVG point lists with their style classes."""
    labels: tuple[Label, ...]
    box: str
    scale: float
    """mm that stand for a hundredth of the picture's larger side."""


@dataclass(frozen=True, slots=True)
class Program:
    """One program of the report: where it came from, what it became, and the proof line."""

    source: str
    language: str
    robot: str
    proof: str
    controller: str
    files: tuple[tuple[str, str], ...]
    """File names with their text."""


@dataclass(frozen=True, slots=True)
class Section:
    """A source with its picture or plot (PNG bytes) and the programs made of it."""

    title: str
    programs: tuple[Program, ...]
    picture: Picture | None = None
    plot: bytes | None = None

    @property
    def plot_data(self) -> str:
        return base64.b64encode(self.plot or b"").decode("ascii")


def page(title: str, sections: Sequence[Section]) -> str:
    """The report as one HTML file without anything from outside."""
    from jinja2 import Environment

    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    template = resource("templates", "report.html").read_text(encoding="utf-8")
    return environment.from_string(template).render(title=title, sections=sections)


def plan_view(drawing: Sequence[Floats], track: Track) -> Picture:
    """The curves of a drawing, each (n, 2 or 3) mm, with the track of a program over them."""
    lines = [Polyline(curve[:, :2], "drawn") for curve in drawing if len(curve)]
    lines += _runs(track)
    everything = np.concatenate([line.points for line in lines] or [np.zeros((1, 2))])
    low, high = everything.min(axis=0) - MARGIN, everything.max(axis=0) + MARGIN
    width, height = high - low
    box = f"{low[0]:.2f} {-high[1]:.2f} {width:.2f} {height:.2f}"
    lists = tuple((_svg(line.points), line.style) for line in lines)
    middle = float(low[0] + high[0]) / 2.0
    return Picture(lists, _labels(track, middle), box, float(max(width, height)) / 100.0)


def _labels(track: Track, middle: float) -> tuple[Label, ...]:
    """One label a place in the plane, with the names of all targets above each other."""
    places: dict[tuple[float, float], list[str]] = {}
    for row, name in track.names.items():
        x, y = (round(float(v), 1) + 0.0 for v in track.positions[row, :2])
        names = places.setdefault((x, y), [])
        if name not in names:
            names.append(name)
    return tuple(
        Label(x, -y, ", ".join(names), "end" if x > middle else "start")
        for (x, y), names in places.items()
    )


def _runs(track: Track) -> list[Polyline]:
    """Consecutive moves of one style as one polyline each: `joint` or `linear`."""
    if len(track) < 2:
        return []
    joint = track.kinds[1:] == Kind.JOINT
    cuts = np.flatnonzero(np.diff(joint.astype(np.int8))) + 1
    edges = [0, *cuts, len(joint)]
    return [
        Polyline(track.positions[a : b + 1, :2], "joint" if joint[a] else "linear")
        for a, b in itertools.pairwise(edges)
    ]


def _svg(points: Floats) -> str:
    return " ".join(f"{x:.2f},{-y:.2f}" for x, y in points)

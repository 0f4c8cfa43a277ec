"""A customer's drawing in the manner of real exports, and the way of a program through it.

The drawing is in inches, on the layer `Default` that CAD systems export to; its pieces do not
quite meet, its holes are blocks, one side is a spline, and around it stands what nobody wants.
What the program does is read from its text alone, by the few forms that it needs here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import ezdxf
import numpy as np
from numpy.typing import NDArray

INCH: Final = 25.4
GAP: Final = 0.0004
"""Inches that ends of neighbours are apart: 0.01 mm, as rounding of an export leaves them."""

Points = NDArray[np.float64]


def write_drawing(file: Path) -> dict[str, list[Points]]:
    """The drawing, and its contours as dense closed lines (n, 2) in mm: `outline` and `holes`."""
    doc = ezdxf.new("R2010", setup=True)
    doc.header["$INSUNITS"] = 1
    for name in ("Default", "BORDER", "CENTER"):
        doc.layers.add(name)
    hole = doc.blocks.new("DRILL_12")
    hole.add_circle((0, 0), 0.25, dxfattribs={"layer": "0"})
    page = doc.modelspace()
    part = {"layer": "Default"}
    # The outline, counter-clockwise from below left: two round corners, a wave on top.
    page.add_line((0.5, 0), (7.5, 0), dxfattribs=part)
    page.add_arc((7.5, 0.5), 0.5, 270, 360, dxfattribs=part)
    page.add_line((8, 0.5 + GAP), (8, 5), dxfattribs=part)
    wave = [(8, 5), (6, 5.4), (4, 4.8), (2, 5.4), (0, 5)]
    spline = page.add_spline(wave, dxfattribs=part)
    page.add_line((0, 5 - GAP), (0, 0.5), dxfattribs=part)
    page.add_arc((0.5, 0.5), 0.5, 180, 270, dxfattribs=part)
    # Holes: three of a block, one of them larger; a slot drawn clockwise; a window.
    for at, scale in (((1, 1), 1.0), ((7, 1), 1.0), ((4, 3.5), 2.0)):
        page.add_blockref("DRILL_12", at, {**part, "xscale": scale, "yscale": scale})
    slot = [(2, 1.75, 0), (3, 1.75, -1), (3, 1.25, 0), (2, 1.25, -1)]
    page.add_lwpolyline(slot, format="xyb", close=True, dxfattribs=part)
    window = [(4.5, 1), (6, 1), (6, 2.5), (4.5, 2.5)]
    page.add_lwpolyline(window, close=True, dxfattribs=part)
    # What exports hold beside the part.
    page.add_lwpolyline([(-2, -2), (11, -2), (11, 8), (-2, 8)], close=True,
                        dxfattribs={"layer": "BORDER"})  # fmt: skip
    page.add_line((4, -1), (4, 7), dxfattribs={"layer": "CENTER", "linetype": "CENTER"})
    page.add_text("PLATE 4711 REV C", height=0.2, dxfattribs={"layer": "BORDER"})
    page.add_linear_dim(base=(0, -1), p1=(0, 0), p2=(8, 0), dxfattribs=part).render()
    doc.saveas(file)
    top = np.array([(p.x, p.y) for p in spline.construction_tool().approximate(2000)])
    corner = np.array([0.5, 0.5])
    outline = [
        *(_line((0.5, 0), (7.5, 0)), _arc((7.5, 0.5), 0.5, -90, 0), _line((8, 0.5), (8, 5))),
        *(top, _line((0, 5), (0, 0.5)), _arc(corner, 0.5, 180, 270)),
    ]
    holes = [
        *(_arc(c, r, 0, 360) for c, r in (((1, 1), 0.25), ((7, 1), 0.25), ((4, 3.5), 0.5))),
        np.vstack([_line((2, 1.25), (3, 1.25)), _arc((3, 1.5), 0.25, -90, 90),
                   _line((3, 1.75), (2, 1.75)), _arc((2, 1.5), 0.25, 90, 270)]),
        np.vstack([_line(a, b) for a, b in zip(window, [*window[1:], window[0]], strict=True)]),
    ]  # fmt: skip
    return {"outline": [np.vstack(outline) * INCH], "holes": [hole * INCH for hole in holes]}


def _line(a: object, b: object) -> Points:
    return np.linspace(np.asarray(a, dtype=float), np.asarray(b, dtype=float), 400)


def _arc(centre: object, radius: float, start: float, end: float) -> Points:
    angles = np.radians(np.linspace(start, end, 721))
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.asarray(centre, dtype=float) + radius * ring


@dataclass(frozen=True, slots=True)
class Cut:
    """Where the tool went (n, 3) mm in its frame while an output was on, densely."""

    way: Points


NUMBER: Final = r"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"
TARGET: Final = re.compile(
    rf"(?:CONST|PERS) robtarget (\w+):=\[\[({NUMBER}),({NUMBER}),({NUMBER})\]", re.IGNORECASE
)
MOVE: Final = re.compile(r"^\s*Move(L|C|J|AbsJ) (.*);", re.IGNORECASE)
HEIGHT: Final = re.compile(rf"CONST num (\w+):=({NUMBER});")
AWAY: Final = re.compile(rf"RelTool\((\w+),({NUMBER}),({NUMBER}),({NUMBER})\)", re.IGNORECASE)


def cuts(text: str, output: str) -> Iterator[Cut]:
    """The ways of a RAPID module while an output is 1; the tool points down (its z is -z)."""
    for name, value in HEIGHT.findall(text):
        text = re.sub(rf"\b{name}\b(?!:=)", value, text)
    targets = {
        found[1].lower(): np.array([float(found[k]) for k in (2, 3, 4)])
        for found in TARGET.finditer(text)
    }
    here: Points | None = None
    way: list[Points] | None = None
    for line in text.splitlines():
        if re.search(rf"\bSetDO (?:\\\w+,\s*)?{output},1;", line):
            way = []
        elif re.search(rf"\bSetDO (?:\\\w+,\s*)?{output},0;", line) and way:
            yield Cut(np.vstack(way))
            way = None
        if (move := MOVE.match(line)) is None or move[1] == "AbsJ":
            continue
        to = _places(move[2], targets)
        end = to[-1]
        if way is not None and here is not None:
            way.append(_through(here, *to) if len(to) == 2 else np.linspace(here, end, 80))
        here = end


def _places(words: str, targets: dict[str, Points]) -> list[Points]:
    """The one or two places of a move's words."""
    found = []
    while words and len(found) < 2:
        if away := AWAY.match(words):
            x, y, z = (float(away[k]) for k in (2, 3, 4))
            found.append(targets[away[1].lower()] + np.array([x, -y, -z]))
            words = words[away.end() :].lstrip(",")
            continue
        name, _, words = words.partition(",")
        if name.lower() not in targets:
            break
        found.append(targets[name.lower()])
    return found


def _through(a: Points, b: Points, c: Points) -> Points:
    """An arc from a through b to c in a plane of one height."""
    (ax, ay), (bx, by), (cx, cy) = a[:2], b[:2], c[:2]
    twice = 2 * (ax * (by - cy) + bx * (cy - ay) + cx * (ay - by))
    squares = [p[0] ** 2 + p[1] ** 2 for p in (a, b, c)]
    x = (squares[0] * (by - cy) + squares[1] * (cy - ay) + squares[2] * (ay - by)) / twice
    y = (squares[0] * (cx - bx) + squares[1] * (ax - cx) + squares[2] * (bx - ax)) / twice
    first, via, last = (np.arctan2(p[1] - y, p[0] - x) for p in (a, b, c))
    full = 2 * np.pi
    if (via - first) % full > (last - first) % full:
        angles = first - np.linspace(0, (first - last) % full, 120)
    else:
        angles = first + np.linspace(0, (last - first) % full, 120)
    radius = np.hypot(ax - x, ay - y)
    flat = np.stack([x + radius * np.cos(angles), y + radius * np.sin(angles)], axis=1)
    return np.column_stack([flat, np.full(len(flat), a[2])])

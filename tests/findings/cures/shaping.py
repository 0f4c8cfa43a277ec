"""Cures of contours with offsets, leads, starts and passes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from tests.findings.cures.case import Case, dxf

ON: Final = {"layer": "CUT"}
DUMBBELL: Final = [
    *((0, 0), (30, 0), (30, 13), (60, 13), (60, 0), (90, 0)),
    *((90, 30), (60, 30), (60, 17), (30, 17), (30, 30), (0, 30)),
]
SLOT: Final = [(0, 0), (60, 0), (60, 40), (32, 40), (32, 70), (28, 70), (28, 40), (0, 40)]


def closed(*outlines: list[tuple[int, int]]) -> Callable[[Any], None]:
    def draw(space: Any) -> None:
        for outline in outlines:
            space.add_lwpolyline(outline, close=True, dxfattribs=ON)

    return draw


def box(size: int, x: int = 0) -> list[tuple[int, int]]:
    return [(x, 0), (x + size, 0), (x + size, size), (x, size)]


def opened(space: Any) -> None:
    space.add_line((0, 0), (50, 0), dxfattribs=ON)


def on_a_wall(space: Any) -> None:
    points = [(400, 0, 300), (400, 40, 300), (400, 40, 340), (400, 0, 340)]
    space.add_polyline3d(points, close=True, dxfattribs=ON)


def _case(
    code: str, draw: Callable[[Any], object], wrong: str, right: str, *, becomes: str = ""
) -> Case:
    def process(keys: str) -> dict[str, str]:
        return {"a.process.toml": f"[layers.CUT]\n{keys}\n"}

    files = {"a.dxf": dxf(draw), **process(wrong)}
    return Case(code, "check a.dxf", files, change=process(right), becomes=becomes)


def nested(space: Any) -> None:
    for layer, outline in (("RIM", box(80)), ("HOLES", [(x + 20, y + 20) for x, y in box(20)])):
        space.add_lwpolyline(outline, close=True, dxfattribs={"layer": layer})


INSIDE: Final = 'side = "inside"\n'
STOPS: Final = '[motion]\nblend = "fine"\n'
SWITCHED: Final = """[signals.valve]
number = 4
[layers.CUT]
on = {valve = 1}
off = {valve = 0}
"""

CASES: Final = (
    Case(
        "CT237",
        "check a.dxf",
        {"a.dxf": dxf(closed(box(40))), "a.process.toml": STOPS + SWITCHED},
        change={"a.process.toml": f"{STOPS}{SWITCHED}blend = 1\n"},
    ),
    Case(
        "CT335",
        "check a.dxf",
        {"a.dxf": dxf(nested), "a.process.toml": "[layers.RIM]\n[layers.HOLES]\n"},
        change={"a.process.toml": "[layers.RIM]\ninside_first = false\n[layers.HOLES]\n"},
    ),
    _case("CT210", opened, "offset = 3", 'offset = 3\nside = "left"'),
    _case("CT210", opened, "offset = 3", 'offset = 3\nside = "right"'),
    _case("CT211", on_a_wall, "offset = 3", "offset = 3\ndirection = [1, 0, 0]"),
    _case("CT213", closed(box(5)), f"{INSIDE}offset = 3", f"{INSIDE}offset = 2"),
    _case("CT214", closed(DUMBBELL), f"{INSIDE}offset = 3", f"{INSIDE}offset = 1"),
    _case("CT215", closed(SLOT), f"{INSIDE}offset = 3", f"{INSIDE}offset = 1"),
    _case("CT216", closed(box(40), box(40, 45)), "offset = 3", "offset = 2"),
    _case(
        "CT217",
        closed(box(40)),
        f"{INSIDE}lead_in = {{line = 60}}\nlead_out = {{arc = 60}}",
        f"lead_in = {{line = 6}}\nlead_out = {{arc = 6}}\n{INSIDE}",
    ),
    _case("CT218", closed(box(40)), "offset = 3", 'offset = 3\nside = "outside"'),
    _case("CT330", closed(box(40)), "passes = 3", "passes = 3\ndepth = 12"),
    _case(
        "CT331",
        closed(box(40)),
        "depth = 3\napproach = 0\nretract = 0",
        "depth = 3\napproach = 9\nretract = 9",
    ),
    _case("CT332", closed(box(40)), 'side = "inside"', 'side = "inside"\noffset = 3'),
    _case("CT333", closed(box(10)), "overlap = 50", "overlap = 5"),
)

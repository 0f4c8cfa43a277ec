"""Cures of the keys that say how contours are followed."""

from __future__ import annotations

from typing import Any, Final

from tests.findings.cures.case import Case, dxf


def rounded(space: Any) -> None:
    """Two lines with an arc of 8 mm between them."""
    points = [(0, 0, 0), (92, 0, 0.4142135623730951), (100, 8, 0), (100, 60, 0)]
    space.add_lwpolyline(points, format="xyb", dxfattribs={"layer": "CUT"})


def slight(space: Any) -> None:
    space.add_lwpolyline([(0, 0), (50, 0), (99, 10)], dxfattribs={"layer": "CUT"})


def zigzag(space: Any) -> None:
    corners = [(10 * k, 8 * (k % 2)) for k in range(5)]
    space.add_lwpolyline(corners, dxfattribs={"layer": "CUT"})


def outline_first(space: Any) -> None:
    for x, size in ((0, 100), (20, 10)):
        corners = [(x, x), (x + size, x), (x + size, x + size), (x, x + size)]
        space.add_lwpolyline(corners, close=True, dxfattribs={"layer": "CUT"})


def crossed_layers(space: Any) -> None:
    for layer, x, size in (("CUT", 0, 100), ("SLOTS", 20, 30), ("CUT", 30, 10)):
        corners = [(x, x), (x + size, x), (x + size, x + size), (x, x + size)]
        space.add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})


def _of(
    code: str, draw: Any, wrong: str, right: str, top: str = "", others: tuple[str, ...] = ()
) -> Case:
    layer = f"{top}[layers.CUT]\n"
    files = {"a.dxf": dxf(draw), "a.process.toml": f"{layer}{wrong}"}
    return Case(
        code, "check a.dxf", files, change={"a.process.toml": f"{layer}{right}"}, others=others
    )


PLANNED: Final = '[motion]\nkind = "travel"\n'
AT_HOME: Final = "home = [0, 0, 0, 0, 30, 0]\n"
TANGENTIAL: Final = "[layers.CUT]\ntangential = true\n"
LONG_TABLE: Final = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n" + "".join(
    f"{300 + k % 2},{k / 5},300,0,1,0,0\n" for k in range(1005)
)
"""More rows than an array of MELFA-BASIC has elements."""
NO_MAIN: Final = "[program]\nmain = false\n"
SLOW: Final = "corner_speed = 20\n"
JOINT: Final = 'travel_kind = "joint"\n'
WIDE: Final = "travel_blend = 60\n"

CASES: Final = (
    _of("CT223", rounded, SLOW, f"{SLOW}corner_radius = 8\n"),
    _of("CT223", slight, SLOW, f"{SLOW}corner_angle = 10\n"),
    _of("CT224", outline_first, 'order = "drawing"\n', 'order = "drawing"\ninside_first = false\n'),
    _of("CT334", crossed_layers, "[layers.SLOTS]\n", "inside_first = false\n[layers.SLOTS]\n"),
    _of("CT343", slight, f"{JOINT}approach = 0\nretract = 0\n", JOINT),
    _of("CT343", slight, f"{JOINT}retract = 0\n", f"{JOINT}travel_height = 50\n"),
    _of("CT344", slight, WIDE, "travel_blend = 20\n"),
    _of("CT344", slight, WIDE, f"{WIDE}travel_height = 80\n"),
    _of("CT344", slight, WIDE, f"{WIDE}approach = 70\nretract = 70\n"),
    _of("CT345", slight, JOINT, "", PLANNED, ("CK470",)),
    Case(
        "CT346",
        "check a.dxf",
        {"a.dxf": dxf(slight), "a.process.toml": f"{AT_HOME}[program]\nmain = false\n"},
        change={"a.process.toml": "[program]\nmain = false\n"},
    ),
    Case(
        "CT346",
        "check a.dxf",
        {"a.dxf": dxf(slight), "a.process.toml": f"{AT_HOME}[program]\nmain = false\n"},
        change={"a.process.toml": AT_HOME},
    ),
    Case(
        "DX014",
        "check a.dxf",
        {"a.dxf": dxf(slight), "a.process.toml": f"{NO_MAIN}[style]\nprocedures = 'none'\n"},
        change={"a.process.toml": f"{NO_MAIN}[style]\nprocedures = 'layer'\n"},
    ),
    Case(
        "DX014",
        "check a.dxf",
        {"a.dxf": dxf(slight), "a.process.toml": f"{NO_MAIN}[style]\nprocedures = 'none'\n"},
        change={"a.process.toml": "[style]\nprocedures = 'none'\n"},
    ),
    Case(
        "CO621",
        "compile a.dxf -l rapid -o out",
        {"a.dxf": dxf(zigzag), "a.process.toml": f"{TANGENTIAL}[style]\npoints = 'offsets'\n"},
        change={"a.process.toml": f"{TANGENTIAL}[style]\npoints = 'targets'\n"},
        others=("CK470", "RA303"),
    ),
    Case(
        "CO621",
        "compile a.dxf -l rapid -o out",
        {"a.dxf": dxf(zigzag), "a.process.toml": f"{TANGENTIAL}[style]\npoints = 'offsets'\n"},
        change={"a.process.toml": "[layers.CUT]\n[style]\npoints = 'offsets'\n"},
        others=("CK470", "RA303"),
    ),
    Case(
        "CO622",
        "compile a.csv -l melfa-basic-6 -o out",
        {"a.csv": LONG_TABLE, "a.process.toml": "tolerance = 0.1\n[style]\npoints = 'arrays'\n"},
        change={"a.process.toml": "tolerance = 0.1\n[style]\npoints = 'targets'\n"},
        others=("MB202", "MB204"),
    ),
    Case(
        "CT345",
        "check a.dxf",
        {"a.dxf": dxf(slight), "a.process.toml": f"{PLANNED}[layers.CUT]\n{JOINT}"},
        change={"a.process.toml": f"[layers.CUT]\n{JOINT}"},
    ),
)

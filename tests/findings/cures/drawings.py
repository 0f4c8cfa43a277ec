"""Cures of drawings, their process files, and cells."""

from __future__ import annotations

from typing import Any, Final

from tests.findings.cures.case import Case, dxf

ARM: Final = "--robot irb1200-7-0.7"
HERE: Final = '[frames.table]\nposition = [400, 0, 300]\n\n[motion]\nframe = "table"\n'


def line(space: Any) -> None:
    space.add_line((0, 0), (50, 0), dxfattribs={"layer": "CUT"})


def long(space: Any) -> None:
    space.add_line((0, 0), (2000, 0), dxfattribs={"layer": "CUT"})


def with_logo(space: Any) -> None:
    line(space)
    space.add_blockref("LOGO", (10, 10))


def square(space: Any) -> None:
    space.add_lwpolyline([(0, 0), (80, 0), (80, 80), (0, 80)], close=True)


def apart(space: Any) -> None:
    space.add_line((0, 0), (50, 0), dxfattribs={"layer": "CUT"})
    space.add_line((50.01, 0), (50, 40), dxfattribs={"layer": "CUT"})


def far_apart(space: Any) -> None:
    space.add_line((0, 0), (50, 0), dxfattribs={"layer": "CUT"})
    space.add_line((50.08, 0), (50, 40), dxfattribs={"layer": "CUT"})


def of_short_sides(space: Any) -> None:
    points = [(0.5 * i, 0.003 * (i % 2)) for i in range(60)]
    space.add_lwpolyline(points, dxfattribs={"layer": "CUT"})


def tiny(space: Any) -> None:
    line(space)
    space.add_ellipse((80, 0), (0.004, 0), 0.9, dxfattribs={"layer": "CUT"})


def curved(space: Any) -> None:
    space.add_ellipse((0, 0), (50, 0), 0.5, dxfattribs={"layer": "CUT"})


def two_layers(space: Any) -> None:
    line(space)
    space.add_line((0, 20), (50, 20), dxfattribs={"layer": "NOTES"})


def bordered(space: Any) -> None:
    line(space)
    space.add_line((0, 20), (50, 20), dxfattribs={"layer": "BORDER"})
    space.add_line((0, 5), (50, 5), dxfattribs={"layer": "CUT", "linetype": "CENTER"})


def bordered_only(space: Any) -> None:
    space.add_line((0, 20), (50, 20), dxfattribs={"layer": "BORDER"})


def titled(space: Any) -> None:
    """A line in a border with a title block."""
    line(space)
    form(space)


def form(space: Any) -> None:
    space.add_lwpolyline([(-20, -60), (260, -60), (260, 130), (-20, 130)], close=True)
    for y in (-50, -40, -30):
        space.add_line((120, y), (260, y))
    for x in (120, 160, 200):
        space.add_line((x, -60), (x, -30))
        space.add_text("A", height=3).set_placement((x + 5, -58))


def underlined(space: Any) -> None:
    """The same, and a line from side to side of the border."""
    titled(space)
    space.add_line((-20, 60), (260, 60), dxfattribs={"layer": "CUT"})


def bent_path(space: Any) -> None:
    line(space)
    space.add_line((50, 0), (50, 40), dxfattribs={"layer": "CUT"})


def rounded_path(space: Any) -> None:
    line(space)
    space.add_arc((50, 10), 10, -90, 0, dxfattribs={"layer": "CUT"})
    space.add_line((60, 10), (60, 40), dxfattribs={"layer": "CUT"})


def as_paper(space: Any) -> None:
    """A plate as large as A4 with a hole and a text."""
    space.add_lwpolyline([(0, 0), (297, 0), (297, 210), (0, 210)], close=True)
    space.add_circle((40, 40), 5)
    space.add_text("A", height=3)


def dimensioned(space: Any) -> None:
    """A square, and a line along the extension line of a dimension, which ends where it does."""
    square(space)
    on = {"layer": "SIZES"}
    space.add_linear_dim(base=(0, 30), p1=(40, 40), p2=(0, 40), dxfattribs=on).render()
    space.add_line((40, 30), (40, 60), dxfattribs=on)


def two_views(space: Any) -> None:
    """A square with a circle in it, and what is seen from its side."""
    square(space)
    space.add_circle((40, 40), 5)
    space.add_lwpolyline([(0, -30), (80, -30), (80, -25), (0, -25)], close=True)


def meeting(space: Any) -> None:
    line(space)
    space.add_line((50, 0), (50, 30), dxfattribs={"layer": "OTHER"})


CUT: Final = "[layers.CUT]\nspeed = 20\n"
TURNING: Final = "[signals.beam]\n\n" + CUT + "on = {beam = 1}\noff = {beam = 0}\n"
HOLLOW: Final = """\
[tools.knife]
tip = [0, 0, 100]
free_turn = true
[layers.CUT]
tool = "knife"
tangential = true
"""

CASES: Final = (
    Case("DX101", "check a.dxf", {"a.dxf": dxf(line, 0)}, ("check a.dxf --unit mm",)),
    Case(
        "DX101", "check a.dxf", {"a.dxf": dxf(line, 0)}, change={"a.process.toml": 'unit = "mm"\n'}
    ),
    Case("DX102", "check a.dxf", {"a.dxf": dxf(line, 99)}, ("check a.dxf --unit mm",)),
    Case(
        "DX102", "check a.dxf", {"a.dxf": dxf(line, 99)}, change={"a.process.toml": 'unit = "mm"\n'}
    ),
    Case(
        "DX104",
        "check a.dxf",
        {"a.dxf": dxf(line), "a.process.toml": 'unit = "in"\n'},
        change={"a.process.toml": "tolerance = 0.05\n"},
    ),
    Case(
        "CT229",
        "check a.dxf",
        {"a.dxf": dxf(two_views)},
        change={"a.process.toml": "leave_out = [{group = 2}]\n"},
    ),
    Case(
        "CT230",
        "check a.dxf",
        {"a.dxf": dxf(two_views), "a.process.toml": "leave_out = [{at = [500, 0]}]\n"},
        change={"a.process.toml": "leave_out = [{at = [40, 40]}]\n"},
    ),
    Case(
        "CT231",
        "check a.dxf",
        {"a.dxf": dxf(two_views), "a.process.toml": "leave_out = [{at = [40, 40]}]\n"},
        change={"a.process.toml": "leave_out = [{at = [45, 40]}]\n"},
    ),
    Case(
        "CT241",
        "check a.dxf",
        {"a.dxf": dxf(two_views), "a.process.toml": "leave_out = [{at = [80, 40]}]\n"},
        change={"a.process.toml": "leave_out = [{at = [80, 40]}, {at = [45, 40]}]\n"},
    ),
    Case(
        "CT242",
        "check a.dxf",
        {"a.dxf": dxf(two_views), "a.process.toml": "leave_out = [{at = [46, 40]}]\n"},
        change={"a.process.toml": "leave_out = [{at = [45, 40]}]\n"},
    ),
    Case(
        "CT232",
        "check a.dxf",
        {"a.dxf": dxf(meeting), "a.process.toml": "leave_out = [{at = [50, 0]}]\n"},
        change={"a.process.toml": 'leave_out = [{layer = "CUT", at = [50, 0]}]\n'},
    ),
    Case(
        "CT233",
        "check a.dxf",
        {"a.dxf": dxf(two_views), "a.process.toml": "leave_out = [{number = 9}]\n"},
        change={"a.process.toml": "leave_out = [{number = 1}]\n"},
    ),
    Case(
        "CT233",
        "check a.dxf",
        {"a.dxf": dxf(two_views), "a.process.toml": "leave_out = [{number = 9}]\n"},
        change={"a.process.toml": "leave_out = [{at = [40, 40]}]\n"},
    ),
    Case(
        "CT234",
        "check a.dxf",
        {"a.dxf": dxf(two_views), "a.process.toml": "leave_out = [{number = 1}]\n"},
        change={"a.process.toml": 'leave_out = [{layer = "0", at = [45, 40]}]\n'},
    ),
    Case(
        "CT235",
        "check a.dxf",
        {"a.dxf": dxf(two_views), "a.process.toml": "leave_out = [{group = 9}]\n"},
        change={"a.process.toml": "leave_out = [{group = 2}]\n"},
    ),
    Case(
        "DX011",
        "check a.dxf",
        {"a.dxf": dxf(bordered_only)},
        change={"a.process.toml": 'follow = ["BORDER"]\n'},
    ),
    Case(
        "DX212",
        "check a.dxf",
        {"a.dxf": dxf(bordered)},
        change={"a.process.toml": 'follow = ["BORDER", "CENTER"]\n'},
    ),
    Case(
        "DX212",
        "check a.dxf",
        {"a.dxf": dxf(bordered), "a.process.toml": CUT},
        change={"a.process.toml": CUT + "[layers.BORDER]\n"},
    ),
    Case(
        "DX212",
        "check a.dxf",
        {"a.dxf": dxf(titled)},
        change={"a.process.toml": 'follow = ["border"]\n'},
    ),
    Case(
        "DX216",
        "check a.dxf",
        {"a.dxf": dxf(dimensioned)},
        change={"a.process.toml": 'leave_out = ["SIZES"]\n'},
    ),
    Case(
        "DX216",
        "check a.dxf",
        {"a.dxf": dxf(dimensioned)},
        change={"a.process.toml": 'follow = ["SIZES"]\n'},
    ),
    Case(
        "DX214",
        "check a.dxf",
        {"a.dxf": dxf(as_paper)},
        change={"a.process.toml": 'leave_out = ["border"]\n'},
    ),
    Case(
        "DX214",
        "check a.dxf",
        {"a.dxf": dxf(as_paper)},
        change={"a.process.toml": 'follow = ["border"]\n'},
    ),
    Case(
        "CT236",
        "check a.dxf",
        {"a.dxf": dxf(bent_path), "a.process.toml": TURNING + "tangential = true\n"},
        change={"a.process.toml": TURNING},
    ),
    Case(
        "CT236",
        "check a.dxf",
        {"a.dxf": dxf(bent_path), "a.process.toml": TURNING + "tangential = true\n"},
        change={"a.dxf": dxf(rounded_path)},
    ),
    Case(
        "DX215",
        "check a.dxf",
        {"a.dxf": dxf(underlined)},
        change={"a.process.toml": 'leave_out = [{layer = "CUT", at = [120, 60]}]\n'},
    ),
    Case(
        "DX213",
        "check a.dxf",
        {"a.dxf": dxf(bordered), "a.process.toml": CUT},
        change={"a.process.toml": f'leave_out = [{{layer = "CUT", line_type = "CENTER"}}]\n{CUT}'},
    ),
    Case(
        "PR305",
        "init p a.dxf",
        {"a.dxf": dxf(bordered)},
        change={"p/drawings/a.process.toml": CUT + "[layers.BORDER]\n"},
    ),
    Case(
        "PR305",
        "init p a.dxf",
        {"a.dxf": dxf(titled)},
        change={"p/drawings/a.process.toml": 'follow = ["border"]\n'},
    ),
    Case(
        "PR306",
        "init p a.dxf",
        {"a.dxf": dxf(form)},
        change={"p/drawings/a.process.toml": 'follow = ["border"]\n'},
    ),
    Case(
        "PR306",
        "init p a.dxf",
        {"a.dxf": dxf(bordered_only)},
        change={"p/drawings/a.process.toml": "[layers.BORDER]\n"},
    ),
    Case(
        "PR307",
        "init p a.dxf --yes",
        {"a.dxf": dxf(line)},
        change={"p/drawings/a.process.toml": CUT},
        then=("init q a.dxf --tip 0,0,80 --place 300,0,200",),
    ),
    Case(
        "DX206",
        "check a.dxf",
        {"a.dxf": dxf(with_logo)},
        change={"a.process.toml": 'leave_out = [{block = "LOGO"}]\n'},
    ),
    Case(
        "PR312",
        "init p a.dxf --yes",
        {"a.dxf": dxf(with_logo)},
        change={"a.dxf": dxf(line), "p/drawings/a.process.toml": "leave_out = []\n"},
        then=("init q a.dxf --yes",),
    ),
    Case(
        "PR308",
        "init p a.dxf --robot irb1200-7-0.7",
        {"a.dxf": dxf(long)},
        then=("init q a.dxf --robot irb6700-150-3.20",),
    ),
    Case(
        "PR308",
        "init p a.dxf --yes",
        {"a.dxf": dxf(line, 6)},
        then=("init q a.dxf --yes --unit mm",),
    ),
    Case(
        "PR314",
        "init p a.dxf --yes",
        {"a.dxf": dxf(line, 1)},
        then=("init q a.dxf --yes --unit mm",),
        slow=True,
    ),
    Case(
        "PR310",
        "init p a.dxf --robot rv-4frl",
        {"a.dxf": dxf(line)},
        before=("init p",),
        then=("init p a.dxf",),
    ),
    Case(
        "CT105",
        "check a.dxf",
        {"a.dxf": dxf(apart)},
        change={"a.process.toml": "tolerance = 0.005\n"},
    ),
    Case(
        "CT107",
        "check a.dxf",
        {"a.dxf": dxf(far_apart)},
        change={"a.process.toml": "tolerance = 0.1\n"},
    ),
    Case(
        "CT108",
        "check a.dxf",
        {"a.dxf": dxf(of_short_sides)},
        change={"a.process.toml": "tolerance = 0.005\n"},
    ),
    Case(
        "CT201",
        "check a.dxf",
        {"a.dxf": dxf(two_layers), "a.process.toml": CUT},
        change={"a.process.toml": f'leave_out = ["NOTES"]\n{CUT}'},
    ),
    Case(
        "CT201",
        "check a.dxf",
        {"a.dxf": dxf(two_layers), "a.process.toml": CUT},
        change={"a.process.toml": f'{CUT}[layers."NOTES"]\n'},
    ),
    Case(
        "CT203",
        "check a.dxf",
        {"a.dxf": dxf(tiny)},
        change={"a.process.toml": "tolerance = 0.001\n"},
    ),
    Case(
        "CT322",
        "check a.dxf",
        {"a.dxf": dxf(line), "a.process.toml": HOLLOW},
        change={"a.process.toml": HOLLOW.replace("tangential = true\n", "")},
    ),
    Case(
        "CT322",
        "check a.dxf",
        {"a.dxf": dxf(line), "a.process.toml": HOLLOW},
        change={"a.process.toml": HOLLOW.replace("free_turn = true\n", "")},
    ),
    Case(
        "CT307",
        "check a.dxf",
        {"a.dxf": dxf(line), "a.process.toml": "[tools.knife]\ncentre = [0, 0, 60]\n"},
        change={"a.process.toml": "[tools.knife]\ncentre = [0, 0, 60]\nmass = 1.5\n"},
    ),
    Case(
        "CT312",
        "check a.dxf",
        {"a.dxf": dxf(line), "a.process.toml": '[signals.glue]\nkind = "digital"\nbits = 4\n'},
        change={"a.process.toml": '[signals.glue]\nkind = "group"\nbits = 4\n'},
    ),
    Case(
        "CT205",
        "check a.dxf",
        {"a.dxf": dxf(curved)},
        change={"a.process.toml": "tolerance = 0.001\n"},
        becomes="0.0003 mm",
    ),
)

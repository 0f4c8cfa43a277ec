"""Robots and columns of numbers as notebooks show them."""

from __future__ import annotations

import struct
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from lxml import html

import assistant
from assistant import robots
from assistant.base.columns import MOST_SHOWN_COLUMNS, MOST_SHOWN_ROWS, columns_html
from assistant.controllers.recording import Recording
from assistant.program.statements import Follow
from tests.api.test_offered import IRB, NASTY, PLATE, shown


def cells(page):
    return [[cell.text_content() for cell in row] for row in page.xpath("//tr")]


def size_of(png):
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    return struct.unpack(">II", png[16:24])


@pytest.mark.parametrize("name", robots.names())
def test_a_robot_shows_its_limits_and_how_it_stands(name):
    robot = robots.get(name)
    page = shown(robot)
    rows = cells(page)[1:]
    assert [row[0] for row in rows] == list(robot.axes)
    found = np.array([[float(part) for part in row[1:3]] for row in rows])
    assert found == pytest.approx(robot.limits, rel=1e-5)
    points = page.xpath("//polyline/@points")[0].split()
    assert all(0.0 <= float(part) <= 260.0 for point in points for part in point.split(","))
    assert name in repr(robot)


def test_names_in_a_file_of_a_robot_are_no_markup():
    page = shown(replace(robots.get(IRB), title=NASTY, maker=NASTY))
    assert "<script>alert(1)</script>" in page.text_content()


def test_columns_show_both_ends_and_their_range():
    many = {NASTY: np.arange(1000.0), "wide": np.arange(2000).reshape(1000, 2)}
    page = html.fromstring(columns_html(NASTY, many))
    assert not page.xpath("//script") and NASTY[:10] in page.text_content()
    rows = cells(page)
    assert [row[0] for row in rows[1:-1]] == ["0", "1", "2", "3", "…", "996", "997", "998", "999"]
    assert rows[-1] == ["from … to", "0 … 999", "0 … 1998", "1 … 1999"]
    assert rows[-2][1:] == ["999", "1998", "1999"]
    short = cells(html.fromstring(columns_html("few", {"a": np.array([np.nan, 2.0])})))
    assert [row[-1] for row in short] == ["a", "nan", "2", "2 … 2"]
    assert cells(html.fromstring(columns_html("none", {}))) == [[""]]
    wide = html.fromstring(
        columns_html("wide", {"a": np.zeros((MOST_SHOWN_ROWS, MOST_SHOWN_COLUMNS + 7))})
    )
    assert len(cells(wide)[0]) == MOST_SHOWN_COLUMNS + 1 and "7 more columns" in wide.text_content()


def test_paths_samples_and_recordings_are_columns():
    program = assistant.from_poses(
        [[300, y, 300, 0, 1, 0, 0] for y in range(-50, 51)], unit="mm", robot=IRB
    )
    paths = [one.path for one in program.statements() if isinstance(one, Follow)]
    page = shown(paths[0])
    assert cells(page)[2][1] == "linear" and "-50 … 50" in page.text_content()
    done = assistant.simulate(program)
    page = shown(done.simulation.samples)
    assert len(cells(page)[0]) == 1 + 1 + 6 + 3 + 1
    assert f"{len(done.simulation.samples)} rows" in page.text_content()
    recording = Recording({"seconds": (), "joint": ("J1", NASTY)})
    recording.add(0.5, (1.0, 2.0))
    page = shown(recording)
    assert cells(page)[1] == ["0", "0.5", "1", "2"] and "joint.J1" in page.text_content()


def test_a_simulation_is_a_picture_where_matplotlib_is(monkeypatch):
    done = assistant.simulate(PLATE, robot=IRB)
    assert size_of(done._repr_png_()) == (770, 385)
    assert done.plot()._repr_png_() == done._repr_png_()
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert done._repr_png_() is None


def test_what_notebooks_show_loads_no_library_of_pictures():
    code = (
        "from assistant import robots; import sys\n"
        "robots.get('rv-2aj')._repr_html_()\n"
        "from assistant.blocks.diagrams import Diagram\n"
        "import assistant.blocks.display, assistant.program.se3\n"
        "print({'matplotlib', 'spatialmath', 'bdsim', 'roboticstoolbox'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"

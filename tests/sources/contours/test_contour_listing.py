"""Contours are listed with the numbers of the picture of the order, and named by a point."""

from __future__ import annotations

from pathlib import Path

import ezdxf
import pytest

from assistant.base.source_text import SourceText
from assistant.report.track import ways
from assistant.sources.contours.contour_listing import ListedContour, listed_contours
from assistant.sources.contours.contour_order import distance_to_outline
from assistant.sources.contours.curves import chorded
from assistant.sources.contours.layer_program import contour_program
from assistant.sources.drawing import read, read_contents
from assistant.sources.process.file import parse_process
from tests.sources.contours.test_contour_choice import plate

__all__ = ["plate"]

PASSES = (
    "[layers.CUT]\ndepth = 4\npasses = 2\napproach = 10\nretract = 10\n[layers.SEAM]\nspeed=5\n"
)
PLACED = "[placement]\nposition = [300, 0, 0]\neuler_zyx = [90, 0, 0]\n"


def listed(path: Path, text: str) -> list[ListedContour]:
    process = parse_process(SourceText(text, "x.toml"))
    contents = read_contents(path, process)
    made = contour_program(contents.curves, process, taken=set())
    return list(listed_contours(made.choice, made.order, process))


@pytest.mark.parametrize("text", ["", PASSES, PLACED, "leave_out = [{number = 2}, {group = 2}]"])
def test_numbers_are_those_of_the_picture(plate: Path, text: str) -> None:
    made = read(plate, parse_process(SourceText(text, "x.toml")))
    starts = [way.positions[0] for way in ways(made.program) if way.name is not None]
    numbers = [number for one in listed(plate, text) for number in one.numbers]
    assert sorted(numbers) == list(range(1, len(starts) + 1))
    for one in listed(plate, text):
        assert bool(one.numbers) is not bool(one.left_by)
        for number in one.numbers:
            curves = [chorded(curve, 0.01)[:, :2] for curve in one.contour.curves]
            assert min(distance_to_outline(starts[number - 1][:2], c) for c in curves) < 0.1


@pytest.mark.parametrize("text", ["", PLACED])
def test_the_point_of_a_contour_leaves_out_that_one_alone(plate: Path, text: str) -> None:
    every = listed(plate, text)
    assert len(every) == 6 and {one.text.split()[0] for one in every} == {"outline", "hole", "line"}
    for i, one in enumerate(every):
        assert one.at is not None
        entry = f'leave_out = [{{layer = "{one.contour.layer}", at = {list(one.at)}}}]\n{text}'
        assert [k for k, other in enumerate(listed(plate, entry)) if other.left_by] == [i]


def test_contours_that_meet_have_points_of_their_own(tmp_path: Path) -> None:
    document = ezdxf.new(units=4)
    space = document.modelspace()
    for x in (0, 10):
        corners = [(x, 0), (x + 10, 0), (x + 10, 10), (x, 10)]
        space.add_lwpolyline(corners, close=True, dxfattribs={"layer": "A"})
    path = tmp_path / "two.dxf"
    document.saveas(path)
    for one in listed(path, ""):
        entry = f'leave_out = [{{layer = "A", at = {list(one.at or ())}}}]'
        assert sum(bool(other.left_by) for other in listed(path, entry)) == 1

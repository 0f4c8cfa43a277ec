"""Contours are left out by a place, a number or a group, and views beside a part are seen."""

from __future__ import annotations

import re
from pathlib import Path

import ezdxf
import pytest

from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText
from assistant.program.program import Program
from assistant.report.track import ways
from assistant.sources.drawing import read
from assistant.sources.process.file import parse_process
from assistant.sources.reading import Reading

HOLES = ((30.0, 30.0), (170.0, 30.0), (125.0, 70.0))


def rectangle(space, x: float, y: float, width: float, height: float, layer: str = "CUT") -> None:
    corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
    space.add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})


@pytest.fixture
def plate(tmp_path: Path) -> Path:
    """A plate with holes, an open line on it, and its side view below."""
    document = ezdxf.new(units=4)
    space = document.modelspace()
    rectangle(space, 0, 0, 200, 100)
    for x, y in HOLES:
        space.add_circle((x, y), 3.3, dxfattribs={"layer": "CUT"})
    space.add_line((50, 50), (90, 50), dxfattribs={"layer": "SEAM"})
    rectangle(space, 0, -60, 200, 5)
    path = tmp_path / "plate.dxf"
    document.saveas(path)
    return path


def reading(path: Path, text: str = "") -> Reading:
    return read(path, parse_process(SourceText(text, "x.toml")))


def starts(program: Program) -> list[tuple[float, float]]:
    """Where each contour starts, in the order of the program."""
    found = (way.positions[0] for way in ways(program) if way.name is not None)
    return [(round(float(x), 1), round(float(y), 1)) for x, y, _ in found]


def codes(made: Reading) -> list[str]:
    return [finding.code for finding in made.findings]


def refused(path: Path, text: str) -> str:
    with pytest.raises(Refused) as caught:
        reading(path, text)
    (finding,) = [one for one in caught.value.findings if one.severity == "error"]
    return f"{finding.code} {finding.message} {finding.cure}"


def near(points: list[tuple[float, float]], at: tuple[float, float], off: float = 5.0) -> bool:
    return any(abs(x - at[0]) < off and abs(y - at[1]) < off for x, y in points)


@pytest.mark.parametrize("at", ((30, 30), (33.3, 30), (33.1, 30.3)))
def test_a_point_in_a_hole_or_on_its_line_leaves_the_hole_out(plate: Path, at) -> None:
    made = reading(plate, f'leave_out = [{{layer = "cut", at = {list(at)}}}]')
    assert len(starts(made.program)) == 5
    assert not near(starts(made.program), (30, 30))
    # In the hole it is in the plate as well: the innermost wins, and that is said.
    assert ("CT231" in codes(made)) is (at == (30, 30))


@pytest.mark.parametrize(
    ("at", "what"),
    (
        ("30, 30", "CT231 hole dia. 6.6 at 30, 30 on layer 'CUT'"),
        ("33.3, 30", "CT240 hole dia. 6.6 at 30, 30 on layer 'CUT'"),
        ("70, 50.2", "CT240 the line of 40 mm, from 50, 50 to 90, 50 on layer 'SEAM'"),
        ("100, -57", "CT240 outline 200 x 5 on layer 'CUT'"),
        ("0, 50", "CT241 outline 200 x 100 on layer 'CUT'; 4 contours that lie in it are followed"),
    ),
)
def test_each_entry_says_which_contour_it_leaves_out(plate: Path, at: str, what: str) -> None:
    code, _, named = what.partition(" ")
    (said,) = [one for one in reading(plate, f"leave_out = [{{at = [{at}]}}]").findings
               if one.code in {"CT231", "CT240", "CT241"}]  # fmt: skip
    assert (said.code, named in said.message) == (code, True), said.message


def test_a_point_that_missed_a_hole_does_not_leave_out_the_plate(plate: Path) -> None:
    """It lies in the plate, whose holes would be followed without the outline."""
    said = refused(plate, 'leave_out = [{layer = "CUT", at = [34.3, 30]}]')
    assert said.startswith("CT242 ")
    assert "outline 200 x 100 on layer 'CUT', which holds 3 contours" in said
    assert "the nearest hole dia. 6.6 at 30, 30 on layer 'CUT', 1.0 mm away" in said
    # What the cure says leaves out the plate after all, with a warning.
    entry = re.search(r'\{layer = "CUT", at = .*?\}', said.partition("this one is")[2])
    assert entry
    made = reading(plate, f"leave_out = [{entry[0]}]")
    assert len(starts(made.program)) == 5
    assert "CT241" in codes(made)
    # With all that lies in it left out as well, nothing is followed without it.
    holes = ", ".join(f"{{at = [{x}, {y}]}}" for x, y in HOLES)
    whole = reading(plate, f'leave_out = [{{layer = "CUT", at = [34.3, 30]}}, {holes}]')
    assert len(starts(whole.program)) == 2


def test_a_point_on_an_open_line_leaves_that_out_and_not_what_is_around_it(plate: Path) -> None:
    made = reading(plate, "leave_out = [{at = [70, 50.2]}]")
    names = [one.name for one in made.program.procedures]
    assert "CUT" in names and "SEAM" not in names
    assert len(starts(made.program)) == 5


def test_a_point_is_of_the_drawing_wherever_it_is_placed(plate: Path) -> None:
    placed = "[placement]\nposition = [500, 100, 7]\neuler_zyx = [90, 0, 0]"
    made = reading(plate, f"leave_out = [{{at = [125, 70]}}]\n{placed}")
    assert len(starts(made.program)) == 5
    assert not near(starts(made.program), (500 - 70, 100 + 125))


def test_a_point_in_no_contour_is_refused_with_the_nearest_one(plate: Path) -> None:
    said = refused(plate, "leave_out = [{at = [100, 110]}]")
    assert said.startswith("CT230 ")
    assert "200.0 x 100.0 mm around [100.0, 50.0] on layer 'CUT', 10.0 mm away" in said
    assert "none is followed" in refused(plate, 'leave_out = [{layer = "X", at = [30, 30]}]')


def test_a_point_where_two_lines_meet_is_refused(plate: Path) -> None:
    document = ezdxf.readfile(plate)
    document.modelspace().add_line((90, 50), (90, 60), dxfattribs={"layer": "OTHER"})
    document.save()
    assert refused(plate, "leave_out = [{at = [90, 50]}]").startswith("CT232 ")
    only = reading(plate, 'leave_out = [{layer = "OTHER", at = [90, 50]}]')
    assert len(starts(only.program)) == 6


def test_a_number_is_that_of_the_order_and_its_finding_names_the_place(plate: Path) -> None:
    every = starts(reading(plate).program)
    for number in range(1, len(every) + 1):
        made = reading(plate, f"leave_out = [{{number = {number}}}]")
        assert len(starts(made.program)) == len(every) - 1
        (told,) = [one for one in made.findings if one.code == "CT234"]
        entry = re.search(r"leave_out = \[.*\]", told.cure or "")
        assert entry
        # What the cure says instead leaves the same contour out.
        again = reading(plate, entry[0])
        assert starts(again.program) == starts(made.program)
        assert "CT234" not in codes(again)


def test_no_cure_leaves_out_a_complete_layer(tmp_path: Path) -> None:
    """Two contours run along each other, so that no point names one of them alone."""
    document = ezdxf.new(units=4)
    for off in (0.0, 0.015):
        rectangle(document.modelspace(), off, off, 50 - off, 50 - off)
    path = tmp_path / "a.dxf"
    document.saveas(path)
    made = reading(path, "tolerance = 0.001\nleave_out = [{number = 1}]")
    (told,) = [one for one in made.findings if one.code == "CT234"]
    assert 'layer = "CUT", at = [' in (told.cure or "")


def test_numbers_are_all_of_the_same_order(plate: Path) -> None:
    one = reading(plate, "leave_out = [{number = 1}, {number = 2}, {number = 5}]")
    other = reading(plate, "leave_out = [{number = 5}, {number = 1}, {number = 2}]")
    assert starts(one.program) == starts(other.program)
    assert len(starts(one.program)) == 3


def test_a_number_that_there_is_not_is_refused(plate: Path) -> None:
    assert "the order has 6" in refused(plate, "leave_out = [{number = 7}]")
    # The outline on CUT comes after what lies inside it on SEAM.
    last = len(starts(reading(plate).program))
    assert "on layer" in refused(plate, f'leave_out = [{{layer = "SEAM", number = {last}}}]')


def test_a_contour_that_is_left_out_does_not_count_as_around_others(tmp_path: Path) -> None:
    """A frame around a plate would make its outline a hole, cut from inside."""
    document = ezdxf.new(units=4)
    rectangle(document.modelspace(), 0, 0, 100, 100)
    path = tmp_path / "a.dxf"
    document.saveas(path)
    layer = "[layers.CUT]\noffset = 2"
    alone = reading(path, layer)
    rectangle(document.modelspace(), -50, -50, 200, 200)
    document.saveas(path)
    made = reading(path, f"leave_out = [{{at = [-50, 0]}}]\n{layer}")
    assert made.program == alone.program
    (number,) = [
        n
        for n in (1, 2)
        if reading(path, f"leave_out = [{{number = {n}}}]\n{layer}").program == alone.program
    ]
    assert number == 2  # the outer one comes last


def test_another_view_is_noticed_and_left_out_by_its_group(plate: Path) -> None:
    (note,) = [one for one in reading(plate).findings if one.code == "CT229"]
    assert "1: 5 contours, 200.0 x 100.0 mm from [0.0, 0.0]" in note.message
    assert "2: 1 contour, 200.0 x 5.0 mm from [0.0, -60.0]" in note.message
    made = reading(plate, "leave_out = [{group = 2}]")
    assert "CT229" not in codes(made)
    assert len(starts(made.program)) == 5
    assert min(y for _, y in starts(made.program)) >= 0
    only = reading(plate, "leave_out = [{group = 1}]")
    assert len(starts(only.program)) == 1
    assert refused(plate, "leave_out = [{group = 3}]").startswith("CT235 ")


def test_copies_of_a_part_and_holes_far_apart_are_no_views(tmp_path: Path) -> None:
    document = ezdxf.new(units=4)
    for x in (0, 250):
        rectangle(document.modelspace(), x, 0, 100, 50)
        document.modelspace().add_circle((x + 20, 20), 5, dxfattribs={"layer": "CUT"})
    path = tmp_path / "a.dxf"
    document.saveas(path)
    assert "CT229" not in codes(reading(path))


def test_nothing_left_is_refused(plate: Path) -> None:
    assert refused(plate, "leave_out = [{group = 1}, {group = 2}]").startswith("DX007 ")


WRONG = ("3", "[3]", "[[]]", "[{}]", '[{layer = "A"}]', "[{at = [1]}]", "[{at = [nan, 1]}]",
         "[{number = 0}]", "[{number = 1.5}]", "[{at = [1, 1], number = 1}]", "[{colour = 3}]",
         '[{layer = "A", group = 1}]', '[{layer = 3, at = [1, 1]}]', '[""]')  # fmt: skip


@pytest.mark.parametrize("value", WRONG)
def test_wrong_entries_are_refused_in_their_line(value: str) -> None:
    with pytest.raises(Refused) as caught:
        parse_process(SourceText(f"leave_out = {value}", "x.toml"))
    (finding,) = caught.value.findings
    assert (finding.code, finding.line) == ("CT303", 1)
    assert finding.cure

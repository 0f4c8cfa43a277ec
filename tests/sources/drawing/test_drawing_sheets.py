"""Borders and title blocks on the layer of the work are known by their shape; plates stay."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import ezdxf
import pytest
from ezdxf.document import Drawing

from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText
from assistant.sources.drawing import read, read_contents
from assistant.sources.drawing.survey import survey
from assistant.sources.process import NO_PROCESS, Process
from assistant.sources.process.file import parse_process
from tests.sources.drawing.conftest import Save

Space = Any
Place = tuple[float, float]


def rectangle(space: Space, low: Place, high: Place, *, lines: bool = False) -> None:
    corners = [low, (high[0], low[1]), high, (low[0], high[1])]
    if not lines:
        space.add_lwpolyline(corners, close=True)
        return
    for start, end in zip(corners, [*corners[1:], corners[0]], strict=True):
        space.add_line(start, end)


def part(space: Space, x: float = 100.0, y: float = 150.0) -> set[str]:
    """A plate with two holes; its handles."""
    outline = space.add_lwpolyline(
        [(x, y), (x + 120, y), (x + 120, y + 60), (x, y + 60)], close=True
    )
    holes = [space.add_circle((x + 20 + 80 * k, y + 30), 6) for k in range(2)]
    return {one.dxf.handle for one in (outline, *holes)}


def title_block(space: Space, right: float, bottom: float, texts: int = 6) -> None:
    """Lines of a title block of 170 x 30 in a corner, with a logo in a cell."""
    left, top = right - 170, bottom + 30
    space.add_line((left, bottom), (left, top))
    space.add_line((left, top), (right, top))
    for y in (bottom + 10, bottom + 20):
        space.add_line((left, y), (right, y))
    for x in (left + 40, left + 80, left + 120):
        space.add_line((x, bottom), (x, top))
    space.add_circle((left + 20, bottom + 15), 3)
    space.add_line((left - 0.2, bottom + 9.8), (left + 39.8, bottom + 9.8))  # beside its place
    for k in range(texts):
        space.add_text("Scale 1:1", height=3).set_placement((left + 5 + 25 * k, bottom + 2))


def sheet(space: Space) -> None:
    """A3 with its edge, a border with a margin for binding, and marks."""
    rectangle(space, (0, 0), (420, 297), lines=True)
    rectangle(space, (20, 10), (410, 287), lines=True)
    for x in (105, 315):
        space.add_line((x, 0), (x, 10))
    space.add_line((210, 0), (210, 15))  # to the middle, over the border
    title_block(space, 410, 10)


def followed(path: Path, given: Process = NO_PROCESS) -> set[str]:
    """Handles of the entities that are followed."""
    return {curve.handle for curve in read_contents(path, given).curves}


def process(text: str) -> Process:
    return parse_process(SourceText(text, "x.toml"))


def codes(path: Path, given: Process = NO_PROCESS) -> list[str]:
    return [one.code for one in read_contents(path, given).findings]


def test_a_border_with_a_title_block_is_off_and_its_cure_switches_it_on(
    save: Save, drawing: Drawing
) -> None:
    space = drawing.modelspace()
    sheet(space)
    work = part(space)
    path = save(drawing)
    assert followed(path) == work
    (note,) = [one for one in read(path, NO_PROCESS).findings if one.code == "DX212"]
    assert "border `390 x 277 mm` (with a title block, " in note.message
    assert 'follow = ["border"]' in (note.cure or "")
    every = {one.dxf.handle for one in space.query("LINE LWPOLYLINE CIRCLE")}
    assert followed(path, process('follow = ["border"]')) == every
    assert followed(path, process('follow = ["*"]')) == every
    # A table of the layer is about the work on it.
    assert followed(path, process("[layers.0]")) == work


def test_the_border_is_known_wherever_the_drawing_is_placed(save: Save, drawing: Drawing) -> None:
    sheet(drawing.modelspace())
    work = part(drawing.modelspace())
    path = save(drawing)
    turned = "[placement]\nposition = [400, 30, 200]\neuler_zyx = [33, 0, 0]\n"
    assert followed(path, process(turned)) == work


def test_each_sheet_of_several_has_its_border(save: Save, drawing: Drawing) -> None:
    block = drawing.blocks.new("SHEET")
    sheet(block)
    space = drawing.modelspace()
    for x in (0, 600, 1200):
        space.add_blockref("SHEET", (x, 0))
    work = part(space) | part(space, 720)
    assert followed(save(drawing)) == work


def test_a_sheet_in_inches_and_marks_for_cutting(save: Save) -> None:
    document = ezdxf.new("R2010", units=1)
    space = document.modelspace()
    block = document.blocks.new("FORM")
    rectangle(block, (10, 10), (290, 200))
    title_block(block, 290, 10)
    for x, dx in ((0, 8), (300, -8)):
        for y, dy in ((0, 8), (210, -8)):
            block.add_line((x, y), (x + dx, y))
            block.add_line((x, y), (x, y + dy))
    space.add_blockref(
        "FORM", (0, 0), dxfattribs=dict.fromkeys(("xscale", "yscale", "zscale"), 1 / 25.4)
    )
    work = {space.add_circle((5, 5), 1).dxf.handle}
    assert followed(save(document)) == work


def test_a_title_block_with_a_name_is_a_sign_of_its_border(save: Save, drawing: Drawing) -> None:
    space = drawing.modelspace()
    rectangle(space, (0, 0), (390, 277))
    title_block(drawing.blocks.new("Title block"), 390, 0)
    space.add_blockref("Title block", (0, 0))
    work = part(space)
    assert followed(save(drawing)) == work


def test_lines_beside_the_table_and_views_in_large_cells_stay(save: Save, drawing: Drawing) -> None:
    space = drawing.modelspace()
    sheet(space)
    # From side to side of the border, as a bend line of a sheet-metal part drawn over it would be.
    across = space.add_line((20, 140), (410, 140)).dxf.handle
    work = part(space)
    assert followed(save(drawing)) == work | {across}


def plate(space: Space) -> None:
    rectangle(space, (0, 0), (297, 210))
    for x in (20, 277):
        for y in (20, 190):
            space.add_circle((x, y), 5)


def bent(space: Space) -> None:
    rectangle(space, (0, 0), (420, 297), lines=True)
    for y in (50, 80, 110, 140, 170, 247):
        space.add_line((0, y), (420, y))
        space.add_text("UP 90", height=5).set_placement((30, y + 2))


def hidden(space: Space) -> None:
    """The plate with hidden edges around its holes."""
    plate(space)
    for x in (20, 277):
        space.add_circle((x, 20), 8, dxfattribs={"layer": "Hidden (ISO)"})


def gasket(space: Space) -> None:
    rectangle(space, (0, 0), (297, 210))
    rectangle(space, (15, 15), (282, 195))
    for x in (7, 290):
        space.add_circle((x, 105), 3)


def nested(space: Space) -> None:
    """Parts with holes in the opening of a plate that is no sheet of paper."""
    rectangle(space, (0, 0), (400, 250))
    space.add_text("t = 3", height=5).set_placement((10, 10))
    part(space)


def crossed(space: Space) -> None:
    sheet(space)
    space.add_line((-100, 140), (200, 160))


def without_texts(space: Space) -> None:
    rectangle(space, (0, 0), (380, 270))
    title_block(space, 380, 0, texts=0)
    part(space)


@pytest.mark.parametrize("draw", (plate, bent, gasket, nested, without_texts))
def test_what_may_be_a_part_stays(
    save: Save, drawing: Drawing, draw: Callable[[Space], None]
) -> None:
    space = drawing.modelspace()
    draw(space)
    path = save(drawing)
    assert followed(path) == {one.dxf.handle for one in space.query("LINE LWPOLYLINE CIRCLE")}
    assert not {"DX212", "DX214"} & set(codes(path))


@pytest.mark.parametrize("size", ((297, 210), (215.9, 279.4), (841, 594)))
def test_an_edge_of_paper_around_parts_is_off(
    save: Save, drawing: Drawing, size: tuple[float, float]
) -> None:
    space = drawing.modelspace()
    rectangle(space, (0, 0), size)
    space.add_text("M 1:1", height=3).set_placement((10, 10))
    work = part(space, 50, 60)
    assert followed(save(drawing)) == work


def test_an_edge_with_a_border_in_it_is_off(save: Save, drawing: Drawing) -> None:
    space = drawing.modelspace()
    rectangle(space, (0, 0), (420, 297))
    rectangle(space, (10, 10), (410, 287))
    space.add_line((210, 0), (210, 10))
    space.add_text("M 1:1", height=3).set_placement((15, 15))
    circle = space.add_circle((200, 100), 30).dxf.handle
    assert followed(save(drawing)) == {circle}


def test_a_plate_as_large_as_paper_with_dimensions_is_the_users_choice(
    save: Save, drawing: Drawing
) -> None:
    space = drawing.modelspace()
    plate(space)
    space.add_linear_dim(base=(0, -20), p1=(0, 0), p2=(297, 0)).render()
    path = save(drawing)
    with pytest.raises(Refused) as refused:
        read(path, NO_PROCESS)
    (finding,) = [one for one in refused.value.findings if one.severity == "error"]
    assert finding.code == "DX214"
    assert "297 x 210 mm" in finding.message
    assert "A4" in finding.message
    every = {one.dxf.handle for one in space.query("LWPOLYLINE CIRCLE")}
    circles = {one.dxf.handle for one in space.query("CIRCLE")}
    assert followed(path, process('follow = ["border"]')) == every
    assert followed(path, process('leave_out = ["border"]')) == circles
    for choice in ("follow", "leave_out"):
        assert read(path, process(f'{choice} = ["border"]')).program.procedures


def test_a_survey_has_the_size_of_the_work(save: Save, drawing: Drawing) -> None:
    sheet(drawing.modelspace())
    part(drawing.modelspace())
    found = survey(save(drawing), NO_PROCESS)
    (layer,) = [one for one in found.layers if one.name == "0"]
    assert layer.closed == 3
    assert [(one.what, one.name) for one in layer.parts] == [("border", "390 x 277 mm")]
    assert found.extents is not None
    assert found.extents.size == pytest.approx((120.0, 60.0, 0.0), abs=0.01)


def test_an_empty_form_is_refused_with_the_cure(save: Save, drawing: Drawing) -> None:
    sheet(drawing.modelspace())
    path = save(drawing)
    with pytest.raises(Refused) as refused:
        read(path, NO_PROCESS)
    (finding,) = [one for one in refused.value.findings if one.severity == "error"]
    assert finding.code == "DX011"
    assert 'follow = ["border"]' in (finding.cure or "")


def framed(space: Space, *, height: float = 222.0, margin: float = 10.0) -> set[str]:
    """Two frames around a part, at a scale that no paper has."""
    rectangle(space, (0, 0), (314, height), lines=True)
    rectangle(space, (margin, 10), (304, height - 10), lines=True)
    space.add_text("view A", height=3).set_placement((50, 30))
    return part(space, 60, 80)


@pytest.mark.parametrize("margin", [10.0, 20.0])
def test_two_frames_in_the_proportion_of_a_sheet_are_off(
    save: Save, drawing: Drawing, margin: float
) -> None:
    kept = framed(drawing.modelspace(), margin=margin)
    contents = read_contents(save(drawing), NO_PROCESS)
    assert {curve.handle for curve in contents.curves} == kept
    (finding,) = [one for one in contents.findings if one.code == "DX212"]
    assert "314 x 222 mm" in finding.message
    assert "two frames of a sheet" in finding.message


@pytest.mark.parametrize("margin", [5.0, 10.0])
def test_frames_in_another_proportion_stay(save: Save, drawing: Drawing, margin: float) -> None:
    height = 270.0 if margin == 10.0 else 222.0
    kept = framed(drawing.modelspace(), height=height, margin=margin)
    space = drawing.modelspace()
    if margin == 5.0:  # uneven margins
        rectangle(space, (12, 12), (300, 205), lines=True)
    assert len(followed(save(drawing))) > len(kept)


@pytest.mark.parametrize("marks", [False, True])
def test_a_plate_with_an_even_rim_is_the_users_choice(
    save: Save, drawing: Drawing, marks: bool
) -> None:
    space = drawing.modelspace()
    rectangle(space, (0, 0), (280, 200))
    rectangle(space, (20, 20), (260, 180))
    bores = {space.add_circle((100, 100), radius).dxf.handle for radius in (6, 10)}
    space.add_text("pocket", height=5).set_placement((150, 100))
    if marks:  # of the middle of paper
        space.add_line((140, 0), (140, 20))
    path = save(drawing)
    assert ("DX214" in codes(path)) is not marks
    assert len(followed(path)) == (2 if marks else 4)
    assert followed(path, process('leave_out = ["border"]')) == bores
    assert not {"DX212", "DX214"} & set(codes(path, process('follow = ["border"]')))


def grid(space: Space, *, line_type: str = "CENTER", texts: bool = True) -> set[str]:
    """A part with two axes of a grid that end in circles with letters."""
    handles = part(space)
    for x in (120, 200):
        space.add_line((x, 60), (x, 230), dxfattribs={"linetype": line_type})
        space.add_circle((x, 52), 8)
        if texts:
            space.add_text("A", height=5).set_placement((x - 2, 50))
    return handles


def test_circles_with_texts_at_the_end_of_centre_lines_are_off(
    save: Save, drawing: Drawing
) -> None:
    drawing.linetypes.add("CENTER", [1.0, 0.5, -0.5])
    kept = grid(drawing.modelspace())
    contents = read_contents(save(drawing), NO_PROCESS)
    assert {curve.handle for curve in contents.curves} == kept
    (finding,) = [one for one in contents.findings if one.code == "DX212"]
    assert "⌀16 mm" in finding.message
    assert len(followed(save(drawing), process('follow = ["border"]'))) == len(kept) + 2


@pytest.mark.parametrize("change", [{"line_type": "Continuous"}, {"texts": False}])
def test_circles_at_the_end_of_other_lines_or_without_texts_stay(
    save: Save, drawing: Drawing, change: dict[str, Any]
) -> None:
    drawing.linetypes.add("CENTER", [1.0, 0.5, -0.5])
    kept = grid(drawing.modelspace(), **change)
    assert len(followed(save(drawing)) - kept) >= 2


def test_a_hole_with_a_text_in_it_and_a_centre_line_through_it_stays(
    save: Save, drawing: Drawing
) -> None:
    drawing.linetypes.add("CENTER", [1.0, 0.5, -0.5])
    space = drawing.modelspace()
    for x in (120, 200):
        space.add_line((x, 60), (x, 160), dxfattribs={"linetype": "CENTER"})
        space.add_circle((x, 110), 12)
        space.add_text("M24", height=5).set_placement((x - 4, 110))
    assert len(followed(save(drawing))) == 2


def test_a_survey_says_that_a_layer_has_balloons_beside_lines(save: Save, drawing: Drawing) -> None:
    drawing.linetypes.add("CENTER", [1.0, 0.5, -0.5])
    space = drawing.modelspace()
    for x in (0, 100):
        space.add_line((x, 8), (x, 60), dxfattribs={"linetype": "CENTER"})
        space.add_line((x, 60), (x, 90), dxfattribs={"linetype": "CENTER"})
        space.add_circle((x, 0), 8)
        space.add_text("A", height=5).set_placement((x - 2, 0))
    (layer,) = [one for one in survey(save(drawing), NO_PROCESS).layers if one.name == "0"]
    assert "balloons around texts" in layer.drafting and "CENTER" in layer.drafting


def test_round_plates_with_texts_and_centre_marks_stay(save: Save, drawing: Drawing) -> None:
    drawing.linetypes.add("CENTER", [1.0, 0.5, -0.5])
    space = drawing.modelspace()
    for x in (0, 100, 200):
        space.add_circle((x, 0), 40)
        space.add_text("P1", height=8).set_placement((x - 5, 0))
        for low, high in ((40, 65), (-40, -65)):
            space.add_line((x, low), (x, high), dxfattribs={"linetype": "CENTER"})
    assert len(followed(save(drawing))) == 3


def test_blocks_of_steelwork_drawings_are_known_by_their_kind(save: Save, drawing: Drawing) -> None:
    kept = set()
    names = ("Part-35-47 - 46", "StraightDimension-35-48 - 46", "Mark-35-50 - 46", "Unknown-35-51")
    for name in (*names, "Text-35-57", "Bolt-35-58 - 46", "Text-35"):
        block = drawing.blocks.new(name)
        line = block.add_line((0, 0), (50, 10 * len(block.name)))
        if name.startswith(("Part", "Bolt")) or name == "Text-35":
            kept.add(line.dxf.handle)
        drawing.modelspace().add_blockref(name, (0, 0))
    assert followed(save(drawing)) == kept


@pytest.mark.parametrize(
    ("length", "layer", "attribute", "bar", "kept"),
    [
        (8.0, "DIM", True, "THICK", 0),
        (80.0, "DIM", True, "THICK", 1),  # a cut beside a label
        (8.0, "PART", True, "THICK", 2),  # nothing in it is drafting
        (8.0, "DIM", False, "THICK", 1),  # without a text
        (8.0, "DIM", True, "CUT", 1),  # a slit of the work
    ],
)
def test_the_bar_of_a_datum_symbol_is_drafting(
    save: Save, drawing: Drawing, length: float, layer: str, attribute: bool, bar: str, kept: int
) -> None:
    block = drawing.blocks.new("BASE4")
    block.add_line((0, 0), (length, 0), dxfattribs={"layer": bar})
    block.add_circle((4, 10), 4, dxfattribs={"layer": layer})
    if attribute:
        block.add_attdef("A", (2, 8), height=3.5)
    drawing.modelspace().add_blockref("BASE4", (50, 50))
    drawing.modelspace().add_line((0, 0), (90, 0))
    assert len(followed(save(drawing))) == 1 + kept


def small_block(
    space: Space, corner: Place, into: tuple[int, int], *, texts: int = 4, closed: bool = False
) -> None:
    """Two by two cells of 90 x 25 mm in a corner of a border. into: signs of the way inside."""
    (x, y), (dx, dy) = corner, into
    far = x + 180 * dx, y + 50 * dy
    if closed:
        rectangle(space, (min(x, far[0]), min(y, far[1])), (max(x, far[0]), max(y, far[1])))
    else:
        space.add_line((far[0], y), far)
        space.add_line(far, (x, far[1]))
    space.add_line((x, y + 25 * dy), (far[0], y + 25 * dy))
    space.add_line((x + 90 * dx, y), (x + 90 * dx, far[1]))
    for k in range(texts):
        at = (x + dx * (30 + 90 * (k % 2)), y + dy * (10 + 25 * (k // 2)))
        space.add_text("Rev. B", height=5).set_placement(at)


CORNERS = (((390, 0), (-1, 1)), ((0, 0), (1, 1)), ((0, 277), (1, -1)), ((390, 277), (-1, -1)))


@pytest.mark.parametrize("edge", (False, True))
@pytest.mark.parametrize("closed", (False, True))
@pytest.mark.parametrize(("corner", "into"), CORNERS)
def test_a_title_block_of_few_lines_is_off_in_any_corner(
    save: Save,
    drawing: Drawing,
    corner: Place,
    into: tuple[int, int],
    closed: bool,
    edge: bool,
) -> None:
    space = drawing.modelspace()
    rectangle(space, (0, 0), (390, 277))
    if edge:
        rectangle(space, (-20, -10), (400, 287))
    small_block(space, corner, into, closed=closed)
    work = part(space)
    path = save(drawing)
    assert followed(path) == work
    assert not {"DX214", "DX215"} & set(codes(path))


def test_lines_of_a_title_block_without_texts_are_off_in_the_edge_of_paper(
    save: Save, drawing: Drawing
) -> None:
    space = drawing.modelspace()
    rectangle(space, (-20, -10), (400, 287))
    rectangle(space, (0, 0), (390, 277))
    small_block(space, (390, 0), (-1, 1), texts=0)
    work = part(space)
    assert followed(save(drawing)) == work


def test_a_title_block_in_a_block_with_attributes_is_off(save: Save, drawing: Drawing) -> None:
    block = drawing.blocks.new("F1")
    rectangle(block, (0, 0), (390, 277), lines=True)
    small_block(block, (390, 0), (-1, 1), texts=0)
    for tag, at in (("NR", (220, 10)), ("REV", (310, 10)), ("MAT", (220, 35))):
        block.add_attdef(tag, at)
    space = drawing.modelspace()
    space.add_blockref("F1", (0, 0)).add_auto_attribs({"NR": "1", "REV": "A", "MAT": "steel"})
    work = part(space)
    assert followed(save(drawing)) == work


@pytest.mark.parametrize("size", ((180, 277), (277, 180), (267, 190), (584, 410), (1159, 821)))
def test_borders_of_every_size_are_off(
    save: Save, drawing: Drawing, size: tuple[float, float]
) -> None:
    space = drawing.modelspace()
    rectangle(space, (0, 0), size)
    small_block(space, (size[0], 0), (-1, 1))
    work = part(space, 20, 100)
    assert followed(save(drawing)) == work


@pytest.mark.parametrize("size", ((10.0, 7.5), (16.0, 10.0), (16.24, 9.76), (21.0, 33.0)))
def test_borders_in_inches_are_off(save: Save, size: tuple[float, float]) -> None:
    document = ezdxf.new("R2010", units=1)
    space = document.modelspace()
    rectangle(space, (0, 0), size)
    block = document.blocks.new("F")
    small_block(block, (0, 0), (-1, 1))
    inch = dict.fromkeys(("xscale", "yscale", "zscale"), 1 / 25.4)
    space.add_blockref("F", (size[0], 0), dxfattribs=inch)
    work = {space.add_circle((3, 5), 1).dxf.handle}
    assert followed(save(document)) == work


def test_a_title_block_drawn_short_of_its_border_is_off(save: Save, drawing: Drawing) -> None:
    space = drawing.modelspace()
    rectangle(space, (0, 0), (390, 277))
    small_block(space, (389.6, 0.4), (-1, 1))
    space.add_circle((250, 10), 4)
    work = part(space)
    assert followed(save(drawing)) == work


def test_a_line_that_divides_texts_off_a_border_is_off(save: Save, drawing: Drawing) -> None:
    space = drawing.modelspace()
    rectangle(space, (0, 0), (390, 277))
    rectangle(space, (-20, -10), (400, 287))
    space.add_line((0, 30), (390, 30))
    for x in (10, 200):
        space.add_text("M 1:1", height=5).set_placement((x, 10))
    work = part(space)
    assert followed(save(drawing)) == work


def asked(path: Path) -> bool:
    """True if the drawing is refused, and its cures are to follow all or to leave it out."""
    with pytest.raises(Refused) as refused:
        read(path, NO_PROCESS)
    assert {one.code for one in refused.value.findings if one.severity == "error"} == {"DX214"}
    follow, leave = (process(f'{key} = ["border"]') for key in ("follow", "leave_out"))
    assert followed(path, leave) < followed(path, follow)
    return not {"DX214"} & {*codes(path, follow), *codes(path, leave)}


def of_no_paper(space: Space) -> None:
    rectangle(space, (0, 0), (380, 260))
    small_block(space, (380, 0), (-1, 1))
    part(space)


def pieces(space: Space) -> None:
    """Parts with common cuts in the corner of their plate, a label and a hole in each."""
    rectangle(space, (0, 0), (1000, 700))
    for x in (0, 100, 200):
        for y in (0, 80, 160):
            rectangle(space, (x, y), (x + 100, y + 80))
            space.add_text("P", height=5).set_placement((x + 20, y + 20))
            space.add_circle((x + 50, y + 40), 5)


def beside_the_border(space: Space) -> None:
    sheet(space)
    small_block(space, (405, 280), (-1, -1), closed=True)
    part(space)


def alone(space: Space) -> None:
    small_block(space, (400, 20), (-1, 1), closed=True)
    part(space)


def without_title_block(space: Space) -> None:
    rectangle(space, (0, 0), (390, 277))
    space.add_circle((100, 100), 40)
    space.add_text("M 1:1", height=5).set_placement((300, 10))


def in_the_edge_alone(space: Space) -> None:
    rectangle(space, (0, 0), (420, 297))
    small_block(space, (420, 0), (-1, 1))
    part(space)


@pytest.mark.parametrize(
    "draw",
    (
        of_no_paper,
        pieces,
        beside_the_border,
        alone,
        crossed,
        without_title_block,
        in_the_edge_alone,
    ),
)
def test_what_may_be_a_title_block_is_the_users_choice(
    save: Save, drawing: Drawing, draw: Callable[[Space], None]
) -> None:
    draw(drawing.modelspace())
    assert asked(save(drawing))


def test_lines_that_end_on_a_border_are_told(save: Save, drawing: Drawing) -> None:
    space = drawing.modelspace()
    sheet(space)
    across = space.add_line((20, 140), (410, 140)).dxf.handle
    work = part(space)
    path = save(drawing)
    assert followed(path) == work | {across}
    (finding,) = [one for one in read_contents(path, NO_PROCESS).findings if one.code == "DX215"]
    assert "leave_out = [" in (finding.cure or "")
    assert "at = [215, 140]" in (finding.cure or "")


def labelled(space: Space) -> None:
    """A plate with texts in it, a hole with a number, and a label in a frame."""
    rectangle(space, (0, 0), (400, 250))
    for k in range(4):
        space.add_circle((50 + 60 * k, 50), 20)
        space.add_text(str(k), height=5).set_placement((48 + 60 * k, 48))
    rectangle(space, (280, 10), (380, 40))
    space.add_text("4711", height=10).set_placement((290, 15))


def parts_in_a_plate(space: Space) -> None:
    rectangle(space, (0, 0), (600, 400))
    for x in (5, 205):
        for y in (5, 205):
            rectangle(space, (x, y), (x + 190, y + 190))
            space.add_text("P1", height=5).set_placement((x + 10, y + 10))


def barred(space: Space) -> None:
    """A frame with openings between bars, and lines to engrave from side to side."""
    rectangle(space, (0, 0), (400, 280))
    for x in (10, 140, 270):
        rectangle(space, (x, 10), (x + 120, 270))
        space.add_text("opening", height=5).set_placement((x + 10, 100))
    space.add_line((0, 5), (400, 5))


def in_common_cuts(space: Space) -> None:
    """A plate cut into pieces along lines, with a label in each."""
    rectangle(space, (0, 0), (400, 250))
    for x in (100, 200, 300):
        space.add_line((x, 0), (x, 250))
        space.add_text("P", height=5).set_placement((x - 50, 100))
    space.add_text("P", height=5).set_placement((350, 100))


def as_large_as_paper(space: Space) -> None:
    rectangle(space, (0, 0), (297, 210))
    for x in (20, 277):
        space.add_circle((x, 100), 5)


@pytest.mark.parametrize(
    "draw", (labelled, parts_in_a_plate, barred, in_common_cuts, as_large_as_paper)
)
@pytest.mark.parametrize("in_sheet", (False, True))
def test_plates_with_texts_and_lines_stay(
    save: Save, drawing: Drawing, draw: Callable[[Space], None], in_sheet: bool
) -> None:
    space = drawing.modelspace()
    draw(space)
    work = {one.dxf.handle for one in space.query("LINE LWPOLYLINE CIRCLE")}
    if in_sheet:
        rectangle(space, (-120, -70), (721, 524))
        rectangle(space, (-100, -60), (711, 514))
        small_block(space, (711, -60), (-1, 1))
    path = save(drawing)
    assert followed(path) == work
    assert not {"DX214", "DX215"} & set(codes(path))

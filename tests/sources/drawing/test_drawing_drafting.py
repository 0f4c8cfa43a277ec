"""What is drawn for people only is not followed, and one note says so."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from ezdxf.document import Drawing

from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText
from assistant.sources.drawing import read, read_contents
from assistant.sources.drawing.drafting import block_kind, layer_kind, line_type_kind
from assistant.sources.drawing.survey import survey
from assistant.sources.process import NO_PROCESS, Process
from assistant.sources.process.file import parse_process
from tests.sources.drawing.conftest import Save

WORDS = {
    "border": "BORDER Border_(ISO) RAHMEN Zeichnungsrahmen Cadre recuadro SQUADRATURA 図枠 frame"
    " Рамка 图框",
    "thin line": "细实线 细实线层",
    "symbol": "ROU1 ROU2 Rauheit 表面粗糙度",
    "title block": "TITLE Title(ISO) TitleBlock TITLE-BLOCK A-ANNO-TTLB Schriftfeld 表題欄"
    " Cartouche",
    "centre line": "CENTER Centerline_(ISO) CENTRE-LINES Center_Mark_(ISO) Mittellinien MITTE Axes"
    " ejes asse 中心線 centerMarks IV_ARC_CENTERS Осевая 点画线 中心线层",
    "phantom line": "Phantom 双点画线",
    "hidden line": "HIDDEN Hidden_Narrow_(ISO) hiddenLines verdeckt CACHÉ caches ocultas nascoste"
    " 隠れ線",
    "dimension": "DIM DIMS Dimension(ISO) A-ANNO-DIMS BEMASSUNG Bemaßung cotation COTES acotación"
    " quote Quotature 寸法 寸法線",
    "construction": "Construction CONSTRUCTION_LINES Hilfslinien Hilfslinie Konstruktionslinien"
    " Sketch_Geometry_(ISO) 補助線",
    "hatch": "HATCH Hatching Schraffur hachures SOMBREADO campitura ハッチング ﾊｯﾁﾝｸﾞ",
    "construction points of dimensions": "Defpoints DEFPOINTS",
}
WORK = (
    *(
        "0",
        "CUT",
        "cutline",
        "outline",
        "OUTLINES",
        "Layer 1",
        "Layer2",
        "visible_iso_24_16",
        "GLUE",
    ),
    *("center bore", "centerpiece", "CENTER_DRILL", "border_cut", "BORDER GLUE", "Klebe_Rahmen"),
    *("machine frame", "seal title", "dim light", "côté gauche", "bordeaux", "seam"),
    *(
        "Visible (ISO)",
        "Außenkontur",
        "外形",
        "外形線",
        "粗实线",
        "轮廓线",
        "切割图框",
        "Контур",
        "Резка рамка",
        "ROUTE",
        "axis 2 rail",
        "IV_OUTER_PROFILE",
        "hatchback",
    ),
)


@pytest.mark.parametrize(("kind", "names"), WORDS.items())
def test_words_of_drafting_in_eight_languages(kind: str, names: str) -> None:
    for name in (*names.split(), *(one.replace("_", " ") for one in names.split())):
        assert layer_kind(name) == kind, name


@pytest.mark.parametrize("name", WORK)
def test_names_that_may_be_work(name: str) -> None:
    assert layer_kind(name) == ""


@pytest.mark.parametrize(
    "name",
    [
        "CENTER",
        "CENTER2",
        "CENTERX2",
        "Center",
        "HIDDEN",
        "HIDDENX2",
        "DASHED",
        "DASHEDX2",
        "DASHED2",
        "PHANTOM",
        "PHANTOMX2",
        "DOT2",
        "ACAD_ISO02W100",
        "ACAD_ISO15W100",
        "SLD-Center",
        "MITTEX2",
        "VERDECKT2",
        "JIS_08_11",
        "AXES2",
        "DASHDOT",
    ],
)
def test_line_types_that_have_gaps(name: str) -> None:
    assert line_type_kind(name)


@pytest.mark.parametrize(
    "name", ("Continuous", "SLD-Solid", "Solid", "ACAD_ISO01W100", "centering")
)
def test_line_types_of_edges(name: str) -> None:
    assert line_type_kind(name) == ""


def test_blocks_without_a_name_are_dimensions_and_hatches() -> None:
    assert (block_kind("*D12"), block_kind("*X3"), block_kind("*U4")) == ("dimension", "hatch", "")


def process(text: str) -> Process:
    return parse_process(SourceText(text, "x.toml"))


def followed(path: Path, given: Process = NO_PROCESS) -> set[str]:
    """Handles of the entities that are followed."""
    return {curve.handle for curve in read_contents(path, given).curves}


def circle(drawing: Drawing, layer: str, line_type: str | None = None, x: float = 0.0) -> str:
    attributes = {"layer": layer} if line_type is None else {"layer": layer, "linetype": line_type}
    return drawing.modelspace().add_circle((x, 0), 5, dxfattribs=attributes).dxf.handle


def test_one_note_lists_what_is_off_and_its_cure_switches_it_on(
    save: Save, drawing: Drawing
) -> None:
    cut, border, centre = (
        *(circle(drawing, "CUT"), circle(drawing, "BORDER", x=20)),
        circle(drawing, "CUT", "CENTER2", 40),
    )
    path = save(drawing)
    reading = read(path, NO_PROCESS)
    (note,) = [one for one in reading.findings if one.code == "DX212"]
    assert note.severity == "info"
    assert "layer `BORDER` (border, 1)" in note.message
    assert "line type `CENTER2` (centre line, 1)" in note.message
    assert 'follow = ["BORDER"]' in (note.cure or "")
    assert followed(path) == {cut}
    assert followed(path, process('follow = ["border"]')) == {cut, border}
    assert followed(path, process('follow = ["BORDER", "CENTER*"]')) == {cut, border, centre}
    assert "DX212" not in {one.code for one in read(path, process('follow = ["*"]')).findings}
    assert "DX212" not in {
        one.code
        for one in read(path, process('leave_out = ["BORDER", {line_type = "CENTER2"}]')).findings
    }


def test_a_layer_with_a_table_is_as_the_file_says(save: Save, drawing: Drawing) -> None:
    drawing.layers.add("BORDER", linetype="CENTER")
    border, centre = circle(drawing, "BORDER"), circle(drawing, "CUT", "HIDDEN", 20)
    path = save(drawing)
    stated = process("[layers.border]\n[layers.CUT]")
    assert followed(path, stated) == {border, centre}
    (note,) = [one for one in read(path, stated).findings if one.code == "DX213"]
    assert "line type `HIDDEN` on layer `CUT`" in note.message  # that of BORDER was named with it
    assert note.cure is not None
    entry = note.cure[note.cure.index("leave_out") :].partition("] at")[0] + "]"
    assert followed(path, process(f"{entry}\n[layers.border]\n[layers.CUT]")) == {border}


def test_line_types_are_those_of_layers_and_inserts(save: Save, drawing: Drawing) -> None:
    drawing.layers.add("AXIAL", linetype="ACAD_ISO04W100")
    block = drawing.blocks.new("HOLE")
    block.add_circle((0, 0), 3, dxfattribs={"linetype": "BYBLOCK"})
    block.add_circle((0, 0), 4)
    space = drawing.modelspace()
    for x, attributes in (
        (10, {"layer": "CUT", "linetype": "HIDDEN"}),
        (20, {"layer": "CUT"}),
        (30, {"layer": "AXIAL"}),
        (40, {"layer": "AXIAL", "linetype": "Continuous"}),
    ):
        space.add_blockref("HOLE", (x, 0), dxfattribs=attributes)
    found = read_contents(save(drawing), NO_PROCESS).curves
    # By block: hidden, continuous, the layer's, continuous. By layer: the layer of the insert.
    assert sorted(round(curve.start[0]) for curve in found) == [14, 23, 24, 43]


def test_a_line_type_whose_pattern_has_gaps_is_not_of_edges(save: Save, drawing: Drawing) -> None:
    drawing.linetypes.add("Osa", [0.5, 0.3, -0.2])
    drawing.linetypes.add("Hrana", [0.0])
    circle(drawing, "0", "Osa")
    edge = circle(drawing, "0", "Hrana", 20)
    assert followed(save(drawing)) == {edge}


def test_a_title_block_is_not_followed_whatever_layer_it_is_on(
    save: Save, drawing: Drawing
) -> None:
    drawing.blocks.new("A3_Schriftfeld").add_line((0, 0), (180, 0))
    drawing.modelspace().add_blockref("A3_Schriftfeld", (0, 0))
    part = circle(drawing, "0")
    path = save(drawing)
    assert followed(path) == {part}
    assert len(followed(path, process('follow = ["A3_schriftfeld"]'))) == 2
    only = 'leave_out = [{layer = "0", block = "A3_SCHRIFTFELD"}]\n[layers.0]'
    assert followed(path, process(only)) == {part}


def test_points_are_switched_off_and_locations_with_attributes_are_not(
    save: Save, drawing: Drawing
) -> None:
    drawing.modelspace().add_point((1, 2), dxfattribs={"layer": "Construction"})
    block = drawing.blocks.new("POSE")
    block.add_attdef("NAME", (0, 0))
    insert = drawing.modelspace().add_blockref("POSE", (5, 0), dxfattribs={"layer": "HIDDEN"})
    insert.add_attrib("NAME", "pick")
    path = save(drawing)
    contents = read_contents(path, NO_PROCESS)
    assert [one.given for one in contents.locations] == ["pick"]
    assert len(read_contents(path, process('follow = ["Construction"]')).locations) == 2


def test_a_drawing_of_nothing_else_is_refused_with_the_cure(save: Save, drawing: Drawing) -> None:
    circle(drawing, "Hidden (ISO)")
    path = save(drawing)
    with pytest.raises(Refused) as refused:
        read(path, NO_PROCESS)
    (finding,) = [one for one in refused.value.findings if one.severity == "error"]
    assert finding.code == "DX011"
    assert 'follow = ["Hidden (ISO)"]' in (finding.cure or "")
    assert read(path, replace(NO_PROCESS, follow=("Hidden (ISO)",))).program.procedures


def test_a_survey_says_what_is_off(save: Save, drawing: Drawing) -> None:
    circle(drawing, "CUT")
    circle(drawing, "CUT", "CENTER", 500)
    circle(drawing, "BORDER", x=900)
    circle(drawing, "Kante 2", "PHANTOM2", 1200)
    found = survey(save(drawing), NO_PROCESS)
    layers = {one.name: one for one in found.layers}
    assert layers["CUT"].closed == 1
    assert [(part.name, part.count) for part in layers["CUT"].parts] == [("CENTER", 1)]
    assert layers["BORDER"].use == "switched off: border"
    assert layers["Kante 2"].drafting == "line type PHANTOM2: phantom line"
    assert found.extents is not None
    assert found.extents.size == pytest.approx((10.0, 10.0, 0.0), abs=0.01)
    assert [one.code for one in found.findings].count("DX212") == 1

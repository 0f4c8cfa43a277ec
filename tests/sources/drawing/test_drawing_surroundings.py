"""What drawings make of the surroundings: ways in from free sides, and a quick order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from ezdxf.document import Drawing

from assistant import sources
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused, info
from assistant.program.geometry import Frame, Pose, Tool
from assistant.program.motion import FINE, Blend
from assistant.program.pseudo import print_program
from assistant.program.statements import Motion
from assistant.sources.drawing import read
from assistant.sources.process import ALONG_TOOL, DEFAULT_SPEED, Defaults, Layer, Process, WayIn

Save = Callable[..., Path]

SAID = info("XX100", "beside {where}", "")
BENCH = Pose((100.0, 0.0, 50.0))
NOZZLE = Pose((0.0, 0.0, 70.0))


class Beside:
    """An arm that is slow along y, and comes from the side of the tool's x axis where y > 0."""

    def __init__(self) -> None:
        self.asked: list[tuple[Pose, Pose, float]] = []

    def places(self, positions: Floats, quaternions: Floats, tool: Pose) -> Floats | None:
        assert tool == NOZZLE
        assert quaternions.shape == (len(positions), 4)
        return np.asarray((positions - BENCH.position) * (0.001, 1.0, 0.001))

    def way_in(self, pose: Pose, tool: Pose, distance: float, place: str) -> WayIn:
        self.asked.append((pose, tool, distance))
        if pose.position[1] > 0.0:
            return WayIn((1.0, 0.0, 0.0), (SAID(where=place),))
        return WayIn(ALONG_TOOL)


def process(around: Beside | None, **said: object) -> Process:
    defaults = replace(Defaults("travel", tool="nozzle", frame="bench"), **said)  # type: ignore[arg-type]
    motion = Motion(DEFAULT_SPEED, FINE, "nozzle", "bench")
    return Process(
        defaults,
        {"nozzle": Tool(NOZZLE)},
        {"bench": Frame(BENCH)},
        layers={"GLUE": Layer("gluing", motion, approach=40.0, retract=40.0)},
        around=around,
    )


def lines(drawing: Drawing, *heights: float) -> None:
    for y in heights:
        drawing.modelspace().add_line((0, y), (50, y), dxfattribs={"layer": "GLUE"})


def points(drawing: Drawing, *places: tuple[float, float]) -> None:
    for x, y in places:
        drawing.modelspace().add_point((x, y, 0), dxfattribs={"layer": "LOOK"})


def printed(path: Path, given: Process) -> tuple[str, list[str]]:
    reading = read(path, given)
    codes = [finding.code for finding in reading.findings]
    return print_program(reading.program).text, codes


def test_contours_are_come_to_from_the_free_side(drawing: Drawing, save: Save) -> None:
    lines(drawing, -30, 30)
    around = Beside()
    program, codes = printed(save(drawing), process(around))
    assert "travel to relative(glue_1_start, 0, 0, -40)" in program
    assert "travel to relative(glue_2_start, 40, 0, 0)" in program
    assert "move linear relative(glue_2_end, 40, 0, 0)" in program
    assert codes.count("XX100") == 2  # its start and its end
    pose, tool, distance = around.asked[0]
    assert pose.position == pytest.approx((100.0, -30.0, 50.0))
    assert (tool, distance) == (NOZZLE, 40.0)


def test_without_surroundings_the_tool_comes_along_its_axis(drawing: Drawing, save: Save) -> None:
    lines(drawing, -30, 30)
    program, codes = printed(save(drawing), process(None))
    assert "travel to relative(glue_2_start, 0, 0, -40)" in program
    assert "XX100" not in codes
    assert "CT206" in codes and "CT209" not in codes  # mm


def test_contours_are_ordered_by_time(drawing: Drawing, save: Save) -> None:
    model = drawing.modelspace()
    for x, y in ((0, 0), (300, 1), (10, 20)):
        model.add_line((x, y), (x + 5, y), dxfattribs={"layer": "GLUE"})
    reading = read(save(drawing), process(Beside()))
    starts = [reading.program.targets[f"glue_{i}_start"].pose.position[1] for i in (1, 2, 3)]
    assert starts == sorted(starts)  # not 0, 20, 1, as it would be by length
    (said,) = (finding for finding in reading.findings if finding.code == "CT209")
    assert "20.00 s" in said.message


def test_locations_are_visited_in_a_quick_order(drawing: Drawing, save: Save) -> None:
    points(drawing, (0, -10), (200, -40), (10, -20), (190, -30))
    around = Beside()
    reading = read(save(drawing), process(around, approach=15.0, retract=15.0))
    program = print_program(reading.program).text
    first = program.index("travel to relative(LOOK_1, 0, 0, -15)")
    order = [program.index(f"move linear LOOK_{i} ") for i in (1, 3, 4, 2)]
    assert order == sorted(order) and first < order[0]
    assert program.count("travel to") == 4
    assert program.count("move linear relative(LOOK_") == 4
    (said,) = (finding for finding in reading.findings if finding.code == "DX322")
    assert "30.00 s" in said.message and "60.00 s" in said.message


@pytest.mark.parametrize(
    "tag, values", [("ORDER", ("1", "2", "3")), ("MOTION", ("travel", "travel", "linear"))]
)
def test_an_order_or_a_motion_that_is_stated_holds(
    drawing: Drawing, save: Save, tag: str, values: tuple[str, ...]
) -> None:
    block = drawing.blocks.new("MARK")
    for row, one in enumerate(("NAME", tag)):
        block.add_attdef(one, (0, row))
    places = (("far", 0, -90), ("near", 0, 0), ("mid", 0, -40))
    for (name, x, y), value in zip(places, values, strict=True):
        insert = drawing.modelspace().add_blockref("MARK", (x, y, 0))
        insert.add_auto_attribs({"NAME": name, tag: value})
    program, codes = printed(save(drawing), process(Beside()))
    order = [program.index(f" {name} speed") for name in ("far", "near", "mid")]
    assert order == sorted(order)
    assert "DX322" not in codes


def test_no_corner_is_cut_where_the_tool_turns_back(drawing: Drawing, save: Save) -> None:
    points(drawing, (0, -10), (0, -40))
    given = process(None, approach=15.0, retract=15.0, blend=Blend(10.0))
    program, _ = printed(save(drawing), given)
    assert "move linear LOOK_1 speed 100 mm/s blend fine" in program
    assert "blend 10 mm" not in program
    given = process(None, blend=Blend(10.0))
    assert "travel to LOOK_1 speed 100 mm/s blend 10 mm" in printed(save(drawing), given)[0]


def test_one_location_may_be_travelled_to(drawing: Drawing, save: Save) -> None:
    block = drawing.blocks.new("MARK")
    for row, tag in enumerate(("NAME", "MOTION")):
        block.add_attdef(tag, (0, row))
    insert = drawing.modelspace().add_blockref("MARK", (0, 0, 0))
    insert.add_auto_attribs({"NAME": "there", "MOTION": "travel"})
    program, _ = printed(save(drawing), process(None, kind="linear"))
    assert "travel to there " in program


def test_tables_have_no_planned_ways(tmp_path: Path) -> None:
    table = tmp_path / "rows.csv"
    table.write_text("x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n400,0,400,0,0,1,0\n")
    said = tmp_path / "rows.process.toml"
    said.write_text('[motion]\nkind = "travel"\n')
    with pytest.raises(Refused) as refused:
        sources.read(table)
    assert [finding.code for finding in refused.value.findings] == ["TB313"]


def test_what_is_left_out_is_not_counted(drawing: Drawing, save: Save) -> None:
    lines(drawing, 0)
    outline = drawing.modelspace().add_lwpolyline(
        [(0, 0), (9, 0), (9, 9)], close=True, dxfattribs={"layer": "WALL"}
    )
    outline.dxf.thickness = 5
    drawing.modelspace().add_3dface([(0, 0), (1, 0), (1, 1), (0, 1)], dxfattribs={"layer": "BODY"})
    path = save(drawing)
    said = process(None)
    _, counted = printed(path, said)
    assert {"DX201", "DX204", "CT201"} <= set(counted)
    _, quiet = printed(path, replace(said, leave_out=("Wall", "BODY")))
    assert not {"DX201", "DX204", "CT201"} & set(quiet)

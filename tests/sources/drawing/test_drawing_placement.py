"""A drawing that is placed: contours and locations go where position, rotation or marks say."""

import inspect
import itertools
import math
from dataclasses import replace
from pathlib import Path

import ezdxf
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from assistant import sources
from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText
from assistant.program.geometry import Frame, Pose
from assistant.program.statements import Follow
from assistant.sources.drawing import read
from assistant.sources.process import NO_PROCESS, Defaults
from assistant.sources.process.file import parse_process
from assistant.sources.process.placement import placement_by_marks, placement_of_options
from tests.examples import drawn
from tests.tables import every_row

MARKS = [[0.0, 0.0, 0.0], [200.0, 0.0, 0.0], [40.0, 100.0, 0.0]]


def process(text):
    return parse_process(SourceText(inspect.cleandoc(text) + "\n", "x.toml"))


def refused(text):
    with pytest.raises(Refused) as caught:
        process(text)
    return [finding.code for finding in caught.value.findings]


def rows(reading):
    """Positions and orientations along the contours, then of the targets, by scipy."""
    paths = [s.path for p in reading.program.procedures for s in p.body if isinstance(s, Follow)]
    poses = [t.pose for t in reading.program.targets.values()]
    positions = [*(p.positions for p in paths), np.array([p.position for p in poses])]
    turns = [*(p.quaternions for p in paths), np.array([p.quaternion for p in poses])]
    turned = Rotation.from_quat(np.vstack(turns), scalar_first=True)
    return np.vstack(positions), turned.as_matrix()


@pytest.fixture
def drawing(save):
    document = ezdxf.new("R2010", units=4)
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (80, 0), (80, 40), (0, 40)], close=True)
    space.add_circle((30, 20), 8)
    space.add_ellipse((120, 30, 5), (20, 5), 0.4)
    space.add_point((10, 70, 3))
    block = document.blocks.new("PICK")
    block.add_line((0, 0), (5, 0))
    insert = space.add_blockref("PICK", (50, 60, 4), dxfattribs={"rotation": 30})
    insert.add_attrib("NAME", "pick_1")
    for tag, value in (("RX", "170"), ("RY", "5"), ("RZ", "20")):
        insert.add_attrib(tag, value)

    return save(document)


POSES = [
    Pose((300.0, -50.0, 20.0)),
    Pose((0.0, 0.0, 0.0), (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))),
    Pose.of(np.array((10.0, 20.0, 30.0)), Rotation.from_euler("ZYX", (40, 25, -20), degrees=True)
            .as_quat(scalar_first=True)),
]  # fmt: skip


@pytest.mark.parametrize("placement", POSES)
@pytest.mark.parametrize("layers", ["", "[layers.0]\ntangential = true\n"])
def test_contours_and_locations_move_alike(drawing, placement, layers):
    usual = process(layers + '[motion]\nframe = "table"\n[frames.table]\nposition = [1, 2, 3]')
    before, turned = rows(read(drawing, usual))
    after, turned_after = rows(read(drawing, replace(usual, placement=placement)))
    turn = Rotation.from_quat(placement.quaternion, scalar_first=True)
    assert len(before) > 20
    assert np.abs(turn.apply(before) + placement.position - after).max() < 1e-6
    # Where the tool does not follow the contour its x axis is the frame's, wherever that is drawn.
    axes = slice(0, 3) if layers else slice(2, 3)
    assert np.abs((turn.as_matrix() @ turned - turned_after)[:, :, axes]).max() < 1e-7


def test_a_location_in_another_frame_moves_as_well(drawing):
    frames = {"table": Frame(Pose((500.0, 0.0, 0.0))), "other": Frame(Pose((0.0, 100.0, 0.0)))}
    usual = replace(NO_PROCESS, frames=frames, defaults=Defaults(frame="table"))
    moved = replace(usual, placement=Pose((0.0, 300.0, 0.0)))
    (one, other) = (read(drawing, p).program.targets["pick_1"].pose for p in (usual, moved))
    assert np.subtract(other.position, one.position) == pytest.approx((0, 300, 0))


coordinates = st.floats(-500, 500).map(lambda x: round(x, 3))
points = st.tuples(coordinates, coordinates, coordinates)


@settings(max_examples=drawn(60), deadline=None)
@given(st.tuples(points, points, points), points, st.floats(-180, 180), st.floats(-80, 80))
def test_marks_that_were_moved_tell_the_move(marks, position, about_z, about_y):
    drawn = np.array(marks)
    normal = np.cross(drawn[1] - drawn[0], drawn[2] - drawn[0])
    longest = max(np.linalg.norm(a - b) for a, b in itertools.combinations(drawn, 2))
    if np.linalg.norm(normal) < 0.2 * longest**2 or longest < 20:
        return
    turn = Rotation.from_euler("ZY", (about_z, about_y), degrees=True)
    placed = placement_by_marks(drawn, turn.apply(drawn) + position)
    assert placed.pose is not None
    found = Rotation.from_quat(placed.pose.quaternion, scalar_first=True)
    assert (found * turn.inv()).magnitude() < 1e-7
    assert placed.pose.position == pytest.approx(position, abs=1e-6)
    assert placed.fields["misfit"] < 1e-6


def test_the_first_mark_the_line_to_the_second_and_the_side_of_the_third_count():
    """A third mark that is 0.3 mm further out, as a hand teaches it, changes nothing else."""
    cell = [[10.0, 20.0, 0.0], [10.0, 220.4, 0.0], [-90.3, 60.0, 0.0]]
    placed = placement_by_marks(MARKS, cell)
    assert placed.pose is not None
    assert placed.pose.position == (10.0, 20.0, 0.0)
    assert placed.pose.quaternion == pytest.approx((math.sqrt(0.5), 0, 0, math.sqrt(0.5)))
    assert placed.rule.code == "CT364"
    assert placed.fields["misfit"] == pytest.approx(0.4)


def test_marks_of_another_unit_do_not_fit():
    inches = [[x / 25.4 for x in mark] for mark in MARKS]
    placed = placement_by_marks(inches, MARKS)
    assert (placed.pose, placed.rule.code) == (None, "CT360")
    assert placed.fields["misfit"] == pytest.approx(200 - 200 / 25.4)
    assert "1 to 2 is 7.87 mm drawn, 200.00 mm taught" in placed.fields["lengths"]


def test_the_misfit_that_is_allowed_is_a_key():
    text = """
        [placement]
        drawing = [[0, 0], [200, 0], [0, 100]]
        cell = [[0, 0, 0], [201.5, 0, 0], [0, 100, 0]]
        """
    assert refused(text) == ["CT360"]
    assert process(text + "misfit = 1.6").placement == Pose()


@every_row(
    ("text", "code"),
    [
        ("drawing = [[0, 0], [100, 0], [200, 0]]\ncell = [[0,0,0], [100,0,0], [200,0,0]]", "CT361"),
        ("drawing = [[0, 0], [100, 0], [200, 3]]\ncell = [[0,0,0], [100,0,0], [200,3,0]]", "CT361"),
        ("drawing = [[0, 0], [0, 0], [0, 10]]\ncell = [[0,0,0], [0,0,0], [0,10,0]]", "CT361"),
        ("drawing = [[0, 0], [90, 0], [0, 50]]\ncell = [[0,0,0], [90,0,0], [0,-50,0]]", "CT362"),
        ("drawing = [[0, 0], [90, 0], [0, 50]]", "CT363"),
        ("misfit = 2", "CT363"),
        ("position = [0, 0, 0]\ndrawing = [[0, 0], [90, 0], [0, 50]]\n"
         "cell = [[0,0,0], [90,0,0], [0,50,0]]", "CT363"),
        ("drawing = [[0, 0], [90, 0]]\ncell = [[0,0,0], [90,0,0], [0,-50,0]]", "CT303"),
        ("drawing = 3\ncell = [[0,0,0], [90,0,0], [0,-50,0]]", "CT303"),
        ("drawing = [[0, 0], [90, true], [0, 50]]\ncell = [[0,0,0], [9,0,0], [0,5,0]]", "CT303"),
        ("postion = [0, 0, 0]", "CT302"),
        ("euler_zyx = [0, 0, 0]\nquaternion = [1, 0, 0, 0]", "CT306"),
    ],
)  # fmt: skip
def test_placements_that_say_nothing_sure(text, code):
    assert refused("[placement]\n" + text) == [code]


def test_a_table_of_waypoints_is_not_placed(tmp_path):
    table = tmp_path / "a.csv"
    table.write_text("x,y,z\n1,2,3\n4,5,6\n")
    (tmp_path / "a.process.toml").write_text("[placement]\nposition = [0, 300, 0]\n")
    with pytest.raises(Refused) as caught:
        sources.read(table)
    assert [f.code for f in caught.value.findings] == ["CT368"]


def test_options_place_instead_of_the_file(drawing: Path):
    drawing.with_suffix(".process.toml").write_text("[placement]\nposition = [0, 300, 0]\n")
    by_file = sources.read(drawing)
    options = placement_of_options("10,20,30,90,0,0", ())
    marks = placement_of_options(None, ["0,0=10,20,30", "100,0=10,120,30", "0,50,0=-40,20,30"])
    for one in (options, marks):
        reading = sources.read(drawing, placement=one)
        assert "CT365" in [f.code for f in reading.findings]
        at = reading.program.targets["pick_1"].pose.position
        assert at == pytest.approx((10 - 60, 20 + 50, 34))
    assert by_file.program.targets["pick_1"].pose.position == pytest.approx((50, 360, 4))
    assert placement_of_options(None, ()) is None


@every_row(
    ("place", "marks", "code"),
    [
        ("1,2", [], "CT366"),
        ("1,2,x", [], "CT366"),
        ("1,2,nan", [], "CT366"),
        ("", [], "CT366"),
        (None, ["0,0=1,2,3"], "CT367"),
        (None, ["0,0"] * 3, "CT366"),
        (None, ["0,0=1,2,3"] * 3, "CT361"),
        ("1,2,3", ["0,0=1,2,3"], "CT363"),
    ],
)
def test_options_that_say_no_place(place, marks, code):
    with pytest.raises(Refused) as caught:
        placement_of_options(place, marks)
    assert ([f.code for f in caught.value.findings], caught.value.exit_status) == ([code], 2)


def test_only_the_layer_that_is_named_is_wanted(save):
    document = ezdxf.new("R2010", units=4)
    space = document.modelspace()
    space.add_circle((0, 0), 10, dxfattribs={"layer": "SEAL"})
    for number in range(11):
        layer = f"OTHER_{number}"
        space.add_line((0, 0), (50, number), dxfattribs={"layer": layer})
        space.add_point((20, number), dxfattribs={"layer": layer})
        space.add_text("x", dxfattribs={"layer": layer})

    path = save(document)
    reading = read(path, process('leave_out = ["*"]\n[layers.SEAL]\nspeed = 20'))
    assert [p.name for p in reading.program.procedures] == ["main", "SEAL"]
    assert reading.findings == ()
    some = process('leave_out = ["other_*"]\n[layers.seal]\n[layers.OTHER_3]')
    reading = read(path, some)
    assert [p.name for p in reading.program.procedures] == ["main", "locations", "SEAL", "OTHER_3"]

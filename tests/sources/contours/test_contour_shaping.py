"""Sides, starts, leads, overlap and passes of contours, by figures worked out by hand."""

import math

import ezdxf
import numpy as np
import pytest

import assistant
from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText
from assistant.program.expressions import Apply
from assistant.program.motion import Kind
from assistant.program.statements import Move
from assistant.sources.contours.curves import Arc, FreeCurve, Line
from assistant.sources.contours.layer_program import contour_program
from assistant.sources.process.file import parse_process
from tests.sources.contours.whole import whole_paths
from tests.tables import every_row


def box(width, height=None, at=(0.0, 0.0), layer="CUT", z=0.0):
    """Four lines, anticlockwise from the lower left."""
    (x, y), height = at, height or width
    corners = [(x, y, z), (x + width, y, z), (x + width, y + height, z), (x, y + height, z)]
    ends = [*corners[1:], corners[0]]
    return [Line(a, b, layer, f"{i:X}") for i, (a, b) in enumerate(zip(corners, ends, strict=True))]


def ring(radius, at=(0.0, 0.0), layer="CUT"):
    x, y = at
    return Arc.about((x, y, 0), (0, 0, 1), (x + radius, y, 0), 360.0, layer, "C")


def program(curves, keys, marks=(), more=""):
    process = parse_process(SourceText(f"{more}\n[layers.CUT]\n{keys}", "part.process.toml"))
    made = contour_program(curves, process, taken=set(), marks=marks)
    return made.procedures, made.targets, made.findings


def ways(curves, keys, marks=(), more=""):
    """The points (n, 3) of each way, its start among them, and the codes of what was found."""
    procedures, targets, findings = program(curves, keys, marks, more)
    found = [path for p in procedures for path in whole_paths(p, targets)]
    starts = [start(targets, f"{path.name}_start") for path in found]
    joined = [np.vstack([[s], path.positions]) for s, path in zip(starts, found, strict=True)]
    return joined, {f.code for f in findings}


def start(targets, name):
    return targets[name].pose.position


def area(points):
    x, y = points.T[:2]
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def codes(curves, keys, **more):
    return {f.code for f in program(curves, keys, **more)[2]}


def test_an_outline_is_followed_outside_and_a_hole_inside():
    (hole, outline), found = ways([*box(40.0), ring(8.0, (20.0, 20.0))], "offset = 3")
    centre = np.array([20.0, 20.0])
    assert np.linalg.norm(hole[:, :2] - centre, axis=1) == pytest.approx(5.0)
    assert outline[:, :2].min(axis=0) == pytest.approx([-3.0, -3.0])
    assert outline[:, :2].max(axis=0) == pytest.approx([43.0, 43.0])
    assert found == {"CT206", "CT218"}


def test_corners_outside_become_arcs_about_them():
    procedures, targets, _ = program(box(40.0), "offset = 3")
    (path,) = whole_paths(procedures[0], targets)
    assert np.count_nonzero(path.kinds == Kind.VIA) == 4
    assert np.count_nonzero(path.kinds == Kind.LINEAR) == 4
    via = path.positions[path.kinds == Kind.VIA]
    near = np.where(via[:, :2] > 20.0, 40.0, 0.0)
    assert np.linalg.norm(via[:, :2] - near, axis=1) == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("side", "low", "high"),
    [("inside", 3.0, 37.0), ("outside", -3.0, 43.0), ("left", 3.0, 37.0), ("right", -3.0, 43.0)],
)
def test_the_side_can_be_stated(side, low, high):
    (way,), _ = ways(box(40.0), f'offset = 3\nside = "{side}"')
    assert (way[:, :2].min(), way[:, :2].max()) == pytest.approx((low, high))


@every_row(
    ("way_round", "outline", "hole"),
    [
        ("climb", -1, 1),
        ("conventional", 1, -1),
        ("clockwise", -1, -1),
        ("anticlockwise", 1, 1),
        ("drawn", 1, 1),
    ],
)
@every_row("offset", [0, 3])
def test_ways_round(way_round, outline, hole, offset):
    keys = f'way_round = "{way_round}"' + (f"\noffset = {offset}" if offset else "")
    (inner, outer), _ = ways([*box(40.0), ring(8.0, (20.0, 20.0))], keys)
    assert (np.sign(area(outer)), np.sign(area(inner))) == (outline, hole)


@pytest.mark.parametrize(("side", "y"), [("left", 3.0), ("right", -3.0)])
def test_open_contours_keep_their_side_and_way(side, y):
    line = Line((0, 0, 0), (50, 0, 0), "CUT", "A")
    (way,), _ = ways([line], f'offset = 3\nside = "{side}"\nway_round = "drawn"')
    assert way.tolist() == [[0, y, 0], [50, y, 0]]
    climbing = [0, 50] if side == "left" else [50, 0]
    (way,), _ = ways([line], f'offset = 3\nside = "{side}"\nway_round = "climb"')
    assert way[:, 0].tolist() == climbing


def test_an_open_corner_is_cut_short_inside_and_rounded_outside():
    lines = [Line((0, 0, 0), (50, 0, 0), "CUT"), Line((50, 0, 0), (50, 50, 0), "CUT")]
    (inner,), _ = ways(lines, 'offset = 3\nside = "left"')
    assert inner.tolist() == [[0, 3, 0], [47, 3, 0], [47, 50, 0]]
    (outer,), _ = ways(lines, 'offset = 3\nside = "right"')
    half = 3.0 / math.sqrt(2.0)
    assert outer[2] == pytest.approx([50 + half, -half, 0])  # the via of the arc


def test_many_open_contours_with_a_side_are_not_run_backwards():
    lines = [Line((0, 20.0 * i, 0), (50, 20.0 * i, 0), "CUT", f"{i}") for i in range(6)]
    found, _ = ways(lines, 'offset = 3\nside = "left"')
    assert len(found) == 6
    assert all(way[0, 0] == 0.0 and way[-1, 0] == 50.0 for way in found)
    free, _ = ways(lines, "overlap = 1")
    assert any(way[0, 0] == 50.0 for way in free)


def test_contours_start_in_the_middle_of_the_longest_side():
    (way,), _ = ways(box(80.0, 30.0), 'start = "longest"')
    assert way[0].tolist() == [40, 0, 0]
    (way,), _ = ways(box(80.0, 30.0), 'start = "longest"\noffset = 3')
    assert way[0].tolist() == [40, -3, 0]


def test_contours_start_at_a_corner():
    # The arc's start is no corner; only (0, 0) and (40, 0) are.
    arc = Arc.about((20, 20, 0), (0, 0, 1), (40, 20, 0), 180.0, "CUT")
    around = [
        Line((40, 0, 0), (40, 20, 0), "CUT"),
        arc,
        Line((0, 20, 0), (0, 0, 0), "CUT"),
        Line((0, 0, 0), (40, 0, 0), "CUT"),
    ]
    other = ring(3.0, (-5.0, 100.0))
    (far, way), _ = ways([other, *around], 'start = "corner"')
    assert way[0].tolist() in ([0, 0, 0], [40, 0, 0])
    assert len(far)


def test_contours_start_where_a_point_marks_them():
    marks = [("cut", (33.0, -4.0, 0.0)), ("OTHER", (0.0, 0.0, 0.0))]
    (way,), found = ways(box(80.0, 30.0), 'start = "point"', marks)
    assert way[0].tolist() == [33, 0, 0]
    assert not found
    (way,), found = ways(box(80.0, 30.0), 'start = "point"\noffset = 3', marks)
    assert way[0].tolist() == [33, -3, 0]
    (disc,), _ = ways([ring(10.0)], 'start = "point"', [("CUT", (0.0, 12.0, 0.0))])
    assert disc[0] == pytest.approx([0, 10, 0])


def test_contours_without_a_mark_and_marks_without_a_contour_are_told():
    two = [*box(20.0), *box(20.0, at=(50.0, 0.0))]
    near = [("CUT", (1.0, -1.0, 0.0)), ("CUT", (9.0, -3.0, 0.0))]
    assert "CT219" in codes(two, 'start = "point"', marks=near)
    assert "CT219" in codes(two, 'start = "point"')


def test_a_bead_overlaps_its_own_start():
    (way,), _ = ways(box(80.0, 30.0), 'start = "longest"\noverlap = 8')
    assert way[0].tolist() == [40, 0, 0]
    assert way[-2].tolist() == [40, 0, 0]
    assert way[-1].tolist() == [48, 0, 0]
    (way,), _ = ways([ring(10.0)], "overlap = 5")
    angle = 5.0 / 10.0
    assert way[-1] == pytest.approx([10 * math.cos(angle), 10 * math.sin(angle), 0])
    assert codes(box(10.0), "overlap = 41") == {"CT333"}


def test_leads_in_a_line_and_along_the_tangent():
    keys = 'side = "outside"\nstart = "longest"\nlead_in = {line = 5, angle = 60}\n'
    (way,), _ = ways(box(80.0, 30.0), keys + "lead_out = {tangent = 4}")
    half = math.radians(60.0)
    assert way[0] == pytest.approx([40 - 5 * math.cos(half), -5 * math.sin(half), 0])
    assert way[1].tolist() == [40, 0, 0]
    assert way[-1].tolist() == [44, 0, 0]


def test_a_lead_in_an_arc_touches_the_contour_on_the_scrap_side():
    keys = 'offset = 2\nway_round = "anticlockwise"\nstart = "longest"\n'
    (way,), _ = ways(
        box(80.0, 30.0), keys + "lead_in = {arc = 5}\nlead_out = {arc = 4, angle = 45}"
    )
    assert way[0] == pytest.approx([35, -7, 0])
    slant = 5.0 / math.sqrt(2.0)
    assert way[1] == pytest.approx([40 - slant, -7 + slant, 0])
    assert way[2] == pytest.approx([40, -2, 0])
    turned = 4.0 / math.sqrt(2.0)
    assert way[-1] == pytest.approx([40 + turned, -6 + turned, 0])


def test_leads_of_holes_are_inside():
    (way,), _ = ways([ring(20.0)], 'side = "inside"\nlead_in = {arc = 5}\nlead_out = {line = 3}')
    centres = np.linalg.norm(way[:, :2], axis=1)
    assert centres[0] < 20.0 - 4.0
    assert centres[-1] == pytest.approx(17.0)
    assert centres[2:-1] == pytest.approx(20.0)


def test_leads_start_where_there_is_room():
    # A neighbour 12 mm away leaves no room on the right; the other sides have it.
    two = [*box(40.0), *box(40.0, at=(52.0, 0.0))]
    found, said = ways(two, "offset = 3\nlead_in = {line = 10}")
    assert "CT217" not in said
    for way in found:
        assert not (40.0 < way[0, 0] < 52.0 and 0.0 < way[0, 1] < 40.0)


@pytest.mark.parametrize(
    "keys",
    [
        'offset = 3\nside = "inside"\nlead_in = {line = 60}',
        'side = "inside"\nlead_in = {line = 60}',
        'side = "inside"\nlead_in = {tangent = 60}\nstart = "longest"',
    ],
)
def test_leads_without_room_are_refused(keys):
    procedures, _, findings = program(box(40.0), keys)
    assert {f.code for f in findings} == {"CT217"}
    assert not procedures


def test_a_pocket_is_milled_in_passes():
    (one, two, three), _ = ways(box(40.0), "offset = 3\ndepth = 12\npasses = 3")
    for way, depth in ((one, 4.0), (two, 8.0), (three, 12.0)):
        assert way[:, 2] == pytest.approx(-depth)
        assert way[:, :2] == pytest.approx(one[:, :2])


def test_passes_come_and_go_above_the_drawing():
    procedures, _, _ = program(box(40.0), "depth = 12\npasses = 3\napproach = 5\nretract = 7")
    away = [
        s.target.arguments[3].value
        for s in procedures[0].body
        if isinstance(s, Move) and isinstance(s.target, Apply)
    ]
    assert away == [-9, -11, -13, -15, -17, -19]


def test_depths_go_along_the_tool():
    wall = [Line((0, a.start[0], a.start[1]), (0, a.end[0], a.end[1]), "CUT") for a in box(40.0)]
    (way,), _ = ways(wall, "direction = [1, 0, 0]\noffset = 3\ndepth = 2")
    assert way[:, 0] == pytest.approx(2.0)
    assert (way[:, 1:].min(), way[:, 1:].max()) == pytest.approx((-3.0, 43.0))


def test_roughing_leaves_what_finishing_takes():
    (rough, finish), _ = ways(box(40.0), "offset = 3\nallowances = [0.5, 0]")
    assert rough[:, :2].min() == pytest.approx(-3.5)
    assert finish[:, :2].min() == pytest.approx(-3.0)


def test_too_narrow_contours_are_left_out_and_told():
    procedures, _, findings = program([*box(40.0), ring(2.5, (20, 20))], "offset = 3")
    assert [f.code for f in findings if f.severity == "warning"] == ["CT213"]
    (outline,), _ = ways([*box(40.0), ring(2.5, (20, 20))], "offset = 3")
    assert outline[:, :2].min() == pytest.approx(-3.0)
    assert len(procedures) == 1


def dumbbell(neck):
    low, high = 15.0 - neck / 2.0, 15.0 + neck / 2.0
    points = [(0, 0), (30, 0), (30, low), (60, low), (60, 0), (90, 0), (90, 30), (60, 30)]
    points += [(60, high), (30, high), (30, 30), (0, 30)]
    ends = [*points[1:], points[0]]
    return [Line((*a, 0.0), (*b, 0.0), "CUT") for a, b in zip(points, ends, strict=True)]


def test_a_neck_splits_a_contour():
    found, said = ways(dumbbell(5.0), 'offset = 3\nside = "inside"')
    assert len(found) == 2
    assert "CT214" in said
    (whole,), said = ways(dumbbell(7.0), 'offset = 3\nside = "inside"')
    assert len(whole) > 12
    assert "CT214" not in said


def test_a_slot_that_the_tool_does_not_reach_is_told():
    points = [(0, 0), (60, 0), (60, 40), (32, 40), (32, 70), (28, 70), (28, 40), (0, 40)]
    ends = [*points[1:], points[0]]
    slot = [Line((*a, 0.0), (*b, 0.0), "CUT") for a, b in zip(points, ends, strict=True)]
    assert "CT215" in codes(slot, 'offset = 3\nside = "inside"')
    assert "CT215" not in codes(box(40.0), 'offset = 3\nside = "inside"')


def test_a_neighbour_is_not_cut_into():
    two = [*box(40.0), *box(40.0, at=(45.0, 0.0))]
    procedures, _, findings = program(two, "offset = 3")
    assert {f.code for f in findings if f.severity == "error"} == {"CT216"}
    assert not procedures
    assert "CT216" not in codes([*box(40.0), *box(40.0, at=(46.1, 0.0))], "offset = 3")


def test_holes_on_a_layer_of_their_own_are_holes():
    more = "[layers.HOLES]\noffset = 3"
    procedures, targets, _ = program(
        [*box(40.0), ring(8.0, (20.0, 20.0), "HOLES")], "offset = 3", more=more
    )
    assert [p.name for p in procedures] == ["HOLES", "CUT"]  # the outline was drawn first
    (hole,) = whole_paths(procedures[0], targets)
    apart = np.linalg.norm(hole.positions[:, :2] - [20.0, 20.0], axis=1)
    assert apart == pytest.approx(5.0)


def test_layers_that_lie_in_each_other_are_told():
    more = "[layers.HOLES]\noffset = 1"
    both = [*box(40.0), ring(8.0, (20, 20), "HOLES"), *box(40.0, at=(100, 0), layer="HOLES")]
    found = codes([*both, ring(8.0, (120, 20))], "offset = 1", more=more)
    assert "CT334" in found
    assert "CT334" not in codes(both, "offset = 1", more=more)


@pytest.mark.parametrize(
    ("curves", "keys", "code"),
    [
        ([Line((0, 0, 0), (50, 0, 0), "CUT")], "offset = 3", "CT210"),
        ([Line((0, 0, 0), (50, 0, 9), "CUT")], 'offset = 3\nside = "left"', "CT211"),
        (
            [
                Line((0, 0, 0), (40, 40, 0), "CUT"),
                Line((40, 40, 0), (40, 0, 0), "CUT"),
                Line((40, 0, 0), (0, 40, 0), "CUT"),
                Line((0, 40, 0), (0, 0, 0), "CUT"),
            ],
            "offset = 3",
            "CT212",
        ),
    ],
)
def test_what_has_no_side_is_refused(curves, keys, code):
    procedures, _, findings = program(curves, keys)
    assert [f.code for f in findings if f.severity == "error"] == [code]
    assert not procedures


def test_ellipses_are_offset_as_arcs_and_lines():
    def ellipse(t):
        angle = math.tau * np.asarray(t)
        return np.stack([40 * np.cos(angle), 20 * np.sin(angle), 0 * angle], axis=1)

    curve = FreeCurve(ellipse, True, "CUT", "E")
    (way,), found = ways([curve], "offset = 3")
    assert "CT205" in found
    drawn = ellipse(np.linspace(0.0, 1.0, 20000))
    for point in way:
        assert np.linalg.norm(drawn - point, axis=1).min() == pytest.approx(3.0, abs=0.05)
    assert len(way) < 80
    twice = program([curve], "offset = 3\nallowances = [0.5, 0]")[2]
    (fitted,) = (f.message for f in twice if f.code == "CT205")
    assert fitted.startswith("1 ellipses")


@every_row(
    ("keys", "code"),
    [
        ("offset = 0", "CT303"),
        ("lead_in = 5", "CT303"),
        ("lead_in = {}", "CT303"),
        ("lead_in = {arc = 5, line = 5}", "CT303"),
        ("lead_in = {arc = 5, turn = 5}", "CT303"),
        ("lead_in = {arc = -5}", "CT303"),
        ("lead_in = {arc = 5, angle = 200}", "CT303"),
        ("lead_in = {tangent = 5, angle = 20}", "CT303"),
        ('offset = 3\nside = "up"', "CT303"),
        ('way_round = "left"', "CT303"),
        ('start = "middle"', "CT303"),
        ("overlap = -1", "CT303"),
        ("allowances = [0, 0.5]", "CT303"),
        ("allowances = []", "CT303"),
        ("allowances = 1", "CT303"),
        ("passes = 3", "CT330"),
        ("depth = 3\napproach = 0", "CT331"),
        ("depth = 3\nretract = 0", "CT331"),
        ('side = "left"', "CT332"),
    ],
)
def test_values_that_cannot_be(keys, code):
    with pytest.raises(Refused) as refused:
        parse_process(SourceText(f"[layers.CUT]\n{keys}", "part.process.toml"))
    (finding,) = refused.value.findings
    assert finding.code == code
    assert finding.cure


def test_points_that_are_looked_up_grow_with_the_sides_and_not_with_their_length(
    tmp_path, monkeypatch
):
    shapely = pytest.importorskip("shapely")
    looked_up = [0]

    def counting(name):
        plain = getattr(shapely.STRtree, name)

        def counted(tree, geometry, *args, **kwargs):
            looked_up[0] += np.size(geometry)
            return plain(tree, geometry, *args, **kwargs)

        monkeypatch.setattr(shapely.STRtree, name, counted)

    counting("query")
    counting("query_nearest")
    sides = 80
    zigzag = [(20.0 * k, 400.0 * (k % 2)) for k in range(sides)]
    corners = [*zigzag, (20.0 * sides, -50.0), (-20.0, -50.0)]
    document = ezdxf.new(units=4)
    document.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": "CUT"})
    drawing = tmp_path / "zigzag.dxf"
    document.saveas(drawing)
    process = 'tolerance = 0.05\n[layers.CUT]\nspeed = 30\noffset = 0.5\nside = "outside"\n'
    drawing.with_suffix(".process.toml").write_text(process)
    made = assistant.compile(drawing, language="rapid")
    assert made.ok, [str(f) for f in made.findings]
    # The sides are 32 m long: points every offset would be 64,000.
    assert looked_up[0] < 100 * sides

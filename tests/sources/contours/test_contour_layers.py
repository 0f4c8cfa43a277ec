"""Layers: one procedure each, which approaches, switches, follows and retracts."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant.base import rotations
from assistant.base.diagnostics import Severity
from assistant.program.expressions import Apply, Name, Number
from assistant.program.geometry import Frame, Pose
from assistant.program.motion import FINE, Blend, Kind, Speed
from assistant.program.program import IDENTIFIER
from assistant.program.statements import (
    Comment,
    Follow,
    Motion,
    Move,
    MoveCircular,
    SetSignal,
    Wait,
)
from assistant.sources.contours.curves import Arc, FreeCurve, Line
from assistant.sources.contours.layer_program import ContourProgram
from assistant.sources.contours.layer_program import contour_program as layer_program
from assistant.sources.contours.path_tolerance import runs_of_kind
from assistant.sources.process import Defaults, Layer, Process, ProgramStyle
from tests.examples import drawn
from tests.sources.contours.whole import pose, whole_paths
from tests.tables import every_row

MOTION = Motion(Speed(50.0), Blend(1.0), "nozzle", "table")
GLUE = Layer("gluing", MOTION, (("glue", 1.0),), (("glue", 0.0),), delay=0.25)
FRAMES = {"table": Frame(Pose((400.0, 0.0, 20.0)))}
DEFAULTS = Defaults(frame="table", tool="nozzle")


def process(**layers):
    return Process(DEFAULTS, frames=FRAMES, layers=layers)


def square(layer="GLUE", size=10.0, at=0.0):
    corners = [(at, 0.0, 0.0), (at + size, 0.0, 0.0), (at + size, size, 0.0), (at, size, 0.0)]
    ends = [*corners[1:], corners[0]]
    return [Line(a, b, layer, f"{i:X}") for i, (a, b) in enumerate(zip(corners, ends, strict=True))]


def circle(layer, at, radius=5.0):
    return Arc.about((at, 0, 0), (0, 0, 1), (at + radius, 0, 0), 360.0, layer, "C")


def codes(findings):
    return [f.code for f in findings]


TARGETS = {}
"""Of the program made last."""


def contour_program(curves, process, **options):
    """One procedure a layer, and what was found."""
    process = replace(process, style=ProgramStyle("layer"))
    made = layer_program(curves, process, **options)
    TARGETS.clear()
    TARGETS.update(made.targets)
    return made.procedures, made.findings


def paths(procedure):
    return whole_paths(procedure, TARGETS)


def test_the_order_of_what_is_done_along_a_contour():
    procedures, findings = contour_program(square(), process(glue=GLUE), taken=set())
    (procedure,) = procedures
    assert findings == ()
    assert procedure.name == "GLUE"
    layer, shape, approach, down, on, wait, follow, end, off, retract = procedure.body
    assert (layer, shape) == (
        Comment("gluing: layer GLUE"),
        Comment("closed contour 10 x 10 at 5, 5"),
    )
    travel = Motion(Speed(200.0), FINE, "nozzle", "table")
    assert isinstance(approach, Move)
    assert (approach.kind, approach.motion) == ("joint", travel)
    back = Apply("relative", (Name("closed_1_start"), Number(0), Number(0), Number(-50)))
    assert approach.target == retract.target == back
    assert pose(approach.target, TARGETS) == Pose((0.0, 0.0, 50.0), (0.0, 1.0, 0.0, 0.0))
    assert (down.kind, down.motion) == ("linear", Motion(Speed(50.0), FINE, "nozzle", "table"))
    assert down.target == end.target == Name("closed_1_start")
    assert pose(down.target, TARGETS) == Pose((0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0))
    assert (end.kind, end.motion) == ("linear", replace(MOTION, blend=FINE))
    assert (on, off) == (SetSignal("glue", Number(1)), SetSignal("glue", Number(0)))
    assert wait == Wait(Number(0.25))
    assert (retract.kind, retract.motion) == ("linear", travel)
    assert len(follow.path) == 3
    (path,) = paths(procedure)
    assert path.name == "closed_1"
    assert path.kinds.tolist() == [Kind.LINEAR] * 4
    assert path.positions.tolist() == [[10, 0, 0], [10, 10, 0], [0, 10, 0], [0, 0, 0]]
    assert [path.blends[i] for i in path.blend] == [Blend(1.0)] * 3 + [FINE]
    assert (path.speeds, path.tools, path.frames) == ((Speed(50.0),), ("nozzle",), ("table",))


def test_later_contours_are_approached_in_a_line():
    curves = [*square(), circle("GLUE", 100.0)]
    (procedure,), _ = contour_program(curves, process(GLUE=GLUE), taken=set())
    approaches = [s.kind for s in procedure.body if isinstance(s, Move)]
    assert approaches == ["joint", *["linear"] * 6]  # a circle ends with an arc
    assert [p.name for p in paths(procedure)] == ["closed_1", "circle_1"]


def test_without_distances_signals_and_delay_there_is_only_the_way():
    plain = Layer("cutting", MOTION, approach=0.0, retract=0.0)
    (procedure,), _ = contour_program(square(), process(GLUE=plain), taken=set())
    assert [type(s) for s in procedure.body] == [Comment, Comment, Move, Follow, Move]
    circles = [circle("GLUE", 0.0)]
    (procedure,), _ = contour_program(circles, process(GLUE=plain), taken=set())
    assert [type(s) for s in procedure.body] == [Comment, Comment, Move, Follow, MoveCircular]


def test_a_slow_travel_is_not_left_on_the_way_down():
    fast = Layer("painting", Motion(Speed(800.0), FINE), travel=Speed(100.0))
    (procedure,), _ = contour_program(square(), Process(layers={"GLUE": fast}), taken=set())
    approach, down, end, retract = (s for s in procedure.body if isinstance(s, Move))
    assert {s.motion.speed for s in (approach, down, retract)} == {Speed(100.0)}
    assert end.motion.speed == Speed(800.0)


def test_without_layers_every_layer_moves_as_the_defaults_say():
    curves = [*square("A"), circle("0", 50.0)]
    procedures, findings = contour_program(curves, Process(DEFAULTS, frames=FRAMES), taken=set())
    assert [p.name for p in procedures] == ["A", "layer_0"]
    assert paths(procedures[0])[0].speeds == (DEFAULTS.speed,)
    assert codes(findings) == ["NM001"]


def test_a_layer_that_is_named_like_a_tool_is_told_why_its_procedure_is_not():
    (procedure,), findings = contour_program(square("laser"), process(laser=GLUE), taken={"laser"})
    assert procedure.name == "laser_contours"
    (finding,) = [one for one in findings if one.code in {"NM001", "NM002"}]
    assert finding.code == "NM002"
    assert "something else has the name `laser`" in finding.message
    assert "another name" in finding.cure


def test_curves_on_other_layers_are_counted():
    curves = [*square(), *square("notes"), circle("NOTES", 5.0)]
    procedures, findings = contour_program(curves, process(GLUE=GLUE), taken=set(), path="a.dxf")
    assert len(procedures) == 1
    (finding,) = findings
    assert (finding.code, finding.severity, finding.path) == ("CT201", Severity.WARNING, "a.dxf")
    assert "4 lines, 1 arc" in finding.message


def test_layers_that_are_to_be_left_out_are_left_out_without_a_word():
    curves = [*square(), *square("notes"), *square("Border")]
    said = replace(process(GLUE=GLUE), leave_out=("NOTES",))
    procedures, findings = contour_program(curves, said, taken=set())
    assert [p.name for p in procedures] == ["GLUE"]
    assert [f.message for f in findings if f.code == "CT201"] == [
        "not used on layer 'Border', which the process file does not have: 4 lines"
    ]
    every = Process(DEFAULTS, frames=FRAMES, leave_out=("notes", "BORDER"))
    procedures, findings = contour_program(curves, every, taken=set())
    assert [p.name for p in procedures] == ["GLUE"]
    assert findings == ()


def test_a_layer_that_was_misspelt_is_pointed_out():
    _, findings = contour_program(square("GLEU"), process(GLUE=GLUE), taken=set())
    assert codes(findings) == ["CT201", "CT202"]
    assert "GLEU" in findings[1].cure


def test_names_avoid_each_other_and_those_that_are_taken():
    layers = dict.fromkeys(("glue", "glue_1", "main", "glue 1"), GLUE)
    curves = [c for i, name in enumerate(layers) for c in square(name, at=100.0 * i)]
    taken = {"main", "glue_7"}
    procedures, _ = contour_program(curves, process(**layers), taken=taken)
    names = [p.name for p in procedures]
    rows = [f"{p.name}_{i}" for q in procedures for p in paths(q) for i in range(1, 5)]
    everything = [
        "main",
        "glue_7",
        *TARGETS,
        *names,
        *(p.name for q in procedures for p in paths(q)),
        *rows,
    ]
    assert len({n.lower() for n in everything}) == len(everything)
    assert taken >= {*names}


NASTY = [
    'a"b',
    "x\nSTOP;",
    "glue';--",
    "!\r\nENDPROC",
    "Ünicode",
    "  ",
    "9lives",
    "{0}%s",
    "x" * 300,
]


@every_row("layer", NASTY)
def test_layer_names_never_become_code(layer):
    procedures, findings = contour_program(square(layer), process(**{layer: GLUE}), taken=set())
    (procedure,) = procedures
    assert IDENTIFIER.fullmatch(procedure.name)
    assert IDENTIFIER.fullmatch(paths(procedure)[0].name)
    assert len(paths(procedure)[0].name) <= 24
    assert procedure.body[0].text.isprintable()
    assert {"NM001"} <= set(codes(findings))


@every_row("layer", NASTY)
def test_findings_about_layers_are_one_printable_line(layer):
    _, findings = contour_program(
        [*square(layer), *square(layer)], process(GLUE=GLUE, **{layer + "q": GLUE}), taken=set()
    )
    for finding in findings:
        assert finding.message.isprintable()
        assert finding.cure.isprintable()


def test_arcs_stay_circular_moves_and_the_last_row_stops():
    (procedure,), _ = contour_program([circle("GLUE", 0.0)], process(GLUE=GLUE), taken=set())
    (path,) = paths(procedure)
    assert path.kinds.tolist() == [Kind.VIA, Kind.END] * 2
    assert [path.blends[i].fine for i in path.blend] == [False, False, True, True]


def test_splines_are_fitted_and_how_well_is_said():
    wave = FreeCurve(lambda t: np.c_[100 * t, 9 * np.sin(6 * t), 0 * t], False, "GLUE", "5")
    (procedure,), findings = contour_program([wave], process(GLUE=GLUE), taken=set())
    assert codes(findings) == ["CT205"]
    assert len(paths(procedure)[0]) < 40


def test_no_pieces_are_no_runs_of_a_kind():
    assert runs_of_kind([]) == []
    assert runs_of_kind([True, True, False]) == [(0, 2), (2, 3)]


@pytest.mark.slow
def test_a_curve_that_cannot_be_followed_is_an_error():
    noise = FreeCurve(lambda t: np.c_[t * 9, np.sin(1e7 * t), 0 * t], False, "GLUE")
    procedures, findings = contour_program([noise], process(GLUE=GLUE), taken=set())
    assert procedures == ()
    assert codes(findings) == ["CT204"]
    assert findings[0].severity is Severity.ERROR


def test_a_curve_that_is_no_number_somewhere_is_an_error():
    broken = FreeCurve(
        lambda t: np.c_[t, np.where(abs(t - 0.37) < 0.1, np.nan, t), t], layer="GLUE"
    )
    procedures, findings = contour_program([broken], process(GLUE=GLUE), taken=set())
    assert procedures == ()
    assert codes(findings) == ["CT101"]


def test_travel_is_reported():
    curves = [circle("GLUE", at) for at in (0.0, 300.0, 100.0, 200.0)]
    _, findings = contour_program(curves, process(GLUE=GLUE), taken=set())
    assert codes(findings) == ["CT206"]
    assert "was 600 mm" in findings[0].message
    assert "is 290 mm" in findings[0].message


directions = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: math.hypot(*v) > 0.05)


@settings(max_examples=drawn(100), deadline=None)
@given(directions, st.booleans())
def test_the_tool_points_along_the_direction(direction, tangential):
    layer = Layer("x", MOTION, direction=direction, tangential=tangential)
    curves = [*square(), Arc.about((5, 0, 0), (0, 0, -1), (0, 0, 0), 170.0, "GLUE")]
    (procedure,), _ = contour_program(curves, process(GLUE=layer), taken=set())
    unit = np.array(direction) / math.hypot(*direction)
    for path in paths(procedure):
        z = rotations.rotate(path.quaternions, (0.0, 0.0, 1.0))
        assert np.allclose(z, unit, atol=1e-9)
    for move in (s for s in procedure.body if isinstance(s, Move)):
        z = rotations.rotate(pose(move.target, TARGETS).quaternion, (0.0, 0.0, 1.0))
        assert np.allclose(z, unit, atol=1e-9)


@pytest.mark.parametrize(
    ("direction", "x"),
    [
        ((0.0, 0.0, -1.0), (1.0, 0.0, 0.0)),
        ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0)),
        ((1.0, 0.0, -1.0), (math.sqrt(0.5), 0.0, math.sqrt(0.5))),
        ((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    ],
)
def test_x_stays_as_near_to_the_frames_x_as_it_can(direction, x):
    layer = Layer("x", MOTION, direction=direction)
    (procedure,), _ = contour_program(square(), process(GLUE=layer), taken=set())
    axes = rotations.rotate(paths(procedure)[0].quaternions, (1.0, 0.0, 0.0))
    assert np.allclose(axes, x)


def test_a_tangential_tool_stops_and_turns_at_corners():
    layer = Layer("knife", MOTION, tangential=True)
    (procedure,), _ = contour_program(square(), process(GLUE=layer), taken=set())
    (path,) = paths(procedure)
    axes = rotations.rotate(path.quaternions, (1.0, 0.0, 0.0))
    ways = [(1, 0, 0), (0, 1, 0), (0, 1, 0), (-1, 0, 0), (-1, 0, 0), (0, -1, 0), (0, -1, 0)]
    assert np.allclose(axes, ways, atol=1e-12)
    assert all(path.blends[i].fine for i in path.blend)
    assert path.positions[0::2].tolist() == [[10, 0, 0], [10, 10, 0], [0, 10, 0], [0, 0, 0]]
    assert path.positions[1::2].tolist() == [[10, 0, 0], [10, 10, 0], [0, 10, 0]]


@pytest.mark.parametrize(("on", "warned"), [((("beam", 1.0),), True), ((), False)])
def test_turns_on_the_spot_with_outputs_on_are_one_warning(on, warned):
    layer = Layer("laser", MOTION, tangential=True, on=on)
    curves = [*square(), Line((50, 0, 0), (90, 0, 0), "GLUE")]
    _, findings = contour_program(curves, process(GLUE=layer), taken=set())
    told = [one for one in findings if one.code == "CT236"]
    assert len(told) == warned
    if warned:
        assert "3 corners" in told[0].message
        assert "the first is at 10, 10, 0 in `outline_1`" in told[0].message


def test_a_tangential_tool_turns_with_an_arc_the_way_the_arc_goes():
    layer = Layer("knife", MOTION, tangential=True)
    arc = Arc.about((0, 0, 0), (0, 0, 1), (50, 0, 0), 350.0, "GLUE")
    (procedure,), _ = contour_program([arc], process(GLUE=layer), taken=set())
    (path,) = paths(procedure)
    x = rotations.rotate(path.quaternions, (1.0, 0.0, 0.0))
    radius = path.positions / 50.0
    assert np.allclose(x, np.cross((0, 0, 1), radius), atol=1e-9)
    start = rotations.rotate(pose(procedure.body[2].target, TARGETS).quaternion, (1.0, 0.0, 0.0))
    ends = np.vstack([[start], x[path.kinds == Kind.END]])
    steps = np.degrees(np.arccos(np.clip((ends[:-1] * ends[1:]).sum(1), -1, 1)))
    assert np.allclose(steps, 350.0 / len(steps))


def test_smooth_joints_are_passed_without_a_stop():
    layer = Layer("knife", MOTION, tangential=True)
    curves = [
        Line((0, 0, 0), (10, 0, 0), "GLUE"),
        Arc.about((10, 10, 0), (0, 0, 1), (10, 0, 0), 90.0, "GLUE"),
        Line((20, 10, 0), (20, 30, 0), "GLUE"),
    ]
    (procedure,), _ = contour_program(curves, process(GLUE=layer), taken=set())
    (path,) = paths(procedure)
    assert path.kinds.tolist() == [Kind.LINEAR, Kind.VIA, Kind.END, Kind.LINEAR]
    assert [path.blends[i].fine for i in path.blend] == [False, False, False, True]


def test_a_tangential_tool_keeps_its_turn_on_the_way_along_itself():
    layer = Layer("knife", MOTION, tangential=True)
    curves = [
        Line((0, 0, 5), (0, 9, 5), "GLUE"),
        Line((0, 9, 5), (0, 9, 0), "GLUE"),
    ]
    (procedure,), _ = contour_program(curves, process(GLUE=layer), taken=set())
    axes = rotations.rotate(paths(procedure)[0].quaternions, (1.0, 0.0, 0.0))
    assert np.allclose(axes, (0, 1, 0))
    only = [Line((0, 9, 5), (0, 9, 0), "GLUE")]
    (procedure,), _ = contour_program(only, process(GLUE=layer), taken=set())
    axes = rotations.rotate(paths(procedure)[0].quaternions, (1.0, 0.0, 0.0))
    assert np.allclose(axes, (1, 0, 0))


def test_a_layer_in_another_frame_is_followed_at_the_same_place():
    turned = Frame(Pose((400.0, 100.0, 20.0), (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))))
    frames = {**FRAMES, "turned": turned}
    layer = Layer("x", Motion(Speed(9.0), FINE, "nozzle", "turned"), direction=(1.0, 0.0, -1.0))
    there = Process(DEFAULTS, frames=frames, layers={"GLUE": layer})
    same = Layer("x", MOTION, direction=(1.0, 0.0, -1.0))
    (moved,), _ = contour_program(square(), there, taken=set())
    (one,) = paths(moved)
    (usual,), _ = contour_program(square(), process(GLUE=same), taken=set())
    (two,) = paths(usual)
    assert one.frames == ("turned",)

    def in_base(path, pose):
        return (
            rotations.rotate(pose.quaternion, path.positions) + pose.position,
            rotations.rotate(rotations.multiply(pose.quaternion, path.quaternions), (0, 0, 1.0)),
        )

    for a, b in zip(in_base(one, turned.pose), in_base(two, FRAMES["table"].pose), strict=True):
        assert np.allclose(a, b)


def test_a_frame_that_moves_or_is_missing_is_an_error():
    held = Layer("x", Motion(Speed(9.0), FINE, "nozzle", "held"))
    gone = Layer("x", Motion(Speed(9.0), FINE, "nozzle", "gone"))
    frames = {**FRAMES, "held": Frame(held=True)}
    for layer, code in ((held, "CT207"), (gone, "CT208")):
        there = Process(DEFAULTS, frames=frames, layers={"GLUE": layer})
        procedures, findings = contour_program(square(), there, taken=set())
        assert procedures == ()
        assert codes(findings) == [code]
        assert findings[0].severity is Severity.ERROR


def test_a_contour_below_the_tolerance_is_left_out_with_a_warning():
    tiny = FreeCurve(
        lambda t: 0.004 * np.c_[np.cos(6.2831853 * t), np.sin(6.2831853 * t), 0 * t],
        True,
        "GLUE",
        "7",
    )
    procedures, findings = contour_program([tiny], process(GLUE=GLUE), taken=set())
    assert procedures == ()
    assert [(f.code, f.place) for f in findings] == [("CT203", "entity 7")]


def test_the_same_drawing_gives_the_same_program():
    curves = [circle("GLUE", float(at)) for at in (0, 300, 100, 200)] + square(at=500.0)
    runs = [contour_program(curves, process(GLUE=GLUE), taken=set()) for _ in range(2)]
    assert runs[0] == runs[1]


def test_nothing_gives_nothing():
    made = layer_program([], Process(), taken=set())
    assert made == ContourProgram((), (), {}, (), made.choice, ()) and not made.choice.left


def test_the_ends_of_a_contour_have_names_that_all_around_them_use():
    curves = [Line((0, 0, 0), (40, 0, 0), "GLUE"), *square(at=100.0)]
    (procedure,), _ = contour_program(curves, process(GLUE=GLUE), taken={"glue_1_end"})
    assert list(TARGETS) == ["glue_1_start", "glue_1_end_2", "closed_1_start"]
    named = [s.target for s in procedure.body if isinstance(s, Move)]
    first = [t.name if isinstance(t, Name) else t.arguments[0].name for t in named]
    open_, closed = ["glue_1_start"] * 2 + ["glue_1_end_2"] * 2, ["closed_1_start"] * 4
    assert first == [*open_, *closed]


def test_a_tool_that_turned_with_a_circle_does_not_end_at_the_target_it_began_from():
    layer = Layer("knife", MOTION, tangential=True)
    contour_program([circle("GLUE", 0.0)], process(GLUE=layer), taken=set())
    assert list(TARGETS) == ["circle_1_start", "circle_1_end", "circle_1_via"]


def test_corners_without_a_stated_size_are_rounded_within_the_tolerance():
    layer = Layer("x", replace(MOTION, blend=FINE), rounded=True)
    curves = [Line((0, 0, 0), (50, 0, 0), "GLUE"), Line((50, 0, 0), (90, 9, 0), "GLUE"),
              Line((90, 9, 0), (90, 60, 0), "GLUE")]  # fmt: skip
    (procedure,), _ = contour_program(curves, process(GLUE=layer), taken=set())
    (path,) = paths(procedure)
    assert path.positions[:, 0].tolist() == [50, 90, 90]
    sizes = [path.blends[i].radius or 0.0 for i in path.blend]
    assert sizes[-1] == 0.0
    for size, turn in zip(sizes[:2], (12.68, 77.32), strict=True):
        assert 0.0 < size * math.sin(math.radians(turn / 2)) <= Process().tolerance

"""Whole programs of drawings: locations and contours under one roof."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import pytest
from ezdxf.document import Drawing

from assistant import sources
from assistant.base.diagnostics import Refused, Severity
from assistant.program.expressions import Number
from assistant.program.geometry import Frame, Pose, Tool
from assistant.program.motion import FINE, Kind, Path, Speed
from assistant.program.program import Procedure, Program, Signal
from assistant.program.statements import Call, Motion, MoveJoints, SetSignal
from assistant.sources.drawing import read
from assistant.sources.process import NO_PROCESS, Defaults, Layer, Process, ProgramStyle
from tests.sources.contours.whole import whole_paths

Save = Callable[..., FilePath]

SAMPLE = FilePath(__file__).parents[3] / "samples" / "plate.dxf"


def contours(program: Program) -> list[Path]:
    """Each contour after its start, as one path."""
    return [
        w
        for p in program.procedures
        if p.name != "locations"
        for w in whole_paths(p, program.targets)
    ]


def procedure(program: Program, name: str) -> Procedure:
    found = program.procedure(name)
    assert found is not None
    return found


def calls(program: Program) -> list[str]:
    main = procedure(program, "main")
    found = [s.procedure for s in main.body if isinstance(s, Call)]
    assert len(found) == len(main.body)
    return found


def names(program: Program) -> list[str]:
    """Every name that a vendor's language puts into one space, rows of paths included."""
    found = [*program.targets, *program.tools, *program.frames, *program.signals]
    found += [p.name for p in program.procedures]
    for path in contours(program):
        found += [f"{path.name}_{i + 1}" for i in range(len(path))]
    return [n.lower() for n in found]


def test_sample() -> None:
    reading = sources.read(SAMPLE)
    assert {f.severity for f in reading.findings} <= {Severity.INFO}
    program = reading.program
    assert program.name == "plate"
    # The holes lie inside the bead.
    assert calls(program) == ["outputs_off", "locations", "CUT", "GLUE"]
    assert list(program.targets)[:9] == [
        "home", "above_pick", "pick", "leave_pick", "above_place", "place", "leave_place",
        "INSPECT_1", "INSPECT_2",
    ]  # fmt: skip
    assert list(program.targets)[9:] == [
        "cut_hole_1_start", "cut_hole_1_via", "cut_opening_1_start", "cut_opening_1_via",
        "glue_1_start", "glue_1_end", "glue_closed_1_start", "glue_closed_2_start",
    ]  # fmt: skip
    assert program.targets["pick"].pose.position == (235.0, -85.0, 260.0)
    assert program.targets["place"].pose.quaternion == pytest.approx(
        (0.0, np.sqrt(0.5), np.sqrt(0.5), 0.0), abs=1e-12
    )
    assert program.tools["gripper"].tip.position == (0.0, 0.0, 60.0)
    kinds = {int(k) for path in contours(program) for k in np.unique(path.kinds)}
    assert kinds == {Kind.LINEAR, Kind.VIA, Kind.END}
    for path in contours(program):
        low, high = path.positions.min(axis=0), path.positions.max(axis=0)
        assert (low >= (220, -90, 240)).all()
        assert (high <= (320, 90, 340)).all()


def test_contours_follow_the_locations(save: Save, drawing: Drawing) -> None:
    model = drawing.modelspace()
    model.add_line((0, 0), (10, 0), dxfattribs={"layer": "CUT"})
    model.add_line((10, 0), (10, 10), dxfattribs={"layer": "CUT"})
    model.add_point((5, 5, 5), dxfattribs={"layer": "CUT"})
    program = read(save(drawing), NO_PROCESS).program
    assert calls(program) == ["locations", "CUT"]
    (path,) = contours(program)
    assert np.allclose(path.positions, [(10, 0, 0), (10, 10, 0)])


def switching(on: dict[str, float], off: dict[str, float]) -> Layer:
    motion = Motion(Speed(10.0), FINE)
    return Layer("gluing", motion, on=tuple(on.items()), off=tuple(off.items()))


def test_outputs_are_off_before_the_first_motion(save: Save, drawing: Drawing) -> None:
    model = drawing.modelspace()
    for layer in ("GLUE", "CUT"):
        model.add_line((0, 0), (10, 0), dxfattribs={"layer": layer})
    layers = {
        "glue": switching({"glue": 1, "fan": 1, "lamp": 1}, {"glue": 0, "fan": 0, "ready": 1}),
        "cut": switching({"cutter": 1, "fan": 0}, {"cutter": 0, "fan": 1}),
        "spare": switching({"spare": 1}, {"spare": 0}),
    }
    numbers = ("glue", "fan", "lamp", "ready", "cutter", "spare")
    signals = {name: Signal("digital", "output", k + 1) for k, name in enumerate(numbers)}
    home = Process(layers=layers, signals=signals, home=(0.0,) * 6)
    program = read(save(drawing), home).program
    first, *rest = procedure(program, "main").body
    assert first == Call("outputs_off") and any(isinstance(one, MoveJoints) for one in rest)
    # `fan` has no value that is off on both layers, `lamp` stays on, `ready` is a message, and
    # nothing is drawn on the layer of `spare`.
    assert procedure(program, "outputs_off").body == (
        SetSignal("glue", Number(0)),
        SetSignal("cutter", Number(0)),
    )
    within = replace(home, style=ProgramStyle(procedures="none"))
    body = procedure(read(save(drawing), within).program, "main").body
    assert body[:2] == procedure(program, "outputs_off").body


def test_no_name_is_there_twice(save: Save, drawing: Drawing) -> None:
    model = drawing.modelspace()
    for layer in ("glue", "GLUE_1", "main", "locations", "outputs_off", "gripper"):
        model.add_line((0, 0), (10, 0), dxfattribs={"layer": layer})
        model.add_point((5, 5, 5), dxfattribs={"layer": layer})
    process = Process(tools={"gripper": Tool()}, frames={"glue_1_1": Frame()})
    program = read(save(drawing, "glue.dxf"), process).program
    assert len(contours(program)) == 6
    assert len(names(program)) == len(set(names(program)))


def test_contours_and_points_in_a_frame_of_their_own(save: Save, drawing: Drawing) -> None:
    model = drawing.modelspace()
    model.add_line((0, 0), (10, 0), dxfattribs={"layer": "CUT"})
    model.add_point((10, 0), dxfattribs={"layer": "CUT"})
    motion = Motion(Speed(10.0), FINE, "tool0", "table")
    process = Process(
        Defaults(frame="base"),
        frames={"table": Frame(Pose((0.0, 0.0, 100.0)))},
        layers={"cut": Layer("cutting", motion)},
    )
    program = read(save(drawing), process).program
    (path,) = contours(program)
    target, *_ = program.targets.values()
    assert path.frames == ("table",)
    assert path.positions[-1] == pytest.approx((10, 0, -100))
    assert target.pose.position == pytest.approx((10, 0, -100))
    assert target.pose.quaternion == pytest.approx(tuple(path.quaternions[-1]), abs=1e-12)


def test_only_layers_without_process(save: Save, drawing: Drawing) -> None:
    drawing.modelspace().add_line((0, 0), (10, 0), dxfattribs={"layer": "OTHER"})
    process = Process(layers={"cut": Layer("cutting", Motion(Speed(10.0), FINE))})
    with pytest.raises(Refused) as caught:
        read(save(drawing), process)
    assert {"CT201", "DX007"} <= {f.code for f in caught.value.findings}


def test_block_twice_gives_contours_twice(save: Save, drawing: Drawing) -> None:
    drawing.blocks.new("HOLE").add_circle((0, 0), 5)
    for at in ((0, 0), (50, 0)):
        drawing.modelspace().add_blockref("HOLE", at, dxfattribs={"layer": "CUT"})
    program = read(save(drawing), NO_PROCESS).program
    assert [len(path) for path in contours(program)] == [4, 4]

"""Locations: attributes, orientation through inserts, names, order."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest
from ezdxf.document import Drawing
from ezdxf.entities import Insert
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from assistant.base import rotations
from assistant.base.diagnostics import Diagnostic, Refused, Severity
from assistant.program.expressions import Name
from assistant.program.geometry import Frame, Pose, Tool
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.program import Program
from assistant.program.statements import Call, Motion, Move
from assistant.sources.drawing import read, read_contents
from assistant.sources.process import NO_PROCESS, Defaults, Process
from tests.examples import drawn
from tests.tables import every_row

Save = Callable[..., Path]

DOWN = np.diag([1.0, -1.0, -1.0])
"""Half a turn about x."""

ROUNDING = 1e-12


def pose_block(document: Drawing, name: str = "POSE", base: tuple[float, ...] = (0, 0, 0)) -> None:
    block = document.blocks.new(name, base_point=base)
    block.add_circle((0, 0), 5)


def put(
    layout: Any,
    at: tuple[float, ...] = (0, 0, 0),
    values: Mapping[str, object] = {},
    block: str = "POSE",
    **attributes: Any,
) -> Insert:
    """An insert with attributes."""
    insert: Insert = layout.add_blockref(block, at, dxfattribs=attributes)
    for tag, value in values.items():
        insert.add_attrib(tag, str(value), at)
    return insert


def angles(x: float = 0, y: float = 0, z: float = 0) -> dict[str, object]:
    return {"RX": x, "RY": y, "RZ": z}


def matrix(pose: Pose) -> np.ndarray[Any, Any]:
    return np.asarray(rotations.to_matrix(pose.quaternion))


def program(path: Path, process: Process = NO_PROCESS) -> Program:
    return read(path, process).program


def one(path: Path, process: Process = NO_PROCESS) -> Pose:
    (target,) = program(path, process).targets.values()
    return target.pose


def codes(path: Path, process: Process = NO_PROCESS) -> list[str]:
    return [f.code for f in read_contents(path, process).findings]


def errors(path: Path, process: Process = NO_PROCESS) -> list[Diagnostic]:
    with pytest.raises(Refused) as caught:
        read(path, process)
    assert caught.value.exit_status == 1
    return [f for f in caught.value.findings if f.severity is Severity.ERROR]


def moves(program: Program) -> list[Move]:
    procedure = program.procedure("locations")
    assert procedure is not None
    found = [s for s in procedure.body if isinstance(s, Move)]
    assert len(found) == len(procedure.body)
    return found


# Orientation.


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (angles(), [(1, 0, 0), (0, 1, 0), (0, 0, 1)]),
        (angles(180), [(1, 0, 0), (0, -1, 0), (0, 0, -1)]),
        (angles(z=90), [(0, 1, 0), (-1, 0, 0), (0, 0, 1)]),
        # Rz(90)·Ry(90): x → -z, y → -x, z → y.
        (angles(y=90, z=90), [(0, 0, -1), (-1, 0, 0), (0, 1, 0)]),
        # Rx(90)·Ry(90): x → Rx(-z) = y, y → z, z → x.
        (angles(90, 90) | {"EULER": "xyz"}, [(0, 1, 0), (0, 0, 1), (1, 0, 0)]),
        # Ry(90)·Rx(90): x → -z, y → Ry(z) = x, z → -y.
        (angles(90, 90) | {"EULER": "ZYX"}, [(0, 0, -1), (1, 0, 0), (0, -1, 0)]),
        ({"A": "180", "b": " 0 ", "C": "+0.0e0"}, [(1, 0, 0), (0, -1, 0), (0, 0, -1)]),
        ({"Q1": 0, "Q2": 0, "Q3": 1, "Q4": 0}, [(-1, 0, 0), (0, 1, 0), (0, 0, -1)]),
        ({"NAME": "p"}, [(1, 0, 0), (0, -1, 0), (0, 0, -1)]),
        ({"SPEED": "", "RX": " "}, [(1, 0, 0), (0, -1, 0), (0, 0, -1)]),
    ],
)
def test_orientation(
    save: Save, drawing: Drawing, values: dict[str, object], expected: list[tuple[int, ...]]
) -> None:
    pose_block(drawing)
    put(drawing.modelspace(), (1, 2, 3), values)
    pose = one(save(drawing))
    assert pose.position == (1, 2, 3)
    assert np.allclose(matrix(pose).T, expected, atol=ROUNDING)


@pytest.mark.parametrize("rotation", [0, 90])
def test_insert_turns_position_and_orientation(
    save: Save, drawing: Drawing, rotation: float
) -> None:
    pose_block(drawing, base=(7, 8, 9))
    put(
        drawing.modelspace(), (10, 20, 30), angles(180, z=-90),
        rotation=rotation, xscale=5, yscale=5, zscale=2,
    )  # fmt: skip
    pose = one(save(drawing))
    assert pose.position == pytest.approx((10, 20, 30), abs=ROUNDING)
    # Rz(-90)·Rx(180): x → -y, y → -x, z → -z; then turned by the insert.
    x, y = ((0, -1, 0), (-1, 0, 0)) if rotation == 0 else ((1, 0, 0), (0, -1, 0))
    assert np.allclose(matrix(pose).T, [x, y, (0, 0, -1)], atol=ROUNDING)


def test_extruded_location(save: Save, drawing: Drawing) -> None:
    pose_block(drawing)
    put(drawing.modelspace(), (10, 20, 30), angles(180), extrusion=(1, 0, 0), rotation=90)
    pose = one(save(drawing))
    assert pose.position == pytest.approx((30, 10, 20), abs=ROUNDING)
    # Axes of the insert: y, z, x turned by 90: z, -y, x. The tool: x, -y, -z of them.
    assert np.allclose(matrix(pose).T, [(0, 0, 1), (0, 1, 0), (-1, 0, 0)], atol=ROUNDING)


def test_mirrored_location(save: Save, drawing: Drawing) -> None:
    pose_block(drawing)
    # The tool leans: z is (0, sin 30, -cos 30), x stays x.
    put(drawing.modelspace(), (10, 0), angles(210), xscale=-1)
    path = save(drawing)
    pose = one(path)
    c, s = math.cos(math.radians(30)), 0.5
    # Mirrored in x: x turned over, z as it was, y = z × x.
    expected = [(-1, 0, 0), (0, c, s), (0, s, -c)]
    assert np.allclose(matrix(pose).T, expected, atol=ROUNDING)
    assert np.linalg.det(matrix(pose)) == pytest.approx(1.0)
    assert "DX313" in codes(path)


def test_location_mirrored_twice_is_not_mirrored(save: Save, drawing: Drawing) -> None:
    pose_block(drawing)
    put(drawing.blocks.new("OUT"), (10, 5), angles(180), xscale=-1)
    drawing.modelspace().add_blockref("OUT", (0, 0), dxfattribs={"yscale": -1})
    path = save(drawing)
    pose = one(path)
    assert pose.position == (10, -5, 0)
    # As turned by 180: x → -x, y → -y, applied to the tool's x, -y, -z.
    assert np.allclose(matrix(pose).T, [(-1, 0, 0), (0, 1, 0), (0, 0, -1)], atol=ROUNDING)
    assert "DX313" not in codes(path)


def test_location_in_an_unevenly_scaled_block(save: Save, drawing: Drawing) -> None:
    pose_block(drawing)
    put(drawing.blocks.new("OUT"), (10, 5), angles(180), rotation=45)
    drawing.modelspace().add_blockref("OUT", (0, 0), dxfattribs={"xscale": 2})
    path = save(drawing)
    pose = one(path)
    assert pose.position == (20, 5, 0)
    # The x axis (1, 1)/√2 is drawn along (2, 1).
    assert matrix(pose)[:, 0] == pytest.approx(np.array([2, 1, 0]) / math.sqrt(5))
    assert matrix(pose)[:, 2] == pytest.approx((0, 0, -1))
    assert "DX314" in codes(path)


def test_mirrored_block_extruded_downwards_without_orientation(
    save: Save, drawing: Drawing
) -> None:
    pose_block(drawing)
    put(drawing.modelspace(), (10, 0), {"NAME": "p"}, extrusion=(0, 0, -1))
    path = save(drawing)
    assert "DX316" in codes(path)
    assert matrix(one(path))[2, 2] == pytest.approx(1.0)


axis_angle = st.floats(-180, 180).map(lambda v: round(v, 3))


@settings(
    max_examples=drawn(40), deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)  # fmt: skip
@given(
    turns=st.lists(axis_angle, min_size=2, max_size=4),
    sizes=st.lists(st.sampled_from([0.5, 1.0, 2.0]), min_size=4, max_size=4),
    mirrors=st.lists(st.booleans(), min_size=4, max_size=4),
    euler=st.tuples(axis_angle, axis_angle, axis_angle),
)
def test_nested_orientation_against_matrices(
    save: Save,
    turns: list[float],
    sizes: list[float],
    mirrors: list[bool],
    euler: tuple[float, float, float],
) -> None:
    document = ezdxf.new("R2010", units=4)
    pose_block(document)
    expected = np.eye(4)
    inner = None
    for i, (turn, size, mirror) in enumerate(zip(turns, sizes, mirrors, strict=False)):
        outer = document.modelspace() if i == len(turns) - 1 else document.blocks.new(f"B{i}")
        insert = put(
            outer,
            (10.0 * i, 5, 1),
            dict(zip(("RX", "RY", "RZ"), euler, strict=True)) if inner is None else {},
            block=inner or "POSE",
            rotation=turn, xscale=-size if mirror else size, yscale=size, zscale=size,
        )  # fmt: skip
        own = np.array(list(insert.matrix44())).reshape(4, 4).T  # ezdxf's are for row vectors
        expected = own @ expected
        inner = f"B{i}"
    rx, ry, rz = np.radians(euler)
    tool = (
        np.array([[math.cos(rz), -math.sin(rz), 0], [math.sin(rz), math.cos(rz), 0], [0, 0, 1]])
        @ np.array([[math.cos(ry), 0, math.sin(ry)], [0, 1, 0], [-math.sin(ry), 0, math.cos(ry)]])
        @ np.array([[1, 0, 0], [0, math.cos(rx), -math.sin(rx)], [0, math.sin(rx), math.cos(rx)]])
    )
    pose = one(save(document))
    linear = expected[:3, :3] / np.cbrt(abs(np.linalg.det(expected[:3, :3])))
    drawn = linear @ tool
    found = matrix(pose)
    assert np.allclose(pose.position, expected[:3, 3], atol=1e-9)
    assert np.allclose(found[:, [0, 2]], drawn[:, [0, 2]], atol=1e-9)
    assert np.linalg.det(found) == pytest.approx(1.0)
    assert ("DX313" in codes(save(document))) == (np.linalg.det(linear) < 0)


# Quaternions.


@pytest.mark.parametrize(
    ("length", "warned", "refused"),
    [(1.0, False, False), (1 + 5e-7, False, False), (1 + 5e-4, True, False),
     (1 - 9e-4, True, False), (1 + 1.1e-3, False, True), (0.9, False, True), (0.0, False, True)],
)  # fmt: skip
def test_quaternion_off_unit_length(
    save: Save, drawing: Drawing, length: float, warned: bool, refused: bool
) -> None:
    pose_block(drawing)
    parts = np.array([0.5, 0.5, -0.5, 0.5]) * length
    insert = put(
        drawing.modelspace(), (0, 0), {f"Q{i + 1}": f"{v:.9f}" for i, v in enumerate(parts)}
    )
    path = save(drawing)
    if refused:
        (error,) = errors(path)
        assert (error.code, error.place) == ("DX309", f"INSERT #{insert.dxf.handle}")
        return
    assert one(path).quaternion == pytest.approx((0.5, 0.5, -0.5, 0.5), abs=1e-9)
    assert ("DX308" in codes(path)) is warned


# Values.


@every_row(
    ("values", "code", "tag"),
    [
        (angles("12,5"), "DX302", "RX"),
        (angles("1.234,5"), "DX301", "RX"),
        (angles("180%%d"), "DX301", "RX"),
        (angles("1_000"), "DX301", "RX"),
        (angles("\u0661"), "DX301", "RX"),
        (angles("nan"), "DX303", "RX"),
        (angles("-inf"), "DX303", "RX"),
        (angles("1e999"), "DX303", "RX"),
        ({"RX": 180, "RZ": 0}, "DX306", ""),
        ({"RX": 180, "RY": "", "RZ": 0}, "DX306", ""),
        ({"Q1": 1, "Q2": 0}, "DX306", ""),
        (angles() | {"Q1": 1, "Q2": 0, "Q3": 0, "Q4": 0}, "DX307", ""),
        (angles() | {"A": 5}, "DX305", "A"),
        ({"SPEED": 0}, "DX304", "SPEED"),
        ({"SPEED": -5}, "DX304", "SPEED"),
        ({"SPEED": "v100"}, "DX301", "SPEED"),
        ({"SPEED": "100", "BLEND": "-1"}, "DX304", "BLEND"),
        ({"ZONE": "z10"}, "DX301", "ZONE"),
        ({"TOOL": "hammer"}, "DX310", "TOOL"),
        ({"WOBJ": "moon"}, "DX310", "WOBJ"),
        ({"MOTION": "jump"}, "DX311", "MOTION"),
        (angles() | {"EULER": "ZYZ"}, "DX311", "EULER"),
        ({"RX": 1, "RY": 2, "RZ": 3, "ORDER": "first"}, "DX301", "ORDER"),
    ],
)
def test_values_that_are_wrong(save: Save, values: dict[str, object], code: str, tag: str) -> None:
    drawing = ezdxf.new("R2010", units=4)
    pose_block(drawing)
    insert = put(drawing.modelspace(), (0, 0), values)
    (error,) = errors(save(drawing))
    assert (error.code, error.place) == (code, f"INSERT #{insert.dxf.handle} {tag}".strip())
    assert error.path is not None
    assert error.cure


def test_all_values(save: Save, drawing: Drawing) -> None:
    pose_block(drawing)
    values = {
        "NAME": "pick", "SPEED": "150", "BLEND": "2.5", "TOOL": "GRIPPER", "FRAME": "Base",
        "MOVE": "MoveJ",
    }  # fmt: skip
    put(drawing.modelspace(), (0, 0), angles(180) | values)
    put(drawing.modelspace(), (0, 0), {"NAME": "place", "BLEND": "fine", "MOTION": "LIN"})
    put(drawing.modelspace(), (0, 0), {"NAME": "rest", "BLEND": "0"})
    defaults = Defaults("joint", Speed(80.0, 90.0), Blend(5.0), "gripper")
    result = program(save(drawing), Process(defaults, tools={"gripper": Tool()}))
    assert moves(result) == [
        Move("joint", Name("pick"), Motion(Speed(150.0, 90.0), Blend(2.5), "gripper", "base")),
        Move("linear", Name("place"), Motion(Speed(80.0, 90.0), FINE, "gripper", "base")),
        Move("joint", Name("rest"), Motion(Speed(80.0, 90.0), FINE, "gripper", "base")),
    ]
    main = result.procedure("main")
    assert main is not None
    assert main.body == (Call("locations"),)
    assert result.entry == "main"


def test_tags_of_a_process_file(save: Save, drawing: Drawing) -> None:
    pose_block(drawing)
    put(drawing.modelspace(), (0, 0), {"Pose_Name": "p", "NAME": "other", "SPEED": 10})
    put(drawing.modelspace(), (0, 0), {"POSE_NAME": "q"})
    path = save(drawing)
    assert list(program(path, Process(tags={"name": "pose_name"})).targets) == ["p", "q"]
    (error,) = errors(path, Process(tags={"nme": "X"}))
    assert error.code == "DX008"


def test_title_block_is_no_location(save: Save, drawing: Drawing) -> None:
    pose_block(drawing)
    pose_block(drawing, "TITLE")
    put(drawing.modelspace(), (0, 0), {"NAME": "Plate 1", "DATE": "today"}, block="TITLE")
    put(drawing.modelspace(), (0, 0), {"WEIGHT": "5"}, block="TITLE")
    put(drawing.modelspace(), (5, 0), {"NAME": "pick", "COLOUR": "red", "SPEED": 5})
    contents = read_contents(save(drawing), NO_PROCESS)
    assert [location.given for location in contents.locations] == ["pick"]
    told = [f.code for f in contents.findings]
    assert told.count("DX319") == 1
    assert told.count("DX321") == 1
    assert (len(contents.curves), len(contents.aside)) == (0, 2)  # no symbols
    (symbol,) = [f for f in contents.findings if "symbol" in f.message]
    assert symbol.message.startswith("1 CIRCLE")


def test_constant_attributes_of_a_block(save: Save, drawing: Drawing) -> None:
    block = drawing.blocks.new("POSE")
    for tag, text in angles(180).items():
        block.add_attdef(tag, (0, 0), str(text)).is_const = True
    put(drawing.modelspace(), (1, 2), {"NAME": "p"})
    put(drawing.modelspace(), (3, 4))
    contents = read_contents(save(drawing), NO_PROCESS)
    assert [location.given for location in contents.locations] == ["p", ""]
    assert all(np.allclose(matrix(p.pose), DOWN, atol=ROUNDING) for p in contents.locations)


def test_wrapped_inserts_keep_their_attributes(save: Save, drawing: Drawing) -> None:
    block = drawing.blocks.new("POSE")
    for tag in ("NAME", "RX", "RY", "RZ"):
        block.add_attdef(tag, (0, 0))
    values = {"NAME": "pick", "RX": "180", "RY": "0", "RZ": "0"}
    drawing.modelspace().add_auto_blockref("POSE", (40, 50), values)
    result = program(save(drawing))
    assert result.targets["pick"].pose.position == (40, 50, 0)


def test_location_without_its_block(save: Save, drawing: Drawing) -> None:
    put(drawing.modelspace(), (1, 2), angles(180), block="NOWHERE")
    assert one(save(drawing)).position == (1, 2, 0)


def test_grid_of_locations(save: Save, drawing: Drawing) -> None:
    pose_block(drawing)
    put(
        drawing.modelspace(), (10, 0), angles(180) | {"NAME": "slot"},
        column_count=2, row_count=2, column_spacing=30, row_spacing=40, rotation=90, xscale=2,
    )  # fmt: skip
    path = save(drawing)
    targets = program(path).targets
    assert {n: t.pose.position for n, t in targets.items()} == {
        "slot": pytest.approx((10, 0, 0)),
        "slot_2": pytest.approx((10, 30, 0)),
        "slot_3": pytest.approx((-30, 0, 0)),
        "slot_4": pytest.approx((-30, 30, 0)),
    }
    assert [f.code for f in read(path, NO_PROCESS).findings].count("DX312") == 3


def test_location_inside_a_location(save: Save, drawing: Drawing) -> None:
    pose_block(drawing)
    fixture = drawing.blocks.new("FIXTURE")
    fixture.add_line((0, 0), (9, 9))
    put(fixture, (5, 0), angles(180) | {"NAME": "inner"})
    put(drawing.modelspace(), (100, 0), angles(180) | {"NAME": "outer"}, block="FIXTURE")
    contents = read_contents(save(drawing), NO_PROCESS)
    assert [(p.given, p.pose.position[0]) for p in contents.locations] == [
        ("outer", 100.0), ("inner", 105.0),
    ]  # fmt: skip
    assert contents.curves == ()


def test_location_on_a_frozen_layer(save: Save, drawing: Drawing) -> None:
    drawing.layers.add("OFF").off()
    pose_block(drawing)
    put(drawing.modelspace(), (1, 2), angles(180), layer="OFF")
    (error,) = errors(save(drawing))
    assert error.code == "DX007"


# Frames.


def test_location_is_put_into_its_frame(save: Save, drawing: Drawing) -> None:
    pose_block(drawing)
    put(drawing.modelspace(), (10, 20, 5), angles(180) | {"FRAME": "table"})
    turned = Pose((100.0, 0.0, 0.0), (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)))
    process = Process(
        Defaults(frame="fixture"),
        frames={"table": Frame(turned), "fixture": Frame(Pose((0.0, 0.0, 50.0)))},
    )
    path = save(drawing)
    pose = one(path, process)
    # In the base (10, 20, 55); from the table (-90, 20, 55) turned back by 90 degrees.
    assert pose.position == pytest.approx((20, 90, 55), abs=ROUNDING)
    assert np.allclose(matrix(pose).T, [(0, -1, 0), (-1, 0, 0), (0, 0, -1)], atol=ROUNDING)
    assert moves(program(path, process))[0].motion.frame == "table"


def test_frame_that_moves(save: Save, drawing: Drawing) -> None:
    pose_block(drawing)
    put(drawing.modelspace(), (10, 20, 5), angles(180) | {"FRAME": "held"})
    (error,) = errors(save(drawing), Process(frames={"held": Frame(held=True)}))
    assert error.code == "DX320"


@pytest.mark.parametrize("what", ["tool", "frame"])
def test_default_that_is_not_declared(save: Save, drawing: Drawing, what: str) -> None:
    drawing.modelspace().add_point((0, 0))
    (error,) = errors(save(drawing), Process(Defaults(**{what: "nothing"})))
    assert error.code == "DX009"


# Names and order.


def test_names(save: Save, drawing: Drawing) -> None:
    pose_block(drawing)
    model = drawing.modelspace()
    for name in ("pick", "PICK", "5 o'clock; \\P", "gripper", "main", "POSE_1", "", ""):
        put(model, (0, 0), angles(180) | {"NAME": name})
    path = save(drawing, "my part-7.dxf")
    reading = read(path, Process(tools={"gripper": Tool()}))
    assert reading.program.name == "my_part_7"
    assert list(reading.program.targets) == [
        "pick", "PICK_2", "n_5_o_clock_P", "gripper_2", "main_2", "POSE_1", "POSE_2", "POSE_3",
    ]  # fmt: skip
    told = [f.code for f in reading.findings]
    assert told.count("DX312") == 1
    assert (told.count("NM001"), told.count("NM002")) == (2, 2)


def test_order(save: Save, drawing: Drawing) -> None:
    pose_block(drawing)
    model = drawing.modelspace()
    for name, order in {"a": "10", "b": "2", "c": "", "d": "2", "e": "-1.5"}.items():
        put(model, (0, 0), angles(180) | {"NAME": name, "ORDER": order})
    path = save(drawing)
    reading = read(path, NO_PROCESS)
    visited = [m.target for m in moves(reading.program)]
    assert visited == [Name(n) for n in ("e", "b", "d", "a", "c")]
    assert list(reading.program.targets) == ["a", "b", "c", "d", "e"]
    told = [f.code for f in reading.findings]
    assert told.count("DX317") == 1
    assert told.count("DX318") == 1


def test_same_bytes_same_program(save: Save, drawing: Drawing) -> None:
    pose_block(drawing)
    put(drawing.modelspace(), (0, 0), angles(180) | {"NAME": "p"})
    path = save(drawing)
    assert read(path, NO_PROCESS) == read(path, NO_PROCESS)


def test_the_letter_of_a_datum_is_no_angle(save: Save, drawing: Drawing) -> None:
    block = drawing.blocks.new("BASE")
    block.add_attdef("A", (0, 0))
    block.add_circle((0, 0), 4)
    space = drawing.modelspace()
    space.add_blockref("BASE", (5, 0)).add_attrib("A", "B")
    lone = space.add_blockref("BASE", (50, 0))
    for tag, text in (("A", "10"), ("B", "20"), ("C", "30")):
        lone.add_attrib(tag, text)
    contents = read_contents(save(drawing), NO_PROCESS)
    assert [one.pose.position for one in contents.locations] == [(50.0, 0.0, 0.0)]
    assert not [one for one in contents.findings if one.severity == "error"]
    assert "DX319" in {one.code for one in contents.findings}

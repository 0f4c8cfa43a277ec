"""Travel between contours that a tool follows with its x axis: the wrist is not wound up."""

import ezdxf
import numpy as np
import pytest

import assistant
from assistant import sources
from assistant.program.geometry import Pose
from assistant.program.statements import Move
from assistant.sources.contours.chains import Contour
from assistant.sources.contours.contour_statements import PlacedLayer, highest_point
from assistant.sources.contours.curves import Arc, FreeCurve

PROCESS = """
[motion]
frame = "table"
tool = "knife"
[tools.knife]
tip = [0, 0, 150]
[frames.table]
position = [900, 0, 600]
[layers."0"]
tangential = true
"""


def drawn(folder, process=PROCESS, *, closed=True):
    document = ezdxf.new("R2010", units=4)
    model = document.modelspace()
    for x in (0, 80, 160):
        if closed:
            model.add_lwpolyline([(x, 0), (x + 50, 0), (x + 50, 50), (x, 50)], close=True)
        else:
            model.add_lwpolyline([(x, 0), (x + 50, 0), (x + 50, 50)])
    document.saveas(folder / "part.dxf")
    (folder / "part.process.toml").write_text(process)
    return folder / "part.dxf"


def travels(path):
    """The kinds of the moves that lead to each contour."""
    statements = sources.read(path).program.statements()
    return [
        s.kind for s in statements if isinstance(s, Move) and s.motion.speed.tcp == 200
    ]  # approaches and retracts


@pytest.mark.parametrize("robot", ["irb4600-20-2.50", "irb4600-60-2.05"])
@pytest.mark.parametrize("language", ["rapid", "melfa-basic-5"])
def test_many_closed_contours_do_not_wind_the_wrist_up(tmp_path, robot, language):
    compiled = assistant.compile(drawn(tmp_path), language=language, robot=robot)
    assert not [f for f in compiled.findings if f.code in ("RB106", "RB113", "MB202")]
    assert compiled.ok, compiled.findings


def test_the_tool_unwinds_above_the_work(tmp_path):
    approach = ["joint", "linear"]  # the retract after it is a line
    assert travels(drawn(tmp_path)) == approach * 3
    assert travels(drawn(tmp_path, closed=False)) == [*approach, *["linear"] * 4]
    low = PROCESS + "approach = 0\n"
    assert travels(drawn(tmp_path, low)) == [*approach, *["linear"] * 4]  # no room above it
    level = PROCESS.replace("tangential = true", "tangential = false")
    assert travels(drawn(tmp_path, level)) == [*approach, *["linear"] * 4]


TWO_LAYERS = """
[motion]
frame = "table"
[frames.table]
position = [900, 0, 600]
[layers.A]
{keys}
[layers.B]
{keys}
"""


@pytest.mark.parametrize(
    ("keys", "kinds"),
    [
        ('travel_kind = "linear"', ["joint", "linear"]),
        ('travel_kind = "linear"\napproach = 0\nretract = 0', ["joint", "linear"]),
        ("approach = 0\nretract = 0", ["joint", "linear"]),
        ("retract = 0", ["joint", "linear"]),
        ("", ["joint", "joint"]),
    ],
)
def test_linear_travel_holds_from_layer_to_layer(tmp_path, keys, kinds):
    document = ezdxf.new("R2010", units=4)
    for y, layer in enumerate("AB"):
        document.modelspace().add_line((0, 20 * y), (50, 20 * y), dxfattribs={"layer": layer})
    document.saveas(tmp_path / "part.dxf")
    (tmp_path / "part.process.toml").write_text(TWO_LAYERS.format(keys=keys))
    compiled = assistant.compile(
        tmp_path / "part.dxf", language="rapid", robot="irb4600-60-2.05"
    ).files
    (text,) = (raw.decode() for raw in compiled.values())
    first = [part.split("Move")[1][0] for part in text.split("PROC ")[-2:]]
    assert first == [{"joint": "J", "linear": "L"}[kind] for kind in kinds]


WAVE = FreeCurve(
    lambda t: np.stack([100 * t, 0 * t, 7 * np.sin(64 * np.pi * t) ** 2], axis=1), layer="CUT"
)
TILTED = Arc.about((50, 0, 0), (0, 1, 0), (42, 0, 0), 97.0, "CUT")


@pytest.mark.parametrize(
    ("curve", "height", "off"), [(WAVE, 7.0, 2e-3), (TILTED, 8.0, 1e-9)], ids=["wave", "arc"]
)
@pytest.mark.parametrize("turn", [0.0, 40.0])
def test_the_highest_point_of_a_curve_is_between_its_samples(curve, height, off, turn):
    half = np.radians(turn) / 2.0  # about x, the tool with it
    pose = Pose((3.0, -20.0, 11.0), (float(np.cos(half)), float(np.sin(half)), 0.0, 0.0))
    down = (0.0, float(np.sin(2 * half)), -float(np.cos(2 * half)))
    found = highest_point([Contour((curve,), False)], PlacedLayer(pose, down))
    origin = -float(np.dot(pose.position, down))
    assert found == pytest.approx(origin + height, abs=off)
    assert found <= origin + height + 1e-9

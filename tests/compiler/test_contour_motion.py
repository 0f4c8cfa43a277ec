"""What a layer says of speeds, outputs and travel, in programs that a virtual controller runs.

The interpreters and their arm know nothing of drawings: where the tool is when an output changes,
and how fast it is where, is measured on their run and compared with the drawing's own numbers.
"""

from __future__ import annotations

import math
from pathlib import Path

import ezdxf
import numpy as np
import pytest

from assistant import languages, robots
from assistant.base.diagnostics import Refused, Severity
from assistant.compiler import compile
from assistant.robots.timing import Drive
from assistant.virtual.events import Switched
from assistant.virtual.kernel import Kernel
from assistant.virtual.kernel.timed_arm import Timed, track_of
from assistant.virtual.melfa import start_slot
from assistant.virtual.rapid.interpreter import start_task

ARMS = {"rapid": "irb1200-7-0.7", "melfa-basic-5": "rv-4frl"}
HOME = {
    "rapid": (0.0, 0.0, 0.0, 0.0, 30.0, 0.0),
    "melfa-basic-5": (0.0, 0.0, 90.0, 0.0, 90.0, 0.0),
}
ORIGIN = np.array([380.0, -60.0, 300.0])
"""Of the drawing in the base of the robot."""
PROCESS = """
robot = "{robot}"
home = {home}
[motion]
frame = "table"
[frames.table]
position = [380, -60, 300]
[signals.glue]
number = 8
[layers.GLUE]
speed = 50
on = {{glue = 1}}
off = {{glue = 0}}
{keys}
"""


class Ran:
    """A run of a compiled drawing: times (n,), tips (n, 3) in the drawing, speeds (n,)."""

    def __init__(self, folder: Path, language: str, keys: str, draw: object = None) -> None:
        document = ezdxf.new()
        document.units = 4
        (draw or rectangles)(document.modelspace())  # type: ignore[operator]
        document.saveas(folder / "part.dxf")
        text = PROCESS.format(robot=ARMS[language], home=list(HOME[language]), keys=keys)
        (folder / "part.process.toml").write_text(text, encoding="utf-8")
        self.compiled = compile(folder / "part.dxf", language=language, robot=ARMS[language])
        wrong = [f for f in self.compiled.findings if f.severity is Severity.ERROR]
        assert self.compiled.ok, wrong
        self.text = next(iter(self.compiled.files.values())).decode()
        arm = robots.get(ARMS[language])
        drive = Drive(arm.speeds * 1e3, arm.speeds * 1e6, math.inf, 10_000.0)
        motion = Timed(arm, drive, HOME[language])
        kernel = Kernel(motion=motion)
        tree = languages.get(language).parse(self.text)
        if language == "rapid":
            start_task(kernel, (tree,), robot=arm)
        else:
            start_slot(kernel, (tree,), robot=arm)
        run = kernel.run()
        assert run.ended == "end", run.message
        track = track_of(motion, run.log, kernel.now, 0.002)
        self.t, self.speed, self.joints = track.t, track.speed, track.joints
        self.tips = track.position - ORIGIN
        first, *self.switched = [
            (row.time, row.what.value) for row in run.log if isinstance(row.what, Switched)
        ]
        assert first == (0.0, 0.0), "the output is off before the first motion"

    def at(self, time: float) -> np.ndarray:
        return np.array([np.interp(time, self.t, column) for column in self.tips.T])


def rectangles(space: object) -> None:
    """An outline of 120 by 80 mm, and a square of 30 mm in it, 10 mm higher."""
    for x, y, w, h, z in ((0, 0, 120, 80, 0), (20, 20, 30, 30, 10)):
        corners = [(x, y), (x + w, y), (x + w, y + h), (x, y + h)]
        space.add_lwpolyline(  # type: ignore[attr-defined]
            corners, close=True, dxfattribs={"layer": "GLUE", "elevation": z}
        )


@pytest.mark.parametrize("language", ARMS)
def test_outputs_are_set_where_and_when_the_layer_says(tmp_path: Path, language: str) -> None:
    keys = "on_before = {mm = 4, seconds = 0.03}\noff_before = {mm = 5}\norder = 'drawing'"
    ran = Ran(tmp_path, language, keys + "\ninside_first = false")
    assert [value for _, value in ran.switched] == [1, 0, 1, 0]
    for (on, _), (off, _), start in zip(
        ran.switched[::2], ran.switched[1::2], ((0, 0, 0), (20, 20, 10)), strict=True
    ):
        # 4 mm and 30 ms at 50 mm/s above the start; the last side comes from above, in y.
        assert ran.at(on) == pytest.approx(np.add(start, (0, 0, 4 + 1.5)), abs=0.15)
        assert ran.at(off) == pytest.approx(np.add(start, (0, 5, 0)), abs=0.15)


@pytest.mark.parametrize("language", ARMS)
def test_outputs_behind_the_start_and_behind_the_end(tmp_path: Path, language: str) -> None:
    keys = "on_after = {mm = 7}\noff_after = {mm = 3}\norder = 'drawing'\ninside_first = false"
    ran = Ran(tmp_path, language, keys)
    (on, _), (off, _), *_ = ran.switched
    assert ran.at(on) == pytest.approx((7, 0, 0), abs=0.15)
    assert ran.at(off) == pytest.approx((0, 0, 3), abs=0.15)
    late = Ran(tmp_path, language, "off_after = {seconds = 0.4}\norder = 'drawing'")
    end, stood = late.switched[1][0], (late.speed < 1e-9) & (np.abs(late.tips[:, 2]) < 1e-3)
    standing = late.t[stood & (late.t <= end + 1e-6) & (late.t > end - 2.0)]
    assert end - standing.min() == pytest.approx(0.4, abs=0.01)


@pytest.mark.parametrize("language", ARMS)
def test_corners_the_start_and_the_end_have_their_own_speeds(tmp_path: Path, language: str) -> None:
    keys = (
        "corner_speed = 20\ncorner_length = 6\nstart_speed = 10\nstart_length = 15\n"
        "end_speed = 15\nend_length = 12\norder = 'drawing'\ninside_first = false\n"
    )
    ran = Ran(tmp_path, language, keys)
    x, y, z = ran.tips.T
    on_it = np.abs(z) < 1e-3
    bottom = on_it & (np.abs(y) < 0.01) & (x > 0.5)
    assert ran.speed[bottom & (x < 14)].max() == pytest.approx(10, abs=0.1)
    assert ran.speed[bottom & (x > 17) & (x < 112)].max() == pytest.approx(50, abs=0.1)
    assert ran.speed[bottom & (x > 115)].max() == pytest.approx(20, abs=0.1)
    right = on_it & (x > 119.99)
    assert ran.speed[right & (y < 5)].max() == pytest.approx(20, abs=0.1)
    assert ran.speed[right & (y > 8) & (y < 72)].max() == pytest.approx(50, abs=0.1)
    left = on_it & (np.abs(x) < 0.01) & (y > 0.5)
    assert ran.speed[left & (y < 11)].max() == pytest.approx(15, abs=0.1)
    # The way is the drawn one still.
    apart = np.minimum.reduce([np.abs(x), np.abs(x - 120), np.abs(y), np.abs(y - 80)])
    assert apart[on_it].max() < 0.05


def test_small_arcs_are_corners_too(tmp_path: Path) -> None:
    def rounded(space: object) -> None:
        corner = math.tan(math.radians(90 / 4))
        points = [(8, 0, 0), (92, 0, corner), (100, 8, 0), (100, 60, 0)]
        space.add_lwpolyline(  # type: ignore[attr-defined]
            points, format="xyb", dxfattribs={"layer": "GLUE"}
        )

    ran = Ran(tmp_path, "rapid", "corner_speed = 20\ncorner_radius = 8\n", rounded)
    x, y, z = ran.tips.T
    on_it = np.abs(z) < 1e-3
    assert ran.speed[on_it & (x > 89) & (y < 11)].max() == pytest.approx(20, abs=0.1)
    assert ran.speed[on_it & (x < 84)].max() == pytest.approx(50, abs=0.1)
    arc = on_it & (x > 92.5) & (y < 7.5)
    assert np.hypot(x[arc] - 92, y[arc] - 8) == pytest.approx(8, abs=0.03)
    (said,) = (f for f in ran.compiled.findings if f.code in ("CT222", "CT223"))
    assert "1 corners" in said.message
    plain = Ran(tmp_path, "rapid", "corner_speed = 20\n", rounded)
    assert "CT223" in [f.code for f in plain.compiled.findings]


@pytest.mark.parametrize("language", ARMS)
@pytest.mark.parametrize("kind", ["joint", "linear"])
def test_travel_goes_above_the_whole_layer(tmp_path: Path, language: str, kind: str) -> None:
    keys = f"travel_height = 40\ntravel_blend = 5\ntravel_kind = '{kind}'\napproach = 10\n"
    ran = Ran(tmp_path, language, keys)
    assert ran.joints[0] == pytest.approx(HOME[language], abs=1e-3)
    assert ran.joints[-1] == pytest.approx(HOME[language], abs=1.0)  # a sample before it stops
    x, y, z = ran.tips.T
    between = (ran.t > ran.switched[1][0]) & (ran.t < ran.switched[2][0])
    aside = between & (np.hypot(x - 20, y - 20) > 6) & (np.hypot(x, y) > 6)
    if kind == "linear":  # 40 mm above the square, which is 10 mm above the outline
        assert z[aside].min() == pytest.approx(50.0, abs=0.1)
    assert z[aside].min() > 40.0
    moving = between & (z > 15)
    assert ran.speed[moving].min() > 1.0  # no stop above the work
    assert ("MoveJ" if language == "rapid" else "Mov ") in ran.text


def test_without_home_the_arm_stops_above_the_last_contour(tmp_path: Path) -> None:
    ran = Ran(tmp_path, "rapid", "travel_blend = 5\n")
    (tmp_path / "part.process.toml").write_text(
        (tmp_path / "part.process.toml").read_text().replace("home =", "# home =")
    )
    compiled = compile(tmp_path / "part.dxf", language="rapid", robot=ARMS["rapid"])
    text = next(iter(compiled.files.values())).decode()
    moves = [line for line in text.splitlines() if "MoveL RelTool" in line]
    assert "fine" in moves[-1]
    assert all("z5" in line for line in moves[:-1])
    assert "MoveAbsJ home" in ran.text and "MoveAbsJ" not in text


@pytest.mark.parametrize(
    ("keys", "code"),
    [
        ("on_after = {mm = 7}\noff_before = {mm = 93}", "CT220"),
        ("off_before = {mm = 100}", "CT220"),
        ("on_after = {mm = 100}", "CT220"),
        ("off_before = {mm = 90, seconds = 0.21}", "CT221"),
        ("off_before = {mm = 4, seconds = 0.11}\nend_speed = 10", "CT221"),
        ("off_before = {mm = 90, seconds = 0.19}", None),
        ("off_before = {mm = 6, seconds = 1.7}\nend_speed = 10", None),
        ("on_after = {mm = 7}\noff_before = {mm = 92}", None),
    ],
)
def test_outputs_for_which_a_contour_is_too_short(
    tmp_path: Path, keys: str, code: str | None
) -> None:
    """A line of 100 mm at 50 mm/s, the last 5 mm of which may be slower."""

    def line(space: object) -> None:
        space.add_line((0, 0), (100, 0), dxfattribs={"layer": "GLUE"})  # type: ignore[attr-defined]

    if code is None:
        assert [value for _, value in Ran(tmp_path, "rapid", keys, line).switched] == [1, 0]
        return
    with pytest.raises(Refused) as caught:
        Ran(tmp_path, "rapid", keys, line)
    (finding,) = [f for f in caught.value.findings if f.severity is Severity.ERROR]
    assert finding.code == code


def test_one_move_sets_at_one_place_only(tmp_path: Path) -> None:
    """MELFA-BASIC has one `Wth` a move: a line that switches on and off is divided."""

    def line(space: object) -> None:
        space.add_line((0, 0), (100, 0), dxfattribs={"layer": "GLUE"})  # type: ignore[attr-defined]

    keys = "on_after = {mm = 10}\noff_before = {mm = 20}"
    ran = Ran(tmp_path, "melfa-basic-5", keys, line)
    (on, _), (off, _) = ran.switched
    assert sorted([ran.at(on)[0], ran.at(off)[0]]) in (
        pytest.approx([10, 80], abs=0.15),
        pytest.approx([20, 90], abs=0.15),  # as the line may be run backwards
    )
    going = (ran.t > on) & (ran.t < off)
    assert ran.speed[going].min() == pytest.approx(50, abs=0.1)

"""Files of cameras: they come back as they were written, and what is wrong in them is told."""

from __future__ import annotations

import datetime
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera, Lens
from assistant.vision.cameras.camera_file import (
    CalibrationRecord,
    Rig,
    cameras_in,
    read_cameras,
    rig_toml,
    write_cameras,
)

COORDINATES = st.floats(-5000.0, 5000.0)


@st.composite
def cameras(draw: st.DrawFn) -> Camera:
    focal = draw(st.floats(600.0, 4000.0))
    lens = Lens(
        (640, 480),
        (focal, focal * draw(st.floats(0.9, 1.1))),
        (draw(st.floats(200.0, 400.0)), draw(st.floats(150.0, 330.0))),
        (draw(st.floats(-0.3, 0.3)), 0.05, *(draw(st.floats(-0.02, 0.02)) for _ in "pp"), 0.0),
    )
    place = (draw(COORDINATES), draw(COORDINATES), draw(COORDINATES))
    return Camera(
        "left",
        lens,
        Pose(place, (0.5, 0.5, -0.5, 0.5)),
        draw(st.sampled_from(["world", "arm.flange"])),
    )


@given(cameras(), st.dates(datetime.date(2000, 1, 1)), st.floats(0.0, 10.0), st.text(max_size=20))
def test_a_rig_comes_back_as_it_was_written(
    camera: Camera, date: datetime.date, residual: float, source: str
) -> None:
    said = "".join(c for c in source if c.isprintable()).strip()
    record = CalibrationRecord(date, residual, residual / 2.0, residual / 3.0, 0.01)
    rig = Rig({"left": camera}, {"left": record}, {"left": said})
    assert cameras_in(SourceText(rig_toml(rig), "c.toml", "utf-8", "\n")) == rig


def test_a_file_is_written_whole(tmp_path: Path) -> None:
    rig = Rig(
        {"one": Camera("one", Lens.ideal((640, 480), 800.0))},
        {"one": CalibrationRecord()},
        {"one": ""},
    )
    write_cameras(tmp_path / "cameras.toml", rig)
    assert read_cameras(tmp_path / "cameras.toml").cameras == rig.cameras


GOOD = "[cameras.left]\nsize = [640, 480]\nfocal = [800, 800]\ncentre = [320, 240]\n"


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "VS010"),
        (GOOD.replace("focal = [800, 800]\n", ""), "VS011"),
        (GOOD.replace("800, 800", "800, 9000"), "VS012"),
        (GOOD.replace("800, 800", "2, 2"), "VS012"),
        (GOOD.replace("320, 240", "9000, 240"), "VS012"),
        (GOOD.replace("640, 480", "640"), "CT303"),
        (GOOD.replace("320, 240", "nan, 240"), "CT303"),
        (GOOD + "focus = 3\n", "CT302"),
        (GOOD + "calibrated = 'today'\n", "CT303"),
        (GOOD + "distortion = [1, 2]\n", "CT303"),
        (GOOD + "distortion = [-50, 0, 0, 0, 0]\n", "VS012"),
        (GOOD + "distortion = [0, 0, 5, 0, 0]\n", "VS012"),
        (GOOD + "hand_eye_mm = -1\n", "CT303"),
        (GOOD + "source = 1000\n", "CT303"),
        ("cameras = 3\n", "CT304"),
    ],
)
def test_what_is_no_camera_is_told(text: str, code: str) -> None:
    with pytest.raises(Refused) as told:
        cameras_in(SourceText(text, "c.toml", "utf-8", "\n"))
    assert code in {finding.code for finding in told.value.findings}
    assert told.value.exit_status == 2


def test_a_camera_that_is_not_there_is_told_with_those_that_are() -> None:
    rig = cameras_in(SourceText(GOOD, "c.toml", "utf-8", "\n"))
    with pytest.raises(Refused, match=r"VS013.*left"):
        rig["right"]

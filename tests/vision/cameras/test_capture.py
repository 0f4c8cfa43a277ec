"""Pictures of cameras: where they come from, and what is wrong with them."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import cv2
import numpy as np
import pytest

from assistant.program.diagnostics import Refused
from assistant.vision.cameras.camera import Camera, Lens, looking_at
from assistant.vision.cameras.capture import look_at, opened, read_picture

STANDS = looking_at((900.0, -700.0, 700.0), (250.0, 0.0, 200.0))
CAMERA = Camera("left", Lens.ideal((64, 48), 80.0), STANDS)


def grey(level: int, size: tuple[int, int] = (64, 48)) -> np.ndarray:
    return np.full((size[1], size[0], 3), level, dtype=np.uint8)


def test_a_folder_gives_its_pictures_by_their_numbers(tmp_path: Path) -> None:
    for number in (10, 2, 1):
        cv2.imwrite(str(tmp_path / f"p{number}.png"), grey(number))
    (tmp_path / "notes.txt").write_text("no picture")
    with opened(CAMERA, tmp_path.name, tmp_path.parent) as frames:
        found = list(frames)
    assert [frame.name for frame in found] == ["p1.png", "p2.png", "p10.png"]
    assert [int(frame.picture[0, 0, 0]) for frame in found] == [1, 2, 10]
    assert [frame.number for frame in found] == [0, 1, 2]
    times = [frame.seconds for frame in found]
    assert times == sorted(times)


def test_a_film_gives_its_pictures(tmp_path: Path) -> None:
    film = tmp_path / "film.avi"
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (64, 48))
    for level in (20, 120, 220):
        writer.write(grey(level))
    writer.release()
    with opened(CAMERA, str(film)) as frames:
        levels = [float(frame.picture.mean()) for frame in frames]
    assert levels == pytest.approx([20, 120, 220], abs=4.0)


def test_a_cell_is_drawn_again_and_again() -> None:
    with opened(CAMERA, "samples/cell/stand.toml") as frames:
        first, second = (frame.picture for frame in islice(frames, 2))
    assert first.shape == (48, 64, 3)
    assert first.std() > 10.0
    assert (first != second).any()  # the noise is another one


@pytest.mark.parametrize(
    ("source", "code"),
    [("nowhere", "VS020"), ("7", "VS020"), ("rtsp://127.0.0.1:9/x", "VS020"), (".", "VS020")],
)
def test_a_camera_that_is_not_there_is_told(tmp_path: Path, source: str, code: str) -> None:
    with pytest.raises(Refused, match=code) as told, opened(CAMERA, source, tmp_path) as frames:
        next(frames)
    assert told.value.exit_status == 2


def test_another_size_than_calibrated_is_told(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "p.png"), grey(100, (32, 48)))
    with pytest.raises(Refused, match="VS021"), opened(CAMERA, "p.png", tmp_path) as frames:
        next(frames)


@pytest.mark.parametrize(
    "data", [b"GIF89a...", b"", b"\x89PNG\r\n\x1a\n" + b"\0" * 60, b"\xff\xd8 no jpeg"]
)
def test_what_is_no_picture_is_told(tmp_path: Path, data: bytes) -> None:
    file = tmp_path / "p.png"
    file.write_bytes(data)
    with pytest.raises(Refused):
        read_picture(file)


def test_a_picture_that_says_to_be_huge_is_not_decoded(tmp_path: Path) -> None:
    file = tmp_path / "p.png"
    size = (60_000).to_bytes(4, "big")
    file.write_bytes(
        b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + size + size + b"\x08\x02\0\0\0" + b"\0" * 40
    )
    with pytest.raises(Refused, match="60000"):
        read_picture(file)


def test_dark_and_saturated_pictures_are_told() -> None:
    assert [one.code for one in look_at(CAMERA, grey(3))] == ["VS022"]
    assert [one.code for one in look_at(CAMERA, grey(255))] == ["VS023"]
    assert look_at(CAMERA, grey(120)) == ()

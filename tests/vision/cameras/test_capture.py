"""Pictures of cameras: where they come from, and what is wrong with them."""

from __future__ import annotations

import functools
import http.server
import struct
import threading
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
import pytest

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera, Lens, looking_at
from assistant.vision.cameras.camera_file import Rig, write_cameras
from assistant.vision.cameras.capture import exposure_findings, open_frames, read_picture

STANDS = looking_at((900.0, -700.0, 700.0), (250.0, 0.0, 200.0))
CAMERA = Camera("left", Lens.ideal((64, 48), 80.0), STANDS)


JPEG = bytes(cv2.imencode(".jpg", np.full((48, 64, 3), 90, dtype=np.uint8))[1])


def grey(level: int, size: tuple[int, int] = (64, 48)) -> np.ndarray:
    return np.full((size[1], size[0], 3), level, dtype=np.uint8)


def test_a_folder_gives_its_pictures_by_their_numbers(tmp_path: Path) -> None:
    for number in (10, 2, 1):
        cv2.imwrite(str(tmp_path / f"p{number}.png"), grey(number))
    (tmp_path / "notes.txt").write_text("no picture")
    with open_frames(CAMERA, tmp_path.name, tmp_path.parent) as frames:
        found = list(frames)
    assert [frame.name for frame in found] == ["p1.png", "p2.png", "p10.png"]
    assert [int(frame.picture[0, 0, 0]) for frame in found] == [1, 2, 10]
    assert [frame.number for frame in found] == [0, 1, 2]
    times = [frame.seconds for frame in found]
    assert times == sorted(times)


def film(file: Path) -> Path:
    writer = cv2.VideoWriter(str(file), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (64, 48))
    for level in (20, 120, 220):
        writer.write(grey(level))
    writer.release()
    return file


def test_a_film_gives_its_pictures(tmp_path: Path) -> None:
    with open_frames(CAMERA, str(film(tmp_path / "film.avi"))) as frames:
        levels = [float(frame.picture.mean()) for frame in frames]
    assert levels == pytest.approx([20, 120, 220], abs=4.0)


def test_a_stream_gives_its_pictures_and_is_lost_where_it_ends(tmp_path: Path) -> None:
    film(tmp_path / "film.avi")
    answer = functools.partial(Quiet, directory=str(tmp_path))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), answer) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        levels = []
        try:
            address = f"http://127.0.0.1:{server.server_port}/film.avi"
            with pytest.raises(Refused, match=r"VS024.*3"), open_frames(CAMERA, address) as frames:
                levels += [float(frame.picture.mean()) for frame in islice(frames, 3)]
                next(frames)
        finally:
            server.shutdown()
    assert levels == pytest.approx([20, 120, 220], abs=4.0)


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_: object) -> None:
        pass


def test_a_cell_is_drawn_again_and_again() -> None:
    with open_frames(CAMERA, "samples/cell/stand.toml") as frames:
        first, second = (frame.picture for frame in islice(frames, 2))
    assert first.shape == (48, 64, 3)
    assert first.std() > 10.0
    assert (first != second).any()  # the noise is another one


def test_a_camera_that_is_carried_is_drawn_where_its_robot_is_at_home() -> None:
    robot = robots.get("irb1200-7-0.7")
    place, turn = robot.fk(robot.home[None])
    flange = Pose.of(place[0], turn[0])
    carried = Camera("hand", CAMERA.lens, flange.inverse() @ STANDS, "arm.flange")
    pictures = []
    for camera in (CAMERA, carried):
        with open_frames(camera, "samples/cell/stand.toml") as frames:
            pictures.append(next(frames).picture.astype(int))
    assert np.abs(pictures[0] - pictures[1]).max() <= 2  # of rays that meet an edge
    lost = Camera("hand", CAMERA.lens, Pose(), "arm.elbow")
    source = "samples/cell/stand.toml"
    with pytest.raises(Refused, match=r"arm\.elbow"), open_frames(lost, source) as frames:
        next(frames)


@pytest.mark.parametrize(
    "source",
    [
        "nowhere",
        "7",
        "9" * 30,
        "²",
        "rtsp://127.0.0.1:9/x",
        ".",
        "list.m3u8",
        "film.avi",
        "cell.txt",
    ],
)
def test_a_camera_that_is_not_there_is_told(tmp_path: Path, source: str) -> None:
    for name in ("list.m3u8", "film.avi", "cell.txt"):
        (tmp_path / name).write_text("#EXTM3U\n/etc/passwd\n")
    with (
        pytest.raises(Refused, match="VS020") as told,
        open_frames(CAMERA, source, tmp_path) as frames,
    ):
        next(frames)
    assert told.value.exit_status == 2


def test_another_size_than_calibrated_is_told(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "p.png"), grey(100, (32, 48)))
    with pytest.raises(Refused, match="VS021"), open_frames(CAMERA, "p.png", tmp_path) as frames:
        next(frames)


@pytest.mark.parametrize(
    "data",
    [
        JPEG[: len(JPEG) // 2],
        b"GIF89a...",
        b"",
        b"\x89PNG\r\n\x1a\n" + b"\0" * 60,
        b"\xff\xd8 no jpeg",
    ],
)
def test_what_is_no_picture_is_told(tmp_path: Path, data: bytes) -> None:
    file = tmp_path / "p.png"
    file.write_bytes(data)
    with pytest.raises(Refused):
        read_picture(file)


SIDE = struct.pack(">H", 60_000)
FRAME = JPEG.index(b"\xff\xc0") + 5
HUGE = {
    "png": b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0" + SIDE + b"\0\0" + SIDE + b"\x08\2" + b"\0" * 43,
    "jpg": JPEG[:FRAME] + SIDE * 2 + JPEG[FRAME + 4 :],
    "bmp": b"BM"
    + struct.pack("<IHHIIiiHHIIiiII", 99, 0, 0, 54, 40, *2 * [60_000], 1, 24, *6 * [0]),
}
READ = """
import sys
from assistant.base.diagnostics import Refused
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera_file import Rig, write_cameras
from assistant.vision.cameras.capture import read_picture
for file in sys.argv[1:]:
    try:
        read_picture(file)
    except Refused as refused:
        print(refused.findings[0].code)
"""


def test_a_picture_that_says_to_be_huge_is_not_decoded(tmp_path: Path, forks) -> None:
    """In a process of its own: OpenCV is told how much it may decode before it is loaded."""
    for kind, data in HUGE.items():
        (tmp_path / f"p.{kind}").write_bytes(data)
    (tmp_path / "read.py").write_text(READ)
    done = forks.python("read.py", *(f"p.{kind}" for kind in HUGE), cwd=tmp_path)
    assert done.stdout.split() == ["VS025"] * 3, done.stderr


def test_without_opencv_it_is_said_what_to_install(tmp_path: Path, forks) -> None:
    script = "import sys\nsys.modules['cv2'] = None\nfrom assistant.cli import main\nmain()\n"
    (tmp_path / "lacking.py").write_text(script)
    write_cameras(tmp_path / "cameras.toml", Rig({"left": CAMERA}))
    words = ("camera", "view", "cameras.toml", "left", "-o", "v.png", "--source", "3")
    done = forks.python("lacking.py", *words, cwd=tmp_path)
    assert done.returncode == 2
    assert "VS001" in done.stderr and "[vision]" in done.stderr


def test_dark_and_saturated_pictures_are_told() -> None:
    assert [one.code for one in exposure_findings(CAMERA, grey(3))] == ["VS022"]
    assert [one.code for one in exposure_findings(CAMERA, grey(255))] == ["VS023"]
    assert exposure_findings(CAMERA, grey(120)) == ()

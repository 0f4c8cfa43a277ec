"""Pictures from cameras, and checks of them.

with open_frames(rig["left"], "pictures/left") as frames:
    for frame in frames: ...

A source is a device, a stream, a video, a picture, a folder of pictures, or a cell file, which is
drawn. The checks: exposure, whether two cameras agree on what both see, and whether pictures in
folders of several cameras are of the same moments, by the numbers in their names.
"""

from __future__ import annotations

import re
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path as FilePath
from pathlib import PurePath
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.source_text import is_file, is_folder, read_bytes
from assistant.vision import rules
from assistant.vision.cameras.camera import Camera, triangulate
from assistant.vision.cameras.synthetic_pictures import Picture
from assistant.vision.opencv import MOST_PIXELS, silent

_DARK_LEVEL: Final = 12.0
"""Grey level below which half of a picture shows nothing."""
_MOST_SATURATED: Final = 0.25
"""Part of a picture that may be as bright as can be."""
_MOST_BYTES: Final = 100_000_000
_STREAM_TIMEOUT: Final = 5000
"""Milliseconds until a stream that does not answer is given up."""
_VIDEO_SUFFIXES: Final = (
    ".avi",
    ".mp4",
    ".m4v",
    ".mkv",
    ".webm",
    ".mpg",
    ".mpeg",
    ".mjpeg",
    ".mjpg",
)
"""Suffixes of files for the film decoder; lists of other files and addresses are excluded."""
_PICTURE_SUFFIXES: Final = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")
STREAM_ADDRESS: Final = re.compile(r"(?:rtsp|rtsps|http|https|udp|tcp)://", re.IGNORECASE)
_PICTURE_SIGNATURES: Final = (b"\x89PNG", b"\xff\xd8", b"BM", b"II*\0", b"MM\0*")
"""First bytes of picture files; other files are not passed to the decoder."""


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A picture (h, w, 3), blue first. number: from 0. seconds: when it came, of a clock that only
    rises. name: of its file, "" for none.
    """

    picture: Picture
    number: int
    seconds: float
    name: str = ""


@contextmanager
def open_frames(
    camera: Camera, source: str, folder: FilePath = FilePath()
) -> Iterator[Iterator[Frame]]:
    """Yield the frames of a camera, one for each request.

    source: the number of a device, the address of a stream, a film, a picture, a folder of pictures
    in the order of their numbers, or a cell file (.toml), which is drawn again and again with its
    robots at home. Relative files are in `folder`. Films and folders end; a device or a stream that
    ends is lost. Raises Refused (exit status 2) if the camera or the picture is missing, a picture
    has another size, or the camera is lost.
    """
    if source.isascii() and source.isdigit():
        if len(source) > 2:
            cure = "devices are counted from 0"
            raise Refused(_not_opened(camera, source, "there is nothing", cure), exit_status=2)
        with _open_device(camera, int(source), f"device {source}") as frames:
            yield frames
        return
    if STREAM_ADDRESS.match(source):
        with _open_device(camera, source, source) as frames:
            yield frames
        return
    path = folder / source
    if path.suffix.lower() == ".toml":
        yield _drawn_frames(camera, path)
    elif is_folder(path):
        yield _folder_frames(camera, path)
    elif path.suffix.lower() in _PICTURE_SUFFIXES:
        yield iter(
            [
                Frame(
                    _with_calibrated_size(camera, read_picture(path)),
                    0,
                    time.monotonic(),
                    path.name,
                )
            ]
        )
    elif path.suffix.lower() in _VIDEO_SUFFIXES and is_file(path):
        with _open_device(camera, str(path), str(path)) as frames:
            yield frames
    else:
        reason = "it is neither film nor picture" if is_file(path) else "there is nothing"
        cure = "name a folder, a film, a picture, an address, or the number of a device"
        raise Refused(_not_opened(camera, source, reason, cure), exit_status=2)


def read_picture(path: str | FilePath) -> Picture:
    """Read a picture (h, w, 3) from a file; raises Refused (exit status 2) for any other file."""
    data = read_bytes(path, most=_MOST_BYTES)
    reason = _unlike_a_picture(data)
    if reason is None:
        with silent() as cv:
            # A lens is that of the sensor: however the camera was held, its pixels stay its pixels.
            how = cv.IMREAD_COLOR | cv.IMREAD_IGNORE_ORIENTATION
            try:
                picture = cv.imdecode(np.frombuffer(data, np.uint8), how)
            except cv.error:
                picture = None
        if picture is not None:
            return np.asarray(picture)
        reason = "what it holds cannot be decoded"
    raise Refused(rules.NOT_A_PICTURE(path=str(path), reason=reason), exit_status=2)


def exposure_findings(camera: Camera, picture: Picture) -> tuple[Diagnostic, ...]:
    """Return findings for a dark or saturated picture."""
    found = []
    brightest = picture.max(axis=2)
    if float(np.median(brightest)) < _DARK_LEVEL:
        found.append(rules.DARK_PICTURE(name=camera.name, level=_DARK_LEVEL))
    part = float((picture.min(axis=2) >= 255).mean())
    if part > _MOST_SATURATED:
        found.append(rules.SATURATED_PICTURE(name=camera.name, percent=100.0 * part))
    return tuple(found)


def picture_names(source: str, folder: FilePath = FilePath()) -> list[str] | None:
    """Return the names of the pictures of a source, in their order; None if it is not a folder of
    pictures.
    """
    number = source.isascii() and source.isdigit()
    if number or STREAM_ADDRESS.match(source) or not is_folder(folder / source):
        return None
    return [file.name for file in pictures_in(folder / source)]


def pictures_in(folder: str | FilePath) -> list[FilePath]:
    """The pictures of a folder, by the numbers in their names: 2 stands before 10."""
    files = (one for one in FilePath(folder).iterdir() if one.suffix.lower() in _PICTURE_SUFFIXES)
    return sorted(files, key=lambda one: _number_order(one.name))


def _number_order(name: str) -> list[tuple[int, int, str]]:
    parts = re.findall(r"\d+|\D+", name)
    return [(0, int(p), "") if p.isdecimal() else (1, 0, p.casefold()) for p in parts]


def _unlike_a_picture(data: bytes) -> str | None:
    start = next((one for one in _PICTURE_SIGNATURES if data.startswith(one)), None)
    if start is None:
        return "it begins like no PNG, JPEG, BMP or TIFF"
    if start == b"\x89PNG" and len(data) >= 24:
        width, height = (int.from_bytes(data[i : i + 4], "big") for i in (16, 20))
        if width * height > MOST_PIXELS:
            return f"it says to have {width} × {height} pixels"
    if start == b"\xff\xd8" and data.rfind(b"\xff\xd9") < data.rfind(b"\xff\xda"):
        return "its end is missing"
    return None


def _with_calibrated_size(camera: Camera, picture: Picture) -> Picture:
    given = picture.shape[1], picture.shape[0]
    if given != camera.lens.size:
        told = [f"{w} × {h}" for w, h in (given, camera.lens.size)]
        finding = rules.OTHER_PICTURE_SIZE(name=camera.name, given=told[0], wanted=told[1])
        raise Refused(finding, exit_status=2)
    return picture


def _folder_frames(camera: Camera, folder: FilePath) -> Iterator[Frame]:
    files = pictures_in(folder)
    if not files:
        cure = f"put pictures there, as {', '.join(_PICTURE_SUFFIXES)}"
        raise Refused(_not_opened(camera, str(folder), "it holds none", cure), exit_status=2)
    for number, file in enumerate(files):
        picture = _with_calibrated_size(camera, read_picture(file))
        yield Frame(picture, number, time.monotonic(), file.name)


def _drawn_frames(camera: Camera, cell: FilePath) -> Iterator[Frame]:
    """Yield a cell as a camera in it sees it; each picture has different noise."""
    from assistant.cell.cell_file import read_scene
    from assistant.vision.cameras.synthetic_pictures import bodies_of_scene, camera_in_world, draw

    scene, _ = read_scene(cell)
    stands, things = camera_in_world(camera, scene), bodies_of_scene(scene)
    number = 0
    while True:
        yield Frame(draw(stands, things, seed=number), number, time.monotonic())
        number += 1


@contextmanager
def _open_device(camera: Camera, source: int | str, named: str) -> Iterator[Iterator[Frame]]:
    with silent() as cv:
        if STREAM_ADDRESS.match(named):
            limits = [cv.CAP_PROP_OPEN_TIMEOUT_MSEC, _STREAM_TIMEOUT]
            limits += [cv.CAP_PROP_READ_TIMEOUT_MSEC, _STREAM_TIMEOUT]
            device = cv.VideoCapture(source, cv.CAP_FFMPEG, limits)
        else:
            device = cv.VideoCapture(source)
    try:
        if not device.isOpened():
            cure = "look whether it is plugged in, and whether others use it"
            raise Refused(_not_opened(camera, named, "it does not open", cure), exit_status=2)
        if isinstance(source, int):
            width, height = camera.lens.size
            device.set(cv.CAP_PROP_FRAME_WIDTH, width)
            device.set(cv.CAP_PROP_FRAME_HEIGHT, height)
        yield _device_frames(camera, device, named)
    finally:
        device.release()


def _device_frames(camera: Camera, device: Any, named: str) -> Iterator[Frame]:
    number = 0
    while True:
        there, picture = device.read()
        if not there:
            if number == 0:
                cure = "look whether others use it"
                raise Refused(_not_opened(camera, named, "no picture came", cure), exit_status=2)
            if not named.lower().endswith(_VIDEO_SUFFIXES) or STREAM_ADDRESS.match(named):
                raise Refused(rules.CAMERA_LOST(name=camera.name, count=number), exit_status=2)
            return
        yield Frame(_with_calibrated_size(camera, np.asarray(picture)), number, time.monotonic())
        number += 1


def _not_opened(camera: Camera, source: str, reason: str, cure: str) -> Diagnostic:
    return rules.CAMERA_NOT_OPENED(name=camera.name, source=source, reason=reason, cure=cure)


@dataclass(frozen=True, slots=True)
class Agreement:
    """Agreement of two cameras about corners of a board that both see. corners: number of corners.
    pixels: root mean square residual of the points. mm: the same for distances between neighbours,
    compared with the board's distances.
    """

    cameras: tuple[str, str]
    corners: int
    pixels: float
    mm: float


_MOST_RESIDUAL = 1.0
"""Pixels from which on two cameras do not stand as they were calibrated."""


def check_agreement(
    cameras: Sequence[Camera], pixels: Sequence[Floats], corners: Floats
) -> tuple[Agreement, tuple[Diagnostic, ...]]:
    """Two cameras in the world that see the same corners. corners: (n, 3) mm on the board."""
    found = triangulate(cameras, pixels)
    names = (cameras[0].name, cameras[1].name)
    good = np.isfinite(found.residuals)
    if good.sum() < 2:
        told = rules.CAMERAS_DISAGREE(one=names[0], other=names[1], pixels=np.inf)
        return Agreement(names, 0, np.inf, np.inf), (told,)
    seen, known = found.points[good], corners[good]
    off = np.linalg.norm(np.diff(seen, axis=0), axis=1) - np.linalg.norm(
        np.diff(known, axis=0), axis=1
    )
    left = float(np.sqrt((found.residuals[good] ** 2).mean()))
    mm = float(np.sqrt((off**2).mean()))
    findings = (
        (rules.CAMERAS_DISAGREE(one=names[0], other=names[1], pixels=left),)
        if left > _MOST_RESIDUAL
        else ()
    )
    return Agreement(names, int(good.sum()), left, mm), findings


def pictures_findings(
    cameras: Mapping[str, Camera], frames: Mapping[str, Frame]
) -> tuple[Diagnostic, ...]:
    """Dark and saturated pictures."""
    return tuple(
        one
        for name, frame in frames.items()
        for one in exposure_findings(cameras[name], frame.picture)
    )


def pairing_finding(
    one: str, names: Sequence[str], other: str, others: Sequence[str]
) -> Diagnostic | None:
    """Return the reason why pictures of two cameras cannot be paired in their order, None if they
    can.

    one, other: names of the cameras. names, others: names of their files, in their order. The last
    number in each name counts pictures if most of them follow each other by one: then a number that
    one camera has and the other lacks is a missing picture. Each may start from any number, and one
    of them may have more pictures at the end.
    """
    counted = _picture_numbers(names), _picture_numbers(others)
    if counted[0] is None or counted[1] is None:
        count, more = len(names), len(others)
        if count == more:
            return None
        return rules.UNEVEN_PICTURES(one=one, count=count, other=other, others=more)
    both = min(len(names), len(others))
    apart = np.flatnonzero(counted[0][:both] != counted[1][:both])
    if not len(apart):
        return None
    at = int(apart[0])
    return rules.PICTURES_OUT_OF_STEP(one=one, other=other, first=names[at], second=others[at])


def _picture_numbers(names: Sequence[str]) -> Rows | None:
    """(n,) numbers of pictures from the first on, None if the names do not count."""
    found = [re.findall(r"\d{1,15}", PurePath(name).stem) for name in names]
    if not names or not all(found):
        return None
    numbers = np.array([int(one[-1]) for one in found])
    if len(numbers) > 1 and np.median(np.diff(numbers)) != 1.0:
        return None
    return np.asarray(numbers - numbers[0])

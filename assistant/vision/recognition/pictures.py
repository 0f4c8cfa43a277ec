"""Pictures of files, and whether they are good enough to look for objects in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path as FilePath
from types import ModuleType
from typing import Final

import numpy as np

from assistant.program.diagnostics import Diagnostic, Refused, Unreadable
from assistant.program.text import read_bytes
from assistant.sources.process.values import listed, shown
from assistant.vision.cameras.camera import Camera
from assistant.vision.recognition.photo import Picture
from assistant.vision.recognition.rules import (
    DARK,
    NO_PICTURE,
    OTHER_SIZE,
    SATURATED,
    TWICE,
    WHICH_CAMERA,
)

DARKEST: Final = 12.0
"""Grey level below which half of a picture must not be."""
MOST_SATURATED: Final = 0.25
"""Part of a picture that may have the highest level."""
MOST_BYTES: Final = 100_000_000
MOST_PIXELS: Final = 100_000_000
STARTS: Final = (b"\x89PNG", b"\xff\xd8", b"BM", b"II*\0", b"MM\0*")
"""How files of pictures begin; others are not handed to what decodes them."""


def read_picture(cv: ModuleType, path: str | FilePath) -> Picture:
    """A picture (h, w, 3) of a file; raises Unreadable for what is none, or is too large."""
    data = read_bytes(path, most=MOST_BYTES)
    start = next((one for one in STARTS if data.startswith(one)), None)
    if start is None:
        raise Unreadable(NO_PICTURE(path=str(path), reason="it begins like no PNG, JPEG or TIFF"))
    if start == b"\x89PNG" and len(data) >= 24:
        width, height = (int.from_bytes(data[i : i + 4], "big") for i in (16, 20))
        if width * height > MOST_PIXELS:
            reason = f"it says to have {width} × {height} pixels"
            raise Unreadable(NO_PICTURE(path=str(path), reason=reason))
    try:
        picture = cv.imdecode(np.frombuffer(data, np.uint8), cv.IMREAD_COLOR)
    except cv.error as wrong:
        raise Unreadable(NO_PICTURE(path=str(path), reason=shown(str(wrong), 100))) from None
    if picture is None or picture.shape[0] < 16 or picture.shape[1] < 16:
        reason = "what it holds cannot be decoded" if picture is None else "it is too small"
        raise Unreadable(NO_PICTURE(path=str(path), reason=reason))
    return np.asarray(picture)


def faults(picture: Picture, camera: Camera, path: str) -> Iterator[Diagnostic]:
    """What keeps a picture of a camera from being looked at."""
    size = picture.shape[1], picture.shape[0]
    if size != camera.lens.size:
        wanted = camera.lens.size
        yield OTHER_SIZE(path=path, given=size, camera=camera.name, wanted=wanted)
    brightest = picture.max(axis=2)
    if float(np.median(brightest)) < DARKEST:
        yield DARK(path=path, level=DARKEST)
    part = float((picture.min(axis=2) >= 255).mean())
    if part > MOST_SATURATED:
        yield SATURATED(path=path, part=part)


def by_camera(given: Sequence[str], cameras: Mapping[str, Camera]) -> dict[str, str]:
    """The files of pictures by their cameras: CAMERA=FILE, files named like their camera, or the
    only picture of the only camera. Raises Refused (exit status 2).
    """
    found: dict[str, str] = {}
    for one in given:
        name, equals, file = one.partition("=")
        if not (equals and name in cameras):
            stem = FilePath(one).stem
            only = len(given) == 1 and len(cameras) == 1
            name, file = (stem if stem in cameras else next(iter(cameras)) if only else ""), one
        if not name:
            names = listed(list(cameras))
            raise Refused(WHICH_CAMERA(name=shown(one), names=names), exit_status=2)
        if name in found:
            raise Refused(TWICE(name=name), exit_status=2)
        found[name] = file
    return found

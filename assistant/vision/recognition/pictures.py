"""The pictures of one moment, each of the camera that took it, good enough to be looked at."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath

from assistant.base.diagnostics import Refused, Severity
from assistant.program.settings_tables import listed, shown
from assistant.vision.cameras import rules as of_cameras
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.capture import exposure_findings, read_picture
from assistant.vision.recognition.photo import Picture
from assistant.vision.recognition.rules import AMBIGUOUS_CAMERA, TWO_PICTURES


def read_pictures_of_cameras(
    given: Sequence[str], cameras: Mapping[str, Camera]
) -> dict[str, Picture]:
    """Pictures by their cameras: of CAMERA=FILE, of files named like their camera, or the only
    picture of the only camera. Raises Refused, see `picture_of`.
    """
    files: dict[str, str] = {}
    for one in given:
        name, file = split_camera_and_file(one, cameras, alone=len(given) == 1)
        if name in files:
            raise Refused(TWO_PICTURES(name=name), exit_status=2)
        files[name] = file
    return {name: read_picture_of_camera(file, cameras[name]) for name, file in files.items()}


def read_picture_of_camera(file: str, camera: Camera) -> Picture:
    """The picture of a file; raises Refused for one of another size than calibrated, and for one
    that is dark or saturated: of these nothing is told that anybody acts on.
    """
    picture = read_picture(file)
    size = picture.shape[1], picture.shape[0]
    if size != camera.lens.size:
        said, wanted = (f"{w} × {h}" for w, h in (size, camera.lens.size))
        told = of_cameras.OTHER_PICTURE_SIZE(path=file, name=camera.name, given=said, wanted=wanted)
        raise Refused(told, exit_status=2)
    return check_exposure(picture, camera, file)


def check_exposure(picture: Picture, camera: Camera, source: str) -> Picture:
    """The picture itself; raises Refused for a dark or saturated one."""
    doubts = exposure_findings(camera, picture)
    if doubts:
        raise Refused(*(replace(one, severity=Severity.ERROR, path=source) for one in doubts))
    return picture


def split_camera_and_file(
    given: str, cameras: Mapping[str, Camera], *, alone: bool
) -> tuple[str, str]:
    """Name of the camera and file of a picture; alone: the only camera took it, if it names none.

    Raises Refused (exit status 2) where that is not told.
    """
    name, equals, file = given.partition("=")
    if equals and name in cameras:
        return name, file
    stem = FilePath(given).stem
    if stem in cameras:
        return stem, given
    if alone and len(cameras) == 1:
        return next(iter(cameras)), given
    names = listed(list(cameras))
    raise Refused(AMBIGUOUS_CAMERA(name=shown(given), names=names), exit_status=2)

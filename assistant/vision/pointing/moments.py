"""Pictures of several cameras, joined moment by moment."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from itertools import combinations
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.camera_file import Rig
from assistant.vision.cameras.capture import Frame, open_frames, picture_names
from assistant.vision.cameras.pairing import pairing_finding
from assistant.vision.pointing import rules
from assistant.vision.pointing.tracking import Moment

FILE_RATE: Final = 30.0
"""Pictures a second of files, which do not say when they were taken."""


@contextmanager
def open_moments(
    rig: Rig,
    cameras: Sequence[Camera],
    rate: float = FILE_RATE,
) -> Iterator[Iterator[Moment]]:
    """The moments of cameras of a rig, until one of them gives no more pictures.

    Raises Refused (exit status 2) for a camera without a source, for folders whose pictures are not
    of the same moments, and as `capture.opened` does.
    """
    for camera in cameras:
        if not rig.sources.get(camera.name):
            raise Refused(rules.NO_PICTURE_SOURCE(camera=camera.name), exit_status=2)
    sources = [rig.sources[camera.name] for camera in cameras]
    _check_pairing(rig, cameras, sources)
    with ExitStack() as stack:
        frames = [
            stack.enter_context(open_frames(camera, source, rig.folder))
            for camera, source in zip(cameras, sources, strict=True)
        ]
        yield _join_frames(frames, rate)


def _check_pairing(rig: Rig, cameras: Sequence[Camera], sources: Sequence[str]) -> None:
    named = {
        camera.name: files
        for camera, source in zip(cameras, sources, strict=True)
        if (files := picture_names(source, rig.folder))
    }
    for (one, names), (other, others) in combinations(named.items(), 2):
        if (finding := pairing_finding(one, names, other, others)) is not None:
            raise Refused(finding, exit_status=2)


def _join_frames(frames: Sequence[Iterator[Frame]], rate: float) -> Iterator[Moment]:
    began: float | None = None
    for group in zip(*frames, strict=False):
        first = group[0]
        began = first.seconds if began is None else began
        seconds = first.number / rate if first.name else first.seconds - began
        yield Moment(seconds, [frame.picture for frame in group])

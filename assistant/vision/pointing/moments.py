"""Pictures of several cameras, joined moment by moment."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Final

from assistant.program.diagnostics import Diagnostic, Refused
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.camera_file import Rig
from assistant.vision.cameras.capture import Frame, opened
from assistant.vision.pointing import rules
from assistant.vision.pointing.tracking import Moment

RATE: Final = 30.0
"""Pictures a second of files, which do not say when they were taken."""
UNEVEN: Final = 0.05
"""Seconds between the pictures of one moment from which on it is said."""


@contextmanager
def moments(
    rig: Rig,
    cameras: Sequence[Camera],
    rate: float = RATE,
    tell: Callable[[Diagnostic], None] = lambda _: None,
) -> Iterator[Iterator[Moment]]:
    """The moments of cameras of a rig, until one of them gives no more pictures.

    Raises Refused (exit status 2) for a camera without a source, and as `capture.opened` does.
    """
    for camera in cameras:
        if not rig.sources.get(camera.name):
            raise Refused(rules.NO_SOURCE(camera=camera.name), exit_status=2)
    with ExitStack() as stack:
        sources = [rig.sources[camera.name] for camera in cameras]
        frames = [
            stack.enter_context(opened(camera, source, rig.folder))
            for camera, source in zip(cameras, sources, strict=True)
        ]
        yield _joined(frames, rate, tell)


def _joined(
    frames: Sequence[Iterator[Frame]], rate: float, tell: Callable[[Diagnostic], None]
) -> Iterator[Moment]:
    began: float | None = None
    said = False
    for group in zip(*frames, strict=False):
        times = [frame.seconds for frame in group]
        filed = any(frame.name for frame in group)
        if not filed and not said and max(times) - min(times) > UNEVEN:
            tell(rules.UNEVEN_TIME(seconds=max(times) - min(times)))
            said = True
        began = times[0] if began is None else began
        seconds = group[0].number / rate if filed else times[0] - began
        yield Moment(seconds, [frame.picture for frame in group])

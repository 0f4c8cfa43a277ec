"""Eyes of real cameras: a thread reads each camera, and its newest picture counts."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path as FilePath
from types import TracebackType
from typing import Self

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.vision import rules
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.capture import Frame, open_frames
from assistant.vision.servoing.control_laws import TargetSighting
from assistant.vision.servoing.visual_targets import VisualTarget


@dataclass(frozen=True, slots=True)
class SoughtTargets:
    """Things to search for in pictures. target, mark: None if not searched."""

    target: VisualTarget | None = None
    mark: VisualTarget | None = None


def require_sources(cameras: Sequence[Camera], sources: Mapping[str, str]) -> None:
    """Raise Refused for a camera of which no source of pictures is known."""
    for camera in cameras:
        if not sources.get(camera.name):
            raise Refused(rules.NO_SERVO_SOURCE(camera=camera.name), exit_status=2)


class LiveEyes:
    """A context manager. sources: where the pictures of each camera come from, see `open_frames`.

    folder: in which relative files stand.
    """

    def __init__(
        self,
        cameras: Sequence[Camera],
        sources: Mapping[str, str],
        looked: SoughtTargets,
        folder: FilePath = FilePath(),
    ) -> None:
        self.cameras = tuple(cameras)
        self._looked = looked
        require_sources(cameras, sources)
        self._readers = [CameraReader(camera, sources[camera.name], folder) for camera in cameras]
        self._open = ExitStack()
        self._number = -1

    def __enter__(self) -> Self:
        with ExitStack() as opening:
            for reader in self._readers:
                opening.enter_context(reader.running())
            self._open = opening.pop_all()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._open.__exit__(kind, error, trace)

    def look(self, after: float, patience: float) -> TargetSighting | None:
        """The newest picture of each camera; raises Refused where one gives no more."""
        end = time.monotonic() + patience
        frames = []
        for reader in self._readers:
            frame = reader.newest(after, end)
            if frame is None:
                return None
            frames.append(frame)
        self._number += 1
        seconds = min(frame.seconds for frame in frames)
        looked = self._looked
        return TargetSighting(
            seconds,
            self._number,
            self._found(frames, looked.target),
            self._found(frames, looked.mark),
        )

    def _found(self, frames: Sequence[Frame], thing: VisualTarget | None) -> Mapping[str, Floats]:
        if thing is None:
            return {}
        return {
            camera.name: thing.find(frame.picture, camera)
            for camera, frame in zip(self.cameras, frames, strict=True)
        }


class CameraReader:
    """The newest frame of a camera, and how it ended."""

    def __init__(self, camera: Camera, source: str, folder: FilePath) -> None:
        self._camera, self._source, self._folder = camera, source, folder
        self._news = threading.Condition()
        self._frame: Frame | None = None
        self._failure: Refused | None = None
        self._over = threading.Event()

    @contextmanager
    def running(self) -> Iterator[None]:
        with open_frames(self._camera, self._source, self._folder) as frames:
            thread = threading.Thread(target=self._read, args=(frames,), daemon=True)
            thread.start()
            try:
                yield
            finally:
                self._over.set()
                thread.join()

    def newest(self, after: float, end: float) -> Frame | None:
        """A frame of after a time, None if none comes until `end`; raises Refused."""
        with self._news:
            self._news.wait_for(
                lambda: self._is_after(after) or self._failure is not None,
                max(0.0, end - time.monotonic()),
            )
            if self._is_after(after):
                return self._frame
            if self._failure is not None:
                raise self._failure
            return None

    def _is_after(self, after: float) -> bool:
        return self._frame is not None and self._frame.seconds > after

    def _read(self, frames: Iterator[Frame]) -> None:
        number, failure = 0, None
        try:
            for frame in frames:
                if self._over.is_set():
                    return
                with self._news:
                    self._frame, number = frame, frame.number
                    self._news.notify_all()
        except Refused as refused:
            failure = refused
        finally:  # nobody waits for ever, whatever it was
            ended = Refused(
                rules.PICTURES_ENDED(camera=self._camera.name, number=number), exit_status=2
            )
            with self._news:
                self._failure = failure or ended
                self._news.notify_all()

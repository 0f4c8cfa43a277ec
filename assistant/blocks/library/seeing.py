"""What cameras see: pixels of a marker, drawn or in pictures, and where a pointing device is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path as FilePath
from typing import ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.blocks.diagrams.block import Block, Port
from assistant.blocks.library.arrays import POSE_SIZE, pose_parts, pose_port, pose_signal
from assistant.blocks.library.arriving import value_source
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import WORLD, Camera
from assistant.vision.cameras.camera_file import Rig
from assistant.vision.cameras.capture import open_frames
from assistant.vision.pointing.devices import Device
from assistant.vision.pointing.locating import USUAL_LIMITS, Limits, Sighting
from assistant.vision.pointing.moments import FILE_RATE, open_moments
from assistant.vision.pointing.tracking import Observation, track_device
from assistant.vision.servoing.things import VisualTarget

NOISE_SEED: Final = 0


class ProjectedMarker(Block):
    """pose of a thing (and that of what carries the camera) → pixels of its points, seen.

    pixels: u, v of each of the n points of the thing, NaN for those that are outside of the
    picture or behind the camera; nothing hides anything. seen: whether all are in it. noise: pixels
    of a normal distribution, one sigma; the same at each run. A camera of the world needs no other
    pose than the thing's.
    """

    def __init__(
        self,
        name: str,
        camera: Camera,
        thing: VisualTarget,
        *,
        noise: float = 0.0,
        seed: int = NOISE_SEED,
    ) -> None:
        carried = [] if camera.parent == WORLD else [pose_port("carrier")]
        outputs = [Port("pixels", 2 * len(thing.points)), Port("seen")]
        super().__init__(name, [pose_port(), *carried], outputs)
        self.camera, self.thing, self.noise, self.seed = camera, thing, noise, seed
        self._chance = np.random.default_rng(seed)

    def begin(self) -> None:
        self._chance = np.random.default_rng(self.seed)

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        del now
        camera = self.camera
        if len(given) > 1:
            place, turn = pose_parts(given[1])
            camera = camera.carried(Pose.of(place[0], turn[0]))
        place, turn = pose_parts(given[0])
        pixels = camera.project(rotations.rotate(turn, self.thing.points) + place)
        pixels = pixels + self.noise * self._chance.normal(size=pixels.shape)
        inside = camera.within(pixels)
        return [np.where(inside[:, None], pixels, np.nan).ravel(), [float(inside.all())]]


class SeenMarker(Block):
    """Pictures of a camera → pixels of the points of a thing, seen, number of the picture.

    source: where the pictures come from, see `capture.opened`; `folder` holds relative files. Those
    of devices and streams are looked at as they come, in a thread of its own; films, folders of
    pictures and drawn cells have so many a second (`rate`), in the time of the model. pixels: as of
    `ProjectedMarker`, NaN where the thing is not seen. number: -1 before the first picture.
    """

    direct: ClassVar[bool] = False

    def __init__(
        self,
        name: str,
        camera: Camera,
        thing: VisualTarget,
        source: str,
        *,
        folder: FilePath = FilePath(),
        rate: float = FILE_RATE,
        period: float | None = None,
    ) -> None:
        width = 2 * len(thing.points)
        outputs = [Port("pixels", width), Port("seen"), Port("number")]
        super().__init__(name, (), outputs, period=period)

        @contextmanager
        def opening() -> Iterator[Iterator[tuple[float, tuple[int, Floats]]]]:
            with open_frames(camera, source, folder) as frames:
                yield (
                    (frame.number / rate, (frame.number, thing.find(frame.picture, camera).ravel()))
                    for frame in frames
                )

        self._arriving = value_source(opening, source)
        self._nothing = -1, np.full(width, np.nan)

    def begin(self) -> None:
        self._arriving.begin()

    def end(self) -> None:
        self._arriving.end()

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Raises Refused for a camera that is lost."""
        del given
        number, pixels = self._arriving.at(now) or self._nothing
        return [pixels, [float(np.isfinite(pixels).all())], [float(number)]]


class PointingDevice(Block):
    """Cameras → pose that a device shows, confidence (0 to 1), seen.

    The pose is that of when it was seen last, NaN before; the confidence is 0 while it is not seen.
    rig: cameras with their sources, live or in the time of the model as those of `SeenMarker`.
    """

    direct: ClassVar[bool] = False

    def __init__(
        self,
        name: str,
        rig: Rig,
        device: Device,
        *,
        cameras: Sequence[str] | None = None,
        limits: Limits = USUAL_LIMITS,
        rate: float = FILE_RATE,
        period: float | None = None,
    ) -> None:
        outputs = [pose_port(), Port("confidence"), Port("seen")]
        super().__init__(name, (), outputs, period=period)
        chosen = tuple(rig[one] for one in cameras or rig.cameras)

        @contextmanager
        def opening() -> Iterator[Iterator[tuple[float, Observation]]]:
            with open_moments(rig, chosen, rate) as coming:
                looks = track_device(coming, device, chosen, limits)
                yield ((number / rate, look) for number, look in enumerate(looks))

        sources = (rig.sources.get(camera.name, "") for camera in chosen)
        self._arriving = value_source(opening, *sources)
        self._pose = np.full(POSE_SIZE, np.nan)

    def begin(self) -> None:
        self._pose = np.full(POSE_SIZE, np.nan)
        self._arriving.begin()

    def end(self) -> None:
        self._arriving.end()

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Raises Refused for cameras that are lost, or that tell no place."""
        del given
        look = self._arriving.at(now)
        seen = None if look is None else look.seen
        if not isinstance(seen, Sighting):
            return [self._pose, [0.0], [0.0]]
        self._pose = pose_signal(seen.pose.position, seen.pose.quaternion)
        return [self._pose, [seen.confidence], [1.0]]

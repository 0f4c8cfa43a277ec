"""Blocks of sensors: pixels of a marker, a pointing device, and the least distance in a cell.

A marker is projected or seen in pictures. Values of devices and streams are gathered in a thread,
so no step waits for one; those of files have their times in the model.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from pathlib import Path as FilePath
from typing import ClassVar, Final, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.blocks.diagrams import Block, Port
from assistant.blocks.library.ports import (
    POSE_SIZE,
    joints_port,
    pose_parts,
    pose_port,
    pose_signal,
)
from assistant.blocks.rules import NO_ROBOT_IN_CELL
from assistant.cell.cell_file import read_scene
from assistant.cell.collision.model import Model
from assistant.cell.scene import Scene
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import WORLD, Camera
from assistant.vision.cameras.camera_file import Rig
from assistant.vision.cameras.capture import STREAM_ADDRESS, open_frames
from assistant.vision.pointing.device_tracking import (
    FILE_RATE,
    USUAL_LIMITS,
    Limits,
    Observation,
    Sighting,
    open_moments,
    track_device,
)
from assistant.vision.pointing.devices import Device
from assistant.vision.servoing.visual_targets import VisualTarget

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)
ValueOpening = Callable[[], AbstractContextManager[Iterator[tuple[float, T]]]]
"""Opens what gives seconds and values, one after the other."""


class _ValueSource(Protocol[T_co]):
    """Opened by `begin`, closed by `end`."""

    def begin(self) -> None: ...

    def at(self, now: float) -> T_co | None:
        """The newest value at a moment of the model, None before there is one; raises Refused."""

    def end(self) -> None: ...


class _RecordedValues(Generic[T]):
    """Values that have their times, counted from the beginning of the model; the last one stays."""

    def __init__(self, opening: ValueOpening[T]) -> None:
        self._opening, self._open = opening, ExitStack()

    def begin(self) -> None:
        self._coming = self._open.enter_context(self._opening())
        self._newest: T | None = None
        self._next = next(self._coming, None)

    def at(self, now: float) -> T | None:
        while self._next is not None and self._next[0] <= now + 1e-9:
            self._newest = self._next[1]
            self._next = next(self._coming, None)
        return self._newest

    def end(self) -> None:
        self._open.close()


class LiveValues(Generic[T]):
    """Live values, collected in a separate thread, so that no step waits for one."""

    def __init__(self, opening: ValueOpening[T]) -> None:
        self._opening, self._open = opening, ExitStack()

    def begin(self) -> None:
        self._newest: T | None = None
        self._failure: Refused | None = None
        self._over = threading.Event()
        coming = self._open.enter_context(self._opening())
        thread = threading.Thread(target=self._gather, args=(coming,), daemon=True)
        self._open.callback(thread.join)
        self._open.callback(self._over.set)
        thread.start()

    def at(self, now: float) -> T | None:
        del now
        if self._failure is not None:
            raise self._failure
        return self._newest

    def end(self) -> None:
        self._open.close()

    def _gather(self, coming: Iterator[tuple[float, T]]) -> None:
        try:
            for _, value in coming:
                self._newest = value
                if self._over.is_set():
                    return
        except Refused as refused:
            self._failure = refused


def _value_source(opening: ValueOpening[T], *sources: str) -> _ValueSource[T]:
    """Live if any source is a device or a stream; else by the times of its pictures."""
    live = any(one.isdigit() or STREAM_ADDRESS.match(one) for one in sources)
    return LiveValues(opening) if live else _RecordedValues(opening)


_NOISE_SEED: Final = 0


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
        seed: int = _NOISE_SEED,
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
    """Pictures of a camera → pixels of the points of an object, seen, number of the picture.

    source: source of the pictures, see `capture.open_frames`; `folder` holds relative files. A
    separate thread evaluates pictures of devices and streams as they arrive; films, folders of
    pictures and drawn cells have `rate` pictures per second, in the time of the model. pixels: as
    of `ProjectedMarker`, NaN where the object is not seen. number: -1 before the first picture.
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

        self._arriving = _value_source(opening, source)
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
        self._arriving = _value_source(opening, *sources)
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


class CollisionDistance(Block):
    """joints of robots → the least distance in mm of any two bodies that could touch.

    Below 0 by how deep they are in each other as far as that is known, inf where nothing could
    touch. `nearest` names both bodies of the step before. cell: a scene, or its file. robots: names
    of those that have an input, `joints` of one and `NAME` of several; the only one, or the one
    that runs the program, if left out. The others stand at home. Raises Refused for names that the
    cell has not, for a cell that cannot be read, and without coal.
    """

    def __init__(
        self, name: str, cell: Scene | str | FilePath, robots: Sequence[str] | None = None
    ) -> None:
        scene = cell if isinstance(cell, Scene) else read_scene(cell)[0]
        names = [one.name for one in scene.robots]
        chosen = [scene.runs] if robots is None and scene.runs else robots or names
        known = ", ".join(f"`{one}`" for one in names) or "none, as the cell has no robot"
        if robots is None and len(chosen) != 1:
            raise Refused(NO_ROBOT_IN_CELL(name="", block=name, known=known))
        for one in chosen:
            if chosen.count(one) != 1 or one not in names:
                raise Refused(NO_ROBOT_IN_CELL(name=one, block=name, known=known))
        self._places = [names.index(one) for one in chosen if one is not None]
        found = [scene.robots[place] for place in self._places]
        single = len(found) == 1
        ports = [joints_port(one.robot, "joints" if single else one.name) for one in found]
        super().__init__(name, ports, [Port("distance", unit="mm")])
        self.scene, self._model = scene, Model(scene)
        self._joints = [one.robot.home for one in scene.robots]
        self.nearest: tuple[str, str] | None = None

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Return the least distance; raises ValueError for joints that are not finite numbers."""
        del now
        if not all(np.isfinite(one).all() for one in given):
            raise ValueError("joints are no numbers")
        joints = list(self._joints)
        for place, one in zip(self._places, given, strict=True):
            joints[place] = one
        least, which = self._model.nearest(np.concatenate(joints)[None])
        pair = int(which[0])
        self.nearest = None if pair < 0 else self._names(pair)
        return [[least[0]]]

    def _names(self, pair: int) -> tuple[str, str]:
        items = self._model.items
        one, other = (items[int(i[pair])].body.name for i in (self._model.one, self._model.other))
        return one, other

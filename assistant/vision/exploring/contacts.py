"""Sources of contacts of an arm: an input, a key, a camera."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Final, Protocol

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.cell.cell_file import read_scene
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.drawing import Picture, bodies_of_scene, draw
from assistant.vision.cameras.standing import camera_in_world
from assistant.vision.exploring import rules
from assistant.vision.servoing.live import CameraReader

NOISE_LEVELS: Final = 30
"""Grey levels by which a pixel may differ by noise."""
MOST_CHANGED: Final = 0.01
"""Largest part of the pixels of a region that differ without contact."""
PICTURE_TIMEOUT: Final = 2.0
"""Most seconds to wait for a picture."""
PictureRegion = tuple[int, int, int, int]
"""Left, top, right, bottom in pixels; right and bottom are outside."""


class Contacts(Protocol):
    """A source of contacts, or several."""

    def touching(self) -> bool:
        """True if the arm is in contact now; raises Refused if that cannot be found out."""


class InputReader(Protocol):
    """A controller whose inputs can be read."""

    def inputs(self, names: Sequence[str]) -> dict[str, float]: ...


@dataclass(frozen=True, slots=True)
class InputContacts:
    """An input of the controller that is not 0 in contact."""

    controller: InputReader
    name: str

    def touching(self) -> bool:
        return self.controller.inputs([self.name])[self.name] != 0.0


@dataclass(slots=True)
class KeyContacts:
    """A key of the operator: each press is a contact.

    pressed: returns a key that was pressed within so many seconds, b"" if none was. ends: keys that
    end the exploration. ended: one of them was pressed, or no more keys can come.
    """

    pressed: Callable[[float | None], bytes]
    ends: bytes
    ended: bool = False

    def touching(self) -> bool:
        touched = False
        while not self.ended and (key := self.pressed(0.0)):
            self.ended = key in self.ends
            touched = touched or not self.ended
        return touched


@dataclass(slots=True)
class PictureContacts:
    """A camera: in contact a region of its picture differs from the first picture.

    picture: returns the newest picture. region: of the picture.
    """

    picture: Callable[[], Picture]
    region: PictureRegion
    first: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.first = self._grey()

    def touching(self) -> bool:
        return self.difference() > MOST_CHANGED

    def difference(self) -> float:
        """Part of the pixels of the region that differ from the first picture."""
        return float((np.abs(self._grey() - self.first) > NOISE_LEVELS).mean())

    def _grey(self) -> Floats:
        left, top, right, bottom = self.region
        return np.asarray(self.picture()[top:bottom, left:right].mean(axis=2, dtype=np.float64))


@dataclass(slots=True)
class AnyContacts:
    """Several sources, of which one is enough. Each is asked: keys are gone once they are read."""

    each: Sequence[Contacts]

    def touching(self) -> bool:
        asked = [one.touching() for one in self.each]
        return any(asked)


@contextmanager
def open_contact_camera(
    camera: Camera,
    source: str,
    folder: FilePath,
    region: PictureRegion | None,
    joints: Callable[[], Mapping[str, Floats]],
) -> Iterator[PictureContacts]:
    """Open a camera as a source of contacts.

    region: None for the complete picture. joints: returns the joints of robots by name, at which a
    cell is drawn where the source is a cell file. Raises Refused for a region outside of the
    picture, and for a camera that gives no picture.
    """
    width, height = camera.lens.size
    wanted = (0, 0, width, height) if region is None else region
    left, top, right, bottom = wanted
    if not (0 <= left < right <= width and 0 <= top < bottom <= height):
        size = f"{width} × {height}"
        finding = rules.BAD_REGION(region=wanted, camera=camera.name, size=size)
        raise Refused(finding, exit_status=2)
    if source.lower().endswith(".toml"):
        yield PictureContacts(_cell_drawer(camera, folder / source, joints), wanted)
        return
    reader = CameraReader(camera, source, folder)

    def newest() -> Picture:
        now = time.monotonic()
        frame = reader.newest(now, now + PICTURE_TIMEOUT)
        if frame is None:
            raise Refused(
                rules.NO_CONTACT_PICTURE(camera=camera.name, seconds=PICTURE_TIMEOUT), exit_status=1
            )
        return frame.picture

    with reader.running():
        yield PictureContacts(newest, wanted)


def _cell_drawer(
    camera: Camera, cell: FilePath, joints: Callable[[], Mapping[str, Floats]]
) -> Callable[[], Picture]:
    """Return a function that draws a cell with its robots at their present joints, and noise."""
    scene, _ = read_scene(cell, explored=False)
    numbers = itertools.count()

    def picture() -> Picture:
        now = joints()
        stands = camera_in_world(camera, scene, now)
        return draw(stands, bodies_of_scene(scene, now), seed=next(numbers))

    return picture

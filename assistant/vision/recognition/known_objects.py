"""Known objects: their outline or texture, and the places and lines of work on them.

The frame of an object lies in its face, the flat side that cameras see: x and y in it, z out of it
towards the viewer. Lengths are mm.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.program.geometry import Pose

TOOL_INTO_FACE: Final = (0.0, 1.0, 0.0, 0.0)
"""A tool that points into the face, its x axis along that of the object."""
USUAL_APPROACH: Final = 30.0
"""mm that a tool comes from and goes to, where an object does not say."""


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """Edges of a face as closed polygons (n, 2), material to the left of each: the first one runs
    about it against the clock as it is seen, holes run with it.
    """

    rings: tuple[Floats, ...]

    @property
    def points(self) -> Floats:
        """(n, 2) corners of all rings."""
        return np.concatenate(self.rings)

    @property
    def diameter(self) -> float:
        """The longest side of the box about it."""
        return float(np.ptp(self.points, axis=0).max())


@dataclass(frozen=True, slots=True, eq=False)
class Texture:
    """Marks of a surface by which it is known.

    points: (n, 3) where they are. descriptors: (n, 128), of SIFT. picture: (h, w) grey levels of a
    flat face whose middle is the origin, None of what is not flat; size: its width and height.
    """

    points: Floats
    descriptors: np.typing.NDArray[np.uint8]
    picture: np.typing.NDArray[np.uint8] | None = None
    size: tuple[float, float] | None = None

    @property
    def flat(self) -> bool:
        return self.picture is not None


@dataclass(frozen=True, slots=True)
class Place:
    """A location on an object. pose: of the tool in the object's frame; approach: mm before it."""

    pose: Pose
    approach: float = USUAL_APPROACH


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A way on an object, such as of glue.

    points: (n, 3), one after the other; vias: those that an arc to the next one passes through.
    quaternion: of the tool in the object's frame. speed: mm/s, None for that of the file.
    """

    points: Floats
    vias: frozenset[int] = frozenset()
    quaternion: tuple[float, float, float, float] = TOOL_INTO_FACE
    approach: float = USUAL_APPROACH
    speed: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class KnownObject:
    """An outline, a texture, or both.

    height: mm of the face above what the object lies on. symmetry: in how many ways it can be
    turned about the middle of its outline and look the same; 0 for a disc. source: as messages
    name it.
    """

    name: str
    outline: Outline | None = None
    texture: Texture | None = None
    height: float = 0.0
    symmetry: int = 1
    places: Mapping[str, Place] = field(default_factory=dict)
    lines: Mapping[str, Line] = field(default_factory=dict)
    source: str = ""

"""Scenes of known and unknown things, whose truth is known: drawn, or pasted from real pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import ezdxf
import numpy as np
import skimage
from shapely import constrained_delaunay_triangles
from shapely.geometry import Polygon

from assistant.base import rotations
from assistant.cell.scene import Mesh
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera, Lens, looking_at
from assistant.vision.cameras.synthetic_pictures import Card, Optics, VisibleBody, draw
from assistant.vision.opencv import opencv
from assistant.vision.recognition.known_objects import KnownObject
from assistant.vision.recognition.object_library import Library
from assistant.vision.recognition.objects_from_drawings import read_part
from assistant.vision.recognition.objects_from_pictures import ObjectView, learn_face
from assistant.vision.recognition.recogniser import face_centre

REAL = Path(skimage.__file__).parent / "data"
LENS = Lens((800, 600), (760.0, 762.0), (401.0, 297.0), (-0.1, 0.05, 0.0005, -0.0004, 0.0))
ABOVE = Camera("above", LENS, looking_at((40.0, -230.0, 640.0), (0.0, 0.0, 0.0)))
LEFT = Camera("left", LENS, looking_at((-230.0, -180.0, 600.0), (0.0, 0.0, 0.0)))
RIGHT = Camera("right", LENS, looking_at((250.0, -160.0, 610.0), (0.0, 0.0, 0.0)))
OPTICS = Optics(light=(0.1, -0.2, 1.0), background=(70, 66, 62))

Ring = list[tuple[float, float]]
Holes = list[tuple[float, float, float]]


@dataclass(frozen=True)
class Flat:
    """A flat part: corners, and round holes (x, y, radius)."""

    name: str
    corners: Ring
    holes: Holes


def gear(teeth: int, low: float, high: float) -> Ring:
    """Teeth of different widths, so that it looks the same in one way only."""
    ring: Ring = []
    for i in range(teeth):
        wide = 0.55 if i == 0 else 0.3
        for part, radius in ((0.0, low), (0.15, high), (0.15 + wide, high), (0.3 + wide, low)):
            turn = 2.0 * np.pi * (i + part) / teeth
            ring.append((radius * float(np.cos(turn)), radius * float(np.sin(turn))))
    return ring


PARTS = (
    Flat("bracket", [(0, 0), (80, 0), (80, 25), (25, 25), (25, 60), (0, 60)], [(12, 48, 6)]),
    Flat("plate", [(0, 0), (90, 0), (90, 50), (0, 50)], [(12, 12, 5), (78, 12, 5), (45, 32, 9)]),
    Flat(
        "tee",
        [(-40, 0), (40, 0), (40, 18), (9, 18), (9, 60), (-9, 60), (-9, 18), (-40, 18)],
        [(28, 9, 4)],
    ),
    Flat("gear", gear(8, 28, 37), [(0, 0, 8)]),
    Flat("wedge", [(0, 0), (70, 0), (50, 45), (10, 45)], [(22, 14, 6)]),
    Flat("hook", [(0, 0), (60, 0), (60, 55), (35, 55), (35, 38), (44, 38), (44, 17), (0, 17)], []),
)
STRANGE = (
    Flat("triangle", [(0, 0), (70, 0), (0, 50)], []),
    Flat("other_plate", [(0, 0), (90, 0), (90, 50), (0, 50)], [(20, 30, 9)]),
    Flat(
        "disc", [(22 * float(np.cos(a)), 22 * float(np.sin(a))) for a in np.arange(48) / 7.64], []
    ),
    Flat("other_bracket", [(0, 0), (60, 0), (60, 30), (25, 30), (25, 55), (0, 55)], []),
    Flat("house", [(-35, 0), (35, 0), (45, 25), (0, 55), (-45, 25)], []),
)
FACES = {
    "coffee": "coffee.png",
    "motorcycle": "motorcycle_left.png",
    "astronaut": "astronaut.png",
    "cat": "chelsea.png",
}
STRANGE_FACES = ("page.png", "camera.png", "coins.png", "ihc.png", "hubble_deep_field.jpg")
WIDE = 100.0
"""mm of a face."""


def drawing(part: Flat, folder: Path, glue: Ring | None = None, grasp: bool = False) -> Path:
    """The DXF of a part: outline and holes, perhaps a line of glue and a place to grasp."""
    document = ezdxf.new(units=4)
    space = document.modelspace()
    space.add_lwpolyline(part.corners, close=True, dxfattribs={"layer": "PART"})
    for x, y, radius in part.holes:
        space.add_circle((x, y), radius, dxfattribs={"layer": "PART"})
    if glue:
        space.add_lwpolyline(glue, dxfattribs={"layer": "GLUE"})
    if grasp:
        space.add_point(part.corners[0], dxfattribs={"layer": "GRASP"})
    path = folder / f"{part.name}.dxf"
    document.saveas(path)
    return path


def real(name: str) -> np.ndarray:
    picture = opencv().imread(str(REAL / name))
    assert picture is not None
    return picture


@cache
def face_picture(name: str, longest: int = 320) -> np.ndarray:
    """A real picture, as it is printed on a card."""
    cv = opencv()
    picture = real(name)
    part = longest / max(picture.shape[:2])
    return cv.resize(picture, None, fx=part, fy=part, interpolation=cv.INTER_AREA)


def library(folder: Path) -> Library:
    """Six parts by their drawings, four cards by a view of each."""
    objects = [read_part(drawing(part, folder), part.name).object for part in PARTS]
    for name, file in FACES.items():
        view = ObjectView(file, face_picture(file))
        objects.append(learn_face(opencv(), name, [view], WIDE).object)
    return Library({one.name: one for one in objects})


def surface(part: Flat, pose: Pose, colour: tuple[int, int, int]) -> VisibleBody:
    """What is drawn of a part: its face, by a triangulation that shares nothing with what is
    tested."""
    angles = np.arange(64) * 2.0 * np.pi / 64
    holes = [
        np.column_stack([x + r * np.cos(angles), y + r * np.sin(angles)]) for x, y, r in part.holes
    ]
    pieces = constrained_delaunay_triangles(Polygon(part.corners, holes)).geoms
    corners = np.concatenate([np.array(one.exterior.coords)[:3] for one in pieces])
    points = np.column_stack([corners, np.zeros(len(corners))])
    triangles = np.arange(len(points)).reshape(-1, 3)
    a, b = corners[1::3] - corners[::3], corners[2::3] - corners[::3]
    area = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    triangles[area < 0] = triangles[area < 0][:, ::-1]
    return VisibleBody(Mesh(points, triangles), pose, colour)


@dataclass(frozen=True)
class Truth:
    """A known object that is there, and the part of it that is hidden."""

    known: KnownObject
    pose: Pose
    hidden: float


@dataclass(frozen=True)
class Drawn:
    things: list[VisibleBody]
    truth: list[Truth]


def laid(middle: np.ndarray, at: np.ndarray, turn: float) -> Pose:
    """Turned about z, so that a point of the object comes to a place of the plane."""
    quaternion = rotations.canonical(rotations.about((0.0, 0.0, 1.0), turn))
    moved = rotations.rotate(quaternion, middle)
    return Pose.of(np.array([*at, 0.0]) - [moved[0], moved[1], 0.0], quaternion)


def colour(rng: np.random.Generator) -> tuple[int, int, int]:
    r, g, b = rng.integers(120, 245, 3)
    return int(r), int(g), int(b)


def scene(seed: int, lib: Library, known: int = 6, strange: int = 3) -> Drawn:
    """Random objects at random places, about half of them partly hidden, and unknown things."""
    rng = np.random.default_rng(seed)
    cells = [(x, y) for x in (-210, -70, 70, 210) for y in (-130, 0, 130)]
    rng.shuffle(cells)
    things: list[VisibleBody] = []
    truth: list[Truth] = []
    covers: list[VisibleBody] = []
    names = rng.permutation(list(lib.objects))[:known]
    flats = {part.name: part for part in PARTS}
    for name, cell in zip(names, cells, strict=False):
        one = lib.objects[name]
        pose = laid(face_centre(one), np.array(cell) + rng.uniform(-10, 10, 2), rng.uniform(0, 360))
        if one.texture is not None:
            things.append(VisibleBody(Card(one.texture.size, face_picture(FACES[name])), pose))
        else:
            things.append(surface(flats[name], pose, colour(rng)))
        hidden = 0.0
        if rng.random() < 0.5:
            hidden = rng.uniform(0.1, 0.3)
            covers.append(cover(one, pose, hidden, rng))
        truth.append(Truth(one, pose, hidden))
    rest = cells[known:]
    for number in range(strange):
        at, turn = np.array(rest[number]) + rng.uniform(-10, 10, 2), rng.uniform(0, 360)
        if rng.random() < 0.5:
            part = STRANGE[rng.integers(len(STRANGE))]
            middle = np.array([*np.mean(part.corners, axis=0), 0.0])
            things.append(surface(part, laid(middle, at, turn), colour(rng)))
        else:
            picture = face_picture(STRANGE_FACES[rng.integers(len(STRANGE_FACES))])
            size = (WIDE, WIDE * picture.shape[0] / picture.shape[1])
            things.append(VisibleBody(Card(size, picture), laid(np.zeros(3), at, turn)))
    return Drawn([*things, *covers], truth)


def cover(one: KnownObject, pose: Pose, hidden: float, rng: np.random.Generator) -> VisibleBody:
    """A strip over an object, a tenth of a mm above it, that hides that part of its area."""
    if one.outline is not None:
        shape = Polygon(one.outline.rings[0], one.outline.rings[1:])
    else:
        x, y = np.array(one.texture.size) / 2.0
        shape = Polygon([(-x, -y), (x, -y), (x, y), (-x, y)])
    turn = rng.uniform(0, 360)
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    across = np.array([c, s])
    reach = np.array(shape.exterior.coords) @ across
    low, high = reach.min(), reach.max()
    first, last = low, high
    for _ in range(30):
        middle = (first + last) / 2.0
        strip = _strip(across, middle, high + 5.0)
        if shape.intersection(Polygon(strip)).area > hidden * shape.area:
            first = middle
        else:
            last = middle
    strip = _strip(across, first, high + 5.0)
    middle, side = np.array(shape.centroid.coords[0]), np.array([-s, c])
    beside = (strip - middle) @ side
    near = strip + (np.clip(beside, -55.0, 55.0) - beside)[:, None] * side
    top = Flat("cover", [tuple(p) for p in near], [])
    dark = rng.random() < 0.5
    shade = tuple(int(v) for v in (rng.integers(5, 30, 3) if dark else rng.integers(90, 250, 3)))
    return surface(top, pose @ Pose((0.0, 0.0, 0.1)), shade)


def _strip(across: np.ndarray, low: float, high: float) -> np.ndarray:
    side = np.array([-across[1], across[0]]) * 200.0
    ring = [across * low - side, across * high - side, across * high + side, across * low + side]
    return np.array(ring)


def taken(
    camera: Camera, drawn: Drawn | Sequence[VisibleBody], seed: int, **optics: float
) -> np.ndarray:
    things = drawn.things if isinstance(drawn, Drawn) else list(drawn)
    return draw(camera, things, replace(OPTICS, **optics), seed=seed)

"""Synthetic pictures: what a camera would take of bodies in the world, by ray casting.

Every pixel is a ray through the lens, so distortion and outlines are exact. A pixel in which two
bodies meet is drawn with several rays, so the centroid of an outline is exact to hundredths of a
pixel. Functions that meet a ray with a shape take the eye (3,) and directions (n, 3) in the frame
of the shape, and return distances (n,) in lengths of the directions, inf where nothing is hit, and
unit normals (n, 3). `with_axes` draws the world's axes over a picture.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows
from assistant.base.data_classes import dataclass
from assistant.cell.collision.model import Carriers, carrier_of
from assistant.cell.scene import (
    Body,
    Box,
    Capsule,
    Convex,
    Cylinder,
    Mesh,
    Scene,
    Shape,
    Sphere,
    extent,
)
from assistant.program.geometry import IDENTITY, Pose, Vector
from assistant.vision.cameras.camera import Camera, Lens
from assistant.vision.opencv import opencv


def camera_in_world(
    camera: Camera, scene: Scene, joints: Mapping[str, Floats] | None = None
) -> Camera:
    """The camera in the world, of robots by name at joints (a,), the others in their home.

    Its parent is the world, a link or flange of a robot (`arm.flange`), a body or a frame. Raises
    Refused (exit status 2) for a parent that the scene has not.
    """
    carriers = Carriers(scene.robots)
    body = Body(f"camera {camera.name}", (), camera.pose, camera.parent)
    number, pose = carrier_of(scene, body, carriers)
    origins, turns = carriers.at(_scene_joints(scene, joints))
    turn = rotations.from_matrix(turns[0, number])
    parent = Pose.of(origins[0, number], np.ravel(turn))
    return Camera(camera.name, camera.lens, parent @ pose)


def _scene_joints(scene: Scene, joints: Mapping[str, Floats] | None = None) -> Floats:
    """(1, n) joints of all robots of a scene, as `Carriers` takes them."""
    given = dict(joints or {})
    rows = [np.asarray(given.get(p.name, p.robot.home), dtype=np.float64) for p in scene.robots]
    return np.concatenate([np.zeros(0), *rows])[None]


Hits = tuple[Floats, Floats]
_PAIRS_AT_ONCE: Final = 2_000_000
"""Pairs of rays and triangles that are worked out at once."""
_PARALLEL_SHARE: Final = 1e-12
"""Share of a direction along an axis or a face below which it is parallel to the face."""


def cast_rays(shape: Shape, eye: Floats, rays: Floats) -> Hits:
    """The first meeting of each ray with a shape, seen from outside."""
    match shape:
        case Sphere(radius=radius):
            return _sphere(np.zeros(3), radius, eye, rays)
        case Capsule(radius=radius, length=length):
            ends = (np.array([0.0, 0.0, end * length / 2.0]) for end in (-1.0, 1.0))
            parts = [_sphere(end, radius, eye, rays) for end in ends]
            return _nearest_hits(_tube(radius, length, eye, rays), *parts)
        case Cylinder(radius=radius, length=length):
            lids = [_lid(radius, side * length / 2.0, side, eye, rays) for side in (-1.0, 1.0)]
            return _nearest_hits(_tube(radius, length, eye, rays), *lids)
        case Box(size=size):
            normals = np.concatenate([np.eye(3), -np.eye(3)])
            return _halves(normals, np.tile(np.array(size) / 2.0, 2), eye, rays)
        case Convex():
            hull = shape.hull
            normals, corners = _faces(hull)
            offsets = (normals * corners).sum(axis=1)
            return _halves(normals, offsets, eye, rays)
    return _triangles(shape, eye, rays)


def _sphere(centre: Floats, radius: float, eye: Floats, rays: Floats) -> Hits:
    away = centre - eye
    squares = (rays**2).sum(axis=1)
    along = rays @ away / squares
    inside = along**2 - (away @ away - radius**2) / squares
    t = np.full(len(rays), np.inf)
    hit = inside >= 0.0
    t[hit] = along[hit] - np.sqrt(inside[hit])
    t[~(t > 0.0)] = np.inf
    return t, _hits_at(eye, rays, t, lambda points: (points - centre) / radius)


def _tube(radius: float, length: float, eye: Floats, rays: Floats) -> Hits:
    """The side of a cylinder about z."""
    across = (rays[:, :2] ** 2).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        along = -(rays[:, :2] @ eye[:2]) / across
        inside = along**2 - (eye[:2] @ eye[:2] - radius**2) / across
        t = along - np.sqrt(inside)
        good = (across > _PARALLEL_SHARE) & (inside >= 0.0) & (t > 0.0)
        good &= np.abs(eye[2] + t * rays[:, 2]) <= length / 2.0
    t[~good] = np.inf

    def normal(points: Floats) -> Floats:
        return np.column_stack([points[:, :2] / radius, np.zeros(len(points))])

    return t, _hits_at(eye, rays, t, normal)


def _lid(radius: float, z: float, side: float, eye: Floats, rays: Floats) -> Hits:
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (z - eye[2]) / rays[:, 2]
        at = eye[:2] + t[:, None] * rays[:, :2]
        good = (side * rays[:, 2] < 0.0) & (t > 0.0) & ((at**2).sum(axis=1) <= radius**2)
    t[~good] = np.inf
    return t, np.tile([0.0, 0.0, side], (len(rays), 1))


def _halves(normals: Floats, offsets: Floats, eye: Floats, rays: Floats) -> Hits:
    """A convex body as half spaces normal · x ≤ offset."""
    enter, leave = np.full(len(rays), -np.inf), np.full(len(rays), np.inf)
    face = np.zeros(len(rays), dtype=np.intp)
    for number, (normal, offset) in enumerate(zip(normals, offsets, strict=True)):
        toward, rest = rays @ normal, offset - eye @ normal
        with np.errstate(divide="ignore", invalid="ignore"):
            t = rest / toward
        front = toward < -_PARALLEL_SHARE
        later = front & (t > enter)
        enter[later], face[later] = t[later], number
        back = toward > _PARALLEL_SHARE
        leave[back] = np.minimum(leave[back], t[back])
        if rest < 0.0:
            leave[~front & ~back] = -np.inf
    enter[~((enter <= leave) & (enter > 0.0))] = np.inf
    return enter, normals[face]


def _faces(mesh: Mesh) -> Hits:
    """Unit normals of its triangles, and a corner of each."""
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    across = np.cross(b - a, c - a)
    sizes = np.linalg.norm(across, axis=1, keepdims=True)
    return across / np.where(sizes > 0.0, sizes, 1.0), a


def _triangles(mesh: Mesh, eye: Floats, rays: Floats) -> Hits:
    """By Möller and Trumbore, Fast, minimum storage ray-triangle intersection, 1997."""
    best, face = np.full(len(rays), np.inf), np.zeros(len(rays), dtype=np.intp)
    for rows in _chunks(len(rays), len(mesh.triangles)):
        some = rays[rows]
        for number, (i, j, k) in enumerate(mesh.triangles):
            a = mesh.points[i]
            one, two = mesh.points[j] - a, mesh.points[k] - a
            p = np.cross(some, two)
            size = p @ one
            with np.errstate(divide="ignore", invalid="ignore"):
                u = p @ (eye - a) / size
                q = np.cross(eye - a, one)
                v = some @ q / size
                t = two @ q / size
                good = (np.abs(size) > _PARALLEL_SHARE) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
                good &= (t > 0.0) & (t < best[rows])
            best[rows] = np.where(good, t, best[rows])
            face[rows] = np.where(good, number, face[rows])
    normals = _faces(mesh)[0][face]
    normals[(normals * rays).sum(axis=1) > 0.0] *= -1.0
    return best, normals


def _chunks(count: int, across: int) -> Iterator[slice]:
    step = max(_PAIRS_AT_ONCE // max(across, 1), 1024)
    return (slice(start, start + step) for start in range(0, count, step))


def _nearest_hits(*found: Hits) -> Hits:
    """The nearest of several meetings."""
    distances = np.stack([t for t, _ in found])
    which = distances.argmin(axis=0)
    rows = np.arange(distances.shape[1])
    return distances[which, rows], np.stack([n for _, n in found])[which, rows]


def _hits_at(eye: Floats, rays: Floats, t: Floats, normal: object) -> Floats:
    """Normals where something is met, upright elsewhere."""
    out = np.tile([0.0, 0.0, 1.0], (len(rays), 1))
    hit = np.isfinite(t)
    out[hit] = normal(eye + t[hit, None] * rays[hit])  # type: ignore[operator]
    return out


Picture = NDArray[np.uint8]
"""(h, w, 3): blue, green, red."""
_Colours = NDArray[np.float32]
"""(…, 3) grey levels: blue, green, red."""
Colour = tuple[int, int, int]
_GREY: Final[Colour] = (160, 160, 165)
_RAYS_PER_SIDE: Final = 4
"""Rays along each side of a pixel in which things meet."""
_PIXELS_AT_ONCE: Final = 2048
"""Pixels that are drawn of several rays at once: what is worked out fits into a cache."""
_SMALL_BODY: Final = 24
"""Pixels across below which all of a thing is drawn of several rays, as single ones may miss it."""
_LOOKUP_WIDTH: Final = 1024
"""Places of a picture in a row, while they are looked up."""
_EDGE_LEVELS: Final = 6.0
"""Grey levels between two pixels beside each other from which on both are drawn of several rays."""


@dataclass(frozen=True, eq=False)
class Card:
    """A rectangle with a picture on it, in the middle of the plane z = 0 of its frame.

    size: its edges along x and y in mm. The picture's right is x, its top y; it is seen from above.
    """

    size: tuple[float, float]
    picture: Picture


@dataclass(frozen=True, slots=True, eq=False)
class VisibleBody:
    """Something that is seen, at a pose in the world. colour: red, green, blue; a card has none."""

    shape: Shape | Card
    pose: Pose = IDENTITY
    colour: Colour = _GREY


@dataclass(frozen=True, slots=True)
class Optics:
    """Light and quality of a picture.

    light: direction to the light. ambient: part of it that comes from everywhere. brightness:
    factor for all light. background: red, green, blue. blur: sigma in pixels. noise: sigma in grey
    levels.
    """

    light: Vector = (0.3, -0.5, 0.81)
    ambient: float = 0.45
    brightness: float = 1.0
    background: Colour = (88, 90, 94)
    blur: float = 0.6
    noise: float = 2.0


CLEAR: Final = Optics()


def draw(
    camera: Camera, things: Sequence[VisibleBody], optics: Optics = CLEAR, *, seed: int = 0
) -> Picture:
    """Draw the picture (h, w, 3) of a camera in the world; the same seed gives the same noise."""
    width, height = camera.lens.size
    numbers = np.arange(width * height).reshape(height, width)
    regions = [_region(camera, thing) for thing in things]
    rows = [numbers[v0:v1, u0:u1].ravel() for u0, u1, v0, v1 in regions]
    flat = _cast(camera, things, _rays(camera.lens), rows, optics)
    picture = flat.reshape(height, width, 3)
    small = (
        own
        for own, (u0, u1, v0, v1) in zip(rows, regions, strict=True)
        if min(u1 - u0, v1 - v0) < _SMALL_BODY
    )
    edges = np.unique(np.concatenate([_edge_pixels(picture), *small]))
    for first in range(0, len(edges), _PIXELS_AT_ONCE):
        some = edges[first : first + _PIXELS_AT_ONCE]
        flat[some] = _mean_colours(camera, things, regions, some, optics)
    return _with_optics(picture, optics, seed)


def ball(centre: Vector, radius: float, colour: Colour) -> VisibleBody:
    """A ball in the world."""
    return VisibleBody(Sphere(radius), Pose(centre), colour)


def bodies_of_scene(scene: Scene, joints: Mapping[str, Floats] | None = None) -> list[VisibleBody]:
    """The bodies of a cell, of robots by name at joints (a,), the others in their home.

    Raises Refused for a body whose parent the scene has not.
    """
    carriers = Carriers(scene.robots)
    origins, turns = carriers.at(_scene_joints(scene, joints))
    found = []
    for body in scene.all_bodies():
        if body.shown:
            number, pose = carrier_of(scene, body, carriers)
            turn = rotations.from_matrix(turns[0, number])
            carrier = Pose.of(origins[0, number], np.ravel(turn))
            placed = carrier @ pose
            colour = body.colour or _GREY
            found += [VisibleBody(part.shape, placed @ part.pose, colour) for part in body.parts]
    return found


# ----------------------------------------------------------------------------------- rays


@lru_cache(maxsize=8)
def _rays(lens: Lens) -> Floats:
    """(w h, 3) directions of all pixels in the frame of the camera; NaN beyond the lens."""
    width, height = lens.size
    u, v = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
    return _directions(lens, np.column_stack([u.ravel(), v.ravel()]))


def _directions(lens: Lens, pixels: Floats) -> Floats:
    tangents = lens.tangents(pixels)
    rays = np.column_stack([tangents, np.ones(len(tangents))])
    return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))


@lru_cache(maxsize=8)
def _direction_slopes(lens: Lens) -> tuple[Floats, Floats]:
    """(w h, 3) change of the direction from a pixel to the next, to the right and down."""
    width, height = lens.size
    grid = _rays(lens).reshape(height, width, 3)
    right, down = (np.asarray(np.gradient(grid, axis=axis)) for axis in (1, 0))
    return right.reshape(-1, 3), down.reshape(-1, 3)


def _subpixel_directions(lens: Lens, pixels: Rows, offsets: Floats) -> Floats:
    """(n k, 3) directions at offsets (k, 2) from pixels (n,): of first order, within a pixel."""
    right, down = (one[pixels] for one in _direction_slopes(lens))
    u, v = offsets.T
    rays = _rays(lens)[pixels][:, None] + right[:, None] * u[:, None] + down[:, None] * v[:, None]
    return np.asarray(rays.reshape(-1, 3))


_Region = tuple[int, int, int, int]
"""Columns and rows of the picture, begin and end of each."""


def _region(camera: Camera, thing: VisibleBody) -> _Region:
    width, height = camera.lens.size
    low, high = _body_extent(thing.shape)
    corners = (np.indices((2, 2, 2)).reshape(3, -1).T) * (high - low) + low
    corners = thing.pose.moved(corners)
    if (camera.seen_by(corners)[:, 2] <= 0.0).all():
        return 0, 0, 0, 0
    pixels = camera.project(corners)
    if not np.isfinite(pixels).all():
        return 0, width, 0, height
    first, last = pixels.min(axis=0), pixels.max(axis=0)
    margin = 4.0 + 0.1 * (last - first)  # what is straight is bent by the lens
    (u0, v0), (u1, v1) = np.floor(first - margin), np.ceil(last + margin) + 1.0
    u0, u1 = (int(np.clip(u, 0, width)) for u in (u0, u1))
    v0, v1 = (int(np.clip(v, 0, height)) for v in (v0, v1))
    return u0, u1, v0, v1


def _body_extent(shape: Shape | Card) -> tuple[Floats, Floats]:
    if isinstance(shape, Card):
        half = np.array([*shape.size, 0.0]) / 2.0
        return -half, half
    return extent(shape)


def _cast(
    camera: Camera,
    things: Sequence[VisibleBody],
    rays: Floats,
    regions: Sequence[Rows],
    optics: Optics,
) -> _Colours:
    """Colours (n, 3), blue first, of rays (n, 3) in the frame of the camera."""
    away = np.full(len(rays), np.inf)
    colours = np.empty((len(rays), 3), dtype=np.float32)
    colours[:] = optics.background[::-1]
    light = np.array(optics.light) / np.linalg.norm(optics.light)
    for thing, rows in zip(things, regions, strict=True):
        if not len(rows):
            continue
        back = thing.pose.inverse()
        turn = rotations.to_matrix(np.array(back.quaternion))
        view = back @ camera.pose
        local = rays[rows] @ rotations.to_matrix(np.array(view.quaternion)).T
        t, normals, colour = _hits_of_body(thing, np.array(view.position), local)
        nearer = np.flatnonzero(t < away[rows])
        there = rows[nearer]
        away[there] = t[nearer]
        lit = np.clip(normals[nearer] @ (turn @ light), 0.0, 1.0)
        shade = optics.ambient + (1.0 - optics.ambient) * lit
        colours[there] = colour[nearer] * shade[:, None]
    return colours


def _hits_of_body(thing: VisibleBody, eye: Floats, rays: Floats) -> tuple[Floats, Floats, Floats]:
    shape = thing.shape
    if isinstance(shape, Card):
        return _hits_of_card(shape, eye, rays)
    t, normals = cast_rays(shape, eye, rays)
    return t, normals, np.broadcast_to(np.array(thing.colour[::-1], dtype=float), normals.shape)


def _hits_of_card(card: Card, eye: Floats, rays: Floats) -> tuple[Floats, Floats, Floats]:
    with np.errstate(divide="ignore", invalid="ignore"):
        t = -eye[2] / rays[:, 2]
        at = eye[:2] + t[:, None] * rays[:, :2]
    half = np.array(card.size) / 2.0
    good = (t > 0.0) & (eye[2] > 0.0)
    good &= (np.abs(at[:, 0]) <= half[0]) & (np.abs(at[:, 1]) <= half[1])
    t[~good] = np.inf
    colours = np.zeros((len(rays), 3))
    height, width = card.picture.shape[:2]
    places = (at[good] / half * [1.0, -1.0] + 1.0) / 2.0 * [width, height] - 0.5
    colours[good] = _interpolated_colours(card.picture, places)
    return t, np.broadcast_to([0.0, 0.0, 1.0], rays.shape), colours


def _interpolated_colours(picture: Picture, places: Floats) -> Floats:
    """Colours (n, 3) of a picture between its pixels."""
    if not len(places):
        return np.zeros((0, 3))
    cv = opencv()
    rows = -(-len(places) // _LOOKUP_WIDTH)
    maps = np.zeros((2, rows * _LOOKUP_WIDTH), dtype=np.float32)
    maps[:, : len(places)] = places.T
    u, v = maps.reshape(2, rows, _LOOKUP_WIDTH)
    found = cv.remap(picture, u, v, cv.INTER_LINEAR, borderMode=cv.BORDER_REPLICATE)
    return np.asarray(found.reshape(-1, 3)[: len(places)], dtype=np.float64)


# ---------------------------------------------------------------------------------- edges


def _edge_pixels(picture: _Colours) -> Rows:
    """Pixels that differ from one beside them, and those around these."""
    edge = np.zeros(picture.shape[:2], dtype=bool)
    for axis in (0, 1):
        steps = np.abs(np.diff(picture, axis=axis)) > _EDGE_LEVELS
        unlike = steps[..., 0] | steps[..., 1] | steps[..., 2]
        first, last = [slice(None)] * 2, [slice(None)] * 2
        first[axis], last[axis] = slice(None, -1), slice(1, None)
        edge[tuple(first)] |= unlike
        edge[tuple(last)] |= unlike
    return np.flatnonzero(edge)


def _mean_colours(
    camera: Camera,
    things: Sequence[VisibleBody],
    regions: Sequence[_Region],
    pixels: Rows,
    optics: Optics,
) -> _Colours:
    """Mean colours (n, 3) of several rays in each of some pixels."""
    width, _ = camera.lens.size
    steps = (np.arange(_RAYS_PER_SIDE) + 0.5) / _RAYS_PER_SIDE - 0.5
    offsets = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    rays = _subpixel_directions(camera.lens, pixels, offsets)
    u, v = pixels % width, pixels // width
    within = [(u >= u0) & (u < u1) & (v >= v0) & (v < v1) for u0, u1, v0, v1 in regions]
    rows = [np.flatnonzero(np.repeat(inside, _RAYS_PER_SIDE * _RAYS_PER_SIDE)) for inside in within]
    colours = _cast(camera, things, rays, rows, optics)
    return np.asarray(colours.reshape(len(pixels), _RAYS_PER_SIDE * _RAYS_PER_SIDE, 3).mean(axis=1))


def _with_optics(picture: _Colours, optics: Optics, seed: int) -> Picture:
    out = (picture * optics.brightness).astype(np.float32)
    if optics.blur > 0.0:
        out = opencv().GaussianBlur(out, (0, 0), optics.blur)
    if optics.noise > 0.0:
        noise = np.random.default_rng(seed).standard_normal(out.shape, dtype=np.float32)
        out += np.float32(optics.noise) * noise
    return np.asarray(np.clip(np.rint(out), 0, 255), dtype=np.uint8)


_AXIS_LENGTH: Final = 100.0
"""mm of an axis."""
_AXIS_COLOURS: Final = ((40, 40, 220), (40, 180, 40), (220, 90, 40))
"""Blue, green, red; of x, y, z."""
_AXIS_CHORDS: Final = 16
"""Chords of an axis, which the lens bends."""


def with_axes(camera: Camera, picture: Picture) -> Picture:
    """Draw the axes of the camera's parent frame, 100 mm each, and the centre of the camera's
    picture.
    """
    cv = opencv()
    out = picture.copy()
    u, v = (round(value) for value in camera.lens.centre)
    cv.drawMarker(out, (u, v), (255, 255, 255), cv.MARKER_CROSS, 14, 1)
    for axis, colour in enumerate(_AXIS_COLOURS):
        points = np.outer(np.linspace(0.0, _AXIS_LENGTH, _AXIS_CHORDS + 1), np.eye(3)[axis])
        _draw_axis(cv, out, camera.project(points), colour, "xyz"[axis])
    return out


def _draw_axis(
    cv: Any, picture: Picture, pixels: Floats, colour: tuple[int, int, int], name: str
) -> None:
    seen = pixels[np.isfinite(pixels).all(axis=1)]
    if len(seen) < 2 or np.abs(seen).max() > 1e5:
        return
    places = np.round(seen).astype(np.int32)
    cv.polylines(picture, [places[:, None]], False, colour, 2, cv.LINE_AA)
    end = (int(places[-1, 0]) + 4, int(places[-1, 1]) + 4)
    cv.putText(picture, name, end, cv.FONT_HERSHEY_SIMPLEX, 0.6, colour, 2, cv.LINE_AA)

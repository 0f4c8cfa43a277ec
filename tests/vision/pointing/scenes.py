"""Pictures of balls and spots, worked out ray by ray; nothing of the package draws them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera, Lens, looking_at
from assistant.vision.pointing.devices import Device, wand

MIDDLE = (0.0, 0.0, 300.0)
LENS = Lens((640, 480), (800.0, 800.0), (319.5, 239.5))
BENT = Lens((640, 480), (800.0, 795.0), (316.0, 243.0), (-0.2, 0.05, 0.001, -0.002, 0.01))
SMALL = Lens((320, 240), (400.0, 398.0), (158.0, 121.0), (-0.2, 0.05, 0.001, -0.002, 0.01))
"""Half as fine, for tests of what is done with places and not of how exact they are."""
BGR = {"red": (30.0, 30.0, 210.0), "green": (40.0, 180.0, 40.0), "blue": (210.0, 70.0, 30.0)}
FINE = 6
"""Rays along each side of a pixel."""


def pair(lens: Lens = LENS) -> tuple[Camera, Camera]:
    """600 mm apart, 1 m from the middle."""
    away = -float(np.sqrt(1000.0**2 - 300.0**2))
    return (
        Camera("left", lens, looking_at((-300.0, away, 300.0), MIDDLE)),
        Camera("right", lens, looking_at((300.0, away, 300.0), MIDDLE)),
    )


def grey(camera: Camera, level: float = 90.0) -> Floats:
    width, height = camera.lens.size
    shade = np.linspace(-15.0, 15.0, width)[None, :, None]
    return np.tile(np.full((height, 1, 3), level) + shade, (1, 1, 1))


def with_sphere(
    picture: Floats, camera: Camera, centre: Floats, radius: float, bgr: tuple[float, ...]
) -> None:
    """Draws a sphere, lit from above, over what is there."""
    toward = rotations.conjugate(np.array(camera.pose.quaternion))
    c = rotations.rotate(toward, np.asarray(centre) - np.array(camera.pose.position))
    middle = camera.project(np.asarray(centre)[None])[0]
    half = 1.4 * radius / c[2] * max(camera.lens.focal) + 4.0
    (u0, v0), (u1, v1) = (np.floor(middle - half).astype(int), np.ceil(middle + half).astype(int))
    width, height = camera.lens.size
    u0, v0, u1, v1 = max(u0, 0), max(v0, 0), min(u1, width - 1), min(v1, height - 1)
    if u1 < u0 or v1 < v0:
        return
    steps = (np.arange(FINE) + 0.5) / FINE - 0.5
    us = (np.arange(u0, u1 + 1)[:, None] + steps).ravel()
    vs = (np.arange(v0, v1 + 1)[:, None] + steps).ravel()
    grid = np.stack(np.meshgrid(us, vs), axis=-1)
    rays = rotations.rotate(toward, camera.directions(grid.reshape(-1, 2)))
    along = rays @ c
    inside = along**2 - (c @ c - radius**2)
    hit = inside > 0.0
    at = rays * (along - np.sqrt(np.maximum(inside, 0.0)))[:, None]
    normals = (at - c) / radius
    light = rotations.rotate(toward, np.array([0.3, -0.5, 0.81]))
    shade = 0.45 + 0.55 * np.clip(normals @ light, 0.0, 1.0)
    colour = np.where(hit[:, None], shade[:, None] * np.array(bgr), 0.0)
    size = (len(vs) // FINE, FINE, len(us) // FINE, FINE)
    cover = hit.reshape(size).mean(axis=(1, 3))[..., None]
    drawn = colour.reshape(*size, 3).mean(axis=(1, 3))
    part = picture[v0 : v1 + 1, u0 : u1 + 1]
    picture[v0 : v1 + 1, u0 : u1 + 1] = part * (1.0 - cover) + drawn


def with_glow(picture: Floats, place: Floats, sigma: float = 2.0, level: float = 400.0) -> None:
    """Draws the spot of a light, brighter than the picture can tell."""
    height, width = picture.shape[:2]
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    away = (u - place[0]) ** 2 + (v - place[1]) ** 2
    picture += level * np.exp(-away / (2.0 * sigma**2))[..., None]


def taken(picture: Floats, rng: np.random.Generator, noise: float = 2.0) -> np.ndarray:
    """As a camera gives it: a little blurred, with noise in grey levels, 8 bits."""
    import cv2

    soft = cv2.GaussianBlur(picture.astype(np.float32), (0, 0), 0.7)
    # Other noise at each place each time; drawing a million numbers takes longer than all else.
    rows = rng.integers(0, len(GRAINS) - len(soft))
    grains = np.roll(GRAINS[rows : rows + len(soft)], int(rng.integers(0, 640)), axis=1)
    soft += grains[:, : soft.shape[1]] * np.float32(noise)
    return np.asarray(cv2.convertScaleAbs(np.maximum(soft, 0.0)))


GRAINS = np.random.default_rng(0).standard_normal((3000, 640, 3), dtype=np.float32)


def shown(
    camera: Camera, pose: Pose, rng: np.random.Generator, device: Device | None = None
) -> np.ndarray:
    """A picture of a device that stands somewhere."""
    return taken(drawn(camera, pose, device or wand()), rng)


@lru_cache(maxsize=8)
def drawn(camera: Camera, pose: Pose, device: Device) -> Floats:
    """The picture before it is taken."""
    picture = grey(camera)
    eye = np.array(camera.pose.position)
    centres = pose.moved(device.positions)
    for i in np.argsort(-np.linalg.norm(centres - eye, axis=1)):
        mark = device.marks[i]
        with_sphere(picture, camera, centres[i], mark.radius, BGR[mark.colour_name])
    return picture


def some_pose(rng: np.random.Generator, tilt: float = 40.0, room: float = 100.0) -> Pose:
    """A wand that points down, tilted by up to so many degrees, turned by up to 60."""
    place = rng.uniform(-room, room, 3) + MIDDLE - (0.0, 0.0, 100.0)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    down = rotations.multiply(
        rotations.about(np.array([0.0, 0.0, 1.0]), rng.uniform(-60.0, 60.0)), (0.0, 1.0, 0.0, 0.0)
    )
    turn = rotations.multiply(rotations.about(axis, rng.uniform(0.0, tilt)), down)
    return Pose.of(place, rotations.canonical(turn))

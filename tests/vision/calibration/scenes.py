"""Boards that are shown to cameras whose lenses and places are known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from assistant.base import rotations
from assistant.program.geometry import Pose
from assistant.vision.cameras.calibration import Board, BoardView
from assistant.vision.cameras.camera import Camera, Lens, looking_at
from assistant.vision.cameras.synthetic_pictures import Card, Optics, Picture, VisibleBody, draw

BOARD = Board.parse("charuco 7x5 40 30")
LENS = Lens((640, 480), (800.0, 795.0), (316.0, 243.0), (-0.18, 0.06, 0.001, -0.002, 0.0))
NOISE = Optics(noise=4.0, blur=0.7)


def shown(board: Board, distance: float, rng: np.random.Generator, tilt: float = 35.0) -> Pose:
    """A board before a camera, tilted to some side; its frame in that of the camera."""
    axis = rng.normal(size=3) * [1.0, 1.0, 0.3]
    turn = rotations.about(axis / np.linalg.norm(axis), rng.uniform(0.4, 1.0) * tilt)
    middle = board.corners.mean(axis=0)
    away = np.array([*(rng.uniform(-0.12, 0.12, 2) * distance), distance])
    return Pose.of(away - rotations.rotate(turn, middle), np.ravel(turn))


def pictures(
    cameras: Sequence[Camera], board: Board, poses: Sequence[Pose], optics: Optics = NOISE
) -> list[list[Picture]]:
    """Of each camera a picture of the board at each of its poses in the world."""
    card = Card(board.size, board.picture(40))
    things = [VisibleBody(card, pose @ board.on_card.inverse()) for pose in poses]
    return [
        [draw(camera, [thing], optics, seed=i) for i, thing in enumerate(things)]
        for camera in cameras
    ]


def stand(name: str, x: float) -> Camera:
    """One of a pair that looks at the same place from 1 m."""
    return Camera(name, LENS, looking_at((x, -950.0, 300.0), (0.0, 0.0, 300.0)))


def exact(
    camera: Camera, board: Board, poses: list[Pose], noise: float, seed: int = 1
) -> list[BoardView]:
    """Views without pictures: projected corners with noise."""
    rng = np.random.default_rng(seed)
    found = []
    for i, pose in enumerate(poses):
        pixels = camera.project(pose.moved(board.corners))
        rows = np.flatnonzero(camera.within(pixels, 5.0))
        found.append(BoardView(str(i), rows, pixels[rows] + rng.normal(0.0, noise, (len(rows), 2))))
    return found

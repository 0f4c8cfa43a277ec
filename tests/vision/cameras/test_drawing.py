"""Pictures of synthetic cameras, held against closed forms and OpenCV."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from assistant.base import rotations
from assistant.cell.scene import Box, Capsule, Convex, Cylinder, Mesh, Sphere
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera, Lens, looking_at
from assistant.vision.cameras.synthetic_pictures import (
    Card,
    Optics,
    VisibleBody,
    ball,
    cast_rays,
    draw,
)

MIDDLE = (0.0, 0.0, 300.0)
PLAIN = Camera("one", Lens.ideal((640, 480), 800.0), looking_at((0.0, -1000.0, 300.0), MIDDLE))
BENT = Camera(
    "bent",
    Lens((640, 480), (800.0, 790.0), (315.0, 242.0), (-0.2, 0.05, 0.001, -0.002, 0.0)),
    looking_at((200.0, -1000.0, 500.0), MIDDLE),
)
WHITE = Optics(ambient=1.0, background=(0, 0, 0), noise=0.0)
CUBE = np.array(np.meshgrid(*[[-10.0, 10.0]] * 3)).reshape(3, -1).T


def test_the_centroid_of_a_ball_ahead_is_where_it_is() -> None:
    picture = draw(PLAIN, [ball(MIDDLE, 15.0, (255, 255, 255))], WHITE)[..., 0].astype(float)
    v, u = np.mgrid[:480, :640]
    seen = (u * picture).sum() / picture.sum(), (v * picture).sum() / picture.sum()
    assert seen == pytest.approx(PLAIN.project(np.array([MIDDLE]))[0], abs=0.02)
    outline = 800.0 * 15.0 / np.sqrt(1000.0**2 - 15.0**2)
    assert picture.sum() / 255.0 == pytest.approx(np.pi * outline**2, rel=2e-3)


def test_a_ball_of_less_than_a_pixel_is_not_missed() -> None:
    """Its light falls on some pixel or another, wherever it is."""
    sums = []
    for x in np.linspace(0.0, 1.2, 5):
        small = draw(PLAIN, [ball((x, 0.0, 300.3), 0.6, (255, 255, 255))], WHITE)
        sums.append(float(small[..., 0].sum()) / 255.0)
    assert sums == pytest.approx([np.pi * (0.8 * 0.6) ** 2] * 5, rel=0.35)


@pytest.mark.parametrize("camera", [PLAIN, BENT])
def test_corners_of_a_board_are_seen_where_the_lens_puts_them(camera: Camera) -> None:
    squares = np.kron(np.indices((6, 9)).sum(axis=0) % 2, np.ones((40, 40))) * 200 + 28
    board = np.repeat(squares[..., None], 3, axis=2).astype(np.uint8)
    turn = rotations.multiply(
        rotations.about(np.array([1.0, 0.0, 0.0]), 75.0),
        rotations.about(np.array([0.0, 0.0, 1.0]), 8.0),
    )
    card = VisibleBody(Card((270.0, 180.0), board), Pose.of(np.array(MIDDLE), turn))
    picture = cv2.cvtColor(draw(camera, [card], Optics(ambient=1.0, noise=1.0)), cv2.COLOR_BGR2GRAY)
    found, corners = cv2.findChessboardCornersSB(picture, (8, 5))
    assert found
    across, down = np.meshgrid((np.arange(8) - 3.5) * 30.0, (2.0 - np.arange(5)) * 30.0)
    points = np.column_stack([across.ravel(), down.ravel(), np.zeros(40)])
    wanted = camera.project(card.pose.moved(points))
    seen = corners.reshape(-1, 2)
    away = min(np.abs(seen - w).max() for w in (wanted, wanted[::-1]))
    assert away < 0.15


def test_what_is_nearer_hides_what_is_behind() -> None:
    near, far = ball((0.0, -200.0, 300.0), 20.0, (255, 0, 0)), ball(MIDDLE, 60.0, (0, 255, 0))
    for things in ([near, far], [far, near]):
        picture = draw(PLAIN, things, WHITE)
        assert picture[240, 320].tolist() == [0, 0, 255]  # blue, green, red
        assert picture[240, 350].tolist() == [0, 255, 0]


@pytest.mark.parametrize(
    "shape", [Sphere(10.0), Capsule(6.0, 20.0), Cylinder(8.0, 24.0), Box((20.0, 14.0, 10.0))]
)
def test_rays_meet_a_shape_as_they_meet_its_triangles(shape) -> None:
    from assistant.cell.scene import surface

    drawn = surface(shape)
    mesh = Mesh(drawn.points, drawn.triangles)
    rng = np.random.default_rng(1)
    eye = np.array([60.0, -35.0, 20.0])
    rays = rng.normal(size=(2000, 3)) * 8.0 - eye
    smooth, flat = cast_rays(shape, eye, rays)[0], cast_rays(mesh, eye, rays)[0]
    both = np.isfinite(smooth) & np.isfinite(flat)
    assert both.sum() > 500
    assert (np.isfinite(smooth) != np.isfinite(flat)).mean() < 0.02  # beside flat sides
    lengths = np.linalg.norm(rays, axis=1)
    assert np.median(np.abs(smooth[both] - flat[both]) * lengths[both]) < 0.15


def test_a_hull_is_met_as_the_box_that_it_is() -> None:
    rng = np.random.default_rng(2)
    eye = np.array([40.0, 30.0, 25.0])
    rays = rng.normal(size=(500, 3)) * 10.0 - eye
    hull, box = cast_rays(Convex(CUBE), eye, rays), cast_rays(Box((20.0, 20.0, 20.0)), eye, rays)
    hit = np.isfinite(box[0])
    assert (np.isfinite(hull[0]) == hit).all() and hit.any()
    assert hull[0][hit] == pytest.approx(box[0][hit])
    assert hull[1][hit] == pytest.approx(box[1][hit])


@pytest.mark.filterwarnings("error")
def test_whatever_stands_in_the_way_of_a_camera_is_drawn() -> None:
    """Things about the camera, behind it, edge on to it, smaller than a pixel, at all places."""
    rng = np.random.default_rng(3)
    card = Card((80.0, 60.0), np.full((30, 40, 3), 200, dtype=np.uint8))
    shapes = [card, Sphere(30.0), Capsule(5.0, 80.0), Cylinder(20.0, 0.5), Box((300.0, 0.1, 40.0))]
    camera = Camera("small", Lens((64, 48), (60.0, 60.0), (31.0, 22.0), BENT.lens.distortion))
    for _ in range(60):
        q = rng.normal(size=4)
        places = rng.normal(size=(5, 3)) * 10.0 ** rng.uniform(-1.0, 5.0, (5, 1))
        things = [
            VisibleBody(shape, Pose.of(place, q / np.linalg.norm(q)))
            for shape, place in zip(shapes, places, strict=True)
        ]
        assert draw(camera, things).shape == (48, 64, 3)
    for turn in (0.0, 90.0, 180.0):
        q = np.ravel(rotations.about(np.array([1.0, 0.0, 0.0]), turn))
        draw(camera, [VisibleBody(card, Pose.of(np.array([0.0, 0.0, 100.0]), q))])


def test_the_same_seed_gives_the_same_picture() -> None:
    things = [ball(MIDDLE, 15.0, (200, 30, 30))]
    assert (draw(PLAIN, things, seed=4) == draw(PLAIN, things, seed=4)).all()
    assert (draw(PLAIN, things, seed=4) != draw(PLAIN, things, seed=5)).any()

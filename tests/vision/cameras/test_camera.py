"""Cameras and triangulation, beside OpenCV's own projection."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera, Lens, looking_at, triangulate

BENT = Lens((640, 480), (800.0, 790.0), (315.0, 242.0), (-0.2, 0.05, 0.001, -0.002, 0.01))
MIDDLE = (0.0, 0.0, 300.0)


def pair() -> tuple[Camera, Camera]:
    return (
        Camera("left", BENT, looking_at((-300.0, -950.0, 300.0), MIDDLE)),
        Camera("right", BENT, looking_at((300.0, -950.0, 300.0), MIDDLE)),
    )


def cloud(count: int, seed: int = 1) -> Floats:
    return np.random.default_rng(seed).uniform(-150.0, 150.0, (count, 3)) + MIDDLE


def test_pixels_and_their_slopes_are_those_of_opencv() -> None:
    camera, points = pair()[0], cloud(300)
    back = camera.pose.inverse()
    turn = rotations.to_matrix(np.array(back.quaternion))
    pixels, slopes = cv2.projectPoints(
        points,
        cv2.Rodrigues(turn)[0],
        np.array(back.position),
        BENT.matrix,
        np.array(BENT.distortion),
    )
    assert np.abs(pixels[:, 0] - camera.project(points)).max() < 1e-9
    by_place = slopes[:, 3:6].reshape(-1, 2, 3) @ turn
    assert np.abs(by_place - camera.slopes(points)).max() < 1e-12


def test_the_ray_of_a_pixel_goes_through_its_point() -> None:
    camera, points = pair()[0], cloud(300)
    rays = camera.directions(camera.project(points))
    away = points - np.array(camera.pose.position)
    assert np.abs(np.cross(away, rays)).max() < 1e-8


def test_nothing_is_seen_behind_or_beyond_the_lens() -> None:
    folding = Lens((640, 480), (800.0, 800.0), (320.0, 240.0), (-0.5, 0.0, 0.0, 0.0, 0.0))
    camera = Camera("one", folding)
    points = np.array([[0.0, 0.0, 500.0], [0.0, 0.0, -500.0], [450.0, 0.0, 500.0]])
    assert np.isfinite(camera.project(points)).all(axis=1).tolist() == [True, False, False]


def test_a_camera_on_a_flange_sees_with_it() -> None:
    carried = Camera("wrist", BENT, Pose((0.0, 0.0, 50.0)), "arm.flange").carried(
        looking_at((0.0, -500.0, 300.0), MIDDLE)
    )
    assert carried.parent == "world"
    assert carried.project(np.array([MIDDLE])) == pytest.approx(np.array([BENT.centre]))


def test_points_are_located_where_they_are() -> None:
    points = cloud(300)
    found = triangulate(pair(), [camera.project(points) for camera in pair()])
    assert np.abs(found.points - points).max() < 1e-8
    assert found.residuals.max() < 1e-8


def test_the_covariance_is_that_of_noisy_pixels() -> None:
    points, rng = cloud(4000), np.random.default_rng(3)
    noisy = [camera.project(points) + rng.normal(0.0, 0.2, (4000, 2)) for camera in pair()]
    found = triangulate(pair(), noisy, noise=0.2)
    off = found.points - points
    squares = np.einsum("ni,nij,nj->n", off, np.linalg.inv(found.covariances), off)
    assert squares.mean() == pytest.approx(3.0, abs=0.15)  # of three degrees of freedom


def test_what_cannot_be_located_is_no_place() -> None:
    left, right = pair()
    seen = np.array([MIDDLE])
    gone = np.full((1, 2), np.nan)
    assert np.isnan(triangulate((left, right), [left.project(seen), gone]).points).all()
    twin = triangulate((left, left), [left.project(seen), left.project(seen)])
    assert np.isnan(twin.points).all()
    apart = [np.array([[20.0, 240.0]]), np.array([[620.0, 240.0]])]
    assert np.isnan(triangulate((left, right), apart).points).all()  # their rays cross behind


HUGE = Lens((640, 480), (800.0, 790.0), (315.0, 242.0), (-5.0, 40.0, 0.3, -0.2, -80.0))
WIDE = Lens((640, 480), (200.0, 200.0), (320.0, 240.0), (0.5, 0.3, 0.0, 0.0, 0.2))
RIGS = {
    "pair": pair(),
    "huge": tuple(Camera(one.name, HUGE, one.pose) for one in pair()),
    "wide": tuple(Camera(one.name, WIDE, one.pose) for one in pair()),
    "three": (*pair(), Camera("top", WIDE, looking_at((0.0, -500.0, 900.0), MIDDLE))),
    "facing": (pair()[0], Camera("back", BENT, looking_at((0.0, 950.0, 300.0), MIDDLE))),
    "behind": tuple(
        Camera("one", BENT, looking_at((0.0, y, 300.0), MIDDLE)) for y in (-950, -1950)
    ),
    "same": (pair()[0], pair()[0]),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("cameras", RIGS.values(), ids=RIGS)
def test_hostile_pixels_give_a_place_before_all_cameras_or_none(
    cameras: tuple[Camera, ...],
) -> None:
    rng = np.random.default_rng(5)
    for _ in range(6):
        pixels = [rng.uniform(-200.0, 900.0, (300, 2)) for _ in cameras]
        for one in pixels[1:]:
            for value in (np.nan, np.inf, -np.inf, 1e300, -1e18):
                one[rng.random((300, 2)) < 0.03] = value
        found = triangulate(cameras, pixels)
        good = np.isfinite(found.points).all(axis=1)
        assert (np.isfinite(found.residuals) == good).all()
        assert np.isfinite(found.covariances[good]).all()
        assert np.isnan(found.covariances[~good]).all()
        assert (np.linalg.eigvalsh(found.covariances[good]) > 0.0).all()
        for camera, seen in zip(cameras, pixels, strict=True):
            used = good & (np.abs(seen) < 1e6).all(axis=1)
            assert (camera.seen_by(found.points[used])[:, 2] > 0.0).all()
        # Rays that cross at half a degree at least: within 115 times what is between cameras.
        assert np.abs(found.points[good]).max(initial=0.0) < 3e5


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", ["pair", "wide", "three", "facing"])
def test_points_far_away_are_told_truly_or_not_at_all(name: str) -> None:
    rng = np.random.default_rng(6)
    points = rng.normal(size=(3000, 3)) * 10.0 ** rng.uniform(0.0, 12.0, (3000, 1))
    found = triangulate(RIGS[name], [camera.project(points) for camera in RIGS[name]])
    good = np.isfinite(found.points).all(axis=1)
    assert good.sum() > 50
    assert np.linalg.norm(found.points - points, axis=1)[good].max() < 1e-3


def test_a_lens_that_folds_within_its_picture_is_none() -> None:
    assert BENT.whole and WIDE.whole and Lens.ideal((640, 480), 800.0).whole
    assert not HUGE.whole
    assert not Lens((640, 480), (800.0, 800.0), (320.0, 240.0), (0.0, 0.0, 3.0, 0.0, 0.0)).whole
    assert not Lens((640, 480), (300.0, 300.0), (320.0, 240.0), (-0.5, 0.0, 0.0, 0.0, 0.0)).whole

"""Balls and lights in single pictures, and what keeps a device from being located."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera, looking_at
from assistant.vision.pointing.device_tracking import Sighting, check_cameras, locate_device
from assistant.vision.pointing.devices import Ball, Device, ball, light, wand
from assistant.vision.pointing.mark_detection import find_spots
from tests.vision.pointing.scenes import (
    BENT,
    BGR,
    LENS,
    MIDDLE,
    grey,
    pair,
    shown,
    some_pose,
    taken,
    with_glow,
    with_sphere,
)

RED = ball()
WHERE = Pose((20.0, -30.0, 310.0))


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def code_of(device: Device, pictures: list[np.ndarray], cameras: tuple[Camera, ...]) -> str:
    seen = locate_device(device, cameras, pictures)
    assert isinstance(seen, Diagnostic), seen
    return seen.code


@pytest.mark.slow
def test_the_centre_of_a_near_ball_is_not_the_middle_of_its_outline() -> None:
    """The ball is large and at the side, so that the two are 1.4 pixels apart."""
    camera = Camera("one", LENS, looking_at((0.0, -400.0, 300.0), MIDDLE))
    centre, radius = np.array([120.0, 0.0, 370.0]), 40.0
    picture = grey(camera)
    with_sphere(picture, camera, centre, radius, BGR["red"])
    picture8 = taken(picture, rng())
    mark = Ball(RED.marks[0].colour, radius)  # type: ignore[union-attr]
    ((spot,),) = find_spots(picture8, camera, [mark])
    truth = camera.project(centre[None])[0]
    mask = (picture8[..., 2] > picture8[..., 1].astype(int) + 60).astype(np.uint8)
    moments = cv2.moments(mask, binaryImage=True)
    middle = np.array([moments["m10"], moments["m01"]]) / moments["m00"]
    assert np.linalg.norm(np.array(spot.place) - truth) < 0.08
    assert np.linalg.norm(middle - truth) > 1.0


def test_half_a_ball_behind_something_is_placed_by_the_other_half() -> None:
    camera, centre = pair()[0], np.array(WHERE.position)
    picture = grey(camera)
    with_sphere(picture, camera, centre, 20.0, BGR["red"])
    truth = camera.project(centre[None])[0]
    picture[:, int(truth[0]) + 6 :] = 90.0
    ((spot,),) = find_spots(taken(picture, rng()), camera, RED.marks)
    assert np.linalg.norm(np.array(spot.place) - truth) < 0.3
    assert 0.4 < spot.confidence < 0.85


@pytest.mark.parametrize("sigma", [0.8, 1.5, 3.0])
def test_a_spot_of_light_is_placed_to_a_tenth_of_a_pixel(sigma: float) -> None:
    camera, place = pair()[0], np.array([200.3, 117.8])
    picture = grey(camera)
    with_glow(picture, place, sigma)
    ((spot,),) = find_spots(taken(picture, rng(1)), camera, light().marks)
    assert np.abs(np.array(spot.place) - place).max() < 0.1


def test_a_light_is_located_also_in_the_dark() -> None:
    cameras, point = pair(BENT), np.array([WHERE.position])
    pictures = []
    for camera in cameras:
        picture = grey(camera, level=16.0)
        with_glow(picture, camera.project(point)[0])
        pictures.append(taken(picture, rng(2)))
    seen = locate_device(light(), cameras, pictures)
    assert isinstance(seen, Sighting)
    assert np.linalg.norm(np.array(seen.pose.position) - point) < 0.3
    assert seen.pose.quaternion == light().orientation


def balls_at(places: list[tuple[float, float, float]], radius: float = 20.0) -> list[np.ndarray]:
    found = []
    for k, camera in enumerate(pair()):
        picture = grey(camera)
        for place in places:
            with_sphere(picture, camera, np.array(place), radius, BGR["red"])
        found.append(taken(picture, rng(k)))
    return found


def test_something_of_the_same_colour_and_another_size_is_not_the_device() -> None:
    pictures = balls_at([WHERE.position])
    for camera, picture in zip(pair(), pictures, strict=True):
        u, v = camera.project(np.array([(-100.0, 0.0, 250.0)]))[0].astype(int)
        picture[v : v + 40, u : u + 60] = BGR["red"]
    seen = locate_device(RED, pair(), pictures)
    assert isinstance(seen, Sighting), seen
    assert np.linalg.norm(np.subtract(seen.pose.position, WHERE.position)) < 0.3


def test_two_devices_are_none() -> None:
    assert code_of(RED, balls_at([WHERE.position, (-80.0, 0.0, 250.0)]), pair()) == "VS109"


def test_two_wands_are_none() -> None:
    pictures = []
    a, b = Pose((-90.0, 0.0, 200.0), (0.0, 1.0, 0.0, 0.0)), Pose((110.0, 0.0, 200.0), (0, 1, 0, 0))
    for k, camera in enumerate(pair()):
        picture = grey(camera)
        for pose in (a, b):
            for mark, centre in zip(wand().marks, pose.moved(wand().positions), strict=True):
                with_sphere(picture, camera, centre, 15.0, BGR[mark.colour_name])  # type: ignore[union-attr]
        pictures.append(taken(picture, rng(k)))
    assert code_of(wand(), pictures, pair()) == "VS109"


def test_a_ball_of_another_radius_is_not_the_device() -> None:
    assert code_of(RED, balls_at([WHERE.position], radius=30.0), pair()) == "VS110"


def test_a_device_that_leaves_one_picture_is_not_located() -> None:
    pictures = balls_at([WHERE.position])
    pictures[1] = taken(grey(pair()[1]), rng())
    seen = locate_device(RED, pair(), pictures)
    assert isinstance(seen, Diagnostic) and seen.code == "VS104" and "right" in seen.message


def test_a_device_at_the_edge_of_a_picture_is_not_located() -> None:
    left, _ = pair()
    corner = left.directions(np.array([[14.0, 240.0]]))[0] * 1000.0 + left.pose.position
    aside = Camera("right", LENS, looking_at((300.0, -950.0, 300.0), corner))
    pictures = []
    for camera in (left, aside):
        picture = grey(camera)
        with_sphere(picture, camera, corner, 20.0, BGR["red"])
        pictures.append(taken(picture, rng()))
    assert code_of(RED, pictures, (left, aside)) == "VS105"


def test_cameras_that_disagree_locate_nothing() -> None:
    left, right = pair()
    moved = replace(right, pose=right.pose @ Pose((0.0, 5.0, 0.0)))
    assert code_of(RED, balls_at([WHERE.position]), (left, moved)) == "VS106"


def test_a_wand_of_other_lengths_is_not_the_device() -> None:
    pose = some_pose(rng(2))
    longer = tuple(
        replace(m, position=(m.position[0], 0.0, m.position[2] * 1.2)) for m in wand().marks
    )
    other = Device("wand", longer)
    pictures = [shown(camera, pose, rng(3), other) for camera in pair()]
    assert code_of(wand(), pictures, pair()) == "VS108"


def test_rays_that_hardly_cross_tell_no_place() -> None:
    left, _ = pair()
    beside = Camera("right", LENS, left.pose @ Pose((2.0, 0.0, 0.0)))
    pictures = []
    for k, camera in enumerate((left, beside)):
        picture = grey(camera)
        with_sphere(picture, camera, np.array(WHERE.position), 20.0, BGR["red"])
        pictures.append(taken(picture, rng(k)))
    assert code_of(RED, pictures, (left, beside)) == "VS107"


def test_a_place_behind_a_camera_is_none() -> None:
    """Cameras that look away from each other see a ball each, and the rays cross behind them."""
    left = Camera("left", LENS, looking_at((-100.0, 0.0, 300.0), (-600.0, -900.0, 300.0)))
    right = Camera("right", LENS, looking_at((100.0, 0.0, 300.0), (600.0, -900.0, 300.0)))
    pictures = []
    for camera in (left, right):
        picture = grey(camera)
        ahead = camera.directions(np.array([[320.0, 240.0]]))[0] * 900.0 + camera.pose.position
        with_sphere(picture, camera, ahead, 20.0, BGR["red"])
        pictures.append(taken(picture, rng()))
    assert code_of(RED, pictures, (left, right)) == "VS107"


@pytest.mark.parametrize(("level", "code"), [(3, "VS101"), (255, "VS102"), (90, "VS104")])
def test_pictures_that_are_dark_or_dazzled_are_told_so(level: int, code: str) -> None:
    blank = np.full((480, 640, 3), level, dtype=np.uint8)
    assert code_of(RED, [blank, blank], pair()) == code


def test_pictures_of_another_size_are_refused() -> None:
    small = np.full((240, 320, 3), 90, dtype=np.uint8)
    assert code_of(RED, [small, small], pair()) == "VS103"


def test_one_camera_and_cameras_in_hand_tell_no_place() -> None:
    left, right = pair()
    for cameras, code in (
        ((left,), "VS115"),
        ((left, replace(right, parent="arm.flange")), "VS116"),
    ):
        with pytest.raises(Refused) as refused:
            check_cameras(cameras)
        assert refused.value.findings[0].code == code and refused.value.exit_status == 2

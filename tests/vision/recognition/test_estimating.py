"""The pose that fits measurements, beside closed forms, OpenCV and many draws."""

from __future__ import annotations

import numpy as np
import pytest

from assistant.base import rotations
from assistant.program.geometry import Pose
from assistant.vision.opencv import opencv
from assistant.vision.recognition.pose_estimation import (
    Plane,
    fit_pose,
    measure_points,
    moved_pose,
    pixels_and_slopes,
)
from tests.vision.recognition.scenes import ABOVE, LEFT

RNG = np.random.default_rng(5)
POSE = Pose.of(np.array([20.0, -15.0, 12.0]), rotations.from_euler((30.0, 8.0, -12.0)))
POINTS = RNG.uniform(-50, 50, (30, 3)) * [1.0, 1.0, 0.4]


def test_slopes_are_differences_of_pixels():
    at, slopes = pixels_and_slopes(ABOVE, POSE, POINTS)
    for i in range(6):
        step = np.zeros(6)
        step[i] = 1e-5
        there, _ = pixels_and_slopes(ABOVE, moved_pose(POSE, step), POINTS)
        np.testing.assert_allclose(slopes[..., i], (there - at) / 1e-5, rtol=1e-4, atol=1e-3)


def test_exact_pixels_give_the_exact_pose_and_that_of_opencv():
    cv = opencv()
    pixels = ABOVE.project(POSE.moved(POINTS))
    start = moved_pose(POSE, np.array([4.0, -3.0, 5.0, 0.05, -0.04, 0.06]))
    found = fit_pose(start, [measure_points(ABOVE, POINTS, pixels)])
    np.testing.assert_allclose(found.pose.position, POSE.position, atol=1e-3)
    done, turn, move = cv.solvePnP(
        POINTS, pixels, ABOVE.lens.matrix, np.array(ABOVE.lens.distortion), flags=cv.SOLVEPNP_SQPNP
    )
    assert done
    local = Pose.of(move.ravel(), rotations.from_matrix(cv.Rodrigues(turn)[0]))
    theirs = ABOVE.pose @ local
    np.testing.assert_allclose(found.pose.position, theirs.position, atol=0.01)
    assert rotations.angle_between(found.pose.quaternion, theirs.quaternion) < 0.01


@pytest.mark.parametrize("plane", [None, Plane(Pose((0.0, 0.0, 12.0)), 0.3, 0.2)])
def test_the_covariance_is_honest(plane, tell):
    """60 draws of the noise: the squared Mahalanobis distance of six numbers is 6 on average,
    less what is told by keypoints that overlap, which draws do not."""
    rng = np.random.default_rng(1)
    flat = POINTS * [1.0, 1.0, 0.0]
    away = []
    for _ in range(60):
        tilt = rng.normal(0.0, 0.2, 2)
        lies = Pose.of(
            np.array([20.0, -15.0, 12.0 + rng.normal(0.0, 0.3)]),
            rotations.from_euler((30.0, 0.0, 0.0)),
        )
        lies = moved_pose(
            lies, np.radians(np.array([0, 0, 0, *tilt, 0.0])) if plane else np.zeros(6)
        )
        measures = [
            measure_points(
                camera, flat, camera.project(lies.moved(flat)) + rng.normal(0, 0.4, (30, 2))
            )
            for camera in (ABOVE, LEFT)
        ]
        found = fit_pose(lies, measures, plane)
        off = np.array(found.pose.position) - lies.position
        turns = np.degrees(rotations.turns(lies.quaternion, found.pose.quaternion))
        both = np.concatenate([off, turns])
        away.append(both @ np.linalg.solve(found.covariance, both))
    kind = "anywhere" if plane is None else "on a plane"
    tell(f"squared Mahalanobis distance of 60 draws, {kind}: {np.mean(away):.2f} of 6")
    assert 3.6 < np.mean(away) < 7.0


def test_outliers_are_left_out():
    rng = np.random.default_rng(2)
    pixels = ABOVE.project(POSE.moved(POINTS)) + rng.normal(0, 0.2, (30, 2))
    pixels[:8] += rng.uniform(20, 60, (8, 2))
    found = fit_pose(POSE, [measure_points(ABOVE, POINTS, pixels)])
    assert np.linalg.norm(np.array(found.pose.position) - POSE.position) < 1.5
    assert (found.used[:16] == 0.0).all()


def test_too_few_measurements_tell_no_pose():
    pixels = ABOVE.project(POSE.moved(POINTS))
    assert fit_pose(POSE, [measure_points(ABOVE, POINTS[:2], pixels[:2])]) is None
    line = np.column_stack([np.linspace(-40, 40, 20), np.zeros(20), np.zeros(20)])
    assert fit_pose(POSE, [measure_points(ABOVE, line, ABOVE.project(POSE.moved(line)))]) is None
    assert fit_pose(POSE, [measure_points(ABOVE, POINTS, pixels * np.nan)]) is None

"""How exactly devices are located, against synthetic truth: 640 x 480, 800 px, 1 m, base 0.6 m."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.synthetic_pictures import draw
from assistant.vision.pointing.demonstrations import HeldPosition, average_hold
from assistant.vision.pointing.device_tracking import Sighting, fit_device_poses, locate_device
from assistant.vision.pointing.devices import HUES, Ball, Device, ball, bodies_of_device, wand
from tests.vision.pointing.scenes import BENT, LENS, pair, shown, some_pose

HOLD = 30


def errors(found: Floats, turns: Floats, poses: list[Pose]) -> tuple[Floats, Floats]:
    """Mm and degrees (n,) from the truth."""
    away = np.linalg.norm(found - [p.position for p in poses], axis=1)
    return away, rotations.angle_between(turns, [p.quaternion for p in poses])


def with_noise(device: Device, poses: list[Pose], frames: int, seed: int) -> Floats:
    """(c, n, b, 2) pixels that are the means of so many moments with noise of 0.2 px."""
    rng, cameras = np.random.default_rng(seed), pair(BENT)
    points = np.stack([pose.moved(device.positions) for pose in poses])
    b = points.shape[1]
    pixels = np.stack([c.project(points.reshape(-1, 3)).reshape(-1, b, 2) for c in cameras])
    noise = rng.normal(0.0, 0.2, (frames, *pixels.shape)).mean(axis=0)
    return np.asarray(pixels + noise)


@pytest.mark.parametrize(("name", "device"), [("ball", ball()), ("wand", wand())])
def test_noise_of_pixels(name: str, device: Device, tell: Callable[[str], None]) -> None:
    rng = np.random.default_rng(3)
    poses = [some_pose(rng) for _ in range(400)]
    for frames, most, most_turned in ((1, 0.8, 0.5), (HOLD, 0.3, 0.3)):
        pixels = with_noise(device, poses, frames, seed=frames)
        posed = fit_device_poses(pair(BENT), pixels, device.positions)
        away, turned = errors(posed.positions, posed.quaternions, poses)
        if name == "ball":
            turned = np.zeros(1)
        assert away.mean() < most and turned.mean() < most_turned
        if frames == HOLD:
            assert np.quantile(away, 0.99) < 0.3 and np.quantile(turned, 0.99) < 0.3
        tell(
            f"{name}, 0.2 px of noise, {frames} frames: {away.mean():.3f} mm mean, "
            f"{away.max():.3f} worst of {len(away)}; "
            f"{turned.mean():.3f} degrees mean, {turned.max():.3f} worst"
        )


def test_the_covariance_is_that_of_the_errors() -> None:
    rng = np.random.default_rng(5)
    poses = [some_pose(rng) for _ in range(1500)]
    posed = fit_device_poses(pair(BENT), with_noise(wand(), poses, 1, seed=8), wand().positions)
    off = np.array([p.position for p in poses]) - posed.positions
    turns = rotations.turns(posed.quaternions, np.array([p.quaternion for p in poses]))
    both = np.concatenate([off, turns], axis=1)
    squares = np.einsum("ni,nij,nj->n", both, np.linalg.inv(posed.covariances), both)
    assert squares.mean() == pytest.approx(6.0, rel=0.07)


def test_a_marker_of_40_mm_tells_turns_worse(tell: Callable[[str], None]) -> None:
    rng = np.random.default_rng(3)
    poses = [some_pose(rng) for _ in range(400)]
    corners = [(-20.0, -20.0, 0.0), (20.0, -20.0, 0.0), (20.0, 20.0, 0.0), (-20.0, 20.0, 0.0)]
    marker = Device("marker", tuple(Ball(HUES["red"], 5.0, place) for place in corners))
    turned = {}
    for device in (wand(), marker):
        posed = fit_device_poses(pair(BENT), with_noise(device, poses, 1, seed=1), device.positions)
        turned[device.name] = errors(posed.positions, posed.quaternions, poses)[1].mean()
    assert turned["wand"] < 0.75 * turned["marker"]
    tell(f"turn in one frame: wand {turned['wand']:.2f}, marker {turned['marker']:.2f} degrees")


def hold_of(device: Device, take: Callable[[Camera], np.ndarray], frames: int) -> HeldPosition:
    cameras = pair(BENT)
    window = []
    for k in range(frames):
        seen = locate_device(device, cameras, [take(camera) for camera in cameras])
        assert isinstance(seen, Sighting), seen
        window.append((k / 30.0, seen))
    found = average_hold(window, device, cameras)
    assert isinstance(found, HeldPosition), found
    return found


@pytest.mark.slow
@pytest.mark.parametrize(("name", "device"), [("ball", ball()), ("wand", wand())])
def test_drawn_pictures(name: str, device: Device, tell: Callable[[str], None]) -> None:
    """Drawn by the tests themselves, with a bent lens, light from one side and noise."""
    rng, cameras = np.random.default_rng(4), pair(BENT)
    poses = [some_pose(rng) for _ in range(4)]
    seen = [
        locate_device(device, cameras, [shown(c, p, rng, device) for c in cameras]) for p in poses
    ]
    good = [one for one in seen if isinstance(one, Sighting)]
    assert len(good) == len(poses)
    positions = np.array([one.pose.position for one in good])
    away, turned = errors(positions, np.array([one.pose.quaternion for one in good]), poses)
    single = f"{away.mean():.3f} mm mean, {away.max():.3f} worst of {len(away)}"
    assert away.mean() < 0.8 and (name == "ball" or turned.mean() < 0.5)
    found = hold_of(device, lambda camera: shown(camera, poses[0], rng, device), HOLD)
    off, angle = errors(
        np.array([found.pose.position]), np.array([found.pose.quaternion]), poses[:1]
    )
    assert off[0] < 0.3 and (name == "ball" or angle[0] < 0.3)
    more = f"; {turned.mean():.3f} and {angle[0]:.3f} degrees" if name == "wand" else ""
    tell(f"{name}, drawn pictures: {single}, hold of {HOLD}: {off[0]:.3f} mm{more}")


def seen_by_synthetic_cameras(count: int) -> tuple[Floats, Floats, int]:
    """Errors in mm and degrees of a wand with its sticks, and how often it was not located."""
    rng, cameras, device = np.random.default_rng(6), pair(LENS), wand()
    away, turned, lost = [], [], 0
    for k in range(count):
        pose = some_pose(rng)
        things = bodies_of_device(device, pose)
        seen = locate_device(device, cameras, [draw(c, things, seed=k) for c in cameras])
        if not isinstance(seen, Sighting):
            lost += 1
            continue
        off, angle = errors(
            np.array([seen.pose.position]), np.array([seen.pose.quaternion]), [pose]
        )
        away.append(off[0])
        turned.append(angle[0])
    return np.array(away), np.array(turned), lost


@pytest.mark.parametrize("count", [4, pytest.param(150, marks=pytest.mark.slow)])
def test_sticks_that_hide_parts_of_balls(count: int, tell: Callable[[str], None]) -> None:
    """Pictures of the synthetic camera; where too much of a ball is hidden, nothing is told."""
    away, turned, lost = seen_by_synthetic_cameras(count)
    assert away.max() < 0.5 and turned.max() < 0.5 and lost <= count / 10
    tell(
        f"wand with sticks, {count} poses, synthetic camera, one frame: {away.mean():.3f} mm "
        f"mean, {away.max():.3f} worst; {turned.mean():.3f} degrees mean, {turned.max():.3f} "
        f"worst; {lost} not located"
    )

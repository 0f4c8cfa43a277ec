"""Cameras in the hand and beside the arm: where they are, by all methods, and how well."""

from __future__ import annotations

import numpy as np
import pytest

from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.program.geometry import Pose
from assistant.vision.cameras.hand_eye import METHODS, Mounting, find_hand_eye

CAMERA = {
    "hand": Pose((30.0, -55.0, 70.0), (0.96, 0.02, -0.05, 0.274)),
    "stand": Pose((900.0, -600.0, 700.0), (0.35, -0.83, -0.39, 0.18)),
}
BOARD = {
    "hand": Pose((450.0, 80.0, 20.0), (0.1, 0.99, 0.05, 0.02)),
    "stand": Pose((10.0, 5.0, 90.0), (0.99, 0.1, 0.02, 0.01)),
}


def poses(
    mounting: Mounting, count: int, mm: float, degrees: float, seed: int = 1, turn: float = 40.0
) -> tuple[list[Pose], list[Pose]]:
    """Flanges in the base, and the board in the camera as it is seen, with noise."""
    rng = np.random.default_rng(seed)
    camera, board = (_unit(one[mounting]) for one in (CAMERA, BOARD))
    flanges, seen = [], []
    for _ in range(count):
        axis = rng.normal(size=3)
        q = rotations.about(axis / np.linalg.norm(axis), rng.uniform(10.0, turn))
        place = np.array([400.0, 0.0, 400.0]) + rng.uniform(-150, 150, 3)
        flange = Pose.of(place, np.ravel(q))
        hand = flange.inverse() if mounting == "hand" else flange
        there = camera.inverse() @ hand @ board
        axis = rng.normal(size=3)
        wobble = rotations.about(axis / np.linalg.norm(axis), rng.normal(0.0, degrees))
        seen.append(there @ Pose.of(rng.normal(0.0, mm, 3), np.ravel(wobble)))
        flanges.append(flange)
    return flanges, seen


def _unit(pose: Pose) -> Pose:
    return Pose.of(np.array(pose.position), np.ravel(rotations.canonical(pose.quaternion)))


def off(found: Pose, mounting: Mounting) -> tuple[float, float]:
    truth = _unit(CAMERA[mounting])
    mm = float(np.linalg.norm(np.subtract(found.position, truth.position)))
    return mm, float(rotations.angle_between(found.quaternion, truth.quaternion))


@pytest.mark.parametrize("mounting", ["hand", "stand"])
def test_a_camera_is_found_by_all_methods(mounting: Mounting, tell) -> None:
    found = find_hand_eye(*poses(mounting, 12, 0.3, 0.06), mounting)
    assert [one.method for one in found.solutions] == list(METHODS)
    mm, degrees = off(found.best.camera, mounting)
    tell(
        f"camera of the {mounting}, 12 poses, 0.3 mm and 0.06 degrees of noise: {mm:.2f} mm and "
        f"{degrees:.3f} degrees off by {found.best.method}; left {found.best.mm:.2f} mm, "
        f"{found.best.degrees:.3f} degrees; held out {found.held_out[0]:.2f} mm"
    )
    assert mm < 1.5
    assert degrees < 0.15
    assert found.best.mm < 3.0
    assert found.held_out[0] >= found.best.mm * 0.9


@pytest.mark.parametrize("mounting", ["hand", "stand"])
def test_without_noise_nothing_is_left(mounting: Mounting) -> None:
    found = find_hand_eye(*poses(mounting, 6, 0.0, 0.0), mounting)
    assert off(found.best.camera, mounting) == pytest.approx((0.0, 0.0), abs=1e-4)
    assert found.best.mm == pytest.approx(0.0, abs=1e-4)


def test_poses_that_do_not_tell_are_refused() -> None:
    flanges, boards = poses("hand", 8, 0.1, 0.02)
    with pytest.raises(Refused, match="VS040"):
        find_hand_eye(flanges[:3], boards[:3], "hand")
    level = [Pose(one.position, (1.0, 0.0, 0.0, 0.0)) for one in flanges]
    with pytest.raises(Refused, match="VS041"):
        find_hand_eye(level, boards, "hand")
    turns = [rotations.about(np.array([0.0, 0.0, 1.0]), 9.0 * i) for i in range(len(flanges))]
    about_z = [
        Pose.of(np.array(one.position), np.ravel(turn))
        for one, turn in zip(flanges, turns, strict=True)
    ]
    with pytest.raises(Refused, match="VS041"):
        find_hand_eye(about_z, boards, "hand")
    with pytest.raises(Refused, match="VS042"):
        find_hand_eye(flanges, boards[::-1], "hand")


def shifted(flanges: list[Pose], rows: list[int], mm: float) -> list[Pose]:
    """Poses of which some rows are wrong by so many mm, each in another direction."""
    rng = np.random.default_rng(len(rows))
    found = list(flanges)
    for row in rows:
        way = rng.normal(size=3)
        place = flanges[row].position + mm * way / np.linalg.norm(way)
        found[row] = Pose.of(place, np.array(flanges[row].quaternion))
    return found


@pytest.mark.parametrize("mounting", ["hand", "stand"])
@pytest.mark.parametrize("rows", [[5], [0, 9], [1, 4, 11]])
def test_single_wrong_poses_are_named_and_left_out(mounting: Mounting, rows: list[int]) -> None:
    for seed in range(2):
        flanges, boards = poses(mounting, 12, 0.3, 0.06, seed)
        found = find_hand_eye(shifted(flanges, rows, 25.0), boards, mounting)
        assert list(found.left_out) == rows
        told = [str(one) for one in found.findings]
        assert [f"pose {row + 1} of the arm" in text for row, text in zip(rows, told, strict=True)]
        assert all("VS047" in text for text in told)
        assert off(found.best.camera, mounting)[0] < 3.0


def test_a_turn_that_was_written_down_wrongly_is_found() -> None:
    flanges, boards = poses("hand", 10, 0.2, 0.05)
    turned = rotations.multiply(
        np.array(flanges[3].quaternion), rotations.about((0.0, 0.0, 1.0), 3.0)
    )
    flanges[3] = Pose.of(np.array(flanges[3].position), turned)
    assert find_hand_eye(flanges, boards, "hand").left_out == (3,)


@pytest.mark.slow
def test_right_poses_are_not_left_out() -> None:
    counted = 0
    for seed in range(4):
        for count in (5, 7, 12):
            counted += len(find_hand_eye(*poses("hand", count, 0.3, 0.06, seed), "hand").left_out)
    assert counted == 0


def test_many_wrong_poses_are_refused() -> None:
    flanges, boards = poses("hand", 12, 0.1, 0.02)
    with pytest.raises(Refused, match=r"VS048.*4 of 12 poses.*: 2, 3, 7, 9"):
        find_hand_eye(shifted(flanges, [1, 2, 6, 8], 40.0), boards, "hand")


def test_poses_that_leave_more_than_pictures_explain_are_reported() -> None:
    found = find_hand_eye(*poses("hand", 10, 2.0, 0.1), "hand", noise=0.2)
    assert [one.code for one in found.findings] == ["VS049"]
    assert find_hand_eye(*poses("hand", 10, 0.2, 0.05), "hand", noise=0.2).findings == ()


@pytest.mark.slow
@pytest.mark.parametrize("mounting", ["hand", "stand"])
def test_the_sigma_of_a_camera_is_honest(mounting: Mounting) -> None:
    """True errors of 20 calibrations, beside what each of them says of itself."""
    ratios = []
    for seed in range(20):
        found = find_hand_eye(*poses(mounting, 10, 0.3, 0.06, seed), mounting)
        ratios.append(np.divide(off(found.best.camera, mounting), found.sigma))
    mm, degrees = np.sqrt(np.mean(np.square(ratios), axis=0))
    assert 0.5 < mm < 1.5
    assert 0.5 < degrees < 1.5

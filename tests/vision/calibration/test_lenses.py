"""Lenses and pairs of cameras from drawn pictures of boards, beside what was drawn."""

from __future__ import annotations

import numpy as np
import pytest

from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.program.geometry import Pose
from assistant.vision.cameras.calibration import Board, BoardView, find_board, find_lens, find_pair
from assistant.vision.cameras.camera import Camera
from tests.vision.calibration.scenes import BOARD, LENS, exact, pictures, shown, stand


def views_of(camera: Camera, board: Board, count: int, seed: int = 1) -> list[BoardView]:
    rng = np.random.default_rng(seed)
    poses = [camera.pose @ shown(board, rng.uniform(430.0, 600.0), rng) for _ in range(count)]
    (taken,) = pictures([camera], board, poses)
    found = [find_board(board, picture, f"view {i}") for i, picture in enumerate(taken)]
    return [view for view in found if view is not None]


@pytest.mark.slow
def test_a_lens_is_found_from_drawn_charuco_boards(tell) -> None:
    camera = Camera("one", LENS)
    views = views_of(camera, BOARD, 8)
    assert len(views) == 8
    found = find_lens(BOARD, views, LENS.size)
    off = 100.0 * (np.array(found.lens.focal) / LENS.focal - 1.0)
    centre = np.abs(np.subtract(found.lens.centre, LENS.centre)).max()
    tell(
        f"8 drawn ChArUco views of 640 x 480: {found.residual:.3f} px left, focal length "
        f"{off[0]:+.3f} and {off[1]:+.3f} %, centre {centre:.2f} px off"
    )
    assert found.residual < 0.2
    assert np.abs(off).max() < 0.6
    assert np.abs(np.subtract(found.lens.focal, LENS.focal)).max() < 5.0 * max(found.sigma[:2])
    assert centre < 4.0


@pytest.mark.slow
@pytest.mark.parametrize("board", [BOARD, Board.parse("chessboard 8x5 30")])
def test_twelve_drawn_views_tell_a_lens(board: Board, tell) -> None:
    found = find_lens(board, views_of(Camera("one", LENS), board, 12, seed=3), LENS.size)
    off = 100.0 * np.abs(np.array(found.lens.focal) / LENS.focal - 1.0).max()
    tell(f"12 drawn views of a {board.kind}: {found.residual:.3f} px left, focal {off:.3f} % off")
    assert found.residual < 0.2
    assert off < 0.4


@pytest.mark.slow
def test_the_told_sigma_of_a_lens_is_honest() -> None:
    camera, rng = Camera("one", LENS), np.random.default_rng(5)
    poses = [shown(BOARD, rng.uniform(430.0, 600.0), rng) for _ in range(10)]
    ratios = []
    for seed in range(30):
        found = find_lens(BOARD, exact(camera, BOARD, poses, 0.2, seed), LENS.size)
        ratios.append((found.lens.focal[0] - LENS.focal[0]) / found.sigma[0])
        assert found.residual == pytest.approx(0.2, rel=0.2)
    assert 0.6 < np.sqrt(np.mean(np.square(ratios))) < 1.5


def test_two_cameras_are_placed_to_each_other(tell) -> None:
    left, right = stand("left", -300.0), stand("right", 300.0)
    rng = np.random.default_rng(2)
    between = Pose((0.0, -350.0, 300.0), (0.7071068, -0.7071068, 0.0, 0.0))
    poses = [between @ shown(BOARD, 350.0, rng) for _ in range(12)]
    seen = [exact(camera, BOARD, poses, 0.2, i) for i, camera in enumerate((left, right))]
    found = find_pair(BOARD, (LENS, LENS), list(zip(*seen, strict=True)))
    truth = left.pose.inverse() @ right.pose
    mm = float(np.linalg.norm(np.subtract(found.pose.position, truth.position)))
    turned = float(rotations.angle_between(found.pose.quaternion, truth.quaternion))
    tell(
        f"stereo from 12 views, 0.2 px: {found.residual:.2f} px, {mm:.2f} mm, {turned:.3f} degrees"
    )
    assert mm < 2.0
    assert turned < 0.1
    assert found.residual == pytest.approx(0.2, rel=0.2)


def test_views_that_are_alike_are_refused() -> None:
    camera = Camera("one", LENS)
    flat = [Pose((-100.0 + 10.0 * i, -60.0, 500.0)) for i in range(6)]
    with pytest.raises(Refused, match="VS034"):
        find_lens(BOARD, exact(camera, BOARD, flat, 0.1), LENS.size)
    with pytest.raises(Refused, match="VS033"):
        find_lens(BOARD, exact(camera, BOARD, flat[:3], 0.1), LENS.size)


def test_a_board_that_is_mirrored_or_not_there_is_told() -> None:
    camera = Camera("one", LENS)
    ((picture,),) = pictures([camera], BOARD, [shown(BOARD, 500.0, np.random.default_rng(1))])
    with pytest.raises(Refused, match=r"VS032.*p\.png"):
        find_board(BOARD, np.ascontiguousarray(picture[:, ::-1]), "p.png")
    assert find_board(BOARD, np.full_like(picture, 120), "p.png") is None
    assert find_board(Board.parse("chessboard 9x6 25"), picture, "p.png") is None


@pytest.mark.parametrize(
    "text",
    [
        *("", "chessboard", "chessboard 9x6", "charuco 7x5 40", "charuco 7x5 40 50"),
        *("chessboard 9x6 25 20", "chessboard 2x2 25", "chessboard 9x6 0", "charuco 30x30 10 8"),
        *("chessboard 9x6 25 4X4_50", "board 9x6 25", "charuco 7x5 40 30 9X9_50"),
    ],
)
def test_what_is_no_board_is_told(text: str) -> None:
    with pytest.raises(Refused, match="VS030") as told:
        Board.parse(text)
    assert told.value.exit_status == 2

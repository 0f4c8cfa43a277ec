"""Rigs from views of boards: what they keep, and views that do not belong together."""

from __future__ import annotations

import datetime
from pathlib import Path

import cv2
import numpy as np
import pytest

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.program.geometry import Pose
from assistant.vision.cameras.calibration import (
    Board,
    BoardPictures,
    BoardView,
    calibrate_rig,
    find_board_in_folder,
)
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.capture import check_agreement
from tests.vision.calibration.scenes import BOARD, LENS, exact, pictures, shown, stand

BETWEEN = Pose((0.0, -350.0, 300.0), (0.7071068, -0.7071068, 0.0, 0.0))
LEFT, RIGHT = stand("left", -300.0), stand("right", 300.0)
CHESSBOARD = Board.parse("chessboard 8x5 30")


def places(board: Board, count: int, seed: int = 2) -> list[Pose]:
    rng = np.random.default_rng(seed)
    return [BETWEEN @ shown(board, 350.0, rng) for _ in range(count)]


def seen(camera: Camera, board: Board, poses: list[Pose], noise: float = 0.1) -> BoardPictures:
    views = tuple(exact(camera, board, poses, noise))
    return BoardPictures(camera.name, LENS.size, tuple(view.name for view in views), views, ())


def test_a_rig_keeps_its_date_and_what_was_left() -> None:
    poses = places(BOARD, 12)
    looked = [seen(camera, BOARD, poses) for camera in (LEFT, RIGHT)]
    day = datetime.date(2026, 11, 25)
    found = calibrate_rig(BOARD, looked, today=day)
    left, right = found.rig.records["left"], found.rig.records["right"]
    assert (left.date, right.date) == (day, day)
    assert left.residual == pytest.approx(0.1, rel=0.2)
    assert right.pair == pytest.approx(0.1, rel=0.2)
    assert (left.pair, left.mm, right.degrees) == (None, None, None)


def test_a_pair_beside_an_arm_stands_in_its_base() -> None:
    """The board is on the flange; where it is there nobody says."""
    on_flange = Pose((20.0, -10.0, 40.0), (0.0, 1.0, 0.0, 0.0))
    poses = places(BOARD, 12)
    flanges = [one @ on_flange.inverse() for one in poses]
    looked = [seen(camera, BOARD, poses, 0.05) for camera in (LEFT, RIGHT)]
    found = calibrate_rig(BOARD, looked, flanges=flanges)
    for camera in (LEFT, RIGHT):
        there = found.rig[camera.name].pose.position
        assert there == pytest.approx(camera.pose.position, abs=6.0)
    assert found.rig.records["left"].mm < 1.0
    assert found.rig.records["left"].degrees < 0.2


def test_views_that_do_not_belong_together_are_told() -> None:
    poses = places(BOARD, 8)
    left, right = (seen(camera, BOARD, poses) for camera in (LEFT, RIGHT))
    other = seen(RIGHT, BOARD, poses[:-1])
    with pytest.raises(Refused, match=r"VS036.*left.*right"):
        calibrate_rig(BOARD, [left, other])
    with pytest.raises(Refused, match=r"VS036.*poses of the arm"):
        calibrate_rig(BOARD, [left], flanges=poses[:-1])
    wrong = BoardPictures("right", LENS.size, right.files, right.views[::-1], ())
    with pytest.raises(Refused, match=r"VS043.*left.*right"):
        calibrate_rig(BOARD, [left, wrong])


def test_a_pair_of_which_one_picture_is_mirrored_is_told() -> None:
    """A chessboard alone does not tell that: its mirror image is a chessboard as well."""
    poses = places(CHESSBOARD, 10)
    left, right = (seen(camera, CHESSBOARD, poses) for camera in (LEFT, RIGHT))
    views = tuple(_mirrored(view) for view in right.views if view is not None)
    with pytest.raises(Refused, match="VS043"):
        calibrate_rig(CHESSBOARD, [left, BoardPictures("right", LENS.size, right.files, views, ())])


def _mirrored(view: BoardView) -> BoardView:
    """As the corners of a mirrored picture are found: its rows begin at their other ends."""
    columns, _ = CHESSBOARD.across
    pixels: Floats = view.pixels * [-1.0, 1.0] + [LENS.size[0] - 1.0, 0.0]
    return BoardView(
        view.name, view.rows // columns * columns + columns - 1 - view.rows % columns, pixels
    )


def test_a_chessboard_that_is_alike_upside_down_tells_no_place() -> None:
    board = Board.parse("chessboard 8x6 30")
    poses = places(board, 8)
    looked = [seen(camera, board, poses) for camera in (LEFT, RIGHT)]
    assert calibrate_rig(board, looked[:1]).rig["left"].lens.focal == pytest.approx(
        LENS.focal, rel=0.03
    )
    with pytest.raises(Refused, match=r"VS039.*8 × 6"):
        calibrate_rig(board, looked)
    with pytest.raises(Refused, match="VS039"):
        calibrate_rig(board, looked[:1], flanges=poses)


def test_what_pictures_lack_is_told(tmp_path: Path) -> None:
    ((picture,),) = pictures([Camera("one", LENS)], BOARD, [shown(BOARD, 500.0, _rng())])
    cv2.imwrite(str(tmp_path / "1.png"), picture)
    cv2.imwrite(str(tmp_path / "2.png"), np.full_like(picture, 90))
    looked = find_board_in_folder(BOARD, "left", tmp_path)
    assert [view is not None for view in looked.views] == [True, False]
    assert [finding.code for finding in looked.findings] == ["VS031"]
    assert "2.png" in str(looked.findings[0])
    cv2.imwrite(str(tmp_path / "3.png"), picture[:400])
    with pytest.raises(Refused, match=r"VS037.*3\.png has 640 × 400"):
        find_board_in_folder(BOARD, "left", tmp_path)


def test_blurred_views_are_told() -> None:
    looked = seen(LEFT, BOARD, places(BOARD, 8), noise=1.1)
    assert "VS035" in {finding.code for finding in calibrate_rig(BOARD, [looked]).findings}


def test_cameras_of_which_one_was_moved_do_not_agree() -> None:
    pose = places(BOARD, 1)[0]
    corners = pose.moved(BOARD.corners)
    pixels = [camera.project(corners) for camera in (LEFT, RIGHT)]
    good, none = check_agreement([LEFT, RIGHT], pixels, BOARD.corners)
    assert none == () and good.corners == len(corners)
    assert (good.pixels, good.mm) == pytest.approx((0.0, 0.0), abs=1e-6)
    moved = Camera("right", LENS, RIGHT.pose @ Pose((0.0, 4.0, 0.0)))
    _, told = check_agreement([LEFT, moved], pixels, BOARD.corners)
    assert [one.code for one in told] == ["VS026"]


def _rng() -> np.random.Generator:
    return np.random.default_rng(1)


def in_the_middle(count: int, distance: float, wide: float, seed: int = 4) -> list[Pose]:
    """Boards before both cameras, off the middle by part of the distance at most."""
    rng = np.random.default_rng(seed)
    middle = BOARD.corners.mean(axis=0)
    found = []
    for pose in (shown(BOARD, distance, rng) for _ in range(count)):
        there = pose.moved(middle[None])[0]
        away = np.array([*rng.uniform(-wide, wide, 2) * distance, distance])
        turn = np.array(pose.quaternion)
        found.append(BETWEEN @ Pose.of(np.array(pose.position) - there + away, turn))
    return found


def test_a_board_in_the_middle_of_the_picture_only_is_reported() -> None:
    poses = in_the_middle(10, 500.0, 0.02)
    found = calibrate_rig(BOARD, [seen(camera, BOARD, poses, 0.2) for camera in (LEFT, RIGHT)])
    assert [one.code for one in found.findings].count("VS045") == 2
    assert "VS046" in {one.code for one in found.findings}
    assert found.lenses["left"].coverage < 0.25
    wide = [LEFT.pose @ shown(BOARD, 450.0, np.random.default_rng(i)) for i in range(14)]
    good = calibrate_rig(BOARD, [seen(LEFT, BOARD, wide, 0.05)])
    assert good.lenses["left"].coverage > 0.5
    assert good.findings == ()


@pytest.mark.slow
@pytest.mark.parametrize(("distance", "wide"), [(350.0, 0.25), (700.0, 0.05)])
def test_every_parameter_is_as_uncertain_as_reported(distance: float, wide: float) -> None:
    """True errors of ten rigs, beside what each of them says of itself."""
    truth = LEFT.pose.inverse() @ RIGHT.pose
    base_line = float(np.linalg.norm(truth.position))
    lens, between = [], []
    for seed in range(10):
        poses = in_the_middle(10, distance, wide, seed)
        views = [
            BoardPictures(
                camera.name, LENS.size, (), tuple(exact(camera, BOARD, poses, 0.2, seed + i)), ()
            )
            for i, camera in zip((0, 100), (LEFT, RIGHT), strict=True)
        ]
        found = calibrate_rig(BOARD, views)
        one, pair = found.lenses["left"], found.pairs["right"]
        values = [*one.lens.focal, *one.lens.centre, *one.lens.distortion]
        true = [*LENS.focal, *LENS.centre, *LENS.distortion]
        known = one.sigma > 0.0
        lens.append((np.subtract(values, true)[known] / one.sigma[known])[:6])
        turned = float(rotations.angle_between(pair.pose.quaternion, truth.quaternion))
        off = pair.base_line - base_line
        between.append((off / pair.sigma_mm, turned / pair.sigma_deg))
    assert 0.5 < np.sqrt(np.mean(np.square(lens))) < 1.6
    assert 0.5 < np.sqrt(np.mean(np.square([mm for mm, _ in between]))) < 2.0
    assert 0.5 < np.sqrt(np.mean(np.square([degrees for _, degrees in between]))) < 2.0


def test_a_wrong_row_of_poses_is_named_by_its_picture() -> None:
    on_flange = Pose((20.0, -10.0, 40.0), (0.0, 1.0, 0.0, 0.0))
    poses = places(BOARD, 12)
    flanges = [one @ on_flange.inverse() for one in poses]
    x, y, z = flanges[7].position
    flanges[7] = Pose((x + 20.0, y - 15.0, z), flanges[7].quaternion)
    found = calibrate_rig(BOARD, [seen(LEFT, BOARD, poses, 0.05)], flanges=flanges)
    assert found.hand_eye is not None and found.hand_eye.left_out == (7,)
    (told,) = (one for one in found.findings if one.code == "VS047")
    assert "pose 8 (7) of the arm is 25" in str(told)
    away = np.subtract(found.rig["left"].pose.position, LEFT.pose.position)
    assert np.linalg.norm(away) < 3.0 * found.hand_eye.sigma[0]

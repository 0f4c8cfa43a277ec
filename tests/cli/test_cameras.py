"""`camera`: cameras that are drawn, calibrated from what was drawn, looked through and checked."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from assistant.base import rotations
from assistant.program.geometry import Pose
from assistant.vision.cameras.calibration import Board
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.camera_file import Rig, read_cameras, write_cameras
from tests.cli.tables import each
from tests.cli.test_commands import run as here
from tests.vision.calibration.scenes import LENS, shown, stand

BOARD = "charuco 7x5 40 30"


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    """Two cameras, and where a board was shown to them."""
    rig = Rig({one.name: one for one in (stand("left", -150.0), stand("right", 150.0))})
    write_cameras(tmp_path / "true.toml", rig)
    rng = np.random.default_rng(4)
    between = Pose((0.0, -450.0, 300.0), (0.7071068, -0.7071068, 0.0, 0.0))
    poses = [between @ shown(Board.parse(BOARD), 10.0 + 40.0 * i, rng) for i in range(6)]
    rows = [",".join(f"{v:.6f}" for v in (*p.position, *p.quaternion)) for p in poses]
    header = "x_mm,y_mm,z_mm,qw,qx,qy,qz"
    (tmp_path / "shown.csv").write_text("\n".join([header, *rows]) + "\n")
    (tmp_path / "two.csv").write_text("\n".join([header, *rows[:2]]) + "\n")
    hand = Rig({"hand": Camera("hand", LENS, Pose((0.0, 0.0, 50.0)), "arm.flange")})
    write_cameras(tmp_path / "hand.toml", hand)
    joints = ['robot = "rv-2aj"', "[[targets]]", 'name = "home"', "joints = [0, 0, 90, 0, 0, 0]"]
    (tmp_path / "joints.toml").write_text("\n".join(joints))
    return tmp_path


def run(folder: Path, forks, *arguments: str, status: int = 0) -> str:
    done = forks.python("-m", "assistant", *arguments, cwd=folder)
    assert done.returncode == status, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    return done.stdout + done.stderr


@pytest.mark.slow
def test_cameras_are_calibrated_from_what_is_drawn(cell: Path, forks) -> None:
    board = ("--board", BOARD)
    shows = ("--show", "board", "--at", "shown.csv")
    run(cell, forks, "camera", "draw", "true.toml", "-o", "pictures", *shows, *board)
    folders = ("left=pictures/left", "right=pictures/right")
    said = run(cell, forks, "camera", "calibrate", *folders, *board, "-o", "rig/found.toml")
    assert "left: 0.0" in said
    found, truth = read_cameras(cell / "rig/found.toml"), read_cameras(cell / "true.toml")
    assert found["left"].lens.focal == pytest.approx(LENS.focal, rel=0.02)
    apart = truth["left"].pose.inverse() @ truth["right"].pose
    assert found["right"].pose.position == pytest.approx(apart.position, abs=6.0)
    turned = rotations.angle_between(found["right"].pose.quaternion, apart.quaternion)
    assert float(turned) < 0.4
    assert found.records["left"].date is not None
    assert found.records["right"].pair < 0.3
    assert found.sources == {"left": "../pictures/left", "right": "../pictures/right"}
    checked = run(cell, forks, "camera", "check", "rig/found.toml", *board)
    assert "left and right:" in checked
    run(cell, forks, "camera", "view", "rig/found.toml", "left", "-o", "view.png")
    assert cv2.imread(str(cell / "view.png")).shape == (480, 640, 3)


REFUSED = (
    (("calibrate", "left", "--board", BOARD, "-o", "c.toml"), "CL500"),
    (("calibrate", "left=nowhere", "--board", BOARD, "-o", "c.toml"), "VS038"),
    (("calibrate", "left=.", "--board", "round", "-o", "c.toml"), "VS030"),
    (("view", "true.toml", "left", "-o", "v.png"), "CL501"),
    (("view", "true.toml", "top", "-o", "v.png"), "VS013"),
    (("view", "true.toml", "left", "-o", "v.gif"), "CL504"),
    (("view", "true.toml", "left", "-o", "v.png", "--source", "9"), "VS020"),
    (("draw", "true.toml", "-o", "p"), "CL503"),
    (("draw", "true.toml", "-o", "p", "--at", "shown.csv", "--poses", "two.csv"), "CL505"),
    (("draw", "hand.toml", "-o", "p", "--at", "shown.csv"), "VS027"),
    (("draw", "true.toml", "-o", "p", "--at", "joints.toml"), "CL502"),
    (("check", "true.toml"), "CL501"),
)


def test_what_cannot_be_is_told(
    cell: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(cell)

    def check(arguments: tuple[str, ...], code: str) -> None:
        status, out, err = here(capsys, "camera", *arguments)
        assert (status, code in out + err) == (2, True)

    each(REFUSED, check)


HEADER = "x_mm,y_mm,z_mm,qw,qx,qy,qz"


def table(file: Path, poses: list[Pose]) -> None:
    rows = [",".join(f"{v:.9f}" for v in (*p.position, *p.quaternion)) for p in poses]
    file.write_text("\n".join([HEADER, *rows]) + "\n")


@pytest.mark.slow
def test_a_camera_in_the_hand_is_placed_by_the_arm_from_what_is_drawn(
    cell: Path, forks, tell
) -> None:
    """Twelve poses of the flange about a board that lies on the table."""
    camera = Pose((30.0, -45.0, 60.0), (0.99, 0.03, -0.05, 0.13))
    truth = Pose.of(np.array(camera.position), np.ravel(rotations.canonical(camera.quaternion)))
    write_cameras(cell / "hand.toml", Rig({"hand": Camera("hand", LENS, truth, "arm.flange")}))
    board = Pose((420.0, -60.0, 20.0), (0.0, 1.0, 0.0, 0.0))  # its face up
    rng = np.random.default_rng(8)
    charuco = Board.parse(BOARD)
    seen = [shown(charuco, 430.0 + 12.0 * i, rng) for i in range(12)]
    flanges = [board @ one.inverse() @ truth.inverse() for one in seen]
    table(cell / "board.csv", [board])
    table(cell / "flanges.csv", flanges)
    shows = ("--show", "board", "--at", "board.csv", "--poses", "flanges.csv", "--noise", "4")
    run(cell, forks, "camera", "draw", "hand.toml", "-o", "pictures", *shows)
    given = ("hand=pictures/hand", "--board", BOARD, "--poses", "flanges.csv", "-o", "found.toml")
    how = ("--mounting", "hand", "--flange", "arm.flange", "--format", "json")
    told = json.loads(run(cell, forks, "camera", "calibrate", *given, *how))["hand_eye"]
    rig = read_cameras(cell / "found.toml")
    found, record = rig["hand"], rig.records["hand"]
    mm = float(np.linalg.norm(np.subtract(found.pose.position, truth.position)))
    degrees = float(rotations.angle_between(found.pose.quaternion, truth.quaternion))
    focal = 100.0 * float(np.abs(np.array(found.lens.focal) / LENS.focal - 1.0).max())
    tell(
        f"camera in the hand from 12 drawn ChArUco views, 4 grey levels of noise: "
        f"{record.residual:.3f} px left, focal length {focal:.3f} % off, camera {mm:.2f} mm and "
        f"{degrees:.3f} degrees off by {told['best']}; left {record.mm:.2f} mm, held out "
        f"{told['held_out']['mm']:.2f} mm"
    )
    assert found.parent == "arm.flange"
    assert mm < 1.0
    assert degrees < 0.15
    assert record.residual < 0.15
    assert record.mm < 1.0

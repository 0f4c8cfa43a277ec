"""`robots calibrate` and `robots poses`, points that two cameras saw among them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.learning.arm_calibration import calibrate
from assistant.learning.measured_poses import measured_from_columns, read_measured
from assistant.learning.pose_selection import suggest_poses
from assistant.vision.cameras.camera import Camera, Lens, looking_at
from assistant.vision.cameras.camera_file import Rig, write_cameras
from tests.cli.test_commands import run
from tests.learning.calibration.truth import Truth, drawn, placed, points_of

SAMPLE = Path(__file__).parents[3] / "samples" / "calibration" / "rv-2aj.csv"
LENS = Lens.ideal((1280, 960), 1400.0)
EYES = {
    "left": Camera("left", LENS, looking_at((1400.0, -500.0, 800.0), (150.0, 0.0, 350.0))),
    "right": Camera("right", LENS, looking_at((1400.0, 500.0, 800.0), (150.0, 0.0, 350.0))),
}
TOOL = (40.0, -20.0, 90.0)


@pytest.fixture
def mine(tmp_path):
    return tmp_path / "mine.toml"


def test_a_sample_is_calibrated_and_the_answer_tells_all(capsys, mine):
    status, out, err = run(capsys, "robots", "calibrate", "rv-2aj", SAMPLE, "-o", mine)
    assert status == 0
    assert err.count("LN112") == 4
    for said in ("of the fit", "held out", "J5.zero", "condition number", "base of the arm"):
        assert said in out
    assert robots.load(mine).lengths.a2 == pytest.approx(248.96, abs=0.06)


def test_programs_get_the_same_as_data(capsys, mine):
    asked = ("robots", "calibrate", "rv-2aj", SAMPLE, "--estimate", "chain", "-o", mine)
    status, out, _ = run(capsys, *asked, "--format", "json")
    said = json.loads(out)
    assert status == 0
    assert [Path(file).name for file in said["files"]] == ["mine.toml", "mine.urdf"]
    assert said["residuals"]["corrected_held_out"]["mm"] < 0.1
    assert {one["name"] for one in said["held"]} == {"J1.zero", "J6.zero", "J1.d"}
    assert robots.load(mine).arm.kind == "serial"


def test_doubts_are_told_by_the_exit_status_and_the_file_is_there(capsys, tmp_path, mine):
    lines = SAMPLE.read_text("utf-8").splitlines()
    cells = lines[6].split(",")
    lines[6] = ",".join([*cells[:-1], str(float(cells[-1]) + 9.0)])
    table = tmp_path / "measured.csv"
    table.write_text("\n".join(lines), "utf-8")
    status, _, err = run(capsys, "robots", "calibrate", "rv-2aj", table, "-o", mine)
    assert status == 1
    assert "LN110" in err
    assert "row 6 is" in err
    assert mine.exists()


def test_what_is_refused_leaves_no_file(capsys, mine):
    status, _, err = run(capsys, "robots", "calibrate", "rv-1a", SAMPLE, "-o", mine)
    assert (status, mine.exists()) == (2, False)
    assert "LN100" in err


@pytest.mark.parametrize(
    ("more", "code"),
    [
        (("-o", "mine.txt"), "CL540"),
        (("-o", "mine.toml", "--tool", "1,2"), "CL541"),
        (("-o", "mine.toml", "--noise", "0"), "CL542"),
    ],
)
def test_options_that_cannot_be_are_told(capsys, more, code):
    status, _, err = run(capsys, "robots", "calibrate", "rv-2aj", SAMPLE, *more)
    assert status == 2
    assert code in err


def test_the_file_of_the_measured_robot_is_not_written_over(capsys, mine):
    run(capsys, "robots", "calibrate", "rv-2aj", SAMPLE, "--estimate", "chain", "-o", mine)
    names = ("j5_deg,j6_deg", "j4_deg,j5_deg")  # of the chain that was written
    table = SAMPLE.read_text("utf-8").replace(*names)
    (mine.parent / "measured.csv").write_text(table, "utf-8")
    before = mine.with_suffix(".urdf").read_bytes()
    asked = ("robots", "calibrate", mine, mine.parent / "measured.csv", "-o", mine)
    status, _, err = run(capsys, *asked, "--estimate", "zeros")
    assert status == 2
    assert "CL544" in err
    assert mine.with_suffix(".urdf").read_bytes() == before


def test_suggested_poses_tell_more_than_random_ones(capsys, tmp_path):
    file = tmp_path / "poses.csv"
    asked = ("robots", "poses", "rv-2aj", "--count", 20, "--tool", "40,-20,90", "-o", file)
    status, out, _ = run(capsys, *asked, "--box", "-500,500,-400,400,50,700")
    assert status == 0
    assert "by chance" in out
    header, *rows = file.read_text("utf-8").splitlines()
    assert header == "j1_deg,j2_deg,j3_deg,j5_deg,j6_deg"
    joints = np.array([[float(cell) for cell in row.split(",")] for row in rows])
    assert len(joints) == 20
    points = Truth("rv-2aj", tool=placed(TOOL)).measured(joints)[:, :3, 3]
    low, high = (-500.0, -400.0, 50.0), (500.0, 400.0, 700.0)
    assert (points > np.array(low) - 0.1).all()
    assert (points < np.array(high) + 0.1).all()
    found = suggest_poses(robots.get("rv-2aj"), 20, tool=TOOL)
    assert (found.sigmas < found.by_chance).mean() > 0.9
    assert run(capsys, "robots", "poses", "rv-2aj", "--count", 2, "-o", file)[0] == 2


def test_suggested_poses_tell_as_much_as_is_said():
    robot, truth = robots.get("rv-2aj"), drawn("rv-2aj", 12)
    found = suggest_poses(robot, 30, tool=tuple(truth.tool[:3, 3]))
    done = calibrate(
        robot, measured_from_columns(found.joints, points_of(truth, found.joints)), noise=0.05
    )
    said = dict(zip((one.name for one in found.parameters), found.sigmas, strict=True))
    for one in done.corrections:
        assert one.sigma == pytest.approx(said[one.parameter.name], rel=0.15)


def test_poses_that_cannot_be_found_are_refused(capsys, tmp_path):
    asked = ("robots", "poses", "rv-2aj", "-o", tmp_path / "poses.csv")
    status, _, err = run(capsys, *asked, "--box", "5000,6000,0,1,0,1")
    assert status == 2
    assert "LN121" in err
    with pytest.raises(Refused) as found:
        suggest_poses(robots.get("rv-2aj"), 4000)
    assert found.value.findings[0].code == "LN121"
    assert run(capsys, *asked, "--count", 2)[0] == 2
    assert "CL541" in run(capsys, *asked, "--box", "1,2")[2]
    assert "CL543" in run(capsys, *asked, "--count", 2)[2]


def pixels(truth, joints, noise, seed):
    """Rows of a table: joints, and where both cameras see the tool point, by pinhole arithmetic."""
    random, columns = np.random.default_rng(seed), [joints]
    points = truth.measured(joints)[:, :3, 3]
    for eye, target in (
        (((1400.0, -500.0, 800.0)), (150.0, 0.0, 350.0)),
        (
            (1400.0, 500.0, 800.0),
            (150.0, 0.0, 350.0),
        ),
    ):
        ahead = np.subtract(target, eye)
        ahead = ahead / np.linalg.norm(ahead)
        right = np.cross(ahead, (0.0, 0.0, 1.0))
        right = right / np.linalg.norm(right)
        local = (points - eye) @ np.column_stack([right, np.cross(ahead, right), ahead])
        seen = 1400.0 * local[:, :2] / local[:, 2:] + (639.5, 479.5)
        columns.append(seen + random.normal(0.0, noise, seen.shape))
    return np.hstack(columns)


def test_what_two_cameras_saw_is_weighed_by_how_well_they_see(capsys, tmp_path, tell):
    arm, noise = robots.get("rv-2aj"), 0.1
    found = suggest_poses(arm, 60, tool=TOOL, cameras=tuple(EYES.values()))
    truth = Truth(
        "rv-2aj",
        {"a2": 1.2, "d4": -0.8},
        np.array([0.0, 0.5, -0.6, 0.7, 0.0, 0.0]),
        tool=placed(TOOL),
    )
    rows = pixels(truth, found.joints, noise, 4)
    rows[3, 5] = np.nan
    rows[7, 6] += 40.0
    names = [*(f"{axis.lower()}_deg" for axis in arm.axes)]
    names += [f"{name}_{side}_px" for name in EYES for side in "uv"]
    table, rig = tmp_path / "measured.csv", tmp_path / "cameras.toml"
    cells = [["" if np.isnan(v) else f"{v:.3f}" for v in row] for row in rows]
    table.write_text("\n".join(",".join(row) for row in [names, *cells]), "utf-8")
    write_cameras(rig, Rig(EYES))
    mine = tmp_path / "mine.toml"
    asked = ("robots", "calibrate", "rv-2aj", table, "--cameras", rig, "-o", mine)
    status, out, err = run(capsys, *asked, "--format", "json")
    said = json.loads(out)
    assert status == 1
    assert err.count("LN102") == 2
    assert "cameras disagree" in err
    true = {"a2": 1.2, "d4": -0.8, "J2.zero": 0.5, "J3.zero": -0.6, "J5.zero": 0.7}
    for one in said["parameters"]:
        wrong = one["corrected"] - one["nominal"] - true[one["name"]]
        assert abs(wrong) < 4.0 * one["sigma"]
    # Triangulation says 0.2 pixels of noise, of which there is half.
    assert said["noise_mm"] == pytest.approx(0.5, rel=0.2)
    tell(
        f"two cameras, {noise} pixels: {said['residuals']['nominal']['mm']:.2f} mm before, "
        f"{said['residuals']['corrected_held_out']['mm']:.2f} mm held out"
    )
    carried = Camera("left", LENS, EYES["left"].pose, "arm.flange")
    for cameras, reason in (
        ({"right": EYES["right"]}, "no camera `left`"),
        ({**EYES, "left": carried}, "does not stand still"),
    ):
        with pytest.raises(Refused) as refused:
            read_measured(table, arm, cameras)
        assert refused.value.findings[0].code == "LN118"
        assert reason in refused.value.findings[0].message

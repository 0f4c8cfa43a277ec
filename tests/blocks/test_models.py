"""The models of samples/blocks: what comes of them in the world that they simulate."""

from __future__ import annotations

import re
import sys

import numpy as np
import pytest

from assistant import robots
from assistant.virtual.kernel.timed_arm import track_of
from docs import models

pytest.importorskip("bdsim")


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Runs a model as from a shell: its module, its columns, and the figures that it prints."""

    def run(name: str, *arguments: str):
        module, file = models.loaded(name), tmp_path / "columns.npz"
        monkeypatch.setattr(sys, "argv", [name, *arguments, "-o", str(file)])
        module.main()
        figures = [float(one) for one in re.findall(r"\d+\.\d+", capsys.readouterr().out)]
        with np.load(file) as columns:
            return module, dict(columns), figures

    return run


def signal(columns, name: str):
    """The columns of a signal of several numbers, (n, k)."""
    return np.column_stack([columns[one] for one in columns if one.startswith(f"{name}.")])


def test_a_tool_stays_on_a_pose_that_moves(run) -> None:
    module, columns, (worst,) = run("pose_tracking")
    later = columns["seconds"] > 1.0
    places, turns = module.ROBOT.fk(signal(columns, "arm[0]")[later])
    wanted = signal(columns, "target[0]")[later]
    off = np.linalg.norm(places - wanted[:, :3], axis=1)
    same = np.abs((turns * wanted[:, 3:]).sum(axis=1))  # cosine of half the angle between them
    assert np.ptp(wanted[:, :3], axis=0) == pytest.approx([80.0, 120.0, 60.0], abs=10.0)
    assert off.max() < 0.2
    assert np.degrees(2.0 * np.arccos(np.minimum(same, 1.0))).max() < 0.1
    assert worst == pytest.approx(off.max(), abs=0.01)


@pytest.mark.parametrize("law", ["image", pytest.param("pose", marks=pytest.mark.slow)])
def test_a_camera_in_the_hand_leads_the_tool_above_the_marker(run, law) -> None:
    module, columns, (before, after, _) = run("visual_servoing", "--law", law)
    joints = signal(columns, "arm[0]")
    assert before == pytest.approx(module.missed(joints[0]), abs=0.1) and before > 100.0
    assert after == pytest.approx(module.missed(joints[-1]), abs=0.01) and after < 1.0
    steps = np.abs(np.diff(joints, axis=0)) / module.STEP
    assert (steps <= 0.3 * robots.get("rv-2aj").speeds + 1e-6).all()


def test_a_path_that_waits_for_its_arm_is_kept_by_it(run) -> None:
    module, columns, (ours, took, by_time, lasts) = run("path_following")
    _, joints = module.motion()
    path = module.ROBOT.fk(joints)[0]
    arm, other = (module.ROBOT.fk(signal(columns, f"{x}[0]"))[0] for x in ("arm", "other arm"))
    # Both go all of it, to its end.
    assert max(np.linalg.norm(one[-1] - path[-1]) for one in (arm, other)) < 0.1
    assert module.beside(path[::20], arm).max() < 2.5
    assert module.beside(arm[::5], path).max() == pytest.approx(ours, abs=0.1) and ours < 2.5
    assert by_time > 4.0 * ours
    assert took > lasts


@pytest.mark.slow
def test_steps_go_out_on_one_line_while_the_status_comes_on_the_other() -> None:
    module = models.loaded("two_data_links")
    with module.virtual(0.4) as (cell, lines):  # an arm that is behind its steps
        assert lines[1].startswith("/dev/") and ":" in lines[2]
        _, ran = module.run(lines)
        machinery = cell.state.machinery
        kernel = machinery.controller.kernel
        track = machinery.do(lambda: track_of(machinery.arm, kernel.log, kernel.now))
    joints, behind = ran["status[1]"], np.abs(ran["behind[0]"]).max(axis=1)
    # It is where all steps lead, by what it tells on its second line and by its own record.
    assert ran["steps[1]"][-1] == module.STEPS
    for rows in (joints, track.joints):
        turned = rows[-1] - rows[0]
        assert turned == pytest.approx([module.TURN, 0.0, 0.0, 0.0, 0.0], abs=0.03)
        assert np.ptp(rows[:, 2]) == pytest.approx(module.STEPS / 4 * module.MOST[2], rel=0.1)
    # Not blocking: all steps were told while it was on its way, and it never stood in between.
    told = int(np.argmax(ran["steps[1]"] == module.STEPS))
    assert (np.diff(ran["steps[1]"][module.FIRST : told + 1]) == 1.0).all()
    assert behind[told] > 10 * module.MOST[0] and behind[-1] < 0.03
    moving = np.flatnonzero(track.speed > 0.0)
    assert len(moving) > 100 and (np.diff(moving) == 1).all()
    assert ran["status[5]"][-1] > 50.0

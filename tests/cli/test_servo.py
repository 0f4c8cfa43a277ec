"""`servo`: an arm that is led by drawn pictures, by jogs of a virtual controller."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from assistant.controllers import connect
from assistant.virtual.cr import VirtualCr
from tests.cli.test_commands import run

SAMPLES = Path(__file__).parents[2] / "samples" / "servoing"
TASK = ("marker.toml", "--cameras", "cameras.toml")


@pytest.fixture
def cell(tmp_path, here):
    """A controller with its motors on, in whose folder the samples are."""
    for file in SAMPLES.iterdir():
        shutil.copy(file, here / file.name)
    with VirtualCr(servo_time=0.02, pace=4.0) as virtual:
        table = f'address = "{virtual.address}"\nrobot = "rv-2aj"\ntimeout = 10\n'
        (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
        yield virtual


@pytest.mark.slow
def test_an_arm_comes_to_its_goal_and_the_log_is_written(capsys, cell, here):
    assert run(capsys, "motors", "cell1", "on", "--yes")[0] == 0
    arguments = ("servo", "cell1", *TASK, "--by", "jog", "--yes")
    status, out, said = run(capsys, *arguments, "--log", "run.csv", "--format", "json")
    assert status == 0, said
    told = json.loads(out)
    assert np.allclose(told["position"], (190.0, 30.0, 289.5), atol=1.5)
    with connect("cell1") as controller:
        shown = controller.position().joints
        assert np.allclose([shown[i] for i in (0, 1, 2, 4, 5)], told["joints"], atol=0.02)
    with (here / "run.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == told["pictures"] and float(rows[-1]["pixels"]) < 0.5
    # On a busy machine a picture may be older than it may be used (`stale` of the task).
    assert all(row["seen"] == "1.0" for row in rows if float(row["age"]) < 5.0)


def test_what_is_not_seen_moves_nothing(capsys, cell, here):
    file = here / "marker.toml"
    text = file.read_text(encoding="utf-8").replace("marker = 7", "marker = 8", 1)
    away = text.replace("position = [190, 30, 129.5]", "position = [900, 900, 129.5]")
    file.write_text(away.replace("stale = 5", "stale = 5\nopening = 0.1"), encoding="utf-8")
    assert run(capsys, "motors", "cell1", "on", "--yes")[0] == 0
    before = cell.state.joints
    arguments = ("servo", "cell1", *TASK, "--by", "jog", "--yes", "--log", "run.csv")
    status, _, said = run(capsys, *arguments)
    assert status == 1 and "VS201" in said and "CL240" not in said, said
    assert cell.state.joints == before and (here / "run.csv").exists()


REFUSED = [
    (("--by", "magic"), 2, "CL530"),
    (("--by", "jog", "--log", "run.xls"), 2, "CL252"),
    (("--by", "jog"), 2, "CL203"),
]


def test_what_is_refused_before_anything_moves(capsys, cell):
    for more, status, code in REFUSED:
        found, _, said = run(capsys, "servo", "cell1", *TASK, *more)
        assert (found, code in said) == (status, True), said


def test_a_virtual_controller_of_the_project_is_not_led(capsys, cell, tmp_path):
    table = 'address = "virtual:cr"\nrobot = "rv-2aj"\n'
    (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
    status, _, said = run(capsys, "servo", "cell1", *TASK, "--by", "mxt", "--yes")
    assert (status, "CN113" in said) == (2, True), said


def test_without_a_robot_nothing_is_led(capsys, cell, tmp_path):
    project = tmp_path / "assistant.toml"
    project.write_text(project.read_text().replace("robot =", "#"))
    status, _, said = run(capsys, "servo", "cell1", *TASK, "--by", "jog", "--yes")
    assert status == 2 and "CL531" in said


def test_a_controller_that_keeps_programs_jogs_nothing(capsys, here, tmp_path, monkeypatch):
    from assistant.virtual.irc5 import VirtualIrc5

    for file in SAMPLES.iterdir():
        shutil.copy(file, here / file.name)
    with VirtualIrc5(tmp_path / "home", rws=None, rwss=None) as virtual:
        monkeypatch.setenv("ROBOT_ASSISTANT_PASSWORD", virtual.password)
        table = f'address = "{virtual.address}"\nrobot = "rv-2aj"\n'
        (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
        status, _, said = run(capsys, "servo", "cell1", *TASK, "--by", "jog", "--yes")
    assert status == 2 and "CN209" in said, said

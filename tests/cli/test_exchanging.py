"""`exchange`: the module, and poses exchanged with a robot that runs it."""

import csv
import json
import os
import re
import signal
import subprocess
import threading

import numpy as np
import pytest

from assistant import languages
from assistant.cli import main
from assistant.virtual.irc5 import VirtualIrc5
from tests.cli.processes import Command
from tests.cli.tables import each
from tests.controllers.abb.exchanging import PlainRobot, RunningRobot


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as exit_:
        main([str(argument) for argument in arguments])
    shown = capsys.readouterr()
    return exit_.value.code, shown.out, shown.err


@pytest.fixture
def robot(tmp_path, monkeypatch):
    with RunningRobot(tmp_path / "home") as robot:
        monkeypatch.setenv("ROBOT_ASSISTANT_PASSWORD", robot.controller.password)
        yield robot


def poses(file, rows=4):
    """A table of poses down from where the robot begins."""
    table = [[420.0, 60.0, 400.0 - 5.0 * i, 0.0, 0.0, 1.0, 0.0] for i in range(1, rows + 1)]
    np.save(file, np.array(table))
    return file


def test_the_module_is_written_and_names_that_it_needs_are_told(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given = ["--tool", "GRIPPER", "--tip", "0,0,118", "--mass", "0.9", "--speed", "v50"]
    status, out, _ = run(capsys, "exchange", "module", "-o", "px.mod", *given)
    assert status == 0 and "px.mod" in out
    text = (tmp_path / "px.mod").read_text("ascii")
    assert "MoveL Posenew,v50,z100,GRIPPER;" in text
    assert not languages.get("rapid").parse(text).findings
    status, out, _ = run(capsys, "exchange", "module", "-o", "-", *given)
    assert status == 0 and out == text

    file = tmp_path / "own.mod"
    status, _, err = run(capsys, "exchange", "module", "-o", file, "--speed", "v151")
    assert status == 0 and "`v151`" in err and "v151,fine" in file.read_text("ascii")


def test_the_robot_says_where_it_is_and_stops(capsys, robot):
    address = robot.controller.address
    status, out, _ = run(capsys, "exchange", "pose", address)
    assert status == 0 and out.startswith("x 420.00  y 60.00  z 400.00 mm")
    status, out, _ = run(capsys, "exchange", "pose", address, "--format", "json")
    assert json.loads(out)["position"] == pytest.approx([420.0, 60.0, 400.0])
    status, out, _ = run(capsys, "exchange", "stop", address)
    assert status == 0 and "its program has ended" in out
    status, _, err = run(capsys, "exchange", "stop", address, "--timeout", "0.2")
    assert status == 1 and "CL264" in err
    status, _, err = run(capsys, "exchange", "pose", address, "--timeout", "0.2")
    assert status == 1 and "CN512" in err


def test_poses_are_followed_recorded_and_drawn(capsys, robot, tmp_path):
    table, record, plot = poses(tmp_path / "way.npy"), tmp_path / "way.csv", tmp_path / "way.png"
    more = ["--record", record, "--plot", plot, "--yes"]
    status, out, err = run(capsys, "exchange", "follow", robot.controller.address, table, *more)
    assert status == 0, err
    assert re.search(r"4 poses; each took [0-9.]+ s on average", out)
    with record.open() as file:
        rows = list(csv.DictReader(file))
    assert [round(float(row["position.z"]), 2) for row in rows] == [
        400.0,
        395.0,
        390.0,
        385.0,
        380.0,
    ]
    assert plot.read_bytes().startswith(b"\x89PNG")
    more = ["--through", "--yes", "--format", "json"]
    status, out, err = run(capsys, "exchange", "follow", robot.controller.address, table, *more)
    assert status == 0 and json.loads(out)["poses"] == 4


def test_a_second_exchange_is_refused_and_a_stop_frees_the_claim(capsys, robot, tmp_path):
    address, table = robot.controller.address, poses(tmp_path / "way.npy")
    (robot.home / "exchange_claim").mkdir()  # of a computer that nobody can ask any more
    for given in (["follow", address, table, "--yes"], ["pose", address]):
        status, _, err = run(capsys, "exchange", *given)
        assert status == 1 and "CN519" in err and "exchange stop" in err
    status, _, err = run(capsys, "exchange", "stop", address)
    assert status == 0, err
    assert not (robot.home / "exchange_claim").exists()


def test_a_table_of_one_pose_is_followed(capsys, robot, tmp_path):
    table = tmp_path / "one.csv"
    table.write_text("x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n420,60,395,0,0,1,0\n")
    given = [robot.controller.address, table, "--yes", "--format", "json"]
    status, out, err = run(capsys, "exchange", "follow", *given)
    assert status == 0, err
    assert json.loads(out)["poses"] == 1


def test_nothing_moves_that_nobody_confirmed(capsys, robot, tmp_path):
    table = poses(tmp_path / "way.npy")
    status, _, err = run(capsys, "exchange", "follow", robot.controller.address, table)
    assert status == 2 and "CL203" in err
    empty = tmp_path / "none.npy"
    np.save(empty, np.zeros((0, 7)))
    status, _, err = run(capsys, "exchange", "follow", robot.controller.address, empty, "--yes")
    assert status in (1, 2) and "Traceback" not in err
    tools = tmp_path / "tools.csv"
    row = "420,60,395,0,0,1,0"
    tools.write_text(f"x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z,tool\n{row},grip\n{row},drill\n")
    declared = "tip = [0, 0, 60]\nmass = 0.5\ncentre = [0, 0, 30]\n"
    process = tmp_path / "tools.process.toml"
    process.write_text("".join(f"[tools.{name}]\n{declared}" for name in ("grip", "drill")))
    status, _, err = run(capsys, "exchange", "follow", robot.controller.address, tools, "--yes")
    assert status == 1 and "CL265" in err and "drill, grip" in err
    bad = ["--plot", "way.gif", "--yes"]
    status, _, err = run(capsys, "exchange", "follow", robot.controller.address, table, *bad)
    assert status == 2 and "CL009" in err
    status, out, _ = run(capsys, "exchange", "pose", robot.controller.address)
    assert status == 0 and "z 400.00" in out


def test_an_interrupt_stops_the_robot_and_says_so(tmp_path, forks):
    with RunningRobot(tmp_path / "home", pace=1.0) as robot:
        table, record = tmp_path / "far.npy", tmp_path / "far.csv"
        np.save(table, np.array([[420.0 - 40.0 * i, 60, 400, 0, 0, 1, 0] for i in range(1, 6)]))
        process = Command(
            *(forks, "exchange", "follow", robot.controller.address, table),
            *("--yes", "--record", record),
            env={**os.environ, "ROBOT_ASSISTANT_PASSWORD": robot.controller.password},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        seen = robot.home / "exchange_answer.txt"
        for _ in range(4000):
            if seen.exists() or process.poll() is not None:
                break
            threading.Event().wait(0.005)
        threading.Event().wait(0.3)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=20)
        assert process.returncode == 130, err
        assert "CL263" in err and "stands still" in err and "Traceback" not in err
        assert robot.ended() == ("end", "")
        assert record.exists()


@pytest.fixture
def plain(tmp_path, monkeypatch):
    with VirtualIrc5(tmp_path / "home", rws=None, rwss=None) as controller:
        monkeypatch.setenv("ROBOT_ASSISTANT_PASSWORD", controller.password)
        with PlainRobot(controller.folder):
            yield controller.address


def test_poses_go_by_plain_files(capsys, plain, tmp_path):
    address = plain
    status, out, _ = run(capsys, "exchange", "pose", address, "--plain")
    assert status == 0 and out.startswith("x 420.00  y 60.00  z 400.00 mm")
    table, record = poses(tmp_path / "way.npy"), tmp_path / "way.csv"
    given = [address, table, "--plain"]
    status, _, err = run(capsys, "exchange", "follow", *given)
    assert status == 2 and "CL203" in err
    status, out, err = run(capsys, "exchange", "follow", *given, "--record", record, "--yes")
    assert status == 0, err
    assert re.search(r"4 poses; each took [0-9.]+ s on average", out) and "nan" not in out
    with record.open() as file:
        rows = list(csv.DictReader(file))
    assert [round(float(row["position.z"])) for row in rows] == [400, 395, 390, 385, 380]
    status, out, err = run(capsys, "exchange", "follow", *given, "--yes", "--format", "json")
    assert status == 0 and json.loads(out)["poses"] == 4


def test_the_plain_module_has_the_names_that_are_given(capsys, tmp_path):
    file = tmp_path / "px.mod"
    given = ["--plain", "--files", "a.txt, b.txt,c.txt", "--answers", "d,e,f", "-o", file]
    status, _, err = run(capsys, "exchange", "module", *given, "--folder", "HOME:/poses")
    assert status == 0, err
    text = file.read_text("ascii")
    assert 'string1:="HOME:/poses/a.txt";' in text and 'string6:="HOME:/poses/d";' in text
    assert "\\MaxTime:=240;" in text


NO_MODULE = (
    (["--tool", "a;b"], "CN515", 1),
    (["--tool", "robtarget"], "CN515", 1),
    (["--tip", "1,2"], "CL261", 2),
    (["--tip", "1,2,x"], "CL261", 2),
    (["--tip", "1,2,3", "--centre", "0"], "CL261", 2),
    (["--longest", "0"], "CN516", 1),
    (["--files", "a,b,c"], "CL267", 2),
    (["--answers", "a,b,c"], "CL267", 2),
    (["--plain", "--files", "a,b"], "CL261", 2),
    (["--plain", "--zone", "z10"], "CL266", 2),
    (["--plain", "--files", "a,b,a"], "CN515", 1),
    (["--plain", "--files", "main.mod,b,c"], "CN515", 1),
    (["--plain", "--tool", "posnow"], "CN515", 1),
)


def test_what_a_module_cannot_hold_is_a_finding(capsys, tmp_path):
    file = tmp_path / "px.mod"

    def check(given, code, status):
        found, _, err = run(capsys, "exchange", "module", "-o", file, *given)
        assert found == status and code in err and "Traceback" not in err
        assert not file.exists()

    each(NO_MODULE, check)
    follow = ["ftp://user@127.0.0.1:1", poses(tmp_path / "way.npy"), "--plain", "--through"]
    status, _, err = run(capsys, "exchange", "follow", *follow, "--yes")
    assert status == 2 and "CL266" in err

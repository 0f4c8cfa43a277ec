"""`follow`: a trajectory that is checked as a whole and led along, cycle by cycle."""

from __future__ import annotations

import csv
import json
import signal
import socket
import subprocess
import sys
import threading
from contextlib import closing

import pytest

from assistant import robots
from assistant.controllers import connect, parse
from assistant.controllers.mitsubishi.cr import Cr
from assistant.virtual.cr import VirtualCr
from assistant.virtual.cr.real_time import Enet, mxt_commands
from assistant.virtual.irc5.egm import Guidance, VirtualEgm
from tests.cli.test_commands import run
from tests.controllers.abb.exchanging import RunningRobot

HEAD = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z,speed_mm_s\n"
FIVE = HEAD + "160,0,478,0,0,1,0,500\n170,0,470,0,0,1,0,500\n175,0,470,0,0,1,0,500\n"
SIX = HEAD + "422,0,750,0.5,0,0.8660254,0,500\n430,5,750,0.5,0,0.8660254,0,500\n"


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.fixture
def led(tmp_path, here):
    """A CR controller in which programs can be led by packets, and the port of those."""
    port = free_port()
    commands = mxt_commands(port=port)
    with VirtualCr(lines={"ENET:": Enet()}, commands=commands) as controller:
        table = f'address = "{controller.address}"\nrobot = "rv-2aj"\ntimeout = 5\n'
        (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
        (here / "way.csv").write_text(FIVE, encoding="utf-8")
        yield controller, port


def test_joints_are_led_by_packets(capsys, led, here):
    _, port = led
    # What lies in the folder is no part of us: the process of the loop imports it from elsewhere.
    (here / "struct.py").write_text("raise SystemExit('imported')\n", encoding="utf-8")
    assert run(capsys, "motors", "cell1", "on", "--yes")[0] == 0
    arguments = ("follow", "cell1", "way.csv", "--by", "mxt", "--port", port, "--yes")
    status, out, said = run(capsys, *arguments, "--log", "run.csv")
    assert status == 0, said
    assert "followed way.csv" in out and "wrote run.csv" in out
    with connect("cell1") as controller:
        assert controller.position().position == pytest.approx((175.0, 0.0, 470.0), abs=0.05)
        assert controller.names() == ()
    with (here / "run.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) > 10 and float(rows[-1]["time"]) > 0.0


def test_joint_positions_go_over_a_line_of_data(capsys, tmp_path, here):
    """On a controller that has been on for a while: its timers are old, and nobody is late yet."""
    (here / "way.csv").write_text(FIVE, encoding="utf-8")
    controller = VirtualCr()
    devices = ", ".join(f"OPT{i}" for i in range(12, 19))
    controller.state.parameters.write("COMDEV", f"{devices}, ", all_levels=True)
    with controller:
        table = f'address = "{controller.address}"\nrobot = "rv-2aj"\ntimeout = 5\n'
        (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
        assert run(capsys, "motors", "cell1", "on", "--yes")[0] == 0
        with Cr(parse(controller.address)) as session:
            session.execute("M_TIMER(2)=9000", wait=True)
        lines = [f"{host}:{port}" for host, port in controller.data_ports.values()][:2]
        arguments = ("follow", "cell1", "way.csv", "--by", "data-link", "--yes", "--interval", "1")
        status, _, said = run(capsys, *arguments, "--line", lines[0], "--line", lines[1])
        assert status == 0, said
        with connect("cell1") as session:
            assert session.position().position == pytest.approx((175.0, 0.0, 470.0), abs=0.05)


DOWN = HEAD + "".join(f"420,60,{z},0,0,1,0,500\n" for z in range(400, 340, -5))
GRIPPER = '[tools.GRIPPER]\ntip = [0, 0, 118]\n[motion]\ntool = "GRIPPER"\n'


@pytest.mark.slow
def test_poses_go_by_files_until_ctrl_c(capsys, monkeypatch, tmp_path, here):
    """The file server tells of no arm, but the program of the exchange does."""
    (here / "way.csv").write_text(DOWN, encoding="utf-8")
    (here / "way.process.toml").write_text(GRIPPER, encoding="utf-8")
    with RunningRobot(tmp_path / "home", pace=0.5) as robot:
        monkeypatch.setenv("ROBOT_ASSISTANT_PASSWORD", robot.controller.password)
        table = f'address = "{robot.controller.address}"\nrobot = "irb1200-7-0.7"\n'
        (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
        command = [sys.executable, "-m", "assistant", "follow", "cell1", "way.csv"]
        with subprocess.Popen(
            [*command, "--by", "exchange", "--yes"], stderr=subprocess.PIPE, text=True
        ) as child:
            request = robot.home / "exchange_request.txt"
            while child.poll() is None and not (
                request.exists() and "pass" in request.read_text(errors="replace")
            ):
                threading.Event().wait(0.005)
            child.send_signal(signal.SIGINT)
            _, said = child.communicate(timeout=60)
    assert child.returncode == 130 and "CL245" in said and "Traceback" not in said, said


def test_another_program_of_that_name_is_not_replaced(capsys, led, here):
    controller, port = led
    (here / "follow.prg").write_text("10 DLY 1\n20 END\n")
    assert run(capsys, "put", "cell1", "follow.prg")[0] == 0
    arguments = ("follow", "cell1", "way.csv", "--by", "mxt", "--port", port, "--yes")
    status, _, said = run(capsys, *arguments)
    assert status == 1 and "CN230" in said and "DLY 1" in controller.text("FOLLOW")


def test_joints_are_led_as_a_program_asks_for_them(capsys, rws, here):
    port = free_port()
    home, patient = robots.get("irb1200-7-0.7").home, 60.0
    arm = Guidance(
        "joints", home, (200.0,) * 6, comm_timeout=patient, cond_time=patient, waiting=None
    )
    (here / "way.csv").write_text(SIX, encoding="utf-8")
    arguments = ("follow", "cell1", "way.csv", "--by", "egm", "--port", port, "--yes")
    with VirtualEgm(arm, ("127.0.0.1", port)):
        status, out, said = run(capsys, *arguments, "--format", "json")
    assert status == 0, said
    assert json.loads(out)["followed"].startswith(tuple("123456789"))


def test_a_motion_that_nobody_asked_for_stops_no_program(capsys, rws, here):
    """The port is taken: nothing was sent, so what runs on the controller goes on."""
    busy = "MODULE Busy\n  PROC main()\n    WaitTime 1000;\n  ENDPROC\nENDMODULE\n"
    (here / "busy.mod").write_text(busy)
    (here / "way.csv").write_text(SIX, encoding="utf-8")
    for command in (("put", "cell1", "busy.mod"), ("motors", "cell1", "on", "--yes")):
        assert run(capsys, *command)[0] == 0
    assert run(capsys, "start", "cell1", "busy.mod", "--yes", "--no-wait")[0] == 0
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as taken:
        taken.bind(("", 0))
        port = str(taken.getsockname()[1])
        arguments = ("follow", "cell1", "way.csv", "--by", "egm", "--port", port, "--yes")
        status, _, said = run(capsys, *arguments)
    assert status in (1, 2) and "CN711" in said, said
    with connect("cell1") as controller:
        assert controller.state().running


REFUSED = [
    (FIVE, ("--by", "magic"), 2, "CL250"),
    (FIVE, ("--by", "mxt", "--speed", "200"), 2, "CL243"),
    (FIVE, ("--by", "mxt", "--interval", "0"), 2, "CL253"),
    (FIVE, ("--by", "mxt", "--log", "run.xls"), 2, "CL252"),
    (FIVE, ("--by", "data-link", *("--line", "127.0.0.1:1") * 3), 2, "CL254"),
    (FIVE, ("--by", "data-link", "--cycle", "0.01"), 2, "CN209"),
    (FIVE, ("--by", "mxt", "--port", "0"), 2, "--port"),
    (FIVE, ("--by", "mxt", "--cycle", "0"), 2, "--cycle"),
    (FIVE + "5000,0,470,0,0,1,0,500\n", ("--by", "mxt"), 1, "RB1"),
    (HEAD, ("--by", "mxt"), 1, "TB"),
]


def test_what_is_refused_before_anything_moves(capsys, cr, here, tmp_path):
    for text, more, status, code in REFUSED:
        (here / "way.csv").write_text(text, encoding="utf-8")
        found, _, said = run(capsys, "follow", "cell1", "way.csv", *more, "--yes")
        assert (found, code in said) == (status, True), said
        assert cr.names() == ()
    project = tmp_path / "assistant.toml"
    project.write_text(project.read_text().replace("robot =", "#"))
    (here / "way.csv").write_text(FIVE, encoding="utf-8")
    status, _, said = run(capsys, "follow", "cell1", "way.csv", "--by", "mxt", "--yes")
    assert status == 2 and "CL251" in said


@pytest.mark.parametrize("by", ("exchange", "data-link", "mxt", "egm"))
def test_a_virtual_controller_of_the_project_is_not_led(capsys, here, tmp_path, by):
    """It runs only during a command, so that no program waits there: nothing is read or started."""
    table = 'address = "virtual:cr"\nrobot = "rv-2aj"\n'
    (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
    status, _, said = run(capsys, "follow", "cell1", "missing.csv", "--by", by, "--yes")
    assert (status, "CN113" in said, "CL241" in said) == (2, True, False), said
    assert not [*tmp_path.rglob(".robot-assistant")]


def test_no_emergency_stop_is_asked_for_where_the_arm_has_ended(capsys, here, tmp_path):
    table = 'address = "virtual:cr"\nrobot = "rv-2aj"\n'
    (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
    status, _, said = run(capsys, "jog", "cell1", "J1", "1", "--yes")
    assert (status, "servos are off" in said, "emergency" in said) == (1, True, False), said


def test_packets_do_not_go_over_a_serial_line(capsys, here, tmp_path):
    """Nobody is asked to confirm what cannot be."""
    (here / "way.csv").write_text(FIVE, encoding="utf-8")
    with VirtualCr(serial=True) as controller:
        address = f"melfa-serial://{controller.serial_path}?parity=none&stop=1"
        table = f'address = "{address}"\nrobot = "rv-2aj"\ntimeout = 5\n'
        (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
        for by, cure in (("mxt", "melfa://"), ("data-link", "two other lines")):
            status, _, said = run(capsys, "follow", "cell1", "way.csv", "--by", by)
            assert (status, "CN209" in said, cure in said) == (2, True, True), said

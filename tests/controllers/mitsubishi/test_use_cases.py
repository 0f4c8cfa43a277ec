"""Use cases of Kohrt et al., tables II and III: a sample each, against virtual controllers."""

import csv
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from assistant.controllers import connect
from assistant.virtual.cr import VirtualCr

SAMPLES = Path(__file__).parents[3] / "samples" / "python"


def started(folder, name, *arguments):
    return subprocess.run(
        [sys.executable, str(SAMPLES / name), *map(str, arguments), "--yes"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(SAMPLES.parents[1])},
        capture_output=True,
        text=True,
        timeout=60,
    )


def sample(folder, name, *arguments):
    done = started(folder, name, *arguments)
    assert done.returncode == 0, done.stderr
    return done.stdout


def controller(pace=4.0, **settings):
    return VirtualCr("rv-2aj", servo_time=0.02, pace=pace, **settings)


def line_of(target):
    host, port = target
    return f"{host}:{port}"


def moved_up_and_back(said):
    rows = [line.partition("(")[2].split(",") for line in said.splitlines()]
    heights = [float(row[2]) for row in rows]
    assert heights == pytest.approx([heights[0], heights[0] - 20, heights[0]], abs=0.02)


@pytest.mark.slow
def test_1_direct_control_with_feedback(tmp_path):
    with controller(pace=1.0) as virtual:
        said = sample(tmp_path, "direct_control.py", virtual.address, "--port", virtual.mxt_port)
        assert virtual.names() == ()
    assert said.startswith("stands at") and "J1 at" in said
    with (tmp_path / "direct_control.csv").open(newline="") as file:
        turns = [float(row["J1"]) for row in csv.DictReader(file)]
    assert max(turns) - turns[0] == pytest.approx(5, abs=0.2) and len(turns) > 200


@pytest.mark.slow
def test_2_single_moves_over_ethernet(tmp_path):
    with controller() as virtual:
        moved_up_and_back(sample(tmp_path, "single_moves.py", virtual.address))


@pytest.mark.slow
@pytest.mark.parametrize("framing", ["plain", "procedural"])
def test_3_single_moves_over_a_serial_line(framing, tmp_path):
    with controller(serial=True, framing=framing) as virtual:
        moved_up_and_back(sample(tmp_path, "single_moves.py", virtual.serial_address))


def went_round(said):
    """The places of the square's corners, in their order."""
    rows = [line.split("at ")[1].split() for line in said.splitlines() if "at " in line]
    places = [(float(row[0]), float(row[1])) for row in rows]
    assert max(x for x, _ in places) - min(x for x, _ in places) == pytest.approx(20, abs=6)
    assert places[-1] == pytest.approx(places[0], abs=12)
    return len(places)


@pytest.mark.slow
def test_4_a_program_over_ethernet_with_feedback_over_ethernet(tmp_path):
    with controller(pace=1.0) as virtual:
        assert went_round(sample(tmp_path, "run_program.py", virtual.address)) > 3


@pytest.mark.slow
def test_4_a_program_over_ethernet_with_feedback_by_data_link(tmp_path):
    with controller() as virtual:
        status = line_of(virtual.data_ports["COM2:"])
        said = sample(tmp_path, "run_program.py", virtual.address, "--status", status)
        assert went_round(said) > 10 and "J1 " in said


@pytest.mark.slow
def test_5_a_program_over_a_serial_line(tmp_path):
    with controller(serial=True) as virtual:
        status = line_of(virtual.data_ports["COM2:"])
        said = sample(tmp_path, "run_program.py", virtual.serial_address, "--status", status)
        assert went_round(said) > 10


def test_6_two_data_links(tmp_path):
    """As in the paper: positions over RS-232, the status over Ethernet."""
    with controller(pace=1.0, serial=True, framing="data link") as virtual:
        status = line_of(virtual.data_ports["COM2:"])
        said = sample(tmp_path, "two_data_links.py", virtual.address, virtual.serial_path, status)
        with connect(virtual.address) as session:
            assert not session.state().motors
    assert "21 of 21" in said
    with (tmp_path / "two_data_links.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    turns = [float(row["J_CURR.J1"]) for row in rows]
    assert max(turns) == pytest.approx(5, abs=0.5) and min(turns) == pytest.approx(-5, abs=0.5)


OTHERS = [
    pytest.param(path.name, marks=pytest.mark.slow)
    for path in sorted(SAMPLES.glob("*.py"))
    if path.name not in ("single_moves.py", "trajectory.py")  # which reaches for no controller
]


@pytest.mark.parametrize("name", ["single_moves.py", *OTHERS])
def test_what_a_sample_is_refused_is_one_sentence(name, tmp_path):
    """Nothing listens there."""
    lines = ["/dev/null", "127.0.0.1:9"] if name.startswith("two") else []
    done = subprocess.run(
        [sys.executable, str(SAMPLES / name), "melfa://127.0.0.1:9", *lines, "--yes"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(SAMPLES.parents[1])},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith("CN")


STRETCHED = ("J99=(0,90,0,0,0,0)", "MOV J99")
"""From where nothing straight below is in reach."""


@pytest.mark.parametrize(
    "name",
    ["single_moves.py", *[pytest.param(n, marks=pytest.mark.slow) for n in ("run_program.py", "")]],
)
def test_a_refused_move_leaves_no_error_on_the_controller(name, tmp_path):
    """Without a name: the program, with its feedback by data link."""
    with controller(pace=20.0) as virtual:
        with connect(virtual.address) as session:
            session.motors(True)
            for line in STRETCHED:
                session.execute(line, wait=line.startswith("MOV"))
            session.motors(False)
        status = ["--status", line_of(virtual.data_ports["COM2:"])] if not name else []
        done = started(tmp_path, name or "run_program.py", virtual.address, *status)
        assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
        assert "2602" in done.stderr
        with connect(virtual.address) as session:
            state = session.state()
    assert not state.faults and not state.running and not state.motors
    assert state.override == 100


@pytest.mark.slow
@pytest.mark.parametrize("error", [None, 2600])
def test_direct_control_that_is_refused_leaves_nothing_behind(error, tmp_path):
    """error: of the controller on the way; without one the swing passes a limit of the joint."""
    with controller(pace=1.0) as virtual:
        swing = ["--degrees", 400] if error is None else []
        if error is not None:
            watch = threading.Thread(target=alarmed_as_it_moves, args=(virtual, error))
            watch.start()
        port = ["--port", virtual.mxt_port]
        done = started(tmp_path, "direct_control.py", virtual.address, *port, *swing)
        assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
        assert done.stderr.startswith("CN7")
        with connect(virtual.address) as session:
            state, names = session.state(), session.names()
    assert not state.faults and not state.running and not state.motors and names == ()


def alarmed_as_it_moves(virtual, number):
    """Waits on a line of its own until the arm is on its way."""
    with connect(virtual.address) as session:
        next(seen for seen in session.watch(0.05) if seen.position.joints[0] > 1.0)
        virtual.alarm(number)


@pytest.mark.slow
def test_a_program_that_ends_by_an_error_is_reported_and_cleared(tmp_path):
    """It starts, and stops by an error on its way; the feedback ends with it."""
    with controller(pace=1.0) as virtual:
        status = line_of(virtual.data_ports["COM2:"])
        alarm = threading.Timer(3.0, virtual.alarm, (2600,))
        alarm.start()
        slow = (SAMPLES / "run_program.py").read_text("utf-8").replace("OVRD 50", "OVRD 5")
        (tmp_path / "slow.py").write_text(slow, "utf-8")
        done = started(tmp_path, tmp_path / "slow.py", virtual.address, "--status", status)
        alarm.join()
        assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
        assert "2600" in done.stderr
        with connect(virtual.address) as session:
            assert not session.state().faults


SLOW = [
    pytest.param(name, marks=pytest.mark.slow)
    for name in ("direct_control.py", "single_moves.py", "run_program.py")
]


@pytest.mark.parametrize("name", ["two_data_links.py", *SLOW])
def test_nothing_moves_unasked(name, tmp_path):
    with controller() as virtual:
        lines = ["/dev/null", "127.0.0.1:1"] if name.startswith("two") else []
        done = subprocess.run(
            [sys.executable, str(SAMPLES / name), virtual.address, *lines],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(SAMPLES.parents[1])},
            input="no\n",
            capture_output=True,
            text=True,
            timeout=60,
        )
        assert done.returncode == 1 and "type yes" in done.stdout, done.stderr
        assert virtual.names() == ()

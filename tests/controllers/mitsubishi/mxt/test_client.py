"""`Mxt` as it is used: the loop in a process of its own, the controller in another."""

import csv
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers.cyclic import Ended, Limits, Settings, Trajectory
from assistant.controllers.mitsubishi.external_control import Mxt
from assistant.program.motion import Path as Points
from assistant.program.motion import Speed
from assistant.virtual.cr.mxt_process import MxtProcess
from tests.controllers.mitsubishi.mxt.controllers import (
    ARM,
    CYCLE,
    LIMITS,
    PATIENT,
    controller,
    joints,
)
from tests.virtual.cr.waiting import wait_for

GIVEN = {"cycle": CYCLE, "limits": LIMITS, "settings": PATIENT}


@pytest.mark.slow
def test_two_trajectories_in_one_control(tmp_path):
    seen = []
    with MxtProcess(cycle=CYCLE) as virtual, Mxt("127.0.0.1", port=virtual.port, **GIVEN) as mxt:
        assert mxt.position() == pytest.approx(tuple(ARM.home), abs=1e-4)
        first = mxt.follow(joints(), watch=seen.append)
        second = mxt.follow(Trajectory.of_joints([ARM.home], unit="deg"))
    assert (first.done, second.done) == (first.rows, second.rows)
    assert virtual.result["reason"] == "end"
    assert virtual.result["joints"] == pytest.approx(list(ARM.home), abs=1e-4)
    assert seen and seen[-1].rows == first.rows
    assert first.delays.count == len(first.columns["time"])
    assert 0.0 < first.delays.median <= first.delays.most_of <= first.delays.longest
    assert "points in" in str(first)
    assert {one.code for one in first.findings} <= {"CN721", "CN722"}
    first.save(tmp_path / "run.csv")
    first.save(tmp_path / "run.npz")
    with (tmp_path / "run.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == first.delays.count
    assert float(rows[-1]["to_J1"]) == pytest.approx(joints().rows[-1, 0])
    with np.load(tmp_path / "run.npz") as saved:
        assert set(saved) == set(first.columns)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["run.csv", "run.npz"]


def test_a_stop_from_outside():
    stop = threading.Event()
    away = Trajectory.of_joints([ARM.home, ARM.home + 40.0], unit="deg")
    slow = Limits(tuple(ARM.speeds * 0.1), tuple(ARM.speeds * 4.0))
    with controller() as control:
        mxt = Mxt("127.0.0.1", port=control.port, **GIVEN)
        with mxt, pytest.raises(Ended) as ended:
            mxt.follow(away, slow, watch=lambda progress: stop.set(), stop=stop)
    assert [one.code for one in ended.value.findings] == ["CN715"]
    assert ended.value.exit_status == 2
    assert 0 < ended.value.report.done < ended.value.report.rows
    assert control.result.reason == "end"


def test_an_emergency_stop_in_the_middle():
    settings = Settings(timeout=0.3, lapse=100, softness=0.5)
    with controller(faults={80: "stop"}) as control:
        mxt = Mxt("127.0.0.1", port=control.port, **{**GIVEN, "settings": settings})
        with mxt, pytest.raises(Ended) as ended:
            mxt.follow(joints())
    assert [one.code for one in ended.value.findings] == ["CN712"]
    assert ended.value.report.columns["to_J1"][-1] == pytest.approx(
        control.result.joints[0], abs=1e-4
    )


def test_a_controller_with_a_shorter_cycle_moves_no_arm_too_fast():
    """The controller takes a point every 2 ms, of a motion that has one for every 20 ms."""
    settings = Settings(timeout=0.3, lapse=100, softness=0.5)
    away = Trajectory.of_joints([ARM.home, ARM.home + 40.0], unit="deg")
    slow = Limits(tuple(ARM.speeds * 0.1), tuple(ARM.speeds * 4.0))
    given = {**GIVEN, "settings": settings, "cycle": 10.0 * CYCLE}
    with controller() as control:
        mxt = Mxt("127.0.0.1", port=control.port, **given)
        with mxt, pytest.raises(Ended, match="times as fast") as ended:
            mxt.follow(away, slow)
    assert [one.code for one in ended.value.findings] == ["CN719"]
    assert 0 < ended.value.report.done < ended.value.report.rows
    assert control.result.reason == "end"


def test_nobody_there():
    with controller() as control:
        port = control.port
    settings = Settings(timeout=0.05)
    with Mxt("127.0.0.1", port=port, **{**GIVEN, "settings": settings}) as mxt:
        with pytest.raises(Refused, match="nothing listens") as refused:
            mxt.position()
        with pytest.raises(Ended, match="nothing listens") as ended:
            mxt.follow(joints())
    assert {one.code for one in (*refused.value.findings, *ended.value.findings)} == {"CN711"}


def test_no_such_name():
    with Mxt("no.such.name.invalid", **GIVEN) as mxt, pytest.raises(Refused) as refused:
        mxt.position()
    assert [one.code for one in refused.value.findings] == ["CN711"]


@pytest.mark.parametrize(
    "given",
    [
        {"mode": "poses"},
        {"port": 0},
        {"cycle": 0.0},
        {"axes": 9},
        {"axes": 4, "sliding": (5,)},
        {"also": (12,)},
        {"also": (11,), "short": True},
        {"watched": "nothing"},
        {"outputs": (0, -1, 0)},
        {"outputs": (10, 1, 1), "inputs": 20},
    ],
)
def test_settings_that_cannot_be(given):
    with pytest.raises(Refused) as refused:
        Mxt("127.0.0.1", **given)
    assert [one.code for one in refused.value.findings] == ["CN731"]


@pytest.mark.parametrize(
    "given", [{"timeout": 0.0}, {"lapse": 0}, {"wait": "often"}, {"softness": 2}]
)
def test_settings_of_a_loop_that_cannot_be(given):
    with pytest.raises(Refused) as refused:
        Settings(**given)
    assert [one.code for one in refused.value.findings] == ["CN704"]


def test_what_does_not_fit_is_refused_before_anything_is_sent():
    path = Points.of("a", [[400, 0, 300]] * 2, [[0, 1, 0, 0]] * 2, speeds=[Speed(50.0)])
    with controller() as control, Mxt("127.0.0.1", port=control.port) as mxt:
        with pytest.raises(Refused, match="joint mode"):
            mxt.follow(path, LIMITS)
        with pytest.raises(Refused, match="limits"):
            mxt.follow(joints())
        with pytest.raises(Refused, match="columns"):
            mxt.follow(Trajectory.of_joints([[1.0, 2.0]], unit="deg"), LIMITS)
        with pytest.raises(Refused, match="of its range"):
            mxt.follow(joints(), Limits(tuple(ARM.speeds), highest=(0.0,) * 6))
    assert control.result.replies == 0


def children():
    """Processes that this thread has started and that still run."""
    return list(
        map(int, Path(f"/proc/self/task/{threading.get_native_id()}/children").read_text().split())
    )


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="tells of processes on Linux only")
def test_a_loop_that_is_killed_is_told_and_the_control_ended():
    slow = Limits(tuple(ARM.speeds * 0.1), tuple(ARM.speeds * 4.0))
    away = Trajectory.of_joints([ARM.home, ARM.home + 40.0], unit="deg")

    def kill(progress):
        for process in children():
            os.kill(process, signal.SIGKILL)

    with controller() as control:
        mxt = Mxt("127.0.0.1", port=control.port, **GIVEN)
        with mxt, pytest.raises(Ended) as ended:
            mxt.follow(away, slow, watch=kill)
    (finding,) = ended.value.findings
    assert finding.code == "CN716" and "SIGKILL" in finding.message
    assert control.result.reason == "end"


ORPHAN = """
import sys
from dataclasses import replace
from assistant.controllers.mitsubishi.external_control import Mxt
from tests.controllers.mitsubishi.mxt.test_client import ARM, GIVEN, PATIENT, Limits, Trajectory

settings = {"settings": replace(PATIENT, alive=2.0)}
with Mxt("127.0.0.1", port=int(sys.argv[1]), **GIVEN | settings) as mxt:
    away = Trajectory.of_joints([ARM.home, ARM.home + 40.0], unit="deg")
    slow = Limits(tuple(ARM.speeds * 0.05), tuple(ARM.speeds * 2.0))
    mxt.follow(away, slow, watch=lambda now: print("led", flush=True))
"""


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_the_arm_is_brought_to_rest_when_who_asked_for_it_is_gone(how):
    """Killed, or stopped as Ctrl-Z does."""
    with controller() as control:
        command = [sys.executable, "-c", ORPHAN, str(control.port)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as asking:
            try:
                assert asking.stdout.readline() == "led\n"
                asking.send_signal(how)
                wait_for(lambda: control.result.reason == "end", 20.0)
            finally:
                asking.kill()
    moved = np.abs(np.diff(np.array(control.result.track), axis=0)) / CYCLE / ARM.speeds
    assert moved.max() <= 1.0
    assert moved[-3:].max() < 1e-3
    assert control.result.joints[0] < ARM.home[0] + 39.0

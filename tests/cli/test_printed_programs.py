"""The three programs of data link control as they were printed: run and served by commands."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from assistant.controllers.address import parse
from assistant.controllers.mitsubishi.cr import Cr
from tests.cli.test_commands import run
from tests.controllers.abb.ftp_servers import free_port as free

SAMPLES = Path(__file__).parents[2] / "samples/melfa"
NAMES = ("MULTITASK", "DATALINK", "CONTROLLINK")
GOAL = 3.0


def command(*words: object) -> list[str]:
    return [sys.executable, "-m", "assistant", *map(str, words)]


@contextmanager
def running(*words: object) -> Iterator[subprocess.Popen[str]]:
    child = subprocess.Popen(command(*words), stdout=subprocess.PIPE, text=True)
    try:
        yield child
    finally:
        child.terminate()
        child.communicate(timeout=30)


def connected(port: int) -> socket.socket:
    end = time.monotonic() + 30.0
    while True:
        try:
            return socket.create_connection(("127.0.0.1", port), timeout=10.0)
        except OSError:
            if time.monotonic() > end:
                raise
            time.sleep(0.05)


def led_to(goal: float, com1: int, com2: int) -> float:
    """J1 as the status stream tells it last, once it is at a goal that went over the other line."""
    with connected(com2) as status, connected(com1) as control:
        status.sendall(b"1\r")
        control.sendall(f"({goal},0,90,0,90,0)\r".encode())
        heard, end, j1 = b"", time.monotonic() + 20.0, float("nan")
        while not abs(j1 - goal) <= 0.02 and time.monotonic() < end:
            heard += status.recv(1 << 16)
            lines = heard.split(b"\r")[:-1]
            heard = heard[sum(len(line) + 1 for line in lines) :]
            records = [line.split(b"|") for line in lines if line.count(b"|") >= 4]
            if records:
                j1 = float(records[-1][3].strip(b" ()").split(b",")[0])
        return j1


@pytest.mark.slow
@pytest.mark.parametrize("folder", [SAMPLES, SAMPLES / "datalink"], ids=["printed", "hardened"])
def test_run_moves_to_what_comes_over_the_line(folder: Path) -> None:
    com1, com2 = free(), free()
    lines = ("--line", f"COM1={com1}", "--line", f"COM2={com2}")
    with running("run", folder / "MULTITASK.prg", "-r", "rv-2aj", *lines):
        assert led_to(GOAL, com1, com2) == pytest.approx(GOAL, abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("folder", [SAMPLES, SAMPLES / "datalink"], ids=["printed", "hardened"])
def test_a_virtual_controller_runs_them(folder: Path) -> None:
    port, com1, com2, mxt = free(), free(), free(), free()
    lines = ("--line", f"COM1={com1}", "--line", f"COM2={com2}")
    address = f"melfa://127.0.0.1:{port}"
    with running("virtual", "cr", "--port", port, "--mxt-port", mxt, *lines) as child:
        assert child.stdout is not None
        assert "listening" in child.stdout.readline()
        with Cr(parse(address)) as controller:
            for name in NAMES:
                controller.write(name, (folder / f"{name}.prg").read_bytes())
            controller.motors(True)
            controller.load("MULTITASK")
            controller.start()
            assert led_to(GOAL, com1, com2) == pytest.approx(GOAL, abs=0.02)
            controller.stop()


def test_a_line_that_leads_nowhere_is_3140(capsys: pytest.CaptureFixture[str]) -> None:
    status, _, said = run(capsys, "run", SAMPLES / "MULTITASK.prg", "-r", "rv-2aj")
    assert status == 1 and "error 3140" in said and "COM2:" in said and "--line" in said


def test_a_line_to_no_port_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    program = ("run", SAMPLES / "MULTITASK.prg", "-r", "rv-2aj")
    for target in ("65536", "127.0.0.1:99999", "9" * 5000):
        line = f"COM1={target}"
        status, _, said = run(capsys, *program, "--line", line)
        assert (status, "VC217" in said) == (2, True), said
        status, _, said = run(capsys, "virtual", "cr", "--port", "0", "--line", line)
        assert (status, "CL101" in said) == (2, True), said


def test_the_check_reports_the_variable_that_is_set_too_late(
    capsys: pytest.CaptureFixture[str],
) -> None:
    status, _, said = run(capsys, "check", SAMPLES / "MULTITASK.prg")
    assert status == 1 and said.count("MB148 warning") == 1 and "`M_02` in line 10" in said
    _, _, said = run(capsys, "check", SAMPLES / "datalink" / "MULTITASK.prg")
    assert "MB148" not in said and "MB149" not in said

"""`virtual cr`: its lines and faults, as a user starts it."""

import os
import re
import signal
import subprocess
import threading

import pytest

from tests.cli.processes import Command
from tests.cli.tables import each
from tests.cli.test_commands import run
from tests.virtual.cr.test_serial import Line
from tests.wire import Wire


@pytest.fixture
def served(tmp_path, forks):
    """What a started controller says of itself."""
    started = []

    def start(*options):
        words = ("virtual", "cr", "--port", "0", *options)
        process = Command(forks, *words, cwd=tmp_path, stdout=subprocess.PIPE)
        started.append(process)
        guard = threading.Timer(20, process.kill)
        guard.start()
        said = ""
        while "COM8:" not in said:
            line = process.stdout.readline()
            assert line, said
            said += line
        guard.cancel()
        return said

    yield start
    for process in started:
        process.send_signal(signal.SIGINT)
        assert process.wait(10) == 0
        process.stdout.close()


@pytest.mark.skipif(os.name == "nt", reason="it has no such signals")
def test_sigterm_ends_it_in_order(tmp_path, forks):
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with Command(forks, "virtual", "cr", "--port", "0", cwd=tmp_path, **pipes) as process:
        assert "listening" in process.stdout.readline()
        process.send_signal(signal.SIGTERM)
        out, said = process.communicate(timeout=30)
    assert (process.returncode, said) == (143, "ended by SIGTERM\n")
    assert out.endswith("ended\n")


def test_all_its_lines_are_told(served, tmp_path):
    said = served(
        "--folder", "programs", "--serial", "pty", "--refuse", "OVRD=5640", "--delay", "0"
    )
    with Line(re.search(r"melfa-serial://(\S+)", said)[1]) as line:
        line.send(b"1;1;LOAD=A\r1;1;EDATA10 END\r1;1;SAVE\r")
        for _ in range(3):
            assert line.until(b"\r") == b"QoK\r"
    with Wire(int(re.search(r"melfa://127.0.0.1:(\d+)", said)[1])) as wire:
        assert wire.ask("1;1;FCHECKA") == "QoKN"
        assert wire.ask("1;1;OVRD") == "QeR5640"
    assert (tmp_path / "programs" / "A.prg").read_bytes() == b"10 END\r\n"
    assert len(re.findall(r"data link COM\d: at 127\.0\.0\.1:\d+", said)) == 7


UNSERVED = (
    (("--refuse", "OVRD"), "CL103"),
    (("--refuse", "=5640"), "CL103"),
    (("--serial", "/dev/nothing"), "CL101"),
    (("--serial", "pty:."), "CL101"),
    (("--line", "COM1=pty"), "pty:FILE"),
    (("--robot", "irb140-6-0.81"), "CL101"),
    (("--port", "99999"), "65535"),
)


def test_what_cannot_be_served_is_said(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def check(options, said):
        port = () if "--port" in options else ("--port", "0")
        status, _, err = run(capsys, "virtual", "cr", *port, *options)
        assert (status, said in err) == (2, True), err

    each(UNSERVED, check)

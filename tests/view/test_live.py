"""Pages that follow a controller: served to this computer alone, told where the arm is."""

from __future__ import annotations

import http.client
import json
import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit
from urllib.request import urlopen

import numpy as np
import pytest

from assistant import robots
from assistant.view.live_page import LivePage
from assistant.virtual.cr import VirtualCr
from tests.cli.processes import Command
from tests.cli.tables import each
from tests.cli.test_commands import run
from tests.forks import Forks
from tests.view.cases import data_of
from tests.wire import Wire

Capture = pytest.CaptureFixture[str]
PROJECT = Path(__file__).parent.parent.parent
PLATE = PROJECT / "samples" / "plate.dxf"


def asked(address: str, path: str, host: str | None = None) -> http.client.HTTPResponse:
    place = urlsplit(address)
    assert place.hostname is not None
    line = http.client.HTTPConnection(place.hostname, place.port, timeout=10)
    line.request("GET", path, headers={"Host": host or place.netloc})
    return line.getresponse()


def event(lines: Any) -> tuple[str, dict[str, Any]]:
    """The next event that a page is told."""
    while (line := lines.readline()).isspace():
        pass
    kind, data = line.decode().strip(), lines.readline().decode()
    return kind.removeprefix("event: "), json.loads(data.removeprefix("data: "))


def test_a_page_is_served_to_who_knows_its_address() -> None:
    with LivePage("<p>é</p>") as served:
        place = urlsplit(served.address)
        assert place.hostname == "127.0.0.1"
        answer = asked(served.address, place.path)
        assert (answer.status, answer.read().decode()) == (200, "<p>é</p>")
        assert answer.headers["Cache-Control"] == "no-store"
        assert asked(served.address, place.path, f"localhost:{place.port}").status == 200
        assert asked(served.address, "/").status == 404
        assert asked(served.address, "/events").status == 404
        for host in ("elsewhere.example", f"elsewhere.example:{place.port}", "127.0.0.1"):
            answer = asked(served.address, place.path, host)
            assert answer.status == 403
            assert "é" not in answer.read().decode()
    with pytest.raises(OSError):
        urlopen(served.address, timeout=10)


def test_every_page_is_told_the_latest_and_the_last() -> None:
    with LivePage("") as served:
        served.tell("sample", {"joints": [1.0]})
        pages = [urlopen(f"{served.address}events", timeout=10) for _ in range(3)]
        for page in pages:
            assert event(page) == ("sample", {"joints": [1.0]})
        served.tell("sample", {"joints": [2.0]})
        for page in pages:
            assert event(page) == ("sample", {"joints": [2.0]})
        served.tell("lost", {"text": "\n\nevent: sample</script>"})
    for page in pages:
        assert event(page) == ("lost", {"text": "\n\nevent: sample</script>"})
        assert page.read().strip() == b""


@contextmanager
def viewing(forks: Forks, *words: str) -> Iterator[tuple[Command, str]]:
    """The command that follows cell1, and the address of its page."""
    environment = {**os.environ, "BROWSER": "true"}
    streams = dict.fromkeys(("stdout", "stderr"), subprocess.PIPE)
    live = ("view", PLATE, "--live", "cell1")
    process = Command(forks, *live, *words, env=environment, **streams)
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        assert line.startswith("following cell1 on http://127.0.0.1:"), line
        yield process, line.split()[3].rstrip(",")
    finally:
        process.kill()
        process.communicate()


def test_the_page_is_told_where_the_arm_of_a_controller_is(cr: VirtualCr, forks: Forks) -> None:
    robot = robots.get("rv-2aj")
    with Wire(cr.port) as other:
        other.ask("1;1;OPEN=OTHER")
        assert other.ask("1;1;CNTLON").startswith("QoK")
        with viewing(forks, "-r", "rv-2aj") as (process, address):
            with urlopen(address, timeout=10) as page:
                data = data_of(page.read().decode())
            assert data["live"] == "cell1"
            with urlopen(f"{address}events", timeout=10) as lines:
                kind, told = event(lines)
                assert kind == "sample"
                found = np.degrees(told["joints"]) - robot.zero
                assert found == pytest.approx([0.0, 0.0, 90.0, 90.0, 0.0], abs=0.01)
                assert told["state"].startswith("cell1: automatic, motors off, standing")
                assert other.ask("1;1;OVRD=50").startswith("QoK")  # nobody took the right
                while "override 50 %" not in event(lines)[1]["state"]:
                    pass
                process.send_signal(signal.SIGINT)
                assert process.wait(10) == 0
                assert lines.read().endswith(b"\n\n")


@pytest.mark.slow
def test_a_controller_that_is_lost_is_told_to_the_page(cr: VirtualCr, forks: Forks) -> None:
    with viewing(forks, "-r", "rv-2aj") as (process, address):
        with urlopen(f"{address}events", timeout=30) as lines:
            assert event(lines)[0] == "sample"
            cr.stop()
            while (told := event(lines))[0] == "sample":
                pass
        assert told[0] == "lost"
        assert process.wait(10) != 0
        assert process.stderr is not None
        assert told[1]["text"] in process.stderr.read()


NOT_FOLLOWED = (
    (("--live", "cell1", "-r", "rv-2aj", "--html", "page.html"), "CL046"),
    (("--live", "cell1", "-r", "irb1200-7-0.7"), "CL047"),
    (("--live", "{address}", "-r", "irb1200-7-0.7"), "CL048"),
    (("--live", "melfa://127.0.0.1:1", "-r", "rv-2aj"), "CN201"),
)


def test_what_is_not_followed(cr: VirtualCr, here: Path, capsys: Capture) -> None:
    def check(words: tuple[str, ...], code: str) -> None:
        given = [word.format(address=cr.address) for word in words]
        status, said, told = run(capsys, "view", PLATE, *given)
        assert (status, code in told) == (2, True)
        assert "http://" not in said
        assert not (here / "page.html").exists()

    each(NOT_FOLLOWED, check)

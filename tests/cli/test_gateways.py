"""The `gateway` command, told what it cannot serve; what it does: `tests/controllers`."""

from __future__ import annotations

import socket

import pytest

from tests.cli.test_commands import run

NO_PLACES = (
    ("gateway", "CL293", "none is named"),
    ("gateway here:1 --to there:2", "CL293", "`here:1` and `there:2`"),
    ("gateway here", "CL291", "`here` is no address"),
    ("gateway here:port", "CL291", "`here:port`"),
    ("gateway here:65536", "CL291", "`here:65536`"),
    ("gateway here:1 --listen 65536", "", "--listen"),
)


def test_places_that_are_none_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    for command, code, said in NO_PLACES:
        status, _, told = run(capsys, *command.split())
        assert (status, code in told, said in told) == (2, True, True), command


def test_a_port_that_is_taken_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        place = ("--host", "127.0.0.1", "--listen", port)
        status, _, told = run(capsys, "gateway", "127.0.0.1:1", *place)
    assert status == 1
    assert "CL292" in told and str(port) in told

"""What goes wrong on purpose: late, cut and spoilt answers, refused log-ins, others who hold."""

from __future__ import annotations

import http.client
import socket
import time

import pytest

from assistant.virtual.irc5.rws_faults import Fault
from tests.virtual.irc5.web import One


def test_an_answer_is_cut_after_each_number_of_bytes(robot, fresh):
    whole = robot.client.get("/rw/panel/opmode")
    cut = 0
    for after in (0, 1, 20, 60, len(whole.data)):
        fresh.faults.add(Fault("cut", "opmode", after=after, times=1))
        try:
            assert robot.client.get("/rw/panel/opmode").data != whole.data
        except (OSError, http.client.HTTPException):
            cut += 1
        assert robot.client.get("/rw/panel/opmode").json == whole.json
    assert cut >= 2  # urllib takes a head without its end for a whole one


def test_garbage_is_no_answer(robot, fresh):
    fresh.faults.add(Fault("garbage", times=1))
    with pytest.raises((OSError, http.client.HTTPException)):
        robot.client.get("/rw/panel/opmode")
    assert robot.client.get("/rw/panel/opmode").status == 200


def test_an_answer_comes_late(robot, fresh):
    robot.client.get("/rw/system")
    fresh.faults.add(Fault("delay", "opmode", seconds=0.1, times=1))
    began = time.monotonic()
    assert robot.client.get("/rw/panel/opmode").status == 200
    assert time.monotonic() - began >= 0.1


def test_an_answer_comes_twice(fresh):
    client = One(fresh)
    client.get("/rw/system")
    cookies = "; ".join(f"{one.name}={one.value}" for one in client.cookies)
    fresh.faults.add(Fault("twice", times=1))
    with socket.create_connection(("127.0.0.1", fresh.rws_port), timeout=10) as line:
        asked = "GET /rw/panel/opmode HTTP/1.1\r\nHost: x\r\nConnection: close\r\n"
        line.sendall(f"{asked}Cookie: {cookies}\r\n\r\n".encode())
        data = b""
        while part := line.recv(4096):
            data += part
    half = len(data) // 2
    assert data[:half] == data[half:] and data.startswith(b"HTTP/1.1 200 OK")
    client.get("/logout")


def test_faults_happen_as_often_as_they_say(robot, fresh):
    fresh.faults.add(Fault("cut", "opmode"))
    for _ in range(3):
        with pytest.raises((OSError, http.client.HTTPException)):
            robot.client.get("/rw/panel/opmode")
    assert robot.client.get("/rw/panel/speedratio").status == 200
    fresh.faults.clear()
    assert robot.client.get("/rw/panel/opmode").status == 200


def test_a_log_in_is_refused(robot, fresh):
    fresh.sessions.refuses = True
    try:
        other = type(robot.client)(fresh)
        try:
            assert other.get("/rw/system").status == 401
        except ValueError as told:  # urllib gives up after some rounds of Digest
            assert "digest" in str(told).lower()
        assert robot.client.get("/rw/panel/opmode").status in (200, 401)
    finally:
        fresh.sessions.refuses = False


def test_somebody_else_holds_mastership(robot, fresh):
    fresh.hold_mastership()
    refused = robot.take()
    assert (refused.status, refused.code) == (403, -1073445862)
    domain = robot.either("rapid", "edit")
    row = robot.client.get(f"/rw/mastership/{domain}").items()[0]
    assert (row["mastership"], row["application"]) == ("local", "somebody")
    assert robot.execution("start").code == -1073445862
    fresh.free_mastership()
    assert robot.take().status == 204


def test_connections_break_and_others_come(robot, fresh):
    line = http.client.HTTPConnection("127.0.0.1", fresh.rws_port, timeout=10)
    line.request("GET", "/rw/system")
    line.getresponse().read()
    fresh.hang_up()
    with pytest.raises((OSError, http.client.HTTPException)):
        line.request("GET", "/rw/system")
        line.getresponse()
    line.close()
    assert robot.client.get("/rw/system").status == 200

"""Subscriptions of the virtual IRC5: groups, WebSockets, and what events look like."""

from __future__ import annotations

import base64
import contextlib
import os
import re
import socket
import ssl
import struct

import pytest

from tests.virtual.irc5.web import Robot, wait_for

PROTOCOLS = {1: "robapi2_subscription", 2: "rws_subscription"}


class Events:
    """A WebSocket, frame by frame (RFC 6455)."""

    def __init__(self, client, path, protocol=None, cookie=None):
        port = int(client.base.rpartition(":")[2])
        self.line = socket.create_connection(("127.0.0.1", port), timeout=10)
        if client.dialect == 2:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
            context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
            self.line = context.wrap_socket(self.line)
        cookies = "; ".join(f"{one.name}={one.value}" for one in client.cookies)
        key = base64.b64encode(os.urandom(16)).decode()
        rows = [
            f"GET {path} HTTP/1.1",
            f"Host: 127.0.0.1:{port}",
            "Upgrade: websocket",
            "Connection: Upgrade",
            f"Sec-WebSocket-Key: {key}",
            "Sec-WebSocket-Version: 13",
            f"Sec-WebSocket-Protocol: {protocol or PROTOCOLS[client.dialect]}",
            f"Cookie: {cookies if cookie is None else cookie}",
        ]
        self.line.sendall("\r\n".join([*rows, "", ""]).encode())
        head = b""
        while not head.endswith(b"\r\n\r\n"):
            head += self.exactly(1)
        self.head = head.decode()
        self.status = int(self.head.split()[1])

    def exactly(self, count):
        data = b""
        while len(data) < count:
            part = self.line.recv(count - len(data))
            if not part:
                raise ConnectionError("closed")
            data += part
        return data

    def frame(self):
        """Its opcode and payload."""
        first, second = self.exactly(2)
        length = second & 0x7F
        if length == 126:
            (length,) = struct.unpack(">H", self.exactly(2))
        return first & 0x0F, self.exactly(length)

    def next(self):
        """The next event, as text."""
        code, data = self.frame()
        assert code == 1, (code, data)
        return data.decode()

    def send(self, opcode, data=b""):
        mask = os.urandom(4)
        masked = bytes(byte ^ mask[i % 4] for i, byte in enumerate(data))
        self.line.sendall(bytes([0x80 | opcode, 0x80 | len(data)]) + mask + masked)

    def close(self):
        self.line.close()


def subscribe(client, *resources, priority="2"):
    form = {"resources": str(len(resources))}
    for number, resource in enumerate(resources, 1):
        form[str(number)] = resource
        form[f"{number}-p"] = priority
    return client.post("/subscription", **form)


@contextlib.contextmanager
def events(client, *resources, priority="2"):
    answer = subscribe(client, *resources, priority=priority)
    assert answer.status == 201, answer.text
    found = Events(client, "/poll/" + answer.headers["Location"].rpartition("/")[2])
    with contextlib.closing(found):
        assert found.status == 101
        yield found


def test_the_answer_names_the_group_and_the_place_of_its_events(robot):
    path = robot.either("/rw/panel/ctrlstate", "/rw/panel/ctrl-state")
    answer = subscribe(robot.client, path)
    assert answer.status == 201
    location = answer.headers["Location"]
    found = re.fullmatch(r"(wss?)://127.0.0.1:(\d+)/poll/(\d+)", location)
    assert found and found[1] == robot.either("ws", "wss")
    assert answer.headers["Content-Type"].startswith("application/xhtml+xml")
    assert f'<a href="subscription/{found[3]}" rel="group"></a>' in answer.text
    assert f'<a href="{location}" rel="self"></a>' in answer.text
    assert answer.spans("pnl-ctrlstate-ev") == [{"ctrlstate": "motoroff"}]
    assert robot.client.send("DELETE", f"/subscription/{found[3]}").status == 200
    assert robot.client.send("DELETE", f"/subscription/{found[3]}").status == 400


def test_changes_of_the_panel_and_the_program_are_told(robot):
    state = robot.either("/rw/panel/ctrlstate;ctrlstate", "/rw/panel/ctrl-state;ctrlstate")
    resources = (state, "/rw/panel/speedratio", "/rw/rapid/execution;ctrlexecstate")
    robot.take()
    text = "MODULE W\nPROC main()\nWaitDI di_part, 1;\nENDPROC\nENDMODULE\n"
    robot.load("w.mod", text)
    with events(robot.client, *resources) as told:
        robot.motors()
        said = told.next()
        assert f'title="ctrlstate"><a href="{state}" rel="self"></a>' in said
        assert '<span class="ctrlstate">motoron</span>' in said
        robot.client.post("/rw/panel/speedratio?action=setspeedratio", speed_ratio="30")
        assert '<span class="speedratio">30</span>' in told.next()
        robot.execution("resetpp")
        robot.execution("start", cycle="once")
        said = told.next()
        assert 'class="rap-ctrlexecstate-ev"' in said and ">running<" in said
        robot.execution("stop")
        assert ">stopped<" in told.next()


def test_each_change_of_a_signal_is_told(robot, fresh):
    path = "/rw/iosystem/signals/Local/DRV_1/do_lamp;state"
    with events(robot.client, path, priority="0") as told:
        outputs = fresh.cabinet.board.outputs

        def blink(_):
            for value in (1.0, 0.0, 1.0):
                outputs.set("do_lamp", value)

        fresh.cabinet.live.do(blink)
        values = [re.search(r'class="lvalue">(\d)<', told.next())[1] for _ in range(3)]
        assert values == ["1", "0", "1"]


def test_data_and_the_event_log_are_told(robot, fresh):
    robot.take()
    text = "MODULE W\nPERS num n := 1;\nPROC main()\nn := 2;\nENDPROC\nENDMODULE\n"
    robot.load("w.mod", text)
    data = robot.symbol("T_ROB1/W/n") + ";value"
    with events(robot.client, data) as told:
        robot.set("T_ROB1/W/n", "8.5")
        said = told.next()
        assert 'class="rap-value-ev" title="value"><a href="' in said
        assert '<span class="value">8.5</span>' in said
        if robot.client.dialect == 1:
            assert '<li class="rap-data" title="RAPID/T_ROB1/W/n">' in said
    with events(robot.client, "/rw/elog/0") as told:
        fresh.cabinet.log.add(10002, "one")
        fresh.cabinet.log.add(10002, "two")
        numbers = [int(re.search(r'href="/rw/elog/0/(\d+)"', told.next())[1]) for _ in range(2)]
        assert numbers[1] == numbers[0] + 1
        path = f"/rw/elog/0/{numbers[1]}?lang=en"
        assert robot.client.get(path).items()[0]["desc"] == "two"


@pytest.mark.parametrize(
    "resource",
    ["/rw/nothing", "/rw/panel/opmode;none", "/rw/iosystem/signals/none;state",
     "/rw/rapid/symbol/data/RAPID/T_ROB1/W/none;value", "/rw/elog/x", ""],
)  # fmt: skip
def test_what_cannot_be_watched_is_refused(robot, resource):
    assert subscribe(robot.client, resource).status in (400, 404)
    assert subscribe(robot.client).status == 400
    assert subscribe(robot.client, "/rw/panel/opmode", priority="9").status == 400


def test_the_name_of_the_protocol_and_the_log_in_are_looked_at(robot):
    answer = subscribe(robot.client, "/rw/panel/opmode")
    path = "/poll/" + answer.headers["Location"].rpartition("/")[2]
    wrong = PROTOCOLS[3 - robot.client.dialect]
    for given, status in (
        ({"protocol": wrong}, 400),
        ({"cookie": "ABBCX=1"}, 401),
        ({}, 101),
    ):
        line = Events(robot.client, path, **given)
        assert line.status == status
        line.close()
    line = Events(robot.client, "/poll/999999")
    assert line.status == 404
    line.close()


def test_a_place_of_events_is_opened_again_in_1_and_spent_in_2(robot):
    answer = subscribe(robot.client, "/rw/panel/opmode")
    path = "/poll/" + answer.headers["Location"].rpartition("/")[2]
    for status in (101, robot.either(101, 404)):
        line = Events(robot.client, path)
        assert line.status == status
        line.close()


def test_pings_are_answered_and_a_close_as_well(robot):
    with events(robot.client, "/rw/panel/opmode") as line:
        line.send(9, b"are you there")
        assert line.frame() == (10, b"are you there")
        line.send(8, struct.pack(">H", 1000))
        code, data = line.frame()
        assert code == 8 and data[:2] == struct.pack(">H", 1000)


def test_a_client_of_rws_2_that_speaks_is_hung_up_on(robot, fresh):
    with events(robot.client, "/rw/panel/opmode") as line:
        line.send(1, b"PING")
        if robot.client.dialect == 1:
            fresh.cabinet.panel.mode = "MANR"
            assert ">MANR<" in line.next()
        else:
            code, data = line.frame()
            assert (code, data[:2], data[2:]) == (
                8,
                struct.pack(">H", 1008),
                b"Client cannot send data.",
            )


def test_the_end_of_a_session_or_group_closes_its_events(robot):
    answer = subscribe(robot.client, "/rw/panel/opmode")
    group = answer.headers["Location"].rpartition("/")[2]
    line = Events(robot.client, f"/poll/{group}")
    robot.client.send("DELETE", f"/subscription/{group}")
    assert line.frame()[0] == 8
    line.close()
    with events(robot.client, "/rw/panel/opmode") as line:
        robot.client.get("/logout")
        assert line.frame()[0] == 8


def test_a_group_of_rws_2_is_changed_in_place(fresh):
    from tests.virtual.irc5.web import FORM, Two

    robot = Robot(Two(fresh))
    answer = subscribe(robot.client, "/rw/panel/opmode")
    group = "/subscription/" + answer.headers["Location"].rpartition("/")[2]
    kind = {"Content-Type": f"{FORM};v=2.0", "Accept": "application/xhtml+xml;v=2.0"}
    body = b"resources=1&1=/rw/panel/speedratio&1-p=1"
    added = robot.client.send("PUT", group, body, kind)
    assert added.status == 200 and added.spans("pnl-speedratio-ev") == [{"speedratio": "100"}]
    assert robot.client.send("DELETE", f"{group}/rw/panel/coldetstate").status == 400
    assert robot.client.send("DELETE", f"{group}/rw/panel/opmode").status == 200
    assert robot.client.send("DELETE", f"{group}/rw/panel/speedratio").status == 200
    assert robot.client.send("PUT", group, body, kind).status == 400  # an empty group is gone
    robot.client.get("/logout")


def test_a_line_that_is_cut_leaves_nothing_behind(robot, fresh):
    listeners = fresh.cabinet.board.outputs.listeners
    before = len(listeners)
    with events(robot.client, "/rw/iosystem/signals/do_lamp;state") as line:
        assert len(listeners) == before + 1
        fresh.hang_up()
        with pytest.raises(OSError):
            line.frame()
    robot.client.get("/logout")
    wait_for(lambda: len(listeners) == before)

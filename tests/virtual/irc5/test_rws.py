"""Robot Web Services of the virtual IRC5: log-in, negotiation, and what answers look like."""

from __future__ import annotations

import contextlib
import http.client
import re
import socket
import ssl
import urllib.parse

import pytest

from assistant.virtual.irc5 import VirtualIrc5
from tests.virtual.irc5.web import FORM, HAL, XHTML, One, Robot, Two

MODULE = "MODULE Seam\n  PROC main()\n    WaitTime 1;\n  ENDPROC\nENDMODULE\n"


def test_a_challenge_has_the_fields_that_controllers_send(irc5):
    line = http.client.HTTPConnection("127.0.0.1", irc5.rws_port, timeout=10)
    line.request("GET", "/rw/system")
    answer = line.getresponse()
    answer.read()
    assert answer.status == 401
    stated = re.sub(r'nonce="[^"]+"', 'nonce="N"', answer.headers["WWW-Authenticate"])
    assert stated == (
        'Digest realm="validusers@robapi.abb", domain="/", qop="auth", nonce="N", '
        'opaque="799d5", algorithm="MD5", stale="FALSE"'
    )
    line.close()
    context = ssl.create_default_context(cafile=str(irc5.certificate))
    safe = http.client.HTTPSConnection("127.0.0.1", irc5.rwss_port, timeout=10, context=context)
    safe.request("GET", "/rw/system")
    answer = safe.getresponse()
    assert answer.headers["WWW-Authenticate"] == 'Basic realm="validusers@robapi.abb"'
    safe.close()


@pytest.mark.parametrize("client", [One, Two])
def test_a_session_is_known_by_its_cookie(irc5, client):
    one = client(irc5)
    before = len(irc5.sessions)
    for _ in range(5):
        assert one.get("/rw/panel/opmode").status == 200
    assert len(irc5.sessions) == before + 1
    assert {cookie.name for cookie in one.cookies} == {"-http-session-", "ABBCX"}
    one.get("/logout")
    assert len(irc5.sessions) == before


@pytest.mark.parametrize("client", [One, Two])
@pytest.mark.parametrize("login", [("Default User", "wrong"), ("nobody", None)])
def test_a_wrong_login_is_refused(irc5, client, login):
    before = len(irc5.sessions)
    try:
        assert client(irc5, *login).get("/rw/system").status == 401
    except ValueError as told:  # urllib gives up after some rounds of Digest
        assert "401" in str(told) or "digest" in str(told).lower()
    assert len(irc5.sessions) == before


def test_only_so_many_sessions_are_there_at_once(tmp_path):
    with VirtualIrc5(tmp_path, robot=None) as controller:
        controller.sessions.most = 3
        clients = [One(controller) for _ in range(4)]
        statuses = [one.get("/rw/system").status for one in clients]
        assert statuses == [200, 200, 200, 503]
        clients[0].get("/logout")
        assert clients[3].get("/rw/system").status == 200


@pytest.mark.parametrize(
    ("accept", "status", "type"),
    [
        (HAL, 200, HAL),
        (XHTML, 200, XHTML),
        ("application/xhtml+xml;v=2.0, */*", 200, XHTML),
        ("*/*", 406, XHTML),
        ("application/xhtml+xml", 406, XHTML),
        ("application/json", 406, XHTML),
    ],
)
def test_rws_2_answers_only_versions_that_are_asked_for(irc5, accept, status, type):
    two = Two(irc5)
    answer = two.send("GET", "/rw/panel/opmode", headers={"Accept": accept})
    assert (answer.status, answer.headers["Content-Type"]) == (status, type)
    two.get("/logout")


@pytest.mark.parametrize(
    ("method", "path", "type", "status"),
    [
        ("POST", "/rw/mastership/edit/request", f"{FORM};v=2.0", 204),
        ("POST", "/rw/mastership/edit/request", FORM, 415),
        ("POST", "/rw/mastership/edit/request", "application/json", 415),
        ("PUT", "/fileservice/HOME/type.txt", "text/plain;v=2.0", 201),
        ("PUT", "/fileservice/HOME/type.txt", "text/plain", 415),
        ("PUT", "/fileservice/HOME/type.txt", "application/octet-stream", 415),
    ],
)
def test_rws_2_takes_only_contents_with_its_version(irc5, method, path, type, status):
    two = Two(irc5)
    (irc5.folder / "type.txt").unlink(missing_ok=True)
    assert two.send(method, path, b"", {"Content-Type": type}).status == status
    two.get("/logout")


def test_rws_1_writes_xhtml_unless_json_is_asked_for(irc5):
    one = One(irc5)
    told = one.send("GET", "/rw/panel/opmode")
    assert told.headers["Content-Type"] == "application/xhtml+xml"
    assert (
        '<li class="pnl-opmode" title="opmode"><span class="opmode">AUTO</span></li>' in told.text
    )
    assert one.get("/rw/panel/opmode").headers["Content-Type"] == "application/json"
    one.get("/logout")


CAPTURED = [
    # What RobotWare 6.16 and 7.21 answered, as the tests of ichbinmeraj/abb-rws-client keep it;
    # without the links and with this controller's own names.
    (1, "/rw/panel/ctrlstate", ["_state"], {"_type": "pnl-ctrlstate", "_title": "ctrlstate",
        "ctrlstate": "motoroff"}),
    (1, "/rw/panel/speedratio", ["_state"], {"_type": "pnl-speedratio", "_title": "speedratio",
        "speedratio": "100"}),
    (1, "/rw/rapid/execution", ["_state"], {"_type": "rap-execution", "_title": "execution",
        "ctrlexecstate": "stopped", "cycle": "forever"}),
    (1, "/rw/rapid/modules?task=T_ROB1", ["_state"], {"_type": "rap-module-info-li",
        "_title": "T_ROB1/Seam", "name": "Seam", "type": "ProgMod"}),
    (2, "/rw/panel/ctrl-state", ["state"], {"_type": "pnl-ctrlstate", "_title": "ctrl-state",
        "ctrlstate": "motoroff"}),
    (2, "/rw/rapid/tasks", ["resources"], {"_type": "rap-task-li", "_title": "T_ROB1",
        "name": "T_ROB1", "type": "normal", "taskstate": "linked", "excstate": "ready",
        "active": "On", "motiontask": "TRUE"}),
    (2, "/rw/rapid/tasks/T_ROB1/modules", ["state"], {"_type": "rap-module-info-li",
        "_title": "T_ROB1/Seam", "name": "Seam", "type": "ProgMod"}),
    (2, "/rw/mastership/edit", ["state"], {"_type": "msh-resource", "_title": "edit",
        "mastership": "nomaster", "uid": "", "application": "", "location": "", "alias": "",
        "mastershipheldbyme": "FALSE"}),
]  # fmt: skip


@pytest.mark.parametrize(("dialect", "path", "where", "item"), CAPTURED)
def test_answers_have_the_shapes_of_real_controllers(fresh, dialect, path, where, item):
    robot = Robot((One if dialect == 1 else Two)(fresh))
    robot.take()
    assert robot.load("seam.mod", MODULE).status == 204
    assert robot.execution("resetpp").status == 204
    robot.give_back()
    told = robot.client.get(path).json
    rows = told.get("state", []) if where == ["state"] else told["_embedded"][where[0]]
    assert [{k: v for k, v in row.items() if k != "_links"} for row in rows] == [item]
    assert told["_links"]["base"]["href"].startswith(robot.client.base)
    if where == ["state"]:
        assert told["status"] == {"code": 294912}
    robot.client.get("/logout")


REFUSED = [
    # (path or form, status, code) of 1.0, then of 2.0; both dialects' from the same captures
    ("GET", "/fileservice/$HOME/none.mod", 404, -1073414146, "/fileservice/HOME/none.modx", 404,
     -1073438713),
    ("GET", "/fileservice/$NOVOL/x", 404, -1073414146, "/fileservice/NOVOL:/x", 400, -1073438716),
    ("GET", "/rw/rapid/tasks/T_ROB1/modules/None", 404, -1073414146,
     "/rw/rapid/tasks/T_ROB1/modules/None", 400, -1073442813),
    ("GET", "/rw/iosystem/signals/a/b/none", 404, -1073445866, "/rw/iosystem/signals/a/b/none", 404,
     -1073445866),
    ("GET", "/rw/rapid/symbol/data/RAPID/T_ROB1/NoMod/none", 400, -1073414146,
     "/rw/rapid/symbol/RAPID/T_ROB1/BASE/none/data", 404, -1073442816),
    ("GET", "/rw/rapid/modules?task=T_NONE", 404, -1073445879,
     "/rw/rapid/tasks/T_NONE/modules", 404, -1073445879),
    ("POST", "/rw/rapid/tasks/T_ROB1?action=unloadmod", 400, -1073442816,
     "/rw/rapid/tasks/T_ROB1/unloadmod", 400, -1073442813),
    ("POST", "/rw/rapid/tasks/T_ROB1?action=loadmod", 400, -1073438708,
     "/rw/rapid/tasks/T_ROB1/loadmod", 400, -1073438708),
    ("POST", "/rw/rapid/execution?action=start", 400, -1073442809, "/rw/rapid/execution/start", 403,
     -1073442809),
    ("GET", "/rw/nothing", 404, -1073414146, "/rw/nothing", 404, -1073414146),
    ("POST", "/rw/rapid/tasks", 405, -1073445879, "/rw/rapid/tasks", 405, -1073445879),
]  # fmt: skip


@pytest.mark.parametrize("row", REFUSED, ids=lambda row: row[1])
def test_refusals_have_the_numbers_of_real_controllers(robot, row):
    method, one, status, code, two, status_2, code_2 = row
    path, wanted = (one, (status, code)) if robot.client.dialect == 1 else (two, (status_2, code_2))
    robot.take()
    if method == "GET":
        answer = robot.client.get(path)
    else:
        answer = robot.client.post(path, module="None", modulepath="HOME/none.mod")
    assert (answer.status, answer.code) == wanted
    assert f"code:{answer.code} icode:-1" in answer.text
    robot.give_back()


def test_a_refusal_in_xhtml(irc5):
    one = One(irc5)
    told = one.send("GET", "/rw/rapid/tasks/T_ROB1/modules/NoSuchModule")
    assert (
        '<div class="status"><span class="code">-1073414146</span><span class="msg">' in told.text
    )
    one.get("/logout")


def test_what_the_system_is(robot, irc5):
    row = robot.client.get("/rw/system").items(robot.either("sys-system-li", "sys-system"))[0]
    assert row["rwversion"] == robot.either("6.16.2027", "7.21.0+229")
    listed = robot.client.get("/rw/system").items("sys-options-li")[0]
    assert "616-1 PC Interface" in [one["option"] for one in listed["options"]]
    assert robot.client.get("/ctrl/identity").items()[0]["ctrl-type"] == "Virtual Controller"
    clock = robot.client.get("/ctrl/clock").items("ctrl-clock-info")[0]["datetime"]
    assert re.fullmatch(r"\d{4}-\d\d-\d\d T \d\d:\d\d:\d\d", clock)
    fields = {"year": 2030, "month": 2, "day": 3, "hour": 4, "min": 5, "sec": 6}
    body = urllib.parse.urlencode({f"sys-clock-{k}": v for k, v in fields.items()}).encode()
    kind = {"Content-Type": FORM + robot.either("", ";v=2.0")}
    assert robot.client.send("PUT", "/ctrl/clock", body, kind).status == 204
    assert robot.client.get("/ctrl/clock").items()[0]["datetime"].startswith("2030-02-03 T 04:05")
    assert robot.client.send("PUT", "/ctrl/clock", b"sys-clock-year=x", kind).status == 400


def test_signals_are_read_and_set(robot, irc5):
    for name, value in (("do_lamp", "1"), ("di_part", "1"), ("DeviceNet/d651/ao_speed", "8.562")):
        path = f"/rw/iosystem/signals/{name}"
        assert robot.client.get(path).items()[0]["lvalue"] == "0"
        written = robot.post(f"{path}?action=set", f"{path}/set-value", lvalue=value)
        assert written.status == 204
        assert robot.client.get(path).items()[0]["lvalue"] == value
    assert irc5.cabinet.board.inputs.read("di_part") == 1.0
    for wrong in ("2", "x", "nan", ""):
        path = "/rw/iosystem/signals/Local/DRV_1/do_lamp"
        assert robot.post(f"{path}?action=set", f"{path}/set-value", lvalue=wrong).status == 400
    listed = robot.client.get("/rw/iosystem/signals").items("ios-signal-li")
    assert [row["_title"] for row in listed] == [
        "DeviceNet/d651/ao_speed",
        "Local/DRV_1/di_part",
        "Local/DRV_1/do_lamp",
    ]
    found = robot.post(
        "/rw/iosystem/signals?action=signal-search", "/rw/iosystem/signals/signal-search", type="AO"
    )
    assert [row["name"] for row in found.items()] == ["ao_speed"]
    page = robot.client.get("/rw/iosystem/signals?start=0&limit=2")
    assert len(page.items()) == 2
    assert page.json["_links"]["next"]["href"] == "signals?start=2&amp;limit=2"


def test_mastership_has_one_holder(robot, irc5):
    other = type(robot)(type(robot.client)(irc5))
    assert robot.take().status == 204
    assert robot.take().status == 204  # once more is no harm
    refused = other.take()
    assert (refused.status, refused.code) == (403, -1073445862)
    assert other.give_back().status == 403
    domain = robot.either("rapid", "edit")
    row = other.client.get(f"/rw/mastership/{domain}").items("msh-resource")[0]
    assert (row["mastership"], row["mastershipheldbyme"]) == ("remote", "FALSE")
    refused = other.load("seam.mod", MODULE)
    assert (refused.status, refused.code) == (403, -1073445862)
    robot.client.get("/logout")  # gives back what the session held
    assert other.take().status == 204
    other.client.get("/logout")


def test_rws_2_wants_mastership_that_1_takes_itself(robot):
    answer = robot.load("seam.mod", MODULE)
    if robot.client.dialect == 1:
        assert answer.status == 204
    else:
        assert (answer.status, answer.code) == (403, -1073445859)


def test_in_manual_mode_the_pendant_has_to_agree(robot, irc5):
    irc5.cabinet.panel.set_mode("MANR")
    assert robot.client.get("/rw/panel/opmode").items()[0]["opmode"] == "MANR"
    refused = robot.take()
    assert (refused.status, refused.code) == (403, -1073445881)
    poll = "/users/rmmp/poll"
    assert robot.client.get(poll).items("user-rmmp-poll")[0]["status"] == "NO SUCH REQUEST"
    assert robot.client.post("/users/rmmp", privilege="modify").status == 202
    assert robot.client.get(poll).items("user-rmmp-poll")[0]["status"] == "PENDING"
    irc5.grant()
    assert robot.client.get(poll).items("user-rmmp-poll")[0]["status"] == "GRANTED"
    assert robot.take().status == 204


def test_speed_ratio(robot):
    robot.take()
    path = "/rw/panel/speedratio?action=setspeedratio"
    assert robot.client.post(path, speed_ratio="50").status == 204
    assert robot.client.get("/rw/panel/speedratio").items()[0]["speedratio"] == "50"
    assert robot.client.post(path, speed_ratio="101").status == 400
    robot.give_back()


def test_a_password_is_in_no_answer_and_no_name(irc5):
    one = One(irc5)
    assert irc5.password not in one.get("/rw/system").text
    assert irc5.password not in repr(irc5.sessions) + repr(irc5)
    one.get("/logout")


def test_what_is_no_http_ends_the_connection_alone(irc5):
    for port in (irc5.rws_port, irc5.rwss_port):
        with socket.create_connection(("127.0.0.1", port), timeout=10) as line:
            line.sendall(b"\x00\x01garbage\r\n\r\n")
            with contextlib.suppress(ConnectionResetError):
                while line.recv(4096):
                    pass
    one = One(irc5)
    assert one.get("/rw/system").status == 200
    one.get("/logout")


def test_lengths_that_are_none_are_refused(irc5):
    for header, status in ((("Transfer-Encoding", "chunked"), 411), (("Content-Length", "x"), 411)):
        line = http.client.HTTPConnection("127.0.0.1", irc5.rws_port, timeout=10)
        line.putrequest("POST", "/rw/mastership")
        line.putheader(*header)
        line.endheaders()
        assert line.getresponse().status == status
        line.close()

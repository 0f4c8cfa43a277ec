"""Logging in, whose certificate is trusted, sessions, and what becomes of the mastership."""

import contextlib
import logging
import socket
import ssl
import threading

import pytest
import trustme

from assistant.base.diagnostics import Refused
from assistant.controllers import Credentials, connect
from assistant.controllers.rules import Lost
from tests.controllers.abb.rws.literal import ONE, TWO
from tests.controllers.abb.rws.peer import Rws1, Rws2, refusal
from tests.controllers.cutting import Cutting

FILES = {f"{home}/seam.mod": b"MODULE seam\nENDMODULE\n" for home in ("$HOME", "HOME")}
PEERS = {"1.0": (Rws1, ONE), "2.0": (Rws2, TWO)}


def codes(refused):
    return [finding.code for finding in refused.value.findings]


@pytest.fixture(params=PEERS)
def peer(request):
    kind, answers = PEERS[request.param]
    with kind(answers, FILES) as peer:
        yield peer


def test_a_session_is_logged_out(peer):
    with peer.connect() as client:
        assert client.names() == ("seam.mod",) and len(peer.sessions) == 1
    assert peer.sessions == set() and peer.log[-1][1] == "/logout"


def test_a_session_is_logged_out_after_an_error(peer):
    with pytest.raises(Refused), peer.connect() as client:
        client.load("seam.mod", "T_NONE")
    assert peer.sessions == set()


def test_a_wrong_password_is_a_finding_without_it(peer, caplog):
    caplog.set_level(logging.DEBUG)
    with pytest.raises(Refused) as refused, peer.connect(password="hunter2"):
        pass
    assert codes(refused) == ["CN202"] and refused.value.exit_status == 2
    assert "hunter2" not in str(refused.value) + caplog.text and peer.sessions == set()


@pytest.mark.parametrize("user", ["a\r\nX: y", 'a"b', "a\\b"])
def test_a_user_that_would_become_something_else(peer, user):
    address = f"{peer.scheme}://127.0.0.1:{peer.port}"
    client = connect(address, credentials=Credentials(user, "p"), certificate=peer.certificate)
    with pytest.raises(Refused) as refused, client:
        pass
    assert codes(refused) == ["CN202"] and peer.log == []


def test_a_folder_that_is_not_there(peer):
    address = f"{peer.scheme}://u@127.0.0.1:{peer.port}/HOME:/nowhere"
    credentials = Credentials("Default User", peer.password)
    client = connect(address, credentials=credentials, certificate=peer.certificate)
    with pytest.raises(Refused) as refused, client:
        pass
    assert codes(refused) == ["CN203"] and peer.sessions == set()


@pytest.mark.parametrize("scheme", ["rws", "rwss"])
def test_nobody_there(scheme):
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    with pytest.raises(Lost) as refused, connect(f"{scheme}://u@127.0.0.1:{port}", password="p"):
        pass
    assert codes(refused) == ["CN201"] and refused.value.exit_status == 2


@pytest.mark.parametrize("scheme", ["rws", "rwss"])
def test_nobody_who_answers(scheme):
    with socket.create_server(("127.0.0.1", 0)) as listener:
        address = f"{scheme}://u@127.0.0.1:{listener.getsockname()[1]}"
        with pytest.raises(Lost) as refused, connect(address, password="p", timeout=0.2):
            pass
    assert codes(refused) == ["CN201"] and "time" in refused.value.findings[0].message


@pytest.mark.parametrize("said", [b"220 ready\r\n", b"HTTP/1.1 200 OK\r\n\r\n<html>", b"\0" * 99])
def test_somebody_else_who_answers(said):
    def answer(listener):
        with contextlib.suppress(OSError):  # the client, or the test, has gone
            while True:
                connection, _ = listener.accept()
                with connection:
                    connection.recv(4096)
                    connection.sendall(said)

    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=answer, args=(listener,), daemon=True)
        thread.start()
        address = f"rws://u@127.0.0.1:{listener.getsockname()[1]}"
        with pytest.raises(Refused) as refused, connect(address, password="p", timeout=2):
            pass
        listener.shutdown(socket.SHUT_RDWR)
        thread.join(5)
    assert codes(refused)[0] in ("CN201", "CN222")


def test_only_certificates_that_are_known_are_trusted(tmp_path):
    with Rws2(TWO, FILES) as peer:
        (tmp_path / "bad.pem").write_text("-----BEGIN CERTIFICATE-----")
        for certificate in (None, "nowhere.pem", tmp_path, tmp_path / "bad.pem"):
            with pytest.raises(Refused) as refused, peer.connect(certificate=certificate):
                pass
            assert codes(refused) == ["CN208"] and refused.value.exit_status == 2
        assert peer.log == []


def test_the_controllers_own_certificate_is_trusted_whatever_its_name(tmp_path):
    other = trustme.CA()
    mine = other.issue_cert("robot.cell.example")
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    mine.configure_cert(context)
    leaf, authority = tmp_path / "leaf.pem", tmp_path / "authority.pem"
    mine.cert_chain_pems[0].write_to_path(leaf)
    other.cert_pem.write_to_path(authority)
    with Rws2(TWO, FILES, context=context) as peer:
        with peer.connect(certificate=leaf) as client:
            assert client.names() == ("seam.mod",)
        with pytest.raises(Refused) as refused, peer.connect(certificate=authority):
            pass
        assert codes(refused) == ["CN208"]


def test_a_busy_controller_is_asked_again(peer):
    busy = iter([(503, ""), (503, ""), (204, "")])
    one = peer.scheme == "rws"
    path = "ctrlstate?action=setctrlstate" if one else "ctrl-state"
    peer.answers[f"POST /rw/panel/{path}"] = lambda body: next(busy)
    with peer.connect() as client:
        client.motors(True)
    assert len(peer.asked("POST")) == 3


def test_a_session_that_was_never_opened_is_a_finding():
    client = connect("rws://u@127.0.0.1", credentials=Credentials("u", "p"))
    with pytest.raises(Lost):
        client.names()


def test_mastership_is_given_back_after_an_error(peer):
    load = "?action=loadmod" if peer.scheme == "rws" else "/loadmod"
    peer.answers[f"POST /rw/rapid/tasks/T_ROB1{load}"] = (400, refusal(-1073438708, "x.cpp[1]"))
    with peer.connect() as client:
        with pytest.raises(Refused) as refused:
            client.load("seam.mod")
        assert codes(refused) == ["CN301"] and peer.held == {}
        assert not client.state().right


def test_mastership_that_somebody_else_holds(peer):
    domain = "rapid" if peer.scheme == "rws" else "edit"
    peer.held[domain] = "another session"
    with peer.connect() as client, pytest.raises(Refused) as refused:
        client.load("seam.mod")
    assert codes(refused) == ["CN301"] and "held by someone else" in str(refused.value)
    assert peer.held == {domain: "another session"}


def test_mastership_is_held_for_several_acts(peer):
    with peer.connect() as client:
        with client.mastership():
            client.load("seam.mod")
            assert client.state().right and len(peer.held) == 1
            client.load("seam.mod")
        assert peer.held == {}
    taken = [path for _, path, _ in peer.asked("POST") if "request" in path]
    assert len(taken) == 1


@pytest.mark.parametrize(
    ("again", "findings"), [(True, ["CN204"]), (False, ["CN204", "CN221"])], ids=str
)
def test_a_new_session_gives_back_what_a_cut_line_left(peer, again, findings):
    held = []

    def answer(body):
        held.append(dict(peer.held))
        proxy.cut_now()
        return 204, ""

    load = "?action=loadmod" if peer.scheme == "rws" else "/loadmod"
    peer.answers[f"POST /rw/rapid/tasks/T_ROB1{load}"] = answer
    with (
        Cutting(peer.port, again=again) as proxy,
        pytest.raises(Lost) as refused,
        peer.connect(port=proxy.port) as client,
    ):
        client.load("seam.mod")
    assert codes(refused) == findings and len(held[0]) == 1
    assert "unless the controller did it" in refused.value.findings[0].message
    assert (peer.held == {}) is again and len(peer.sessions) == (0 if again else 1)


def test_what_a_new_session_may_not_give_back_is_told(peer):
    """Any other refusal than that this session holds none leaves it open."""

    def cut(body):
        proxy.cut_now()
        return 204, ""

    domain = "rapid" if peer.scheme == "rws" else "edit"
    load, back = ("?action=loadmod", "?action=release")
    if peer.scheme == "rwss":
        load, back = ("/loadmod", "/release")
    peer.answers[f"POST /rw/rapid/tasks/T_ROB1{load}"] = cut
    peer.answers[f"POST /rw/mastership/{domain}{back}"] = (500, "")
    with (
        Cutting(peer.port) as proxy,
        pytest.raises(Lost) as refused,
        peer.connect(port=proxy.port) as client,
    ):
        client.load("seam.mod")
    assert codes(refused) == ["CN204", "CN221"]


@contextlib.contextmanager
def stranger():
    """Another host, and what it hears."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        listener.setblocking(False)
        yield listener

        with pytest.raises(BlockingIOError):
            listener.accept()


def the_log_is(peer, page):
    peer.answers = {k: v for k, v in peer.answers.items() if "/elog" not in k}
    peer.answers["GET /rw/elog/0"] = page


def test_a_redirection_is_not_followed(peer):
    with stranger() as other, peer.connect() as client:
        place = f"http://127.0.0.1:{other.getsockname()[1]}/x"
        peer.answers["GET /rw/iosystem/signals"] = (307, "", {"Location": place})
        with pytest.raises(Refused, match="HTTP 307"):
            client.inputs([])


@pytest.mark.parametrize("link", ["http://127.0.0.1:{}/x", "x:@127.0.0.1:{}/x", "//127.0.0.1:{}/x"])
def test_no_next_page_is_looked_for_on_another_host(peer, link):
    """`http://host:80` with `x:@other/` behind it would be a user of that name on the other."""
    with stranger() as other, peer.connect() as client:
        place = link.format(other.getsockname()[1])
        page = f'{{"_links":{{"next":{{"href":"{place}"}}}},"state":[]}}'
        the_log_is(peer, page)
        with pytest.raises(Refused) as refused:
            client.log()
        assert codes(refused) == ["CN222"]


def test_pages_that_never_end_are_given_up(peer, monkeypatch):
    monkeypatch.setattr("assistant.controllers.abb.rws.session.MOST_PAGES", 5)
    count = iter(range(1000))

    def page(_):
        return f'{{"_links":{{"next":{{"href":"?start={next(count)}"}}}},"state":[]}}'

    the_log_is(peer, page)
    with peer.connect() as client, pytest.raises(Refused) as refused:
        client.log()
    assert codes(refused) == ["CN222"]


def test_events_are_not_looked_for_on_another_host(peer):
    with stranger() as other, peer.connect() as client:
        scheme = {"rws": "ws", "rwss": "wss"}[peer.scheme]
        place = f"{scheme}://127.0.0.1:{other.getsockname()[1]}/poll/1"
        peer.answers["POST /subscription"] = (201, "", {"Location": place})
        peer.answers["GET /poll/1"] = (307, "", {"Location": place})
        with pytest.raises(Refused) as refused, client.subscribe(["motors"]):
            pass
        assert codes(refused) == ["CN209"]


HTML = '<html xmlns="http://www.w3.org/1999/xhtml">'
NO_ANSWERS = [
    f'<!DOCTYPE x [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]>{HTML}&b;</html>',
    f'{HTML}<li class="rap-task-li">{"<div>" * 3000}{"</div>" * 3000}</li></html>',
    '{"a":' * 100_000,
    f"{HTML}<ul>",
]


@pytest.mark.parametrize("body", NO_ANSWERS)
def test_bombs_and_halves_are_no_answers(peer, body):
    peer.answers = {
        question: body if question.startswith("GET /rw/rapid/tasks") else answer
        for question, answer in peer.answers.items()
    }
    with peer.connect() as client, pytest.raises(Refused) as refused:
        client.modules()
    assert codes(refused) == ["CN222"]

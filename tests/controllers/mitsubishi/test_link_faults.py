"""The controller link when things go wrong: lines cut anywhere, answers late, spoilt, repeated."""

import contextlib
import re
import socketserver
import sys
import threading
import time

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers import connect
from assistant.controllers.rules import Lost
from assistant.virtual.cr import VirtualCr
from tests.controllers.cutting import Cutting, cuts, garbage, late, twice

OLD = "10 END\r\n"
LINES = [f"{10 * n} MVS P{n}" for n in range(1, 120)]
PLACES = [f"P{n}=(+{n}.25,+0.00,+450.00,+0.00,+180.00,+0.00)(6,0)" for n in range(1, 40)]
NEW = "".join(f"{line}\r\n" for line in [*LINES, "1200 END", *PLACES])


def codes(refused):
    return [finding.code for finding in refused.findings]


def conversation(client, folder, rounds):
    """Most of what a session does, with the operation right several times."""
    client.identify()
    client.motors(True)
    client.set_override(50)
    client.set_parameter("MEXTL", "0, 0, 100, 0, 0, 0")
    client.write("SEAM", NEW.encode())
    assert client.read("SEAM").decode() == NEW
    client.load("SEAM")
    for _ in range(rounds):
        client.state(), client.position(), client.log(), client.inputs(["1", "40"])
        client.set_override(60)
    client.backup(folder)
    client.motors(False)


@pytest.fixture
def controller():
    with VirtualCr(servo_time=0.0) as controller, connect(controller.address) as client:
        client.write("SEAM", OLD.encode())
        yield controller


def talk(controller, folder, *, timeout=5.0, rounds=1, **faults):
    """One conversation through a proxy; the error that it ended with, and what passed."""
    caught = None
    with Cutting(controller.port, **faults) as proxy:
        try:
            with connect(f"melfa://127.0.0.1:{proxy.port}", timeout=timeout) as client:
                conversation(client, folder, rounds)
        except Refused as refused:
            caught = refused
        passed = proxy.passed
    released(controller)
    assert controller.text("SEAM") in (OLD, NEW)
    assert [path.name for path in folder.parent.iterdir()] in ([], [folder.name])
    return caught, passed


def released(controller):
    """Waits until the controller has seen that the line is cut."""
    end = time.monotonic() + 5
    while controller.state.right is not None or controller.state.edited:
        assert time.monotonic() < end, "the operation right is still held"
        time.sleep(0.001)


def cut_at(controller, folder, places, rounds):
    for at in places:
        caught, _ = talk(controller, folder, cut=at, reset=at % 2 == 0, rounds=rounds)
        assert isinstance(caught, Lost), f"cut after {at} bytes: {caught}"
        assert not folder.exists(), f"cut after {at} bytes: a backup that looks whole"


def test_a_line_that_is_cut_anywhere(controller, tmp_path):
    folder = tmp_path / "cell"
    caught, length = talk(controller, folder)
    assert caught is None and folder.exists()
    clear(folder)
    places = [1, 12, 24, 150, 260, *range(301, length - 300, 2503)]
    cut_at(controller, folder, places, 1)


@pytest.mark.slow
def test_a_line_that_is_cut_at_every_place(controller, tmp_path, capsys):
    folder = tmp_path / "cell"
    rounds = 10
    _, length = talk(controller, folder, rounds=rounds)
    clear(folder)
    places = [at for at in cuts(length) if at < length - 300]
    cut_at(controller, folder, places, rounds)
    with capsys.disabled():
        sys.stdout.write(
            f"\ncontroller link: {len(places)} cuts of a conversation of {length} bytes\n"
        )
    assert len(places) >= 500


def clear(folder):
    for path in sorted(folder.rglob("*"), reverse=True):
        path.unlink() if path.is_file() else path.rmdir()
    folder.rmdir()


ANSWERS = [0, 1, 2, 9]


@pytest.mark.parametrize("which", ANSWERS)
def test_an_answer_that_comes_too_late(controller, tmp_path, which):
    caught, _ = talk(controller, tmp_path / "cell", timeout=0.15, answers=late(which, 0.3))
    assert isinstance(caught, Lost) and codes(caught)[0] == "CN204"


@pytest.mark.parametrize("which", ANSWERS)
@pytest.mark.parametrize("instead", [bytes(range(256)), b"QoK\x00\xff\r", b"QeR1\r"])
def test_garbage_instead_of_an_answer(controller, tmp_path, which, instead):
    caught, _ = talk(controller, tmp_path / "cell", answers=garbage(which, instead))
    # What looks like an answer can only be told where the text of the right one is known.
    if caught is None:
        assert instead.startswith(b"QoK")
    else:
        assert set(codes(caught)) <= {"CN302", "CN310", "CN301", "CN306", "CN204"}


@pytest.mark.parametrize("which", ANSWERS)
def test_an_answer_that_comes_twice(controller, tmp_path, which):
    caught, _ = talk(controller, tmp_path / "cell", answers=twice(which))
    assert caught is None or set(codes(caught)) <= {"CN302", "CN301", "CN310", "CN306"}


# ------------------------------------------------------------------------- the operation right


def test_a_list_of_programs_that_repeats_itself_is_given_up(controller):
    """Nor is a size of thousands of digits a number."""
    said = []

    def repeat(_, data):
        if data.startswith(b"QoKTHERE."):
            said.append(data.replace(b";", b";" + b"9" * 6000, 1))
        return [(0.0, said[0] if said else data)]

    with connect(controller.address) as client:
        client.write("THERE", b"10 END\r\n")
    with (
        Cutting(controller.port, answers=repeat) as proxy,
        connect(f"melfa://127.0.0.1:{proxy.port}", timeout=5) as client,
        pytest.raises(Lost) as lost,
    ):
        client.names()
    assert codes(lost.value)[0] == "CN302"


class Keeping(socketserver.ThreadingTCPServer):
    """A controller that keeps the operation right when a line is cut, until CNTLOFF comes.

    deaf: it does not give it back either.
    """

    allow_reuse_address = True
    daemon_threads = True

    def __init__(self):
        self.held = self.deaf = False
        super().__init__(("127.0.0.1", 0), KeepingHandler)

    def __enter__(self):
        self._thread = threading.Thread(target=self.serve_forever, args=(0.02,))
        self._thread.start()
        return self

    def __exit__(self, *error):
        self.shutdown()
        self.server_close()
        self._thread.join()

    @property
    def port(self):
        return self.server_address[1]

    def answer(self, command):
        if command == "CNTLON":
            self.held = True
        elif command == "CNTLOFF":
            self.held = self.held and self.deaf
        elif command == "DSTATE":
            return f"{0xA3 if self.held else 0x23:02X}120;1;1"
        elif number := re.fullmatch(r"OVRD=(\d+)", command):
            return number[1]
        return ""


class KeepingHandler(socketserver.StreamRequestHandler):
    def handle(self):
        with contextlib.suppress(OSError):
            data = b""
            while piece := self.request.recv(1000):
                *whole, data = (data + piece).split(b"\r")
                for command in whole:
                    answer = self.server.answer(command.decode("latin-1").split(";", 2)[2])
                    self.request.sendall(f"QoK{answer}\r".encode())


def test_the_right_is_given_back_over_a_new_connection():
    with Keeping() as controller:
        with Cutting(controller.port) as proxy:
            with connect(f"melfa://127.0.0.1:{proxy.port}", timeout=2) as client:
                client.set_override(50)
            length = proxy.passed
        assert not controller.held
        for at in range(1, length, 3):
            with Cutting(controller.port, cut=at, reset=bool(at % 2)) as proxy:
                with (
                    contextlib.suppress(Lost),
                    connect(f"melfa://127.0.0.1:{proxy.port}", timeout=2) as client,
                ):
                    client.set_override(50)
                assert proxy.was_cut.is_set()
            assert not controller.held, f"cut after {at} bytes"


@pytest.mark.parametrize("deaf", [False, True])
def test_a_right_that_cannot_be_given_back_is_told(deaf):
    """There is no way back after the cut, or the controller holds on to the right."""
    with Keeping() as controller:
        controller.deaf = deaf
        sent = len("1;1;OPEN=USERTOOL\rQoK\r1;1;CNTLON\rQoK\r1;1;OV")
        with (
            Cutting(controller.port, cut=sent, again=deaf) as proxy,
            pytest.raises(Lost) as refused,
            connect(f"melfa://127.0.0.1:{proxy.port}", timeout=0.3) as client,
        ):
            client.set_override(50)
        assert codes(refused.value) == ["CN204", "CN306"]
        assert "may still be held" in refused.value.findings[-1].message
        assert controller.held

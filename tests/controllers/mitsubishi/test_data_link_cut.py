"""The data link and control mode when lines are cut after any byte, delayed, spoilt or repeated."""

import socketserver
import threading
from contextlib import contextmanager

import pytest

from assistant.controllers.mitsubishi.control_mode import ControlMode
from assistant.controllers.mitsubishi.data_link import DataLink, Form, Joints
from assistant.controllers.rules import Lost
from tests.controllers.cutting import Cutting, cuts, garbage, late, twice
from tests.controllers.mitsubishi.running import Running, samples, tcp
from tests.controllers.mitsubishi.test_control_mode import LIMITS, codes, points

FORM = Form.parse("M1 | P_CURR | J_CURR")
RECORD = b"%d|(+250.00,+0.00,+450.00,+0.00,+180.00)(6,0)|(+0.00,+21.19,+72.78,,+86.03,+0.00)\r\n"


class Program(socketserver.StreamRequestHandler):
    """Answers each line with a record, as a program with Input# and Print# does."""

    disable_nagle_algorithm = True

    def handle(self):
        buffer = b""
        while data := self.request.recv(4096):
            *lines, buffer = (buffer + data).split(b"\r")
            for line in lines:
                self.wfile.write(RECORD % int(line.split(b",")[0]))


class Server(socketserver.ThreadingTCPServer):
    allow_reuse_address = daemon_threads = True

    def handle_error(self, request, address):
        """The line is cut: nobody is there any more."""


@contextmanager
def program():
    with Server(("127.0.0.1", 0), Program) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield server.server_address[1]
        finally:
            server.shutdown()
            thread.join()


def talk(port, exchanges, timeout=5.0):
    """How many records came; each is the one that was asked for."""
    came = 0
    with DataLink(f"127.0.0.1:{port}", timeout=timeout) as link:
        for number in range(exchanges):
            link.send(number, Joints((10, 0, 90, 0, 90, 0)))
            found, place, _ = link.record(FORM)
            assert found == number and place.flags == (6, 0)
            came += 1
    return came


def cut_everywhere(exchanges, each):
    with program() as port:
        with Cutting(port) as proxy:
            assert talk(proxy.port, exchanges) == exchanges
            length = proxy.passed
        places = cuts(length)[::each]
        for place in places:
            with Cutting(port, cut=place, reset=place % 2 == 0) as proxy:
                if place == length:
                    continue
                with pytest.raises(Lost) as lost:
                    talk(proxy.port, exchanges)
                assert codes(lost)[0] in ("CN613", "CN614"), place
    return len(places)


def test_a_line_that_is_cut_after_any_byte_is_lost():
    assert cut_everywhere(10, 7) > 40


@pytest.mark.slow
def test_a_line_that_is_cut_after_any_byte_is_lost_everywhere(capsys):
    count = cut_everywhere(200, 1)
    with capsys.disabled():
        print(f"\n{count} cuts of the data link")  # noqa: T201
    assert count >= 500


SPOILT = [
    (late(2, 1.0), "CN614"),
    (garbage(2), "CN615"),
    (garbage(2, b"Qer6010\r"), "CN615"),
]


@pytest.mark.parametrize(("spoilt", "code"), SPOILT)
def test_answers_that_are_late_or_spoilt_are_found(spoilt, code):
    with (
        program() as port,
        Cutting(port, answers=spoilt) as proxy,
        pytest.raises(Lost) as lost,
    ):
        talk(proxy.port, 5, timeout=0.2)
    assert codes(lost)[0] == code


def test_an_answer_that_comes_twice_is_the_next_record():
    """Nothing in a record tells it from the next one: who asks for one has to number them."""
    with (
        program() as port,
        Cutting(port, answers=twice(2)) as proxy,
        DataLink(f"127.0.0.1:{proxy.port}", timeout=5.0) as link,
    ):
        told = []
        for number in range(5):
            link.send(number, Joints((10, 0, 90, 0, 90, 0)))
            told.append(link.record(FORM)[0])
    assert told == [0, 1, 2, 2, 3]


def controlled(cut_control=None, cut_status=None, answers=None, again=False, patience=1.0):
    """Data link control mode over lines that are cut; what it says, and how the run ended."""
    with tcp() as (com1, control), tcp() as (com2, status):
        lines = {"COM1:": com1, "COM2:": com2}
        with Running(samples("datalink"), lines, timed=True) as running:
            ports = [int(target.rpartition(":")[2]) for target in (control, status)]
            with (
                Cutting(ports[0], cut=cut_control, again=False) as one,
                Cutting(ports[1], cut=cut_status, again=again, answers=answers) as two,
            ):
                targets = [f"127.0.0.1:{proxy.port}" for proxy in (one, two)]
                links = [DataLink(target, timeout=patience) for target in targets]
                with (
                    pytest.raises(Lost) as lost,
                    ControlMode(None, *links, limits=LIMITS, silence=patience) as mode,
                ):
                    mode.follow(points(*range(0, 150, 5)))
                    raise AssertionError("it was not cut")
            waiting = "may still wait" in str(lost.value)
            return codes(lost)[0], waiting, None if waiting else running.stopped()


@pytest.mark.parametrize("place", [60, pytest.param(200, marks=pytest.mark.slow)])
def test_a_cut_control_line_stops_the_arm_at_once(place):
    assert controlled(cut_control=place)[0] == "CN614"


@pytest.mark.parametrize("place", [3, 500])
def test_a_cut_status_line_is_connected_to_again_and_all_stops(place):
    code, waiting, seconds = controlled(cut_status=place, again=True)
    assert (code, waiting) == ("CN614", False) and seconds < 4


def test_both_lines_that_are_cut_are_no_reason_to_run_on():
    code, waiting, _ = controlled(cut_control=100, cut_status=2000, again=True, patience=10.0)
    assert (code, waiting) == ("CN614", False)


SLOW = [pytest.param(place, marks=pytest.mark.slow) for place in (1, 2, 3, 9, 50, 500, 3000)]


@pytest.mark.parametrize("place", SLOW)
def test_a_status_line_that_is_gone_stops_the_arm_in_two_seconds(place):
    """Before the programs heard that somebody watches, no position was sent."""
    code, waiting, seconds = controlled(cut_status=place)
    assert code == "CN614" and waiting is (place < 100)
    assert waiting or seconds < 8


@pytest.mark.slow
def test_a_spoilt_status_line_stops_the_arm():
    code, waiting, _ = controlled(answers=garbage(20), again=True)
    assert (code, waiting) == ("CN615", False)

"""Connections that are cut, late, spoilt or answered twice: typed errors, and no half file."""

import contextlib
import json
import sys

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers.abb.exchange import PoseExchange
from assistant.controllers.abb.exchange.files import with_sum
from assistant.controllers.rules import Lost
from assistant.virtual.events import Moved
from tests.controllers.abb.cutting_ftp import CuttingFtp
from tests.controllers.abb.exchanging import RunningRobot
from tests.controllers.abb.ftp_servers import pyftpdlib
from tests.controllers.abb.sftp_server import SftpServer
from tests.controllers.cutting import Cutting, cuts, garbage, late, twice

OLD, NEW = b"MODULE old\n" * 40, b"MODULE new\n" * 50
LONG = NEW * 15
"""For a conversation that is long enough to be cut at 500 places."""
KINDS = {"CN201", "CN202", "CN203", "CN204", "CN205", "CN206", "CN211", "CN213"}
WAIT = 0.25
"""Seconds that clients wait here where an answer never comes."""


def conversation(client, new):
    """Everything that a client of files does; old.mod is there."""
    with client:
        told = {name for name in client.names() if name.isprintable()}  # garbage is none
        assert told <= {"old.mod", "~old.mod", "~poses.txt"}
        client.write("old.mod", new)
        assert client.read("old.mod") == new
        client.hand_over("poses.txt", b"1\nEND 1\n")
        found = client.look("poses.txt")
        client.take_away("poses.txt")
        return found


def tried(server, proxy, timeout=5.0, new=NEW):
    """Whether it came through; what was lost on the way is typed, and no file is half there."""
    home = getattr(server, "home", server.root)
    for left in home.iterdir():
        left.unlink(missing_ok=True)  # a server that still ends may have taken it away
    (home / "old.mod").write_bytes(OLD)
    came = False
    try:
        conversation(server.client(port=proxy.port, timeout=timeout), new)
        came = True
    except Refused as refused:
        assert {finding.code for finding in refused.findings} <= KINDS
        assert isinstance(refused, Lost) or refused.exit_status in (1, 2)
    for file in home.iterdir():
        if not file.name.startswith("~"):
            assert file.read_bytes() in (OLD, new, b"1\nEND 1\n", b""), file.name
            assert file.name != "old.mod" or file.read_bytes() in (OLD, new)
    return came


@contextlib.contextmanager
def ftp(root):
    with pyftpdlib(root) as server:
        yield server, CuttingFtp


@contextlib.contextmanager
def sftp(root):
    with SftpServer(root) as server:
        yield server, Cutting


SERVERS = {"ftp": (ftp, 89), "sftp": (sftp, 1009)}
"""Server, and each how manieth byte an ordinary run cuts at."""


@pytest.fixture(params=SERVERS)
def serving(request, tmp_path):
    root = tmp_path / "root"
    root.mkdir()
    serve, each = SERVERS[request.param]
    with serve(root) as (server, proxy):
        yield server, proxy, each


def length(server, proxy, new=NEW):
    with proxy(server.port) as whole:
        assert tried(server, whole, new=new)
    return whole.passed


def cut_at(server, proxy, places, new=NEW):
    for number, place in enumerate(places):
        with proxy(server.port, cut=place, reset=number % 2 == 1) as cutting:
            # The answer to the good-bye is no loss.
            assert not tried(server, cutting, new=new) or place > places[-1] - 60


def test_files_are_whole_wherever_the_line_is_cut(serving):
    server, proxy, each = serving
    whole = length(server, proxy)
    cut_at(server, proxy, range(1, whole - 60, each))


@pytest.mark.slow
def test_files_are_whole_at_each_byte_where_the_line_is_cut(serving, capsys):
    server, proxy, _ = serving
    whole = length(server, proxy, LONG)
    places = cuts(whole - 60)
    cut_at(server, proxy, places, LONG)
    with capsys.disabled():
        sys.stdout.write(f"\n{len(places)} cuts of a conversation of {whole} bytes\n")
    assert len(places) > 500


def spoilt(server, proxy, faults, pieces):
    for fault in faults:
        for which in pieces:
            with proxy(server.port, answers=fault(which)) as cutting:
                tried(server, cutting, timeout=WAIT)


def test_answers_that_are_late_spoilt_or_come_twice_break_nothing(serving):
    server, proxy, _ = serving
    spoilt(server, proxy, (lambda n: late(n, 1.0), garbage, twice), (2, 9))


@pytest.mark.slow
def test_any_answer_that_is_late_spoilt_or_comes_twice_breaks_nothing(serving):
    server, proxy, _ = serving
    spoilt(server, proxy, (lambda n: late(n, 1.0), garbage, twice), range(40))


def moved(robot):
    return [event for event in robot.run.events if isinstance(event, Moved)][1:]


def exchanged(tmp_path, number, **fault):
    """One pose by an exchange whose line has a fault; the robot, and what it ended as."""
    with RunningRobot(tmp_path / f"home{number}") as robot:
        exchange = None
        with CuttingFtp(robot.controller.port, **fault) as proxy:
            try:
                with robot.client(proxy.port, timeout=WAIT) as client:
                    exchange = PoseExchange(client, timeout=2.0, longest=2.0)
                    with exchange:
                        start = exchange.current_pose().pose
                        exchange.move_to(start.offset(z=5.0))
            except Refused as refused:
                codes = {finding.code for finding in refused.findings}
                assert codes <= {*KINDS, "CN512", "CN513"}
            passed = proxy.passed
    assert robot.ended() == ("end", "")
    assert len(moved(robot)) <= 1
    for file in robot.home.glob("exchange_*.txt"):
        data = file.read_bytes()
        lines = data.splitlines(keepends=True)
        ours = file.name == "exchange_claimant.txt" and json.loads(data)
        stop = file.name == "exchange_stop.txt" and lines[-1].startswith(b"END")
        assert ours or stop or data == with_sum(b"".join(lines[:-1]))
    return exchange, passed


def test_an_exchange_that_is_cut_stops_the_robot_and_moves_it_once_at_most(tmp_path):
    _, whole = exchanged(tmp_path, 0)
    places = range(whole // 3, whole, whole // 6)
    ends = [exchanged(tmp_path, cut, cut=cut)[0] for cut in places]
    # Where only a question was asked, nothing is stopped.
    told = [exchange.ended for exchange in ends if exchange is not None and exchange.ended]
    # On a busy computer more is asked, and the cut may fall into the stop itself, which tells so.
    stopped = [ended for ended in told if "exchange_stop.txt" not in ended]
    assert len(told) > 1 and stopped and all("stands still" in ended for ended in stopped)


def test_an_exchange_whose_line_stays_cut_says_that_the_robot_may_move(tmp_path):
    exchange, _ = exchanged(tmp_path, 1, cut=2500, again=False)
    assert "may still move" in exchange.ended


@pytest.mark.slow
def test_an_exchange_is_cut_at_each_byte(tmp_path, capsys):
    _, whole = exchanged(tmp_path, 0)
    places = cuts(whole, then=(whole - 300) // 200)
    for cut in places:
        exchanged(tmp_path, cut, cut=cut, reset=cut % 2 == 1)
    with capsys.disabled():
        sys.stdout.write(f"\n{len(places)} cuts of a conversation of {whole} bytes\n")
    assert len(places) >= 500


@pytest.mark.slow
@pytest.mark.parametrize(
    "fault", [lambda n: late(n, 1.0), garbage, twice], ids=["late", "garbage", "twice"]
)
def test_an_exchange_with_an_answer_that_is_late_spoilt_or_comes_twice(tmp_path, fault):
    for which in range(40):
        exchanged(tmp_path, which, answers=fault(which))

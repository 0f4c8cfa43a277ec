"""Poses exchanged with the printed RAPID module, which the interpreter runs, over a file server."""

import csv
import json
import math
import socket
import subprocess
import sys
import threading
from contextlib import contextmanager, suppress

import numpy as np
import pytest

from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.controllers import connect
from assistant.controllers.abb.exchange import Module, PoseExchange, files
from assistant.controllers.rules import Lost
from assistant.program.geometry import Pose
from assistant.program.motion import Kind, Path, Speed
from tests.controllers.abb.exchanging import POSES, RunningRobot, moves, targets
from tests.controllers.abb.sftp_server import SftpServer


def codes(refused):
    return [finding.code for finding in refused.value.findings]


@pytest.fixture
def robot(tmp_path):
    with RunningRobot(tmp_path / "home") as robot:
        yield robot


@pytest.fixture
def programs(robot):
    with robot.client() as programs:
        yield programs


@pytest.fixture
def exchange(programs):
    with PoseExchange(programs) as exchange:
        yield exchange


def test_35_poses_are_followed_and_each_is_answered_with_where_the_robot_stands(robot, programs):
    told = []
    with PoseExchange(programs) as exchange:
        positions, quaternions = targets(exchange.current_pose().pose)
        path = Path.of("way", positions, quaternions, speeds=[Speed(150.0)])
        recording = exchange.follow(path, progress=lambda done, of, answer: told.append((done, of)))
        exchange.stop()
    assert told == [(i + 1, POSES) for i in range(POSES)]
    assert np.abs(recording.column("position")[-POSES:] - positions).max() < 0.001
    angles = rotations.angle_between(recording.column("quaternion")[-POSES:], quaternions)
    assert angles.max() < 0.001
    assert robot.ended() == ("end", "")
    assert [(m.kind, m.speed, m.blend) for m in moves(robot)] == [("linear", 150.0, 0.0)] * POSES
    assert list(robot.home.iterdir()) == []


def test_poses_on_the_way_go_through_the_zone(robot, programs):
    with PoseExchange(programs) as exchange:
        positions, quaternions = targets(exchange.current_pose().pose, 6)
        exchange.follow((positions, quaternions), through=True)
        exchange.move_to(Pose.of(positions[-1], quaternions[-1]))
        exchange.stop()
    robot.ended()
    assert [move.blend for move in moves(robot)] == [100.0] * 6 + [0.0]


def test_a_pose_is_answered_with_its_motion_and_where_the_time_went(exchange):
    start = exchange.current_pose()
    answer = exchange.move_to(start.pose.offset(z=15.0), configuration=start.configuration)
    assert answer.pose.position == pytest.approx(start.pose.offset(z=15.0).position, abs=0.001)
    assert answer.configuration == start.configuration
    assert answer.motion > 0.1 and np.isnan(answer.external).all()
    spent = exchange.spent
    assert spent.looks >= 1 and spent.motion == answer.motion
    assert spent.round_trip == spent.hand_over + spent.waiting + spent.fetching > 0.0


@pytest.mark.parametrize(
    ("offset", "configuration", "reason"),
    [
        ((5000.0, 0.0, 0.0), None, "outside of its reach"),
        ((0.0, 20.0, 0.0), (3, 0, 0, 0), "limits"),
    ],
)
def test_what_is_out_of_reach_is_answered_and_the_exchange_goes_on(
    robot, programs, offset, configuration, reason
):
    with PoseExchange(programs) as exchange:
        start = exchange.current_pose()
        far = Pose.of(np.add(start.pose.position, offset), start.pose.quaternion)
        with pytest.raises(Refused) as refused:
            exchange.move_to(far, configuration=configuration)
        assert codes(refused) == ["CN513"] and reason in str(refused.value)
        assert exchange.move_to(start.pose).pose.position == pytest.approx(start.pose.position)
        exchange.stop()
    robot.ended()
    assert len(moves(robot)) == 1


NO_POSES = [
    ((np.nan, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)),
    ((1.0, np.inf, 0.0), (1.0, 0.0, 0.0, 0.0)),
    ((1.0, 2.0, 1e9), (1.0, 0.0, 0.0, 0.0)),
    ((1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 0.0)),
    ((1.0, 2.0, 3.0), (0.9, 0.0, 0.0, 0.0)),
    ((1.0, 2.0, 3.0), (np.nan, 0.0, 0.0, 0.0)),
]


def test_poses_that_are_none_are_never_sent(robot, programs):
    with PoseExchange(programs) as exchange:
        start = exchange.current_pose().pose
        for position, quaternion in NO_POSES:
            with pytest.raises(Refused) as refused:
                exchange.move_to(Pose.of(position, quaternion))
            assert codes(refused) == ["CN511"]
            both = ([start.position, position], [start.quaternion, quaternion])
            with pytest.raises(Refused) as refused:
                exchange.follow(both)
            assert codes(refused) == ["CN511"] and "pose 2" in str(refused.value)
        exchange.stop()
    robot.ended()
    assert moves(robot) == []


def test_columns_that_are_none_are_never_sent(robot, programs):
    ragged, words, flat = [[1, 2, 3], [1, 2]], ["1,5"], [1, 2, 3]
    with PoseExchange(programs) as exchange:
        here = exchange.current_pose().pose
        for places in (ragged, words, flat, [[10**400, 0, 0]]):
            with pytest.raises(Refused) as refused:
                exchange.follow((places, [here.quaternion]))
            assert codes(refused) in (["CN511"], ["TB444"])
        for configuration in [(0, 0), (0, 0, math.nan, 0), (0, 0, 0, 10**400), ("0", 0, 0, 0)]:
            with pytest.raises(Refused) as refused:
                exchange.move_to(here.offset(z=5.0), configuration=configuration)
            assert codes(refused) == ["CN511"]
        exchange.stop()
    robot.ended()
    assert moves(robot) == []


@pytest.mark.parametrize("word", ["ok", "incomplete"])
def test_an_old_answer_to_nobody_is_not_taken_for_a_new_one(robot, programs, word):
    rows = "[1,2,3]\n[1,0,0,0]\n[0,0,0,0]\n[9E9,9E9,9E9,9E9,9E9,9E9]\n0"
    (robot.home / "exchange_answer.txt").write_text(f"0\n{word}\n{rows}\nEND 0")
    with PoseExchange(programs) as exchange:
        assert exchange.current_pose().pose.position == pytest.approx((420.0, 60.0, 400.0))


def test_a_request_that_is_refused_half_way_is_taken_back(robot, programs):
    """A folder of its name: the request stands in its place already when that is refused."""
    with PoseExchange(programs) as exchange:
        here = exchange.current_pose().pose
        (robot.home / "exchange_request.txt").mkdir()
        with pytest.raises(Refused):
            exchange.move_to(here.offset(z=5.0))
        assert not (robot.home / "exchange_request.txt").is_file()


def test_a_check_is_asked_before_anything_is_sent(robot, programs):
    def check(positions, quaternions):
        assert quaternions.shape == (len(positions), 4)
        return {int(row): "it is too low" for row in np.flatnonzero(positions[:, 2] < 370.0)}

    with PoseExchange(programs, check=check) as exchange:
        ways = targets(exchange.current_pose().pose)
        with pytest.raises(Refused) as refused:
            exchange.follow(ways)
        assert codes(refused) == ["CN511"] and "too low" in str(refused.value)
        arc = Path.of("arc", *ways, kinds=[Kind.VIA, Kind.END] * 17 + [0], speeds=[Speed(1.0)])
        with pytest.raises(Refused) as refused:
            exchange.follow(arc)
        assert "arc" in str(refused.value)
        with pytest.raises(Refused) as refused:
            exchange.follow(ways, configurations=[(0, 0, 0, 0)])
        assert codes(refused) == ["CN511"]
        exchange.stop()
    robot.ended()
    assert moves(robot) == []


def ask(robot, text, checked=True):
    """Puts a request there by hand and gives the lines of the answer."""
    arriving = robot.home / "arriving"
    arriving.write_bytes(files.with_sum(text.encode()) if checked else text.encode())
    arriving.rename(robot.home / "exchange_request.txt")
    answer = robot.home / "exchange_answer.txt"
    for _ in range(2000):
        if answer.exists():
            lines = answer.read_text().splitlines()
            answer.unlink()
            return lines
        threading.Event().wait(0.005)
    raise AssertionError("no answer")


def test_what_the_robot_answers_to_requests_of_any_kind(robot):
    here = ask(robot, "100\nwhere\n\n\n\nEND 100\n")
    assert here[:2] == ["100", "ok"] and here[-2] == "END 100"
    assert files.parse_answer("".join(f"{line}\n" for line in here).encode()).checked
    assert ask(robot, "101\nwhere\n\n\n\nEND 101\n", checked=False)[:2] == ["0", "unchecked"]
    place, turn, configuration = here[2:5]
    assert place == "[420,60,400]" and configuration == "[0,0,0,0]"

    def move(number, place=place, turn=turn, configuration=configuration, word="move", end=None):
        lines = [number, word, place, turn, configuration, end or f"END {number}"]
        return ask(robot, "".join(f"{line}\n" for line in lines))[:2]

    there = "[420,70,400]"
    assert move("102", there) == ["102", "number"]
    assert move("101", there) == ["101", "ok"]
    assert move("101", there) == ["101", "ok"]
    assert move("100", there) == ["100", "number"]
    here = ask(robot, "200\nwhere\n\n\n\nEND 200\n")
    assert here[2] == there
    bad = (("[1,2]", turn), ("", turn), (there, "[0,0,0,0]"), (there, "[1,1,0,0]"))
    for number, pose in enumerate(bad, 201):
        assert move(str(number), *pose) == [str(number), "unreadable"]
    assert move("205", there, turn, "[x]") == ["205", "unreadable"]
    assert move("206", word="jump") == ["206", "unknown"]
    assert move("207", end="END 20") == ["0", "incomplete"]
    assert move("x") == ["0", "incomplete"]
    assert ask(robot, "208\nmove\n")[:2] == ["0", "incomplete"]
    assert ask(robot, "", checked=False)[:2] == ["0", "incomplete"]
    assert ask(robot, "9" * 300 + "\n")[:2] == ["0", "incomplete"]
    assert ask(robot, "208\nmove\n[420,75,400]\n[0,0,1,0]\n\nEND 208\nSUM 1 1\n", False)[1] == (
        "incomplete"
    )
    (robot.home / "exchange_stop.txt").write_text("7\nEND 7\n")
    assert robot.ended() == ("end", "")
    assert len(moves(robot)) == 1
    lines = (robot.home / "exchange_stopped.txt").read_text().splitlines()
    assert lines[:2] == ["7", "stopped"] and lines[-2] == "END 7"


def test_an_old_answer_is_not_taken_for_a_new_one(tmp_path):
    with RunningRobot(tmp_path / "home", begins=False) as robot:
        old = files.request_file(5, "where")
        (robot.home / "exchange_answer.txt").write_bytes(old)
        with (
            robot.client() as programs,
            pytest.raises(Refused) as refused,
            PoseExchange(programs, timeout=0.2),
        ):
            pass
        assert codes(refused) == ["CN512"] and "removed" in str(refused.value)
        assert [file.name for file in robot.home.iterdir()] == ["exchange_answer.txt"]


def test_requests_that_were_left_are_not_carried_out_by_a_program_that_starts(tmp_path):
    with RunningRobot(tmp_path / "home", begins=False) as robot:
        pose = Pose((420.0, 90.0, 400.0), (0.0, 0.0, 1.0, 0.0))
        (robot.home / "exchange_request.txt").write_bytes(files.request_file(1, "move", pose))
        robot.begin()
        with robot.client() as programs, PoseExchange(programs) as exchange:
            assert exchange.current_pose().pose.position == pytest.approx((420.0, 60.0, 400.0))
            exchange.stop()
        robot.ended()
        assert moves(robot) == []


def test_a_second_exchange_is_refused_while_the_first_goes_on(robot, programs):
    with PoseExchange(programs) as first:
        start = first.current_pose().pose
        with robot.client() as others:
            second = PoseExchange(others)
            for use in (second.__enter__, second.current_pose, lambda: second.move_to(start)):
                with pytest.raises(Refused) as refused:
                    use()
                assert codes(refused) == ["CN519"]
        assert first.move_to(start.offset(z=5.0)).pose.position[2] == pytest.approx(395.0)
    with robot.client() as others, PoseExchange(others) as second:
        second.current_pose()


def test_a_claim_of_a_process_that_has_died_is_taken_over(robot, programs):
    PoseExchange(programs)._claim.take()
    claimant = robot.home / "exchange_claimant.txt"
    content = json.loads(claimant.read_text())
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    for machine, busy in (("elsewhere", True), (content["machine"], False)):
        claimant.write_text(json.dumps(content | {"process": ended.pid, "machine": machine}))
        with robot.client() as others, suppressed(Refused) as met, PoseExchange(others):
            pass
        assert [code for error in met for code in codes_of(error)] == ["CN519"] * busy
    assert not claimant.exists()


@contextmanager
def suppressed(kind):
    """The errors of a kind that were met, none of which goes on."""
    met = []
    try:
        yield met
    except kind as error:
        met.append(error)


def codes_of(error):
    return [finding.code for finding in error.findings]


def handing_over(programs, change):
    """Another writer into the folder, or a damaged transfer: what a request becomes, None: gone."""
    hand_over = programs.hand_over

    def changed(name, data):
        data = change(data) if b"move" in data else data
        if data is not None:
            hand_over(name, data)

    programs.hand_over = changed


@pytest.mark.parametrize("changed", [(b"[420.0", b"[435.0"), (b"1.000000000", b"0.100000000")])
def test_a_request_that_is_changed_on_the_disk_moves_nothing(robot, programs, changed):
    handing_over(programs, lambda data: data.replace(*changed))
    with pytest.raises(Refused) as refused, PoseExchange(programs) as exchange:
        exchange.move_to(exchange.current_pose().pose.offset(z=5.0))
    assert codes(refused) == ["CN513"] and "other text" in str(refused.value)
    assert robot.ended() == ("end", "")
    assert moves(robot) == []


def test_a_request_that_somebody_else_removed_was_not_taken_by_the_robot(robot, programs):
    handing_over(programs, lambda _: None)
    exchange = PoseExchange(programs, timeout=1.0, longest=600.0)
    with pytest.raises(Refused) as refused, exchange:
        exchange.move_to(exchange.current_pose().pose.offset(z=5.0))
    assert codes(refused) == ["CN512"] and "something else may have" in str(refused.value)
    assert robot.ended() == ("end", "") and moves(robot) == []


class OldModule:
    """A robot whose module was written before there were checksums.

    goes: where it is after a motion, None if it never arrives. tail: what follows END.
    """

    def __init__(self, home, goes, tail=""):
        self.home, self.goes, self.tail = home, goes, tail
        self.over = threading.Event()
        self.thread = threading.Thread(target=self._runs, daemon=True)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *error):
        self.over.set()
        self.thread.join(20)

    def _runs(self):
        stands = ["[420,60,400]", "[0,0,1,0]", "[0,0,0,0]"]
        request, stop = (self.home / f"exchange_{file}.txt" for file in ("request", "stop"))
        while not self.over.wait(0.002):
            with suppress(OSError):
                lines = stop.read_text().splitlines()
                stop.unlink()
                self._answer("stopped", [lines[0], "stopped", *off()])
            with suppress(OSError):
                number, word = request.read_text().splitlines()[:2]
                request.unlink()
                stands = self.goes if word == "move" else stands
                if stands is not None:
                    self._answer("answer", [number, "ok", *stands])

    def _answer(self, file, lines):
        lines = [*lines, "[9E9,9E9,9E9,9E9,9E9,9E9]", "0.5", f"END {lines[0]}"]
        half = self.home / "half"
        half.write_text("".join(f"{line}\n" for line in lines) + self.tail)
        half.replace(self.home / f"exchange_{file}.txt")


def off(position="[420,60,405]", quaternion="[0,0,1,0]", configuration="[0,0,0,0]"):
    return position, quaternion, configuration


@pytest.mark.parametrize(
    ("goes", "configuration", "tail", "code"),
    [
        (off(), None, "", None),
        (off("[435,60,405]"), None, "", "CN517"),
        (off(quaternion="[0,0,0.99939,0.0349]"), None, "", "CN517"),
        (off(), (0, 0, 0, 0), "", None),
        (off(configuration="[0,-1,0,0]"), (0, 0, 0, 0), "", None),
        (off(configuration="[0,2,0,0]"), (0, 0, 0, 0), "", "CN517"),
        (off(), None, "SUM 12 3\n", "CN521"),
    ],
    ids=str,
)
def test_the_pose_of_an_answer_is_compared_with_that_of_the_request(
    tmp_path, goes, configuration, tail, code
):
    with (
        RunningRobot(tmp_path / "home", begins=False) as robot,
        robot.client() as programs,
        OldModule(robot.home, goes, tail),
        suppressed(Refused) as met,
        PoseExchange(programs, timeout=5.0) as exchange,
    ):
        assert exchange.checked is False
        there = Pose((420.0, 60.0, 405.0), (0.0, 0.0, 1.0, 0.0))
        exchange.move_to(there, configuration=configuration)
    assert [each for error in met for each in codes_of(error)] == ([code] if code else [])


def test_a_stop_by_another_process_ends_the_claim_and_the_exchange(tmp_path):
    with (
        RunningRobot(tmp_path / "home", begins=False) as robot,
        robot.client() as programs,
        robot.client() as others,
        OldModule(robot.home, None),
        pytest.raises(Refused) as it,
        PoseExchange(programs, timeout=1.0, longest=600.0) as exchange,
    ):
        start = exchange.current_pose().pose
        assert PoseExchange(others, timeout=5.0).stop() is not None
        assert not (robot.home / "exchange_claim").exists()
        exchange.move_to(start.offset(x=-200.0))
    assert codes(it) == ["CN520"]


@pytest.mark.parametrize(
    "error", [KeyboardInterrupt, pytest.param(RuntimeError, marks=pytest.mark.slow)]
)
def test_an_interrupt_stops_the_robot_on_its_way(tmp_path, error):
    with RunningRobot(tmp_path / "home", pace=0.25) as robot, robot.client() as programs:
        exchange = PoseExchange(programs)
        going = threading.Event()

        def interrupt(positions, quaternions):
            threading.Timer(0.2, going.set).start()
            return {}

        with pytest.raises(error), exchange:
            start = exchange.current_pose().pose
            look = exchange._look

            def looked(file):
                if going.is_set() and file == "answer":
                    going.clear()
                    raise error
                return look(file)

            exchange._check, exchange._look = interrupt, looked
            exchange.move_to(start.offset(x=-200.0))
        assert exchange.ended == "the robot stands still, and its program has ended"
        way = np.linalg.norm(np.subtract(exchange.stopped.pose.position, start.position))
        assert 0.0 < way < 190.0
        with pytest.raises(Refused) as refused:
            exchange.current_pose()
        assert codes(refused) == ["CN514"]
        assert robot.ended() == ("end", "")


def test_poses_are_exchanged_over_sftp(tmp_path):
    with RunningRobot(tmp_path / "home") as robot, SftpServer(robot.home) as server:
        exchanged(robot, server.client())


def test_poses_are_exchanged_over_robot_web_services(tmp_path):
    """A client that has no shorter way for small files than any that keeps programs."""
    with RunningRobot(tmp_path / "home", rws=0) as robot:
        controller = robot.controller
        exchanged(robot, connect(controller.rws_address, password=controller.password))


def exchanged(robot, client):
    with client, PoseExchange(client) as exchange:
        start = exchange.current_pose().pose
        there = exchange.move_to(start.offset(z=5.0)).pose
        assert there.position == pytest.approx(start.offset(z=5.0).position, abs=1e-3)
        exchange.stop()
    assert robot.ended() == ("end", "") and list(robot.home.iterdir()) == []


def test_a_motion_that_takes_too_long_is_stopped(tmp_path):
    with RunningRobot(tmp_path / "home", pace=1.0) as robot, robot.client() as programs:
        exchange = PoseExchange(programs, longest=0.3)
        with pytest.raises(Refused) as refused, exchange:
            exchange.move_to(exchange.current_pose().pose.offset(x=-200.0))
        assert codes(refused) == ["CN512"] and "it was taken" in str(refused.value)
        assert refused.value.__notes__ == ["the robot stands still, and its program has ended"]
        assert robot.ended() == ("end", "")


def test_a_stop_that_nobody_answers_says_so(tmp_path):
    with RunningRobot(tmp_path / "home", begins=False) as robot, robot.client() as programs:
        exchange = PoseExchange(programs, timeout=0.2)
        assert exchange.stop() is None and "may still move" in exchange.ended
        assert list(robot.home.iterdir()) == []


def test_a_program_that_nobody_asks_ends(tmp_path):
    with RunningRobot(tmp_path / "home", Module(longest=1.0, tool_data=None)) as robot:
        pass
    assert robot.ended()[0] == "end"


def test_a_connection_that_is_lost_is_found_and_the_robot_stopped(robot, programs):
    with pytest.raises(Lost) as lost, PoseExchange(programs) as exchange:
        programs._ftp.sock.shutdown(socket.SHUT_RDWR)
        exchange.current_pose()
    assert codes(lost) == ["CN204"]
    assert exchange.ended == "the robot stands still, and its program has ended"
    assert lost.value.__notes__ == [exchange.ended]


def test_recordings_are_tables_with_units(exchange, tmp_path):
    start = exchange.current_pose().pose
    exchange.move_to(start.offset(z=5.0))
    table, arrays = tmp_path / "poses.csv", tmp_path / "poses.npz"
    exchange.recording.save(table)
    exchange.recording.save(arrays)
    rows = list(csv.DictReader(table.read_text().splitlines()))
    assert len(rows) == len(exchange.recording) == 3
    assert rows[0]["asked_position.x"] == ""
    assert float(rows[2]["asked_position.z"]) == pytest.approx(395.0)
    assert float(rows[2]["position.z"]) == pytest.approx(395.0, abs=1e-3)
    columns = np.load(arrays)
    assert np.isnan(columns["asked_quaternion"][:2]).all()
    assert (np.diff(columns["seconds"]) > 0.0).all() and (columns["motion"][2] > 0.0)


def test_a_folder_in_the_place_of_the_answer_ends_nothing(robot, programs):
    """The program takes what comes next, and answers again once the folder is gone."""
    in_the_way, request = (robot.home / f"exchange_{file}.txt" for file in ("answer", "request"))
    with PoseExchange(programs) as exchange:
        exchange.current_pose()
        in_the_way.mkdir()
        for number in (101, 102):
            half = robot.home / "half"
            half.write_bytes(files.request_file(number, "where"))
            half.replace(request)
            while request.exists() and robot.thread.is_alive():
                threading.Event().wait(0.005)
            assert robot.thread.is_alive(), robot.run
        in_the_way.rmdir()
        exchange.current_pose()

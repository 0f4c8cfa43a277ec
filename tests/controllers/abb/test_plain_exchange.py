"""Poses exchanged by plain files, with the sample that the interpreter runs, over file servers."""

import threading
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from assistant import languages
from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.controllers import connect
from assistant.controllers.abb.exchange import Module, PlainExchange, PlainFiles, Tool
from assistant.controllers.abb.exchange.protocols import parse_plain_answer
from assistant.program.geometry import Pose
from assistant.virtual.irc5 import VirtualIrc5
from tests.controllers.abb import ftp_servers
from tests.controllers.abb.exchanging import POSES, PlainRobot, moves, targets

SAMPLE = Path(__file__).parents[3] / "samples" / "rapid" / "plain_exchange.mod"
START = Pose((420.0, 60.0, 400.0), (0.0, 0.0, 1.0, 0.0))


def codes(refused):
    return [finding.code for finding in refused.value.findings]


@contextmanager
def virtual(folder):
    with (
        VirtualIrc5(folder, rws=None, rwss=None) as controller,
        connect(controller.address, password=controller.password, timeout=5.0) as programs,
    ):
        yield controller.folder, programs


@contextmanager
def proftpd(folder):
    folder.mkdir()
    with ftp_servers.proftpd(folder) as server, server.client(timeout=5.0) as programs:
        yield server.home, programs


@pytest.fixture
def served(tmp_path):
    with virtual(tmp_path / "home") as there:
        yield there


@pytest.fixture
def robot(served):
    with PlainRobot(served[0]) as robot:
        yield robot


@pytest.mark.parametrize("server", [pytest.param(virtual, marks=pytest.mark.slow), proftpd])
def test_35_poses_go_as_plain_files_and_come_back(tmp_path, tell, server):
    with server(tmp_path / "root") as (home, programs):
        with PlainRobot(home, SAMPLE.read_text()) as robot:
            with PlainExchange(programs) as exchange:
                start = exchange.current_pose()
                positions, quaternions = targets(start.pose)
                recording = exchange.follow(
                    (positions, quaternions), configurations=[start.configuration] * POSES
                )
            assert robot.end() == ("end", "")
        assert list(home.iterdir()) == []
    assert np.abs(recording.column("position")[-POSES:] - positions).max() < 0.001
    angles = rotations.angle_between(recording.column("quaternion")[-POSES:], quaternions)
    assert angles.max() < 0.001
    assert [(move.kind, move.speed) for move in moves(robot)] == [("linear", 150.0)] * POSES
    seconds = recording.column("round_trip")[-POSES:]
    tell(f"{server.__name__}: {seconds.mean():.3f} s a pose, {seconds.max():.3f} s at most")


def test_the_sample_is_what_the_command_writes_and_has_no_finding():
    tool = Tool((0.0, 0.0, 118.0), mass=0.9, centre=(0.0, 0.0, 52.0))
    module = Module(module="MainModule", tool="GRIPPER", tool_data=tool, plain=PlainFiles())
    assert SAMPLE.read_text() == module.text()
    rapid = languages.get("rapid")
    tree = rapid.parse(module.text())
    assert [*tree.findings, *rapid.check([tree])] == []
    waits = "IsFile(string1) AND IsFile(string2) AND IsFile(string3)\\MaxTime:=240;"
    assert f"WaitUntil {waits}" in module.text()


def test_other_names_and_folders_are_those_of_both_sides(tmp_path):
    files = PlainFiles(("p.txt", "q.txt", "c.txt"), ("now_p.txt", "now_q.txt", "now_c.txt"))
    text = Module(tool="GRIPPER", tool_data=Tool((0.0, 0.0, 118.0)), plain=files).text()
    text = text.replace("HOME:/", "HOME:/poses/")
    with VirtualIrc5(tmp_path / "home", rws=None, rwss=None) as controller:
        (controller.folder / "poses").mkdir()
        address = f"{controller.address}/HOME:/poses"
        with (
            PlainRobot(controller.folder, text, files=files, folder="poses") as robot,
            connect(address, password=controller.password) as programs,
        ):
            with PlainExchange(programs, files=files) as exchange:
                answer = exchange.move_to(START.offset(z=5.0))
            assert answer.pose.position == pytest.approx((420.0, 60.0, 395.0), abs=0.001)
            assert robot.end() == ("end", "")


@pytest.mark.parametrize(
    "names",
    [
        ("position.mod", "q.txt", "c.txt"), ("a b", "q.txt", "c.txt"), ("p", "P", "c"),
        ("../p", "q", "c"), ('p"', "q", "c"), ("selfposition.txt", "q", "c"), ("p.new", "q", "c"),
        ("p" * 33, "q", "c"), ("p", "q"),
    ],
)  # fmt: skip
def test_names_that_files_must_not_have(names):
    with pytest.raises(Refused) as refused:
        PlainFiles(names)
    assert codes(refused) == ["CN515"]


@pytest.mark.parametrize(
    ("row", "read"),
    [
        ("[420,60,400]", True),
        ("420 60 400", True),
        ("[420, 60.5,4e2]", True),
        ("[[420,60,400]]", False),
        ("][420,60,400][", False),
        ("[420,,60,400]", False),
        ("420,5 60 400", False),
        ("420,60,400", False),
        ("[420;60;400]", False),
    ],
)
def test_an_answer_is_a_row_or_nothing(row, read):
    texts = [f"{row}\n".encode(), b"[0,0,1,0]\n", b"[0,0,0,0]\n"]
    answer = parse_plain_answer(1, texts)
    assert (answer is not None) == read
    if answer is not None:
        assert answer.pose.position[0] == 420.0


def test_files_of_before_are_never_carried_out_nor_taken_for_an_answer(served):
    home, programs = served
    old = {"position": "[420,90,400]", "orientation": "[0,0,1,0]", "configuration": "[0,0,0,0]"}
    for name, row in old.items():
        (home / f"{name}.txt").write_text(f"{row}\n")
        (home / f"self{name}.txt").write_text(f"{row}\n")
    with PlainRobot(home, begins=False) as robot:
        with pytest.raises(Refused) as refused:
            PlainExchange(programs, timeout=0.2).current_pose()
        assert codes(refused) == ["CN512"] and "has been removed" in str(refused.value)
        assert list(home.iterdir()) == []
        for name, row in old.items():
            (home / f"{name}.txt").write_text(f"{row}\n")
        robot.begin()
        for name, row in old.items():
            (home / f"self{name}.txt").write_text(f"{row}\n")
        with PlainExchange(programs) as exchange:
            assert exchange.current_pose().pose.position == pytest.approx((420.0, 60.0, 400.0))
        robot.end()
        assert moves(robot) == []


def test_an_answer_to_an_earlier_question_is_left_alone(served):
    """It comes while the new question still lies there; the program takes that afterwards."""
    home, programs = served
    rows = {"position": "[1,2,3]", "orientation": "[1,0,0,0]", "configuration": "[0,0,0,0]"}
    answers = {"position": "[7,8,9]", "orientation": "[0,0,1,0]", "configuration": "[0,-1,0,1]"}

    def robot():
        question = home / "position.txt"
        for _ in range(2000):
            if question.exists():
                break
            threading.Event().wait(0.005)
        for name, row in rows.items():
            (home / f"self{name}.txt").write_text(f"{row}\n")
        threading.Event().wait(0.1)
        for name in rows:
            (home / f"self{name}.txt").unlink()
        for name in rows:
            (home / f"{name}.txt").unlink()
        for name, row in answers.items():  # written in pieces, under its name
            with (home / f"self{name}.txt").open("w") as file:
                file.write(row[:4])
                file.flush()
                threading.Event().wait(0.03)
                file.write(f"{row[4:]}\n")

    thread = threading.Thread(target=robot, daemon=True)
    thread.start()
    answer = PlainExchange(programs).current_pose()
    thread.join(10)
    assert answer.pose.position == (7.0, 8.0, 9.0)
    assert answer.configuration == (0, -1, 0, 1)


def test_numbers_in_lines_are_an_answer_too(served):
    """A program may write one register at a time."""
    home, programs = served

    def robot():
        question = home / "position.txt"
        for _ in range(2000):
            if question.exists():
                break
            threading.Event().wait(0.005)
        (home / "selfposition.txt").write_text("1.5\n2\n-3\n")
        (home / "selforientation.txt").write_text("0.5 0.5 0.5 0.5\n")
        (home / "selfconfiguration.txt").write_text("0\n-1\n0\n4\n")
        question.unlink()

    thread = threading.Thread(target=robot, daemon=True)
    thread.start()
    answer = PlainExchange(programs).current_pose()
    thread.join(10)
    assert (answer.pose.position, answer.configuration) == ((1.5, 2.0, -3.0), (0, -1, 0, 4))


def test_a_pose_that_cannot_be_read_moves_nothing(robot, served):
    _, programs = served
    with PlainExchange(programs) as exchange:
        put = exchange._files.put
        exchange._files.put = lambda name, text: put(name, text.replace(b"[", b"("))
        with pytest.raises(Refused) as refused:
            exchange.move_to(START.offset(z=20.0))
        assert codes(refused) == ["CN517"]
    robot.end()
    assert moves(robot) == []


def test_what_must_not_be_sent_is_not(robot, served):
    _, programs = served
    with PlainExchange(programs, check=lambda p, q: {0: "it is too low"}) as exchange:
        for act in (
            lambda: exchange.move_to(START),
            lambda: exchange.move_to(Pose((np.nan, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))),
        ):
            with pytest.raises(Refused) as refused:
                act()
            assert codes(refused) == ["CN511"]
    exchange = PlainExchange(programs)
    with pytest.raises(Refused) as refused:
        exchange.move_to(START, through=True)
    assert codes(refused) == ["CN209"]
    with pytest.raises(Refused) as refused:
        exchange.move_to(START, configuration=(0, 0))
    assert codes(refused) == ["CN511"]
    robot.end()
    assert moves(robot) == []


def test_two_pcs_do_not_exchange_poses_at_once(robot, served):
    home, programs = served
    with PlainExchange(programs):
        claim = home / "exchange_claim"
        assert claim.is_dir()
        with pytest.raises(Refused) as refused:
            PlainExchange(programs).current_pose()
        assert codes(refused) == ["CN519"]
    assert not claim.exists()


def test_an_old_file_that_stays_is_refused(served):
    home, programs = served
    (home / "selfposition.txt").mkdir()
    (home / "selfposition.txt" / "inside").touch()
    with pytest.raises(Refused):
        PlainExchange(programs, timeout=0.2).current_pose()
    assert not (home / "position.txt").exists()


def test_an_exchange_that_breaks_off_takes_its_question_back_or_says_that_the_arm_may_move(served):
    home, programs = served
    with PlainRobot(home) as robot:
        with pytest.raises(KeyboardInterrupt), PlainExchange(programs) as exchange:
            raise KeyboardInterrupt
        assert exchange.stands and "no pose is under way" in exchange.ended
        with pytest.raises(KeyboardInterrupt), PlainExchange(programs) as exchange:
            remove = exchange._there
            seen = []

            def there():
                seen.append(remove())
                if len(seen) > 1 and "position.txt" not in seen[-1]:
                    raise KeyboardInterrupt
                return seen[-1]

            exchange._there = there
            exchange.move_to(START.offset(z=30.0))
        assert not exchange.stands and "may still move" in exchange.ended
        with pytest.raises(Refused) as refused:
            exchange.current_pose()
        assert codes(refused) == ["CN514"]
        robot.end()
    assert len(moves(robot)) == 1


def test_a_session_that_operates_the_controller_stops_its_programs(tmp_path):
    with VirtualIrc5(tmp_path / "home", password="secret", rwss=None) as controller:
        home = controller.folder
        with connect(controller.rws_address, password="secret") as programs:
            with (
                pytest.raises(KeyboardInterrupt),
                PlainRobot(home) as robot,
                PlainExchange(programs) as exchange,
            ):
                exchange.move_to(START.offset(z=5.0))
                raise KeyboardInterrupt
            assert exchange.ended == "the programs of the controller were stopped"
            assert len(moves(robot)) == 1


def test_a_program_that_nobody_sends_a_pose_ends(tmp_path):
    text = SAMPLE.read_text().replace(":=240", ":=0.05")
    with PlainRobot(tmp_path, text) as robot:
        robot.thread.join(20)
    assert (robot.run.ended, robot.run.message) == ("end", "")

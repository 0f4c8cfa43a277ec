"""Poses sent to a running RAPID program as files, over the FTP server of its virtual controller."""

from __future__ import annotations

import ftplib
import io
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from assistant import languages, robots
from assistant.base import rotations
from assistant.virtual.events import Run
from assistant.virtual.irc5 import VirtualIrc5
from assistant.virtual.kernel.timed_arm import Timed
from assistant.virtual.rapid import TaskProgram, run_tasks
from assistant.virtual.rapid.controller import Controller
from assistant.virtual.rapid.disk import Disk

SAMPLES = Path(__file__).parents[2] / "samples" / "rapid"
POSES = 35
TRIES = 5000
"""How often the client looks for an answer, 2 ms apart, before it gives up."""
STEP = float(np.hypot(120.0, 40.0)) / POSES
"""mm from one pose to the next."""
Rows = list[list[float]]


class Client:
    """A PC that puts files into HOME: and fetches others. sent: names, in the order of sending."""

    def __init__(
        self, controller: VirtualIrc5, sent: Sequence[str], answers: Sequence[str]
    ) -> None:
        self.ftp = ftplib.FTP()
        self.ftp.connect("127.0.0.1", controller.port, timeout=10)
        self.ftp.login(controller.user, controller.password)
        self.sent, self.answers = sent, answers

    def send(self, values: Sequence[Sequence[float]]) -> None:
        for name, row in zip(self.sent, values, strict=True):
            text = "[" + ",".join(f"{value:.6f}" for value in row) + "]\n"
            self.ftp.storbinary(f"STOR {name}", io.BytesIO(text.encode()))

    def received(self, lines: int) -> Rows:
        """The lines of all answers, once there are so many; they are deleted."""
        for _ in range(TRIES):
            texts = [self._text(name) for name in self.answers]
            rows = [line for text in texts for line in text.split("\n")]
            if sum(row.endswith("]") for row in rows) == lines:
                for name in self.answers:
                    self.ftp.delete(name)
                return [[float(v) for v in row[1:-1].split(",")] for row in rows if row]
            threading.Event().wait(0.002)
        raise AssertionError("the robot does not answer")

    def _text(self, name: str) -> str:
        """Empty as long as there is no such file."""
        found = io.BytesIO()
        try:
            self.ftp.retrbinary(f"RETR {name}", found.write)
        except ftplib.error_perm:
            return ""
        return found.getvalue().decode()


def exchanged(controller: VirtualIrc5, program: Path, seconds: float = 300.0) -> Run:
    """Runs a program on the disk that the controller serves."""
    file = languages.get("rapid").parse(program.read_text(encoding="utf-8"))
    assert not file.findings
    robot = robots.get("irb1200-7-0.7")
    return run_tasks(
        [TaskProgram(name="T_ROB1", modules=[file])],
        robot=robot,
        motion=Timed(robot),
        most_time=seconds,
        controller=Controller(disk=Disk(controller.folder, outside=True)),
    )


def targets(
    first: Sequence[float], turn: Sequence[float], side: float
) -> list[tuple[list[float], list[float]]]:
    """Poses from where the robot stands to 120 mm beside and 40 mm below, turned by 20 degrees.

    side: 1 or -1, so that no axis leaves its quadrant: the programs state the configuration.
    """
    ends = rotations.multiply(turn, rotations.about([0.0, 0.0, 1.0], side * 20.0))
    parts = np.arange(1, POSES + 1) / POSES
    places = np.asarray(first) + parts[:, None] * np.array([0.0, side * 120.0, -40.0])
    turns = rotations.between(np.asarray(turn), ends, parts)
    return list(zip(places.round(6).tolist(), turns.round(6).tolist(), strict=True))


@pytest.fixture
def controller(tmp_path: Path):
    with VirtualIrc5(tmp_path / "home") as served:
        yield served


def test_the_sample_that_exchanges_poses_runs_with_a_client(controller) -> None:
    """Without a configuration, and with both parts of its answer in one file.

    It answers while the robot goes through the corner in front of the pose.
    """
    answers: list[Rows] = []
    wanted: list[Rows] = []

    def pc() -> None:
        client = Client(controller, ("next_rot.txt", "next_pos.txt"), ("now.txt",))
        place, turn = client.received(2)
        for position, quaternion in targets(place, turn, 1.0):
            client.send((quaternion, position))
            wanted.append([position, quaternion])
            answers.append(client.received(2))
        client.ftp.quit()

    with ThreadPoolExecutor(1) as pool:
        done = pool.submit(pc)
        run = exchanged(controller, SAMPLES / "pose_exchange.mod")
        assert (run.ended, run.message) == ("end", "")
        done.result()
    assert len(answers) == POSES
    for asked, told in zip(wanted, answers, strict=True):
        assert np.linalg.norm(np.subtract(told[0], asked[0])) < STEP + 0.01


def test_a_program_that_nobody_sends_a_pose_gives_up(controller) -> None:
    """In the longest time that it waits, of which real time takes as long."""
    text = (SAMPLES / "pose_exchange.mod").read_text(encoding="utf-8").replace("240", "0.05")
    program = controller.folder.parent / "short.mod"
    program.write_text(text, encoding="utf-8")
    run = exchanged(controller, program)
    assert (run.ended, "ERR_WAIT_MAXTIME" in run.message) == ("error", True)
    assert run.place is not None and run.place[1] == text[: text.index("WaitUntil")].count("\n") + 1

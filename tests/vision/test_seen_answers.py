"""Programs that ask where an object is, run by the interpreters, and this computer that answers.

Where the flange comes to is compared with the closed form: the place that was answered, times the
target, by homogeneous matrices.
"""

from __future__ import annotations

import datetime
import math
import socket
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.compiler import compile, translate
from assistant.compiler.simulated_run import programs
from assistant.controllers.mitsubishi.data_link import DataLink
from assistant.controllers.rules import Lost
from assistant.program.geometry import Pose
from assistant.sources.sights import Sight, seeing
from assistant.virtual.events import Moved, Run
from assistant.virtual.kernel import Kernel
from assistant.virtual.kernel.kernel import Instant
from assistant.virtual.program_run import Settings, prepared
from assistant.vision.pose_server import Answer, answer_line, answer_numbers, serve_program

TEXT = """program seam

frame part user [300, 0, 200] seen bracket

target above [0, 0, 60] [0, 0, 1, 0]
target on [10, -20, 10] [0, 0, 1, 0]

procedure main
  move joint above speed 200 mm/s blend fine frame part
  move linear on speed 50 mm/s blend fine frame part
end
"""
TWO = TEXT.replace(
    "\ntarget above", "frame lid user [310, 40, 220] seen cover\n\ntarget above"
).replace("on speed 50 mm/s blend fine frame part", "on speed 50 mm/s blend fine frame lid")
TARGETS = ((0.0, 0.0, 60.0), (10.0, -20.0, 10.0))
ARMS = [("rapid", "irb1200-7-0.7"), ("melfa-basic-5", "rv-4frl"), ("melfa-basic-6", "rv-4frl")]


def sight(pose: Pose, name: str = "bracket", age: float = 0.0, **changed: float) -> Sight:
    when = datetime.datetime.now(datetime.UTC) - datetime.timedelta(seconds=age)
    told = {"sigma_mm": 0.2, "sigma_deg": 0.1, "confidence": 0.97, **changed}
    return Sight(name, pose, seen=when, **told)


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as one:
        return int(one.getsockname()[1])


class Asked:
    """A program of a language that is run, and what it was answered."""

    def __init__(self, folder: Path, language: str, robot: str, text: str = TEXT) -> None:
        self.port, self.robot = free_port(), robot
        (folder / "seam.pseudo").write_text(text, "ascii")
        made = compile(
            folder / "seam.pseudo",
            language=language,
            robot=robot,
            seeing=seeing(ask=f"127.0.0.1:{self.port}"),
        )
        assert made.ok
        (self.file,) = made.write(folder)
        self.link = DataLink(f"listen:127.0.0.1:{self.port}", timeout=20.0)

    def translated(self, to: str, robot: str, process: Path | None = None) -> None:
        """The same in another language, for another arm."""
        done = translate(self.file, to=to, robot=robot, from_robot=self.robot, process=process)
        assert done.ok, [f"{one.code} {one.message}" for one in done.findings]
        (self.file,) = done.write(self.file.parent / "other")
        self.robot = robot

    def run(self, look: Callable[[str], Sight | None]) -> tuple[list[Answer], Run]:
        self.link.prepare()
        with ThreadPoolExecutor(1) as aside:
            answers = aside.submit(lambda: list(serve_program(self.link, look, patience=20.0)))
            kernel = self.kernel()
            run = kernel.run()
            return answers.result(30), run

    def kernel(self, most_time: float = 20.0) -> Kernel:
        melfa = self.file.suffix == ".prg"
        settings = Settings(
            robot=robots.get(self.robot),
            motion=Instant(),
            lines={"COM3": f"127.0.0.1:{self.port}"} if melfa else {},
            most_time=most_time,
        )
        return prepared(programs([str(self.file)]), settings)


@pytest.fixture(params=ARMS, ids=lambda arm: arm[0])
def asked(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Asked]:
    one = Asked(tmp_path, *request.param)
    yield one
    one.link.close()


def flanges(run: Run) -> list[Pose]:
    return [one.flange for one in run.events if isinstance(one, Moved) and one.flange]


def homogeneous(pose: Pose) -> np.ndarray:
    """(4, 4), by the formula of a unit quaternion, which no code of ours works out."""
    w, x, y, z = pose.quaternion
    turn = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = turn, pose.position
    return whole


def turned(*angles: float) -> tuple[float, float, float, float]:
    w, x, y, z = rotations.from_euler(angles, "ZYX").tolist()
    return (w, x, y, z)


# ------------------------------------------------------------------------------ whole ways


def test_the_arm_goes_to_the_place_that_was_answered(asked: Asked, tell: Callable[[str], None]):
    pose = Pose((320.5, 15.25, 190.0), turned(25.0, -4.0, 3.0))
    off, turn = astray(asked, pose)
    tell(f"seen frames, {asked.file.name}: {off:.5f} mm, {turn:.6f} degrees off")
    assert off < 0.01 and turn < 0.01


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arm", "to", "robot"),
    [(ARMS[0], "melfa-basic-5", "rv-4frl"), (ARMS[1], "rapid", "irb1200-7-0.7")],
    ids=["from rapid", "to rapid"],
)
def test_it_does_so_in_the_other_language_too(
    tmp_path: Path, arm: tuple[str, str], to: str, robot: str
):
    asked = Asked(tmp_path, *arm)
    line = f'[lines.line_3]\nrole = "client"\nport = {asked.port}\naddress = "127.0.0.1"\n'
    (tmp_path / "line.toml").write_text(f"joint_speed = 100\n{line}", "ascii")
    asked.translated(to, robot, tmp_path / "line.toml" if to == "rapid" else None)
    off, turn = astray(asked, Pose((310.0, 20.0, 205.0), turned(15.0, 0.0, 0.0)), at_once=True)
    assert off < 0.01 and turn < 0.01


def astray(asked: Asked, pose: Pose, *, at_once: bool = False) -> tuple[float, float]:
    """mm and degrees by which an arm comes to another place than the one that was answered.

    at_once: the program goes round and round, of which the first cycle is looked at.
    """
    answers, run = asked.run(lambda name: sight(pose, name))
    assert {(one.name, one.state) for one in answers} == {("bracket", 1)}
    went = [homogeneous(flange) for flange in flanges(run)][: len(TARGETS) if at_once else None]
    due = [homogeneous(pose) @ homogeneous(Pose(at, (0.0, 0.0, 1.0, 0.0))) for at in TARGETS]
    assert len(went) == len(due)
    pairs = list(zip(went, due, strict=True))
    off = max(float(np.abs(a[:3, 3] - b[:3, 3]).max()) for a, b in pairs)
    turn = max(float(np.abs(a[:3, :3] - b[:3, :3]).max()) for a, b in pairs)
    return off, math.degrees(turn)


@pytest.mark.parametrize(
    ("look", "state"),
    [
        (lambda _: None, 0),
        (lambda name: sight(Pose((320.0, 0.0, 200.0)), name, age=601.0), 2),
        (lambda name: sight(Pose((320.0, 0.0, 200.0)), name, sigma_mm=1.5), 2),
        (lambda name: sight(Pose((320.0, 0.0, 200.0)), name, confidence=0.5), 2),
        (lambda name: sight(Pose((320.0, 301.0, 200.0)), name), 1),  # too far from where it is
    ],
    ids=["not in sight", "old", "unsure", "hardly it", "far away"],
)
def test_nothing_moves_where_it_is_not_found_or_doubtful(
    asked: Asked, look: Callable[[str], Sight | None], state: int
):
    answers, run = asked.run(look)
    assert [one.state for one in answers] == [state]
    assert not flanges(run)
    assert state == 1 or answers[0].findings


@pytest.mark.parametrize("arm", ARMS[:2], ids=lambda arm: arm[0])
def test_of_two_objects_each_is_asked_for(tmp_path: Path, arm: tuple[str, str]):
    places = {"bracket": Pose((300.0, 10.0, 200.0)), "cover": Pose((330.0, 30.0, 220.0))}
    answers, run = Asked(tmp_path, *arm, text=TWO).run(lambda name: sight(places[name], name))
    assert [one.name for one in answers] == list(places)
    first, second = (flange.position for flange in flanges(run))
    assert first == pytest.approx((300, 10, 260), abs=0.01)
    assert second == pytest.approx((340, 10, 230), abs=0.01)


@pytest.mark.parametrize("arm", ARMS[:2], ids=lambda arm: arm[0])
def test_a_line_that_is_cut_moves_nothing(tmp_path: Path, arm: tuple[str, str]):
    asking = Asked(tmp_path, *arm)
    asking.link.prepare()

    def cut() -> None:
        asking.link.open()
        asking.link.receive()
        asking.link.send(1)
        asking.link.send(320.0)
        asking.link.close()

    with ThreadPoolExecutor(1) as aside:
        over = aside.submit(cut)
        run = asking.kernel(most_time=0.5).run()
        over.result(30)
    assert not flanges(run)


# --------------------------------------------------------------------------------- answers


def test_the_numbers_are_those_of_the_pose():
    told = Answer("b", 1, Pose((1.0, 2.0, 3.0), turned(30.0, 20.0, 10.0)))
    assert answer_numbers(told) == pytest.approx((1, 1, 2, 3, 10, 20, 30))
    assert answer_numbers(Answer("b", 0)) == (0,) * 7 and answer_numbers(Answer("b", 2)) == (
        2,
        *(0,) * 6,
    )


def test_what_was_seen_in_the_world_is_told_in_the_base():
    there = Sight(**{name: getattr(sight(Pose((85.0, 320.0, 210.0))), name) for name in
                     Sight.__slots__ if name != "frame"}, frame="world")  # fmt: skip
    base = Pose((100.0, 0.0, 0.0), turned(90.0, 0.0, 0.0))
    told = answer_line("see bracket", lambda _: there, base=base)
    assert told.pose is not None and told.pose.position == pytest.approx((320, 15, 210))
    nowhere = answer_line("see bracket", lambda _: there)
    assert nowhere.state == 2 and [one.code for one in nowhere.findings] == ["VS382"]


@pytest.mark.parametrize("line", ["", "see", "see ", "look bracket", "1,2,3", "\x00\xff"])
def test_what_is_no_question_is_not_answered(line: str):
    told = answer_line(line, lambda name: sight(Pose(), name))
    assert told.state is None and [one.code for one in told.findings] == ["VS380"]


def test_what_is_not_in_sight_is_told():
    told = answer_line("see bracket", lambda _: None)
    assert told.state == 0 and [one.code for one in told.findings] == ["VS381"]


def test_nobody_who_asks_is_told_in_time():
    link = DataLink(f"listen:127.0.0.1:{free_port()}", timeout=0.2)
    with pytest.raises(Lost):
        list(serve_program(link, lambda _: None, patience=0.1))

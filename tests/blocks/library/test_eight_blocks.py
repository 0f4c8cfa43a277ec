"""Each of the paper's eight blocks in a model of bdsim, on a virtual CR controller.

What its table IV says of them is looked at in the controller's own record: "stopped, blocking" of
the five moves, "continuous, non blocking" of RelJoint and RelCart, "continuous measurement" of
Status; over real sockets and over a pseudo terminal.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest

from assistant import robots
from assistant.blocks.bdsim_adapter import run_paced
from assistant.blocks.connections import operated
from assistant.blocks.diagrams import RealTime, RunResult
from assistant.blocks.setpoint_connections import led, measured
from assistant.controllers.trajectory_execution import LinkOptions
from assistant.virtual.irc5 import VirtualIrc5
from assistant.virtual.irc5.controller import USER
from assistant.virtual.irc5.egm import Guidance, VirtualEgm
from tests.blocks.library.test_leading import MOST, STEP, Cell, cell, check_continuous
from tests.vision.servoing.scenes import free_port

pytest.importorskip("bdsim")
ARM = robots.get("rv-2aj")
TICK, ANOTHER = 0.02, 0.03
"""Seconds of a step of the model, and when another target comes."""
LOW, HIGH = [0, 10, 80, 0, 60, 0], [20, 0, 90, 0, 90, 0]
OUT, BESIDE, BACK = [360, 0, 300, 0, 180, 0], [330, 60, 300, 0, 180, 0], [300, 100, 300, 0, 180, 0]
BEFORE = [260, -90, 400, 0, 180, 0]
MOVES: Final = {
    "JOINTMOVJOINT": ([[LOW, HIGH]], "joint"),
    "JOINTMOVCART": ([[OUT, BACK]], "joint"),
    "LINMOVJOINT": ([[LOW, HIGH]], "linear"),
    "LINMOVCART": ([[OUT, BACK]], "linear"),
    "CIRCULARMOV": (
        [[[260, -90, 300, 0, 180, 0], [330, 60, 300, 0, 180, 0]], [OUT, BACK]],
        "circular",
    ),
}
"""What each is given, one after the other, and how the controller calls what it does."""
SLOW: Final = {("serial link", name) for name in MOVES} - {("serial link", "JOINTMOVJOINT")}
"""In the fast suite each has one case."""


def both(names: Any, slow: Any) -> list[Any]:
    """Each block over sockets and over a pseudo terminal."""
    return [
        pytest.param(way, name, marks=pytest.mark.slow if (way, name) in slow else ())
        for name in names
        for way in ("sockets", "serial link")
    ]


@pytest.mark.parametrize(("way", "name"), both(MOVES, SLOW))
def test_a_move_is_blocking_and_the_arm_stops_behind_it(
    sim: Any, way: str, name: str, tell: Callable[[str], None]
) -> None:
    ways, kind = MOVES[name]
    with cell(way, pace=2.0) as here:
        connection = operated("cell", here.address, override=50)
        diagram = sim.blockdiagram()
        block = getattr(diagram, name)(diagram.clock(TICK), connection, ARM, "move")
        for number, (first, second) in enumerate(ways):
            # The other target comes while the arm is on its way to the first one.
            source = diagram.MOTIONTABLE(
                [0.0, TICK, ANOTHER], [first, first, second], name=f"to{number}"
            )
            diagram.connect(source[0], block[number])
        diagram.connect(diagram.CONSTANT(1.0), block[len(ways)])
        ran = run_paced(
            sim, diagram, 60.0, TICK,
            clock=RealTime(), moving=["cell"], watch=lambda now: not now or block._inner._done < 2,
        )  # fmt: skip
        assert connection.users == 0
        check_blocking(here, ran)
        assert [(one.kind, one.blend) for one in here.moves] == [(kind, 0.0)] * 2
    tell(f"{name}, {way}: busy until the arm stands, one halt between two moves")


def check_blocking(here: Cell, ran: RunResult) -> None:
    busy, done = ran["move[0]"], ran["move[1]"]
    assert done[-1] == 2.0 and (np.diff(done) <= 1.0).all()
    begun, ended = int(np.argmax(busy)), int(np.argmax(done == 1.0))
    assert (busy[begun:ended] == 1.0).all() and ended * TICK > ANOTHER
    assert busy[ended] == 0.0  # the other target waited until then
    moving = np.flatnonzero(here.track.speed > 0.0)
    assert (np.diff(moving) > 1).sum() == 1  # it stands once between the two


def led_model(sim: Any, here: Cell, name: str, by: Any, steps: int) -> tuple[Any, Any, Any]:
    """A model in which an arm is led so many steps, and measured meanwhile."""
    connection, diagram = here.led(), sim.blockdiagram()
    clock = diagram.clock(STEP)
    status = diagram.STATUS(clock, connection, ARM, "status")
    rel = getattr(diagram, name)(clock, connection, ARM, "rel", **BOUNDS[name])
    ends = STEP * (steps + 0.5)  # a clock of bdsim ticks for the first time after a period
    go = diagram.MOTIONTABLE([0.0, ends - 1e-3, ends], [1.0, 1.0, 0.0])
    diagram.connect(diagram.CONSTANT(np.array(by, dtype=float)), rel[0])
    diagram.connect(go[0], rel[1])
    for port in range(6):
        diagram.connect(status[port], diagram.NULL())
    return diagram, connection, ends


BOUNDS: Final = {"RELJOINT": {"most": 10.0}, "RELCART": {"most": (30.0, 5.0)}}
BY: Final = {
    "RELJOINT": [MOST[0], 0.0, -MOST[2] / 2.0, 0.0, 0.0],
    "RELCART": [6.0, 0.0, -6.0, 0.0, 0.0, 0.0],
}
LED_SLOW: Final = {("sockets", "RELJOINT"), ("serial link", "RELCART")}


@pytest.mark.parametrize(("way", "name"), both(BY, LED_SLOW))
def test_relative_steps_are_continuous_and_not_blocking(
    sim: Any, way: str, name: str, tell: Callable[[str], None]
) -> None:
    steps = 4
    with cell(way) as here:
        diagram, connection, ends = led_model(sim, here, name, BY[name], steps)

        def watch(now: float) -> bool:
            leader = connection.value
            return now < ends + STEP or bool(
                np.abs(leader.measured().joints - leader.told).max() > 0.02
            )

        ran = run_paced(sim, diagram, 60.0, STEP, clock=RealTime(), moving=["cell"], watch=watch)
        assert connection.users == 0
        named = {"rel.steps": "rel[1]", "rel.told": "rel[0]", "status.joints": "status[1]"}
        shown = {name: ran.columns[port] for name, port in named.items()}
        check_continuous(here, RunResult(ran.seconds, shown, ran.lateness, ran.late), steps)
        if name == "RELCART":
            check_straight(here, steps * np.array(BY[name][:3]))
        rate = check_measured(ran)
    tell(f"{name} and STATUS, {way}: {steps} steps without a halt, {rate:.0f} records a second")


def check_measured(ran: RunResult) -> float:
    """All the time, and tens of times in each second of the controller's clock: how often."""
    seconds = ran["status[4]"]
    assert (np.diff(seconds) >= 0.0).all() and len(np.unique(seconds)) > len(seconds) / 2
    rate = float(ran["status[5]"][-1])
    assert rate > 20.0
    return rate


def check_straight(here: Cell, way: np.ndarray) -> None:
    """The tool went all of the way, and kept to the line that its steps are on."""
    gone = here.track.position - here.track.position[0]
    assert gone[-1] == pytest.approx(way, abs=0.1)
    along = way / np.linalg.norm(way)
    assert np.linalg.norm(gone - np.outer(gone @ along, along), axis=1).max() < 0.5


@pytest.mark.parametrize("way", ["sockets", "serial line"])
def test_status_measures_all_the_time_and_moves_nothing(
    sim: Any, way: str, tell: Callable[[str], None]
) -> None:
    with cell(way, pace=1.0) as here:
        connection = measured("cell", here.lines[1], ARM, address=here.address)
        diagram = sim.blockdiagram()
        status = diagram.STATUS(diagram.clock(STEP), connection, ARM, "status")
        for port in range(6):
            diagram.connect(status[port], diagram.NULL())
        ran = run_paced(sim, diagram, 1.0, STEP, clock=RealTime())  # nothing is to be confirmed
        assert connection.users == 0 and here.moves == []
        p, q = ARM.fk(ARM.home)
        assert ran["status[0]"][-1] == pytest.approx([*p[0], *q[0]], abs=0.01)
        assert ran["status[1]"][-1] == pytest.approx(ARM.home, abs=0.01)
        rate = check_measured(ran)
    tell(f"STATUS alone, {way}: {rate:.0f} records a second")


@pytest.mark.slow
def test_two_robots_in_one_model(sim: Any) -> None:
    """As the paper could not: one by its serial line, the other by data links."""
    with cell("serial link", pace=4.0) as one, cell() as other:
        diagram, second, ends = led_model(sim, other, "RELJOINT", BY["RELJOINT"], 4)
        first = operated("first", one.address, override=50)
        block = diagram.JOINTMOVJOINT(diagram.clock(TICK), first, ARM, "move")
        diagram.connect(diagram.CONSTANT(np.array(LOW, dtype=float)), block[0])
        diagram.connect(diagram.CONSTANT(1.0), block[1])

        def watch(now: float) -> bool:
            assert (first.users, second.users) == (1, 2)
            return now < ends + STEP or block._inner._done < 1

        run_paced(sim, diagram, 60.0, TICK, clock=RealTime(), moving=["cell", "first"], watch=watch)
        assert (first.users, second.users) == (0, 0)
        assert [move.kind for move in one.moves] == ["joint"]
        assert len(other.moves) >= 2 and one.track.joints[-1][0] == pytest.approx(0.0, abs=0.01)


@pytest.mark.slow
def test_robots_of_two_makers_in_one_model(
    sim: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One over data links, the other cycle by cycle, each by a connection of its own."""
    monkeypatch.setenv("ROBOT_ASSISTANT_PASSWORD", "secret")
    robot, port = robots.get("irb1200-7-0.7"), free_port()
    arm = Guidance(
        "joints", tuple(robot.home), tuple(robot.speeds),
        comm_timeout=60.0, cond_time=600.0, waiting=None,
    )  # fmt: skip
    with (
        cell() as one,
        VirtualIrc5(tmp_path / "home", password="secret") as irc5,
        VirtualEgm(arm, ("127.0.0.1", port)) as virtual,
    ):
        diagram, first, ends = led_model(sim, one, "RELJOINT", BY["RELJOINT"], 3)
        second = led(
            "irc5", f"ftp://{USER}@127.0.0.1:{irc5.port}", robot,
            by="egm", percent=20.0, wishes=LinkOptions(port=port),
        )  # fmt: skip
        rel = diagram.RELJOINT(diagram.clock(STEP), second, robot, "other")
        diagram.connect(diagram.CONSTANT(np.array([2.0, 0.0, -1.0, 0.0, 0.0, 0.0])), rel[0])
        diagram.connect(diagram.CONSTANT(1.0), rel[1])
        ran = run_paced(sim, diagram, ends + STEP, STEP, clock=RealTime(), moving=["cell", "irc5"])
        assert (first.users, second.users) == (0, 0)
        assert one.moves and one.track.joints[-1, 0] > 1.0
    told = ran["other[0]"][-1]
    rows = np.array(virtual.track)
    assert told[0] - robot.home[0] == pytest.approx(2.0 * ran["other[1]"][-1])
    assert np.abs(rows[-1] - told).max() < 3.0 and np.abs(rows[-1] - robot.home).max() > 1.0

"""Poses out of a model to the printed module, which the interpreter runs, over a file server."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from assistant.base.diagnostics import Refused
from assistant.blocks.connections import Asked, Connection
from assistant.blocks.diagrams import Diagram, RealTime, run
from assistant.blocks.library.controller_io import ExchangedPose, exchanged
from assistant.blocks.library.sources import Constant, Table
from assistant.controllers.abb.exchange import PoseExchange
from tests.controllers.abb.exchanging import RunningRobot

STEP = 0.02
HELD = 3.0
"""Seconds."""
NEAR, FAR = [420.0, 80.0, 400.0, 0.0, 0.0, 1.0, 0.0], [420.0, -140.0, 400.0, 0.0, 0.0, 1.0, 0.0]


def connected(robot: RunningRobot, **how: object) -> Connection[Asked[PoseExchange]]:
    controller = robot.controller
    address = f"ftp://{controller.user}@127.0.0.1:{controller.port}"
    return exchanged("cell", address, password=controller.password, **how)  # type: ignore[arg-type]


def sent(
    connection: Connection[Asked[PoseExchange]], *rows: list[float]
) -> tuple[Diagram, ExchangedPose]:
    """A block that is given poses, each for so long that a computer that is busy misses none."""
    diagram = Diagram()
    times = [HELD * i + part for i in range(len(rows)) for part in (0.0, HELD - 0.001)]
    poses = diagram.add(Table("poses", times, np.repeat(rows, 2, axis=0)))
    block = diagram.add(ExchangedPose("arm", connection))
    diagram.wire((poses, "value"), (block, "pose"))
    diagram.wire(diagram.add(Constant("start", 1.0)), (block, "start"))
    return diagram, block


@pytest.mark.parametrize("pace", [None, 4.0])
def test_poses_are_gone_to_one_after_the_other(tmp_path: Path, pace: float | None) -> None:
    """Each motion is seen, one that ends within a step as well."""
    with RunningRobot(tmp_path / "home", pace=pace) as robot:
        connection = connected(robot)
        diagram, block = sent(connection, NEAR, FAR)
        watch = lambda now: now < HELD + 0.1 or block._goes or block._done < 2  # noqa: E731
        found = run(diagram, 20.0, STEP, clock=RealTime(), watch=watch, moving=["cell"])
        assert connection.users == 0
    assert np.isnan(found["arm.stands"][0]).all()
    assert found["arm.stands"][-1] == pytest.approx(FAR, abs=1e-2)
    busy, done = found["arm.busy"], found["arm.done"]
    assert done[-1] == 2.0 and (np.diff(done) >= 0.0).all()
    assert (np.diff(busy) > 0.0).sum() == 2.0, "it is busy twice"
    for number in (1, 2):
        ended = np.searchsorted(done, number)
        assert busy[ended - 1] == 1.0 and busy[ended] == 0.0
    if pace is not None:
        assert busy.sum() > 5.0
    assert found["arm.motion"][-1] > 0.0


@pytest.mark.slow
def test_a_run_that_ends_stops_the_robot_on_its_way(tmp_path: Path) -> None:
    with RunningRobot(tmp_path / "home", pace=1.0) as robot:
        diagram, block = sent(connected(robot), FAR)
        going: list[float] = []

        def watch(now: float) -> bool:
            taken = block._goes and not (robot.home / "exchange_request.txt").exists()
            going.extend([now] * taken)
            return len(going) < 10

        run(diagram, 20.0, STEP, clock=RealTime(), watch=watch, moving=["cell"])
        assert robot.ended() == ("end", "")
    assert going


def test_nothing_is_sent_that_is_outside_of_the_box_or_no_pose(tmp_path: Path) -> None:
    with RunningRobot(tmp_path / "home") as robot:
        box = (300.0, -100.0, 300.0), (500.0, 100.0, 500.0)
        connection = connected(robot, box=box)
        diagram, _ = sent(connection, FAR)
        with pytest.raises(Refused, match=r"CN511.*outside of the box"):
            run(diagram, 20.0, STEP, clock=RealTime(), moving=["cell"])
        assert connection.users == 0
        assert not (robot.home / "exchange_request.txt").exists()

"""Arms that are led cycle by cycle out of a model, over real sockets and a process of the loop."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
import pytest

from assistant import robots
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.blocks.connections import Connection
from assistant.blocks.diagrams import Diagram, RealTime, RunResult, run
from assistant.blocks.library.external_control import ExternalControl, Led, by_egm, by_mxt
from assistant.blocks.library.sources import Constant, Table, joint_table
from assistant.controllers import connect
from assistant.controllers.controller import Controller
from assistant.controllers.cyclic import Settings
from assistant.controllers.trajectory_execution import LinkOptions
from assistant.robots.robot import Robot
from assistant.virtual.cr import VirtualCr
from assistant.virtual.irc5.egm import Guidance, VirtualEgm
from assistant.vision.servoing.bounds import Bounds
from assistant.vision.servoing.interaction import flange_of
from tests.vision.servoing.scenes import PATIENT, free_port

ARM = robots.get("rv-2aj")
IRB = robots.get("irb1200-7-0.7")
HERE = np.array([10.0, 25.0, 15.0, 20.0, 60.0, 15.0])
STEP = 0.01
BRISK = Bounds(speed=1000.0, turning=360.0, part=0.8, margin=0.0)


@contextmanager
def guided(
    bounds: Bounds = BRISK, settings: Settings = PATIENT, **how: float
) -> Iterator[tuple[Connection[Led], VirtualEgm]]:
    """A virtual arm of six axes whose program asks for joints, at `HERE`."""
    port = free_port()
    waits = {"comm_timeout": 60.0, "cond_time": 600.0, **how}
    speeds = tuple(IRB.speeds)
    arm = Guidance("joints", tuple(HERE), speeds, waiting=None, **waits)
    connection = by_egm("cell", "127.0.0.1", IRB, bounds=bounds, port=port, settings=settings)
    with VirtualEgm(arm, ("127.0.0.1", port)) as virtual:
        yield connection, virtual


def model(
    connection: Connection[Led], robot: Robot, wanted: Sequence[Floats], seconds: float
) -> tuple[Diagram, ExternalControl]:
    diagram = Diagram()
    times = np.linspace(0.0, seconds, len(wanted)) if len(wanted) > 1 else [0.0]
    way = diagram.add(joint_table("way", robot, times, np.array(wanted)))
    block = diagram.add(ExternalControl("arm", connection, robot))
    diagram.wire((way, "joints"), (block, "wanted"))
    diagram.wire(diagram.add(Constant("on", 1.0)), (block, "enable"))
    return diagram, block


def led(
    connection: Connection[Led], robot: Robot, wanted: Sequence[Floats], seconds: float
) -> tuple[RunResult, ExternalControl]:
    diagram, block = model(connection, robot, wanted, seconds)
    rest = 1.0  # an arm comes late where this computer is busy
    ran = run(diagram, seconds + rest, STEP, clock=RealTime(), moving=["cell"])
    assert connection.users == 0
    return ran, block


def there(start: Floats, by: Floats, count: int = 60) -> Floats:
    """From rest to rest in the first two thirds."""
    part = np.minimum(1.0, np.linspace(0.0, 1.5, count))
    return start + np.outer(np.sin(0.5 * np.pi * part) ** 2, by)


def test_an_arm_is_guided_along_joints_and_its_cycles_are_counted() -> None:
    with guided() as (connection, virtual):
        ran, block = led(connection, IRB, there(HERE, np.ones(6)), 1.0)
    assert np.abs(ran["arm.commanded"] - ran["way.joints"]).max() < 0.2
    assert np.abs(ran["arm.joints"] - ran["way.joints"]).max() < 1.0
    assert ran["arm.joints"][-1] == pytest.approx(HERE + 1.0, abs=0.1)
    assert virtual.track[-1] == pytest.approx(HERE + 1.0, abs=0.1)
    assert (np.diff(ran["arm.cycles"]) >= 0.0).all() and ran["arm.cycles"][-1] > 20
    assert ran["arm.worst"][-1] >= ran["arm.jitter"][-1] > 0.0
    assert block.report is not None and "later than half a cycle" in block.summary
    assert block.report.delays.count >= ran["arm.cycles"][-1]


def test_real_time_external_control_installs_its_program_and_ends_it() -> None:
    with VirtualCr("rv-2aj", servo_time=0.02) as cell:
        start = np.array(cell.state.joints)
        wanted = there(start, np.array([1.0, 1.0, -1.0, -1.0, 1.0]))
        wishes = LinkOptions(port=cell.mxt_port)
        connection = by_mxt("cell", cell.address, ARM, bounds=BRISK, wishes=wishes)
        ran, block = led(connection, ARM, wanted, 1.0)
        assert np.abs(ran["arm.joints"] - ran["way.joints"]).max() < 1.0
        assert ran["arm.joints"][-1] == pytest.approx(wanted[-1], abs=0.1)
        with connect(cell.address) as session:
            assert isinstance(session, Controller)
            state = session.state()
            assert not state.motors and not state.running
        assert block.report is not None and block.report.cycle == pytest.approx(64 / 9000)


def test_neither_speed_nor_region_is_left_whatever_is_wanted() -> None:
    x, y, z = flange_of(IRB, HERE).position
    box = (x - 30.0, y - 30.0, z - 30.0), (x + 30.0, y + 30.0, z + 30.0)
    bounds = Bounds(speed=80.0, turning=180.0, part=0.5, box=box)
    with guided(bounds) as (connection, virtual):
        diagram = Diagram()
        jump = diagram.add(Table("way", [0.0, 0.05, 0.051], [HERE, HERE, HERE + 40.0]))
        block = diagram.add(ExternalControl("arm", connection, IRB))
        diagram.wire((jump, "value"), (block, "wanted"))
        diagram.wire(diagram.add(Constant("on", 1.0)), (block, "enable"))
        ran = run(diagram, 1.2, STEP, clock=RealTime(), moving=["cell"])
        track = np.array(virtual.track)
    assert ran["arm.limited"][-1] == 1.0
    tips = np.array([flange_of(IRB, row).position for row in ran["arm.commanded"]])
    speeds = np.linalg.norm(np.diff(tips, axis=0), axis=1) / STEP
    assert 40.0 < speeds.max() < 81.0
    inside = np.array([flange_of(IRB, row).position for row in track])
    assert (inside > np.array(box[0]) - 0.5).all() and (inside < np.array(box[1]) + 0.5).all()


@pytest.mark.slow
def test_an_arm_that_is_not_enabled_comes_to_rest() -> None:
    with guided() as (connection, virtual):
        diagram = Diagram()
        way = diagram.add(Table("way", [0.0, 2.0], [HERE, HERE + 40.0]))
        on = diagram.add(Table("on", [0.0, 0.4, 0.401], [1.0, 1.0, 0.0]))
        block = diagram.add(ExternalControl("arm", connection, IRB))
        diagram.wire((way, "value"), (block, "wanted"))
        diagram.wire((on, "value"), (block, "enable"))

        def watch(now: float) -> bool:
            return now < 1.0 or bool(np.ptp(virtual.track[-50:], axis=0).max() > 0.01)

        ran = run(diagram, 20.0, STEP, clock=RealTime(), watch=watch, moving=["cell"])
    commanded = ran["arm.commanded"]
    assert commanded[-1, 0] - HERE[0] > 5.0
    assert np.ptp(commanded[-20:], axis=0).max() == 0.0
    assert virtual.track[-1] == pytest.approx(commanded[-1], abs=0.1)


def test_a_link_that_is_lost_ends_the_run() -> None:
    with guided(settings=Settings(opening=60.0, timeout=0.3)) as (connection, virtual):
        diagram, block = model(connection, IRB, [HERE, HERE + 9.0], 3.0)

        def watch(now: float) -> bool:
            if now > 0.3:
                virtual.guidance.motors = False
            return True

        with pytest.raises(Refused, match="CN71"):
            run(diagram, 3.0, STEP, clock=RealTime(), watch=watch, moving=["cell"])
        assert connection.users == 0
    assert block.report is not None
    assert virtual.track[-1][0] - HERE[0] < 3.0


@pytest.mark.parametrize(
    ("wanted", "code"),
    [(HERE + 40.0, "BL501"), pytest.param(HERE * np.nan, "BL203", marks=pytest.mark.slow)],
)
def test_no_setpoint_far_away_is_begun_with(wanted: Floats, code: str) -> None:
    with guided() as (connection, virtual):
        diagram = Diagram()
        way = diagram.add(Constant("way", wanted))
        block = diagram.add(ExternalControl("arm", connection, IRB))
        diagram.wire(way, (block, "wanted"))
        diagram.wire(diagram.add(Constant("on", 1.0)), (block, "enable"))
        with pytest.raises(Refused, match=code):
            run(diagram, 0.5, STEP, clock=RealTime(), moving=["cell"])
        assert connection.users == 0
    assert np.ptp(np.array(virtual.track), axis=0).max() < 1e-6


def test_nobody_is_led_who_was_not_confirmed_or_by_two() -> None:
    with guided() as (connection, _):
        diagram, block = model(connection, IRB, [HERE], 1.0)
        with pytest.raises(Refused, match=r"BL111.*`cell`"):
            run(diagram, 0.1, STEP)
        other = diagram.add(ExternalControl("other", connection, IRB))
        diagram.wire((diagram.blocks[0], "joints"), (other, "wanted"))
        diagram.wire(diagram.add(Constant("off", 0.0)), (other, "enable"))
        with pytest.raises(Refused, match=r"BL502.*`cell`"):
            run(diagram, 0.1, STEP, moving=["cell"])
        assert connection.users == 0
        assert block.report is not None

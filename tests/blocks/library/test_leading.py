"""Status, RelJoint and RelCart of the paper, on a virtual CR controller over sockets and a pty."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
import pytest
from numpy.typing import ArrayLike

from assistant import robots
from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.blocks.connections import Connection, operated
from assistant.blocks.diagrams import Diagram, Port, RealTime, RunResult, run
from assistant.blocks.library.arms import tool_pose
from assistant.blocks.library.continuous_moves import Relative, RelCart, RelJoint, Status
from assistant.blocks.library.external_control import ExternalControl
from assistant.blocks.library.ports import tool_step
from assistant.blocks.library.sources import Constant, Table
from assistant.blocks.library.stopped_moves import JointMovJoint
from assistant.blocks.lock_step import LockStep
from assistant.blocks.setpoint_connections import SetpointSender, led, measured
from assistant.controllers import connect
from assistant.controllers.mitsubishi.control_mode import MEASURING_PROGRAM, program_texts
from assistant.controllers.trajectory_execution import LinkOptions
from assistant.program.geometry import Pose
from assistant.virtual.cr import VirtualCr
from assistant.virtual.events import Moved
from assistant.virtual.kernel.timed_arm import Track, track_of

ARM = robots.get("rv-2aj")
STEP = 0.1
PERCENT = 20.0
MOST = STEP * PERCENT / 100.0 * ARM.speeds
SLOW = 0.25
"""Pace at which an arm is behind its steps, however busy this computer is."""
NETWORK = ", ".join(f"OPT{i}" for i in range(12, 19)) + ", "


@dataclass
class Cell:
    """A virtual controller, how it is reached, and its lines of data: control and status."""

    virtual: VirtualCr
    address: str
    lines: tuple[str, str]

    def led(self, name: str = "cell", percent: float = PERCENT) -> Connection[SetpointSender]:
        return led(name, self.address, ARM, percent=percent, wishes=LinkOptions(lines=self.lines))

    @property
    def moves(self) -> list[Moved]:
        """The motions that the controller itself carried out."""
        machinery = self.virtual.state.machinery
        log = machinery.do(lambda: list(machinery.controller.kernel.log))
        return [row.what for row in log if isinstance(row.what, Moved)]

    @property
    def track(self) -> Track:
        """Its arm's own record."""
        machinery = self.virtual.state.machinery
        kernel = machinery.controller.kernel
        return machinery.do(lambda: track_of(machinery.arm, kernel.log, kernel.now))


@contextmanager
def cell(way: str = "sockets", pace: float = SLOW) -> Iterator[Cell]:
    """way: `sockets`, `serial link` for commands by a pty, `serial line` for setpoints by one."""
    framing: Literal["plain", "data link"] = "data link" if way == "serial line" else "plain"
    serial = way != "sockets"
    virtual = VirtualCr("rv-2aj", pace=pace, servo_time=0.02, serial=serial, framing=framing)
    if way != "serial line":
        virtual.state.parameters.write("COMDEV", NETWORK, all_levels=True)
    with virtual:
        first, second = [f"{host}:{port}" for host, port in virtual.data_ports.values()][:2]
        address = virtual.serial_address if way == "serial link" else virtual.address
        if way == "serial link":
            address += "?parity=none"
        lines = (virtual.serial_path, first) if way == "serial line" else (first, second)
        yield Cell(virtual, address, lines)


def gone(
    here: Cell,
    block: Callable[[Connection[SetpointSender]], Relative],
    by: list[float],
    steps: int,
    begin: list[float] | None = None,
) -> RunResult:
    """So many steps, each right behind the other, and until the arm is where they lead."""
    diagram, connection = Diagram(), here.led()
    diagram.add(Status("status", connection, ARM))
    rel = diagram.add(block(connection))
    diagram.wire(diagram.add(Constant("by", by)), (rel, "by"))
    ends = STEP * (steps - 0.5)
    go = diagram.add(Table("go", [0.0, ends - 1e-3, ends], [1.0, 1.0, 0.0], port=Port("value")))
    diagram.wire((go, "value"), (rel, "go"))

    def watch(now: float) -> bool:
        leader = connection.value
        assert leader is not None and connection.users == 2
        there = leader.measured().joints
        return now < ends + STEP or bool(np.abs(there - leader.told).max() > 0.02)

    ran = run(diagram, 60.0, STEP, clock=RealTime(), watch=watch, moving=["cell"])
    assert connection.users == 0
    assert ran["rel.steps"][-1] == steps
    return ran


def check_continuous(here: Cell, ran: RunResult, steps: int) -> None:
    """By the controller's own record: one motion a step, and no stop between them."""
    moves, track = here.moves, here.track
    assert len(moves) == steps
    assert all(one.kind == "joint" for one in moves)
    assert all(one.blend > 0.0 for one in moves[:-1])  # the last one ends at its target
    moving = np.flatnonzero(track.speed > 0.0)
    assert (np.diff(moving) == 1).all()
    # Not blocking: the last step was told while the arm was on its way.
    first, last = (int(np.argmax(ran["rel.steps"] == count)) for count in (1, steps))
    assert (np.diff(ran["rel.steps"][first : last + 1]) == 1.0).all()
    assert np.abs(ran["status.joints"][last] - ran["rel.told"][last]).max() > MOST.min()


WAYS = ["sockets", "serial line", pytest.param("serial link", marks=pytest.mark.slow)]


@pytest.mark.parametrize("way", WAYS)
def test_relative_joints_go_on_without_stops_and_wait_for_nothing(way: str) -> None:
    steps = 4
    with cell(way) as here:
        by = [*MOST[:1], 0.0, -MOST[2] / 2.0, 0.0, 0.0]
        ran = gone(here, lambda one: RelJoint("rel", one, ARM, most=10.0), by, steps)
        check_continuous(here, ran, steps)
        assert here.track.joints[-1] == pytest.approx(ARM.home + steps * np.array(by), abs=0.03)


def run_led(
    here: Cell, block: Callable[[Connection[SetpointSender]], Relative], rows: ArrayLike
) -> RunResult:
    """What a block does that is given a row of steps each step of the model."""
    rows = np.array(rows, dtype=float)
    diagram, connection = Diagram(), here.led()
    rel = diagram.add(block(connection))
    times = STEP * np.arange(len(rows))
    if len(rows) == 1:
        diagram.wire(diagram.add(Constant("by", rows[0])), (rel, "by"))
    else:
        by = diagram.add(Table("by", times, rows, port=Port("value", rows.shape[1])))
        diagram.wire((by, "value"), (rel, "by"))
    diagram.wire(diagram.add(Constant("go", 1.0)), (rel, "go"))
    try:
        return run(diagram, times[-1], STEP, clock=RealTime(), moving=["cell"])
    finally:
        assert connection.users == 0


FAR, FAST = [6.0, 0.0, 0.0, 0.0, 0.0], [2.0 * MOST[0], 0.0, 0.0, 0.0, 0.0]
AWAY = [0.0, 0.0, 0.0, 0.0, 5.5, 0.0]
REFUSED: Final[dict[str, tuple[str, Any, dict[str, Any], Any]]] = {
    "one step too far": ("BL207", RelJoint, {}, [FAR]),
    "turned too far": ("BL207", RelCart, {}, [AWAY]),
    "too fast": ("BL208", RelJoint, {"most": 90.0}, [[0.0] * 5, FAST]),
    "outside its limits": ("BL202", RelJoint, {"most": 360.0}, [[-200.0, 0.0, 0.0, 0.0, 0.0]]),
    "out of reach": ("BL209", RelCart, {"most": (900.0, 5.0)}, [[0.0, 0.0, 800.0, 0.0, 0.0, 0.0]]),
    "turned too far by a quaternion": ("BL207", RelCart, {}, [[0, 0, 0, 0.9, -0.4358899, 0, 0]]),
    "no turn": ("BL211", RelCart, {}, [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]]),
    "no numbers": ("BL203", RelJoint, {}, [[np.nan, 0.0, 0.0, 0.0, 0.0]]),
}


@pytest.fixture(scope="module")
def shared() -> Iterator[Cell]:
    with cell(pace=4.0) as here:
        yield here


@pytest.mark.one_in(3)
@pytest.mark.parametrize("what", REFUSED)
def test_steps_beyond_what_is_allowed_end_the_run_before_they_are_told(
    shared: Cell, what: str
) -> None:
    code, kind, bounds, rows = REFUSED[what]
    before = len(shared.moves)
    with pytest.raises(Refused, match=code):
        run_led(shared, lambda one: kind("rel", one, ARM, **bounds), rows)
    assert len(shared.moves) == before


def test_nothing_is_opened_that_nobody_confirmed(shared: Cell) -> None:
    diagram, connection = Diagram(), shared.led()
    rel = diagram.add(RelJoint("rel", connection, ARM))
    diagram.wire(diagram.add(Constant("by", np.zeros(5))), (rel, "by"))
    diagram.wire(diagram.add(Constant("go", 1.0)), (rel, "go"))
    with pytest.raises(Refused, match=r"BL111.*`cell`"):
        run(diagram, 1.0, STEP)
    assert connection.value is None and shared.moves == []


@pytest.mark.parametrize("seconds", [30.0, 1.0])
def test_an_emergency_stop_ends_the_run_and_is_told(seconds: float) -> None:
    """Also by a run that is over before the silence is long enough."""
    with cell(pace=1.0) as here:
        diagram, connection = Diagram(), here.led()
        diagram.add(Status("status", connection, ARM))
        rel = diagram.add(RelJoint("rel", connection, ARM, most=10.0))
        diagram.wire(diagram.add(Constant("by", [*MOST[:1], 0.0, 0.0, 0.0, 0.0])), (rel, "by"))
        diagram.wire(diagram.add(Constant("go", 1.0)), (rel, "go"))

        def watch(now: float) -> bool:
            if 0.45 < now < 0.55:
                here.virtual.emergency_stop()
            return True

        with pytest.raises(Refused, match=r"CN6\d\d"):
            run(diagram, seconds, STEP, clock=RealTime(), watch=watch, moving=["cell"])
        assert connection.users == 0
        assert here.track.speed[-1] == 0.0


def test_lines_that_go_by_real_time_take_no_lock_step() -> None:
    with VirtualCr("rv-2aj", lock_step=True) as virtual:
        host, port = virtual.data_ports["COM2:"]
        line = measured("line", f"{host}:{port}", ARM, address=virtual.address)
        diagram = Diagram()
        diagram.add(Status("status", line, ARM))
        clock = LockStep(virtual, connections=[line], begins=1.0)
        with pytest.raises(Refused, match=r"BL204.*`line`"):
            run(diagram, 1.0, STEP, clock=clock)
        assert line.users == 0


def test_other_ways_and_controllers_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROBOT_ASSISTANT_PASSWORD", "secret")
    with pytest.raises(Refused, match=r"BL205.*`jog`"):
        led("cell", "melfa://127.0.0.1", ARM, by="jog")
    with pytest.raises(Refused, match="BL206"):
        measured("cell", "127.0.0.1:10003", ARM, address="ftp://u@127.0.0.1:1").take()


def test_a_step_of_the_tool_is_exact_for_six_axes_in_either_frame() -> None:
    robot, tool = robots.get("irb1200-7-0.7"), Pose((10.0, 0.0, 80.0))
    joints = np.array([10.0, 20.0, 15.0, 30.0, 50.0, -20.0])
    by = np.array([5.0, -8.0, 3.0, 1.0, -2.0, 1.5])
    start = tool_pose(robot, tool, joints)
    turn = rotations.about(by[3:] / np.linalg.norm(by[3:]), np.linalg.norm(by[3:]))
    connection: Connection[SetpointSender] = led("cell", "melfa://127.0.0.1", robot)
    for in_tool in (False, True):
        block = RelCart("rel", connection, robot, tool=tool, in_tool=in_tool)
        found = tool_pose(robot, tool, block.stepped(joints, by))
        way = rotations.rotate(start[3:], by[:3]) if in_tool else by[:3]
        order = (start[3:], turn) if in_tool else (turn, start[3:])
        assert found[:3] == pytest.approx(start[:3] + way, abs=1e-6)
        assert rotations.angle_between(found[3:], rotations.multiply(*order)) < 1e-6


def test_a_step_of_seven_numbers_is_that_of_six() -> None:
    vector = np.array([1.0, -2.0, 1.5])
    angle = float(np.linalg.norm(vector))
    half = math.radians(angle) / 2.0
    turn = [math.cos(half), *(math.sin(half) * vector / angle)]
    for sign in (1.0, -1.0):
        seven = np.array([5.0, -8.0, 3.0, *(sign * part for part in turn)])
        assert tool_step("rel", seven) == pytest.approx([5.0, -8.0, 3.0, *vector])
    assert tool_step("rel", np.array([0.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0])).tolist() == [
        0,
        0,
        2,
        0,
        0,
        0,
    ]
    with pytest.raises(Refused, match="BL211"):
        tool_step("rel", np.array([0.0, 0.0, 2.0, 2.0, 0.0, 0.0, 0.0]))


@pytest.mark.slow
def test_a_slot_that_always_runs_measures_beside_moves_that_block(tmp_path: Path) -> None:
    with VirtualCr("rv-2aj", folder=tmp_path) as first, connect(first.address) as session:
        session.write(MEASURING_PROGRAM, program_texts([MEASURING_PROGRAM])[MEASURING_PROGRAM])
    virtual = VirtualCr("rv-2aj", folder=tmp_path, servo_time=0.02)
    virtual.state.parameters.write("SLT2", f"{MEASURING_PROGRAM}, REP, ALWAYS, 1", all_levels=True)
    with virtual:
        host, port = virtual.data_ports["COM2:"]
        for _ in range(2):
            diagram = Diagram()
            moving = operated("cell", virtual.address, override=20)
            status = diagram.add(Status("s", measured("line", f"{host}:{port}", ARM), ARM))
            move = diagram.add(JointMovJoint("m", moving, ARM))
            goal = [20.0 - virtual.state.joints[0], 0.0, 90.0, 0.0, 90.0, 0.0]
            diagram.wire(diagram.add(Constant("goal", goal)), (move, "target"))
            diagram.wire(diagram.add(Constant("on", 1.0)), (move, "start"))

            def watch(now: float, move: JointMovJoint = move) -> bool:
                return not now or move._done < 1

            ran = run(diagram, 30.0, 0.05, clock=RealTime(), moving=["cell"], watch=watch)
            joints = ran["s.joints"][:, 0]
            assert status.moves == "" and joints[-1] == pytest.approx(goal[0], abs=0.02)
            between = np.abs(joints - joints[0]) % 20.0 > 0.05
            assert (ran["m.busy"][between] == 1.0).all() and between.sum() > 5
            track = Cell(virtual, virtual.address, ("", "")).track
            assert np.nanmax(ran["s.speed"]) == pytest.approx(track.speed.max(), rel=0.05)


@pytest.mark.slow
def test_an_arm_is_led_cycle_by_cycle_as_well() -> None:
    with cell(pace=1.0) as here:
        wishes = LinkOptions(port=here.virtual.mxt_port)
        connection = led("cell", here.address, ARM, by="mxt", percent=PERCENT, wishes=wishes)
        diagram = Diagram()
        diagram.add(Status("status", connection, ARM))
        rel = diagram.add(RelJoint("rel", connection, ARM))
        diagram.wire(diagram.add(Constant("by", [1.0, 0.0, 0.0, 0.0, 0.0])), (rel, "by"))
        go = diagram.add(Table("go", [0.0, 0.95, 1.0], [1.0, 1.0, 0.0], port=Port("value")))
        diagram.wire((go, "value"), (rel, "go"))
        ran = run(diagram, 2.0, STEP, clock=RealTime(), moving=["cell"])
        assert ran["rel.steps"][-1] == 10.0
        assert ran["status.joints"][-1, 0] == pytest.approx(10.0, abs=0.05)
        assert np.isnan(ran["status.speed"]).all()


@pytest.mark.parametrize("bound", [math.nan, -1.0])
def test_bounds_that_bound_nothing_are_refused(shared: Cell, bound: float) -> None:
    connection: Any = shared.led()
    for make in (
        lambda: RelJoint("rel", connection, ARM, most=bound),
        lambda: RelCart("rel", connection, ARM, most=(5.0, bound)),
        lambda: ExternalControl("external", connection, ARM, approach=bound),
    ):
        with pytest.raises(Refused, match="give a number from 0"):
            make()

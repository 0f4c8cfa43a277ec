"""The five moves of the paper, on a virtual CR controller over real sockets and a serial line."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from numpy.typing import ArrayLike

from assistant import robots
from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.blocks.connections import operated
from assistant.blocks.diagrams import Diagram, Port, RealTime, RunResult, run
from assistant.blocks.library.ports import controller_pose
from assistant.blocks.library.sources import Constant, Table
from assistant.blocks.library.stopped_moves import (
    CircularMov,
    JointMovCart,
    JointMovJoint,
    LinMovCart,
    LinMovJoint,
    Move,
)
from assistant.controllers import connect
from assistant.controllers.controller import Controller
from assistant.program.geometry import Pose
from assistant.robots import Robot
from assistant.virtual.cr import VirtualCr
from assistant.virtual.events import Moved

ARM = robots.get("rv-2aj")
STEP = 0.02
PACE = 10.0


@pytest.fixture
def cell() -> Iterator[VirtualCr]:
    with VirtualCr("rv-2aj", pace=PACE) as controller:
        yield controller


def moved(
    address: str, kind: type[Move], ways: Sequence[Sequence[ArrayLike]], seconds: float = 1.0
) -> RunResult:
    """A block that is given targets one after the other; it ends when it has been at the last."""
    diagram = Diagram()
    connection = operated("cell", address, override=50)
    block = diagram.add(kind("move", connection, ARM, period=STEP))
    times = np.linspace(0.0, seconds, len(ways[0]), endpoint=False)
    for way, rows in zip(kind.ways, ways, strict=True):
        held = np.repeat(np.array(rows, dtype=float), 2, axis=0)
        at = np.column_stack([times, np.append(times[1:], 1e3) - 1e-3]).ravel()
        source = diagram.add(Table(way, at, held, port=Port("value", held.shape[1])))
        diagram.wire((source, "value"), (block, way))
    diagram.wire(diagram.add(Constant("on", 1.0)), (block, "start"))
    ended: list[float] = []

    def watch(now: float) -> bool:
        del now
        return len(ended) < len(ways[0])

    def counted(now: float) -> bool:
        if block._done > len(ended):
            ended.append(now)
        return watch(now)

    ran = run(diagram, 20.0, STEP, clock=RealTime(), watch=counted, moving=["cell"])
    assert connection.users == 0
    return ran


def commanded(cell: VirtualCr) -> list[Moved]:
    """The motions that the controller itself carried out."""
    machinery = cell.state.machinery
    log = machinery.do(lambda: list(machinery.controller.kernel.log))
    return [row.what for row in log if isinstance(row.what, Moved)]


LOW, HIGH = [0, 10, 80, 0, 60, 0], [20, 0, 90, 0, 90, 0]
OUT, BESIDE, BACK = [360, 0, 300, 0, 180, 0], [330, 60, 300, 0, 180, 0], [300, 100, 300, 0, 180, 0]


@pytest.mark.parametrize(("kind", "way"), [(JointMovJoint, "joint"), (LinMovJoint, "linear")])
def test_joints_are_gone_to_one_after_the_other(
    cell: VirtualCr, kind: type[Move], way: str
) -> None:
    ran = moved(cell.address, kind, [[LOW, HIGH]])
    assert [(one.kind, one.blend) for one in commanded(cell)] == [(way, 0.0)] * 2  # it stops
    assert ran["move.joints"][-1] == pytest.approx(HIGH, abs=0.02)
    done, busy = ran["move.done"], ran["move.busy"]
    assert busy[np.searchsorted(done, 1) - 1] == 1.0  # until it ended


@pytest.mark.parametrize(("kind", "way"), [(JointMovCart, "joint"), (LinMovCart, "linear")])
def test_poses_are_gone_to_one_after_the_other(cell: VirtualCr, kind: type[Move], way: str) -> None:
    ran = moved(cell.address, kind, [[OUT, BACK]])
    moves = commanded(cell)
    assert [(one.kind, one.blend) for one in moves] == [(way, 0.0)] * 2
    for one, pose in zip(moves, (OUT, BACK), strict=True):
        assert one.flange is not None
        assert one.flange.position == pytest.approx(pose[:3], abs=0.02)
    joints = ran["move.joints"][-1]
    assert ARM.fk(joints[list(ARM.places)])[0][0] == pytest.approx(BACK[:3], abs=0.1)


def test_an_arc_goes_by_way_of_a_pose(cell: VirtualCr) -> None:
    with_start = [[OUT, BESIDE], [OUT, BACK]]
    moved(cell.address, JointMovCart, [[OUT]])
    moved(cell.address, CircularMov, [with_start[0][1:], with_start[1][1:]])
    arc = commanded(cell)[-1]
    assert (arc.kind, arc.blend) == ("circular", 0.0)
    assert arc.via is not None and arc.flange is not None
    assert arc.via.position == pytest.approx(BESIDE[:3], abs=0.02)
    assert arc.flange.position == pytest.approx(BACK[:3], abs=0.02)


def test_a_serial_line_carries_the_same() -> None:
    with VirtualCr("rv-2aj", pace=PACE, serial=True) as cell:
        ran = moved(cell.serial_address, JointMovJoint, [[LOW]])
        assert ran["move.joints"][-1] == pytest.approx(LOW, abs=0.02)


def test_two_blocks_share_a_connection_and_two_robots_have_two(cell: VirtualCr) -> None:
    with VirtualCr("rv-2aj", pace=PACE) as other:
        diagram = Diagram()
        shared = operated("cell", cell.address, override=50)
        lone = operated("other", other.address, override=50)
        on = diagram.add(Constant("on", 1.0))
        blocks = []
        for name, connection, kind, goal in (
            ("first", shared, JointMovJoint, LOW),
            ("second", shared, LinMovJoint, HIGH),
            ("third", lone, JointMovJoint, HIGH),
        ):
            block = diagram.add(kind(name, connection, ARM))
            diagram.wire(diagram.add(Constant(f"to {name}", goal, "deg")), (block, "target"))
            diagram.wire(on, (block, "start"))
            blocks.append(block)
        most = []

        def watch(now: float) -> bool:
            del now
            most.append(shared.users)
            return not all(block._done for block in blocks)

        run(diagram, 20.0, STEP, clock=RealTime(), watch=watch, moving=["cell", "other"])
        assert set(most) == {2}
        assert (shared.users, lone.users) == (0, 0)
        assert [one.kind for one in commanded(cell)] == ["joint", "linear"]
        assert [one.kind for one in commanded(other)] == ["joint"]


def test_nothing_moves_that_nobody_confirmed(cell: VirtualCr) -> None:
    diagram = Diagram()
    block = diagram.add(JointMovJoint("move", operated("cell", cell.address), ARM))
    diagram.wire(diagram.add(Constant("to", LOW)), (block, "target"))
    diagram.wire(diagram.add(Constant("on", 1.0)), (block, "start"))
    with pytest.raises(Refused, match=r"BL111.*`cell`"):
        run(diagram, 1.0, STEP)
    assert commanded(cell) == []


@pytest.mark.parametrize(
    ("target", "code"), [([0, 200, 0, 0, 0, 0], "BL202"), ([0, np.nan, 0, 0, 0, 0], "BL203")]
)
def test_no_place_that_is_none_is_gone_to(
    cell: VirtualCr, target: Sequence[float], code: str
) -> None:
    diagram = Diagram()
    block = diagram.add(JointMovJoint("move", operated("cell", cell.address), ARM))
    diagram.wire(diagram.add(Constant("to", target)), (block, "target"))
    diagram.wire(diagram.add(Constant("on", 1.0)), (block, "start"))
    with pytest.raises(Refused, match=code):
        run(diagram, 1.0, STEP, moving=["cell"])
    assert commanded(cell) == []


def test_a_run_that_ends_stops_the_arm_on_its_way(cell: VirtualCr) -> None:
    diagram = Diagram()
    block = diagram.add(JointMovJoint("move", operated("cell", cell.address, override=1), ARM))
    diagram.wire(diagram.add(Constant("to", HIGH)), (block, "target"))
    diagram.wire(diagram.add(Constant("on", 1.0)), (block, "start"))
    begun: list[float] = []

    def watch(now: float) -> bool:
        if commanded(cell):
            begun.append(now)
        return len(begun) < 3

    run(diagram, 20.0, STEP, clock=RealTime(), watch=watch, moving=["cell"])
    there = cell.state.machinery.joints()
    assert np.abs(np.array(there) - np.array(HIGH)[list(ARM.places)]).max() > 1.0
    assert tuple(cell.state.machinery.joints()) == tuple(there)  # it stands
    with connect(cell.address) as session:
        assert isinstance(session, Controller)
        assert not session.state().motors


@pytest.mark.parametrize("line", ["serial", "lost"])
def test_no_arm_goes_on_behind_a_run_on_a_line_that_takes_no_other_or_is_lost(line: str) -> None:
    """Somebody interrupts a move on a serial line; an answer comes too late for the time-out."""
    with VirtualCr("rv-2aj", pace=1.0, serial=line == "serial") as cell:
        address = cell.serial_address if line == "serial" else cell.address
        late = 0.4 if line == "lost" else 60.0
        connection = operated("cell", address, override=3, timeout=late)
        diagram = Diagram()
        block = diagram.add(JointMovJoint("move", connection, ARM))
        diagram.wire(diagram.add(Constant("to", [140, 0, 0, 0, 0, 0])), (block, "target"))
        diagram.wire(diagram.add(Constant("on", 1.0)), (block, "start"))

        def interrupted(now: float) -> bool:
            if line == "serial" and now > 0.4:
                raise KeyboardInterrupt
            return True

        lost = pytest.raises(Refused, match=r"^CN204.*executing `MOV J99`")
        with pytest.raises(KeyboardInterrupt) if line == "serial" else lost:
            run(diagram, 8.0, STEP, clock=RealTime(), watch=interrupted, moving=["cell"])
        there = cell.state.machinery.joints()
        assert there[0] < 100.0
        with connect(cell.address) as session:
            assert isinstance(session, Controller)
            assert not session.state().running
        assert tuple(cell.state.machinery.joints()) == tuple(there)
        assert connection.users == 0


def with_quaternion(pose: Sequence[float]) -> list[float]:
    """The pose (7,) of X, Y, Z, A, B, C of the arm, by its own controller's reading of them."""
    made = pose_of_values(tuple(map(float, pose)), ARM)
    return [*made.position, *made.quaternion]


def pose_of_values(values: tuple[float, ...], robot: Robot) -> Pose:
    """For five axes R = Rz(azimuth)·Ry(B)·Rz(A - azimuth·cos B), written out with matrices."""
    x, y, z, a, b, c = values
    if not robot.five_axis:
        return Pose.of_matrix(turn("z", c) @ turn("y", b) @ turn("x", a), (x, y, z))
    azimuth = math.degrees(math.atan2(y, x))
    roll = a - azimuth * math.cos(math.radians(b))
    return Pose.of_matrix(turn("z", azimuth) @ turn("y", b) @ turn("z", roll), (x, y, z))


def turn(axis: str, degrees: float) -> np.ndarray:
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    matrices = {
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }
    return np.array(matrices[axis])


FORWARD = [300, 100, 350, 20, 120, 0]


def test_seven_numbers_go_where_the_six_of_the_controller_go(cell: VirtualCr) -> None:
    moved(cell.address, JointMovCart, [[OUT, FORWARD]])
    six = commanded(cell)
    moved(cell.address, LinMovCart, [[with_quaternion(OUT), with_quaternion(FORWARD)]])
    seven = commanded(cell)[len(six) :]
    assert len(six) == len(seven) == 2
    for one, other in zip(six, seven, strict=True):
        assert one.flange is not None and other.flange is not None
        assert one.flange.position == pytest.approx(other.flange.position, abs=0.02)
        assert rotations.angle_between(one.flange.quaternion, other.flange.quaternion) < 0.02


@pytest.mark.slow
def test_an_arc_takes_one_pose_of_each_form(cell: VirtualCr) -> None:
    moved(cell.address, JointMovCart, [[OUT]])
    moved(cell.address, CircularMov, [[with_quaternion(BESIDE)], [with_quaternion(BACK)]])
    arc = commanded(cell)[-1]
    assert arc.kind == "circular" and arc.via is not None and arc.flange is not None
    assert arc.via.position == pytest.approx(BESIDE[:3], abs=0.02)
    assert arc.flange.position == pytest.approx(BACK[:3], abs=0.02)


def test_an_arm_of_six_axes_has_a_b_and_c() -> None:
    six, angles = robots.get("rv-4frl"), (400.0, 100.0, 300.0, 170.0, 20.0, -30.0)
    made = pose_of_values(angles, six)
    found = controller_pose("move", six, np.array([*made.position, *made.quaternion]), "7,0)")
    assert found == pytest.approx(angles)
    assert controller_pose("move", six, np.array(angles), "7,0)").tolist() == list(angles)


@pytest.mark.parametrize(
    ("pose", "posture", "code"),
    [
        ([360, 0, 300, 0, 0, 0, 0], "6,0)", "BL211"),
        ([360, 0, 300, 0, 0, 2, 0], "6,0)", "BL211"),
        ([360, 0, 300, 0, math.nan, 1, 0], "6,0)", "BL203"),
        ([360, 0, 300, 0.9659258, 0.2588190, 0, 0], "6,0)", "BL212"),  # tilted to the side
        (with_quaternion(FORWARD), "2,0)", "BL212"),  # over its back, not vertical
    ],
)
def test_a_quaternion_that_is_no_turn_of_the_arm_is_refused(pose, posture: str, code: str) -> None:
    with pytest.raises(Refused) as caught:
        controller_pose("move", ARM, np.array(pose, dtype=float), posture)
    assert [one.code for one in caught.value.findings] == [code]


def test_a_vertical_tool_is_told_over_the_back_too() -> None:
    found = controller_pose("move", ARM, np.array(with_quaternion(OUT)), "2,0)")
    assert found[:3].tolist() == OUT[:3] and abs(found[4]) == pytest.approx(180)


def test_another_size_is_refused_with_the_numbers_that_are_wanted() -> None:
    diagram = Diagram()
    block = diagram.add(LinMovCart("move", operated("cell", "melfa://127.0.0.1:9"), ARM))
    source = diagram.add(Table("way", [0.0], [[1.0] * 5], port=Port("value", 5)))
    diagram.wire((source, "value"), (block, "target"))
    with pytest.raises(Refused, match="6 or 7: X, Y, Z in mm and A, B, C in degrees"):
        diagram.plan()

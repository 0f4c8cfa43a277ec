"""Models in lock step with virtual controllers, over their real sockets."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.blocks.bdsim_adapter import run_bdsim, run_paced
from assistant.blocks.connections import operated
from assistant.blocks.diagrams import Diagram, run
from assistant.blocks.library.sources import Constant, Table
from assistant.blocks.library.stopped_moves import JointMovJoint, LinMovJoint
from assistant.blocks.lock_step import LockStep
from assistant.robots.timing import drive_of
from assistant.virtual.cr import VirtualCr
from assistant.virtual.cr.session import Faults

ARM = robots.get("rv-2aj")
STEP, SECONDS = 0.01, 5.0
FIRST, SECOND = [0.0, 10.0, 80.0, 0.0, 60.0, 0.0], [20.0, 0.0, 90.0, 0.0, 90.0, 30.0]
GOALS = [0.0, 2.5, 2.51, SECONDS], [FIRST, FIRST, SECOND, SECOND]


def moved(*kinds, seconds=SECONDS, late=0.0):
    """A diagram with an arm of its own for each kind of move, run in lock step."""
    cells = [
        VirtualCr("rv-2aj", lock_step=True, faults=Faults(delay=late)) for _ in range(len(kinds))
    ]
    diagram = Diagram()
    start = diagram.add(Constant("start", 1.0))
    connections = []
    try:
        for number, (cell, kind) in enumerate(zip(cells, kinds, strict=True)):
            cell.start()
            connections.append(operated(f"cell{number}", cell.address, override=50))
            goals = diagram.add(Table(f"goals{number}", *GOALS))
            move = diagram.add(kind(f"move{number}", connections[-1], ARM))
            diagram.wire((goals, "value"), (move, "target"))
            diagram.wire(start, (move, "start"))
        clock = LockStep(*cells, connections=connections)
        ran = run(diagram, seconds, STEP, clock=clock, moving=[one.name for one in connections])
    finally:
        for cell in cells:
            cell.stop()
    assert [one.users for one in connections] == [0] * len(kinds)
    return ran


def same(one, other):
    return one.columns.keys() == other.columns.keys() and all(
        np.array_equal(one.columns[name], other.columns[name], equal_nan=True)
        for name in one.columns
    )


def test_the_same_model_gives_the_same_columns_each_time_and_faster_than_it_lasts(tell):
    began = time.monotonic()
    first = moved(JointMovJoint)
    took = time.monotonic() - began
    tell(f"lock step: {SECONDS:g} s of a model with a virtual CR controller in {took:.2f} s")
    assert first["move0.done"][-1] == 2.0
    assert first["move0.joints"][-1] == pytest.approx(SECOND, abs=0.01)
    assert first.late == 0
    assert same(first, moved(JointMovJoint))
    assert same(first, moved(JointMovJoint, late=0.002))  # on slow lines too


def test_moves_take_as_long_as_the_axes_need():
    """By the closed form of the slowest axis, at half speed, and a step until it is seen."""
    busy = moved(JointMovJoint)["move0.busy"]
    begins, ends = np.flatnonzero(np.diff(busy) > 0), np.flatnonzero(np.diff(busy) < 0)
    lasted = (ends - begins) * STEP
    drive, places = drive_of(ARM), list(ARM.places)
    at = np.array([ARM.home, np.array(FIRST)[places], np.array(SECOND)[places]])
    for way, took in zip(np.abs(np.diff(at, axis=0)), lasted, strict=True):
        turning = way > 0.0
        rise, way = drive.accelerations[turning], way[turning]
        peak = np.minimum(0.5 * drive.speeds[turning], np.sqrt(rise * way))
        assert 0.0 <= took - (way / peak + peak / rise).max() <= 1.5 * STEP


def test_two_arms_keep_step_in_one_model():
    both = moved(JointMovJoint, LinMovJoint)
    assert both["move0.done"][-1] == both["move1.done"][-1] == 2.0
    alone = moved(JointMovJoint)
    for port in ("busy", "done", "joints"):
        assert np.array_equal(both[f"move0.{port}"], alone[f"move0.{port}"], equal_nan=True)


def test_other_work_of_the_computer_changes_nothing():
    over = threading.Event()

    def work():
        while not over.is_set():
            sum(range(2000))
            time.sleep(0.0002)

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    try:
        busy = moved(JointMovJoint, seconds=0.2)
    finally:
        over.set()
        for thread in threads:
            thread.join()
    assert same(busy, moved(JointMovJoint, seconds=0.2))


def test_a_line_on_which_nothing_arrives_is_told():
    with VirtualCr("rv-2aj", lock_step=True) as cell:
        diagram = Diagram()
        connection = operated("cell", cell.address)
        goal, start = diagram.add(Constant("goal", FIRST)), diagram.add(Constant("start", 1.0))
        move = diagram.add(JointMovJoint("move", connection, ARM))
        diagram.wire(goal, (move, "target"))
        diagram.wire(start, (move, "start"))
        clock = LockStep(cell, connections=[connection], patience=0.02)

        def slow(now):
            cell.faults.delay = 0.05
            return True

        with pytest.raises(Refused, match="BL204"):
            run(diagram, 1.0, STEP, clock=clock, moving=["cell"], watch=slow)
        assert connection.users == 0
        # Its time passes again, so that the stop that ends the run is answered.
        assert not cell.executing
        assert not cell.state.servo


def test_bdsim_in_lock_step_gives_its_results_and_our_columns_alike():
    bdsim = pytest.importorskip("bdsim")
    sim = bdsim.BDSim(
        packages="assistant", toolboxes=False, graphics=False, progress=False, quiet=True,
        sysargs=False, hold=False,
    )  # fmt: skip

    def model(cell):
        diagram = sim.blockdiagram()
        connection = operated("cell", cell.address, override=50)
        goal = diagram.CONSTANT(np.array(FIRST))
        move = diagram.JOINTMOVJOINT(diagram.clock(STEP), connection, ARM, "move")
        diagram.connect(goal, move[0])
        diagram.connect(diagram.CONSTANT(1.0), move[1])
        diagram.compile(verbose=False)
        return diagram, move, LockStep(cell, connections=[connection])

    with VirtualCr("rv-2aj", lock_step=True) as cell:
        diagram, _, clock = model(cell)
        ours = run_paced(sim, diagram, 1.0, STEP, clock=clock, moving=["cell"])
    with VirtualCr("rv-2aj", lock_step=True) as cell:
        diagram, move, clock = model(cell)
        theirs = run_bdsim(
            sim, diagram, 1.0, clock=clock, moving=["cell"], watch=[move[0], move[1], move[2]]
        )
    assert ours["move[1]"][-1] == 1.0
    at = np.rint(theirs.t / STEP).astype(int)
    kept = at < len(ours.seconds)
    assert kept.sum() > 90
    found = np.column_stack([ours.columns[f"move[{i}]"] for i in range(3)])[at[kept]]
    assert np.array_equal(found, theirs.y[kept], equal_nan=True)

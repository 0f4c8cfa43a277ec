"""Inputs, outputs and grippers of virtual controllers of both makers, over their real protocols."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from assistant.base.diagnostics import Refused
from assistant.blocks.connections import Asked, Connection, asked
from assistant.blocks.diagrams import Block, Diagram, RealTime, RunResult, run
from assistant.blocks.library.controller_io import Gripper, Hand, Output, Signals, Valve
from assistant.blocks.library.sources import Constant, Table
from assistant.blocks.lock_step import LockStep
from assistant.controllers import connect
from assistant.controllers.controller import Controller
from assistant.virtual.cr import VirtualCr
from assistant.virtual.irc5 import Signal, VirtualIrc5

STEP = 0.01
Cell = Connection[Asked[Controller]]


@pytest.fixture
def cr() -> Iterator[VirtualCr]:
    with VirtualCr("rv-2aj", pace=10.0) as controller:
        yield controller


def set_input(cell: VirtualCr, name: str, value: float) -> None:
    cell.state.machinery.do(lambda: cell.state.board.inputs.set(name, value))


def output(cell: VirtualCr, name: str) -> float:
    return cell.state.machinery.do(lambda: cell.state.board.outputs.read(name))


def alone(block: Block, value: float | None = None) -> Diagram:
    diagram = Diagram()
    diagram.add(block)
    if value is not None:
        diagram.wire(diagram.add(Constant("value", value)), block)
    return diagram


def until(done: Callable[[], bool]) -> Callable[[float], bool]:
    """Ends a run a few steps after something is so."""
    left = [3]

    def watch(now: float) -> bool:
        del now
        left[0] -= done()
        return left[0] > 0

    return watch


def ran(
    diagram: Diagram, cell: Cell, watch: Callable[[float], bool], seconds: float = 10.0
) -> RunResult:
    found = run(diagram, seconds, STEP, clock=RealTime(), watch=watch, moving=[cell.name])
    assert cell.users == 0
    return found


def test_inputs_are_read_while_the_model_goes_on(cr: VirtualCr) -> None:
    connection = asked("cell", cr.address)
    block = Signals("inputs", connection, ["3", "4"])
    set_input(cr, "4", 1.0)
    seen: list[float] = []

    def watch(now: float) -> bool:
        del now
        values = block._values
        if values[1] == 1.0 and not seen:
            set_input(cr, "3", 1.0)
            seen.append(values[0])
        return not (seen and values[0] == 1.0)

    found = ran(alone(block), connection, watch)
    assert seen == [0.0]
    assert np.isnan(found["inputs.values"][0]).all()
    assert [0.0, 1.0] in found["inputs.values"].tolist()
    assert found["inputs.values"][-1].tolist() == [1.0, 1.0]
    ages = found["inputs.age"][np.isfinite(found["inputs.age"])]
    assert (ages > 0.0).all()


def test_one_name_is_one_signal_and_a_gripper_has_to_confirm_in_some_time(cr: VirtualCr) -> None:
    cell = asked("cell", cr.address)
    assert Signals("inputs", cell, "12").names == ("12",)
    with pytest.raises(ValueError, match="`within`"):
        Gripper("gripper", cell, Hand(1), closed="5", within=np.nan)


def test_an_output_is_set_once_and_what_is_refused_ends_the_run(cr: VirtualCr) -> None:
    connection = asked("cell", cr.address)
    block = Output("lamp", connection, "7")
    found = ran(alone(block, 1.0), connection, until(lambda: block._set == 1.0))
    assert output(cr, "7") == 1.0
    assert found["lamp.set"][-1] == 1.0
    with pytest.raises(Refused, match=r"0 or 1"):
        ran(alone(Output("lamp", connection, "7"), 2.0), connection, lambda now: True)
    assert connection.users == 0
    with pytest.raises(Refused, match=r"BL111.*`cell`"):
        run(alone(Output("lamp", connection, "7"), 0.0), 1.0, STEP)


def test_a_hand_closes_and_opens(cr: VirtualCr) -> None:
    connection = asked("cell", cr.address)
    diagram = Diagram()
    gripper = diagram.add(Gripper("gripper", connection, Hand(1)))
    diagram.wire(
        (diagram.add(Table("close", [0.0, 0.2, 0.201], [1.0, 1.0, 0.0])), "value"), gripper
    )
    hands: list[bool] = []

    def watch(now: float) -> bool:
        hands.append(cr.state.hands[1])
        return now < 0.25 or gripper._state != 0.0

    found = ran(diagram, connection, watch)
    assert False in hands and cr.state.hands[1] is True
    states = found["gripper.state"]
    assert states[0] == 0.5 and 1.0 in states and states[-1] == 0.0
    assert (found["gripper.confirmed"] == (found["gripper.busy"] == 0.0))[2:].all()


def gripping(cr: VirtualCr, within: float = 10.0) -> tuple[Cell, Gripper]:
    """Closed by output 5, confirmed by inputs 8 (open) and 9 (closed)."""
    connection = asked("cell", cr.address)
    by = Valve("5")
    return connection, Gripper("gripper", connection, by, opened="8", closed="9", within=within)


def test_a_gripper_is_confirmed_by_its_inputs_and_a_part_that_is_lost_is_seen(
    cr: VirtualCr,
) -> None:
    connection, gripper = gripping(cr)
    lost: list[float] = []

    def watch(now: float) -> bool:
        if gripper._state == 1.0 and not lost:
            set_input(cr, "9", 0.0)
            lost.append(now)
        elif output(cr, "5") == 1.0 and not lost:
            set_input(cr, "9", 1.0)
        return not (lost and gripper._state == 0.5)

    found = ran(alone(gripper, 1.0), connection, watch)
    assert lost and 1.0 in found["gripper.confirmed"]
    states = found["gripper.state"]
    assert states[0] == 0.5 and 1.0 in states


def test_a_gripper_that_does_not_confirm_ends_the_run(cr: VirtualCr) -> None:
    connection, gripper = gripping(cr, within=0.1)
    with pytest.raises(Refused, match=r"BL505.*close"):
        ran(alone(gripper, 1.0), connection, lambda now: True)
    connection, gripper = gripping(cr)
    set_input(cr, "8", 1.0)
    set_input(cr, "9", 1.0)
    with pytest.raises(Refused, match="BL506"):
        ran(alone(gripper, 1.0), connection, lambda now: True)


def test_signals_have_names_where_a_controller_names_them(tmp_path: Path) -> None:
    signals = [Signal("doGrip", "DO"), Signal("diPart", "DI")]
    with VirtualIrc5(tmp_path / "home", signals=signals) as cell:
        connection = asked("cell", cell.rws_address, password=cell.password)
        diagram = Diagram()
        grip = diagram.add(Gripper("grip", connection, Valve("doGrip")))
        diagram.wire(diagram.add(Constant("close", 1.0)), grip)
        part = diagram.add(Signals("part", connection, ["diPart"]))
        done = until(lambda: grip._state == 1.0 and bool(np.isfinite(part._values).all()))
        found = ran(diagram, connection, done)
        assert found["grip.confirmed"][-1] == 1.0 and found["part.values"][-1] == 0.0
        with connect(cell.rws_address, password=cell.password) as session:
            assert isinstance(session, Controller)
            assert session.outputs(["doGrip"]) == {"doGrip": 1.0}
        files = f"ftp://{cell.user}@127.0.0.1:{cell.port}"
        of_files = asked("cell", files, password=cell.password)
        with pytest.raises(Refused, match="BL503"):
            run(alone(Signals("part", of_files, ["diPart"])), 0.1, STEP)


def test_in_lock_step_signals_come_at_the_same_steps_each_time() -> None:
    def once() -> RunResult:
        with VirtualCr("rv-2aj", lock_step=True) as cell:
            connection = asked("cell", cell.address)
            diagram = Diagram()
            lamp = diagram.add(Output("lamp", connection, "7"))
            on = diagram.add(Table("on", [0.0, 0.05, 0.051], [0.0, 0.0, 1.0]))
            diagram.wire((on, "value"), lamp)
            diagram.add(Signals("inputs", connection, ["3"]))
            clock = LockStep(cell, connections=[connection])
            return run(diagram, 0.15, STEP, clock=clock, moving=["cell"])

    first, second = once(), once()
    assert first["lamp.set"][-1] == 1.0
    for name in first.columns:
        assert np.array_equal(first[name], second[name], equal_nan=True)

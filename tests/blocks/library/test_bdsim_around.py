"""What is around an arm, in bdsim: found by it, and run by it and at our pace."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.blocks.bdsim_adapter import run_bdsim, run_paced
from assistant.blocks.connections import asked
from assistant.blocks.diagrams import RealTime
from assistant.blocks.library.controller_io import Hand
from assistant.blocks.library.external_control import by_egm
from assistant.program.geometry import Pose
from assistant.virtual.cr import VirtualCr
from assistant.virtual.irc5.egm import Guidance, VirtualEgm
from assistant.vision.cameras.camera import Camera, looking_at
from assistant.vision.servoing.bounds import Bounds
from assistant.vision.servoing.visual_targets import Marker
from tests.vision.pointing.scenes import LENS
from tests.vision.servoing.scenes import PATIENT, free_port

pytest.importorskip("bdsim")
IRB = robots.get("irb1200-7-0.7")
HERE = np.array([10.0, 25.0, 15.0, 20.0, 60.0, 15.0])
CELL = Path(__file__).parents[3] / "samples" / "cell" / "station-irb1200-7-0.7.toml"
DOWN = (0.0, 1.0, 0.0, 0.0)


def test_bdsim_finds_these_blocks(sim) -> None:
    assert {
        *("EXTERNALCONTROL", "EXCHANGEDPOSE", "INPUTSIGNALS", "OUTPUTSIGNAL", "GRIPPER"),
        *("PROJECTEDMARKER", "SEENMARKER", "POINTINGDEVICE", "COLLISIONDISTANCE"),
    } <= set(sim.block_library)


def test_a_camera_and_a_distance_are_functions_of_the_moment(sim) -> None:
    diagram = sim.blockdiagram()
    camera = Camera("above", LENS, looking_at((450.0, 0.0, 900.0), (450.0, 0.0, 0.0), (0, 1, 0)))
    line = diagram.POSELINE(Pose((420.0, -60.0, 0.0)), Pose((480.0, 60.0, 0.0)), 1.0)
    seen = diagram.PROJECTEDMARKER(camera, Marker(7, 60.0))
    way = diagram.MOTIONTABLE([0.0, 1.0], [IRB.home, IRB.home + 10.0])
    apart = diagram.COLLISIONDISTANCE(CELL)
    diagram.connect(line[0], seen)
    diagram.connect(way[0], apart)
    diagram.compile(verbose=False)
    theirs = run_bdsim(sim, diagram, 1.0, dt=0.1, watch=[seen[1], apart[0]])
    assert (theirs.y[:, 0] == 1.0).all() and np.isfinite(theirs.y[:, 1]).all()
    ours = run_paced(sim, diagram, 1.0, 0.1)
    assert ours["distance[0]"][-1] == pytest.approx(theirs.y[-1, 1])
    assert ours["camera[0]"].shape == (11, 8)


def test_a_hand_is_closed_out_of_bdsim_once_that_is_confirmed(sim) -> None:
    with VirtualCr("rv-2aj", pace=10.0) as cell:
        diagram = sim.blockdiagram()
        connection = asked("cell", cell.address)
        clock = diagram.clock(0.01)
        gripper = diagram.GRIPPER(clock, connection, Hand(1), name="gripper")
        inputs = diagram.INPUTSIGNALS(clock, connection, ["3"], name="inputs")
        diagram.connect(diagram.CONSTANT(1.0), gripper)
        diagram.connect(inputs[0], diagram.NULL())
        diagram.compile(verbose=False)
        with pytest.raises(Refused, match="BL111"):
            run_paced(sim, diagram, 1.0, 0.01)
        inner = gripper._inner
        ran = run_paced(
            sim, diagram, 10.0, 0.01, clock=RealTime(), moving=["cell"],
            watch=lambda now: not now or inner._state != 1.0,
        )  # fmt: skip
        assert connection.users == 0 and cell.state.hands[1] is False
        assert np.isnan(ran["inputs[0]"]).any()


@pytest.mark.slow
def test_an_arm_is_led_cycle_by_cycle_out_of_bdsim(sim) -> None:
    port = free_port()
    arm = Guidance(
        "joints", tuple(HERE), tuple(IRB.speeds), waiting=None, comm_timeout=60.0, cond_time=600.0
    )
    bounds = Bounds(speed=1000.0, turning=360.0, part=0.8, margin=0.0)
    connection = by_egm("cell", "127.0.0.1", IRB, bounds=bounds, port=port, settings=PATIENT)
    with VirtualEgm(arm, ("127.0.0.1", port)):
        diagram = sim.blockdiagram()
        way = diagram.MOTIONTABLE([0.0, 0.7, 1.0], [HERE, HERE + 1.0, HERE + 1.0])
        led = diagram.EXTERNALCONTROL(diagram.clock(0.01), connection, IRB, name="arm")
        diagram.connect(way[0], led[0])
        diagram.connect(diagram.CONSTANT(1.0), led[1])
        diagram.compile(verbose=False)
        ran = run_paced(sim, diagram, 1.2, 0.01, clock=RealTime(), moving=["cell"])
    assert ran["arm[0]"][-1] == pytest.approx(HERE + 1.0, abs=0.1)
    assert "later than half a cycle" in led._inner.summary

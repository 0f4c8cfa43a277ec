"""Our blocks in bdsim: found by it, run by it, and run at our pace."""

from __future__ import annotations

import json
from importlib import import_module
from inspect import signature
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.blocks.bdsim_adapter import add, run_bdsim, run_paced
from assistant.blocks.connections import operated
from assistant.blocks.diagrams import Block, Port, RealTime
from assistant.blocks.library.sources import Constant
from assistant.program.geometry import Pose
from assistant.virtual.cr import VirtualCr

pytest.importorskip("bdsim")
bdload = pytest.importorskip("bdsim.blockdiagram").bdload
ARM = robots.get("rv-2aj")
IRB = robots.get("irb1200-7-0.7")
DOWN = (0.0, 1.0, 0.0, 0.0)


def test_bdsim_finds_the_blocks(sim) -> None:
    names = set(sim.block_library)
    assert {
        *("JOINTMOVJOINT", "JOINTMOVCART", "LINMOVJOINT", "LINMOVCART", "CIRCULARMOV"),
        *("ARMFK", "ARMIK", "ARMJACOBIAN", "SIMARM", "MOTIONTABLE", "POSELINE"),
    } <= names


def tracking(sim):
    """A line of poses that a simulated arm follows."""
    diagram = sim.blockdiagram()
    line = diagram.POSELINE(
        Pose((420.0, -60.0, 360.0), DOWN), Pose((420.0, 140.0, 300.0), DOWN), 1.0
    )
    nearest = diagram.CONSTANT(-1.0)
    inverse = diagram.ARMIK(IRB)
    arm = diagram.SIMARM(diagram.clock(0.01), IRB, name="arm")
    diagram.connect(line[0], inverse[0])
    diagram.connect(nearest, inverse[1])
    diagram.connect(inverse[0], arm)
    diagram.compile(verbose=False)
    return diagram, arm


def test_bdsim_runs_them_and_so_do_we_with_the_same_result(sim) -> None:
    diagram, arm = tracking(sim)
    theirs = run_bdsim(sim, diagram, 1.5, dt=0.01, watch=[arm[0]])
    diagram, _ = tracking(sim)
    ours = run_paced(sim, diagram, 1.5, 0.01)
    at = np.searchsorted(ours.seconds, theirs.t - 1e-9)
    assert len(at) > 100
    assert np.abs(ours["arm[0]"][at] - theirs.y.reshape(len(at), -1)).max() < 1e-9
    assert ours["arm[1]"][-1, :3] == pytest.approx([420.0, 140.0, 300.0], abs=1e-6)


def test_moves_of_a_model_reach_the_controller_once_they_are_confirmed(sim) -> None:
    with VirtualCr("rv-2aj", pace=10.0) as cell:
        diagram = sim.blockdiagram()
        connection = operated("cell", cell.address, override=50)
        goal = diagram.CONSTANT(np.array([0.0, 10.0, 80.0, 0.0, 60.0, 0.0]))
        block = diagram.JOINTMOVJOINT(diagram.clock(0.02), connection, ARM, "move")
        diagram.connect(goal, block[0])
        diagram.connect(diagram.CONSTANT(1.0), block[1])
        diagram.compile(verbose=False)
        with pytest.raises(Refused, match="BL111"):
            run_paced(sim, diagram, 1.0, 0.02)
        assert connection.users == 0
        inner = block._inner
        ran = run_paced(
            sim,
            diagram,
            20.0,
            0.02,
            clock=RealTime(),
            watch=lambda now: not now or inner._done == 0,
            moving=["cell"],
        )
        assert ran["move[1]"].max() == 1.0
        assert ran["move[2]"][-1] == pytest.approx([0.0, 10.0, 80.0, 0.0, 60.0, 0.0], abs=0.02)
        assert connection.users == 0


class Sum(Block):
    """A block of one's own: it adds up what it is given at each of its steps."""

    direct = False

    def __init__(self, name: str) -> None:
        super().__init__(name, [Port("by")], [Port("sum")])

    def begin(self) -> None:
        self.sum = 0.0

    def give(self, now, given):
        return [[self.sum]]

    def take(self, now, given) -> None:
        self.sum += given[0][0]


def test_an_own_block_runs_in_bdsim_without_a_class_of_bdsim(sim) -> None:
    diagram = sim.blockdiagram()
    constant = add(diagram, Constant("two", 2.0))
    added = add(diagram, Sum("sum"), diagram.clock(0.1))
    diagram.connect(constant, added)
    ran = run_paced(sim, diagram, 1.0, 0.1)
    assert ran["sum[0]"] == pytest.approx([0.0, *np.arange(0.0, 20.0, 2.0)])
    with pytest.raises(ValueError, match="steps with a clock"):
        add(diagram, Sum("other"))


def test_a_block_steps_at_the_ticks_of_its_own_clock_only(sim) -> None:
    def model():
        diagram = sim.blockdiagram()
        one = diagram.CONSTANT(1.0)
        sums = [add(diagram, Sum(f"{t:g}"), diagram.clock(t)) for t in (0.1, 0.3)]
        for block in sums:
            diagram.connect(one, block)
        diagram.compile(verbose=False)
        return diagram, sums

    diagram, _ = model()
    ours = run_paced(sim, diagram, 0.9, 0.1)
    assert ours["0.1[0]"] == pytest.approx([0, *range(9)])  # its ticks begin after a period
    assert ours["0.3[0]"] == pytest.approx([0, 0, 0, 0, 1, 1, 1, 2, 2, 2])
    diagram, sums = model()
    run_bdsim(sim, diagram, 0.9, dt=0.05, watch=[block[0] for block in sums])
    assert [block._inner.sum for block in sums] == [9.0, 3.0]


def test_its_editor_finds_an_icon_of_each_block_and_its_ports(sim) -> None:
    ours = {k: found for k, found in sim.block_library.items() if found["package"] == "assistant"}
    assert len(ours) > 10
    for name, found in ours.items():
        # Where its editor looks: beside the module, by the name of the block.
        icon = Path(found["path"][0]) / "Icons" / f"{name.lower()}.png"
        assert icon.is_file(), f"a row in docs/icons.py for {name}, then: python -m docs.icons"
        with Image.open(icon) as picture:
            assert (picture.size, picture.mode) == ((250, 250), "RGBA")
            assert picture.getextrema()[3] == (0, 255)
        block = found["class"]
        for labels, ports in (("inlabels", "nin"), ("outlabels", "nout")):
            named = getattr(block, labels, None)
            assert named is None or len(named) == found[ports]
            assert all(len(label) <= 3 for label in named or ())  # more is drawn over the icon
        taken = signature(getattr(import_module(found["module"]), found["classname"])).parameters
        assert set(found["params"]) <= set(taken)


def test_a_diagram_of_its_editor_is_loaded_with_our_blocks(sim, tmp_path) -> None:
    def block(number, kind, title, parameters, nin, nout):
        ports = [[{"id": 100 * number + 10 * k + i, "index": i} for i in range(n)]
                 for k, n in enumerate((nin, nout))]  # fmt: skip
        return {
            "block_type": kind, "id": number, "title": title, "parameters": parameters,
            "inputs": ports[0], "outputs": ports[1],
        }  # fmt: skip

    wanted = [["value", "=[10.0, 0.0, 0.0, 0.0, 0.0, 0.0]"]]
    arm = [["clock", "=ticks"], ["robot", "=robot"], ["tool", None], ["start", None], ["lag", 0.05]]
    model = {
        "blocks": [
            block(1, "CONSTANT", "goal", wanted, 0, 1),
            block(2, "SIMARM", "arm", arm, 1, 3),
        ],
        "wires": [{"start_socket": 110, "end_socket": 200}],
    }
    file = tmp_path / "model.bd"
    file.write_text(json.dumps(model))
    diagram = sim.blockdiagram()
    known = {"ticks": diagram.clock(0.01), "robot": IRB}
    bdload(diagram, str(file), globalvars=known, allow_eval=True)
    ran = run_paced(sim, diagram, 1.0, 0.01)
    assert ran["arm[0]"][-1, 0] == pytest.approx(10.0, abs=0.01)


@pytest.mark.parametrize("runner", ["bdsim", "paced"])
def test_every_block_is_ended_whose_begin_or_end_fails(sim, runner: str) -> None:
    ended: list[str] = []

    class Fails(Block):
        direct = False

        def begin(self) -> None:
            if self.name == "second":
                raise LookupError("no camera")

        def give(self, now, given):
            return [0.0]

        def end(self) -> None:
            ended.append(self.name)
            raise ValueError(f"{self.name} cannot be ended")

    diagram = sim.blockdiagram()
    clock = diagram.clock(0.1)
    for name in ("first", "second"):
        made = add(diagram, Fails(name, [], [Port("value")]), clock)
        diagram.connect(made, diagram.NULL())
    diagram.compile(verbose=False)
    with pytest.raises(Refused, match=r"BL110.*`second` failed at 0 s: LookupError: no camera"):
        if runner == "bdsim":
            run_bdsim(sim, diagram, 0.3)
        else:
            run_paced(sim, diagram, 0.3, 0.1)
    assert sorted(ended) == ["first", "second"]


@pytest.mark.parametrize("given", [lambda: 1 / 0, lambda: [1.0, 2.0], lambda: [[1.0, 2.0]]])
def test_what_an_own_block_does_wrong_in_bdsim_is_told_as_by_us(sim, given, capsys) -> None:
    class Own(Block):
        def give(self, now, signals):
            return given()

    diagram = sim.blockdiagram()
    diagram.connect(add(diagram, Own("own", [], [Port("value")])), diagram.NULL())
    with pytest.raises(Refused, match=r"BL110.*`own` failed at 0 s"):
        run_bdsim(sim, diagram, 0.3)
    assert "Traceback" not in capsys.readouterr().out

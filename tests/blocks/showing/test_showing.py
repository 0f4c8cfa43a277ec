"""Diagrams and their runs as notebooks show them."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from lxml import html

from assistant import robots
from assistant.blocks.diagrams import Block, Diagram, Port, run
from assistant.blocks.display import lay_out
from assistant.blocks.library.arms import InverseKinematics, SimulatedArm
from assistant.blocks.library.sources import Constant, PoseToPose
from assistant.program.geometry import Pose

IRB = robots.get("irb1200-7-0.7")
DOWN = (0.0, 1.0, 0.0, 0.0)
NASTY = "<script>alert(1)</script>$x_{\x1b[31m"


def tracking(name="line"):
    diagram = Diagram("tracking")
    line = diagram.add(
        PoseToPose(name, Pose((420.0, -60.0, 360.0), DOWN), Pose((420.0, 140.0, 300.0), DOWN), 1.0)
    )
    nearest = diagram.add(Constant("nearest", -1.0))
    inverse = diagram.add(InverseKinematics("inverse", IRB))
    arm = diagram.add(SimulatedArm("arm", IRB))
    diagram.wire((line, "pose"), (inverse, "pose"))
    diagram.wire(nearest, (inverse, "branch"))
    diagram.wire((inverse, "joints"), arm)
    return diagram


def test_blocks_stand_in_the_order_of_their_signals():
    found = lay_out(tracking())
    columns = {box.name: box.column for box in found.boxes}
    assert columns == {"line": 0, "nearest": 0, "inverse": 1, "arm": 2}
    assert not any(found.back(wire) for wire in found.wires)
    places = {(box.column, box.row) for box in found.boxes}
    assert len(places) == len(found.boxes)


class Behind(Block):
    direct = False

    def __init__(self, name):
        super().__init__(name, [Port("given")], [Port("before")])

    def give(self, now, given):
        return [[0.0]]


def test_a_loop_and_a_block_alone_are_drawn():
    diagram = Diagram()
    blocks = [diagram.add(Behind(name)) for name in "abcd"]
    for one, other in zip(blocks, [*blocks[1:3], blocks[0]], strict=False):
        diagram.wire(one, other)
    found = lay_out(diagram)
    assert [found.back(wire) for wire in found.wires].count(True) == 1
    assert [box.column for box in found.boxes] == [0, 1, 2, 0]
    assert diagram._repr_png_()[:4] == b"\x89PNG"
    assert Diagram()._repr_png_()[:4] == b"\x89PNG"


def test_a_diagram_too_large_for_a_picture_shows_itself_in_words():
    diagram = Diagram()
    for number in range(400):
        diagram.add(Constant(f"c{number}", 1.0))
    assert diagram._repr_png_() is None
    assert repr(diagram) == "<Diagram main: 400 blocks, 0 wires>"


def test_a_run_shows_its_signals_and_names_are_no_markup(monkeypatch):
    diagram = tracking(NASTY)
    ran = run(diagram, 0.5, 0.01)
    text = ran._repr_html_()
    page = html.fromstring(text)
    assert not page.xpath("//script") and "\x1b" not in text
    assert "<script>alert(1)</script>" in page.text_content()
    assert "51 steps" in repr(ran) or "50 steps" in repr(ran)
    assert diagram._repr_png_()[:4] == ran._repr_png_()[:4] == b"\x89PNG"
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert diagram._repr_png_() is None and ran._repr_png_() is None


def test_models_of_bdsim_are_drawn_as_ours_are():
    bdsim = pytest.importorskip("bdsim")
    sim = bdsim.BDSim(
        packages="assistant", toolboxes=False, graphics=False, progress=False, quiet=True,
        sysargs=False, hold=False,
    )  # fmt: skip
    diagram = sim.blockdiagram()
    line = diagram.POSELINE(Pose(), Pose((0.0, 0.0, 100.0)), 1.0)
    inverse = diagram.ARMIK(IRB)
    diagram.connect(line[0], inverse[0])
    diagram.connect(diagram.CONSTANT(-1.0, name="nearest"), inverse[1])
    found = lay_out(diagram)
    by_name = {box.name: box for box in found.boxes}
    assert by_name["ik"].inputs == ("pose", "branch") and by_name["ik"].kind == "ArmIK"
    assert by_name["ik"].column == 1 and by_name["line"].column == by_name["nearest"].column == 0
    assert np.isfinite([box.row for box in found.boxes]).all()

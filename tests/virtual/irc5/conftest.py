from __future__ import annotations

import pytest

from assistant.virtual.irc5 import Signal, VirtualIrc5
from assistant.virtual.kernel.timed_arm import Timed
from tests.virtual.irc5.web import One, Robot, Two

SIGNALS = [
    Signal("do_lamp", "DO"),
    Signal("di_part", "DI"),
    Signal("ao_speed", "AO", "DeviceNet", "d651"),
]


@pytest.fixture(scope="module")
def irc5(tmp_path_factory):
    home = tmp_path_factory.mktemp("irc5") / "home"
    with VirtualIrc5(home, user="Default User", signals=SIGNALS, rate=20.0) as controller:
        yield controller


@pytest.fixture
def fresh(irc5):
    """The controller as it is when it was switched on."""
    irc5.free_mastership()
    irc5.release_emergency_stop()
    irc5.faults.clear()
    panel = irc5.cabinet.panel
    panel.mode, panel.speed = "AUTO", 100
    panel.set_motors(False)
    irc5.cabinet.do(_empty)
    irc5.cabinet.log.clear()
    irc5.cabinet.board.inputs.values.clear()
    irc5.cabinet.board.outputs.values.clear()
    return irc5


@pytest.fixture(params=[One, Two], ids=["rws", "rwss"])
def robot(fresh, request):
    """A client of either dialect."""
    client = request.param(fresh)
    yield Robot(client)
    client.get("/logout")


def _empty(programs):
    programs.stop()
    programs.restore([])
    programs.active, programs.cycle = True, "forever"
    programs.kernel.motion = Timed(programs.robot)  # the arm is at its home

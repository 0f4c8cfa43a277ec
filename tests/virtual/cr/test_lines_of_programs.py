"""Lines that programs in the virtual CR controller open: of the data link, and packets."""

from types import SimpleNamespace

import pytest

from assistant.virtual.cr import VirtualCr
from tests.controllers.mitsubishi.mxt.controllers import joints, led
from tests.virtual.cr.test_link import load
from tests.virtual.cr.test_running import bits, place, runs, state
from tests.virtual.cr.waiting import wait_for
from tests.wire import Wire


def test_lines_of_the_data_link_are_where_they_are_wanted():
    for first in range(20011, 30000, 97):  # below the ports that the system gives out
        try:
            with VirtualCr("rv-2aj", data_port=first) as controller:
                ports = [port for _, port in controller.data_ports.values()]
        except OSError:
            continue
        assert ports == list(range(first + 1, first + 8))
        return
    pytest.fail("no seven ports in a row are free")


def test_an_arm_is_led_by_packets():
    with VirtualCr("rv-4frl") as controller, Wire(controller.port) as wire:
        load(wire, "LED", '1 Open "ENET:127.0.0.1" As #1', "2 Mxt 1,1", "3 End")
        for command in ("CNTLON", "SRVON"):
            assert wire.ask(f"1;1;{command}") == "QoK"
        wait_for(lambda: bits(wire)[0] & 0x20)
        assert wire.ask("1;1;RUNLED;1") == "QoK"
        wait_for(lambda: state(wire)[1] == "2")
        trajectory = joints()
        assert led(SimpleNamespace(port=controller.mxt_port), trajectory).code == ""
        wait_for(lambda: not runs(wire))
        assert bits(wire)[2] == 0
        assert list(place(wire, "JPOSF").values()) == pytest.approx(trajectory.rows[-1], abs=0.1)

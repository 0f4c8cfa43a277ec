"""The real-time monitor: client and virtual controller, and the packet as the manual has it."""

import itertools
import socket
import struct
import threading

import numpy as np
import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers.mitsubishi.external_control import Monitor
from assistant.controllers.mitsubishi.monitor import FIELDS, FORMS, TYPES
from assistant.virtual.cr.mxt import Bits, MxtArm
from assistant.virtual.cr.real_time import MONITOR_PACKET, MxtMonitor
from tests.controllers.mitsubishi.mxt.controllers import ARM

# BFP-A3379-A, table 5-1: address of each field.
MANUAL = [0, 4, 8, 48, 50, 52, 56, 60, 64, 68, 108, 112, 152, 156]


@pytest.fixture
def virtual():
    bits = Bits(inputs={33: True}, outputs={40: True})
    arm = MxtArm(ARM, ARM.home, 0.002)
    with MxtMonitor(lambda: arm, bits, program=lambda: ("SEAM", 70), cycle=0.002) as monitor:
        monitor.arm = arm
        yield monitor


def test_both_sides_know_the_packet_of_the_manual():
    assert [offset for offset, _, _ in FIELDS] == MANUAL
    fields = [name for name in MONITOR_PACKET.names if not name.startswith("reserve")]
    assert [MONITOR_PACKET.fields[name][1] for name in fields] == MANUAL
    assert {form.size for form, _ in FORMS.values()} == {40}


def test_what_the_arm_does_is_told(virtual):
    virtual.arm.fed_back = virtual.arm.commanded + 1.0
    types = ("joints", "joints_feedback", "pose", "robot")
    with Monitor("127.0.0.1", types, port=virtual.port, inputs=32, outputs=32) as monitor:
        samples = list(itertools.islice(monitor, 5))
    last = samples[-1]
    assert last.values["joints"][:6] == pytest.approx(tuple(ARM.home), abs=1e-4)
    assert last.values["joints_feedback"][:6] == pytest.approx(tuple(ARM.home + 1.0), abs=1e-4)
    assert last.values["pose"][:3] == pytest.approx(tuple(ARM.fk(ARM.home[None])[0][0]), abs=1e-3)
    assert last.values["robot"][-3:-1] == (70, 352)
    assert last.program == "SEAM"
    assert (last.inputs, last.outputs) == (1 << 1, 1 << 8)
    assert all(one.counter < two.counter for one, two in itertools.pairwise(samples))


@pytest.mark.parametrize(
    "name", ["joints_radians", "pose_feedback_radians", "pulses", "load_percent"]
)
def test_a_type_is_recorded_in_columns(virtual, name):
    with Monitor("127.0.0.1", (name,), port=virtual.port) as monitor:
        columns = monitor.record(3)
    assert {len(column) for column in columns.values()} == {3}
    assert len(columns) == 4 + len(FORMS[TYPES[name][1]][1])
    if name == "joints_radians":
        assert columns["joints_radians_J3"] == pytest.approx(np.radians(ARM.home[2]))


def test_the_controller_sends_to_the_last_one_that_asked(virtual):
    with Monitor("127.0.0.1", port=virtual.port, timeout=0.05) as first:
        second = Monitor("127.0.0.1", port=virtual.port)
        with second, pytest.raises(Refused) as refused:
            assert len(list(itertools.islice(second, 3))) == 3
            first.record(100)
    assert [one.code for one in refused.value.findings] == ["CN734"]


def test_a_monitor_that_is_off():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as silent:
        silent.bind(("127.0.0.1", 0))
        monitor = Monitor("127.0.0.1", port=silent.getsockname()[1], timeout=0.05)
        with pytest.raises(Refused) as refused, monitor:
            pass
        asked = silent.recv(2048)
    assert [one.code for one in refused.value.findings] == ["CN733"]
    assert len(asked) == 196
    assert struct.unpack_from("<HHH", asked) == (1, 0, 1002)


def test_packets_that_are_none_or_come_twice_are_left_out():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as odd:
        odd.bind(("127.0.0.1", 0))
        odd.settimeout(10)

        def told(counter, kind=1002):
            packet = bytearray(196)
            struct.pack_into("<HHH", packet, 0, 1, 0, kind)
            struct.pack_into("<I", packet, 60, counter)
            return bytes(packet)

        def serve():
            _, client = odd.recvfrom(2048)
            for one in (
                b"?",
                told(1, 7),
                told(5),
                told(5),
                told(4),
                told(8),
                told(8)[:-1],
                told(9),
            ):
                odd.sendto(one, client)
            ended.append(odd.recv(2048)[0])

        ended = []
        thread = threading.Thread(target=serve)
        thread.start()
        with Monitor("127.0.0.1", ("joints",), port=odd.getsockname()[1]) as monitor:
            samples = list(itertools.islice(monitor, 3))
        thread.join()
    assert [(one.counter, one.lost) for one in samples] == [(5, 0), (8, 2), (9, 0)]
    assert ended == [255]


@pytest.mark.parametrize(
    "given",
    [
        {"types": ()},
        {"types": ("joints",) * 2},
        {"types": ("joints", "pose", "pulses", "robot", "force")},
        {"types": ("colour",)},
        {"port": 0},
        {"local_port": -1},
        {"inputs": 40000},
        {"timeout": 0.0},
    ],
)
def test_settings_that_cannot_be(given):
    with pytest.raises(Refused) as refused:
        Monitor("127.0.0.1", **given)
    assert [one.code for one in refused.value.findings] == ["CN731"]

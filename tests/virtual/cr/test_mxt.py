"""A controller in `Mxt`, asked packet by packet as the manual says."""

import contextlib
import socket
import struct
import sys
import threading
import time

import numpy as np
import pytest

from assistant import robots
from assistant.virtual.cr.mxt import Bits, MxtArm, MxtControl

ARM = robots.get("rv-4frl")
CYCLE = 0.002
STAMP = 35
"""SO_TIMESTAMPNS, which `socket` does not name."""


class Peer:
    """Sends packets and takes the answers."""

    def __init__(self, control):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect(("127.0.0.1", control.port))
        self.socket.settimeout(10)

    def send(self, command=1, send=2, recv=2, angles=(), **fields):
        packet = bytearray(196)
        struct.pack_into("<HHH", packet, 0, command, send, recv)
        struct.pack_into(f"<{len(angles)}f", packet, 8, *angles)
        for at, value in fields.items():
            struct.pack_into("<H", packet, int(at.removeprefix("at")), value)
        self.socket.send(packet)

    def ask(self, *given, **fields):
        self.send(*given, **fields)
        return self.socket.recv(2048)


@contextlib.contextmanager
def running(kind=1, robot=ARM, filter_ms=0.0, **settings):
    control = MxtControl(MxtArm(robot, robot.home, CYCLE, filter_ms), kind, **settings)
    stop = threading.Event()
    thread = threading.Thread(target=control.run, args=(stop,))
    thread.start()
    peer = Peer(control)
    try:
        yield peer, control
    finally:
        stop.set()
        thread.join()
        peer.socket.close()


def until(happened):
    """Waits until something has happened, 10 s at most."""
    over = time.monotonic() + 10.0
    while not happened():
        assert time.monotonic() < over, "it never happened"
        time.sleep(0.001)


def ended(peer, control, *given, **fields):
    """Sends what ends it, and waits until it has."""
    peer.send(*given, **fields)
    until(lambda: control.result.reason != "stopped")
    return control.result.reason, control.result.number


HOME = tuple(np.radians(ARM.home))


@contextlib.contextmanager
def stamped():
    """Linux stamps packets as they arrive a while after the first socket asked for that."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as own:
        own.bind(("127.0.0.1", 0))
        own.setsockopt(socket.SOL_SOCKET, STAMP, 1)

        def is_stamped():
            own.sendto(b".", own.getsockname())
            time.sleep(0.02)
            _, ((_, _, moment), *_), _, _ = own.recvmsg(1, 64)
            seconds, nanoseconds = struct.unpack_from("=qq", moment)
            return time.time() - (seconds + 1e-9 * nanoseconds) >= 0.02

        until(is_stamped)
        yield


@pytest.mark.skipif(sys.platform != "linux", reason="packets carry their moment on Linux only")
def test_a_packet_that_came_before_the_reply_answers_none():
    class Meanwhile(Bits):
        def write(self, first, mask, word):
            peer.send(angles=HOME)

    signals = Meanwhile()
    with stamped(), running(signals=signals) as (peer, control):
        peer.ask(angles=HOME, at48=1)
        peer.socket.recv(2048)
        assert control.result.answers == []
        peer.ask(angles=HOME)
        ended(peer, control, 255, 0, 0)
    (seconds,) = control.result.answers
    assert seconds > 0.0


def test_the_first_packet_is_answered_with_the_position_and_moves_nothing():
    with running() as (peer, control):
        answer = peer.ask(0, 0, 2)
        assert len(answer) == 196
        assert struct.unpack_from("<HHH", answer) == (0, 2, 2)
        assert struct.unpack_from("<6f", answer, 8) == pytest.approx(HOME)
        assert struct.unpack_from("<I", answer, 60) == (1,)
        assert struct.unpack_from("<I", peer.ask(0, 0, 2), 60) == (2,)
    assert control.result.track == []


def test_commands_are_followed_and_255_ends_it():
    with running() as (peer, control):
        for step in range(1, 6):
            answer = peer.ask(angles=[HOME[0] + 0.001 * step, *HOME[1:]])
        assert struct.unpack_from("<f", answer, 8)[0] == pytest.approx(HOME[0] + 0.005)
        assert ended(peer, control, 255, 2, 2) == ("end", 0)
    assert control.result.joints[0] == pytest.approx(np.degrees(HOME[0] + 0.005), abs=1e-4)


def test_without_packets_the_position_is_held():
    with running() as (peer, control):
        peer.ask(angles=[HOME[0] + 0.001, *HOME[1:]])
        cycles = control.result.cycles
        until(lambda: control.result.cycles >= cycles + 5)
        answer = peer.ask(0, 0, 8)
        assert struct.unpack_from("<H", answer, 58) == (0,)
        assert struct.unpack_from("<f", answer, 8)[0] == pytest.approx(HOME[0] + 0.001, abs=1e-4)


def test_cycles_without_a_packet_are_counted_up_to_the_error():
    with running(timeout=400) as (peer, control):
        peer.ask(0, 0, 2)
        cycles = control.result.cycles
        until(lambda: control.result.cycles >= cycles + 4)
        assert struct.unpack_from("<H", peer.ask(0, 0, 2), 58)[0] >= 3
    with running(timeout=5) as (peer, control):
        assert ended(peer, control, 0, 0, 2) == ("error", 7820)


@pytest.mark.parametrize(
    ("packet", "number"),
    [
        ((1, 1, 2), 7840),  # a pose where joints were announced
        ((1, 0, 2), 7840),
        ((2, 2, 2), 7840),
        ((0, 0, 12), 7840),
        ((1, 2, 2, [float("nan")] * 6), 7840),
        ((1, 2, 2, [HOME[0] + 0.1, *HOME[1:]]), 2131),
        ((1, 2, 2, [*HOME[:5], HOME[5] - 0.1]), 2136),
        ((1, 2, 2, [np.radians(241), *HOME[1:]]), 2161),
        ((1, 2, 2, [HOME[0], HOME[1], np.radians(-1), *HOME[3:]]), 2173),
    ],
)
def test_what_a_controller_answers_with_an_error(packet, number):
    with running() as (peer, control):
        peer.ask(0, 0, 2)
        assert ended(peer, control, *packet) == ("error", number)
    assert control.result.track == []


def test_packets_of_other_senders_and_sizes_are_ignored():
    with running(partner="127.0.0.9") as (peer, control):
        peer.send(1, 1, 2)
        until(lambda: control.result.ignored)
    assert (control.result.reason, control.result.replies) == ("stopped", 0)
    with running() as (peer, control):
        peer.socket.send(b"\1" * 195)
        peer.ask(0, 0, 2)
    assert control.result.ignored == 1


def test_signals_and_more_data():
    with running() as (peer, control):
        control._signals.inputs[3] = True
        answer = peer.ask(
            0, 0, 2, at48=1, at50=2, at52=2, at54=6, at56=0xFF, at64=8, at108=1, at152=11
        )
    assert control._signals.outputs == {3: True, 4: True}
    assert struct.unpack_from("<HHHHH", answer, 48) == (2, 0, 2, 0, 2)
    assert [struct.unpack_from("<H", answer, at)[0] for at in (64, 108, 152)] == [8, 1, 11]
    assert struct.unpack_from("<6f", answer, 68) == pytest.approx(HOME)
    place = ARM.fk(ARM.home[None])[0][0]
    assert struct.unpack_from("<3f", answer, 112) == pytest.approx(tuple(place), abs=1e-3)


def test_a_filter_makes_the_arm_lag():
    with running(filter_ms=20.0) as (peer, _):
        answer = peer.ask(1, 2, 5, [HOME[0] + 0.01, *HOME[1:]])
    assert 0.0005 < struct.unpack_from("<f", answer, 8)[0] - HOME[0] < 0.002


def test_an_axis_that_an_arm_lacks_keeps_its_place():
    arm = robots.get("rv-2aj")
    with running(robot=arm) as (peer, _):
        answer = struct.unpack_from("<6f", peer.ask(0, 0, 2), 8)
    home = dict(zip(arm.axes, np.radians(arm.home), strict=True))
    assert answer == pytest.approx([home.get(f"J{i}", 0.0) for i in range(1, 7)])


def test_a_pose_out_of_reach():
    with running(0) as (peer, control):
        peer.ask(0, 0, 1)
        assert ended(peer, control, 1, 1, 1, [9000.0, 0, 0, 0, 0, 0]) == ("error", 2802)

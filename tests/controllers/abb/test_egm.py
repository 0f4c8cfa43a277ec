"""EGM: the client against the virtual controller, over real UDP sockets, and against bad peers."""

import math
import os
import random
import signal
import socket
import struct
import threading
import time
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant.base.diagnostics import Refused
from assistant.controllers.abb.egm import (
    Egm,
    Message,
    decode,
    encode,
    guide,
    guide_by_corrections,
)
from assistant.controllers.cyclic import Endpoint, Limits, Settings, Trajectory, resampled
from assistant.controllers.cyclic.loop import Job, Loop, PacketSocket, Stop
from assistant.virtual.irc5 import egm_packets as packets
from assistant.virtual.irc5.egm import CYCLE, NO_DATA, Guidance, VirtualEgm

HERE = (0.0, 10.0, -20.0, 0.0, 30.0, 0.0)
POSE = (400.0, 0.0, 600.0, 1.0, 0.0, 0.0, 0.0)
LIMITS = Limits((120.0,) * 6, (800.0,) * 6)
QUICK = Settings(
    opening=20.0, settle=0.3, timeout=10.0, softness=1.0, real_time=False, wait="block"
)
"""No time-out that a busy computer could reach."""
SPEEDS = (200.0,) * 6


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def to(*turns):
    return Trajectory.of_joints([HERE, *((turn, *HERE[1:]) for turn in turns)], unit="deg")


@contextmanager
def controller(port, **settings):
    asked = {"kind": "joints", "values": HERE, "speeds": SPEEDS, "cond_time": 60.0, "waiting": None}
    guidance = Guidance(**{**asked, **settings})
    with VirtualEgm(guidance, ("127.0.0.1", port)) as virtual:
        yield virtual


def guided(trajectory, limits=LIMITS, settings=QUICK, **more):
    """A guidance in the foreground, and the virtual controller that it leads.

    The controller waits long for the next packet while there is to be one, and then not.
    """
    port = free_port()
    with controller(port, comm_timeout=60.0, **more) as virtual:
        report = guide("127.0.0.1", trajectory, limits, port=port, settings=settings)
        virtual.guidance.comm_timeout = 0.3
        assert virtual.wait(20)
        return report, virtual


# -------------------------------------------------------------------------------- messages


def test_a_message_is_what_the_encoding_says():
    """By hand: tag = number * 8 + wire type, whole numbers in groups of seven bits."""
    one = struct.pack("<d", 1.5)
    joints = b"".join(b"\x09" + one for _ in range(6))
    header = b"\x08\xac\x02" + b"\x10\x01" + b"\x18\x03"
    planned = b"\x0a" + bytes([len(joints)]) + joints
    expected = b"\x0a" + bytes([len(header)]) + header + b"\x12" + bytes([len(planned)]) + planned
    message = decode("EgmSensor", expected)
    assert message.all("header", "seqno") == (300,) and message.all("header", "mtype") == (3,)
    assert message.all("planned", "joints", "joints") == (1.5,) * 6
    assert encode("EgmSensor", message) == expected
    sent = Egm().command((1.5,) * 6, 300)
    assert decode("EgmSensor", sent).all("planned", "joints", "joints") == (1.5,) * 6
    assert packets.read_sensor_packet(sent, "joints", 6) == packets.SensorCommand(300, (1.5,) * 6)


def test_repeated_numbers_may_be_packed_and_fields_may_be_unknown():
    values = struct.pack("<3d", 1, 2, 3)
    packed = b"\x0a" + bytes([len(values)]) + values
    assert decode("EgmJoints", packed).all("joints") == (1, 2, 3)
    strange = b"\x78\x01" + b"\x7d1234" + b"\x79" + bytes(8) + b"\x7a\x02ab"
    assert decode("EgmJoints", strange + packed).all("joints") == (1, 2, 3)


@given(st.binary(max_size=200))
def test_any_bytes_are_a_message_or_none(data):
    link = Egm()
    found = link.read(data)
    assert found is None or len(found.values) == 6
    assert packets.read_sensor_packet(data, "joints", 6) is None or len(data) > 60


def test_a_damaged_message_is_none_or_another():
    whole = packets.robot_packet(packets.RobotState(1, 4, HERE, HERE), "joints")
    assert Egm().read(whole).values == HERE
    assert all(Egm().read(whole[:end]) is None for end in range(60))
    chance = random.Random(1)
    for _ in range(500):
        spoilt = bytearray(whole)
        spoilt[chance.randrange(len(whole))] = chance.randrange(256)
        found = Egm().read(bytes(spoilt))
        assert found is None or all(map(math.isfinite, found.values))


@pytest.mark.parametrize(
    ("changed", "ready", "stopped"),
    [
        ({}, True, ""),
        ({"mci": packets.MCI_STOPPED}, False, "its EGM does not run (any more)"),
        ({"mci": packets.MCI_ERROR}, False, "its EGM reports an error"),
        ({"motors": packets.MOTORS_OFF}, True, "its motors are off"),
        ({"rapid": packets.RAPID_STOPPED}, True, "its program is stopped"),
        ({"rapid": 0}, True, ""),
    ],
)
def test_the_states_of_a_controller_are_told(changed, ready, stopped):
    told = packets.RobotState(7, 28, HERE, HERE, **changed)
    found = Egm().read(packets.robot_packet(told, "joints"))
    assert (found.counter, found.ready, found.stopped) == (7, ready, stopped)


def test_additional_axes_and_poses_come_and_go():
    eight = (*HERE, 12.5, -3.0)
    link = Egm(axes=8)
    assert (
        link.read(packets.robot_packet(packets.RobotState(1, 4, eight, eight), "joints")).values
        == eight
    )
    assert packets.read_sensor_packet(link.command(eight, 0), "joints", 8).values == eight
    link = Egm("poses")
    assert (
        link.read(packets.robot_packet(packets.RobotState(1, 4, POSE, POSE), "poses")).values
        == POSE
    )
    assert packets.read_sensor_packet(link.command(POSE, 0), "poses", 7).values == POSE
    assert Egm().read(packets.robot_packet(packets.RobotState(1, 4, POSE, POSE), "poses")) is None


def test_numbers_that_are_none_are_no_place():
    bad = (math.nan, *HERE[1:])
    assert Egm().read(packets.robot_packet(packets.RobotState(1, 4, bad, bad), "joints")) is None
    wrong = Message(parts={"header": Message({"seqno": [1]})})
    assert Egm().read(encode("EgmRobot", wrong)) is None


# -------------------------------------------------------------------------------- guidance


def test_an_arm_follows_a_trajectory(tmp_path):
    """When nothing more is sent, the controller sees that as its time-out."""
    report, virtual = guided(to(6.0, 3.0))
    assert report.done == report.rows > 20
    assert virtual.guidance.ended == "silent" and virtual.events == [NO_DATA]
    assert virtual.guidance.values == pytest.approx((3.0, *HERE[1:]), abs=1e-3)
    farthest = max(row[0] for row in virtual.track)
    assert 4.0 < farthest < 6.2  # it turns back at 6; on a busy computer packets there come late
    assert {"time", "J1", "to_J1", "tm", "converged", "utilization"} <= set(report.columns)
    report.save(tmp_path / "run.csv")
    assert len((tmp_path / "run.csv").read_text().splitlines()) == len(report.columns["J1"]) + 1


@pytest.mark.slow
def test_a_controller_may_end_as_the_arm_has_converged():
    settings = Settings(
        opening=20.0, settle=5.0, timeout=0.4, softness=1.0, real_time=False, wait="block"
    )
    report, virtual = guided(to(6.0, 3.0), settings=settings, within=0.02, cond_time=0.2)
    assert report.done == report.rows and virtual.guidance.ended == "converged"
    assert virtual.events == [] and virtual.guidance.values[0] == pytest.approx(3.0, abs=0.02)


@pytest.mark.slow
def test_a_tool_is_led_along_poses():
    turned = (math.cos(math.radians(5)), 0.0, 0.0, math.sin(math.radians(5)))
    way = Trajectory.of_poses([POSE[:3], (410.0, 5.0, 600.0)], [POSE[3:], turned])
    limits = Limits((250.0, 90.0), (2000.0, 500.0))
    report, virtual = guided(way, limits, kind="poses", values=POSE, speeds=(500.0, 180.0))
    assert report.done == report.rows and virtual.guidance.ended == "silent"
    assert virtual.guidance.values == pytest.approx((410.0, 5.0, 600.0, *turned), abs=1e-3)


def led(port, trajectory, act=None, virtual=None, settings=QUICK):
    """The loop itself, in this process; what came of it."""
    egm = Egm(trajectory.kind, trajectory.rows.shape[1])
    speeds, rises = LIMITS.columns(trajectory.kind, trajectory.rows.shape[1])
    rows = resampled(trajectory, LIMITS, egm.cycle)
    job = Job(trajectory.kind, rows, tuple(speeds), tuple(rises), settings)
    stop = Stop()
    with PacketSocket(Endpoint("127.0.0.1", 0, "", port)) as wire:
        return Loop(egm, wire, job, stop, lambda *_: act and act(virtual, stop)).run("here")


def faulty(trajectory, act=None, settings=QUICK, **more):
    port = free_port()
    with controller(port, **more) as virtual:
        return led(port, trajectory, act, virtual, settings), virtual


def test_an_emergency_stop_ends_it():
    done, virtual = faulty(to(40.0), lambda virtual, _: virtual.emergency())
    assert (done.code, done.fields["reason"]) == ("CN713", "its motors are off")
    assert 0 < done.done < done.fields["rows"] and virtual.guidance.values[0] < 40


def test_a_controller_that_falls_silent_ends_it():
    done, _ = faulty(to(40.0), lambda virtual, _: virtual.stop(), replace(QUICK, timeout=0.8))
    assert done.code == "CN712" and 0 < done.done < done.fields["rows"]


def test_a_stop_brings_the_arm_to_rest_on_its_way():
    def ask(_, stop):
        stop.asked = True

    done, virtual = faulty(to(40.0), ask)
    assert done.code == "CN715" and 0 < virtual.guidance.values[0] < 40
    last = [row[0] for row in virtual.track[-10:]]
    assert max(last) - min(last) < 0.01


def test_a_controller_that_converges_on_the_way_has_not_followed():
    done, virtual = faulty(to(6.0, 3.0), within=90.0, cond_time=0.1)
    assert (done.code, virtual.guidance.ended) == ("CN713", "converged")


def test_a_controller_that_never_begins_is_told_of():
    assert led(free_port(), to(1.0), settings=Settings(opening=0.1)).code == "CN711"
    done, virtual = faulty(to(1.0), settings=Settings(opening=0.5), waiting=60.0)
    assert done.code == "CN711" and "does not run" in done.fields["reason"]
    assert {row[0] for row in virtual.track} == {0.0}


def test_an_arm_that_is_elsewhere_is_not_moved():
    done, virtual = faulty(to(1.0), values=(50.0, *HERE[1:]))
    assert done.code == "CN703"
    assert {row[0] for row in virtual.track} == {50.0}


@pytest.mark.parametrize(
    "state", [{}, {"mci": packets.MCI_STOPPED}, {"motors": packets.MOTORS_OFF}]
)
def test_a_late_packet_of_an_earlier_run_tells_nothing(state):
    """It tells where the arm was, which would be the begin of a jump, and comes of an old port."""
    port, elsewhere = free_port(), (5.0, *HERE[1:])
    late = packets.robot_packet(
        packets.RobotState(5000, 20_000, elsewhere, elsewhere, **state), "joints"
    )
    egm, trajectory = Egm(), to(0.5)
    speeds, rises = LIMITS.columns("joints", 6)
    job = Job("joints", resampled(trajectory, LIMITS, 0.004), tuple(speeds), tuple(rises), QUICK)
    with (
        PacketSocket(Endpoint("127.0.0.1", 0, "", port)) as wire,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as old,
    ):
        old.sendto(late, ("127.0.0.1", port))
        with controller(port) as virtual:
            done = Loop(egm, wire, job, Stop(), lambda *_: None).run("here")
    assert done.code == "" and done.done == len(job.rows)
    assert max(row[0] for row in virtual.track) < 1.0


def test_garbage_moves_nothing():
    port = free_port()
    over = threading.Event()

    def chatter():
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
            while not over.wait(0.004):
                one.sendto(random.randbytes(80), ("127.0.0.1", port))

    thread = threading.Thread(target=chatter)
    thread.start()
    try:
        done = led(port, to(1.0), settings=Settings(opening=0.5))
    finally:
        over.set()
        thread.join()
    assert done.code == "CN711" and "no sense" in done.fields["reason"] and done.garbled > 5


def test_limits_are_looked_at_before_anything_is_sent():
    limits = Limits((120.0,) * 6, lowest=(-1.0,) * 6, highest=(1.0,) * 6)
    with pytest.raises(Refused) as refused:
        guide("127.0.0.1", to(1.0), limits, port=free_port())
    assert refused.value.findings[0].code == "CN701"


def children():
    found = set()
    for file in Path("/proc/self/task").glob("*/children"):
        with suppress(OSError):  # a thread that has ended meanwhile
            found.update(map(int, file.read_text().split()))
    return found


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="finds processes on Linux only")
def test_a_position_of_a_loop_that_hangs_is_not_given_for_long():
    port, before = free_port(), children()
    limits = replace(LIMITS, lowest=(-180.0,) * 6, highest=(180.0,) * 6)
    settings = replace(QUICK, timeout=1.0)
    with (
        controller(port, comm_timeout=60.0),
        suppress(Refused),  # the controller may fall silent, too, while the loop hangs
        guide_by_corrections("127.0.0.1", 6, limits, port=port, settings=settings) as leading,
    ):
        assert leading.joints() == pytest.approx(HERE)
        (loop,) = children() - before
        os.kill(loop, signal.SIGSTOP)
        try:
            with pytest.raises(Refused) as refused:
                for _ in range(500):
                    leading.joints()
                    time.sleep(0.02)
        finally:
            os.kill(loop, signal.SIGCONT)
    assert [one.code for one in refused.value.findings] == ["CN716"]


# ------------------------------------------------------------------- the virtual controller


def test_the_virtual_arm_is_never_faster_than_it_can():
    guidance = Guidance("joints", HERE, SPEEDS, lag=0.0)
    guidance.step(CYCLE)
    guidance.hear(Egm().command((90.0, *HERE[1:]), 0))
    for _ in range(10):
        guidance.step(CYCLE)
    assert guidance.values[0] == pytest.approx(10 * CYCLE * 200.0)


def test_without_an_answer_the_virtual_controller_says_41822():
    with controller(free_port(), comm_timeout=0.05, waiting=0.0) as virtual:
        assert virtual.wait(10)
    assert virtual.events == [NO_DATA] and virtual.guidance.values == HERE


def test_a_sensor_that_falls_silent_stops_the_virtual_arm():
    guidance = Guidance("joints", HERE, SPEEDS, comm_timeout=0.1)
    guidance.step(CYCLE)
    guidance.hear(Egm().command((90.0, *HERE[1:]), 0))
    while guidance.ended is None:
        guidance.step(CYCLE)
    stood = guidance.values
    guidance.step(1.0)
    assert guidance.ended == "silent" and guidance.values == stood
    assert stood[0] < 200.0 * 0.12


@pytest.mark.parametrize("change", [{"mtype": [0]}, {"mtype": [4]}])
def test_what_is_no_correction_is_passed_over(change):
    message = decode("EgmSensor", Egm().command(HERE, 0))
    message.parts["header"].numbers.update(change)
    guidance = Guidance("joints", HERE, SPEEDS)
    guidance.hear(encode("EgmSensor", message))
    guidance.hear(Egm(axes=7).command((*HERE, 1.0), 0))
    guidance.hear(Egm().command((math.nan, *HERE[1:]), 0))
    assert (guidance.taken, guidance.ignored) == (0, 3)

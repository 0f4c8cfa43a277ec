"""Programs that wait in `Mxt` while a client leads the arm."""

import socket
import struct
import threading
import time

import numpy as np
import pytest

from assistant import languages
from assistant.controllers.mitsubishi.external_control import program
from assistant.virtual.cr.real_time import Enet, mxt_commands
from assistant.virtual.kernel import Kernel
from assistant.virtual.kernel.timed_arm import Timed
from assistant.virtual.melfa import Controller, Entry
from tests.controllers.mitsubishi.mxt.controllers import ARM, CYCLE, joints, led
from tests.virtual.melfa_cell import outputs


def run(text, client, *, timed=False, **settings):
    """Runs a program; a client in another thread gets the port once packets are taken."""
    tree = languages.get("melfa-basic-5").parse(text)
    assert not tree.findings
    kernel = Kernel(most_time=30.0)
    if timed:
        kernel.motion = Timed(ARM)
    threads = []

    def opened(port):
        threads.append(threading.Thread(target=client, args=(port,)))
        threads[0].start()

    commands = mxt_commands(port=0, cycle=CYCLE, opened=opened, **settings)
    table = {1: Entry("A", "CYC")}
    given = {"robot": ARM, "joints": tuple(ARM.home), "commands": commands}
    controller = Controller(kernel, {"A": tree}, table, lines={"ENET:": Enet()}, **given)
    controller.start()
    done = kernel.run()
    for thread in threads:
        thread.join()
    return done, controller


class Port:
    def __init__(self, port):
        self.port = port


def test_a_program_is_led_and_goes_on_behind_it():
    trajectory = joints()
    found = []
    text = program("127.0.0.1", filter_ms=3).replace("40 END", "40 M_Out(5)=1\r\n50 END")
    done, controller = run(
        text,
        lambda port: found.append(led(Port(port), trajectory, first=8, mask=3, word=2)),
        timed=True,
    )
    assert (done.ended, found[0].code) == ("end", ""), done.message
    assert outputs(done)[-1] == ("5", 1.0)
    assert ("9", 1.0) in outputs(done)
    assert controller.arm.shown_joints().values[:6] == pytest.approx(trajectory.rows[-1], abs=0.05)


def test_an_error_of_mxt_is_one_of_the_program():
    def client(port):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
            packet = bytearray(196)
            struct.pack_into("<HHH", packet, 0, 1, 1, 1)  # a pose where joints are announced
            peer.sendto(packet, ("127.0.0.1", port))

    done, _ = run(program("127.0.0.1"), client)
    assert done.ended == "error"
    assert "7840" in done.message


def test_mxttout_is_that_of_the_controller():
    done, _ = run(program("127.0.0.1"), lambda port: None, timeout=lambda: 5)
    assert done.ended == "error"
    assert "7820" in done.message


@pytest.mark.parametrize(
    ("line", "number"),
    [
        ("10 MXT 1,1\n20 END\n", "3110"),
        ('10 OPEN "ENET:127.0.0.1" AS #1\n20 MXT 2,1\n30 END\n', "3110"),
        ('10 OPEN "ENET:127.0.0.1" AS #1\n20 MXT 1,3\n30 END\n', "3110"),
        ('10 OPEN "ENET:127.0.0.1" AS #1\n20 MXT 1,1,-5\n30 END\n', "3110"),
    ],
)
def test_what_mxt_cannot_take(line, number):
    done, _ = run(line, lambda port: None)
    assert done.ended == "error"
    assert number in done.message


def test_a_program_that_is_stopped_halts_it_until_it_goes_on():
    """Another slot stops it; no packet is answered then (BFP-A3379-A, MXT 7)."""
    answered = []
    again, seen = threading.Event(), threading.Event()

    def client(port):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
            peer.connect(("127.0.0.1", port))
            peer.settimeout(0.02)
            ask, end = bytearray(196), bytearray(196)
            struct.pack_into("<HHH", ask, 0, 0, 0, 2)
            struct.pack_into("<HHH", end, 0, 255, 2, 2)
            until = time.monotonic() + 20.0
            while time.monotonic() < until and not (None in answered and answered[-1] is not None):
                peer.send(ask)
                try:
                    answered.append(np.frombuffer(peer.recv(2048)[:2], "<u2")[0])
                except TimeoutError:  # on a busy machine also while it is not halted
                    if controller.slots[0].state == "waits" and answered:
                        answered.append(None)
                        seen.set()
            for _ in range(100):
                peer.send(end)
                try:
                    peer.recv(2048)
                    break
                except (TimeoutError, ConnectionRefusedError):
                    continue
        again.set()

    tree = languages.get("melfa-basic-5").parse(program("127.0.0.1"))
    other = languages.get("melfa-basic-5").parse(
        "10 DLY 0.1\n20 XSTP 1\n30 M1=M_SEEN\n40 XRUN 1\n50 DLY 0.05\n60 END\n"
    )
    kernel = Kernel(most_time=30.0)
    threads = []

    def opened(port):
        threads.append(threading.Thread(target=client, args=(port,)))
        threads[0].start()

    def until_seen(given):
        given.task.wait(seen.is_set, 20.0, "the client", outside=True)
        return 1.0

    commands = mxt_commands(port=0, cycle=CYCLE, opened=opened) | {"M_SEEN": until_seen}
    table = {1: Entry("A", "CYC"), 2: Entry("B", "CYC")}
    controller = Controller(
        kernel,
        {"A": tree, "B": other},
        table,
        robot=ARM,
        joints=tuple(ARM.home),
        lines={"ENET:": Enet()},
        commands=commands,
    )
    controller.start()
    done = kernel.run()
    threads[0].join()
    assert done.ended == "end", done.message
    assert again.is_set()
    assert answered[0] == answered[-1] == 0
    assert None in answered

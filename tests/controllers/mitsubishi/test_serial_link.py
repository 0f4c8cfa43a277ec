"""The controller link over serial lines: pseudo terminals with the virtual controller and peers."""

import os
import sys
import threading
import tty
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers import connect
from assistant.controllers.mitsubishi.data_link import DataLink
from assistant.controllers.mitsubishi.link import frame, unframed
from assistant.controllers.rules import Lost
from assistant.virtual.cr import VirtualCr

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no pseudo terminals")

PROGRAM = b"".join(
    [
        *(b"%d MVS P%d\r\n" % (10 * n, n) for n in range(1, 15)),
        b"150 END\r\n",
        *(
            b"P%d=(+%d.25,+0.00,+450.00,+0.00,+180.00,+0.00)(6,0)\r\n" % (n, n)
            for n in range(1, 15)
        ),
    ]
)
FRAMINGS = ["plain", "procedural"]
STX, ETX, EOT, ENQ, ACK, NAK = b"\x02", b"\x03", b"\x04", b"\x05", b"\x06", b"\x15"


def codes(refused):
    return [finding.code for finding in refused.value.findings]


@contextmanager
def line():
    """The controller's end of a pseudo terminal, and the path of the other one."""
    ours, theirs = os.openpty()
    tty.setraw(ours)
    tty.setraw(theirs)
    try:
        yield ours, os.ttyname(theirs)
    finally:
        os.close(theirs)
        with suppress(OSError):
            os.close(ours)


@contextmanager
def controller_that(speaks):
    """The address of a peer in a thread, and what it heard.

    speaks: gets functions to read up to some bytes, and to send.
    """
    with line() as (descriptor, path):
        heard = bytearray()

        def read(*ends):
            got = bytearray()
            while not any(got.endswith(end) for end in ends):
                got += os.read(descriptor, 1)
            heard.extend(got)
            return bytes(got)

        def run():
            with suppress(OSError):
                speaks(read, lambda data: os.write(descriptor, data))

        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        yield f"melfa-serial://{path}?framing=procedural", heard
    thread.join(5)


@pytest.mark.parametrize("framing", FRAMINGS)
def test_a_program_goes_there_and_comes_back(framing):
    with VirtualCr(serial=True, framing=framing) as controller:
        with connect(controller.serial_address, timeout=5) as client:
            client.write("SEAM", PROGRAM)
            assert client.read("SEAM") == PROGRAM
            assert client.state().override == 100
            assert client.identify().robot == "RV-2AJ"
        with connect(controller.serial_address, timeout=5) as again:
            assert again.names() == ("SEAM",)


def test_the_settings_of_an_address_reach_the_port():
    with VirtualCr(serial=True) as controller:
        options = "?baud=19200&parity=odd&stop=1&bits=8&end=crlf"
        with connect(controller.serial_address + options, timeout=5) as client:
            import termios

            with Path(controller.serial_path).open("rb") as port:
                settings = termios.tcgetattr(port)
            assert settings[4] == termios.B19200
            assert not settings[2] & termios.CSTOPB
            assert client.names() == ()


def test_a_line_belongs_to_one_program_at_a_time():
    with VirtualCr(serial=True) as controller, connect(controller.serial_address):
        with pytest.raises(Lost) as refused, connect(controller.serial_address):
            pass
        assert codes(refused) == ["CN201"]


def test_no_such_line():
    with pytest.raises(Lost) as refused, connect("melfa-serial:///dev/none-of-that-name"):
        pass
    assert codes(refused) == ["CN201"] and refused.value.exit_status == 2


@pytest.mark.parametrize("framing", FRAMINGS)
def test_a_silent_line(framing):
    with line() as (_, path):
        address = f"melfa-serial://{path}?framing={framing}"
        with pytest.raises(Lost) as refused, connect(address, timeout=0.1):
            pass
    assert codes(refused) == ["CN204"] and "in time" in refused.value.findings[0].message


def test_the_other_framing_is_no_hang():
    with VirtualCr(serial=True, framing="procedural") as controller:
        address = f"melfa-serial://{controller.serial_path}"
        with pytest.raises(Lost) as refused, connect(address, timeout=0.5):
            pass
    assert codes(refused)[0] in ("CN204", "CN302")


def test_broken_bytes_are_repaired_by_the_procedure():
    with VirtualCr(serial=True, framing="procedural") as controller:
        controller.faults.broken = 211
        with connect(controller.serial_address, timeout=10) as client:
            client.write("SEAM", PROGRAM)
            assert client.read("SEAM") == PROGRAM
    assert controller.text("SEAM").encode() == PROGRAM


def test_half_a_command_of_an_earlier_connection_does_no_harm():
    with VirtualCr(serial=True) as controller:
        with connect(controller.serial_address) as client:
            client.write("AB", b"10 END\r\n")
            client.write("ABC", b"10 END\r\n")
        descriptor = os.open(controller.serial_path, os.O_WRONLY | os.O_NOCTTY)
        os.write(descriptor, b"1;1;FDELAB")  # of FDELABC
        os.close(descriptor)
        with connect(controller.serial_address) as client:
            assert client.names() == ("AB", "ABC")


def test_a_late_answer_is_not_taken_for_another():
    with VirtualCr(serial=True) as controller:
        controller.faults.delay, controller.faults.times = 0.3, 1
        with pytest.raises(Lost), connect(controller.serial_address, timeout=0.1):
            pass
        with connect(controller.serial_address, timeout=5) as client:
            assert client.names() == ()
            assert client.state().override == 100


def test_a_frame_is_as_the_manual_shows_it():
    sent = frame(b"1;1;OPEN=NARCUSR")
    assert sent[:6] == b"\x02D011R" and sent[-1:] == ETX
    check = 0
    for byte in sent[1:-3]:
        check ^= byte
    assert sent[-3:-1] == b"%02X" % check
    assert unframed(sent[:-1]) == b"1;1;OPEN=NARCUSR"
    assert unframed(sent[:-1].replace(b"NARC", b"NARD")) is None
    assert unframed(b"noise" + sent[:-1]) == b"1;1;OPEN=NARCUSR"


def test_each_step_of_the_procedure_is_tried_again():
    def speaks(read, send):
        read(ENQ)
        send(NAK)
        read(ENQ)
        send(ACK)
        read(ETX)
        send(NAK)
        read(ETX)
        send(ACK)
        read(EOT)
        send(ENQ)
        read(ACK)
        send(frame(b"QoK;;;;MB5").replace(b"MB5", b"MB4"))  # its checksum is wrong now
        read(NAK)
        send(frame(b"QoK;;;;MB5"))
        read(ACK)
        send(EOT)
        read(ENQ)

    with (
        controller_that(speaks) as (address, heard),
        pytest.raises(Lost),
        connect(address, timeout=0.3) as client,
    ):
        assert client.identity.suffix == "MB5"
        client.names()  # which this peer does not answer
    assert heard.count(frame(b"1;1;OPEN=USERTOOL")) == 2


def test_a_controller_that_never_acknowledges():
    def speaks(read, send):
        while True:
            read(ENQ)
            send(NAK)

    with (
        controller_that(speaks) as (address, heard),
        pytest.raises(Lost) as refused,
        connect(address, timeout=3),
    ):
        pass
    assert codes(refused) == ["CN204"] and heard.count(ENQ) == 4


def test_a_controller_that_wants_to_speak_first_is_out_of_step():
    def speaks(read, send):
        while True:
            read(ENQ)
            send(ENQ)

    with (
        controller_that(speaks) as (address, _),
        pytest.raises(Refused) as refused,
        connect(address, timeout=3),
    ):
        pass
    assert codes(refused) == ["CN302"]


def test_a_line_that_is_cut():
    controller = VirtualCr(serial=True)
    controller.start()
    address = controller.serial_address
    with pytest.raises(Lost) as refused, connect(address, timeout=1) as client:
        controller.stop()
        client.names()
    assert codes(refused) == ["CN204"]


@pytest.mark.parametrize(("framing", "late"), [("plain", "CNTLON"), ("procedural", "SRVON")])
def test_a_line_that_falls_silent_gives_the_right_back(framing, late):
    """An answer comes too late while the operation right is held, or may be."""

    def report(told):
        if late in told:
            controller.faults.times, controller.faults.delay = 1, 0.5

    with VirtualCr(serial=True, framing=framing, report=report) as controller:
        address = controller.serial_address
        with pytest.raises(Lost) as refused, connect(address, timeout=0.35) as client:
            client.motors(True)
        assert codes(refused)[0] == "CN204"
        assert controller.state.right is None or "CN306" in codes(refused)


@pytest.mark.parametrize("opened", [connect, DataLink], ids=["controller link", "data link"])
def test_pyserial_that_is_not_installed(opened, monkeypatch):
    monkeypatch.setitem(sys.modules, "serial", None)
    device = "/dev/ttyS9"
    with (
        pytest.raises(Refused) as refused,
        opened(device if opened is DataLink else f"melfa-serial://{device}"),
    ):
        pass
    assert codes(refused) == ["CN612"] and "[serial]" in refused.value.findings[0].cure

"""The serial side of the virtual CR controller over a pseudo terminal: both framings, faults."""

import os
import select
import time

import pytest

from assistant.controllers import connect
from assistant.virtual.cr import VirtualCr
from assistant.virtual.cr.session import from_frame, in_frame
from tests.virtual.cr.waiting import wait_for
from tests.wire import Wire

ENQ, ACK, NAK, EOT = b"\x05", b"\x06", b"\x15", b"\x04"


class Line:
    """One end of a pseudo terminal, byte by byte."""

    def __init__(self, path):
        self.descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY)
        self._come = b""

    def __enter__(self):
        return self

    def __exit__(self, *error):
        os.close(self.descriptor)

    def send(self, data):
        os.write(self.descriptor, data)

    def receive(self, count, seconds=5.0):
        """So many bytes; fewer only if the line stays quiet."""
        while len(self._come) < count:
            if not select.select([self.descriptor], [], [], seconds)[0]:
                break
            self._come += os.read(self.descriptor, 1000)
        got, self._come = self._come[:count], self._come[count:]
        return got

    def until(self, end):
        data = b""
        while not data.endswith(end):
            byte = self.receive(1)
            assert byte, f"the line is quiet behind {data!r}"
            data += byte
        return data


@pytest.fixture
def plain():
    with VirtualCr("rv-2aj", serial=True) as controller, Line(controller.serial_path) as line:
        yield controller, line


@pytest.fixture
def procedural():
    with (
        VirtualCr("rv-2aj", serial=True, framing="procedural") as controller,
        Line(controller.serial_path) as line,
    ):
        yield controller, line


def test_a_frame_is_as_the_manual_has_it():
    # BFP-A4288 3.2: STX 'D' '0' length 'R' command checksum ETX; the sum is worked out by hand
    assert in_frame(b"1;1;TIME") == b"\x02D009R1;1;TIME3A\x03"
    assert from_frame(b"\x02D009R1;1;TIME3A") == b"1;1;TIME"
    assert from_frame(b"\x02D009R1;1;TIME1B") is None
    assert from_frame(b"\x02D008R1;1;TIME3B") is None


@pytest.mark.parametrize("end", [b"\r", b"\r\n"])
def test_commands_without_a_procedure(plain, end):
    _, line = plain
    for _ in range(2):
        line.send(b"1;1;OVRD" + end)
        assert line.until(b"\r") == b"QoK100\r"


def test_it_is_switched_off_while_commands_come(plain):
    """Nothing goes wrong in its threads, which pytest would tell."""
    controller, _ = plain
    for _ in range(5):
        with Line(controller.serial_path) as line:
            line.send(b"1;1;STATE\r" * 100)
            line.until(b"\r")
            controller.stop()
        controller.start()


def test_answers_end_as_the_parameter_says(plain):
    controller, line = plain
    line.send(b"1;1;PRM=CTERM232;1\r")
    assert line.until(b"\r") == b"QoK\r"
    controller.stop()
    controller.start()
    with Line(controller.serial_path) as again:
        again.send(b"1;1;OVRD\r")
        assert again.until(b"\n") == b"QoK100\r\n"


def test_a_command_and_its_answer_with_the_procedure(procedural):
    _, line = procedural
    pairs = (
        (b"1;1;OVRD", b"QoK100"),
        (b"1;1;FROB", b"QeR6010"),
        (b"1;1;LOAD=A", b"QoK"),
        (b"1;1;EDATA10 END\r20 HLT", b"QeR6010"),
    )
    for command, answer in pairs:
        line.send(ENQ)
        assert line.receive(1) == ACK
        line.send(in_frame(command))
        assert line.receive(1) == ACK
        line.send(EOT)
        assert line.receive(1) == ENQ
        line.send(ACK)
        assert line.until(b"\x03") == in_frame(answer)
        line.send(ACK)
        assert line.receive(1) == EOT


def test_a_damaged_frame_is_asked_for_again(procedural):
    _, line = procedural
    line.send(ENQ)
    assert line.receive(1) == ACK
    line.send(in_frame(b"1;1;OVRD").replace(b"OVRD", b"OVRX"))
    assert line.receive(1) == NAK
    line.send(in_frame(b"1;1;OVRD"))
    assert line.receive(1) == ACK
    line.send(EOT)
    assert line.receive(1) == ENQ
    line.send(NAK)
    assert line.receive(1) == ENQ
    line.send(ACK)
    for _ in range(2):
        assert line.until(b"\x03") == in_frame(b"QoK100")
        line.send(NAK)
    assert line.until(b"\x03") == in_frame(b"QoK100")
    line.send(ACK)
    assert line.receive(1) == EOT


def test_a_client_that_gives_up_leaves_the_line_usable(procedural):
    _, line = procedural
    line.send(ENQ)
    assert line.receive(1) == ACK
    line.send(b"\x02D009R1;1;TI")
    for _ in range(100):  # the controller waits a second for the rest of the frame
        line.send(ENQ)
        if line.receive(1, 0.1) == ACK:
            break
    else:
        pytest.fail("the line stays out of use")


def test_the_client_of_the_project_speaks_without_a_procedure(plain):
    controller, _ = plain
    with connect(controller.serial_address) as client:
        client.write("SEAM", b"10 END\r\n")
        assert client.names() == ("SEAM",)


def test_the_client_of_the_project_speaks_with_the_procedure(procedural):
    controller, _ = procedural
    with connect(controller.serial_address) as client:
        client.write("SEAM", b"10 END\r\n")
        assert client.read("SEAM") == b"10 END\r\n"


def test_faults_of_answers():
    with VirtualCr("rv-2aj") as controller, Wire(controller.port) as wire:
        faults = controller.faults
        faults.errors = {"OVRD": 5640, "OVRD=": 5600}
        assert wire.ask("1;1;OVRD") == "QeR5640"
        assert wire.ask("1;1;OVRD=3") == "QeR5600"
        faults.errors = {}
        faults.twice, faults.times = True, 1
        wire.send(b"1;1;OVRD\r")
        assert [wire.answer(), wire.answer()] == ["QoK100", "QoK100"]
        assert wire.ask("1;1;PRGRD") == "QoK"
        faults.twice, faults.times, faults.garbage = False, None, b"\xff?"
        assert wire.ask("1;1;OVRD") == "\xff?"
        faults.garbage, faults.terminator = None, b"#"
        wire.send(b"1;1;OVRD\r")
        assert wire.answer(b"#") == "QoK100"
        faults.terminator, faults.broken = None, 3
        wire.send(b"1;1;OVRD\r")
        spoilt = wire.socket.recv(100)
        assert sum(a != b for a, b in zip(spoilt, b"QoK100\r", strict=True)) in (2, 3)
        faults.broken, faults.delay = 0, 0.05
        before = time.monotonic()
        assert wire.ask("1;1;OVRD") == "QoK100"
        assert time.monotonic() - before >= 0.05
        faults.delay, faults.drop_after = 0.0, 4
        wire.send(b"1;1;OVRD\r")
        assert wire.socket.recv(100) == b"QoK1"
        assert wire.closed_by_peer()
        with Wire(controller.port) as again:
            assert again.ask("1;1;OVRD") == "QoK100"


def test_a_program_talks_over_the_serial_line():
    with (
        VirtualCr("rv-2aj", serial=True, framing="data link") as controller,
        Wire(controller.port) as wire,
        Line(controller.serial_path) as line,
    ):
        lines = ('10 OPEN "COM1:" AS #1', "20 INPUT #1,M1", "30 PRINT #1,M1*2", "40 END")
        for command in ("CNTLON", "LOAD=L", *(f"EDATA{text}" for text in lines), "SAVE", "RUNL;1"):
            assert wire.ask(f"1;1;{command}") == "QoK", command
        wait_for(lambda: wire.ask("1;1;LINENO") == "QoK20")
        line.send(b"21\r")
        assert float(line.until(b"\r")) == 42.0


@pytest.mark.parametrize("before", ["nothing", "a link that leads nowhere"])
def test_a_line_has_the_name_that_it_is_given(before, tmp_path):
    link = tmp_path / "line"
    if before != "nothing":
        link.symlink_to(tmp_path / "gone")
    with VirtualCr("rv-2aj", serial=f"pty:{link}") as controller:
        assert controller.serial_address == f"melfa-serial://{link}"
        with connect(controller.serial_address, timeout=5) as client:
            assert client.names() == ()
    assert not link.is_symlink()


@pytest.mark.parametrize("there", ["file", "line of another controller"])
def test_a_name_that_is_taken_stays_as_it_is(there, tmp_path):
    link = tmp_path / "line"
    if there == "file":
        link.write_text("kept")
    with VirtualCr("rv-2aj", serial=True if there == "file" else f"pty:{link}") as other:
        with (
            pytest.raises(FileExistsError, match="is there already"),
            VirtualCr("rv-2aj", serial=f"pty:{link}"),
        ):
            pass
        kept = link.read_text() if there == "file" else str(link.readlink())
        assert kept == ("kept" if there == "file" else os.path.realpath(other.serial_path))

"""The client of the controller link against the virtual controller and against bad peers."""

import contextlib
import socket
import threading

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant.base.diagnostics import Refused
from assistant.controllers import connect
from assistant.controllers.mitsubishi.cr import Cr, identity
from assistant.controllers.mitsubishi.programs import listed_form
from assistant.controllers.rules import Lost
from assistant.virtual.cr import VirtualCr
from tests.examples import drawn
from tests.wire import Wire

PROGRAM = b"".join(
    [
        b"10 'seam;  1\r\n20 OVRD 50\r\n",
        *(b"%d MVS P%d\r\n" % (20 + 10 * n, n) for n in range(1, 60)),
        b"990 END\r\n",
        *(
            b"P%d=(+%d.25,-%d.50,+450.00,+0.00,+180.00,+0.00)(6,0)\r\n" % (n, n, n)
            for n in range(1, 60)
        ),
    ]
)


def codes(refused):
    return [finding.code for finding in refused.value.findings]


@contextlib.contextmanager
def peer(*answers, hang_up=True):
    """A peer that sends these bytes, one a command, then hangs up or goes silent."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        heard = []
        done = threading.Event()

        def serve():
            connection, _ = listener.accept()
            with connection:
                connection.settimeout(10)
                for answer in answers:
                    data = connection.recv(4096)
                    if not data:
                        return
                    heard.append(data)
                    connection.sendall(answer)
                if not hang_up:
                    done.wait(10)

        thread = threading.Thread(target=serve)
        thread.start()
        try:
            yield listener.getsockname()[1], heard
        finally:
            done.set()
            with contextlib.suppress(OSError):  # lets a peer go that nobody spoke to
                socket.create_connection(listener.getsockname(), timeout=1).close()
            thread.join()


@pytest.mark.parametrize("terminator", [b"\r", b"\r\n"])
def test_a_program_goes_there_and_comes_back(terminator):
    with VirtualCr(terminator=terminator) as controller, connect(controller.address) as client:
        assert client.names() == ()
        assert client.read("SEAM") is None
        client.write("SEAM", PROGRAM)
        assert client.names() == ("SEAM",)
        assert client.read("SEAM") == PROGRAM
        client.write("SEAM", b"10 END\r\n")
        assert client.read("SEAM") == b"10 END\r\n"
        client.remove("SEAM")
        client.remove("SEAM")
        assert client.names() == ()


def test_a_controller_may_send_no_end_code():
    """Each answer costs its time of silence."""
    with VirtualCr(terminator=b"") as controller, connect(controller.address) as client:
        client.write("SEAM", b"10 END\r\n")
        assert client.read("SEAM") == b"10 END\r\n"
        client.remove("SEAM")
        assert client.names() == ()


@pytest.mark.parametrize("terminator", [b"\r\n", b""])
def test_the_end_code_of_commands_is_free(terminator):
    with VirtualCr(quiet=0.02) as controller:
        from assistant.controllers import parse

        with Cr(parse(controller.address), terminator=terminator) as client:
            client.write("SEAM", b"10 END\r\n")
            assert client.read("SEAM") == b"10 END\r\n"


def test_a_session_knows_the_controller():
    with VirtualCr("rv-2aj") as controller, connect(controller.address) as client:
        assert client.languages == ("melfa-basic-4",)
        assert (client.identity.robot, client.identity.slots) == ("RV-2AJ", 8)
    real = "3F;3F;7,0;3,5,A,1E,32,46,64;MB5;PRM;RV-4A;CRn-5xx;MELFA;03-11-19;Ver.J4;ENG;C;1;1;12;"
    assert identity(real).suffix == "MB5" and identity(real).slots == 12
    assert identity("").slots == 8


def test_a_refused_line_is_named_and_the_old_program_stays():
    with VirtualCr() as controller, connect(controller.address) as client:
        client.write("SEAM", b"10 END\r\n")
        bad = PROGRAM.replace(b"300 MVS P28", b"300 MVS ((")
        with pytest.raises(Refused) as refused:
            client.write("SEAM", bad)
        finding = refused.value.findings[0]
        assert finding.code == "CN303" and "4220" in finding.message
        assert finding.line == bad.splitlines().index(b"300 MVS ((") + 1
        assert finding.column and finding.excerpt == "300 MVS (("
        assert "as it was" in finding.message
        assert controller.text("SEAM") == "10 END\r\n"
        # The session goes on, and the program is not left open.
        client.write("SEAM", b"10 DLY 1\r\n")
        assert controller.text("SEAM") == "10 DLY 1\r\n"


@pytest.mark.parametrize(
    ("program", "code"),
    [(b"10 '" + b"x" * 300, "CN304"), (b"10 END\v20 END", "CN305"), (b"10 'a\0b", "CN305")],
)
def test_lines_that_cannot_be_carried_are_not_sent(program, code):
    with VirtualCr() as controller, connect(controller.address) as client:
        client.write("SEAM", b"10 END\r\n")
        with pytest.raises(Refused) as refused:
            client.write("SEAM", b"5 DLY 1\r\n" + program)
        assert codes(refused) == [code] and refused.value.findings[0].line == 2
        assert controller.text("SEAM") == "10 END\r\n"


@pytest.mark.parametrize(
    "name", ["", "seam", "../SEAM", "SEAM-1", "MUCHTOOLONGNAME", "A\rB", "A;B"]
)
def test_names_that_are_none_are_refused_here(name):
    with VirtualCr() as controller, connect(controller.address) as client:
        for act in (client.read, client.remove, lambda n: client.write(n, b"10 END\r\n")):
            with pytest.raises(Refused) as refused:
                act(name)
            assert codes(refused) == ["CN207"]


def test_names_of_files():
    with VirtualCr() as controller:
        client = connect(controller.address)
        assert client.name_for("out/seam_1.prg".replace("_", "")) == "SEAM1"
        with pytest.raises(Refused):
            client.name_for("a seam.prg")


def test_a_program_open_elsewhere_is_a_finding_with_cure():
    with VirtualCr() as controller, Wire(controller.port) as other:
        other.ask("1;1;LOAD=SEAM")
        with connect(controller.address) as client, pytest.raises(Refused) as refused:
            client.write("SEAM", PROGRAM)
        assert codes(refused) == ["CN301"]
        assert "4170" in refused.value.findings[0].message


def test_an_error_state_is_no_obstacle():
    with VirtualCr() as controller, connect(controller.address) as client:
        controller.alarm(2800)
        client.write("SEAM", PROGRAM)
        assert listed_form(client.read("SEAM")) == listed_form(PROGRAM)


def test_nobody_there():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    with pytest.raises(Lost) as refused, connect(f"melfa://127.0.0.1:{port}"):
        pass
    assert codes(refused) == ["CN201"] and refused.value.exit_status == 2


def test_another_kind_of_server():
    with peer(b"220 FTP ready\r\n") as (port, _):
        with pytest.raises(Lost) as refused, connect(f"melfa://127.0.0.1:{port}"):
            pass
        assert codes(refused) == ["CN302"]


@pytest.mark.parametrize("answers", [[], [b"QoK\r"], [b"QoK\r", b"QoK\r", b"Qo"]])
def test_a_controller_that_falls_silent(answers):
    with (
        peer(*answers, hang_up=False) as (port, _),
        pytest.raises(Lost) as refused,
        connect(f"melfa://127.0.0.1:{port}", timeout=0.3) as client,
    ):
        client.write("SEAM", PROGRAM)
    assert codes(refused) == ["CN204"] and "in time" in refused.value.findings[0].message


def test_a_controller_that_hangs_up_in_the_middle():
    answers = [b"QoK\r"] * 6
    with (
        peer(*answers) as (port, heard),
        pytest.raises(Lost) as refused,
        connect(f"melfa://127.0.0.1:{port}") as client,
    ):
        client.write("SEAM", PROGRAM)
    assert codes(refused) == ["CN204"]
    assert "as it was" in refused.value.findings[0].message
    assert all(len(command) <= 256 for command in heard)
    assert not any(b"SAVE" in command for command in heard)


def test_the_operation_right_is_taken_where_it_is_asked_for_and_given_back():
    answers = [b"QoK\r", b"QoK\r", b"QeR6020\r", b"QoK\r", *[b"QoK\r"] * 7]
    with peer(*answers) as (port, heard), connect(f"melfa://127.0.0.1:{port}") as client:
        client.write("SEAM", b"10 END\r\n")
    sent = [command.split(b";", 2)[2].strip() for command in heard]
    assert sent == [
        b"OPEN=USERTOOL", b"NEW", b"LOAD=SEAM", b"CNTLON", b"LOAD=SEAM", b"ECLR",
        b"EMDAT10 END", b"SAVE", b"NEW", b"CNTLOFF", b"CLOSE",
    ]  # fmt: skip


LINE = st.from_regex(r"[1-9][0-9]{0,3} '[ -~\x80-\xff]{0,110}", fullmatch=True)


@pytest.fixture(scope="module")
def lasting():
    """A controller for many programs, and its client."""
    with VirtualCr() as controller, connect(controller.address) as client:
        yield controller, client


@settings(deadline=None, max_examples=drawn(25))
@given(st.lists(LINE, max_size=40, unique_by=lambda line: int(line.split()[0])))
def test_any_comments_come_back_byte_for_byte(lasting, lines):
    controller, client = lasting
    lines = sorted((line.rstrip(" ") for line in lines), key=lambda line: int(line.split()[0]))
    program = "".join(f"{line}\r\n" for line in lines).encode("latin-1")
    try:
        client.write("SEAM", program)
    except Refused as refused:
        # Bytes that are no character of the controller's code page are refused, not changed.
        assert {finding.code for finding in refused.findings} == {"CN303"}
    else:
        assert client.read("SEAM") == program
        client.remove("SEAM")
    assert controller.names() == ()

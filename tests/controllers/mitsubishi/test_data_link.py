"""The data link: programs of a controller at the other end of real sockets and serial ports."""

import math
import os
import pty
import socket
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant.base.diagnostics import Refused
from assistant.controllers.mitsubishi.data_link import (
    DataLink,
    Form,
    Joints,
    Position,
    Rate,
    input_line,
    read_value,
    stream_to,
)
from assistant.controllers.recording import Recording
from assistant.controllers.rules import Lost
from assistant.virtual.melfa.communication_lines import TcpClient
from tests.controllers.mitsubishi.running import Running, serial, tcp

NAN = math.nan
FORM = Form.parse("M_TIMER(1) | P_CURR | J_FBC | J_CURR | M_RSPD(3)")
PRINTED = (
    "12.5     |(+250.00,+0.00,+450.00,+0.00,+180.00)(6,0)|(0.00,21.19,72.78,****,86.03,0.00)"
    "|(0.00,21.19,72.78,,86.03,0.00)|+100.00"
)
PROGRAM = """10 DEF JNT JGOAL
20 DEF POS PSEEN
30 DEF CHAR CWORD
40 OPEN "COM2:" AS #1
50 INPUT #1,M1,JGOAL,PSEEN,CWORD
60 MOV JGOAL
70 PRINT #1,M1,"|",J_CURR,"|",PSEEN,"|",CWORD
80 IF CWORD<>"end" THEN 50
90 CLOSE #1
100 END
"""
ECHO = Form.parse("M1 | J_CURR | PSEEN | CWORD")


def codes(refused):
    return [finding.code for finding in refused.value.findings]


# ----------------------------------------------------------------------------------- records


def test_a_record_of_the_paper_is_read():
    seconds, place, joints, commanded, speed = FORM.read(PRINTED)
    assert (seconds, speed) == (12.5, 100.0)
    assert place.values[:5] == (250, 0, 450, 0, 180) and place.flags == (6, 0)
    assert np.isnan(place.values[5:]).all() and math.isnan(joints.values[3])
    assert joints.values[4] == commanded.values[4] == 86.03


@pytest.mark.parametrize(
    "line",
    [
        *("", "1|2", PRINTED.replace("|", ";"), PRINTED + "|0", PRINTED.replace("(6,0)", "")),
        *(PRINTED.replace("(6,0)", "(6)"), PRINTED.replace("12.5", "nan")),
        *(PRINTED.replace("12.5", "1e999"), PRINTED.replace("12.5", "one")),
        *(PRINTED.replace("(0.00,21", "(0.00(21"), PRINTED.replace("(6,0)", "(6,0.5)")),
        PRINTED.replace("(0.00,", "(1,2,3,4,0.00,"),
    ],
)
def test_a_record_of_another_form_is_none(line):
    with pytest.raises(ValueError):
        FORM.read(line)


@given(st.text(max_size=60))
def test_any_text_is_a_record_or_none(text):
    try:
        values = FORM.read(text)
    except ValueError:
        return
    assert len(values) == 5


@given(st.lists(st.floats(-9999, 9999), min_size=1, max_size=8), st.integers(0, 7))
def test_what_is_written_is_read_back(values, flag):
    for value in (Joints(tuple(values)), Position(tuple(values), (flag, 0))):
        kind = "joints" if isinstance(value, Joints) else "position"
        back = read_value(input_line([value]), kind)
        assert np.allclose(back.values[: len(values)], values, atol=5e-5)
        assert np.isnan(back.values[len(values) :]).all()


@pytest.mark.parametrize(
    "value",
    [
        *("a,b", "a\rb", "a\nb", "a(b", 'a"b', "\u20ac", "x" * 256, NAN, math.inf),
        *(Joints(()), Joints((NAN,)), Joints((0.0,) * 9), Joints((math.inf,))),
    ],
)
def test_what_no_line_carries_is_refused(value):
    with pytest.raises(Refused) as refused:
        input_line([value])
    assert codes(refused) == ["CN616"]


@pytest.mark.parametrize("form", ["", "1", "M_TIMER(1) |", "X_CURR", "M_TIMER(1); P_CURR", "P("])
def test_a_form_that_nothing_prints_is_refused(form):
    with pytest.raises(Refused) as refused:
        Form.parse(form)
    assert codes(refused) == ["CN617"]


# -------------------------------------------------------------------------------- recordings


def recorded():
    recording = FORM.recording("seconds")
    for number in range(3):
        FORM.record(recording, FORM.read(PRINTED), 0.5 * number)
    return recording


def test_records_are_kept_in_columns_and_saved(tmp_path):
    recording = recorded()
    assert recording.column("seconds").tolist() == [0, 0.5, 1]
    assert recording.column("P_CURR").shape == (3, 10)
    recording.save(tmp_path / "a.csv")
    recording.save(tmp_path / "a.npz")
    head, *rows = (tmp_path / "a.csv").read_text().splitlines()
    assert head.startswith("seconds,M_TIMER(1),P_CURR.X,") and ",P_CURR.FL1," in head
    assert len(rows) == 3 and rows[1].startswith("0.5,12.5,250.0,0.0,450.0,0.0,180.0,,,,6.0,")
    with np.load(tmp_path / "a.npz") as saved:
        assert set(saved) == set(recording.fields)
        for name in saved:
            np.testing.assert_array_equal(saved[name], recording.column(name))
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a.csv", "a.npz"]


def test_a_recording_that_cannot_be_saved_leaves_what_was_there(tmp_path):
    (tmp_path / "a.csv").mkdir()
    for name, code in (("a.txt", "CN601"), ("no/a.csv", "CN602"), ("a.csv", "CN602")):
        with pytest.raises(Refused) as refused:
            recorded().save(tmp_path / name)
        assert codes(refused) == [code]
    assert [file.name for file in tmp_path.iterdir()] == ["a.csv"]


def test_a_row_that_does_not_fit_is_none():
    recording = Recording({"a": (), "b": ("x", "y")})
    for row in ((1.0,), (1.0, 2.0), (1.0, (1.0, 2.0, 3.0)), (1.0, (1.0, 2.0), 3.0)):
        with pytest.raises(ValueError):
            recording.add(*row)
    assert len(recording) == 0


# ------------------------------------------------------------------------------------- lines


@pytest.mark.parametrize("kind", [tcp, serial])
def test_a_program_reads_what_is_sent_and_prints_it_back(kind):
    with kind() as (line, target), Running({"ECHO": PROGRAM}, {"COM2:": line}) as running:
        with DataLink(target, rate=Rate(19200, "none", 1)) as link:
            for number, word in enumerate(["go", "on", "end"]):
                goal = Joints((10.0 * number, 0.5, 90.0, NAN, 89.9999, 0.0))
                link.send(number + 0.25, goal, Position((1, 2, 3, 4, 5, 6), (7, 0)), word)
                count, joints, seen, said = link.record(ECHO)
                assert (count, said) == (number + 0.25, word)
                assert joints.values[:6] == (10.0 * number, 0.5, 90, 0, 90, 0)
                assert (seen.values[:6], seen.flags) == ((1, 2, 3, 4, 5, 6), (7, 0))
        assert running.ended().ended == "end", running.done.message


def test_a_controller_may_be_the_client():
    """NETMODE 0: the program connects to this computer."""
    link = DataLink("listen:127.0.0.1:0")
    link.prepare()
    line = TcpClient("127.0.0.1", link.stream.port)
    with Running({"ECHO": PROGRAM}, {"COM2:": line}) as running, link:
        link.send(1, Joints((1, 2, 3)), Position((0,) * 6), "end")
        assert link.record(ECHO)[0] == 1
        assert running.ended().ended == "end", running.done.message


def test_data_on_a_line_for_commands_has_its_prefix():
    program = '10 OPEN "COM1:" AS #1\n20 INPUT #1,M1\n30 PRINT #1,M1+1\n40 END\n'
    from assistant.virtual.melfa import Options

    options = Options(prefixed=True)
    with (
        tcp() as (line, target),
        Running({"A": program}, {"COM1:": line}, options=options),
        DataLink(target, prefix="PRN") as link,
    ):
        link.send(41)
        assert link.record(Form.parse("M1")) == (42.0,)


@contextmanager
def peer(*pieces, hang_up=True):
    """A controller that sends these bytes, then hangs up or says nothing more."""
    done = threading.Event()

    def serve(listener):
        with listener.accept()[0] as connection:
            for piece in pieces:
                connection.sendall(piece)
            if not hang_up:
                done.wait(20)

    with socket.create_server(("127.0.0.1", 0)) as listener, ThreadPoolExecutor() as pool:
        served = pool.submit(serve, listener)
        try:
            yield f"127.0.0.1:{listener.getsockname()[1]}"
        finally:
            done.set()
        served.result()


def test_lines_end_with_cr_or_cr_lf_wherever_they_are_cut():
    with peer(b"1\r\n", b"2", b"\r", b"\n3\r4\r\n\r5", b"5\r") as target, DataLink(target) as link:
        assert [link.receive() for _ in range(6)] == ["1", "2", "3", "4", "", "55"]


@pytest.mark.parametrize(
    ("pieces", "hang_up", "code"),
    [
        ((b"1|2",), True, "CN614"),  # cut within a line
        ((), True, "CN614"),
        ((b"1|2",), False, "CN614"),  # silence within a line
        ((b"?" * 5000,), False, "CN615"),
        ((b"\x00\xff\x80\r",), False, "CN615"),
        ((b"Qer6010\r",), False, "CN615"),
    ],
)
def test_a_bad_peer_is_found_in_time(pieces, hang_up, code):
    with peer(*pieces, hang_up=hang_up) as target, DataLink(target, timeout=0.3) as link:
        with pytest.raises(Lost) as lost:
            link.record(FORM)
        assert codes(lost) == [code]
        with pytest.raises(Lost) as lost:
            link.receive()
        assert codes(lost) == ["CN614"]


def test_a_serial_line_that_is_pulled_out_is_lost():
    other, port = pty.openpty()
    with DataLink(os.ttyname(port), timeout=5) as link:
        os.write(other, b"1\r2")
        assert link.receive() == "1"
        os.close(other)
        with pytest.raises(Lost) as lost:
            link.receive()
        assert codes(lost) == ["CN614"]
    os.close(port)


def test_a_serial_line_that_says_nothing_is_lost():
    other, port = pty.openpty()
    with DataLink(os.ttyname(port), timeout=0.1) as link, pytest.raises(Lost) as lost:
        link.receive()
    assert codes(lost) == ["CN614"]
    os.close(other)
    os.close(port)


def test_lines_that_are_none_are_refused():
    for target in (
        "",
        "host",
        "host:",
        "host:x",
        "host:0",
        "host:99999",
        "a b:1",
        "ho\rst:1",
        "/\n",
    ):
        with pytest.raises(Refused) as refused:
            stream_to(target)
        assert codes(refused) == ["CN611"], target
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        taken = DataLink(f"listen:127.0.0.1:{port}")
        with pytest.raises(Lost) as lost:
            taken.prepare()
        assert codes(lost) == ["CN613"]
    for target in (f"127.0.0.1:{port}", "/dev/no-such-port", "listen:127.0.0.1:0"):
        with pytest.raises(Lost) as lost, DataLink(target, timeout=0.2):
            pass
        assert codes(lost) == ["CN613"], target

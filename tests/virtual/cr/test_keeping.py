"""What the virtual CR controller keeps: files, edits, variables, parameters, signals, errors."""

import datetime

import pytest

from assistant.virtual.cr import VirtualCr
from tests.virtual.cr.test_link import load
from tests.wire import Wire

POSITION = "P1=(+250.00,+0.00,+450.00,+0.00,+180.00,+0.00)(6,0)"
MOMENT = datetime.datetime(2024, 2, 28, 12, 0, 5)


@pytest.fixture(scope="module")
def served():
    with (
        VirtualCr("rv-2aj", clock=lambda: MOMENT) as controller,
        Wire(controller.port) as wire,
    ):
        yield controller, wire


@pytest.fixture
def wire(served):
    _, wire = served
    for command in ("CLOSE", "FINIT", "PRMINIT", "RSTPWR"):
        assert wire.ask(f"1;1;{command}") == "QoK"
    return wire


def asks(wire, *pairs):
    for request, answer in pairs:
        assert wire.ask(f"1;1;{request}") == answer, request


def test_a_file_goes_out_and_in_by_blocks(wire):
    load(wire, "SEAM", *(f"{n} DLY {n}" for n in range(10, 400, 10)), POSITION)
    asks(wire, ("FOPENSEAM;r", "QoK"), ("FOPENSEAM;r", "QeR6050"), ("FWRITE1;00", "QeR4200"))
    data, more = b"", "1"
    while more == "1":
        block, more = wire.ask("1;1;FREAD")[3:].split(";")
        assert len(block) <= 240
        data += bytes.fromhex(block)
    asks(wire, ("FCLOSE", "QoK"), ("FCLOSE", "QeR6050"), ("FREAD", "QeR5140"))
    assert data.endswith(b"390 DLY 390\r\n" + POSITION.encode() + b"\r\n")
    asks(wire, ("FOPENCOPY;w", "QoK"))
    for at in range(0, len(data), 100):
        piece = data[at : at + 100]
        asks(wire, (f"FWRITE{len(piece)};{piece.hex()}", "QoK"))
    asks(wire, ("FWRITE3;0000", "QeR4460"), ("FCLOSE", "QoK"))
    asks(wire, ("LOAD=COPY", "QoK"), ("LISTIEND", "QoK390 DLY 390"), ("LISTP+1", f"QoK{POSITION}"))
    asks(wire, ("FOPENODD;w", "QoK"), ("FWRITE3;ff00ff", "QoK"), ("FCLOSE", "QeR4160"))
    asks(wire, ("FCHECKODD", "QoKF"), ("FOPENODD;r", "QeR4140"), ("FOPENODD;x", "QeR5410"))


def test_files_are_copied_renamed_and_protected(wire):
    load(wire, "A", "10 END", POSITION)
    asks(wire, ("FCOPYA;B", "QoK"), ("FRENAMEB;C", "QoK"), ("FCHECKB", "QoKF"), ("FCHECKC", "QoKN"))
    asks(wire, ("FCOPYX;B", "QeR7000"), ("FDELX", "QeR7010"), ("FRENAMEX;B", "QeR7020"))
    asks(wire, ("FPATH=X", "QeR4140"), ("FATTRIBA;+x", "QeR4460"), ("FCOPYA", "QeR4460"))
    asks(wire, ("FATTRIBA;+p", "QoK"), ("FATTRIBA;+q", "QoK"), ("LOAD=A", "QoK"))
    asks(wire, ("EDATA10", "QeR4240"), (f"EDATA{POSITION}", "QeR4320"), ("ECLR", "QeR4240"))
    asks(wire, ("DELETE10;10", "QeR4240"), ("VAL=M1=2", "QeR4320"), ("NEW", "QoK"))
    asks(wire, ("HOTA;M1=1", "QeR4320"), ("FATTRIBA;-p", "QoK"), ("FATTRIBA;-q", "QoK"))
    asks(
        wire, ("LOAD=A", "QoK"), ("EDATA10 HLT", "QoK"), ("FDELA", "QeR4170"), ("FINIT", "QeR4170")
    )
    assert wire.ask("1;1;FDIRTOP").split(";")[3] == "2"


def test_lines_are_inserted_found_and_numbered_anew(wire):
    load(wire, "A", "10 GOTO 30", "20 DLY 1", "30 END")
    asks(wire, ("LOAD=A", "QoK"), ("EDINS=20;HLT", "QoK"))
    asks(wire, ("LISTLTOP", "QoK10 GOTO 30\v20 HLT\v21 DLY 1\v30 END;4;0"))
    asks(wire, ("EDINS=x;HLT", "QeR4420"), ("EDINS=20;MOV ((", "QeR4220;9"))
    asks(wire, ("ESEARCHDLY", "QoK21 DLY 1;3"), ("ESEARCHMVS", "QeR4430"))
    asks(wire, ("RENUM100;0;10;0", "QoK"), ("RENUM1;0;1;100", "QeR4410"), ("RENUM0;0;0", "QeR4460"))
    asks(wire, ("LISTLTOP", "QoK100 GOTO 130\v110 HLT\v120 DLY 1\v130 END;4;0"))
    asks(wire, ("LISTI-1", "QoK120 DLY 1"), ("LISTI120", "QoK120 DLY 1"), ("LISTI+1", "QoK130 END"))


@pytest.mark.parametrize(
    ("told", "answer"),
    [
        ("M1=3", "M1=+3"),
        ("M1=-0.25", "M1=-0.25"),
        ("M1=1E3", "M1=+1000"),
        ('C1$="a;b"', 'C1$="a;b"'),
        ("P1=(1,2,3,4,5,6)(7,0)", "P1=(+1.00,+2.00,+3.00,+4.00,+5.00,+6.00)(7,0)"),
        ("J1=(1,2,3,4,5,6)", "J1=(+1.00,+2.00,+3.00,+4.00,+5.00,+6.00)"),
        ("M1(2)=5", "M1(2)=+5"),
    ],
)
def test_variables_are_listed_as_they_are_set(wire, told, answer):
    name = told.partition("=")[0]
    asks(wire, ("LOAD=V", "QoK"), (f"VAL={told}", "QoK"), (f"VAL{name}", f"QoK{answer}"))
    kind = answer[0]
    asks(wire, (f"VALS<;{kind}", f"QoK{answer};1;0"), (f"VTYPRD{name}", f"QoK{kind}"))


def test_wrong_values_of_variables_are_refused(wire):
    asks(wire, ("LOAD=V", "QoK"), ("VAL=P1=3", "QeR4390"), ("VAL=M1=(1,2,3)", "QeR4390"))
    asks(
        wire, ("VAL=M1=x", "QeR4220"), ("VAL=M1", "QeR4220"), ("VALM9", "QoK"), ("VTYPRDP9", "QoK")
    )
    asks(wire, ("VAL<;Q", "QeR4460"), ("HOTNONE;M1=1", "QeR4140"), ("VAL=P1=(a)", "QeR4220"))


def test_many_variables_come_in_parts(wire):
    asks(wire, ("LOAD=V", "QoK"))
    for n in range(1, 61):
        asks(wire, (f"VAL=M{n}={n}", "QoK"))
    answer, listed = wire.ask("1;9;VALS<;M"), []
    while True:
        *lines, count, more = answer[3:].split(";")
        listed += [line.lstrip("\v") for line in lines]
        assert len(lines) == int(count)
        if more == "0":
            break
        answer = wire.ask("1;9;VALS+1;M")
    assert listed == [f"M{n}=+{n}" for n in range(1, 61)]
    asks(wire, ("VAL>;M", "QoKM60=+60"), ("VAL-1;M", "QoKM59=+59"))


def test_parameters_are_written_listed_and_undone(wire):
    asks(wire, ("PRM=BZR;0", "QoK"), ("PNRBZR", "QoKBZR;0;1"), ("PRM=BZR;x", "QeR7081"))
    asks(wire, ("PRM=MEXTL;1,2", "QeR7081"), ("PRM=NONE;1", "QeR7081"), ("PNRNONE", "QeR7080"))
    asks(wire, ("PRM=MEXTL;0,0,120.5,0,0,0", "QoK"), ("PMR=0", "QoK0;2;BZR\vMEXTL"))
    asks(wire, ("PARMEXTL", "QoKMEXTL;0, 0, 120.5, 0, 0, 0;6"))
    asks(wire, ("PRMUNDO0;BZR", "QoK"), ("PMR=0", "QoK0;1;MEXTL"), ("PMR=2", "QeR4460"))
    protected = "MEOFFZ;0.00, 0.00, 0.00, 0.00, 0.00, 0.00, 0.00, 0.00;8"
    asks(wire, ("KEYWDpNO", "QoK"), ("PNRMEOFFZ", "QeR7080"), ("PARMEOFFZ", f"QoK{protected}"))
    asks(wire, ("PRM=MEOFFZ;1,0,0,0,0,0,0,0", "QeR7040"), ("KEYWDpMELFA", "QoK"))
    asks(wire, ("PNRMEOFFZ", f"QoK{protected}"), ("PRM=MEOFFZ;1,0,0,0,0,0,0,0", "QoK"))
    asks(wire, ("PRMINIT", "QoK"), ("PMR=0", "QoK0;0;"), ("SLOTSETA;NO;START;1", "QeR4460"))


def test_a_long_list_of_changed_parameters_goes_on(wire):
    names = [f"SLT{n}" for n in range(1, 33)] + [f"MEXTL{n}" for n in range(1, 17)]
    for name in names:
        values = "A,CYC,START,2" if name.startswith("SLT") else "1,0,0,0,0,0"
        asks(wire, (f"PAW={name};{values}", "QoK"))
    more, listed, command = "1", [], "PMR=0"
    while more == "1":
        more, count, found = wire.ask(f"1;1;{command}")[3:].split(";")
        listed += found.split("\v")
        assert len(found.split("\v")) == int(count)
        command = "PMR=1"
    assert listed == names


def test_signals_out_of_range_and_inputs_that_are_real_are_refused(wire):
    asks(wire, ("IN=0;0001", "QeR6630"), ("DIN=6000;0001", "QeR6630"), ("IN40000", "QeR6600"))
    asks(wire, ("DIN5999", "QeR7780"), ("DOUT=6256;0001", "QeR7780"), ("OUT=0;12345", "QeR4460"))
    asks(wire, ("OUT=100;8001", "QoK"), ("OUT100", "QoK8001"), ("OUT115", "QoK0001"))
    asks(wire, ("RSTIO", "QoK"), ("OUT100", "QoK0000"), ("HNDON9", "QeR4460"))
    asks(
        wire, ("INDMY", "QoK"), ("IN=3;0001", "QoK"), ("IN0", "QoK0008"), ("DSTATE", "QoK03520;1;1")
    )
    asks(wire, ("DOUT=6001;002A", "QoK"), ("INSET", "QoK"), ("IN0", "QoK0000"))
    assert wire.ask("1;1;DOUT6000").startswith("QoK0;42;0;")


def test_the_clock_is_set(wire):
    asks(wire, ("TIME=20-01-0203:04:05", "QoK"), ("TIME", "QoK20-01-0203:04:05"))
    asks(wire, ("TIME=20-13-0203:04:05", "QeR6070"), ("TIME=24-02-2812:00:05", "QoK"))


def test_the_history_of_errors_is_listed_narrowed_and_cleared(served, wire):
    controller, _ = served
    asks(wire, ("ERRLOGCLR0", "QoK"), ("ERRORLOGTOP", "QoK"), ("ERRORMES9", "QoKError 0009"))
    for number in (4140, 2600, 6900):
        controller.alarm(number)
    assert wire.ask("1;1;ERRORLOGTOP").split(";")[2:5:2] == ["6900", "3"]
    assert wire.ask("1;1;ERRORLOG+1").split(";")[2] == "2600"
    assert wire.ask("1;1;ERRORLOGEND").split(";")[2] == "4140"
    assert wire.ask("1;1;ERRLOG2=TOP;3").split(";")[2] == "6900"
    asks(wire, ("RSTALRM", "QoK"), ("ERRLOGCLR2", "QoK"))
    assert wire.ask("1;1;ERRORLOGEND").split(";")[2] == "6900"
    assert wire.ask("1;1;ERRORLOG+1") == "QoK"

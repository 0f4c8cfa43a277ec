"""Requests and answers as the manual BFP-A4288-V shows them, over a real socket.

Each row has its source: the section of the manual (`5.2.8` is EMDAT), or a session that was
recorded with a robot. What a controller has to hold for the answer is done before.
"""

import datetime
from functools import partial

import pytest

from assistant.virtual.cr import VirtualCr
from assistant.virtual.cr.state import Cycles
from assistant.virtual.cr.store import CrProgram
from tests.virtual.cr.waiting import wait_for
from tests.virtual.tables import failures
from tests.wire import Wire

MOMENT = datetime.datetime(2004, 2, 9, 18, 49, 52)
RUNNING = "CNTLON"
SHORT = ("LOAD=100", "ECLR", "EDATA10 END", "SAVE")
SERVO = ("CNTLON", "SRVON")
EDITED = ("NEW", "LOAD=1", "ECLR", "EMDAT10 MOV P1\v20 MOV P2\v30 M1=1")
POSITION = "P1=(+400.13,+0.00,+644.62,+180.00,+0.00,+180.00)(7,0)"
HANDS = "900;2;1;902;1;1;904;1;1;906;1;1;-1;-1;-1;-1;-1;-1;-1;-1;-1;-1;-1;-1"
DATA = "Z2UOGQ;Z2VX5I;Z2#46Z;Z2NXW5;004QA5;0XB462;Y91%K5"

# source, commands before, request, answer
PAIRS = [
    ("5.2.2", (), "1;1;CLOSE", "QoK"),
    ("5.2.3", (), "1;1;CNTLON", "QoK"),
    ("5.2.4", (), "1;1;LOAD=100", "QoK"),
    ("5.2.5", ("LOAD=100",), "1;1;SAVE", "QoK"),
    ("5.2.6", (), "1;1;NEW", "QoK"),
    ("5.2.7", ("LOAD=100",), "1;1;EDATA10 MOV P1", "QoK"),
    ("5.2.8", ("LOAD=100",), "1;1;EMDAT10 MOV P1\v20 MOV P2\v30 MOV P3", "QoK"),
    ("5.2.9", ("LOAD=100",), "1;1;EDINS=3;MOV P1", "QoK"),
    ("5.2.10", ("LOAD=100",), "1;9;VAL=M1=3", "QoK"),
    ("5.2.11", EDITED, "1;1;LISTITOP", "QoK10 MOV P1"),
    ("5.2.12", EDITED, "1;1;LISTLTOP", "QoK10 MOV P1\v20 MOV P2\v30 M1=1;3;0"),
    ("5.2.13", (*EDITED, f"EDATA{POSITION}"), "1;1;LISTPTOP", f"QoK{POSITION}"),
    ("5.2.14", EDITED, "1;9;VTYPRDP1", "QoKP"),
    ("5.2.15", (*EDITED, "EMDAT40 END\v50 END"), "1;1;LISTCNT10;50", "QoK0005"),
    ("5.2.19", EDITED, "1;9;ECLR", "QoK"),
    ("5.2.20", EDITED, "1;1;DELETE10;50", "QoK"),
    ("5.2.21", EDITED, "1;9;RENUM100;0;0;0", "QoK"),
    ("5.2.24", (), "1;1;FCHECK100", "QoKN"),
    ("5.2.25", (), "1;1;FPATH=1.MB5", "QoK/robprg/dat/1.MB5"),
    ("5.2.26", (), "1;1;FCOPY1;2", "QoK"),
    ("5.2.27", (), "1;1;FDEL1", "QoK"),
    ("5.2.28", (), "1;1;FRENAME1;2", "QoK"),
    ("5.2.29", (), "1;1;FATTRIB1;+p", "QoK"),
    ("5.2.30", (), "1;1;FINIT", "QoK"),
    ("5.2.31", (), "1;1;FOPEN1.MB5;r", "QoK"),
    ("5.2.32", ("FOPEN1.MB5;r",), "1;1;FCLOSE", "QoK"),
    ("5.2.36", ("LOAD=9", "EDATA3 Mov P1"), "1;9;ESEARCHMov", "QoK3 Mov P1;2"),
    ("5.2.37", (RUNNING,), "1;1;PRGLOAD=100", "QoK"),
    ("5.2.38", (RUNNING,), "1;1;PRGUP", "QoK"),
    ("5.2.39", (RUNNING, "PRGLOAD=100"), "1;1;PRGRD", "QoK100.MB5"),
    ("5.2.40", (RUNNING, "PRGLOAD=100"), "1;1;LINENO=100", "QoK"),
    ("5.2.41", (RUNNING, "PRGLOAD=100", "LINENO=100"), "1;1;LINENO", "QoK100"),
    ("5.2.42", (RUNNING, "PRGLOAD=100"), "1;1;LINERD", "QoK10 MOV P1"),
    (
        "5.2.43",
        (RUNNING, "PRGLOAD=S1"),
        "1;1;LINESRD0;2;2",
        "QoK0;5;10 '### Program ###\v20 '\v30 *SMAIN\v40  MOV P0\v50  DLY 1;0010",
    ),
    ("5.2.44", (RUNNING,), "1;1;SRVON", "QoK"),
    ("5.2.45", (RUNNING,), "1;1;OVRD=50", "QoK50"),
    ("5.2.46", (RUNNING, "OVRD=50"), "1;1;OVRD", "QoK50"),
    ("5.2.49", (), "1;1;STOPON", "QoK"),
    ("5.2.51", (), "1;1;RSTALRM", "QoK"),
    ("5.2.52", (), "1;1;SLOTINIT", "QoK"),
    ("5.2.53", (), "1;1;RSTPRG", "QoK"),
    ("5.2.54", (), "1;1;RSTIO", "QoK"),
    ("5.2.55", (), "1;1;MLOCKON", "QoK"),
    ("5.2.56", (), "1;1;HNDON1", "QoK"),
    ("5.2.61", (), "1;1;LSON", "QoK"),
    ("5.2.62", (), "1;1;AUEON", "QoK"),
    ("5.2.63", ("AUEOFF",), "1;1;ATENA", "QoK1"),
    ("5.2.67", (), "1;1;TOOLSET2", "QoK"),
    ("5.2.68", ("TOOLSET2",), "1;1;TOOLRD", "QoK2"),
    ("5.2.72", (), "1;1; CALIB", "QoKN3F3F"),
    ("5.2.73", ("OUT=0;0002",), "1;1;IOSIGNAL0;0", "QoK00000002"),
    ("5.2.74", (), "1;1;IN0", "QoK0000"),
    ("5.2.75", ("OUT=0;0001",), "1;1;OUT0", "QoK0001"),
    ("5.2.76", (), "1;1;OUT=0;0802", "QoK"),
    ("5.2.77", (), "1;1;DIN6000", "QoK0;0;0;0;0;0;0;0;0;0;0;0;0;0;0;0"),
    ("5.2.78", (), "1;1;DOUT6000", "QoK0;0;0;0;0;0;0;0;0;0;0;0;0;0;0;0"),
    ("5.2.79", (), "1;1;DOUT=6000;0002", "QoK"),
    ("5.2.80", (), "1;1;INDMY", "QoK"),
    ("5.2.81", ("INDMY",), "1;1;INSET", "QoK"),
    ("5.2.82", ("INDMY",), "1;1;IN=0;0802", "QoK"),
    ("5.2.83", ("INDMY",), "1;1;DIN=6000;0001", "QoK"),
    ("5.2.84", (), "1;1;STPSIG", "QoK0;0"),
    ("5.2.85", ("HNDOFF1",), "1;1;HNDSTS", f"QoK{HANDS}"),
    ("5.2.86", (), "1;1;USERAREASTS", "QoK0"),
    ("5.2.90", (), "1;1;TIME=04-02-0917:00:00", "QoK"),
    (
        "5.2.91",
        (),
        "1;1;PTIME",
        "QoK149;51;51;0;0;0;0;0;0;0;0;0;0;0;0;0;0;102;0;2715;11885;1",
    ),
    ("5.2.92", (), "1;1;PTIMEDEL=B", "QoK"),
    ("5.2.93", (), "1;1;CYCLETIME100", "QoK224745;156;154;1454"),
    ("5.2.94", (), "1;1;CYCLECLR100", "QoK"),
    ("5.2.96", (), "1;1;ERRORMES4140", "QoKThe program was not found"),
    ("5.2.99", (), "1;1;ERRLOGCLR1", "QoK"),
    ("5.2.100", ("ERRSUMCLR",), "1;1;ERRSUM5", "QoK0;000000000;;;;;0"),
    ("5.2.103", (), "1;1;SUMDATE0", "QoK04-02-09;18:49:52"),
    ("5.2.104", ("LOAD=3", "VAL=M1=3"), "1;9;VAL<;M", "QoKM1=+3"),
    (
        "5.2.105",
        ("LOAD=3", "VAL=M1=1", "VAL=M2=2", "VAL=M3=3"),
        "1;9;VALS<;M",
        "QoKM1=+1;\vM2=+2;\vM3=+3;3;0",
    ),
    ("5.2.106", ("LOAD=3", "VAL=M_01=3"), "1;1;GVAL<;M", "QoKM_01=+3"),
    (
        "5.2.107",
        ("LOAD=3", "VAL=M_01=1", "VAL=M_02=2", "VAL=M_03=3"),
        "1;1;GVALS<;M",
        "QoKM_01=+1;\vM_02=+2;\vM_03=+3;3;0",
    ),
    ("5.2.108", (), "1;1;HOT100;M1=1", "QoK"),
    ("5.2.109", (), "1;1;OPNUMRD", "QoK3"),
    ("5.2.111", (), "1;1;THMRD", "QoK39.5"),
    ("5.2.112", (), "1;1;ETEMP", "QoK38;39;41;39;36;36;0;0;41;42;44;41;38;37;0;0"),
    ("5.2.119", (), "1;1;SRVVOL", "QoK0;0;0;0;0;0;0;0;0;0;0"),
    ("5.2.120", (), "1;1;SVMONRST=", "QoK"),
    ("5.2.122", (), "1;1;PRMINIT", "QoK"),
    ("5.2.123", (), "1;1;PNRBZR", "QoKBZR;1;1"),
    ("5.2.124", (), "1;1;PRM=BZR;1", "QoK"),
    ("5.2.125", (), "1;1;PARBZR", "QoKBZR;1;1"),
    ("5.2.126", (), "1;1;PAW=BZR;1", "QoK"),
    ("5.2.127", (), "1;1;PAW2=BZR;1", "QoK"),
    ("5.2.128", (), "1;1;PRMUNDO0;BZR", "QoK"),
    (
        "5.2.129",
        (
            "PAW=SVSSFR;1",
            *(f"PAW={name};1,0,0,0,0,0,0,0" for name in ("MEOFFZ", "MEINST", "MEINSZ", "MEINSD")),
            "PAW=MEJAR;-200,200,-120,120,0,160,-200,200,-120,120,-360,360",
        ),
        "1;1;PMR=0",
        "QoK0;6;SVSSFR\vMEOFFZ\vMEINST\vMEINSZ\vMEINSD\vMEJAR",
    ),
    ("5.2.130", (), "1;1;KEYWDpMELFA", "QoK"),
    ("5.2.131", ("2;SLOTSET2;REP;START;1",), "1;2;SLOTRD", "QoK2;REP;START;1"),
    ("5.2.132", (), "1;2;SLOTSET2;REP;START;1", "QoK"),
    ("5.2.133", (), "1;1;ENCBATTM", "QoK51;11885"),
    ("5.2.134", (RUNNING,), "1;1;BREAKON3F", "QoK"),
    ("5.2.135", (), "1;1;BREAKONF3F", "QoK"),
    ("5.2.136", (RUNNING,), "1;1;HOME3;3F", "QoK"),
    ("5.2.137", (RUNNING,), "1;1;AXDATINST", "QoK"),
    ("5.2.138", (RUNNING,), f"1;1;DATINST{DATA}", "QoK"),
    ("5.2.139", (), "1;1;DATRD", f"QoK{DATA}"),
    ("5.2.140", (), "1;1;RSTPWR", "QoK"),
    ("5.2.141", (), "1;1;RPWRCHK=", "QoK1"),
    ("5.2.143", (), "1;1;MFRST=20;1", "QoK"),
    ("5.2.144", (), "1;1;MFFCST=1", "QoK23999;23999;23999;23999;23999;23999;0;0"),
    # programs and motion
    ("5.2.16", (*SERVO, "9;EXEC2=P1=P_CURR"), "1;9;EXECMOV P1", "QoK"),
    ("5.2.17", (*SERVO, "9;EXEC2=P1=P_CURR"), "1;9;EXEC2=MOV P1", "QoK"),
    ("5.2.18", (*SHORT, RUNNING, "PRGLOAD=100"), "1;9;STEP1", "QoK"),
    ("5.2.47", (*SHORT, RUNNING), "1;1;RUN100;1", "QoK"),
    ("5.2.48", (), "1;1;STOP", "QoK"),
    ("5.2.50", (), "1;1;CSTOP", "QoK"),
    ("5.2.57", SERVO, "1;1;ALIGN", "QoK"),
    ("5.2.58", SERVO, "1;1;MOVSP", "QoK"),
    ("5.2.59", SERVO, "1;1;JOG01;00;01;00;00", "QoK"),
    ("5.2.64", (), "1;1;BRKPTSET=100;100;0", "QoK"),
    ("5.2.65", (), "1;1;BRKPTCLR=100;100", "QoK"),
    # an RV-3SB answered these (recorded session; RLNG is that of version V here)
    ("recorded", (), "1;1;PARMEXTL", "QoKMEXTL;0.00, 0.00, 0.00, 0.00, 0.00, 0.00;6"),
    ("recorded", (), "1;1;PARRLNG", "QoKRLNG;2;1"),
]


@pytest.fixture(scope="module")
def controller():
    with VirtualCr(
        "rv-4fr", language="melfa-basic-5", clock=lambda: MOMENT, servo_time=0.0
    ) as controller:
        yield controller


@pytest.fixture(scope="module")
def line(controller):
    with Wire(controller.port) as wire:
        yield wire


@pytest.fixture
def wire(controller, line):
    as_delivered(controller, line)
    return line


def as_delivered(controller, line):
    """Gives a controller three programs and some hours behind it, and nothing else."""
    state = controller.state
    line.ask("1;1;RSTALRM")
    for command in ("CLOSE", "PRMINIT", "RSTPWR", "STOP", "INDMY", "INSET"):
        assert line.ask(f"1;1;{command}") == "QoK", command
    with state.lock:
        for name in list(state.store):
            state.store.delete(name)
        for name, text in PROGRAMS.items():
            program = CrProgram()
            for entry in text.split("|"):
                program.put(entry)
            state.store.save(name, program)
        for variable in ("M_01", "M_02", "M_03"):
            state.machinery.controller.shared.places.pop(variable, None)
        state.board.outputs.values.clear()
        state.hours.update(T=149, S=51, D=102, B=2715)
        state.cycles["100"] = Cycles(224745, 156, 1454)
        state.log.clear_summary()
        state.clock_off = 0.0


PROGRAMS = {
    "1": "10 MOV P1|20 MOV P2",
    "100": "10 MOV P1|100 END",
    "S1": "10 '### Program ###|20 '|30 *SMAIN|40  MOV P0|50  DLY 1",
}


def test_documented_pairs(controller, line):
    assert not failures(
        (f"{source} {request}", partial(answers, controller, line, before, request, answer))
        for source, before, request, answer in PAIRS
    )


def answers(controller, wire, before, request, answer):
    """Asserts that a controller as it is delivered gives an answer, after some commands."""
    as_delivered(controller, wire)
    for command in before:
        command = command if command[:1].isdigit() else f"1;{command}"
        assert wire.ask(f"1;{command}").startswith("QoK"), command
        if command == "1;SRVON":
            wait_for(lambda: controller.state.servo)
    assert wire.ask(request) == answer


def test_there_are_as_many_pairs_as_were_asked_for():
    assert len({(source, request) for source, _, request, _ in PAIRS}) == len(PAIRS) >= 60
    assert all(source for source, _, _, _ in PAIRS)


def test_directories_as_the_manual_shows_them(controller, wire):
    state = controller.state
    stored = state.store
    with state.lock:
        stored.delete("1")
        stored.delete("100")
        stored.delete("S1")
        first = CrProgram({10: "10 '" + "x" * 113, 20: "20 '" + "x" * 114})
        first.changed = datetime.datetime(2004, 2, 5, 19, 31, 28)
        stored.save("1", first)
        for number in range(2, 35):
            stored.save(str(number), CrProgram())
        stored.capacity = 105984 + 235
        state.cycles["1"] = Cycles(115850, 60, 1903)
    # 5.2.22
    listed = "QoK1.MB5;235;04-02-0519:31:28;34;105984;12;;2;0;115850;60;60;1903"
    assert wire.ask("1;1;PDIRTOP") == listed
    assert wire.ask("1;1;PDIR1") == "QoK1.MB5;235;04-02-0519:31:28;12;;2;0;115850;60;60;1903"
    with state.lock:
        for number in range(35, 47):
            stored.save(str(number), CrProgram())
    # 5.2.23
    assert wire.ask("1;1;FDIRTOP") == "QoK1.MB5;235;04-02-0519:31:28;46;105984;12"
    assert wire.ask("1;1;FDIR1") == "QoK1.MB5;235;04-02-0519:31:28;12"
    assert wire.ask("1;1;FDIR<*.*") == "QoK1.MB5;235;04-02-0519:31:28;46;105984;12"
    # 5.2.35
    with state.lock:
        stored.capacity = 125696
        stored.save("1", CrProgram({10: "10 '" + "x" * 15612}))
    assert wire.ask("1;1;EFREE") == "QoK125696;15616;12"


def test_errors_as_the_manual_shows_them(controller, wire):
    state = controller.state
    with state.lock:
        state.log.entries.clear()
        for _ in range(4):
            state.alert(60, 1)
        state.alert(4140, 2, "S1")
    # 5.2.95, 5.2.97, 5.2.98; the letter is lower case as an error holds
    entry = "04-02-09;18:49:52;4140;The program was not found;2;S1;0;414000000"
    assert wire.ask("1;1;ERROR") == "Qok4140;2"
    assert wire.ask("1;1;ERRORLOGTOP") == f"Qok{entry}"
    assert wire.ask("1;1;ERRLOG2=TOP;0;414000000") == f"Qok{entry}"
    assert wire.ask("1;1;RSTALRM") == "QoK"
    # 5.2.100, but for the cure and the blanks in front of the texts
    summary = "006000000;H;EMG signal is input. (O.Panel);EMG signal is input. (O.Panel);;4"
    assert wire.ask("1;1;ERRSUM1") == f"QoK2;{summary}"
    assert wire.ask("1;1;ERRSUM2=1") == f"QoK2;{summary};04-02-09;18:49:52"
    assert wire.ask("1;1;ERRSUM2=5") == "QoK2;000000000;;;;;0;;"

"""The virtual CR controller over real sockets: framing, answers, error numbers, sessions."""

import datetime
import threading

import pytest

from assistant.virtual.cr import VirtualCr
from assistant.virtual.cr.controller import MOST_CONNECTIONS
from tests.wire import Wire

POSITION = "P1=(+250.00,+0.00,+450.00,+0.00,+180.00,+0.00)(6,0)"


@pytest.fixture
def controller():
    noon = datetime.datetime(2024, 2, 28, 12, 0, 5)
    with VirtualCr("rv-2aj", clock=lambda: noon) as controller:
        yield controller


@pytest.fixture
def wire(controller):
    with Wire(controller.port) as wire:
        yield wire


def load(wire, name, *lines):
    """A program in the controller; every step must be accepted."""
    commands = ["NEW", f"LOAD={name}", "ECLR", *(f"EDATA{line}" for line in lines), "SAVE"]
    for command in commands:
        assert wire.ask(f"1;1;{command}") == "QoK", command


def test_every_end_of_a_command_is_understood(controller):
    for end in (b"\r", b"\r\n", b"\n", b""):
        with Wire(controller.port) as wire:
            for _ in range(3):
                wire.send(b"1;1;DSTATE" + end)
                assert wire.answer() == "QoK03120;1;1", end


@pytest.mark.parametrize("first", [True, False])
def test_a_command_may_come_in_pieces(first):
    with VirtualCr(quiet=5.0) as controller, Wire(controller.port) as wire:
        if not first:
            assert wire.ask("1;1;TIME").startswith("QoK")
        for byte in b"1;1;OVRD\r":
            wire.send(bytes([byte]))
        assert wire.answer() == "QoK100"


def test_several_commands_in_one_segment_get_an_answer_each(wire):
    wire.send(b"1;1;OVRD\r1;1;ERROR\r\n1;1;PRGRD\r")
    assert [wire.answer(), wire.answer(), wire.answer()] == ["QoK100", "QoK", "QoK"]


@pytest.mark.parametrize(("terminator", "sent"), [(b"\r\n", b"QoK\r\n"), (b"", b"QoK")])
def test_answers_end_as_set(terminator, sent):
    with VirtualCr(terminator=terminator) as controller, Wire(controller.port) as wire:
        wire.send(b"1;1;NEW\r")
        assert wire.socket.recv(100) == sent


def test_open_says_what_the_controller_is(wire):
    assert wire.ask("1;1;OPEN=USERTOOL") == (
        "QoK1F;37;6,0;3,5,A,1E,32,46,64;MB4;PRM;RV-2AJ;CR1;MELFA;24-02-28;Ver.VIRTUAL;ENG;"
        "VIRTUAL CONTROLLER;1;1;8;"
    )


def test_a_scara_has_four_joints_and_turns_about_z_only():
    with VirtualCr("rh-6frh5520") as controller, Wire(controller.port) as wire:
        controller.state.joints = (0.0, -90.0, 333.0, 10.0)
        assert wire.ask("1;1;OPEN=USERTOOL").startswith("QoK27;0F;4,0;")
        joints = wire.ask("1;1;JPOSF")
        assert joints.startswith("QoKJ1;0.00;J2;-90.00;J3;333.00;J4;10.00;J5;****;J6;****;;")
        assert ";C;-80.00;" in wire.ask("1;1;PPOSF")


def test_positions_of_the_five_axis_arm(controller, wire):
    controller.state.joints = (0.0, 21.19, 72.78, 86.03, 0.0)
    assert (
        wire.ask("1;1;JPOSF")
        == "QoKJ1;0.00;J2;21.19;J3;72.78;J4;****;J5;86.03;J6;0.00;;****,****;100;0.00;00000000"
    )
    fields = wire.ask("1;1;PPOSF").removeprefix("QoK").split(";")
    assert fields[:10:2] == ["X", "Y", "Z", "A", "B"]
    shown = dict(zip(fields[:10:2], map(float, fields[1:10:2]), strict=True))
    # What an RV-2AJ showed for these joints: 250, 0, 450, A 0, B 180, flags 6,0.
    assert shown["X"] == pytest.approx(250, abs=0.05)
    assert shown["Z"] == pytest.approx(450, abs=0.05)
    assert (shown["Y"], shown["A"], shown["B"]) == (0, 0, 180)
    assert fields[10:] == ["", "6,0", "100", "0.00", "00000000"]


def test_state_has_its_nineteen_fields(wire):
    load(wire, "SEAM", "10 END")
    wire.ask("1;1;CNTLON")
    assert wire.ask("1;1;PRGLOAD=SEAM") == "QoK"
    assert wire.ask("1;1;PRGRD") == "QoKSEAM.MB4"
    fields = wire.ask("1;1;STATE").removeprefix("QoK").split(";")
    assert len(fields) == 19
    assert fields[:5] == ["SEAM.MB4", "10", "100", "0", "83120"]


def test_programs_are_edited_saved_and_listed(controller, wire):
    load(wire, "SEAM", "20 MOV P1", "10 OVRD 50", "30 END", POSITION, "20 MVS P1")
    assert wire.ask("1;1;LOAD=SEAM") == "QoK"
    assert wire.ask("1;1;LISTLTOP") == "QoK10 OVRD 50\v20 MVS P1\v30 END;3;0"
    assert wire.ask("1;1;LISTPTOP") == f"QoK{POSITION}"
    assert wire.ask("1;1;LISTP+1") == "QoK"
    assert wire.ask("1;1;LISTCNT10;20") == "QoK0002"
    assert wire.ask("1;1;LISTITOP") == "QoK10 OVRD 50"
    assert wire.ask("1;1;LISTI+1") == "QoK20 MVS P1"
    assert wire.ask("1;1;LISTI30") == "QoK30 END"
    assert wire.ask("1;1;EDATA20") == "QoK"
    assert wire.ask("1;1;DELETE30;30") == "QoK"
    assert wire.ask("1;1;LISTLTOP") == "QoK10 OVRD 50;1;0"
    assert wire.ask("1;1;NEW") == "QoK"
    assert controller.text("SEAM") == f"10 OVRD 50\r\n20 MVS P1\r\n30 END\r\n{POSITION}\r\n"
    assert wire.ask("1;1;PDIRTOP").split(";")[:4] == [
        "QoKSEAM.MB4",
        str(len("10 OVRD 5020 MVS P130 END" + POSITION)),
        "24-02-2812:00:05",
        "1",
    ]
    assert wire.ask("1;1;PDIR2") == "QoK"
    assert wire.ask("1;1;FDELSEAM") == "QoK"
    assert wire.ask("1;1;FDELSEAM") == "QeR7010"


def test_long_listings_continue(wire):
    lines = [f"{n} DLY {n / 100:.2f}" for n in range(10, 2010, 10)]
    load(wire, "LONG", *lines)
    wire.ask("1;1;LOAD=LONG")
    listed, command = [], "LISTLTOP"
    while True:
        text, count, more = wire.ask(f"1;1;{command}").removeprefix("QoK").rsplit(";", 2)
        assert len(text) <= 230 and len(text.split("\v")) == int(count)
        listed += text.split("\v")
        if more == "0":
            break
        command = "LISTL+1"
    assert listed == lines


def test_single_answers(wire):
    expected = [
        ("1;1;FROB", "QeR6010"),
        ("no head at all", "QeR6010"),
        ("9;1;STATE", "QeR5430"),
        ("1;44;STATE", "QeR5420"),
        ("1;1;SAVEX", "QeR6010"),
        ("1;1;EDATA10 END", "QeR4820"),
        ("1;1;LISTLTOP", "QeR4820"),
        ("1;1;LOAD=lower", "QeR4130"),
        ("1;1;LOAD=", "QeR4130"),
        ("1;1;LOAD=../../X", "QeR4130"),
        ("1;1;LOAD=MUCHTOOLONGNAME", "QeR4120"),
        ("1;1;OVRD=50", "QeR6020"),
        ("1;1;PRGLOAD=SEAM", "QeR6020"),
        ("1;1;PARNONSENSE", "QeR7080"),
        ("1;1;PARTASKMAX", "QoKTASKMAX;8;1"),
        ("1;1;PNRMEXTL", "QoKMEXTL;0.00, 0.00, 0.00, 0.00, 0.00, 0.00;6"),
        ("1;1;TIME", "QoK24-02-2812:00:05"),
        ("1;1;EFREE", "QoK220160;0;0"),
        (";;OVRD", "QoK100"),
    ]
    assert [(command, wire.ask(command)) for command, _ in expected] == expected


def test_nothing_moves_without_right_program_and_servos(controller, wire):
    expected = [
        ("RUNSEAM;1", "QeR4140"),
        ("RUN", "QeR5100"),
        ("STEP1", "QeR5100"),
        ("EXECMOV P1", "QeR2000"),
        ("EXEC2=MVS P1", "QeR2000"),
        ("JOG00;00;00;01;00", "QeR2000"),
        ("ALIGN", "QeR2000"),
        ("MOVSP", "QeR2000"),
    ]
    before = controller.state.joints
    for command, _ in expected:
        assert wire.ask(f"1;1;{command}") == "QeR6020", command
        assert controller.state.joints == before, command
    wire.ask("1;1;CNTLON")
    for command, answer in expected:
        assert wire.ask(f"1;1;{command}") == answer, command
        assert controller.state.joints == before, command


def test_operation_right_is_held_by_one_line(controller, wire):
    with Wire(controller.port) as other:
        assert wire.ask("1;1;CNTLON") == "QoK"
        assert other.ask("1;1;CNTLON") == "QeR6020"
        assert other.ask("1;1;OVRD=10") == "QeR6020"
        assert wire.ask("1;1;OVRD=0") == "QeR4460"
        assert wire.ask("1;1;OVRD=25") == "QoK25"
        assert wire.ask("1;1;PRGLOAD=NONE") == "QeR4140"
        assert wire.ask("1;1;CNTLOFF") == "QoK"
        assert other.ask("1;1;CNTLON") == "QoK"


def test_answers_in_an_error_state_have_a_lower_case_letter(controller, wire):
    controller.alarm(4140, 2)
    assert wire.ask("1;1;ERROR") == "Qok4140;2"
    assert wire.ask("1;1;FROB") == "Qer6010"
    assert wire.ask("1;1;DSTATE") == "Qok03124140;1;1"
    assert wire.ask("1;1;RSTALRM") == "QoK"
    assert wire.ask("1;1;ERROR") == "QoK"


def test_a_wrong_line_is_told_with_its_place(wire):
    wire.ask("1;1;LOAD=BAD")
    number, column = wire.ask("1;1;EDATA10 MOV P1 P2 P3").removeprefix("QeR").split(";")
    assert number == "4220" and 3 < int(column) <= len("10 MOV P1 P2 P3")
    answer = wire.ask("1;9;EMDAT10 MOV P1\v20 MOV ((\v30 END")
    number, line, column = answer.removeprefix("QeR").split(";")
    assert (number, line) == ("4220", "2") and int(column) > 3
    # What came before the wrong line is in the edit, what came after is not.
    assert wire.ask("1;1;LISTLTOP") == "QoK10 MOV P1;1;0"


def test_rules_of_single_lines(wire):
    expected = [
        ("40000 END", "QeR4420"),
        ("10 '" + "x" * 130, "QeR4210"),
        ("10 MOV PLONGNAMES1", "QeR4300"),
        ("10 BREAK", "QeR4220"),  # not in version IV
        ("10 GOTO *LATER", "QoK"),  # looked for when the program runs
        ("20 FOR M1=1 TO 3", "QoK"),
    ]
    wire.ask("1;1;LOAD=BAD")
    assert [(one, wire.ask(f"1;1;EDATA{one}").split(";")[0]) for one, _ in expected] == expected


def test_a_message_may_have_255_bytes(wire):
    wire.ask("1;1;LOAD=LONG")
    exact = "1;1;EDATA10 '" + "x" * 100
    assert wire.ask(exact) == "QoK"
    payload = "20 '" + "y" * 117 + "\v" + "30 '" + "z" * 120
    assert len("1;9;EMDAT" + payload) == 255
    assert wire.ask("1;9;EMDAT" + payload) == "QoK"
    assert wire.ask("1;9;EMDAT" + payload + "z") == "QeR6080"


def test_garbage_breaks_nothing(controller, wire):
    wire.send(bytes(range(256)) * 20 + b"\r")
    answers = [wire.answer()]
    while not answers[-1].startswith("QoK"):
        wire.send(b"1;1;OVRD\r")
        answers.append(wire.answer())
    assert all(a.startswith(("QeR", "QoK")) for a in answers)
    with Wire(controller.port) as silent:
        silent.send(b"\xff" * 1_000_000)
        assert wire.ask("1;1;OVRD") == "QoK100"


def test_a_client_that_vanishes_leaves_nothing_behind(controller, wire):
    load(wire, "SEAM", "10 END")
    for _ in range(3):
        with Wire(controller.port) as lost:
            assert lost.ask("1;1;CNTLON") == "QoK"
            assert lost.ask("1;1;LOAD=SEAM") == "QoK"
            assert lost.ask("1;1;ECLR") == "QoK"
            assert wire.ask("1;1;LOAD=SEAM") == "QeR4170"
            lost.send(b"1;1;EDATA10 MO")
        deadline = threading.Event()
        while wire.ask("1;1;LOAD=SEAM") != "QoK":
            deadline.wait(0.01)
        assert wire.ask("1;1;LISTLTOP") == "QoK10 END;1;0"
        assert wire.ask("1;1;NEW") == "QoK"


def test_a_client_that_is_silent_loses_its_edit_and_its_right_to_who_asks(
    controller, wire, monkeypatch
):
    """As one whose cable was cut: its connection is there for ever."""
    load(wire, "SEAM", "10 END")
    with Wire(controller.port) as lost:
        for command in ("1;1;CNTLON", "1;1;LOAD=SEAM", "1;1;EDATA20 HLT"):
            assert lost.ask(command) == "QoK"
        refused = {"1;1;LOAD=SEAM": "4170", "1;1;FDELSEAM": "4170", "1;1;CNTLON": "6020"}
        for command, number in refused.items():
            assert wire.ask(command) == f"QeR{number}"
        monkeypatch.setattr("assistant.virtual.cr.state.SILENT", -1.0)
        for command in ("1;1;LOAD=SEAM", "1;1;NEW", "1;1;CNTLON", "1;1;FDELSEAM"):
            assert wire.ask(command) == "QoK"
        monkeypatch.undo()
        assert lost.ask("1;1;EDATA30 HLT") == "QeR4820"


def test_clients_at_once_do_not_mix(controller):
    def write(number):
        with Wire(controller.port) as wire:
            load(wire, f"PROG{number}", *(f"{n} DLY {number}.{n}" for n in range(10, 300, 10)))

    threads = [threading.Thread(target=write, args=(n,)) for n in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert controller.names() == tuple(f"PROG{n}" for n in range(6))
    for number in range(6):
        text = controller.text(f"PROG{number}")
        assert text == "".join(f"{n} DLY {number}.{n}\r\n" for n in range(10, 300, 10))


def test_more_clients_than_lines_are_turned_away(controller):
    wires = [Wire(controller.port) for _ in range(MOST_CONNECTIONS)]
    try:
        assert all(wire.ask("1;1;OVRD") == "QoK100" for wire in wires)
        with Wire(controller.port) as extra:
            assert extra.closed_by_peer()
    finally:
        for wire in wires:
            wire.socket.close()


def test_a_full_memory_refuses_and_keeps_the_old_program():
    with VirtualCr(capacity=60) as controller, Wire(controller.port) as wire:
        load(wire, "SEAM", "10 END")
        wire.ask("1;1;LOAD=SEAM")
        for n in range(20, 100, 10):
            assert wire.ask(f"1;1;EDATA{n} DLY 1.5") == "QoK"
        assert wire.ask("1;1;SAVE") == "QeR4110"
        assert controller.text("SEAM") == "10 END\r\n"


def test_programs_in_a_folder_outlive_the_controller(tmp_path):
    with VirtualCr(folder=tmp_path / "cr") as controller, Wire(controller.port) as wire:
        load(wire, "SEAM", "10 END", POSITION)
    with VirtualCr(folder=tmp_path / "cr") as controller, Wire(controller.port) as wire:
        assert controller.names() == ("SEAM",)
        wire.ask("1;1;LOAD=SEAM")
        assert wire.ask("1;1;LISTPTOP") == f"QoK{POSITION}"
        wire.ask("1;1;NEW")
        assert wire.ask("1;1;FDELSEAM.MB4") == "QoK"
    assert list((tmp_path / "cr").iterdir()) == []


def test_stopping_hangs_up_and_frees_the_port():
    controller = VirtualCr()
    controller.start()
    port = controller.port
    with Wire(port) as wire:
        assert wire.ask("1;1;OVRD") == "QoK100"
        controller.stop()
        assert wire.closed_by_peer()
    with pytest.raises(ConnectionRefusedError):
        Wire(port)
    with VirtualCr(port=port) as again:
        assert again.port == port

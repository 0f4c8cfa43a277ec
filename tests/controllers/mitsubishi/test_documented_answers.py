"""What real controllers and the manual's examples answer, and what the client makes of it."""

import json
import socketserver
import threading
from contextlib import contextmanager, suppress

import pytest

from assistant.base.diagnostics import Refused
from assistant.base.rotations import angle_between, from_euler
from assistant.cli import main
from assistant.controllers import connect
from assistant.controllers.rules import Lost

OPEN = "3F;3F;7,0;3,5,A,1E,32,46,64;MB4;PRM;RV-3SB;CRn-5xx;MELFA;05-07-14;Ver.K4a;ENG;C;1;1;2;"
"""Of an RV-3SB (client of FunMetJoel/MITSUBISHI-robot-arm-python-controller), with two slots."""

REST = "****,****;50;0.00;00000000"


@contextmanager
def answering(answers, end="\r"):
    """A client of a controller that answers these commands so, and all others with QoK."""

    class Handler(socketserver.StreamRequestHandler):
        def handle(self):
            with suppress(OSError):
                data = b""
                while piece := self.request.recv(1000):
                    *whole, data = (data + piece).split(b"\r")
                    for command in whole:
                        name = command.decode("latin-1").split(";", 2)[2]
                        told = {"OPEN=USERTOOL": f"QoK{OPEN}", **answers}.get(name, "QoK")
                        self.request.sendall((told + end).encode("latin-1"))

    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Handler) as server:
        server.daemon_threads = True
        thread = threading.Thread(target=server.serve_forever, args=(0.02,))
        thread.start()
        try:
            with connect(f"melfa://127.0.0.1:{server.server_address[1]}", timeout=5) as client:
                yield client
        finally:
            server.shutdown()
            thread.join()


def test_the_pose_of_an_rv_3sb():
    answers = {
        "JPOSF": f"QoKJ1;10.00;J2;20.00;J3;90.00;J4;0.00;J5;5.00;J6;0.00;;{REST}",
        "PPOSF": "QoKX;176.01;Y;33.14;Z;541.62;A;77.92;B;-25.59;C;106.80;;6,15728640;100;0.00;"
        "00000000",
    }
    with answering(answers) as client:
        place = client.position()
    assert place.position == (176.01, 33.14, 541.62)
    assert place.text == "(176.01,33.14,541.62,77.92,-25.59,106.80)(6,15728640)"
    assert angle_between([place.quaternion], from_euler([[106.80, -25.59, 77.92]]))[0] < 1e-3
    assert place.joints == (10.0, 20.0, 90.0, 0.0, 5.0, 0.0)


def test_the_pose_of_an_rv_2aj():
    answers = {
        "JPOSF": f"QoKJ1;0.00;J2;21.19;J3;72.78;J4;****;J5;86.03;J6;0.00;;{REST}",
        "PPOSF": "QoKX;250.00;Y;0.00;Z;450.00;A;0.00;B;180.00;;6,0;50;0.00;00000000",
    }
    with answering(answers) as client:
        place = client.position()
    assert place.joints == (0.0, 21.19, 72.78, None, 86.03, 0.0)
    assert place.text == "(250.00,0.00,450.00,0.00,180.00,0.00)(6,0)"
    assert place.quaternion == pytest.approx((0, 0, 1, 0))


def test_an_axis_that_is_left_out_moves_no_other_into_its_place():
    answers = {
        "JPOSF": f"QoKJ1;0.00;J2;21.19;J3;72.78;J5;86.03;J6;0.00;;{REST}",
        "PPOSF": "QoKX;250.00;Y;0.00;Z;450.00;A;0.00;B;180.00;;6,0;50;0.00;00000000",
    }
    with answering(answers) as client:
        assert client.position().joints == (0.0, 21.19, 72.78, None, 86.03, 0.0)


def test_a_pose_with_an_additional_axis():
    pose = "X;290.62;Y;-0.09;Z;11.26;A;-179.94;B;-0.26;C;179.93;L1;0.00;;6,0;100;0.00;00000000"
    joints = "J1;0.00;J2;0.00;J3;0.00;J4;0.00;J5;0.00;J6;0.00;J7;0.00;;****,****;100;0.00;00000000"
    with answering({"PPOSF": f"QoK{pose}", "JPOSF": f"QoK{joints}"}) as client:
        assert client.position().text == ("(290.62,-0.09,11.26,-179.94,-0.26,179.93,0.00)(6,0)")


def test_the_state_of_the_manual():
    """In an error state, so that the third letter is a small one."""
    answers = {
        "STATE": "Qok2.MB5;100;100;5;A1124220;1;1;;;;;;;;;REP;START;1;0",
        "ERROR": "Qok4220;2",
    }
    with answering(answers) as client:
        state = client.state()
    assert (state.motors, state.running, state.emergency, state.override) == (
        *(True, False, False, 100),
    )
    assert state.tasks[0].program == "2" and state.tasks[0].line == 100
    assert [fault.number for fault in state.faults] == [4220]


def test_the_bits_of_a_state():
    answers = {"STATE": "QoK1.MB4;10;30;2;E9050;1;1;;;;;;;;;REP;START;1;1"}
    with answering(answers) as client:
        state = client.state()
    # E9 = operation right of some line, servo on, running, teach, repeat; 05 = wait, emergency
    assert (state.mode, state.motors, state.running, state.emergency) == ("manual", *[True] * 3)
    assert not state.right, "which is that of this session"


def test_the_directory_of_an_rv_3sb():
    answers = {
        "PDIRTOP": "QoK1.MB4;4767;24-02-2821:05:14;2;220160;12;;9;82;135256;6848;9661;14",
        "PDIR1": "QoK2.MB4;100;24-02-2821:05:15;12;;9;82;135256;6848;9661;14",
    }
    with answering(answers) as client:
        one, two = client.entries()
    assert (one.name, one.size, one.attributes) == ("1", 4767, "12")
    assert (two.name, two.size, two.attributes) == ("2", 100, "12")
    assert f"{one.changed:%Y-%m-%d %H:%M:%S}" == "2024-02-28 21:05:14"


def test_files_that_are_no_programs_are_told_and_not_in_the_backup(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    answers = {
        "PDIRTOP": "QoKUSERS.DAT;4767;24-02-2821:05:14;2;220160;12;;9;82;135256;6848;9661;14",
        "PDIR1": "QoK2.MB7;100;24-02-2821:05:15;12;;9;82;135256;6848;9661;14",
        "PMR=0": "QoK0;0;",
    }
    with answering(answers) as client, pytest.raises(SystemExit) as ended:
        main(["backup", str(client.address), "kept", "--format", "json"])
    answer = json.loads(capsys.readouterr().out)
    assert ended.value.code == 0 and "not-kept.txt" in answer["files"], answer
    (finding,) = answer["findings"]
    assert finding["code"] == "CN406" and "2.MB7, USERS.DAT" in finding["message"]
    assert (tmp_path / "kept" / "not-kept.txt").read_text() == "2.MB7\nUSERS.DAT\n"


def test_parameters_of_an_rv_3sb():
    answers = {
        "PNRMEXTL": "QoKMEXTL;0.00, 0.00, 0.00, 0.00, 0.00, 0.00;6",
        "PNRRLNG": "QoKRLNG;1;1",
        "PMR=0": "QoK1;2;MEXTL\vRLNG",
        "PMR=1": "QoK0;1;RLNG",
    }
    with answering(answers) as client:
        assert client.parameters() == {"MEXTL": "0.00, 0.00, 0.00, 0.00, 0.00, 0.00", "RLNG": "1"}


def test_variables_of_the_manual():
    answers = {
        "VALM1;M": "QoKM1=+3",
        "GVALS<;M": "QoKM_01=+1;\vM_02=+2;;2;0",
    }
    with answering(answers) as client:
        assert client.variable("M1") == "+3"


def test_the_error_history():
    entry = "24-02-28;21:05:{:02};{};text of the controller;{};1;30;414000000"
    answers = {
        "ERRORLOGTOP": f"QoK{entry.format(1, '4140', '2')}",
        "ERRORLOG+1": "QoK",
    }
    with answering(answers) as client:
        (fault,) = client.log()
    assert (fault.number, fault.level) == (4140, "error")
    assert fault.text == "text of the controller (`1`, line 30)"


@pytest.mark.parametrize(
    ("command", "answer", "act"),
    [
        ("STATE", "QoK", lambda c: c.state()),
        ("STATE", "QoK1;2;3;4;XYZ", lambda c: c.state()),
        ("JPOSF", "QoKX;1.00;;", lambda c: c.position()),
        ("JPOSF", "QoKJ1;one;;0", lambda c: c.position()),
        ("JPOSF", "QoKJ1;1.00;J1;2.00;;0", lambda c: c.position()),
        ("JPOSF", f"QoKJ1;{'9' * 400};;0", lambda c: c.position()),
        ("PPOSF", "QoKJ1;1.00;;0", lambda c: c.position()),
        ("PPOSF", "QoKX;****;Y;0.00;Z;1.00;;6,0", lambda c: c.position()),
        ("IN5", "QoK12", lambda c: c.inputs(["5"])),
        ("IN5", "QoKGGGG", lambda c: c.inputs(["5"])),
        ("PNRMEXTL", "QoKMEXBS;0;1", lambda c: c.parameters(["MEXTL"])),
        ("PMR=0", "QoKwhatever", lambda c: c.parameters()),
        ("VALM1;M", "QoKM2=+1", lambda c: c.variable("M1")),
        ("ERRORLOGTOP", "QoKx;y", lambda c: c.log()),
        ("ERROR", "QoKx", lambda c: c.state()),
        ("CNTLON", "QoKsurprise", lambda c: c.set_override(10)),
    ],
)
def test_answers_that_make_no_sense_end_the_session(command, answer, act):
    sane = {
        "STATE": "QoK;0;100;0;0310;1;1;;;;;;;;;REP;START;1;1",
        "JPOSF": "QoKJ1;0.00;J2;0.00;J3;0.00;;****,****;50;0.00;00000000",
        "DSTATE": "QoK03120;1;1",
    }
    with answering(sane | {command: answer}) as client:
        with pytest.raises(Lost) as refused:
            act(client)
        assert refused.value.findings[0].code == "CN302"
        with pytest.raises(Refused):
            client.state()


def test_a_list_that_has_no_end():
    answers = {"ERRORLOGTOP": (e := "QoK24-02-28;21:05:01;4140;text;2;1;30;0"), "ERRORLOG+1": e}
    with answering(answers) as client:
        assert len(client.log(10)) == 10

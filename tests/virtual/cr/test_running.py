"""Programs and single commands that run in the virtual CR controller, over a real socket."""

import threading
import time

import pytest

from assistant.virtual.cr import VirtualCr
from tests.virtual.cr.test_link import load
from tests.virtual.cr.waiting import wait_for
from tests.wire import Wire

NEAR = "P1=(+250.00,+0.00,+450.00,+0.00,+180.00,+0.00)(6,0)"
AWAY = "P2=(+250.00,+80.00,+400.00,+0.00,+180.00,+0.00)(6,0)"
PACE = 20.0


@pytest.fixture
def controller():
    with VirtualCr("rv-2aj", pace=PACE, servo_time=0.0) as controller:
        yield controller


@pytest.fixture
def wire(controller):
    """A line that has the operation right, with the servos on."""
    with Wire(controller.port) as wire:
        for command in ("CNTLON", "SRVON"):
            assert wire.ask(f"1;1;{command}") == "QoK"
        wait_for(lambda: bits(wire)[0] & 0x20)
        yield wire


@pytest.fixture(scope="module")
def slow():
    """A controller whose time passes as it does."""
    with VirtualCr("rv-2aj", servo_time=0.0) as controller, Wire(controller.port) as wire:
        for command in ("CNTLON", "SRVON"):
            assert wire.ask(f"1;1;{command}") == "QoK"
        yield controller, wire


def bits(wire):
    """Run bits, stop bits and the error number of DSTATE."""
    answer = wire.ask("1;1;DSTATE")[3:]
    return int(answer[:2], 16), int(answer[2:4], 16), int(answer[4:].split(";")[0])


def runs(wire):
    return bool(bits(wire)[0] & 0x40)


def state(wire, slot=1):
    return wire.ask(f"1;{slot};STATE")[3:].split(";")


def place(wire, command="PPOSF"):
    """Numbers by the names of their axes."""
    fields = wire.ask(f"1;1;{command}")[3:].split(";;")[0].split(";")
    return {n: float(v) for n, v in zip(fields[::2], fields[1::2], strict=True) if v != "****"}


def test_a_program_runs_and_the_arm_is_on_its_way_meanwhile(slow):
    _, wire = slow
    load(wire, "SEAM", "10 MOV P1", "20 SPD 80", "30 MVS P2", "40 END", NEAR, AWAY)
    assert wire.ask("1;1;RUNSEAM;1") == "QoK"
    seen = set()
    while runs(wire):
        seen.add(round(place(wire)["Y"]))
        time.sleep(0.01)
    assert {round(v) for v in place(wire).values()} == {250, 80, 400, 0, 180}
    assert len(seen) > 2, "the arm was seen on its way"
    assert bits(wire)[1:] == (0x12, 0)
    assert state(wire)[0] == "SEAM.MB4"
    operation, tact, average, cycles = wire.ask("1;1;CYCLETIMESEAM")[3:].split(";")
    assert cycles == "1" and operation == tact == average and int(tact) > 100


def test_a_program_is_stopped_on_its_way_and_goes_on(stopped):
    run, stop, _ = bits(stopped)
    assert (run & 0x60, stop) == (0x20, 0x06)
    there = place(stopped)
    time.sleep(0.02)
    assert place(stopped) == there
    assert stopped.ask("1;1;PRGLOAD=SEAM") == "QeR5120"
    assert stopped.ask("1;1;RUN") == "QoK"
    wait_for(lambda: not runs(stopped))
    assert place(stopped)["Y"] == pytest.approx(80.0, abs=0.01)


def test_a_stopped_program_is_reset(wire):
    load(wire, "SEAM", "10 M1=1", "20 DLY 100", "30 END")
    wire.ask("1;1;RUNSEAM;1")
    wait_for(lambda: state(wire)[1] == "20")
    assert wire.ask("1;1;SLOTINIT") == "QeR5640"
    wire.ask("1;1;STOP")
    wait_for(lambda: not runs(wire))
    assert wire.ask("1;1;RSTPRG") == "QoK"
    assert bits(wire)[1] == 0x12 and state(wire)[1] == "10"


def test_a_repeating_program_ends_with_its_cycle(wire):
    load(wire, "LOOP", "10 M1=M1+1", "20 DLY 0.2", "30 END")
    assert wire.ask("1;1;HOTLOOP;M1=0") == "QoK"
    assert wire.ask("1;1;RUNLOOP;0") == "QoK"
    wait_for(lambda: float(wire.ask("1;1;VALM1;M")[len("QoKM1=") :]) >= 2)
    assert bits(wire)[0] & 0x43 == 0x43
    assert wire.ask("1;1;CSTOP") == "QoK"
    wait_for(lambda: not runs(wire) or not bits(wire)[0] & 0x02)
    wait_for(lambda: not runs(wire))
    assert state(wire)[15] == "REP"


def test_variables_of_a_program_that_runs_are_seen_and_set(wire):
    load(wire, "COUNT", "10 M1=1", "20 WAIT M2=5", '30 C1$="done"', "40 P3=P1*2", "50 END", NEAR)
    assert wire.ask("1;1;HOTCOUNT;M2=0") == "QoK"
    wire.ask("1;1;RUNCOUNT;1")
    wait_for(lambda: state(wire)[1] == "20")
    assert wire.ask("1;1;VALM1;M") == "QoKM1=+1"
    assert wire.ask("1;1;HOTCOUNT;M2=5") == "QoK"
    wait_for(lambda: not runs(wire))
    assert wire.ask("1;1;VAL<;C") == 'QoKC1$="done"'
    assert wire.ask("1;1;VALS<;M") == "QoKM1=+1;\vM2=+5;2;0"
    # and so does an edit that begins now
    wire.ask("1;1;LOAD=COUNT")
    assert wire.ask("1;9;LISTPP3").startswith("QoKP3=(+500.00,")


def test_inputs_and_outputs_are_those_that_programs_see(wire):
    load(wire, "IO", "10 M_OUT(3)=1", "20 WAIT M_IN(5)=1", "30 HOPEN 1", "40 HCLOSE 1", "50 END")
    wire.ask("1;1;RUNIO;1")
    wait_for(lambda: wire.ask("1;1;OUT0") == "QoK0008")
    assert wire.ask("1;1;INDMY") == "QoK"
    assert wire.ask("1;1;IN=0;0020") == "QoK"
    wait_for(lambda: not runs(wire))
    assert wire.ask("1;1;HNDSTS").startswith("QoK900;2;1;902;1;1;")
    assert wire.ask("1;1;OUT900") == "QoK0056"


def test_an_error_of_a_program_is_an_error_of_the_controller(wire):
    load(wire, "BAD", "10 MOV P1", "20 MVS P9", "30 END", NEAR)
    wire.ask("1;1;RUNBAD;1")
    wait_for(lambda: bits(wire)[2])
    number = bits(wire)[2]
    assert wire.ask("1;1;ERROR") == f"Qok{number};2"
    assert wire.ask("1;1;RUN") == "Qer5600"
    fields = wire.ask("1;1;ERRORLOGTOP")[3:].split(";")
    assert fields[2:3] + fields[4:7] == [str(number), "2", "BAD", "20"]
    assert wire.ask("1;1;RSTALRM") == "QoK"
    assert wire.ask("1;1;EDATAP9=(1,2,3)") == "QeR4820"


def test_servos_off_refuses_motions_of_programs_with_their_number(wire):
    load(wire, "SEAM", "10 MOV P1", "20 END", NEAR)
    assert wire.ask("1;1;SRVOFF") == "QoK"
    wire.ask("1;1;RUNSEAM;1")
    wait_for(lambda: bits(wire)[2])
    assert bits(wire)[2] == 2000


def test_a_program_begins_at_a_line_and_goes_step_by_step(wire):
    load(wire, "STEPS", "10 M1=1", "20 M1=2", "30 M1=3", "40 END")
    wire.ask("1;1;PRGLOAD=STEPS")
    assert wire.ask("1;1;LINENO=20") == "QoK"
    assert wire.ask("1;1;LINERD") == "QoK20 M1=2"
    for value, line in ((2, "30"), (3, "40")):
        assert wire.ask("1;1;STEP1") == "QoK"
        wait_for(lambda line=line: not runs(wire) and state(wire)[1] == line)
        assert wire.ask("1;1;VALM1;M") == f"QoKM1=+{value}"
    wire.ask("1;1;RSTPRG")
    assert wire.ask("1;1;BRKPTSET=STEPS;30;1") == "QoK"
    assert wire.ask("1;1;BRKPTGET=STEPS;1;;") == "QoKSTEPS.MB4;30;1"
    wire.ask("1;1;RUNSTEPS;1")
    wait_for(lambda: not runs(wire))
    assert state(wire)[1] == "30" and wire.ask("1;1;BRKPTGET=;1;;") == "QoK"


def test_single_commands_move_the_arm_and_keep_their_settings(wire):
    # the sequence of clients of an RV-2AJ
    assert wire.ask("1;1;EXECJOVRD 10") == "QoK"
    goal = "(250.0, 30.0, 420.0, 0.0, 180.0, 0.000)(6,0)"
    assert wire.ask(f"1;1;EXECPCOSIROP = {goal}") == "QoK"
    assert wire.ask("1;1;EXECMOV PCOSIROP") == "QoK"
    wait_for(lambda: place(wire)["Y"] == pytest.approx(30.0, abs=0.01))
    assert wire.ask("1;1;EXEC2=MOV J_CURR") == "QoK"
    assert wire.ask("1;1;EXECMOV PNONE X").startswith("QeR4220;")
    assert wire.ask("1;1;EXEC2=MOV PNONE").startswith("Qe")
    wait_for(lambda: bits(wire)[2])
    assert wire.ask("1;1;EXECMOV PCOSIROP") == "Qer5600"


def test_other_lines_are_served_while_a_command_is_waited_for(controller, wire):
    answers = []

    def move():
        answers.append(wire.ask("1;1;EXEC2=WAIT M_IN(5)=1"))

    thread = threading.Thread(target=move)
    thread.start()
    with Wire(controller.port) as other:
        for _ in range(20):
            assert other.ask("1;1;OVRD") == "QoK100"
        assert not answers
        for command in ("INDMY", "IN=0;0020"):
            assert other.ask(f"1;1;{command}") == "QoK"
        thread.join()
    assert answers == ["QoK"]


@pytest.mark.parametrize(
    ("jog", "axis", "command"),
    [
        ("00;00;00;01;00", "J1", "JPOSF"),
        ("01;00;00;02;00", "Y", "PPOSF"),
        ("01;00;04;00;00", "Z", "PPOSF"),
        ("02;00;01;00;00", "X", "PPOSF"),
    ],
)
def test_jogging_goes_on_as_long_as_it_is_asked_for(slow, jog, axis, command):
    controller, wire = slow
    controller.state.joints = (0.0, 21.19, 72.78, 86.03, 0.0)
    before = place(wire, command)
    for _ in range(3):
        assert wire.ask(f"1;1;JOG{jog}") == "QoK"
        time.sleep(0.02)
    assert place(wire, command)[axis] != before[axis]

    def stands():
        first = place(wire, command)
        time.sleep(0.02)
        return place(wire, command) == first

    wait_for(stands)
    after = place(wire, command)
    assert abs(after[axis] - before[axis]) > 1.0
    moved = {name for name in before if abs(after[name] - before[name]) > 1.0}
    assert moved == {axis}


def test_inching_safe_position_and_override(wire):
    before = place(wire, "JPOSF")
    assert wire.ask("1;1;JOG00;00;01;00;01") == "QoK"
    wait_for(lambda: place(wire, "JPOSF")["J1"] == pytest.approx(before["J1"] - 0.5, abs=0.001))
    assert wire.ask("1;1;OVRD=50") == "QoK50"
    assert wire.ask("1;1;MOVSP") == "QoK"
    wait_for(lambda: place(wire, "JPOSF") == before)
    assert wire.ask("1;1;JOG07;00;01;00;00") == "QeR5410"


def test_the_emergency_stop_ends_motion_until_it_is_released_and_reset(controller, wire):
    load(wire, "SEAM", "10 MOV P1", "20 SPD 20", "30 MVS P2", "40 END", NEAR, AWAY)
    wire.ask("1;1;RUNSEAM;1")
    wait_for(lambda: place(wire)["Y"] > 1.0)
    controller.emergency_stop()
    wait_for(lambda: not runs(wire))
    run, stop, number = bits(wire)
    assert (run & 0x20, stop & 0x01, number) == (0, 1, 60)
    assert wire.ask("1;1;STPSIG") == "Qok0;2"
    assert wire.ask("1;1;SRVON") == "Qer5600"
    assert wire.ask("1;1;RSTALRM") == "Qok"
    controller.emergency_stop(False)
    assert wire.ask("1;1;RSTALRM") == "QoK"
    assert wire.ask("1;1;SRVON") == "QoK"


def test_a_program_talks_over_the_data_link(controller, wire):
    load(
        wire,
        "LINK",
        '10 OPEN "COM3:" AS #1',
        "20 INPUT #1,M1,P5",
        "30 PRINT #1,M1+1",
        "40 CLOSE #1",
        "50 END",
    )
    wire.ask("1;1;RUNLINK;1")
    assert list(controller.data_ports) == [f"COM{n}:" for n in range(2, 9)]
    with Wire(controller.data_ports["COM3:"][1]) as link:
        link.send(b"41,(1,2,3,0,0,0)(6,0)\r")
        assert float(link.answer()) == 42.0
    wait_for(lambda: not runs(wire))
    assert wire.ask("1;1;VALP5;P") == "QoKP5=(+1.00,+2.00,+3.00,+0.00,+0.00,+0.00)(6,0)"


def test_slots_run_side_by_side_and_one_begins_with_the_power(controller, wire):
    load(wire, "ONE", "10 M_01=M_01+1", "20 DLY 0.05", "30 END")
    load(wire, "TWO", "10 *L", "20 IF M_01<3 THEN GOTO *L", "30 M_02=7", "40 END")
    load(wire, "EVER", "10 M_03=1", "20 DLY 0.1", "30 END")
    wire.ask("1;1;EXEC2=M_01=0")
    assert wire.ask("1;1;RUNONE;0") == "QoK"
    assert wire.ask("1;2;RUNTWO;1") == "QoK"
    wait_for(lambda: wire.ask("1;1;GVALM_02;M") == "QoKM_02=+7")
    assert state(wire, 2)[0] == "TWO.MB4"
    assert wire.ask("1;3;SLOTSETEVER;REP;ALWAYS;1") == "QoK"
    assert wire.ask("1;1;RSTPWR") == "QoK"
    wait_for(lambda: wire.ask("1;1;GVALM_03;M") == "QoKM_03=+1")
    assert not runs(wire)
    assert state(wire, 3)[14:17] == ["EVER.MB4", "REP", "ALWAYS"]


@pytest.fixture
def stopped(wire):
    """A program that was stopped in the middle of a motion."""
    stop_on_the_way(wire)
    return wire


def stop_on_the_way(wire):
    """Runs SEAM until it is caught between its places; a busy machine needs a slow arm for that."""
    for attempt in range(20):
        speed = max(20 * 0.7**attempt, 0.1)
        load(wire, "SEAM", "10 MOV P1", f"20 SPD {speed:.2f}", "30 MVS P2", "40 END", NEAR, AWAY)
        assert wire.ask("1;1;RUNSEAM;1") == "QoK"
        wait_for(lambda: state(wire)[1] == "30" or not runs(wire))
        wait_for(lambda: place(wire)["Y"] > 1.0 or not runs(wire))
        assert wire.ask("1;1;STOP") == "QoK"
        wait_for(lambda: not runs(wire))
        if bits(wire)[1] == 0x06 and 1.0 < place(wire)["Y"] < 79.0:
            return
        assert wire.ask("1;1;RSTPRG") == "QoK"
    pytest.fail("the program was never caught on its way")


def test_a_stopped_program_goes_on_behind_servos_off(stopped):
    there = place(stopped)
    assert stopped.ask("1;1;SRVOFF") == "QoK"
    assert stopped.ask("1;1;SRVON") == "QoK"
    wait_for(lambda: bits(stopped)[0] & 0x20)
    assert place(stopped) == there
    assert stopped.ask("1;1;RUN") == "QoK"
    wait_for(lambda: not runs(stopped))
    assert bits(stopped)[2] == 0
    assert place(stopped)["Y"] == pytest.approx(80.0, abs=0.01)


def test_a_stopped_program_is_reset_and_begins_anew(stopped):
    assert stopped.ask("1;1;SLOTINIT") == "QoK"
    assert stopped.ask("1;1;RUN;1") == "QoK"
    wait_for(lambda: not runs(stopped))
    assert bits(stopped)[2] == 0
    assert place(stopped)["Y"] == pytest.approx(80.0, abs=0.01)


def test_a_stopped_motion_does_not_go_on_behind_a_jog(stopped):
    before = place(stopped, "JPOSF")["J6"]
    assert stopped.ask("1;1;JOG00;00;00;20;01") == "QoK"
    wait_for(lambda: place(stopped, "JPOSF")["J6"] == pytest.approx(before + 0.5, abs=0.01))
    assert stopped.ask("1;1;RUN").lower() == "qok"  # the error may be there already
    wait_for(lambda: not runs(stopped))
    assert bits(stopped)[2] == 3930
    assert stopped.ask("1;1;RSTALRM") == "QoK"
    assert stopped.ask("1;1;RUN;1") == "QoK"
    wait_for(lambda: not runs(stopped))
    assert place(stopped)["Y"] == pytest.approx(80.0, abs=0.01)


def test_stopping_ends_single_commands_and_jogs_where_they_are(slow):
    _, wire = slow
    goal = "(250.0, -90.0, 420.0, 0.0, 180.0, 0.000)(6,0)"
    for command in (f"EXEC2=P1={goal}", "EXEC2=SPD 30", "EXECMVS P1", "EXECMOV P1"):
        assert wire.ask(f"1;1;{command}") == "QoK"
    before = place(wire)["Y"]
    wait_for(lambda: place(wire)["Y"] != before)
    assert wire.ask("1;1;STOP") == "QoK"
    there = place(wire)
    time.sleep(0.03)
    assert place(wire) == there and there["Y"] > -89.0
    assert wire.ask("1;1;EXEC2=DLY 0.01") == "QoK"
    assert bits(wire)[2] == 0


def test_single_commands_have_the_variables_of_the_program_at_hand(wire):
    load(wire, "SEAM", "10 MOV P1", "20 END", NEAR, AWAY)
    assert wire.ask("1;1;PRGLOAD=SEAM") == "QoK"
    assert wire.ask("1;1;EXEC2=MOV P2") == "QoK"
    assert place(wire)["Y"] == pytest.approx(80.0, abs=0.01)
    # teaching: what is open for editing is moved to, changed, and kept
    for command in ("LOAD=SEAM", "EDATAP3=(250,0,420,0,180)(6,0)", "EXEC2=MOV P3"):
        assert wire.ask(f"1;9;{command}") == "QoK"
    assert place(wire)["Z"] == pytest.approx(420.0, abs=0.01)
    for command in ("EXEC2=P1=P_CURR", "EXEC2=M1=P1.X", "SAVE"):
        assert wire.ask(f"1;9;{command}") == "QoK"
    assert wire.ask("1;1;LOAD=SEAM") == "QoK"
    assert wire.ask("1;9;LISTPP1").startswith("QoKP1=(+250.00,+0.00,+420.00,")
    assert wire.ask("1;9;VALM1") == "QoKM1=+250"


def test_what_waits_behind_a_command_that_fails_is_not_run(slow):
    _, wire = slow
    assert wire.ask("1;3;EXECM1=1") == "QoK"
    for command in ("EXECDLY 0.1", "EXECMVS P_CURR+(0,0,5000,0,0,0)(0,0)"):
        assert wire.ask(f"1;3;{command}") == "QoK"
    assert wire.ask("1;3;EXEC2=M1=2").lower() == "qer5600"
    assert bits(wire)[2] == 2602
    assert wire.ask("1;1;RSTALRM") == "QoK"
    assert wire.ask("1;3;EXEC2=MVS P_CURR+(0,0,5000,0,0,0)(0,0)").lower() == "qer2602"
    assert wire.ask("1;1;RSTALRM") == "QoK"

"""What may move an arm: asked for by name, looked at beforehand, and stopped by Ctrl-C."""

from __future__ import annotations

import json
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from assistant.controllers import Controller, connect
from assistant.controllers.states import State
from assistant.virtual.irc5.rws_faults import Fault
from tests.cli.processes import Command
from tests.cli.terminal import Terminal
from tests.cli.test_commands import run
from tests.forks import Forks

MODULE = """MODULE cell
PERS num done:=0;
CONST jointtarget j1:=[[40,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST jointtarget j2:=[[-40,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
  WHILE done<{times} DO
    MoveAbsJ j1,{speed},fine,tool0;
    MoveAbsJ j2,{speed},fine,tool0;
    done:=done+1;
  ENDWHILE
ENDPROC
ENDMODULE
"""


@pytest.fixture
def loaded(capsys, rws, here):
    """An IRC5 whose program lasts until somebody stops it; the motors are on."""
    (here / "cell.mod").write_text(MODULE.format(times=10_000, speed="v50"), encoding="utf-8")
    assert run(capsys, "put", "cell1", "cell.mod")[0] == 0
    assert run(capsys, "motors", "cell1", "on", "--yes")[0] == 0
    return rws


def now() -> tuple[State, float]:
    """What `cell1` is doing, and its first joint."""
    with connect("cell1") as controller:
        assert isinstance(controller, Controller)
        return controller.state(), controller.position().joints[0] or 0.0


@contextmanager
def process(forks: Forks, *arguments: str) -> Iterator[Command]:
    """A command that goes on meanwhile, without a terminal."""
    streams = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with Command(forks, *arguments, **streams) as child:
        yield child
        child.kill()


ASKING = [
    ("motors", "cell1", "on"),
    ("start", "cell1", "cell.mod"),
    ("start", "cell1"),
    ("hand", "cell1", "open"),
    ("jog", "cell1", "J1", "-5"),
    ("outputs", "cell1", "doGrip=1"),
    ("follow", "cell1", "way.csv", "--by", "exchange"),
]
WAY = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n422,0,750,0.5,0,0.8660254,0\n430,0,750,0.5,0,0.8660254,0\n"
BEYOND = [
    (("jog", "cell1", "J1", "500"), "CO711"),
    (("jog", "cell1", "Z", "-3000"), "CO713"),
    (("jog", "cell1", "J9", "1"), "CO712"),
]


def test_without_a_terminal_nothing_moves_unasked(capsys, rws, here):
    """Nor is anybody asked about what is beyond the limits, or cannot be done by hand."""
    (here / "way.csv").write_text(WAY, encoding="utf-8")
    for arguments in ASKING:
        status, out, said = run(capsys, *arguments)
        assert status == 2 and "CL203" in said and "type `cell1`" in said and not out
    for arguments, code in BEYOND:
        status, _, said = run(capsys, *arguments, "--yes")
        assert status in (1, 2) and code in said
    for arguments in (("jog", "cell1", "J1", "5"), ("hand", "cell1", "open")):
        status, _, said = run(capsys, *arguments, "--yes")
        assert status == 2 and "CN209" in said and "CL24" not in said
    state, _ = now()
    assert not state.motors and not state.running


def test_the_name_typed_is_a_yes_and_another_word_is_none(capsys, rws, here, forks):
    with Terminal(forks, "motors", "cell1", "on", folder=here) as terminal:
        terminal.until("Type `cell1` to confirm: ")
        terminal.type("cell2\n")
        status, said = terminal.end()
    assert status == 2 and "CL204" in said
    assert not now()[0].motors
    with Terminal(forks, "motors", "cell1", "on", folder=here) as terminal:
        asked = terminal.until("Type `cell1` to confirm: ")
        assert "the arm can move from then on" in asked
        terminal.type("cell1\n")
        assert terminal.end()[0] == 0
    assert now()[0].motors
    assert run(capsys, "motors", "cell1", "off")[0] == 0  # which is never asked for
    assert not now()[0].motors


def test_a_program_is_started_and_waited_for(capsys, loaded, here):
    (here / "cell.mod").write_text(MODULE.format(times=1, speed="v1000"), encoding="utf-8")
    assert run(capsys, "put", "cell1", "cell.mod", "--replace")[0] == 0
    status, out, _ = run(capsys, "start", "cell1", "cell.mod", "--override", "100", "--yes")
    assert status == 0 and "the program has ended" in out
    assert run(capsys, "variables", "cell1", "done", "--program", "cell")[1] == "done = 1\n"
    assert now()[1] == pytest.approx(-40.0, abs=0.01)


def test_it_is_not_waited_for_if_nobody_wants(capsys, loaded):
    arguments = ("start", "cell1", "cell.mod", "--no-wait", "--yes", "--format", "json")
    status, out, _ = run(capsys, *arguments)
    assert status == 0 and json.loads(out)["state"]["running"]
    status, _, said = run(capsys, "variables", "cell1", "done=5")
    assert status == 2 and "CL203" in said  # a program runs that may go elsewhere then
    status, out, _ = run(capsys, "stop", "cell1")
    assert status == 0 and "standing" in out
    assert run(capsys, "variables", "cell1", "done=5", "--program", "cell")[:2] == (0, "done = 5\n")


ENDINGS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGTSTP")


def test_ctrl_c_stops_the_arm_and_tells_where_it_is(loaded, forks):
    """So does the end of a pipeline or a terminal, and Ctrl-Z, which would halt us alone."""
    for ending in ENDINGS:
        with process(forks, "start", "cell1", "cell.mod", "--yes") as child:
            assert "Ctrl-C stops it" in child.stdout.readline()
            child.send_signal(getattr(signal, ending))
            _, said = child.communicate(timeout=30)
        assert child.returncode == 128 + getattr(signal, ending)
        assert said.endswith(f"ended by {ending}\n")
        assert "CL240" in said and "stands at J1 " in said and "Traceback" not in said
        state, first = now()
        assert not state.running and f"J1 {first:.2f}" in said


def test_an_emergency_stop_ends_the_wait(loaded, forks):
    with process(forks, "start", "cell1", "cell.mod", "--yes") as child:
        assert "Ctrl-C stops it" in child.stdout.readline()
        loaded.press_emergency_stop()
        out, said = child.communicate(timeout=30)
    assert child.returncode == 1 and "EMERGENCY STOP" in out and "Traceback" not in said
    assert not now()[0].running


def test_where_nobody_answers_it_is_not_known_whether_the_arm_stands(loaded, forks):
    with process(forks, "start", "cell1", "cell.mod", "--yes") as child:
        assert "Ctrl-C stops it" in child.stdout.readline()
        loaded.stop()
        _, said = child.communicate(timeout=60)
    assert child.returncode == 2 and "Traceback" not in said
    assert "CL241" in said and "emergency stop" in said


def test_a_second_ctrl_c_gives_up(loaded, forks):
    with process(forks, "start", "cell1", "cell.mod", "--yes") as child:
        assert "Ctrl-C stops it" in child.stdout.readline()
        loaded.faults.add(Fault("delay", seconds=1.0))
        child.send_signal(signal.SIGINT)
        assert "Ctrl-C again gives up" in child.stderr.readline()
        child.send_signal(signal.SIGINT)
        _, said = child.communicate(timeout=30)
    assert child.returncode == 130
    assert "CL241" in said and "given up" in said and "CL240" not in said


def test_the_robot_of_the_project_has_to_be_there(capsys, loaded, tmp_path):
    project = tmp_path / "assistant.toml"
    text = project.read_text()
    project.write_text(text.replace("irb1200-7-0.7", "rv-2aj"))
    status, _, said = run(capsys, "start", "cell1", "cell.mod", "--yes")
    assert status == 2 and "CO702" in said
    assert not now()[0].running
    project.write_text(text.replace("robot =", "#"))
    status, _, said = run(capsys, "start", "cell1", "cell.mod", "--no-wait", "--yes")
    assert status == 0 and "CO714" in said
    assert run(capsys, "stop", "cell1")[0] == 0


# ------------------------------------------------------------------- a CR controller, by its link


@pytest.fixture
def ready(capsys, cr):
    """A CR controller whose motors are on."""
    assert run(capsys, "motors", "cell1", "on", "--yes")[0] == 0
    return cr


def test_one_axis_and_a_hand_are_moved(capsys, ready):
    status, out, _ = run(capsys, "jog", "cell1", "J1", "-5", "--speed", "100", "--yes")
    assert status == 0 and out.startswith("J1 -5.00  J2 0.00")
    status, out, _ = run(capsys, "jog", "cell1", "z", "-3", "--yes", "--format", "json")
    assert status == 0
    assert json.loads(out)["position"]["position"] == pytest.approx([159.39, -13.94, 475.0])
    assert run(capsys, "hand", "cell1", "close", "--yes")[:2] == (0, "cell1: hand 1 closed\n")


def test_ctrl_c_stops_a_motion_by_hand(ready, forks):
    with process(forks, "jog", "cell1", "J1", "90", "--speed", "3", "--yes") as child:
        while now()[1] == 0.0:
            assert child.poll() is None
        child.send_signal(signal.SIGINT)
        _, said = child.communicate(timeout=30)
    assert child.returncode == 130 and "CL240" in said and "Traceback" not in said
    first = now()[1]
    assert 0.0 < first < 89.0 and f"J1 {first:.2f}" in said


def test_a_program_is_started_by_the_link_and_a_fault_of_it_is_its_end(capsys, ready, here):
    (here / "pick.prg").write_text(
        "10 MOV J1\n20 END\nJ1=(+10.00,+0.00,+90.00,+0.00,+90.00,+0.00)\n"
    )
    assert run(capsys, "put", "cell1", "pick.prg")[0] == 0
    status, out, _ = run(capsys, "start", "cell1", "PICK", "--yes")
    assert status == 0 and "the program has ended" in out
    assert now()[1] == pytest.approx(10.0)
    (here / "bad.prg").write_text(
        "10 MOV J1\n20 END\nJ1=(+400.00,+0.00,+90.00,+0.00,+90.00,+0.00)\n"
    )
    assert run(capsys, "put", "cell1", "bad.prg")[0] == 0
    status, out, said = run(capsys, "start", "cell1", "BAD", "--yes")
    assert status == 1 and "error" in out + said
    assert not now()[0].running

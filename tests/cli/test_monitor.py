"""`monitor` and what else looks at a controller: as lines, JSON, CSV, and live in a terminal."""

from __future__ import annotations

import csv
import json

from assistant.sources import read
from tests.cli.terminal import Terminal
from tests.cli.test_commands import run
from tests.controllers.mitsubishi.test_documented_answers import answering
from tests.wire import Wire


def test_plain_lines_and_a_log(capsys, cr, here):
    arguments = ("--interval", "0.01", "--seconds", "0.02", "--signals", "in:5,out:7")
    status, out, _ = run(capsys, "monitor", "cell1", *arguments, "--log", "run.csv")
    first, *lines = out.splitlines()
    assert status == 0 and "RV-2AJ" in first and len(lines) >= 2
    assert "motors off, standing" in lines[0] and "J3 90.00" in lines[0]
    assert "in:5 = 0; out:7 = 0" in lines[0]
    with (here / "run.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(lines)
    assert (
        rows[0]["_j3_deg"] == "90.0000" and rows[0]["_j4_deg"] == "" and rows[0]["_in:5"] == "0.0"
    )
    program = read(here / "run.csv").program  # a log is a trajectory, too
    assert len(program.procedures[0].body) >= 1


def test_json_is_a_line_each(capsys, cr):
    arguments = ("--interval", "0.01", "--seconds", "0.02", "--format", "json")
    status, out, _ = run(capsys, "monitor", "cell1", *arguments)
    samples = [json.loads(line) for line in out.splitlines()]
    assert status == 0 and len(samples) >= 2
    assert samples[0]["state"]["mode"] == "automatic"
    assert samples[0]["position"]["joints"] == [0.0, 0.0, 90.0, None, 90.0, 0.0]
    assert samples[-1]["seconds"] >= 0.02


def test_a_log_is_not_written_over_nor_left_of_nothing(capsys, cr, here):
    (here / "run.csv").write_text("mine")
    status, _, said = run(capsys, "monitor", "cell1", "--seconds", "0.1", "--log", "run.csv")
    assert status == 2 and "CL220" in said and (here / "run.csv").read_text() == "mine"
    status, _, said = run(capsys, "monitor", "cell1", "--log", "none/run.csv")
    assert status == 2 and "CL221" in said

    (here / "run.csv").unlink()
    status, _, said = run(capsys, "monitor", "melfa://127.0.0.1:1", "--log", "run.csv")
    assert status == 2 and "CN201" in said and not (here / "run.csv").exists()


def test_a_live_table_until_ctrl_c(cr, here, forks):
    with Terminal(forks, "monitor", "cell1", "--interval", "0.05", folder=here) as terminal:
        terminal.until("RV-2AJ")
        terminal.until("J3 90.00")
        cr.alarm(4140)
        terminal.until("4140")
        terminal.interrupt()
        assert terminal.end()[0] == 0


def test_monitoring_needs_no_right(capsys, cr):
    with Wire(cr.port) as other:
        other.ask("1;1;OPEN=OTHER")
        assert other.ask("1;1;CNTLON").startswith("QoK")
        assert run(capsys, "monitor", "cell1", "--seconds", "0.01")[0] == 0
        assert other.ask("1;1;OVRD=50").startswith("QoK")  # which is still theirs


def test_signals_are_read_and_parameters_are_set(capsys, cr):
    assert run(capsys, "inputs", "cell1", "5", "6")[:2] == (0, "5 = 0\n6 = 0\n")
    with Wire(cr.port) as wire:
        wire.ask("1;1;INDMY")
        wire.ask("1;1;IN=5;0001")
    assert run(capsys, "inputs", "cell1", "5")[1] == "5 = 1\n"
    status, out, _ = run(capsys, "parameters", "cell1", "MEJAR", "--format", "json")
    assert status == 0 and json.loads(out)["parameters"]["MEJAR"].startswith("-150.00, 150.00")
    status, _, said = run(capsys, "parameters", "cell1", "NONSENSE")
    assert status == 1 and "CN" in said

    assert run(capsys, "parameters", "cell1")[:2] == (0, "")
    assert run(capsys, "parameters", "cell1", "MEXTL=0,0,50,0,0,0")[0] == 0
    status, out, _ = run(capsys, "parameters", "cell1")
    assert status == 0 and out.startswith("MEXTL = ") and "50" in out


def test_the_log_and_its_end(capsys, cr):
    assert run(capsys, "log", "cell1")[:2] == (0, "")
    cr.alarm(4140)
    status, out, _ = run(capsys, "log", "cell1", "--most", "1")
    assert status == 0 and "4140" in out
    status, out, _ = run(capsys, "monitor", "cell1", "--seconds", "0.01", "--format", "json")
    assert json.loads(out.splitlines()[0])["state"]["faults"][0]["number"] == 4140
    status, out, _ = run(capsys, "reset", "cell1")
    assert status == 0 and "4140" not in out


def test_backup_and_restore(capsys, cr, here):
    (here / "pick.prg").write_text("10 DLY 1\n20 END\n")
    assert run(capsys, "put", "cell1", "pick.prg")[0] == 0
    status, out, _ = run(capsys, "backup", "cell1", "saved")
    assert status == 0 and (here / "saved" / "programs" / "PICK.prg").exists()
    files = [file for file in (here / "saved").rglob("*") if file.is_file()]
    assert out == f"{len(files)} files of cell1 are in saved\n"
    (here / "pick.prg").write_text("10 DLY 2\n20 END\n")
    assert run(capsys, "put", "cell1", "pick.prg", "--replace")[0] == 0
    status, out, _ = run(capsys, "restore", "cell1", "saved", "--dry-run")
    assert status == 0 and "-10 DLY 2" in out and "+10 DLY 1" in out
    status, out, _ = run(capsys, "restore", "cell1", "saved", "--dry-run", "--format", "json")
    answer = json.loads(out)
    assert not answer["restored"] and "+10 DLY 1" in answer["changes"]["programs/PICK.prg"]
    assert "DLY 2" in cr.text("PICK")
    status, out, said = run(capsys, "restore", "cell1", "saved")
    assert status == 2 and "CL203" in said + out and "DLY 2" in cr.text("PICK")
    assert run(capsys, "restore", "cell1", "saved", "--yes")[0] == 0
    assert "DLY 1" in cr.text("PICK")


def test_names_of_a_controller_do_not_steer_the_terminal(capsys):
    answers = {"PDIRTOP": "QoKA\x1b[2J\x9bB.MB5;10;24-02-2821:05:14;1;220160;12;;1;0;0;0;0;0"}
    with answering(answers) as client:
        status, out, _ = run(capsys, "ls", client.address)
    assert status == 0 and "A\\u001b[2J\\u009bB" in out and out.rstrip("\n").isprintable()

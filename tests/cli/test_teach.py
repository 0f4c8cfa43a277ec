"""`teach`: at a key press in a terminal, at lines of an input, when a signal comes, at once."""

from __future__ import annotations

import json
import subprocess

from assistant.sources import read
from tests.cli.processes import Command
from tests.cli.terminal import Terminal
from tests.cli.test_commands import run
from tests.wire import Wire


def test_at_once(capsys, cr, here):
    status, out, _ = run(capsys, "teach", "cell1", "above", "--now", "--into", "points.toml")
    assert status == 0 and out.startswith("above: x 160.00")
    status, out, _ = run(
        capsys, "teach", "cell1", "bent", "--now", "--joints", "--into", "points.toml",
        "--format", "json",
    )  # fmt: skip
    assert json.loads(out)["stored"][0]["name"] == "bent"
    program = read(here / "points.toml").program
    assert program.robot == "rv-2aj" and program.targets["above"].configuration is not None
    assert list(program.joint_targets) == ["bent"]


def test_a_name_that_is_there_stays_unless_it_is_to_be_replaced(capsys, cr, here):
    arguments = ("teach", "cell1", "above", "--now", "--into", "points.toml")
    assert run(capsys, *arguments)[0] == 0
    text = (here / "points.toml").read_text() + "speed = 50  # slowly\n"
    (here / "points.toml").write_text(text.replace("160.0", "100.0"))
    status, _, said = run(capsys, *arguments)
    assert status == 1 and "TB509" in said
    assert run(capsys, *arguments, "--replace")[0] == 0
    assert (here / "points.toml").read_text() == text


def test_key_presses_in_a_terminal(cr, here, forks):
    with Terminal(forks, "teach", "cell1", "above", "below", "left", folder=here) as terminal:
        terminal.until("above: Enter stores it, q ends")
        terminal.type("x\r")
        terminal.until("above: x 160.00")
        terminal.until("below: Enter stores it, q ends")
        terminal.type(" ")
        terminal.until("below: x 160.00")
        terminal.until("left: Enter stores it")
        terminal.type("q")
        assert terminal.end()[0] == 0
    assert list(read(here / "taught.toml").program.targets) == ["above", "below"]


def test_ctrl_c_keeps_what_was_stored(capsys, cr, here, forks):
    assert run(capsys, "teach", "cell1", "p1", "--now")[0] == 0  # so p2 is the first free name
    with Terminal(forks, "teach", "cell1", folder=here) as terminal:
        terminal.until("p2: Enter stores it")
        terminal.type("\r")
        terminal.until("p3: Enter stores it")
        terminal.interrupt()
        assert terminal.end()[0] == 130
    assert list(read(here / "taught.toml").program.targets) == ["p1", "p2"]


def test_lines_of_an_input(cr, here, forks):
    file = here / "taught.toml"
    for typed, names in (("\n\n", ["p1", "p2"]), ("\nq\n", ["p1"])):
        pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
        with Command(forks, "teach", "cell1", **pipes) as child:
            _, said = child.communicate(typed, timeout=60)
        assert child.returncode == 0, said
        assert list(read(file).program.targets) == names
        file.unlink()


def test_when_a_signal_comes(cr, here, forks):
    words = ("teach", "cell1", "a", "b", "--on", "5")
    with Wire(cr.port) as wire, Terminal(forks, *words, folder=here) as terminal:
        wire.ask("1;1;INDMY")
        terminal.until("a: `5` stores it, q ends")
        wire.ask("1;1;IN=5;0001")
        terminal.until("a: x 160.00")
        terminal.until("b: `5` stores it")
        wire.ask("1;1;IN=5;0000")
        terminal.type("q")
        assert terminal.end()[0] == 0
    assert list(read(here / "taught.toml").program.targets) == ["a"]


def test_a_file_that_is_wrong_is_not_touched(capsys, cr, here):
    (here / "taught.toml").write_text("[[targets]\n")
    status, _, said = run(capsys, "teach", "cell1", "a", "--now")
    assert status == 2 and "CT301" in said
    assert (here / "taught.toml").read_text() == "[[targets]\n"

"""`run`: what programs do, told in a log; scripts, limits, places, steps, files; what is wrong."""

from __future__ import annotations

import io
import json
import os
import pty
import signal
import socket
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from tests.cli.processes import Command
from tests.cli.tables import each
from tests.cli.test_commands import run
from tests.forks import Forks

Capture = pytest.CaptureFixture[str]
SAMPLES = Path(__file__).parents[2] / "samples"
RAPID = """MODULE cell
PERS num done:=0;
PROC main()
  Add 2;
  WaitDI diPart,1;
  SetDO doGrip,1;
  WaitTime 0.5;
ENDPROC
PROC Add(num by)
  done:=done+by;
ENDPROC
ENDMODULE
"""
MELFA = "10 M1=2\n20 WAIT M_IN(3)=1\n30 M_OUT(8)=1\n40 DLY 0.5\n50 END\n"
SCRIPT = "[[set]]\ninput = {name}\nat = 1.25\n"


def write(folder: Path, name: str, text: str) -> Path:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    return write(tmp_path, "cell.mod", RAPID)


@pytest.fixture
def part(tmp_path: Path) -> Path:
    return write(tmp_path, "part.toml", SCRIPT.format(name='"diPart"'))


def test_a_run_tells_what_happens_when_and_where(capsys: Capture, cell: Path, part: Path) -> None:
    status, out, err = run(capsys, "run", cell, "--robot", "irb1200-7-0.7", "--signals", part)
    assert (status, err) == (0, "")
    assert [line.split(None, 2) for line in out.splitlines()[:3]] == [
        ["1.250", "input", "diPart = 1"],
        ["1.250", "cell.mod:6", "doGrip = 1"],
        ["1.250", "cell.mod:7", "waits 0.5 s"],
    ]
    assert out.splitlines()[3].startswith(f"{cell}: came to its end: 1.75 s, 0 motions, 1 output")


def test_a_program_of_melfa_basic_is_run_alike(capsys: Capture, tmp_path: Path) -> None:
    program = write(tmp_path, "PART.prg", MELFA)
    script = write(tmp_path, "part.toml", SCRIPT.format(name="3"))
    status, out, _ = run(capsys, "run", program, "-r", "rv-2aj", "--signals", script)
    assert status == 0
    assert [line.split(None, 2)[1:] for line in out.splitlines()[:3]] == [
        ["input", "3 = 1"],
        ["PART.prg:3", "8 = 1"],
        ["PART.prg:4", "waits 0.5 s"],
    ]


def test_the_answer_for_programs(capsys: Capture, cell: Path, part: Path, tmp_path: Path) -> None:
    trace = tmp_path / "out" / "run.npz"
    status, out, _ = run(
        capsys, "run", cell, "--signals", part, "--format", "json", "--trace", trace
    )
    answer = json.loads(out)
    assert status == 0
    assert (answer["ended"], answer["seconds"], answer["file"]) == ("end", 1.75, None)
    assert [row["event"] for row in answer["events"]] == ["input", "output", "wait"]
    assert answer["events"][1] == {
        "time": 1.25,
        "task": "T_ROB1",
        "file": str(cell),
        "line": 6,
        "event": "output",
        "signal": "doGrip",
        "value": 1.0,
        "on_way": None,
    }
    assert [finding["code"] for finding in answer["findings"]] == ["CL025"]
    assert answer["written"] == [str(trace)]
    with np.load(trace) as columns:
        assert columns["event_time"].tolist() == [1.25, 1.25, 1.25]
        assert columns["signal"].tolist() == ["diPart", "doGrip", ""]
        assert columns["event_line"].tolist() == [0, 6, 7]


def test_a_run_ends_where_it_is_asked_to(capsys: Capture, cell: Path, part: Path) -> None:
    for until in (f"{cell}:7", "cell.mod:7", "CELL:7", "1.4"):
        status, out, _ = run(capsys, "run", cell, "--signals", part, "--until", until)
        assert status == 0
        assert "was ended as asked" in out
        assert ("waits" in out) is (until == "1.4")
    status, _, err = run(capsys, "run", cell, "--signals", part, "--until", "cell.mod:1")
    assert status == 1
    assert "CL024" in err and "cell.mod:1" in err


EARLY = (
    ((), "VC213", 5),
    (("--max-time", "2", "--signals", "far.toml"), "VC215", 5),
    (("--max-steps", "2"), "VC214", 5),
)


def test_what_ends_a_run_early_has_its_place(
    capsys: Capture, cell: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(cell.parent)
    write(cell.parent, "far.toml", SCRIPT.format(name='"diPart"').replace("1.25", "9"))

    def check(options: tuple[str, ...], code: str, line: int) -> None:
        status, out, err = run(capsys, "run", "cell.mod", *options)
        assert status == 1
        assert f"{code} error cell.mod:{line}: " in err
        assert "came to its end" not in out

    each(EARLY, check)


def test_errors_of_the_program_have_their_place(capsys: Capture, tmp_path: Path) -> None:
    body = "PROC main()\n  VAR num n;\n  n:=1/0;\nENDPROC\n"
    rapid = write(tmp_path, "a.mod", f"MODULE a\n{body}ENDMODULE\n")
    status, _, err = run(capsys, "run", rapid)
    assert (status, "VC211 error" in err, "a.mod:4: " in err) == (1, True, True)
    other = write(tmp_path, "b.mod", "MODULE b\nPROC main()\n  Unheard 3;\nENDPROC\nENDMODULE\n")
    status, _, err = run(capsys, "run", other)
    assert (status, "VC212 error" in err, "b.mod:3" in err) == (1, True, True)
    melfa = write(tmp_path, "C.prg", "10 M1=M2+1\n20 END\n")
    status, _, err = run(capsys, "run", melfa)
    assert (status, "VC211 error" in err, "C.prg:1: " in err, "3700" in err) == (
        1,
        True,
        True,
        True,
    )


WRONG = (
    (("--until", "-1"), "CL022"),
    (("--until", "nan"), "CL022"),
    (("--until", "other.mod:3"), "CL027"),
    (("--until", "cell.mod:99"), "CL027"),
    (("--break", "cell.mod"), "CL027"),
    (("--max-time", "0"), "CL023"),
    (("--max-steps", "0"), "CL023"),
    (("--trace", "run.csv"), "CL021"),
    (("--period", "-1"), "CL023"),
    (("--plot", "run.gif"), "CL009"),
    (("--plot", "run.png"), "CL029"),
    (("--robot", "nothing"), "CO002"),
    (("--signals", "none.toml"), "IN001"),
    (("--unit", "mm"), "CO023"),
    (("--step", "--format", "json"), "CL028"),
    (("--trace", "cell.mod"), "CL021"),
)

OUTSIDE = (
    (("--disk", "nowhere"), "CL031"),
    (("--host", "192.168.125.1"), "CL030"),
    (("--host", "=127.0.0.1"), "CL030"),
    (("--line", "COM1"), "CL033"),
    (("--line", "COM1=1", "--line", "com1:=2"), "CL043"),
    (("--host", "a=b", "--host", "a=c"), "CL043"),
    (("--line", "COM1=10003"), "VC207"),
)


def test_wrong_usage_is_said(capsys: Capture, cell: Path) -> None:
    def check(options: tuple[str, ...], code: str) -> None:
        status, out, err = run(capsys, "run", cell, *options)
        assert status == 2
        assert code in (out if "json" in options else err)

    each((*WRONG, *OUTSIDE), check)


def test_a_signal_that_no_program_uses_is_told(capsys: Capture, cell: Path) -> None:
    script = write(cell.parent, "x.toml", SCRIPT.format(name='"diPrat"'))
    status, _, err = run(capsys, "run", cell, "--signals", script, "--until", "3")
    assert status == 1
    assert "CL026" in err and "write `dipart`" in err


MOVES = """MODULE moves
CONST robtarget a:=[[400,-100,400],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
  MoveJ a,v200,fine,tool0;
  SetDO doGrip,1;
  MoveL Offs(a,0,0,-100),v100,fine,tool0;
  SetDO doGrip,0;
ENDPROC
ENDMODULE
"""


def test_the_motion_is_written_and_drawn(capsys: Capture, tmp_path: Path) -> None:
    program = write(tmp_path, "moves.mod", MOVES)
    trace, plot = tmp_path / "run.npz", tmp_path / "run.svg"
    files = ("--trace", trace, "--plot", plot, "--period", "0.05")
    status, out, err = run(capsys, "run", program, "-r", "irb1200-7-0.7", *files)
    assert (status, err) == (0, "")
    assert f"wrote {trace}" in out and f"wrote {plot}" in out
    assert plot.read_bytes().startswith(b"<?xml")
    with np.load(trace) as columns:
        on, off = columns["event_time"][columns["signal"] == "doGrip"]
        assert off - on == pytest.approx(1.0, abs=0.2)  # 100 mm at 100 mm/s
        assert columns["output_names"].tolist() == ["doGrip"]
        grip = columns["outputs"][:, 0]
        assert columns["t"][grip == 1.0].min() == pytest.approx(on, abs=0.05)
        assert columns["position"][-1] == pytest.approx([400, -100, 300], abs=5.0)
        assert columns["joints"].shape == (len(columns["t"]), 6)
        assert columns["speed"].max() == pytest.approx(200, rel=0.01)


COMMANDS = ("stack", "s", "v done by", "v nix", "i", "i dipart x", "i diPart 1", "o", "h", "wat")


def test_a_person_steps_through_a_program(
    capsys: Capture, cell: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = "\n".join((*COMMANDS, "c")) + "\n"
    monkeypatch.setattr(sys, "stdin", io.StringIO(said))
    status, out, _ = run(capsys, "run", cell, "--step", "--break", "cell.mod:7")
    assert status == 0
    for shown in (
        "T_ROB1  cell.mod:4  Add 2;",
        "main  cell.mod:4  Add 2;",
        "T_ROB1  cell.mod:10  done:=done+by;",
        "Routine: num by = 2",
        "there is no data of that name here",
        "`x` is no number",
        "input diPart = 1",
        "`wat` is no command; h prints them",
        "T_ROB1  cell.mod:7  WaitTime 0.5;",
        "doGrip = 1",
    ):
        assert shown in out, shown
    assert out.splitlines()[-1].startswith(f"{cell}: came to its end: 0.50 s")


def test_stepping_in_a_terminal(cell: Path, forks: Forks) -> None:
    """Over a terminal of its own, as a person has it."""
    ours, theirs = pty.openpty()
    streams = {"stdin": theirs, "stdout": theirs, "stderr": subprocess.DEVNULL}
    with Command(forks, "run", cell, "--break", "cell.mod:5", **streams) as child:
        os.close(theirs)
        said = b""
        for typed, awaited in ((b"", b"> "), (b"i diPart 1\n", b"diPart = 1"), (b"q\n", b"asked")):
            os.write(ours, typed)
            while awaited not in said:
                said += os.read(ours, 4096)
        assert child.wait() == 0
    os.close(ours)
    assert b"cell.mod:5" in said


# ------------------------------------------------------------------------ what is outside

QUESTION = """MODULE cell
PROC main()
  TPReadNum reg1,"How many?";
  SetGO goCount,reg1;
ENDPROC
ENDMODULE
"""
FILES = """MODULE cell
VAR iodev log;
PROC main()
  WaitUntil IsFile("HOME:/order.txt")\\MaxTime:=10;
  Open "HOME:/order.txt",log\\Read;
  TPWrite ReadStr(log);
  Close log;
  Open "done.txt",log\\Write;
  Write log,"done";
  Close log;
ENDPROC
ENDMODULE
"""


def test_questions_are_answered_on_standard_input(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    program = write(tmp_path, "cell.mod", QUESTION)
    monkeypatch.setattr("sys.stdin", io.StringIO("7\n"))
    status, out, err = run(capsys, "run", program, "-r", "irb1200-7-0.7", "--ask")
    assert status == 0
    assert "answer to `How many?`: " in err
    assert "goCount = 7" in out
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    status, _, err = run(capsys, "run", program, "-r", "irb1200-7-0.7", "--ask")
    assert (status, "nobody answers `How many?`" in err) == (1, True)


def test_a_folder_is_the_disk_of_the_controller(capsys: Capture, tmp_path: Path) -> None:
    program = write(tmp_path, "cell.mod", FILES)
    home = tmp_path / "home"
    home.mkdir()
    write(home, "order.txt", "two frames\n")
    status, out, _ = run(capsys, "run", program, "-r", "irb1200-7-0.7", "--disk", home)
    assert (status, "two frames" in out) == (0, True)
    assert (home / "done.txt").read_text() == "done\n"


def test_a_program_from_standard_input_cannot_ask_there(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(QUESTION.encode())))
    status, _, err = run(capsys, "run", "-", "--from", "rapid", "--ask")
    assert (status, "CL032" in err) == (2, True)


def test_what_a_language_does_not_use_is_said(capsys: Capture, tmp_path: Path) -> None:
    program = write(tmp_path, "PART.prg", MELFA)
    none = f"COM1={tmp_path / 'none'}"
    for option, value, code in (
        *(("--disk", tmp_path, "VC207"), ("--host", "a=b", "VC207"), ("--line", none, "VC217")),
    ):
        status, _, err = run(capsys, "run", program, option, value)
        assert (status, code in err) == (2, True), option


OPEN = (
    ("", "VC212", "quotients"),
    ('quotients = "zero"', "", "3 = 1"),
    ('quotients = "floor"', "", "4 = 1"),
    ('quotient = "zero"', "VC208", "`quotients`"),
    ('quotients = "up"', "VC209", '"floor"'),
    ("tools = { 1 = [0, 0] }", "VC209", "X, Y, Z, A, B, C"),
    ("bits = true", "VC209", "32"),
    ("digits = 0", "VC209", "from 1 to 17"),
    ("began = 2026-05-01T12:30:00", "VC212", "quotients"),
)


def test_what_the_manuals_leave_open(capsys: Capture, tmp_path: Path) -> None:
    program = write(tmp_path, "OPEN.prg", "1 M_Out(-(-7\\2))=1\n2 End\n")

    def check(options: str, code: str, told: str) -> None:
        script = write(tmp_path, "open.toml", f"[options]\n{options}\n")
        status, out, err = run(capsys, "run", program, "--signals", script)
        assert told in out + err and code in err
        assert status == (0 if not code else 1 if code == "VC212" else 2)

    each(OPEN, check)


def test_options_are_for_languages_that_have_some(capsys: Capture, tmp_path: Path) -> None:
    program = write(tmp_path, "m.mod", "MODULE m\nPROC main()\nENDPROC\nENDMODULE\n")
    script = write(tmp_path, "open.toml", "[options]\ntruth = -1\n")
    status, _, err = run(capsys, "run", program, "--signals", script)
    assert (status, "VC210" in err) == (2, True)
    script = write(tmp_path, "wrong.toml", "options = 5\n")
    status, _, err = run(capsys, "run", program, "--signals", script)
    assert (status, "CT303" in err) == (2, True)


def test_the_page_shows_what_the_command_says(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(SAMPLES.parent)
    page = (SAMPLES.parent / "docs" / "running.md").read_text("utf-8")
    command, shown = page.split("$ robot-assistant ", 2)[1].split("...", 1)[0].split("\n", 1)
    status, out, _ = run(capsys, *command.split())
    assert status == 0
    assert len(shown.splitlines()) == 6 and out.startswith(shown)


def test_a_sample_comes_to_its_end(capsys: Capture) -> None:
    script = SAMPLES / "melfa" / "PALLET.signals.toml"
    program = SAMPLES / "melfa" / "PALLET.prg"
    status, out, err = run(capsys, "run", program, "-r", "rv-4frl", "--signals", script)
    assert (status, err) == (0, "")
    assert "came to its end" in out.splitlines()[-1]


def test_lines_lead_to_this_computer(capsys: Capture) -> None:
    """Programs of three slots: one line is a port that a client connects to, the other a server."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    with socket.create_server(("127.0.0.1", 0)) as server, ThreadPoolExecutor() as pool:
        server.settimeout(20.0)

        def client() -> str:
            peer, _ = server.accept()
            with peer, peer.makefile("rw", newline="\r") as stream:
                peer.settimeout(20.0)
                said = stream.readline()
                with socket.create_connection(("127.0.0.1", port), 20.0) as mover:
                    mover.sendall(b"(10,0,90,0,90,0)\r")
                    print("1", end="\r", file=stream, flush=True)
                    while "(10.00,0.00,90.00" not in stream.readline():
                        pass
                print("0", end="\r", file=stream, flush=True)
                *_, last = stream
            return said + last

        person = pool.submit(client)
        main = SAMPLES / "melfa" / "datalink" / "MULTITASK.prg"
        lines = ("--line", f"COM1={port}", "--line", f"COM2=127.0.0.1:{server.getsockname()[1]}")
        status, out, err = run(capsys, "run", main, "-r", "rv-2aj", *lines, "--max-time", "60")
        assert (status, person.result()) == (0, "READY\rEND\r"), err
    assert "stop" in out


def test_a_run_that_is_interrupted_tells_what_it_did(tmp_path: Path, forks: Forks) -> None:
    endless = "SetDO doGrip,1;\nWHILE TRUE DO\ndone:=done+1;\nENDWHILE\n"
    text = f"MODULE a\nVAR num done;\nPROC main()\n{endless}ENDPROC\nENDMODULE\n"
    program = write(tmp_path, "a.mod", text)
    words = ("run", program, "--real-time", "--max-steps", "100000000")
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    with Command(forks, *words, **streams) as child:
        assert child.stdout is not None
        assert "doGrip = 1" in child.stdout.readline()
        child.send_signal(signal.SIGINT)
        assert "was ended as asked" in child.stdout.read()
    assert child.returncode == 130

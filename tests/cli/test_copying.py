"""`ls`, `get`, `put` on both kinds of controllers, and what an address cannot do."""

from __future__ import annotations

import json

from tests.cli.test_commands import run

MODULE = "MODULE {0}\n  PROC {0}_main()\n    WaitTime {1};\n  ENDPROC\nENDMODULE\n"
PROGRAM = "10 OVRD 50\n20 DLY {}\n30 END\n"


def test_programs_of_an_irc5_by_name(capsys, irc5, tmp_path):
    (tmp_path / "here" / "seam.mod").write_text(MODULE.format("seam", 1), encoding="utf-8")
    assert run(capsys, "put", "cell1", "seam.mod")[:2] == (0, "seam.mod is `seam.mod` on cell1\n")
    assert run(capsys, "ls", "cell1")[:2] == (0, "seam.mod\n")
    assert run(capsys, "get", "cell1", "seam.mod", "-o", "back.mod")[0] == 0
    here = tmp_path / "here"
    assert (here / "back.mod").read_bytes() == (here / "seam.mod").read_bytes()


def test_programs_of_a_cr_by_name(capsys, cr, tmp_path):
    for name in ("pick.prg", "place.prg"):
        (tmp_path / "here" / name).write_text(PROGRAM.format(1), encoding="utf-8")
    assert run(capsys, "put", "cell1", "pick.prg", "place.prg")[0] == 0
    assert run(capsys, "ls", "cell1")[:2] == (0, "PICK\nPLACE\n")
    answer = json.loads(run(capsys, "ls", "cell1", "--format", "json")[1])
    assert answer == {"address": str(cr.address), "programs": ["PICK", "PLACE"]}
    (tmp_path / "copies").mkdir()
    copies = tmp_path / "copies"
    assert run(capsys, "get", "cell1", "PICK", "PLACE", "-o", copies)[0] == 0
    assert sorted(file.name for file in copies.iterdir()) == ["PICK", "PLACE"]
    assert b"DLY 1" in (copies / "PICK").read_bytes()


def test_nothing_is_written_over_unasked(capsys, cr, tmp_path):
    here = tmp_path / "here"
    (here / "pick.prg").write_text(PROGRAM.format(1), encoding="utf-8")
    (here / "other.prg").write_text(PROGRAM.format(1), encoding="utf-8")
    assert run(capsys, "put", "cell1", "pick.prg")[0] == 0
    assert run(capsys, "put", "cell1", "pick.prg")[0] == 0  # which is the same
    (here / "pick.prg").write_text(PROGRAM.format(2), encoding="utf-8")
    status, _, said = run(capsys, "put", "cell1", "other.prg", "pick.prg")
    assert status == 1 and "CL212" in said
    assert cr.names() == ("PICK",) and "DLY 1" in (cr.text("PICK") or "")
    assert run(capsys, "put", "cell1", "pick.prg", "--replace")[0] == 0
    assert "DLY 2" in (cr.text("PICK") or "")
    (here / "PICK").write_text("mine", encoding="utf-8")
    status, _, said = run(capsys, "get", "cell1", "PICK")
    assert status == 1 and "CL211" in said and (here / "PICK").read_text() == "mine"
    assert run(capsys, "get", "cell1", "PICK", "--replace")[0] == 0
    assert "DLY 2" in (here / "PICK").read_text()


WRONG = [
    (("get", "cell1", "NONE"), 1, "CL210"),
    (("get", "cell1", "A", "B", "-o", "one.prg"), 2, "CL216"),
    (("put", "cell1", "none.prg"), 2, "IN001"),
    (("ls", "cell2"), 2, "CN104"),
    (("ls", "http://127.0.0.1"), 2, "CN103"),
    (("ls", "melfa://127.0.0.1:1"), 2, "CN201"),
    (("backup", "cell1", "."), 2, "CL214"),
    (("restore", "cell1", "nowhere"), 2, "CL215"),
    (("monitor", "cell1", "--interval", "0"), 2, "CL222"),
    (("outputs", "cell1", "5=loud"), 2, "CL202"),
    (("outputs", "cell1", "5="), 2, "CL201"),
    (("teach", "cell1", "--now"), 2, "CL231"),
    (("teach", "cell1", "a", "--now", "--on", "3"), 2, "CL230"),
    (("jog", "cell1", "J1", "0"), 2, "CL244"),
    (("jog", "cell1", "J1", "5", "--speed", "0"), 2, "CL243"),
    (("start", "cell1", "--override", "101"), 2, "CL242"),
]


def test_wrong_usage(capsys, cr):
    for arguments, status, code in WRONG:
        found, _, said = run(capsys, *arguments)
        assert (found, code in said) == (status, True), said


COMMANDS = [
    *(("monitor", "cell1"), ("jog", "cell1", "J1", "-5", "--yes"), ("start", "cell1", "--yes")),
    *(("stop", "cell1"), ("reset", "cell1"), ("log", "cell1"), ("motors", "cell1", "off")),
    *(("hand", "cell1", "open", "--yes"), ("inputs", "cell1", "di1"), ("outputs", "cell1", "do1")),
    *(("parameters", "cell1"), ("variables", "cell1", "x"), ("teach", "cell1", "a", "--now")),
    *(("backup", "cell1", "saved"), ("restore", "cell1", "..")),
]


def test_what_a_file_server_cannot_do(capsys, irc5, here):
    for arguments in COMMANDS:
        status, out, _ = run(capsys, *arguments, "--format", "json")
        (finding,) = json.loads(out)["findings"]
        assert (status, finding["code"]) == (2, "CN209")
        assert f"`{arguments[0]}`" in finding["message"] and "FTP" in finding["message"]
        assert list(here.iterdir()) == []


def test_deploying_by_name(capsys, cr, tmp_path):
    (tmp_path / "here" / "pick.prg").write_text(PROGRAM.format(1), encoding="utf-8")
    assert run(capsys, "deploy", "pick.prg", "--to", "cell1", "--history", tmp_path / "b")[0] == 0
    assert cr.names() == ("PICK",)

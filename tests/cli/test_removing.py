"""`rm` on both makers' controllers: what is deleted, and what keeps it from being deleted."""

from __future__ import annotations

import json

import pytest

from assistant.controllers import connect
from tests.cli.test_commands import run
from tests.controllers.abb import ftp_servers

MODULE = "MODULE {0}\n  PROC main()\n    WaitTime 60;\n  ENDPROC\nENDMODULE\n"
PROGRAM = "10 OVRD 50\n20 DLY {}\n30 END\n"


def test_files_of_a_file_server_are_deleted(capsys, irc5):
    (irc5.folder / "seam.mod").write_text(MODULE.format("seam"))
    (irc5.folder / "position.txt").write_text("[1,2,3]\n")
    (irc5.folder / "parts").mkdir()
    assert run(capsys, "rm")[0] == run(capsys, "rm", "cell1")[0] == 2
    status, _, said = run(capsys, "rm", "cell1", "seam.mod")
    assert status == 2 and "CL203" in said and (irc5.folder / "seam.mod").exists()
    for name, code in (("none.mod", "CL210"), ("parts", "DP238"), ("../x", "CN207")):
        status, _, said = run(capsys, "rm", "cell1", "seam.mod", name, "--yes")
        assert status == 1 and code in said, said
        assert (irc5.folder / "seam.mod").exists() and (irc5.folder / "parts").is_dir()
    status, out, said = run(capsys, "rm", "cell1", "SEAM.mod", "seam.mod", "--yes")
    assert (status, out) == (0, "deleted `seam.mod` on cell1\n") and "DP239" in said
    status, out, said = run(capsys, "rm", "cell1", "position.txt", "--yes", "--format", "json")
    assert status == 0 and json.loads(out)["deleted"] == ["position.txt"]
    assert [file.name for file in irc5.folder.iterdir()] == ["parts"]


def test_files_of_a_real_file_server_are_deleted(capsys, tmp_path, here, monkeypatch):
    root = tmp_path / "root"
    root.mkdir()
    with ftp_servers.proftpd(root) as server:
        monkeypatch.setenv("ROBOT_ASSISTANT_PASSWORD", ftp_servers.PASSWORD)
        (server.home / "parts").mkdir()
        (server.home / "parts" / "a.txt").touch()
        address = f"ftp://user@127.0.0.1:{server.port}"
        status, _, said = run(capsys, "rm", address, "parts", "--yes")
        assert status == 1 and "DP238" in said
        status, _, said = run(capsys, "rm", f"{address}/HOME:/parts", "a.txt", "--yes")
        assert status == 0, said
        assert list((server.home / "parts").iterdir()) == []


@pytest.fixture
def three(capsys, cr, tmp_path):
    """A CR controller with three programs, of which PICK calls SUB."""
    for name in ("pick", "place", "sub"):
        text = PROGRAM.format(60) if name != "pick" else '10 CALLP "SUB"\n20 GOTO 10\n'
        (tmp_path / "here" / f"{name}.prg").write_text(text, encoding="utf-8")
    assert run(capsys, "put", "cell1", "pick.prg", "place.prg", "sub.prg")[0] == 0
    return cr


def test_a_program_of_a_cr_is_deleted_unless_it_is_loaded(capsys, three):
    with connect(str(three.address)) as controller:
        controller.load("PICK")
    status, _, said = run(capsys, "rm", "cell1", "PLACE", "PICK", "--yes")
    assert status == 1 and "DP237" in said and "is loaded in slot" in said
    assert run(capsys, "rm", "cell1", "place", "SUB", "--yes")[0] == 0
    assert three.names() == ("PICK",)
    status, _, said = run(capsys, "rm", "cell1", "PLACE", "--yes")
    assert status == 1 and "CL210" in said


@pytest.mark.slow
def test_a_program_of_a_cr_that_runs_or_is_called_is_not_deleted(capsys, three):
    assert run(capsys, "start", "cell1", "PICK", "--no-wait", "--yes")[0] == 0
    status, _, said = run(capsys, "rm", "cell1", "PLACE", "PICK", "SUB", "--yes")
    assert status == 1 and said.count("DP237") == 2, said
    assert "it runs in slot" in said and "`PICK` runs, which uses it" in said
    assert run(capsys, "stop", "cell1")[0] == 0
    assert three.names() == ("PICK", "PLACE", "SUB")


def test_a_module_in_memory_is_not_deleted(capsys, rws):
    (rws.folder / "parts").mkdir()
    for name in ("seam", "other"):
        (rws.folder / f"{name}.mod").write_text(MODULE.format(name))
    with connect(rws.rws_address, password="secret") as controller:
        controller.load("seam.mod")
        status, _, said = run(capsys, "rm", "cell1", "other.mod", "seam.mod", "--yes")
        assert status == 1 and "DP237" in said and "T_ROB1" in said
        status, _, said = run(capsys, "rm", "cell1", "parts", "--yes")
        assert status == 1 and "DP238" in said
        status, _, said = run(capsys, "rm", "cell1", "other.mod", "--yes")
        assert status == 0 and "DP239" not in said, said
        controller.unload("seam")
    assert run(capsys, "rm", "cell1", "seam.mod", "--yes")[0] == 0
    assert [file.name for file in rws.folder.iterdir()] == ["parts"]

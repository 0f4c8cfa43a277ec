"""Files that somebody has protected are not replaced, and what is replaced keeps its rights."""

import stat

import pytest

from assistant.cli import main
from tests.cli.tables import each

MODULE = "MODULE seam\nPROC main()\nWaitTime 1;\nENDPROC\nENDMODULE\n"
PSEUDO = "program p\n\nprocedure main\n  wait 1 s\nend\n"
COMMANDS = {
    "fmt": ("fmt", "seam.mod"),
    "compile": ("compile", "p.pseudo", "-l", "rapid", "-o", "out"),
    "translate": ("translate", "seam.mod", "--to", "melfa-basic-5", "-o", "out"),
    "show": ("show", "seam.mod", "-o", "out/q.pseudo"),
}


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "seam.mod").write_text(MODULE)
    (tmp_path / "p.pseudo").write_text(PSEUDO)
    (tmp_path / "out").mkdir()
    return tmp_path


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as ended:
        main(list(arguments))
    return ended.value.code, capsys.readouterr()


def written(here, command, capsys):
    """What it writes, from a run of its own."""
    run(capsys, *COMMANDS[command])
    found = [file for file in (here / "out").iterdir() if file.is_file()]
    return here / "seam.mod" if command == "fmt" else found[0]


def test_a_protected_file_is_not_replaced_and_what_is_replaced_keeps_its_rights(here, capsys):
    def check(command):
        target = written(here, command, capsys)
        target.write_text(MODULE)
        target.chmod(0o444)
        code, said = run(capsys, *COMMANDS[command])
        assert code == 2 and "CO201" in said.err and "it is read-only" in said.err, said.err
        assert target.read_text() == MODULE and stat.S_IMODE(target.stat().st_mode) == 0o444
        assert not list(here.rglob(".robot-assistant-*"))
        target.chmod(0o640)
        run(capsys, *COMMANDS[command], *(["--overwrite"] if command == "compile" else []))
        assert target.read_text() != MODULE and stat.S_IMODE(target.stat().st_mode) == 0o640
        if command != "fmt":
            target.unlink()

    each(COMMANDS, check)


def test_a_folder_that_cannot_be_made_is_told_as_that(here, capsys):
    for folder in ("p.pseudo/x", "/proc/closed/x"):
        for command in ("compile", "translate"):
            *words, _ = COMMANDS[command]
            code, said = run(capsys, *words, folder)
            assert code == 2 and "CO201" in said.err and "CL901" not in said.err, said.err

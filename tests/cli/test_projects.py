"""`init`, `build` and `check` without files, as a new user types them."""

from __future__ import annotations

import json

import pytest

from assistant.cli import main
from tests.project.conftest import CELLS, pseudo


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as ended:
        main(list(words))
    out, err = capsys.readouterr()
    assert "Traceback" not in out + err
    return int(ended.value.code or 0), out, err


@pytest.fixture
def started(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, out, _ = run(capsys, "init")
    assert status == 0
    assert "wrote assistant.toml\n" in out
    assert out.endswith("next, robot-assistant build, then robot-assistant deploy\n")
    return tmp_path


def test_init_build_deploy(capsys, started):
    assert run(capsys, "build")[:2][0] == 0
    status, out, _ = run(capsys, "deploy")
    assert (status, "1 installed and verified" in out) == (0, True)
    assert "127.0.0.1" not in out  # whose port is another one each time
    status, out, _ = run(capsys, "ls", "cell1")
    assert (status, "plate.mod" in out) == (0, True)


def test_build_tells_programs_what_it_did(capsys, started):
    status, out, _ = run(capsys, "build", "--format", "json", "--jobs", "1")
    answer = json.loads(out)
    assert (status, answer["ok"]) == (0, True)
    (program,) = answer["programs"]
    assert program["state"] == "built"
    assert program["files"] == ["build/cell1/plate.mod"]
    assert "proven" in program["proof"][0]
    (program,) = json.loads(run(capsys, "build", "--format", "json")[1])["programs"]
    assert (program["state"], program["proof"]) == ("unchanged", [])


def test_a_break_in_a_source_is_found_by_both(capsys, started):
    (started / "drawings/plate.process.toml").write_text("speed = fast\n")
    for command in ("build", "check"):
        status, out, _ = run(capsys, command, "--format", "json")
        assert status == 2
        assert "CT301" in [finding["code"] for finding in json.loads(out)["findings"]]


def test_check_ends_with_its_status(capsys, started):
    status, out, _ = run(capsys, "check")
    assert (status, out) == (0, "1 program checked, 1 finding\n")
    text = (started / "assistant.toml").read_text()
    (started / "assistant.toml").write_text(f'{text}[severity]\nCT206 = "warning"\n')
    assert run(capsys, "check")[0] == 1


def test_options_of_files_say_nothing_of_a_project(capsys, started):
    for words in (("check", "--robot", "rv-2aj"), ("check", "--unit", "mm")):
        status, _, err = run(capsys, *words)
        assert (status, "PR206" in err) == (2, True), words


def test_what_is_wrong_in_the_file_is_shown_with_its_line(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for command in ("check", "build"):
        status, _, err = run(capsys, command)
        assert (status, "PR101" in err) == (2, True), command
    (tmp_path / "waiting.pseudo").write_text(pseudo())
    (tmp_path / "assistant.toml").write_text(
        f'{CELLS}[programs.a]\nsource = "waiting.pseudo"\n[targets.cell1]\nprogramms = ["a"]\n'
    )
    status, _, err = run(capsys, "build")
    assert status == 2
    assert 'programms = ["a"]' in err
    assert "= write `programs`" in err

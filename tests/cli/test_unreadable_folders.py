"""A folder that may not be read is told of as that, not as one without programs."""

import contextlib
import os

import pytest

from assistant.cli import main

MODULE = "MODULE seam\nPROC main()\nWaitTime 1;\nENDPROC\nENDMODULE\n"
NOBODY = 65534


@contextlib.contextmanager
def as_nobody():
    """The administrator may read every folder."""
    if os.getuid():
        yield
        return
    os.seteuid(NOBODY)
    try:
        yield
    finally:
        os.seteuid(0)


@pytest.fixture
def closed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for folder in (tmp_path, *tmp_path.parents[:2]):
        if not os.getuid():
            folder.chmod(0o755)
    folder = tmp_path / "closed"
    folder.mkdir()
    (folder / "seam.mod").write_text(MODULE)
    yield folder
    folder.chmod(0o755)


COMMANDS = (
    ("check", "closed"),
    ("fmt", "--check", "closed"),
    ("coverage", "closed"),
    ("translate", "closed", "--to", "melfa-basic-5"),
    ("plan", "closed", "--to", "melfa://127.0.0.1:1"),
)


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such rights")
def test_a_folder_that_may_not_be_read(closed, capsys):
    for command in COMMANDS:
        for name in ("closed", "nowhere"):  # what it needs is loaded before it runs as nobody
            with pytest.raises(SystemExit):
                main([name if word == "closed" else word for word in command])
            capsys.readouterr()
    closed.chmod(0)
    for command in COMMANDS:
        with as_nobody(), pytest.raises(SystemExit) as ended:
            main(list(command))
        said = capsys.readouterr()
        assert ended.value.code == 2 and "IN003" in said.err and "`closed`" in said.err, said.err
        assert "no robot programs" not in said.err

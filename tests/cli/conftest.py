"""Virtual controllers that a project names `cell1`, with the working folder beside its file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from assistant.virtual.cr import VirtualCr
from assistant.virtual.irc5 import VirtualIrc5


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder, below the folder of the project."""
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def irc5(tmp_path: Path, here: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[VirtualIrc5]:
    """Behind its file server."""
    with VirtualIrc5(tmp_path / "home", password="secret", rws=None, rwss=None) as controller:
        monkeypatch.setenv("ROBOT_ASSISTANT_CELL1_PASSWORD", "secret")
        table = f'[controllers]\ncell1 = "{controller.address}"\n'
        (tmp_path / "assistant.toml").write_text(table, encoding="utf-8")
        yield controller


@pytest.fixture
def cr(tmp_path: Path, here: Path) -> Iterator[VirtualCr]:
    with VirtualCr() as controller:
        table = f'address = "{controller.address}"\nrobot = "rv-2aj"\ntimeout = 5\n'
        (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
        yield controller


@pytest.fixture
def rws(tmp_path: Path, here: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[VirtualIrc5]:
    """An IRC5 behind Robot Web Services 1.0, which runs ten times as fast as a real one."""
    with VirtualIrc5(tmp_path / "home", password="secret", rate=10.0, rwss=None) as controller:
        monkeypatch.setenv("ROBOT_ASSISTANT_CELL1_PASSWORD", "secret")
        table = f'address = "{controller.rws_address}"\nrobot = "irb1200-7-0.7"\ntimeout = 5\n'
        (tmp_path / "assistant.toml").write_text(f"[controllers.cell1]\n{table}", encoding="utf-8")
        yield controller

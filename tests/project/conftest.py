"""Small projects to read, build and deploy."""

from __future__ import annotations

from pathlib import Path

import pytest

CELLS = """
[controllers.cell1]
address = "virtual:irc5"
robot = "irb1200-7-0.7"

[controllers.cell2]
address = "virtual:cr"
robot = "rv-2aj"
"""


def module(name: str, said: str = "") -> str:
    """A program that is ready for an IRC5."""
    return (
        f'MODULE {name}\n  PROC go_{name}()\n    TPWrite "{said or name}";\n  ENDPROC\nENDMODULE\n'
    )


def pseudo(seconds: float = 0.5) -> str:
    """A program that any controller can be given."""
    return f"program waiting\n\nprocedure main\n  wait {seconds} s\nend\n"


class Home:
    """A folder with an assistant.toml, which is the working folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def put(self, name: str, text: str) -> Path:
        file = self.folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
        return file

    def states(self, text: str, name: str = "assistant.toml") -> Path:
        return self.put(name, CELLS + text)

    def built(self, target: str = "cell1") -> dict[str, bytes]:
        """The files in the folder of a target."""
        folder = self.folder / "build" / target
        return {file.name: file.read_bytes() for file in folder.iterdir()}


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Home:
    monkeypatch.chdir(tmp_path)
    return Home(tmp_path)

"""Which files a controller takes: those of its language, and of older versions of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from assistant.base.diagnostics import Refused
from assistant.deploy.plan import file_findings, gathered


@dataclass
class Stated:
    """A controller that says what it takes, and takes any text."""

    languages: tuple[str, ...]
    address: str = "melfa:cell"
    lists: tuple[str, ...] = ()

    def check_text(self, name: str, data: bytes) -> None:
        pass


IV_TEXT = b"10 MOV P1\n20 END\nP1=(+400.00,+0.00,+450.00,+180.00,+0.00,+180.00)(7,0)\n"
V_TEXT = b"1 M1=1\n2 Mov P1\n3 End\nP1=(+400.00,+0.00,+450.00,+180.00,+0.00,+180.00)(7,0)\n"
VI_TEXT = b"Function Main\nMov P1\nFEnd\nP1=(400,0,450,180,0,180)(7,0)\n"


@pytest.mark.parametrize(
    ("level", "name", "data", "taken"),
    [
        (6, "A.prg", IV_TEXT, True),
        (6, "A.prg", V_TEXT, True),
        (6, "A.prg", VI_TEXT, True),
        (6, "A.mb6", V_TEXT, True),
        (6, "A.mb4", IV_TEXT, True),
        (5, "A.prg", IV_TEXT, True),
        (5, "A.prg", V_TEXT, True),
        (5, "A.prg", VI_TEXT, False),
        (4, "A.prg", V_TEXT, False),
        (4, "A.prg", IV_TEXT, True),
        (6, "A.prg", b"1 ' robot-assistant: melfa-basic-5\n" + V_TEXT, True),
        (5, "A.prg", b"1 ' robot-assistant: melfa-basic-6\n" + V_TEXT, False),
        (6, "A.prg", b"MODULE A\nPROC main()\nENDPROC\nENDMODULE\n", False),
    ],
)
def test_a_controller_takes_programs_of_older_versions(level, name, data, taken, tmp_path):
    controller: Any = Stated((f"melfa-basic-{level}",))
    (found,) = file_findings({name: data}, {name: "A"}, controller).values()
    assert any(finding.code == "DP103" for finding in found) != taken
    (tmp_path / name).write_bytes(data)
    assert _counts(tmp_path, controller) == taken


def _counts(folder: Path, controller: Any) -> bool:
    """True if the file of a folder is a program for a controller."""
    try:
        return bool(gathered([folder], controller))
    except Refused:
        return False

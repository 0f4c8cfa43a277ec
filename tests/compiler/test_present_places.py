"""Parts of the present position in a language that has parts of data alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.compiler.motion_proof import Proving
from assistant.compiler.translation import translate

PLACES = "P1=(400,0,400,180,0,180)(7,0)\nP2=(400,100,300,180,0,90)(7,0)\n"


@pytest.mark.parametrize(
    "body",
    [
        "Mvs P1\nM1=P_Curr.X+P_Curr.Z\nP2.Z=M1-500\nMvs P2",
        "Mvs P1\nP2.C=P_Curr.C\nP2.C=P2.C-0.3\nMvs P2",
        "Mvs P1\nWhile P_Curr.Z>350\nMvs ,5\nP1.Z=P1.Z-20\nMvs P1\nWEnd",
        "Mvs P1\nIf P_Fbc.Z>399 Then Mvs P2",
    ],
)
def test_parts_of_the_present_position(body: str, tmp_path: Path) -> None:
    source = tmp_path / "JOB.prg"
    source.write_text(f"Tool P_NTool\nBase P_NBase\n{body}\nEnd\n{PLACES}")
    found = translate(source, to="rapid", language="melfa-basic-5", proving=Proving(seconds=2))
    assert found.ok, found.findings
    assert found.motion is not None
    assert found.motion.holds
    assert ("MB257" in {f.code for f in found.findings}) is ("P_Fbc" in body)
    assert "here_1:=CRobT(" in next(iter(found.files.values())).decode()

"""A text whose damage leaves no doubt is translated, with warnings that stay errors of a check."""

from __future__ import annotations

from pathlib import Path

from assistant.base.diagnostics import Severity
from assistant.compiler.checker import check_files
from assistant.compiler.motion_proof import Proving
from assistant.compiler.translation import translate

TEXT = "Mvs P1 ‘to the part\nMvs P1,–50\nEnd\nP1=(400,0,400,180,0,180)(7,0)\n"


def test_typographic_marks_are_read_as_they_are_meant(tmp_path: Path) -> None:
    source = tmp_path / "JOB.prg"
    source.write_text(TEXT, encoding="utf-8")
    found = translate(source, to="rapid", language="melfa-basic-5", proving=Proving())
    assert found.ok, found.findings
    told = [finding for finding in found.whole if finding.code == "MB003"]
    assert [(f.line, f.severity) for f in told] == [(1, Severity.WARNING), (2, Severity.WARNING)]
    (data,) = found.files.values()
    assert b"to the part" in data
    checked = check_files([str(source)], language="melfa-basic-5")
    assert sum(f.code == "MB003" and f.severity is Severity.ERROR for f in checked.findings) == 2

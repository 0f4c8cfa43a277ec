"""Rules over modules with syntax errors: sound lines have findings, none follows from damage."""

from __future__ import annotations

import pytest

from assistant.base.source_text import SourceText
from assistant.compiler.checker import check_text

ROWS: dict[str, tuple[str, list[str]]] = {
    "a call elsewhere": ("VAR num x;\nx := 1 +;\nWaitTime 0;\nGripp;", ["RA103 4", "RA401 6"]),
    "a routine that is damaged": ("Gripp;\nENDPROC\nPROC Gripp(num)\nWaitTime 1;", ["RA103 5"]),
    "a name that is parted": ("VAR n um x;\nWaitTime 1;\nx := 1;", ["RA103 3"]),
    "a label that is parted": ("GOTO again;\nWaitTime 1;\nag ain:", ["RA101 5"]),
    "a use that is damaged": ("VAR num x;\nWaitTime 1;\nWaitTime x+;", ["RA103 5"]),
}


@pytest.mark.parametrize(("text", "expected"), ROWS.values(), ids=ROWS)
def test_damage(text: str, expected: list[str]) -> None:
    module = f"MODULE a\nPROC main()\n{text}\nENDPROC\nENDMODULE\n"
    findings = check_text(SourceText(module, "a.mod"), language="rapid").findings
    assert [f"{f.code} {f.line}" for f in findings] == expected

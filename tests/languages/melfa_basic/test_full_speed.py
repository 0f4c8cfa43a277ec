"""Translation reports moves at full speed that no `Spd` asks for."""

from __future__ import annotations

import pytest

from assistant.base.diagnostics import Severity
from assistant.base.source_text import SourceText
from assistant.compiler import translate
from assistant.compiler.loader import load_text
from tests.tables import every_row

PLACES = """P1=(+310,+0,+400,+180,+0,+180)(7,0)
P2=(+330,+0,+420,+180,+0,+180)(7,0)
P3=(+350,+9,+420,+180,+0,+180)(7,0)
"""
PROGRAMS = {
    "without Spd": (("Mvs P1", "Mvs P2"), [3, 4]),
    "an arc": (("Mov P1", "Dly 1", "Mvr P1,P2,P3"), [5]),
    "before the first Spd": (("Mvs P1", "Spd 100", "Mvs P2"), [3]),
    "asked for": (("Spd M_NSpd", "Mvs P1"), []),
    "asked for later": (("Mvs P1", "Spd 100", "Mvs P2", "Spd M_NSpd", "Mvs P1"), [3]),
    "joints alone": (("Mov P1", "Mov P2"), []),
    "with Spd": (("Spd 80", "Mvs P1"), []),
    "on one of two ways": (("If M_In(1)=1 Then Spd 100", "Mvs P1"), [4]),
    "on no way": (("If M_In(1)=1 Then Spd 100 Else Spd 50", "Mvs P1"), []),
    "around the first Spd": (
        ("If M_In(1)=1 Then GoTo *A", "Spd M_NSpd", "Mvs P1", "*A", "Mvs P2"),
        [7],
    ),
    "set by a subroutine": (("GoSub *S", "Mvs P1", "End", "*S", "Spd 70", "Return"), []),
    "set by a subroutine at times": (
        ("GoSub *S", "Mvs P1", "End", "*S", "If M_In(1)=1 Then Return", "Spd 70", "Return"),
        [4],
    ),
    "in a subroutine": (("GoSub *S", "Spd 70", "GoSub *S", "End", "*S", "Mvs P1", "Return"), [8]),
    "to a computed position": (("Mvs P1+(0,0,5,0,0,30)", "Mvs P1*P2"), [3, 4]),
    "in a condition": (("If M_In(1)=1 Then Mvs P1", "Spd 20", "Mvs P2"), [3]),
    "a long run": ([f"Mvs P{1 + k % 3}" for k in range(12)], list(range(3, 15))),
}


@every_row("name", list(PROGRAMS))
def test_implicit_full_speed_is_told(name: str) -> None:
    lines, expected = PROGRAMS[name]
    code = ("Tool P_NTool", "Base P_NBase", *lines, "End")
    text = "\n".join(f"{at} {line}" for at, line in enumerate(code, 1))
    made = translate(
        load_text(SourceText(f"{text}\n{PLACES}"), language="melfa-basic-5"), to="rapid"
    )
    found = [one for one in made.findings if one.code == "MB294"]
    assert bool(found) == bool(expected)
    assert all(one.severity is Severity.WARNING and "Spd" in one.cure for one in found)
    rows = [row for row in made.rows if any(one.code == "MB294" for one in row.reasons)]
    assert len(rows) in (0, 1, len(expected))
    assert [row.place.line for row in rows][:1] == expected[:1]


@pytest.mark.parametrize(
    ("main", "expected"),
    [
        ("Mvs P1", [2]),
        ("Spd 50\nMvs P1", []),
        ("fnSet(1)\nMvs P1", []),
        ("fnMove(1)\nSpd 50\nMvs P1", [10]),
        ("fnMay(1)\nMvs P1", [3]),
        ("M1=fnMay(1)\nIf M_In(1)=1 Then Spd 9\nMvs P1", [4]),
    ],
)
def test_functions_are_followed(main: str, expected: list[int]) -> None:
    text = (
        f"Function Main\n{main}\nFEnd\n"
        "Function V fnSet(ByVal M2)\nSpd 70\nFEnd\n"
        "Function V fnMove(ByVal M2)\nMvs P2\nFEnd\n"
        "Function M fnMay(ByVal M2)\nIf M2>1 Then Spd 70\nfnMay=1\nFEnd\n"
    )
    made = translate(load_text(SourceText(f"{text}{PLACES}"), language="melfa-basic-6"), to="rapid")
    rows = [row for row in made.rows if any(one.code == "MB294" for one in row.reasons)]
    assert [row.place.line for row in rows] == expected

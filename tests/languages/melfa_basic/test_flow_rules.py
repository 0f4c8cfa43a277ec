"""Rules of blocks, jumps and subroutines."""

from __future__ import annotations

from assistant import languages
from tests.languages.melfa_basic.ruled import Row, found
from tests.tables import every_row

BLOCKS: dict[str, Row] = {
    "For without Next": ("For M1=1 To 3\nDly 1", ["MB105 1:1"]),
    "Next without For": ("Dly 1\nNext", ["MB105 2:1"]),
    "While without WEnd": ("While M_In(1)=1", ["MB105 1:1"]),
    "If without EndIf": ("If M_In(1)=1 Then\nDly 1", ["MB105 1:1"]),
    "Select without End Select": ("Select M_In(1)\nCase 1\nDly 1", ["MB105 1:1"]),
    "Else without If": ("Else", ["MB105 1:1"]),
    "Case without Select": ("Case 1", ["MB105 1:1"]),
    "blocks that cross": (
        "For M1=1 To 3\nIf M_In(1)=1 Then\nNext\nEndIf",
        ["MB131 3:1"],
    ),
    "an inner block without end": (
        "For M1=1 To 3\nWhile M_In(1)=1\nDly 1\nNext",
        ["MB105 2:1"],
    ),
    "blocks in order": ("For M1=1 To 3\nIf M_In(1)=1 Then\nDly 1\nEndIf\nNext", []),
    "Next of two loops": ("For M1=1 To 3\nFor M2=1 To 3\nDly 1\nNext M2,M1", []),
    "Next of two loops in the wrong order": (
        "For M1=1 To 3\nFor M2=1 To 3\nDly 1\nNext M1,M2",
        ["MB146 4:6", "MB146 4:9"],
    ),
    "Next of another loop": ("For M1=1 To 3\nDly 1\nNext M2", ["MB146 3:6"]),
    "17 loops": (
        "\n".join(["While M_In(1)=1"] * 17 + ["WEnd"] * 17),
        ["MB132 17:1"],
    ),
    "16 loops": ("\n".join(["While M_In(1)=1"] * 16 + ["WEnd"] * 16), []),
    "9 branches": (
        "\n".join(["If M_In(1)=1 Then"] * 9 + ["EndIf"] * 9),
        ["MB132 9:1"],
    ),
    "8 branches": ("\n".join(["If M_In(1)=1 Then"] * 8 + ["EndIf"] * 8), []),
    "a Select in a Select": (
        "Select M_In(1)\nCase 1\nSelect M_In(2)\nCase 1\nDly 1\nEnd Select\nEnd Select",
        [],
    ),
    "one variable for two loops": (
        "For M1=1 To 3\nFor M1=1 To 3\nDly 1\nNext\nNext",
        ["MB145 2:5"],
    ),
    "a loop variable that is set": (
        "For M1=1 To 3\nIf M_In(1)=1 Then M1=3\nNext",
        ["MB144 2:19"],
    ),
    "a loop variable that is set behind": ("For M1=1 To 3\nDly 1\nNext\nM1=3", []),
    "Else behind Else": (
        "If M_In(1)=1 Then\nDly 1\nElse\nDly 2\nElse\nDly 3\nEndIf",
        ["MB147 5:1"],
    ),
    "Default twice": (
        "Select M_In(1)\nCase 1\nDly 1\nDefault\nDly 2\nDefault\nDly 3\nEnd Select",
        ["MB147 6:1"],
    ),
}


@every_row(("text", "expected"), BLOCKS)
def test_blocks(text: str, expected: list[str]) -> None:
    assert found(5, text) == expected


WAYS: dict[str, Row] = {
    "into a loop": (
        "If M_In(1)=1 Then GoTo *X\nFor M1=1 To 3\n*X\nDly 1\nNext",
        ["MB134 1:24"],
    ),
    "within a loop": ("For M1=1 To 3\n*X\nIf M_In(1)=1 Then GoTo *X\nNext", []),
    "out of a loop": ("For M1=1 To 3\nIf M_In(1)=1 Then GoTo *X\nNext\n*X\nDly 1", []),
    "into a branch": (
        "If M_In(1)=1 Then\n*X\nDly 1\nEndIf\nIf M_In(2)=1 Then *X",
        ["MB134 5:19"],
    ),
    "into the other branch": (
        "If M_In(1)=1 Then\nDly 1\nElse\n*X\nDly 2\nIf M_In(3)=1 Then *X\nEndIf",
        [],
    ),
    "a subroutine": ("GoSub *S\nEnd\n*S\nDly 1\nReturn", []),
    "a subroutine that is run into": ("GoSub *S\n*S\nDly 1\nReturn", ["MB135 2:1"]),
    "a subroutine behind a way that may end": (
        "GoSub *S\nIf M_In(1)=1 Then End\n*S\nDly 1\nReturn",
        ["MB135 3:1"],
    ),
    "a subroutine behind branches that both leave": (
        "*A\nGoSub *S\nIf M_In(1)=1 Then *A Else *B\n*S\nDly 1\nReturn\n*B",
        [],
    ),
    "a jump into a subroutine": (
        "GoSub *S\nIf M_In(1)=1 Then GoTo *S\nEnd\n*S\nDly 1\nReturn",
        ["MB136 2:24"],
    ),
    "a subroutine that jumps to its own begin": (
        "GoSub *S\nEnd\n*S\nDly 1\nIf M_In(1)=1 Then GoTo *S\nReturn",
        [],
    ),
    "Return alone": ("Dly 1\nReturn", ["MB137 2:1"]),
    "no Return": ("GoSub *S\nEnd\n*S\nDly 1\nEnd", ["MB138 3:1"]),
    "a stop for good": ("GoSub *S\nEnd\n*S\nDly 1\nWhile 1\nHlt\nWEnd\nReturn", []),
    "a stop for good in a subroutine of a subroutine": (
        "GoSub *S\nEnd\n*S\nGoSub *T\nDly 1\nReturn\n*T\n*U\nHlt\nGoTo *U",
        [],
    ),
    "a loop that is no stop": (
        "GoSub *S\nEnd\n*S\nWhile 1\nDly 1\nWEnd\nReturn",
        ["MB138 3:1"],
    ),
    "a stop, and then the caller once more": (
        "*M\nGoSub *S\nEnd\n*S\nHlt\nGoTo *M",
        ["MB138 4:1"],
    ),
    "a stop, and then the end": ("GoSub *S\nEnd\n*S\nHlt\nEnd", ["MB138 3:1"]),
    "a Return on one way": ("GoSub *S\nEnd\n*S\nIf M_In(1)=1 Then Return\nGoTo *S", []),
    "an interrupt with a plain Return": (
        "Def Act 1,M_In(1)=1 GoSub *S\nAct 1=1\nDly 9\nEnd\n*S\nDly 1\nReturn",
        ["MB139 7:1"],
    ),
    "an interrupt that returns": (
        "Def Act 1,M_In(1)=1 GoSub *S\nAct 1=1\nDly 9\nEnd\n*S\nDly 1\nReturn 1",
        [],
    ),
    "an interrupt that jumps away": (
        "Def Act 1,M_In(1)=1 GoTo *S\nAct 1=1\nDly 9\nEnd\n*S\nDly 1\nEnd",
        [],
    ),
    "a number behind Return": ("GoSub *S\nEnd\n*S\nDly 1\nReturn 1", ["MB140 5:1"]),
    "behind End": ("Dly 1\nEnd\nDly 2\nDly 3", ["MB141 3:1"]),
    "behind End at a label": ("*X\nIf M_In(1)=1 Then *Y\nEnd\n*Y\nDly 2\nGoTo *X", []),
    "behind an endless loop": ("While 1\nDly 1\nWEnd\nDly 2", ["MB141 4:1"]),
    "behind a loop that is left": ("While 1\nIf M_In(1)=1 Then Break\nDly 1\nWEnd\nDly 2", []),
    "Break leaves the If alone": (
        "While 1\nIf M_In(1)=1 Then\nBreak\nEndIf\nWEnd\nDly 2",
        ["MB141 6:1"],
    ),
    "Break leaves the inner loop alone": (
        "While 1\nFor M1=1 To 9\nIf M_In(1)=1 Then Break\nNext M1\nWEnd\nDly 2",
        ["MB141 6:1"],
    ),
    "behind a Break": ("For M1=1 To 9\nBreak\nDly 1\nNext M1\nDly 2", ["MB141 3:1"]),
    "in front of the first Case": (
        "Select M_In(1)\nDly 1\nCase 1\nDly 2\nEnd Select",
        ["MB141 2:1"],
    ),
    "a habit of ends": ("*X\nDly 1\nGoTo *X\nEnd", []),
    "behind branches that both leave": (
        "*X\nIf M_In(1)=1 Then\nGoTo *X\nElse\nEnd\nEndIf\nDly 1",
        ["MB141 7:1"],
    ),
}


@every_row(("text", "expected"), WAYS)
def test_ways_through_a_program(text: str, expected: list[str]) -> None:
    assert found(5, text) == expected


def test_a_subroutine_without_a_label_has_the_name_of_its_step() -> None:
    language = languages.get("melfa-basic-4")
    text = "10 GOSUB 30\n20 END\n30 DLY 30\n40 END\n"
    (finding,) = (f for f in language.check([language.parse(text)]) if f.code == "MB138")
    assert finding.message == "the subroutine `30` never comes to a `Return`"
    assert (finding.line, finding.column) == (3, 4)

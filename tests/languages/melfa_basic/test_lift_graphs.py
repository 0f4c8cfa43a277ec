"""Control flow of any shape is read, whatever leads where: `lift` never raises."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages
from tests.examples import drawn

# PX and PA have no values: what needs them stays as its text, under the settings of its way
POSITIONS = "PT=(0,0,100,0,0,0)(0,0)\nP1=(300,0,300,180,0,180)(7,0)\n"
LEFT_IN_TWO_WAYS = {
    "a way back to a subroutine below a comment": """\
GoSub *SUB
End
'
*SUB
Tool PX
For M1=1 To 4
Next M1
If M_Svo=0 Then *SUB
Mov PX
""",
    "an early return, and a tool in a branch": """\
Mvs PA(1)
GoSub *SUB
If M_In(3)=1 Then Return
If M_In(1)=1 Then
Tool PT
EndIf
Return
*SUB
""",
    "a call of itself below a comment": """\
End
'
*SUB
GoSub *OTHER
If M1 GoTo *SUB
GoSub *SUB
Print#"";P_Curr
""",
}


def joined(several: list[list[str]]) -> list[str]:
    return [line for lines in several for line in lines]


labels = st.sampled_from(["*A", "*B", "*C", "*D"])
conditions = st.sampled_from(["M1<3", "M_In(1)=1", "M_Svo=0"])
leaving = st.one_of(
    st.sampled_from(["Return", "End", "Break"]),
    labels.map("GoTo {}".format),
    labels.map("GoSub {}".format),
)
plain = st.sampled_from(
    [
        "Tool PT",
        "Tool P_NTool",
        "Base PT",
        "Spd M1",
        "Cnt 1",
        "Mvs P1",
        "Mov PA(1)",
        "Tool PX",
        "M1=M_RSpd",
        "'",
    ]
)
single = st.one_of(
    plain,
    labels,
    leaving,
    st.builds("If {} Then {}".format, conditions, st.one_of(leaving, labels, plain)),
    st.builds("If {} Then {} Else {}".format, conditions, leaving, st.one_of(leaving, plain)),
    st.builds("On M1 {} {},{}".format, st.sampled_from(["GoTo", "GoSub"]), labels, labels),
    st.builds("Def Act 1,M_In(1)=1 {} {}".format, st.sampled_from(["GoTo", "GoSub"]), labels),
)


def blocks(inner: st.SearchStrategy[list[str]]) -> st.SearchStrategy[list[str]]:
    bodies = st.lists(inner, max_size=3).map(joined)
    return st.one_of(
        bodies.map(lambda body: ["For M1=1 To 3", *body, "Next M1"]),
        st.builds(lambda test, body: [f"While {test}", *body, "WEnd"], conditions, bodies),
        st.builds(
            lambda test, body, other: [f"If {test} Then", *body, "Else", *other, "EndIf"],
            conditions,
            bodies,
            bodies,
        ),
        st.builds(
            lambda body, other: ["Select M1", "Case 1", *body, "Default", *other, "End Select"],
            bodies,
            bodies,
        ),
    )


lines = st.recursive(single.map(lambda line: [line]), blocks, max_leaves=4)
bodies = st.lists(lines, max_size=5).map(joined)
ends = st.sampled_from([[], ["End"], ["End", "'"], ["Return"], ["Return", "'"]])
routines = st.builds(lambda label, body, end: [label, *body, *end], labels, bodies, ends)
graphs = st.builds(
    lambda main, end, several: [*main, *end, *joined(several)],
    bodies,
    ends,
    st.lists(routines, min_size=1, max_size=3, unique_by=lambda routine: routine[0]),
)
"""Lines of a program, then subroutines that end, run on into the next, or go back and forth."""


def reads(lines: list[str]) -> None:
    language = languages.get("melfa-basic-5")
    code = "".join(f"{step} {line}\n" for step, line in enumerate(lines, 1))
    tree = language.parse(code + POSITIONS)
    language.lift(tree)
    language.check([tree])


@pytest.mark.parametrize("code", LEFT_IN_TWO_WAYS.values(), ids=list(LEFT_IN_TWO_WAYS))
def test_where_a_subroutine_ends_the_next_one_is_not_entered(code: str) -> None:
    reads(code.splitlines())


@settings(max_examples=drawn(80))
@given(graphs)
def test_any_flow_is_read(lines: list[str]) -> None:
    reads(lines)


@pytest.mark.slow
@settings(max_examples=drawn(1000))
@given(graphs)
def test_many_flows_are_read(lines: list[str]) -> None:
    reads(lines)

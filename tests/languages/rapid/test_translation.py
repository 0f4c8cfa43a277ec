"""Programs to RAPID and back: adapted, built, printed, parsed, lifted, compared."""

from __future__ import annotations

import math
import re
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.diagnostics import Severity
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.comparison import Tolerance, compare
from assistant.program.geometry import Pose, Target, Tool
from assistant.program.motion import FINE, FULL_BLEND, MAXIMUM_SPEED, Blend, Kind, Path, Speed
from assistant.program.passes.procedure_forms import units
from assistant.program.program import Procedure, Program, Signal, Variable
from tests.examples import drawn
from tests.languages.rapid.programs import full, path
from tests.tables import every_row

RAPID = languages.get("rapid")
PRINTED = Tolerance(RAPID.precision.position * 2, RAPID.precision.angle, RAPID.precision.number)


TYPES = ("RA4", "RA215")
"""Codes of rules of types, calls and constants, which random programs do not keep."""


def proved(program: Program, most_targets: int | None = None) -> Program:
    """The adapted program, after its text was read back and found to say the same."""
    adapted = RAPID.adapt(program, most_targets=most_targets)
    assert not [f for f in adapted.findings if f.severity is Severity.ERROR], adapted.findings
    again = RAPID.adapt(adapted.program, most_targets=most_targets).program
    assert not compare(adapted.program, again).mismatches
    trees = []
    for unit in (None, *units(adapted.program)):
        built = RAPID.build(adapted.program, unit=unit)
        text = RAPID.render(built)
        assert text.isascii()
        assert "nan" not in re.sub(r'!.*|"[^"]*"', "", text).lower().replace("nan_", "")
        read = RAPID.parse(text)
        assert not read.findings, read.findings
        assert read == built
        assert RAPID.encode(read) == text.encode("ascii")
        trees.append(read)
    said = [f for f in RAPID.check(trees) if f.severity is not Severity.INFO]
    assert all(f.code.startswith(TYPES) for f in said), said
    lifted = RAPID.lift(trees)
    assert not compare(adapted.program, lifted, PRINTED).mismatches
    return adapted.program


def main(*body: p.Statement, **parts: object) -> Program:
    return replace(Program("cell", (Procedure("main", body),)), **parts)  # type: ignore[arg-type]


def text(program: Program, unit: str | None = None) -> str:
    return RAPID.render(RAPID.build(RAPID.adapt(program).program, unit=unit))


def codes(program: Program) -> list[str]:
    return [f.code for f in RAPID.adapt(program).findings]


@pytest.mark.parametrize("most", [None, 20, 7, 1])
def test_everything_comes_back(most: int | None) -> None:
    proved(full(), most)


def test_a_long_path_is_spread_over_modules_that_are_loaded() -> None:
    seam = path("seam", 45, arcs=True)
    program = proved(main(p.Follow(seam)), 10)
    pieces = [q for q in program.procedures if q.unit]
    rows = [s_.path for q in pieces for s_ in q.body if isinstance(s_, p.Follow)]
    assert sum(len(r) for r in rows) == 45
    assert all(len(r) <= 10 and r.kinds[0] != Kind.END and r.kinds[-1] != Kind.VIA for r in rows)
    assert np.array_equal(np.concatenate([r.positions for r in rows]), seam.positions)
    shown = RAPID.render(RAPID.build(program))
    assert 'Load\\Dynamic,"HOME:/seam_unit1.mod";' in shown
    assert '%"seam_part1"%;' in shown
    assert 'UnLoad "HOME:/seam_unit1.mod";' in shown
    assert RAPID.file_name(program, "seam_unit1") == "seam_unit1.mod"


def test_predefined_names_only_where_they_fit() -> None:
    moves = [
        p.Move("linear", e.Name("a"), p.Motion(Speed(v), Blend(z)))
        for v, z in ((150.0, 100.0), (147.0, 3.0), (25.0, 2.5), (7000.0, 0.3))
    ]
    program = main(*moves, targets={"a": Target(Pose())})
    shown = text(program)
    for line in (
        "MoveL a,v150,z100,tool0;",
        "MoveL a,speed_147,zone_3,tool0;",
        "MoveL a,speed_25,zone_2_5,tool0;",
        "MoveL a,v7000,z0,tool0;",
        "CONST speeddata speed_147:=[147,500,5000,1000];",
        "CONST zonedata zone_3:=[FALSE,3,4.5,4.5,0.45,4.5,0.45];",
    ):
        assert line in shown
    assert ",z3," not in shown
    proved(program)


def test_what_rapid_has_not_is_changed_and_said() -> None:
    program = main(
        p.Move("joint", e.Name("a"), p.Motion(replace(MAXIMUM_SPEED, joint=100.0), FULL_BLEND)),
        p.SetAcceleration(e.Number(50), e.Number(10)),
        p.Comment("über\nENDPROC"),
        targets={"a": Target(Pose())},
        tools={"torch": Tool()},
    )
    assert sorted(set(codes(program))) == ["RA302", "RA303", "RA306"]
    shown = text(program)
    assert "MoveJ a,vmax,z10,tool0;" in shown
    assert "AccSet 20,100;" in shown
    assert "! uber ENDPROC" in shown.replace("u?", "u") or "ENDPROC\r\n  ENDPROC" not in shown
    assert "[0.001,[0,0,0.001],[1,0,0,0],0,0,0]" in shown
    proved(program)


def test_a_percentage_alone_is_no_speed() -> None:
    motion = p.Motion(replace(MAXIMUM_SPEED, joint=30.0), FULL_BLEND)
    program = main(p.Move("joint", e.Name("a"), motion), targets={"a": Target(Pose())})
    assert "RA305" in codes(program)


NASTY = ("MoveL", "fine", "v100", "if", "round", "tool0_", "a" * 40, "a" * 39 + "b", "main", "Cell")


def test_names_that_rapid_has_already_come_back() -> None:
    program = main(
        *(p.Assign(e.Name(n), e.Binary("+", e.Name(n), e.Number(1))) for n in NASTY),
        p.Call("reset"),
        p.For("stop", e.Number(1), e.Number(2), (p.Assign(e.Name("if"), e.Name("stop")),)),
        p.Follow(path("a" * 40, 12)),
        p.Follow(path("seam", 5)),
        p.Follow(path("seam", 9)),
        tools={"GRIPPER": Tool(load=None)},
        variables={n: Variable("number", e.Number(0)) for n in NASTY},
    )
    program = replace(program, procedures=(*program.procedures, Procedure("reset", ())))
    proved(program)
    shown = text(program)
    assert all(
        len(word) <= 32
        for word in shown.replace("=", " ").split()
        if word.isidentifier() and word[0] != "a"
    )


def test_a_pulse_to_zero_ends_by_a_delayed_output() -> None:
    """`PulseDO` only goes to 1."""
    program = main(p.SetSignal("out", e.Number(0), e.Number(1)))
    proved(program)
    assert re.search(r"SetDO out,0;\s+SetDO\\SDelay:=1,out,1;", text(program))


@every_row(
    "bad",
    [
        main(p.Opaque("melfa-basic-5", "Hlt")),
        main(p.Opaque("rapid", "ENDPROC PROC evil()")),
        main(p.Opaque("rapid", "a := ;")),
        main(p.Wait(e.Verbatim("melfa-basic-5", "M_Timer(1)"))),
        main(p.Wait(e.Verbatim("rapid", "1; Stop"))),
        main(p.Wait(e.Number(math.nan))),
        main(p.Wait(e.Apply("ln", (e.Number(1.5),)))),
        main(p.Assign(e.Name("t"), e.Text("x" * 81))),
        main(p.Assign(e.Name("t"), e.Text("→"))),
        main(
            p.Move(
                "linear", e.TargetValue(Target(Pose((math.nan, 0, 0)))), p.Motion(Speed(5), Blend())
            )
        ),
        main(p.Move("linear", e.Name("a"), p.Motion(Speed(0.0), Blend()))),
        main(p.Follow(replace(path("seam", 12), positions=np.full((12, 3), np.inf)))),
        main(p.Follow(replace(path("seam", 12), kinds=np.full(12, Kind.VIA, dtype=np.uint8)))),
    ],
)
def test_what_cannot_be_said_is_an_error(bad: Program) -> None:
    findings = RAPID.adapt(bad).findings
    assert [f for f in findings if f.severity is Severity.ERROR]


def test_a_long_message_is_several() -> None:
    program = proved(main(p.Message((e.Text("x" * 200), e.Number(3)))))
    (procedure,) = program.procedures
    assert [type(x) for x in procedure.body] == [p.Message] * 3


def test_columns_stay_columns() -> None:
    program = RAPID.adapt(main(p.Follow(path("seam", 3000)))).program
    tree = RAPID.build(program)
    (module,) = tree.modules
    assert sum(isinstance(item, s.TargetRunNode) for item in module.items) == 1
    (routine,) = (item for item in module.items if isinstance(item, s.Routine))
    assert [type(node) for node in routine.body] == [s.MoveRunNode]
    lifted = RAPID.lift(RAPID.parse(RAPID.render(tree)))
    assert not lifted.targets
    assert [type(x) for x in lifted.procedures[0].body] == [p.Follow]


# What people write

PEOPLE = r"""
MODULE MainModule
  ! Cell 4
  TASK PERS tooldata tGripper:=[TRUE,[[0,0,100],[1,0,0,0]],[2,[0,0,50],[1,0,0,0],0,0,0]];
  PERS tooldata tPen:=[TRUE,[[0,0,100],[1,0,0,0]],[2,[0,0,50],[1,0,0,0],0,0,0]];
  LOCAL PERS wobjdata wTable:=[FALSE,TRUE,"",[[500,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  VAR speeddata vSlow:=[20,500,5000,1000];
  VAR speeddata vFree:=[20,500,5000,1000];
  CONST robtarget pHome:=[[400,0,600],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST jointtarget jHome:=[[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR intnum alarm;
  PROC main()
    vFree.v_tcp:=30;
    MoveAbsJ jHome\NoEOffs,v100,fine,tPen;
    MoveAbsJ jHome,v100,fine,tPen;
    MoveL Offs(pHome,0,0,50),vSlow,z10,tPen,\WObj:=wTable;
    MoveL [[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],vFree,z10,tPen;
    MoveL pHome,v100\V:=50,z10,tPen;
    Set doGlue;
    Reset doGlue;
    WaitDI diReady,1;
    IF diReady=1 Stop;
    TPWrite "n = "\Num:=3;
    SetDO hand1_open,1;
    work 1,2;
    work 1,2\Fast;
  ENDPROC
  PROC work(num a,num b\switch Fast)
    IF Present(Fast) RETURN;
  ERROR
    RETRY;
  ENDPROC
  TRAP onAlarm
    Stop;
  ENDTRAP
ENDMODULE
"""


def test_what_people_write_is_understood_and_nothing_is_lost() -> None:
    tree = RAPID.parse(PEOPLE)
    assert not tree.findings
    program = RAPID.lift(tree)
    assert program.name == "MainModule"
    assert program.comments == ("Cell 4",)
    assert set(program.tools) == {"tGripper", "tPen"}
    assert set(program.frames) == {"wTable"}
    assert set(program.speeds) == {"vSlow"}
    assert set(program.targets) == {"pHome"}
    assert set(program.joint_targets) == {"jHome"}
    assert program.signals == {
        "doGlue": Signal("digital", "output"),
        "diReady": Signal("digital", "input"),
    }
    kept = "\n".join(d.text for d in program.declarations)
    for word in ("vFree", "alarm", "PROC work", "TRAP onAlarm", "RETRY"):
        assert word in kept
    body = program.procedures[0].body
    assert p.SetSignal("doGlue", e.Number(0)) in body
    assert p.Gripper("open", 1) in body
    assert p.If((p.Branch(e.Binary("=", e.Name("diReady"), e.Number(1)), (p.Stop(),)),)) in body
    opaque = [x.text for x in body if isinstance(x, p.Opaque)]
    assert opaque == [
        "MoveL pHome,v100\\V:=50,z10,tPen;",
        "work 1,2\\Fast;",
    ]
    proved(program)


@every_row(
    ("line", "code"),
    [
        ("CONST num a:=1; VAR num A;", "RA201"),
        ("VAR num " + "a" * 33 + ";", "RA202"),
        ('CONST string t:="' + "x" * 81 + '";', "RA203"),
        ("PROC p() MoveL a,v25,z10,tool0; ENDPROC", "RA204"),
        ("PROC p() MoveL a,v100,z3,tool0; ENDPROC", "RA205"),
        (
            "CONST robtarget a:=[[1,2,3],[1,0.1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
            "RA206",
        ),
        ("PERS num a:=b;", "RA207"),
        (
            "VAR tooldata t; PROC p() MoveL a,v100,z1,t; ENDPROC",
            "RA208",
        ),
        ("PROC p() ENDPROC VAR num a;", "RA209"),
        ("PROC p() a:=1; VAR num b; ENDPROC", "RA209"),
        ("CONST speeddata v100:=[1,2,3,4];", "RA210"),
    ],
)
def test_a_load_error_is_found_before_the_load(line: str, code: str) -> None:
    tree = RAPID.parse(f"MODULE m\n{line}\nENDMODULE")
    assert not tree.findings
    found = RAPID.check([tree])
    assert code in {f.code for f in found}
    assert all(f.line == 2 for f in found)


def test_the_nearest_zones_are_named() -> None:
    tree = RAPID.parse("MODULE m PROC p() MoveL a,v100,z3,tool0; ENDPROC ENDMODULE")
    (finding,) = [f for f in RAPID.check([tree]) if f.code == "RA205"]
    assert "z1 or z5" in finding.cure


# Random programs

VARIABLES = ("a", "b", "Count", "x_9", "loop", "p" * 34, "set")
NAMES = st.sampled_from([*VARIABLES, "seam_1"])
NUMBERS = st.integers(-1000, 1000) | st.floats(-1e6, 1e6, allow_nan=False, width=32)
TEXTS = st.text(st.characters(max_codepoint=255), max_size=30)
BINARY = st.sampled_from(
    [
        "+",
        "-",
        "*",
        "/",
        "div",
        "mod",
        "^",
        "@",
        "=",
        "<>",
        "<",
        "<=",
        ">",
        ">=",
        "and",
        "or",
        "xor",
    ]
)


def compound(inner: st.SearchStrategy[e.Expression]) -> st.SearchStrategy[e.Expression]:
    return st.one_of(
        st.builds(e.Binary, BINARY, inner, inner),
        st.builds(e.Unary, st.sampled_from(["-", "not"]), inner),
        st.builds(e.Apply, st.sampled_from(["sin", "abs", "text"]), st.tuples(inner)),
        st.builds(e.Apply, st.just("own"), st.lists(inner, max_size=3).map(tuple)),
        st.builds(e.Aggregate, st.lists(inner, min_size=1, max_size=3).map(tuple)),
        st.builds(e.Index, st.builds(e.Name, NAMES), st.tuples(inner)),
        st.builds(e.Member, st.builds(e.Name, NAMES), st.sampled_from(["x", "y", "j3"])),
    )


EXPRESSIONS = st.recursive(
    st.one_of(
        st.builds(e.Number, NUMBERS),
        st.builds(e.Truth, st.booleans()),
        st.builds(e.Text, TEXTS),
        st.builds(e.Name, NAMES),
    ),
    compound,
    max_leaves=4,
)
MOTIONS = st.builds(
    p.Motion,
    st.builds(Speed, st.floats(1, 9000).map(lambda v: round(v, 2)), st.sampled_from([500.0, 20.0])),
    st.builds(Blend, st.sampled_from([None, 0.3, 1.0, 3.0, 15.0, 17.5, 200.0])),
    st.sampled_from(["tool0", "torch"]),
    st.sampled_from(["base", "table"]),
)
COMMENTS = st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=20).map(str.strip)
POINTS = st.sampled_from(["home", "seam_1", "seam_2", "seam_3", "q_1"]).map(e.Name)


def blocks(inner: st.SearchStrategy[p.Statement]) -> st.SearchStrategy[p.Statement]:
    body = st.lists(inner, max_size=4).map(tuple)
    branch = st.builds(p.Branch, EXPRESSIONS, body)
    case = st.builds(p.Case, st.lists(EXPRESSIONS, min_size=1, max_size=2).map(tuple), body)
    return st.one_of(
        st.builds(p.If, st.lists(branch, min_size=1, max_size=2).map(tuple), body),
        st.builds(p.While, EXPRESSIONS, body),
        st.builds(
            p.For,
            st.sampled_from(VARIABLES),
            EXPRESSIONS,
            st.builds(e.Number, NUMBERS),
            body,
            st.builds(e.Number, NUMBERS.filter(bool)),
        ),
        st.builds(p.Switch, EXPRESSIONS, st.lists(case, max_size=2).map(tuple), body),
    )


@st.composite
def paths(draw: st.DrawFn) -> Path:
    given = path(draw(st.sampled_from(["seam", "weld", "q"])), draw(st.integers(1, 24)))
    return replace(given, tools=("torch",), frames=("table",))


STATEMENTS = st.recursive(
    st.one_of(
        st.builds(p.Comment, COMMENTS),
        st.builds(p.Move, st.sampled_from(["joint", "linear"]), POINTS, MOTIONS),
        st.builds(p.MoveCircular, POINTS, POINTS, MOTIONS),
        st.builds(p.Follow, paths()),
        st.builds(p.Wait, EXPRESSIONS),
        st.builds(
            p.WaitSignal, st.sampled_from(["di1", "go1"]), EXPRESSIONS, st.none() | EXPRESSIONS
        ),
        st.builds(p.WaitUntil, EXPRESSIONS, st.none() | EXPRESSIONS),
        st.builds(p.SetSignal, st.sampled_from(["do1", "ao1", "hand3_open"]), EXPRESSIONS),
        st.builds(p.Gripper, st.sampled_from(["open", "close"]), st.integers(1, 8)),
        st.builds(p.SetOverride, EXPRESSIONS),
        st.builds(
            p.Call,
            st.sampled_from(["main", "elsewhere"]),
            st.lists(EXPRESSIONS, max_size=2).map(tuple),
        ),
        st.builds(p.Assign, st.builds(e.Name, NAMES), EXPRESSIONS),
        st.builds(p.Stop, st.booleans()),
        st.builds(p.Return, st.none()),
        st.builds(p.Message, st.lists(EXPRESSIONS, max_size=3).map(tuple)),
        st.just(p.Opaque("rapid", "SingArea \\Wrist ;")),
        st.just(p.Opaque("rapid", "WaitTime 1;")),
    ),
    blocks,
    max_leaves=5,
)


@settings(max_examples=drawn(25), deadline=None)
@given(st.lists(STATEMENTS, max_size=6), st.lists(COMMENTS, max_size=3))
def test_random_programs_come_back(body: list[p.Statement], comments: list[str]) -> None:
    points = {
        n: Target(Pose((float(i), 2.0, 3.0)))
        for i, n in enumerate(("home", "seam_1", "seam_2", "seam_3", "q_1"))
    }
    program = main(
        *body,
        comments=tuple(comments),
        targets=points,
        tools={"torch": Tool()},
        variables={n: Variable("number", e.Number(1)) for n in VARIABLES},
        signals={"ao1": Signal("analog", "output"), "go1": Signal("group", "input", 4, 8)},
    )
    proved(program)


def packed(contours: int, most: int, *, comments: bool = True, blend: Blend = FINE) -> Program:
    """A program of that many short contours in modules of so many targets."""

    def contour(number: int) -> tuple[p.Statement, ...]:
        end = p.Motion(Speed(50.0), blend)
        note = (p.Comment(f"contour {number}"),) if comments else ()
        up = p.Move("joint", e.Apply("relative", (e.Name("a"), *map(e.Number, (0, 0, -9)))), end)
        return (*note, up, p.Follow(path(f"seam_{number}_x", 4)), up)

    calls = tuple(p.Call(f"contour_{k}") for k in range(contours))
    made = tuple(Procedure(f"contour_{k}", contour(k)) for k in range(contours))
    program = Program(
        "cell",
        (
            Procedure("main", (p.Call("cut"),)),
            Procedure("cut", (p.Comment("cutting"), *calls)),
            *made,
        ),
        targets={"a": Target(Pose())},
    )
    return proved(program, most)


def test_short_paths_are_packed_in_modules() -> None:
    program = packed(9, 16)
    assert list(units(program)) == ["cut_unit1", "cut_unit2"]  # the ninth has room in the main one
    holding = Counter(q.unit for q in program.procedures if q.name.startswith("contour"))
    assert holding == {"cut_unit1": 4, "cut_unit2": 4, None: 1}
    shown = RAPID.render(RAPID.build(program))
    assert shown.count("Load\\Dynamic") == 2
    assert "! cutting" in shown
    inner = RAPID.render(RAPID.build(program, unit="cut_unit1"))
    # The procedure that is called from outside comes first, the others are called as usual.
    assert inner.index("PROC cut_part1()") < inner.index("PROC contour_0()")
    assert "Load" not in inner


def test_modules_are_not_loaded_while_the_arm_moves() -> None:
    program = packed(9, 16, blend=Blend(5.0))
    # Nothing stops between the contours, so that each path has a module as before.
    assert all("part" in q.name for q in program.procedures if q.unit)


def test_joint_moves_at_full_speed_name_the_key_that_slows_them_down() -> None:
    fastest = p.Motion(replace(MAXIMUM_SPEED, tcp=math.inf, joint=100.0), FINE)
    program = main(p.Move("joint", e.Name("a"), fastest), targets={"a": Target(Pose())})
    (found,) = [one for one in RAPID.adapt(program).findings if one.code == "RA306"]
    assert "vmax" in found.message and "`joint_speed`" in found.cure

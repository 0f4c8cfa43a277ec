"""RAPID to the pseudo-program and back: nothing is lost, and what is not touched stays."""

from __future__ import annotations

from dataclasses import replace

import pytest

from assistant.languages import get
from assistant.languages.rapid.tree.syntax import File
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Pose
from assistant.program.program import Program, Variable
from assistant.program.pseudo import parse as parse_pseudo
from assistant.program.pseudo import print_program
from tests.languages.rapid.sameness import differences
from tests.tables import every_row

RAPID = get("rapid")

CELL = """MODULE Cell(NOSTEPIN)
  ! stacks boxes
  CONST num rows := 3;   ! of the pallet
  VAR  num i := 0;
  PERS tooldata gripper:=[TRUE,[[0,0,120.50],[1,0,0,0]],[1.2,[0,0,60],[1,0,0,0],0,0,0]];
  CONST robtarget pPick:=[[400,0,300],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST jointtarget jHome:=[[0,0,0,0,90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR intnum iStop;
  RECORD box
    num width;
  ENDRECORD
  VAR box one;

  ! the way there
  PROC main()
    MoveAbsJ jHome,v1000,z50,gripper;
    IF DInput(diReady)=0 WaitDI diReady,1\\MaxTime:=20;
    CONNECT iStop WITH tStop;
    FOR n FROM 1 TO rows DO
      stack n, (n*2);
      Set doVacuum; Reset doBlow;
    ENDFOR
    TPWrite "rows: "\\Num:=rows;
    TPWrite "at " + NumToStr(i,0) + " of " + ValToStr(rows) + other;
    one.width:=12;
  ERROR
    RETRY;
  ENDPROC

  PROC stack(num level,num i)
    VAR num rows;
    rows:=level*(i+1);
    MoveJ Offs(pPick,0,0,rows*50),v500,z10,gripper;
    MoveL   pPick,v100,fine,gripper\\WObj:=wobj0; ! slowly
  ENDPROC

  FUNC num twice(num x)
    RETURN x*2;
  ENDFUNC

  TRAP tStop
    StopMove;
  ENDTRAP
ENDMODULE
"""


def module(text: str) -> File:
    tree = RAPID.parse(text)
    assert not tree.findings
    return tree


def lifted(text: str) -> Program:
    return RAPID.lift(module(text))


def test_an_unchanged_program_comes_back_as_it_was() -> None:
    tree = module(CELL)
    again = RAPID.lower(RAPID.lift(tree))
    assert again == tree
    assert RAPID.render(again) == CELL


def test_without_its_origin_a_program_says_the_same() -> None:
    behind = "  CONST num rows := 3;   ! of the pallet"  # is written above, with the name
    tree = module(CELL.replace(behind, "  ! rows: of the pallet\n  CONST num rows := 3;"))
    program = parse_pseudo(print_program(RAPID.lift(tree)).text)
    assert program.origin is None
    assert list(differences([tree], [RAPID.lower(program)])) == []


def test_what_is_changed_changes_alone() -> None:
    tree = module(CELL)
    program = RAPID.lift(tree)
    pick = program.targets["pPick"]
    higher = replace(pick, pose=Pose((400.0, 0.0, 310.0), pick.pose.quaternion))
    changed = replace(program, targets={**program.targets, "pPick": higher})
    text = RAPID.render(RAPID.lower(changed))
    wrong = [(a, b) for a, b in zip(CELL.splitlines(), text.splitlines(), strict=True) if a != b]
    assert len(wrong) == 1
    assert "310" in wrong[0][1]


def test_a_changed_statement_leaves_the_other_ones() -> None:
    program = lifted(CELL)
    stack = program.procedure("stack")
    assert stack is not None
    slower = tuple(
        replace(x, motion=replace(x.motion, speed=replace(x.motion.speed, tcp=80.0)))
        if isinstance(x, p.Move) and x.kind == "joint"
        else x
        for x in stack.body
    )
    others = tuple(q if q is not stack else replace(stack, body=slower) for q in program.procedures)
    text = RAPID.render(RAPID.lower(replace(program, procedures=others)))
    assert "MoveJ Offs(pPick,0,0,rows*50),v80,z10,gripper;" in text
    assert text.replace(",v80,", ",v500,") == CELL


@pytest.mark.parametrize(
    ("statement", "again"),
    [
        ('TPWrite NumToStr(x,0);', "TPWrite NumToStr(x,0);"),
        ('TPWrite "a"+ValToStr(n);', 'TPWrite "a"+ValToStr(n);'),
        ('TPWrite "a"+said;', 'TPWrite "a"+said;'),
        ('TPWrite "a"+ofOthers;', 'TPWrite "a"+ofOthers;'),
        ('TPWrite ValToStr(ofOthers);', "TPWrite ValToStr(ofOthers);"),
        ('TPWrite "a"\\Num:=n;', 'TPWrite "a"+ValToStr(n);'),
    ],
)  # fmt: skip
def test_a_message_stays_a_string(statement: str, again: str) -> None:
    text = (
        f"MODULE m\n VAR num n;\n VAR string said;\n PROC main()\n {statement}\n ENDPROC\nENDMODULE"
    )
    built = RAPID.lower(replace(lifted(text), origin=None))
    assert again in RAPID.render(built)


@pytest.mark.parametrize(
    ("loop", "step"),
    [
        ("FOR i FROM 1 TO 3 DO", p.ONE),
        ("FOR i FROM 3 TO 1 DO", e.Number(-1)),
        ("FOR i FROM 1 TO n DO", None),
        ("FOR i FROM 1 TO n STEP 2 DO", e.Number(2)),
    ],
)
def test_a_loop_counts_as_rapid_does(loop: str, step: e.Expression | None) -> None:
    text = f"MODULE m\n VAR num n;\n PROC main()\n {loop}\n ENDFOR\n ENDPROC\nENDMODULE"
    (statement,) = (x for x in lifted(text).statements() if isinstance(x, p.For))
    assert statement.step == step
    assert (
        list(differences([module(text)], [RAPID.lower(replace(lifted(text), origin=None))])) == []
    )


def test_a_parameter_may_hide_a_value_of_the_module() -> None:
    text = "MODULE m\n VAR num n;\n PROC main(num n)\n n:=n+1;\n ENDPROC\nENDMODULE"
    built = RAPID.lower(replace(lifted(text), origin=None))
    assert list(differences([module(text)], [built])) == []


@pytest.mark.parametrize(
    ("call", "parameter", "constant"),
    [
        ("wider zNow;", "zonedata z", True),
        ("wider zNow;", "INOUT zonedata z", False),
        ('%"wider"% zNow;', "INOUT zonedata z", False),
        ("ofOthers zNow;", "zonedata z", False),
    ],
)
def test_data_that_a_call_may_change_are_no_constants(
    call: str, parameter: str, constant: bool
) -> None:
    text = (
        "MODULE m\n VAR zonedata zNow:=[FALSE,10,15,15,1.5,15,1.5];\n"
        f" PROC main()\n {call}\n MoveL p1,v100,zNow,tool0;\n ENDPROC\n"
        f" PROC wider({parameter})\n z:=z100;\n ENDPROC\nENDMODULE"
    )
    assert ("zNow" in lifted(text).blends) is constant


def test_a_routine_is_understood_beside_what_only_rapid_can_say() -> None:
    program = lifted(CELL.replace("VAR num rows;", "VAR num rows;\n    VAR clock c;"))
    names = {q.name for q in program.procedures}
    assert {"main", "stack", "twice"} <= names
    main = program.procedure("main")
    assert main is not None
    assert main.body[-1] == p.Opaque("rapid", "ERROR\n    RETRY;")
    stack = program.procedure("stack")
    assert stack is not None
    assert p.Opaque("rapid", "VAR clock c;") in stack.body


def test_many_targets_that_are_written_out_are_a_path() -> None:
    rows = "".join(
        f"    MoveL [[{x},0,500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z1,tool0;\n"
        for x in range(300)
    )
    text = f"MODULE m\n  PROC main()\n{rows}    Stop;\n{rows}  ENDPROC\nENDMODULE\n"
    program = lifted(text)
    first, stop, second = program.procedures[0].body
    assert isinstance(first, p.Follow)
    assert isinstance(stop, p.Stop)
    assert isinstance(second, p.Follow)
    assert first.path.name != second.path.name
    assert list(first.path.positions[:, 0]) == list(range(300))
    assert RAPID.render(RAPID.lower(program)) == text
    again = RAPID.lift(RAPID.lower(replace(program, origin=None)))
    assert again == program


def test_a_mistaken_comparison_stays_as_it_is_written() -> None:
    tree = RAPID.parse("MODULE m\nPROC main()\nIF a:=1 Stop;\nENDPROC\nENDMODULE\n")
    assert [f.code for f in tree.findings] == ["RA101"]
    condition = e.Verbatim("rapid", "a:=1")
    (procedure,) = RAPID.lift(tree).procedures
    assert procedure.body == (p.If((p.Branch(condition, (p.Stop(),)),)),)


@every_row(
    ("condition", "written"),
    [
        ("n", "n<>0"),
        ("ready", "ready<>0"),
        ("n and not ready", "n<>0 AND (NOT (ready<>0))"),
        ("n - 1", "n-1<>0"),
        ("1", "TRUE"),
        ("b", "b"),
        ("n > 1", "n>1"),
    ],
)
def test_a_condition_is_a_truth_value(condition: str, written: str) -> None:
    program = parse_pseudo(
        "program cell entry main\n\nsignal ready digital input\n\nvariable n number\n"
        f"variable b truth\n\nprocedure main\n  if {condition}\n    stop\n  end\nend\n"
    )
    tree = RAPID.lower(program)
    assert f"IF {written} THEN" in RAPID.render(tree)
    assert not [f for f in RAPID.check([tree]) if f.severity == "error"]


def test_letters_beyond_ascii_come_back_in_names() -> None:
    text = "MODULE Größe\n  VAR num höhe;\n  PROC main()\n    größer;\n  ENDPROC\n"
    text += "  PROC größer()\n    höhe:=1;\n  ENDPROC\nENDMODULE\n"
    program = lifted(text)
    adapted = RAPID.adapt(program).program
    built = RAPID.build(adapted)
    assert RAPID.render(built).isascii()
    again = RAPID.lift(RAPID.parse(RAPID.render(built)))
    assert again == adapted
    assert {q.name for q in again.procedures} == {"main", "größer"}
    assert set(again.variables) == {"höhe"}


@pytest.mark.parametrize("name", ["pi", "vmax", "z10", "robtarget", "SetDO", "err_overflow"])
def test_what_every_controller_knows_gives_its_name_to_nothing_else(name: str) -> None:
    """An error number of RobotWare is as much a name of its own as a speed or a type."""
    variables = {name: Variable("number", e.Number(1))}
    adapted = RAPID.adapt(Program("cell", variables=variables)).program
    text = RAPID.render(RAPID.build(adapted))
    assert f" num {name}_2" in text and f" num {name}:" not in text

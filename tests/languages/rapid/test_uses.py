"""How names, values and routines are used: each finding where it belongs, and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Rule, Severity
from assistant.languages.checks.names import misspelt
from assistant.languages.rapid import rules
from assistant.languages.rapid.checks.rule_context import RuleContext, Task
from assistant.languages.rapid.checks.uses import uses_by_construct
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.predefined import signature
from assistant.languages.rapid.tree.syntax import File
from tests.examples import drawn
from tests.languages.rapid import modules
from tests.tables import every_row

RAPID = languages.get("rapid")
KNOWN = {rule.code for rule in vars(rules).values() if isinstance(rule, Rule)}
OWN = {code for code in KNOWN if code.startswith(("RA40", "RA41", "RA42", "RA43"))}

DECLARED = r"""
  RECORD part
    num width;
    pos corner;
  ENDRECORD
  ALIAS num length;
  CONST robtarget p1:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST jointtarget home:=[[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS tooldata gripper:=[TRUE,[[0,0,0],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  PERS wobjdata table:=[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  PERS bool seen:=FALSE;
  PERS num kept:=0;
  CONST num fixed:=1;
  CONST num many:=3;
  VAR num a;
  VAR dnum big;
  VAR length long;
  VAR bool yes;
  VAR string text;
  VAR part one;
  VAR num list{3};
  VAR num grid{2,3};
  VAR intnum alarm;
  VAR clock watch;
  VAR errnum slip;
"""
ROUTINES = r"""
  PROC grip(num force \switch hard | num soft, VAR num reached \string note)
    reached:=force;
  ENDPROC
  PROC show(num values{*})
    a:=values{1};
  ENDPROC
  FUNC num twice(num value)
    RETURN 2*value;
  ENDFUNC
  FUNC pos middle(pos one, pos other)
    RETURN 0.5*(one+other);
  ENDFUNC
  TRAP stopped
    Stop;
  ENDTRAP
"""


def module(statements: str, *, data: str = "", routine: str = "PROC try()", name: str = "m") -> str:
    end = "ENDFUNC" if "FUNC" in routine else "ENDPROC"
    lines = ("MODULE " + name, DECLARED, data, ROUTINES, routine, statements, end, "ENDMODULE", "")
    return "\n".join(lines)


def findings(text: str, *others: str) -> list[Diagnostic]:
    trees = [RAPID.parse(one) for one in (text, *others)]
    assert not [f for tree in trees for f in tree.findings], trees[0].findings
    return [f for f in RAPID.check(trees) if f.code in OWN]


def codes(text: str, *others: str) -> list[str]:
    return [finding.code for finding in findings(text, *others)]


@dataclass(frozen=True)
class Case:
    """wrong: statements with exactly this finding. right: much the same ones without any."""

    rule: Rule
    wrong: str
    right: str
    wrong_data: str = ""
    right_data: str = ""

    def __str__(self) -> str:
        return f"{self.rule.code} {self.wrong or self.wrong_data}"[:60]


CASES = [
    Case(rules.UNKNOWN_ROUTINE, "weld_seam a;", "grip 1,a;"),
    Case(rules.UNKNOWN_ROUTINE, "a:=thrice(2);", "a:=twice(2);"),
    Case(rules.UNKNOWN_ROUTINE, "FCPressLBegin p1;", "FCPressLEnd p1;"),
    Case(rules.UNKNOWN_ROUTINE, "FCPresL p1;", "FCPressL p1;"),
    Case(rules.UNKNOWN_ROUTINE, "CONNECT alarm WITH gone;", "CONNECT alarm WITH stopped;"),
    Case(rules.UNKNOWN_DATA, "CONNECT bell WITH stopped;", "CONNECT alarm WITH stopped;"),
    Case(rules.MISSPELT_ROUTINE, "WaitTiem 1;", "WaitTime 1;"),
    Case(rules.MISSPELT_ROUTINE, "a:=twcie(2);", "a:=twice(2);"),
    Case(rules.UNKNOWN_DATA, "MoveJ p9,v100,fine,gripper;", "MoveJ p1,v100,fine,gripper;"),
    Case(rules.UNKNOWN_DATA, "count:=1;", "reg1:=1;"),
    Case(rules.UNKNOWN_DATA, "a:=there.width;", "a:=one.width;"),
    Case(rules.UNKNOWN_DATA, "a:=rows{1};", "a:=list{1};"),
    Case(rules.UNKNOWN_DATA, "Incr count;", "IF di_part=1 Incr a;"),
    Case(rules.UNKNOWN_DATA, "grip 1,count;", "SetDO do_open,1;"),
    Case(rules.MISSING_ARGUMENTS, "MoveL p1,v100,gripper;", "MoveL p1,v100,fine,gripper;"),
    Case(rules.MISSING_ARGUMENTS, "a:=twice();", "a:=twice(1);"),
    Case(rules.MISSING_ARGUMENTS, "grip 1;", "grip <ARG>,<ARG>;"),
    Case(rules.TOO_MANY, "WaitTime 1,2;", "WaitTime\\InPos,1;"),
    Case(rules.TOO_MANY, "Stop 1;", "Stop\\NoRegain;"),
    Case(rules.TOO_MANY, "a:=Abs(1,2);", "a:=Abs(-1);"),
    Case(rules.UNKNOWN_OPTION, "grip 1\\weak,a;", "grip 1\\hard,a;"),
    Case(rules.NEW_OPTION, "WaitTime\\InPosition,1;", "WaitTime\\InPos,1;"),
    Case(rules.EXCLUSIVE, "grip 1\\hard\\soft:=2,a;", 'grip 1\\hard,a\\note:="x";'),
    Case(rules.EXCLUSIVE, "ConfL\\On\\Off;", "ConfL\\On;"),
    Case(rules.EXCLUSIVE, "StopMove\\Quick\\Quick;", "StopMove\\Quick\\AllMotionTasks;"),
    Case(rules.OPTION_WITHOUT_VALUE, "grip 1\\soft,a;", "grip 1\\soft:=2,a;"),
    Case(
        rules.OPTION_WITHOUT_VALUE,
        "MoveL p1,v100\\T,fine,gripper;",
        "MoveL p1,v100\\T:=1,fine,gripper;",
    ),
    Case(rules.SWITCH_WITH_VALUE, "ConfL\\Off:=TRUE;", "ConfL\\Off;"),
    Case(rules.WRONG_NAME, "grip reached:=1,a;", "grip force:=1,reached:=a;"),
    Case(rules.WRONG_ARGUMENT, 'WaitTime "1";', "WaitTime 0x10;"),
    Case(rules.WRONG_ARGUMENT, "a:=StrLen(1);", 'a:=StrLen("one"+text);'),
    Case(rules.WRONG_ARGUMENT, "MoveL home,v100,fine,gripper;", "MoveAbsJ home,v100,fine,tool0;"),
    Case(rules.WRONG_ARGUMENT, "a:=twice(big);", "a:=twice(DnumToNum(big));"),
    Case(rules.WRONG_ARGUMENT, "show a;", "show list;"),
    Case(rules.WRONG_ARGUMENT, "a:=twice(list);", "a:=twice(list{2});"),
    Case(rules.WRONG_ARGUMENT, "show grid;", "show grid{1,*};"),
    Case(rules.WRONG_ARGUMENT, "TPWrite 1;", 'TPWrite "is "\\Num:=a;'),
    Case(rules.WRONG_ARGUMENT, "SetDO a,1;", "WaitTime di_fast;"),
    Case(rules.WRONG_ARGUMENT, "a:=VectMagn(p1);", "a:=VectMagn(p1.trans);"),
    Case(rules.NO_REFERENCE, "Incr fixed;", "Incr kept;"),
    Case(rules.NO_REFERENCE, "Incr a+1;", "Incr list{2};"),
    Case(rules.NO_REFERENCE, "FOR i FROM 1 TO 2 DO grip 1,i; ENDFOR", "grip a+1,one.width;"),
    Case(rules.NO_PERSISTENT, "WaitTestAndSet yes;", "WaitTestAndSet seen;"),
    Case(rules.NO_VARIABLE, "grip 1,kept;", "grip kept,a;"),
    Case(rules.FUNCTION_ALONE, "twice 2;", "a:=twice(2);"),
    Case(rules.FUNCTION_ALONE, "Offs p1,1,2,3;", "MoveL Offs(p1,1,2,3),v50,z1,gripper;"),
    Case(rules.NO_FUNCTION, "a:=Stop();", "Stop;"),
    Case(rules.NAME_WITHOUT_VALUE, "a:=grip;", "a:=1;"),
    Case(rules.NOT_A_ROUTINE, "a 1;", "grip 1,a;"),
    Case(rules.NOT_A_ROUTINE, "stopped;", "CONNECT alarm WITH stopped;"),
    Case(rules.UNKNOWN_TYPE, "", "", "VAR weldseam x;", "VAR part x;"),
    Case(rules.MISSPELT_TYPE, "", "", "VAR robtraget x;", "VAR robtarget x;"),
    Case(
        rules.COMPONENT_COUNT,
        "",
        "",
        "CONST robtarget x:=[[1,2,3],[1,0,0,0],[0,0,0,0]];",
        "CONST robtarget x:=[[1,2,3],[1,0,0,0],[0,0,0,0],[0,0,0,0,0,0]];",
    ),
    Case(rules.COMPONENT_COUNT, "one:=[1,[2,3]];", "one:=[1,[2,3,a]];"),
    Case(rules.COMPONENT_COUNT, "PDispSet [[1,2,3]];", "PDispSet [[1,2,3],[1,0,0,0]];"),
    Case(rules.ELEMENT_COUNT, "", "", "CONST num x{3}:=[1,2];", "CONST num x{many}:=[1,2,3];"),
    Case(
        rules.ELEMENT_COUNT,
        "",
        "",
        "CONST num x{2,2}:=[[1,2],[3]];",
        "CONST num x{2,2}:=[[1,2],[3,4]];",
    ),
    Case(rules.WRONG_VALUE, 'a:="1";', "a:=1;"),
    Case(rules.WRONG_VALUE, "big:=a;", "big:=NumToDnum(a)+1;"),
    Case(rules.WRONG_VALUE, "list:=[1,TRUE,3];", "list:=[1,a,kept];"),
    Case(rules.WRONG_VALUE, "yes:=[TRUE];", "long:=a;"),
    Case(rules.WRONG_VALUE, 'TEST a CASE "x": Stop; ENDTEST', "TEST a CASE 1,fixed: Stop; ENDTEST"),
    Case(rules.WRONG_VALUE, "", "", 'VAR num x:="x";', "VAR dionum x:=high;"),
    Case(rules.UNKNOWN_COMPONENT, "a:=p1.trans.w;", "a:=p1.trans.x+p1.extax.eax_a;"),
    Case(rules.UNKNOWN_COMPONENT, "a:=one.height;", "a:=one.WIDTH;"),
    Case(rules.UNKNOWN_COMPONENT, "a:=fixed.x;", "a:=one.corner.x;"),
    Case(rules.INDEX_COUNT, "a:=grid{1};", "a:=grid{1,2};"),
    Case(rules.INDEX_COUNT, "a:=fixed{1};", "a:=list{1};"),
    Case(rules.INDEX_RANGE, "a:=list{0};", "a:=list{3};"),
    Case(rules.INDEX_RANGE, "list{many+1}:=1; list{4}:=1;", "list{many}:=1; list{a}:=1;"),
    Case(rules.INDEX_RANGE, "show grid{3,*};", "show grid{2,*};"),
    Case(rules.OPERANDS, 'text:="n = "+a;', 'text:="n = "+NumToStr(a,0);'),
    Case(rules.OPERANDS, "a:=a*big;", "big:=2*big;"),
    Case(rules.OPERANDS, "yes:=p1.trans<p1.trans;", "yes:=p1.trans=p1.trans;"),
    Case(rules.OPERANDS, 'yes:=a="1";', 'yes:=(a=1) AND (text="1");'),
    Case(rules.NO_TRUTH, "IF a THEN Stop; ENDIF", "IF a>0 THEN Stop; ENDIF"),
    Case(rules.NO_TRUTH, "WHILE text DO ENDWHILE", "WHILE NOT seen DO ENDWHILE"),
    Case(rules.NO_TRUTH, "yes:=NOT a;", "yes:=NOT (a=1);"),
    Case(rules.NO_TRUTH, "yes:=yes AND kept;", "yes:=yes OR seen;"),
]


@every_row("case", CASES)
def test_a_finding_stands_where_it_belongs(case: Case) -> None:
    found = findings(module(case.wrong, data=case.wrong_data))
    assert [f.code for f in found] == [case.rule.code], found
    assert found[0].span is not None
    assert found[0].line is not None
    assert "{" not in found[0].message + found[0].cure.replace("{*}", "")
    assert findings(module(case.right, data=case.right_data)) == []


def test_every_rule_has_a_case() -> None:
    assert {case.rule.code for case in CASES} == OWN


def test_results_fit_their_function() -> None:
    routine = "FUNC pos here()"
    assert codes(module("RETURN p1;", routine=routine)) == [rules.WRONG_VALUE.code]
    assert codes(module("RETURN middle(p1.trans,[1,2,3]);", routine=routine)) == []


def test_a_handle_that_is_given_a_value_is_told_of_once() -> None:
    assert codes(module("ClkStart late;", data="VAR clock late:=0;")) == []


def test_parameters_and_loops_hide_what_is_outside() -> None:
    routine = "PROC try(string a,INOUT robtarget here \\switch list)"
    right = "TPWrite a; here:=p1; IF Present(list) RETURN; FOR yes FROM 1 TO 2 DO big:=yes; ENDFOR"
    assert codes(module(right, routine=routine)) == []
    wrong = module("WaitTime a;", routine=routine)
    assert codes(wrong) == [rules.WRONG_ARGUMENT.code]


def test_options_are_handed_on() -> None:
    routine = "PROC try(\\switch hard | num soft, \\string note)"
    assert codes(module("grip 1\\hard?hard\\soft?soft,a\\note?note;", routine=routine)) == []
    wrong = module("grip 1\\weak?hard,a;", routine=routine)
    assert codes(wrong) == [rules.UNKNOWN_OPTION.code]


def test_one_module_alone_may_lean_on_others() -> None:
    user = module("weld_seam; other.width:=1;", data="VAR weldseam x;")
    alone = findings(user)
    assert {f.severity for f in alone} == {Severity.INFO}
    together = findings(user, "MODULE n ENDMODULE")
    assert {f.severity for f in together} == {Severity.WARNING, Severity.INFO}
    rest = (
        "MODULE n RECORD weldseam num width; ENDRECORD VAR weldseam other; "
        "PROC weld_seam() ENDPROC ENDMODULE"
    )
    assert findings(user, rest) == []


def test_long_runs_of_moves_name_tools_and_frames() -> None:
    lines = "\n".join(f"    MoveL t{i},v100,z1,torch\\WObj:=bench;" for i in range(20))
    data = "\n".join(
        f"  CONST robtarget t{i}:=[[{i},0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
        for i in range(20)
    )
    messages = [f.message for f in findings(module(lines, data=data))]
    assert messages == [f"no given module declares `{name}`" for name in ("torch", "bench")]


def test_a_name_is_told_once() -> None:
    assert codes(module("weld_seam; weld_seam; WELD_SEAM;")) == [rules.UNKNOWN_ROUTINE.code]


def test_nothing_is_said_of_a_name_that_two_modules_declare() -> None:
    first = "MODULE n PROC both(num x) ENDPROC ENDMODULE"
    second = "MODULE o PROC both() ENDPROC ENDMODULE"
    assert codes(module("both TRUE;"), first, second) == []
    assert codes(module("both TRUE;"), first) == [rules.WRONG_ARGUMENT.code]


def test_a_local_routine_is_called_before_a_global_one() -> None:
    local = "LOCAL PROC both(string x) ENDPROC"
    text = module('both "x";').replace("ENDMODULE", local + " ENDMODULE")
    assert codes(text, "MODULE n PROC both(num x) ENDPROC ENDMODULE") == []


def test_cures_name_what_is_meant() -> None:
    (finding,) = findings(module("Wiatdi di1,1;"))
    assert finding.cure == "write `WaitDI` if it is meant"
    (finding,) = findings(module("grip 1\\hadr,a;"))
    assert finding.cure == "write `\\hard`"
    (finding,) = findings(module("MoveC p1,v100,fine,gripper;"))
    assert "MoveC CirPoint, ToPoint, Speed, Zone, Tool" in finding.cure
    assert finding.message == "`MoveC` lacks 1 of its 5 arguments"
    (finding,) = findings(module("MoveL p1,v100,gripper;"))
    assert finding.message == "`MoveL` lacks `Zone`"


ROUTINE_NAMES = st.sampled_from(sorted(predefined.rows()))


@settings(max_examples=drawn(60), deadline=None)
@given(name=ROUTINE_NAMES, data=st.data())
def test_a_call_with_what_is_required_is_right(name: str, data: st.DataObject) -> None:
    """Data of unknown modules in every place, of any standard routine, is never an error."""
    routine = signature(name)
    assert routine is not None
    given = [f"{one.alternatives[0].name}:=x{i}" for i, one in enumerate(routine.required)]
    if data.draw(st.booleans()):
        given = [text.partition(":=")[2] for text in given]
    for slot in routine.optional:
        if data.draw(st.booleans()):
            one = data.draw(st.sampled_from(slot.alternatives))
            value = "" if one.type == "switch" else f":={one.name}_x"
            given.append(f"\\{one.name}{value}")
    text = ",".join(given)
    call = f"{name} {text};" if routine.kind == "PROC" else f"reg1:={name}({text});"
    found = findings(f"MODULE m PROC p() {call} ENDPROC ENDMODULE")
    assert {f.code for f in found} <= {rules.UNKNOWN_DATA.code, rules.WRONG_VALUE.code}
    if routine.kind == "PROC":
        assert {f.severity for f in found} <= {Severity.INFO}


@settings(max_examples=drawn(30), deadline=None)
@given(st.lists(modules.files(), min_size=1, max_size=2))
def test_whatever_a_tree_holds_is_judged(files: list[File]) -> None:
    task = Task(files)
    for file in files:
        for one in file.modules:
            assert all(
                f.message and f.code in OWN for f in uses_by_construct(RuleContext(file, one, task))
            )


@given(st.text(st.characters(categories=["L", "Nd"]), max_size=12))
def test_no_name_is_a_slip_of_itself_with_another_number(name: str) -> None:
    assert misspelt(name + "1", [name + "2", name + "12"]) == ""


@every_row(
    ("name", "meant"),
    [
        ("WaitTiem", "WaitTime"),
        ("MoveLL", "MoveL"),
        ("movj", "MoveJ"),
        ("SokcetRecive", "SocketReceive"),
        ("Grip", ""),
        ("MoveAway", ""),
        ("Sin2", ""),
    ],
)
def test_slips_of_typing(name: str, meant: str) -> None:
    known = ["WaitTime", "MoveL", "MoveJ", "MoveAbsJ", "SocketReceive", "Sin", "GripLoad"]
    assert misspelt(name, known) == meant

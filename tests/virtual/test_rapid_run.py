"""The interpreter of RAPID against values worked out by hand."""

from __future__ import annotations

import pytest

from assistant import languages
from assistant.virtual.events import Said, Stopped
from assistant.virtual.rapid import run
from tests.virtual.rapid_cell import ran, said, truths, values

# ------------------------------------------------------------------------------- expressions


def test_operators_bind_as_the_manual_says() -> None:
    assert values("2+3*4", "(2+3)*4", "2-3-4", "12/4/3", "-2+5", "2*(-3)") == (
        ["14", "20", "-5", "1", "3", "-6"]
    )
    assert values(
        "14 DIV 4", "14 MOD 4", "-14 DIV 4", "-14 MOD 4", "1+7 DIV 2*3", "20 DIV 6 MOD 2"
    ) == (["3", "2", "-3", "-2", "10", "1"])
    assert truths("NOT TRUE AND FALSE", "TRUE OR FALSE AND FALSE", "TRUE XOR TRUE OR TRUE") == (
        ["TRUE", "TRUE", "TRUE"]
    )
    assert truths("1+1=2 AND 3<4", "2<=2", "2<>2", '"a"+"b"="ab"') == [
        "TRUE",
        "TRUE",
        "FALSE",
        "TRUE",
    ]


def test_numbers_in_every_spelling() -> None:
    assert values("0x1F", "0b101", "1E3", ".5", "5.") == ["31", "5", "1000", "0.5", "5"]


def test_functions_of_numbers() -> None:
    assert values(
        "Round(2.5)", "Round(-2.5)", "Round(1.2345\\Dec:=2)", "Trunc(-1.7)", "Abs(-3)"
    ) == (["3", "-3", "1.23", "-1", "3"])
    assert values("Sqrt(16)", "Pow(2,10)", "Sin(30)", "ATan2(1,-1)", "Max(1,2)") == (
        ["4", "1024", "0.5", "135", "2"]
    )


def test_functions_of_strings() -> None:
    assert said('TPWrite StrPart("Robotics",1,5)+NumToStr(1.255,1)+ValToStr(TRUE);') == [
        "Robot1.3TRUE"
    ]
    assert values(
        'StrLen("abc")', 'StrFind("Robotics",1,"aeiou")', 'StrMatch("Robotics",1,"xx")'
    ) == (["3", "2", "9"])
    assert said('VAR num n:=7;\nIF StrToVal("3.5",n) TPWrite ""\\Num:=n;') == ["3.5"]


def test_positions_are_vectors() -> None:
    assert said('VAR pos a:=[1,2,3];\nTPWrite ""\\Pos:=a+2*a;\nTPWrite ""\\Pos:=a*[0,0,1];') == (
        ["[3,6,9]", "[2,-1,0]"]
    )
    assert values("Distance([0,0,0],[3,4,0])", "VectMagn([0,6,8])", "DotProd([1,2,3],[4,5,6])") == (
        ["5", "10", "32"]
    )


def test_euler_angles_are_z_then_y_then_x() -> None:
    assert values("EulerZYX(\\Z,OrientZYX(30,20,10))", "EulerZYX(\\Y,OrientZYX(30,20,10))") == [
        "30",
        "20",
    ]
    assert values("EulerZYX(\\X,OrientZYX(30,20,10))") == ["10"]


def test_data_has_values_before_it_is_set() -> None:
    data = "VAR num n;\nVAR bool b;\nVAR string t;\nVAR num k{2,3};\n"
    data += "CONST num two:=one+1;\nCONST num one:=1;"
    assert said('TPWrite t+ValToStr(b);\nTPWrite ""\\Num:=n+k{2,3}+two+Dim(k,2);', data=data) == [
        "FALSE",
        "5",
    ]


# ------------------------------------------------------------------- routines and references


@pytest.mark.parametrize("mode", ["INOUT", "VAR"])
def test_a_reference_is_the_data_itself(mode: str) -> None:
    more = f'PROC raise_({mode} num q)\nq:=q+30;\nTPWrite ""\\Num:=n;\nENDPROC'
    assert said("raise_ n;", more, "VAR num n:=4;") == ["34"]


def test_a_reference_to_an_element_or_component_stays_while_the_whole_is_set() -> None:
    more = 'PROC sub(INOUT num q)\nk:=[5,6];\nq:=q+1;\nTPWrite ""\\Num:=k{2};\nENDPROC'
    assert said("sub k{2};", more, "VAR num k{2};") == ["7"]
    more = 'PROC lift_(INOUT num z)\nz:=z+1;\nTPWrite ""\\Num:=pt.trans.z;\nENDPROC'
    assert said("pt:=p10;\nlift_ pt.trans.z;", more, "VAR robtarget pt;") == ["301"]


def test_a_persistent_reference_and_a_chain_of_references() -> None:
    more = "PROC a(PERS num q)\nb q;\nENDPROC\n"
    more += 'PROC b(PERS num r)\nr:=r+1;\nTPWrite ""\\Num:=n;\nENDPROC'
    assert said("a n;", more, "PERS num n:=4;") == ["5"]


def test_an_input_parameter_is_a_copy() -> None:
    more = 'PROC sub(num q,robtarget p)\nq:=q+1;\np.trans.x:=0;\nTPWrite ""\\Num:=n;\nENDPROC'
    assert said(
        'sub n,pt;\nTPWrite ""\\Num:=pt.trans.x;',
        more,
        "VAR num n:=4;\nVAR robtarget pt:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
    ) == ["4", "1"]


def test_local_data_begins_anew_at_each_call() -> None:
    more = 'PROC up()\nVAR num q{2};\nq{1}:=q{1}+10;\nTPWrite ""\\Num:=q{1};\nENDPROC'
    assert said("up;\nup;", more) == ["10", "10"]


def test_optional_parameters_and_switches() -> None:
    more = (
        'PROC go(num a\\num b|switch fast)\nIF Present(b) THEN\nTPWrite "b"\\Num:=b;\n'
        'ELSEIF Present(fast) THEN\nTPWrite "fast";\nELSE\nTPWrite "plain";\nENDIF\nENDPROC\n'
        "PROC pass(\\num b)\ngo 1\\b?b;\nENDPROC"
    )
    assert said("go 1;\ngo 1\\b:=2;\ngo 1\\fast;\npass;\npass\\b:=3;", more) == (
        ["plain", "b2", "fast", "plain", "b3"]
    )
    assert ran("pass;", 'PROC pass(\\num b)\nTPWrite ""\\Num:=b;\nENDPROC').ended == "error"


def test_functions_and_early_returns() -> None:
    more = "FUNC num half(num v)\nIF v MOD 2=1 RETURN (v-1)/2;\nRETURN v/2;\nENDFUNC"
    assert values("half(7)+half(half(8))", more=more) == ["5"]
    assert (
        ran('TPWrite ""\\Num:=none(1);', "FUNC num none(num v)\nIF v>5 RETURN 1;\nENDFUNC").ended
        == "error"
    )


def test_names_hide_one_another() -> None:
    more = """PROC sub()
VAR num n:=5;
FOR n FROM 1 TO 2 DO
TPWrite "l"\\Num:=n;
ENDFOR
TPWrite "o"\\Num:=n;
ENDPROC"""
    assert said('sub;\nTPWrite "g"\\Num:=n;', more, "VAR num n:=9;") == ["l1", "l2", "o5", "g9"]


def test_local_names_of_modules() -> None:
    other = """MODULE Other
LOCAL VAR num n:=2;
PROC show()
TPWrite ""\\Num:=n;
ENDPROC
ENDMODULE"""
    one = """MODULE One
LOCAL VAR num n:=1;
PROC main()
show;
TPWrite ""\\Num:=n;
ENDPROC
ENDMODULE"""
    rapid = languages.get("rapid")
    found = run([rapid.parse(one), rapid.parse(other)])
    assert found.events == (Said("2"), Said("1"))
    assert run([rapid.parse(one), rapid.parse(one)]).ended == "error"


def test_records_of_the_program() -> None:
    text = (
        "MODULE M\nRECORD slot\nrobtarget at;\nnum filled;\nENDRECORD\n"
        "VAR slot rack{2};\nPROC main()\nrack{2}.filled:=3;\nrack{1}:=rack{2};\n"
        "rack{2}.filled:=4;\n"
        'TPWrite ""\\Num:=rack{1}.filled;\nENDPROC\nENDMODULE'
    )
    assert run(languages.get("rapid").parse(text)).events == (Said("3"),)


# ----------------------------------------------------------------------------------- control


@pytest.mark.parametrize(
    ("loop", "turns"),
    [
        ("1 TO 3", "123"),
        ("3 TO 1", "321"),
        ("a TO b", "5432"),
        ("1 TO 6 STEP 2", "135"),
        ("3 TO 1 STEP 1", ""),
        ("6 TO 1 STEP -2", "642"),
        ("2 TO 2", "2"),
    ],
)
def test_for(loop: str, turns: str) -> None:
    main = f'VAR num a:=5;\nVAR num b:=2;\nFOR i FROM {loop} DO\nb:=9;\nTPWrite ""\\Num:=i;\nENDFOR'
    assert "".join(said(main)) == turns


def test_test_while_and_goto() -> None:
    main = """VAR num n;
WHILE n<5 DO
  n:=n+1;
  TEST n
  CASE 1,2: TPWrite "low";
  CASE 3: GOTO L1;
  DEFAULT: TPWrite "high";
  ENDTEST
ENDWHILE
L1:
TPWrite "L1";
IF n=3 THEN
  n:=10;
  GOTO L1;
ENDIF"""
    assert said(main) == ["low", "low", "L1", "L1"]


def test_exit_and_stop() -> None:
    assert ran('Stop;\nsub;\nTPWrite "no";', "PROC sub()\nEXIT;\nENDPROC").events == (
        Stopped(),
        Stopped(end=True),
    )


# --------------------------------------------------------------------------------------- ends


@pytest.mark.parametrize(
    ("main", "ended", "message"),
    [
        ("reg1:=1/0;", "error", "division by zero"),
        ("reg1:=1 DIV 0;", "error", "division by zero"),
        ("reg1:=1.5 DIV 1;", "error", "no whole number"),
        ("reg2:=1.5;\nk{reg2}:=1;", "error", "an index is 1.5"),
        ("k{3}:=1;", "error", "the index 3"),
        ("reg1:=nowhere;", "error", "no data `nowhere`"),
        ("reg1:=TRUE;", "error", "bool is assigned"),
        ("p10:=p20;", "error", "cannot be changed"),
        ("FOR i FROM 1 TO 2 DO\ni:=3;\nENDFOR", "error", "cannot be changed"),
        ("MoveL Offs(p10,Sqrt(-1),0,0),v100,fine,tool0;", "error", "defined"),
        ("WHILE TRUE DO\nENDWHILE", "steps", ""),
        ("Frobnicate 1;", "unknown", "`Frobnicate`"),
        ("SetDO\\SDelay:=1,doA,1;", "end", ""),
        ("again;", "unknown", "routines inside of one another"),
        ("handled;", "end", ""),
    ],
)
def test_ends(main: str, ended: str, message: str) -> None:
    more = "PROC again()\nagain;\nENDPROC\nPROC handled()\nreg1:=1/0;\nERROR\nRETURN;\nENDPROC"
    found = ran(main, more, "VAR num k{2};", most_steps=2000)
    assert found.ended == ended
    assert message in found.message


def test_an_error_is_told_with_its_line() -> None:
    tree = languages.get("rapid").parse(
        "MODULE M\nPROC main()\nsub;\nENDPROC\nPROC sub()\nreg1:=1/0;\nENDPROC\nENDMODULE"
    )
    assert run(tree).message == "6: division by zero (ERR_DIVZERO)"
    assert run(tree, entry="sub").message == "6: division by zero (ERR_DIVZERO)"
    assert run(tree, entry="nothing").ended == "error"


@pytest.mark.parametrize(
    ("declared", "main", "message"),
    [
        ("VAR r19 k;", "k:=k;", "a record `r19` of more than 1000000 elements"),
        ("VAR r9 k{1000};", "k{1}:=k{1};", "an array of more than 1000000 elements"),
        ("VAR twice k{10,100};", "k{1,1}:=k{1,1};", "an array of more than 1000000 elements"),
        ("VAR r3 k{10};", "k{1}:=k{2};", ""),
    ],
)
def test_data_is_counted_through_its_records_before_it_is_built(
    declared: str, main: str, message: str
) -> None:
    records = ["RECORD r0\nnum a;\nnum b;\nENDRECORD"]
    records += [f"RECORD r{i}\nr{i - 1} a;\nr{i - 1} b;\nENDRECORD" for i in range(1, 20)]
    types = "\n".join([*records, "ALIAS r9 twice;"])
    tree = languages.get("rapid").parse(
        f"MODULE M\n{types}\n{declared}\nPROC main()\n{main}\nENDPROC\nENDMODULE"
    )
    assert tree.findings == ()
    found = run(tree)
    assert (found.ended, found.message.endswith(message)) == ("unknown" if message else "end", True)

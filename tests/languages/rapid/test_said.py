"""What a module says, apart from its layout."""

from pathlib import Path

from assistant import languages
from assistant.base.diagnostics import has_errors
from tests.tables import every_row

RAPID = languages.get("rapid")
DATA = Path(__file__).parent / "data"


def said(text):
    return [form for form, _ in RAPID.said(text)]


@every_row("file", sorted(DATA.rglob("*.mod")))
def test_the_layout_of_a_module_says_nothing(file):
    source = RAPID.read(file)
    tree = RAPID.parse(source)
    forms = said(source.text)
    assert forms or not tree.parts
    if not has_errors(tree.findings):
        assert said(RAPID.format(tree)) == forms
        assert said("\r".join(source.text.upper().splitlines())) == said(source.text.upper())


@every_row(
    ("one", "other"),
    [
        ("PERS num a:=1.50;", "pers NUM A := 1.5;"),
        ("PERS num a:=1;", "PERS num a:=1.0;"),
        ("PERS num a:=0.05;", "PERS num a:=5E-02;"),
        ("CONST num a{2}:=[9E9,-0.00];", "CONST num a{2}:=[9E+09,0];"),
        ("PERS num a:=0.333333333;", "PERS num a:=0.333333;"),
        ("PERS num a:=1264.8649;", "PERS num a:=1264.86;"),
        ("PERS num a:=0x1F;", "PERS num a:=31;"),
        ("PERS dnum a:=1.50;", "PERS dnum a:=1.5;"),
        ("PROC p()\n\nM t,\\W:=w;\nENDPROC", "PROC p() M t\\W:=w; ENDPROC"),
        ("PROC p() ! begins\n! WaitTime 1;\nENDPROC", "PROC p()\nENDPROC"),
        ("%%%\nVERSION:1\n%%%\nMODULE a\nENDMODULE", "MODULE a ENDMODULE"),
    ],
)  # fmt: skip
def test_these_say_the_same(one, other):
    assert said(one) == said(other)


@every_row(
    ("one", "other"),
    [
        ("PERS num a:=1264.86;", "PERS num a:=1264.87;"),
        ("PERS num a:=1234567;", "PERS num a:=1234568;"),
        ("PERS dnum a:=1.23456789;", "PERS dnum a:=1.23456788;"),
        ("PERS num a:=0.1;", "PERS num a:=-0.1;"),
        ("PERS bool a:=TRUE;", "PERS bool a:=FALSE;"),
        ('PERS string a:="go  on";', 'PERS string a:="go on";'),
        ('PERS string a:="! x";', 'PERS string a:="! y";'),
        ('PERS string a:="A";', 'PERS string a:="a";'),
        ("PERS num a{2}:=[1,23];", "PERS num a{2}:=[12,3];"),
        ("PERS num a:=1;", "CONST num a:=1;"),
        ("PERS num a:=1;", "TASK PERS num a:=1;"),
        ("PROC p() WaitTime 1; ENDPROC", "PROC p() ! WaitTime 1;\nENDPROC"),
        ("PROC p() a:=1.0000001; ENDPROC", "PROC p() a:=1; ENDPROC"),
        ("PROC p() a:=b-0; ENDPROC", "PROC p() a:=b 0; ENDPROC"),
    ],
)
def test_these_do_not(one, other):
    assert said(one) != said(other)


def test_names_that_a_task_shares():
    text = (
        "MODULE m\nRECORD r\nnum x;\nENDRECORD\nALIAS num mm;\nPERS num a:=1;\nLOCAL VAR num b;\n"
        "TASK PERS num c:=1;\nPROC main(num q)\nVAR num z;\nENDPROC\nLOCAL PROC hidden()\nENDPROC\n"
        "FUNC num f()\nRETURN 1;\nENDFUNC\nTRAP t\nENDTRAP\nENDMODULE\n"
    )
    assert dict(RAPID.shared_names(RAPID.parse(text))) == {
        "r": "type", "mm": "type", "a": "data", "c": "data", "main": "procedure",
        "f": "function", "t": "trap routine",
    }  # fmt: skip


def test_names_of_many_targets_in_a_row():
    names = dict(RAPID.shared_names(RAPID.parse(RAPID.read(DATA / "point_list.mod"))))
    assert set(names.values()) == {"data", "procedure"} and len(names) > 10

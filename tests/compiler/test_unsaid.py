"""Of what crosses: calls of what does not, and what stands in it."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.compiler import translate

HEAD = """\
MODULE part
  VAR num n:=1;
  PROC main()
    {0}
    IF n>9 Outer;
    IF n>9 n:=Value();
  ENDPROC
  PROC Outer()
    Inner;
  ENDPROC
  PROC Inner()
    WaitTime 1;
    {1}
  ENDPROC
  PROC Whole()
    WaitTime 2;
  ENDPROC
  PROC Again(num k)
    WaitTime 3;
    IF k>0 Again k-1;
  ENDPROC
  FUNC num Value()
    {1}
    RETURN 1;
  ENDFUNC
ENDMODULE
"""
UNKNOWN = "IPathPos;"


def levels(folder: Path, main: str, inner: str) -> dict[str, tuple[str, set[str]]]:
    """Level and codes of each row, by its text."""
    file = folder / "part.mod"
    file.write_text(HEAD.format(main, inner), encoding="utf-8")
    done = translate(file, to="melfa-basic-5")
    return {row.text.rstrip(";"): (row.level, {f.code for f in row.reasons}) for row in done.rows}


@pytest.mark.parametrize("call", ["Inner", "Outer", "n:=Value()"])
def test_a_call_of_what_is_not_said_in_full_says_so(tmp_path: Path, call: str) -> None:
    rows = levels(tmp_path, f"{call};", UNKNOWN)
    assert rows["IPathPos"][0] == "not"
    assert rows[call] == ("partial", {"CO013"})
    assert rows["WaitTime 1"] == ("supported", set())
    rows = levels(tmp_path, f"{call};", "WaitTime 9;")
    assert "CO013" not in rows[call][1] and rows[call][0] != "not"


def test_a_call_of_what_is_whole_is_said(tmp_path: Path) -> None:
    assert levels(tmp_path, "Whole;", UNKNOWN)["Whole"] == ("supported", set())


def test_what_is_not_said_at_all_is_not_called_either(tmp_path: Path) -> None:
    rows = levels(tmp_path, "Again 3;", "WaitTime 9;")
    assert rows["PROC Again(num k)"][0] == "not"
    assert rows["Again 3"] == ("not", {"CO014"})
    assert rows["WaitTime 3"] == ("not", {"MB224"})
    assert rows["WaitTime 2"][0] == "supported"


def test_what_stands_in_a_block_that_is_not_said_is_not_said(tmp_path: Path) -> None:
    rows = levels(tmp_path, "IF OddFunction() THEN\n WaitTime 5;\n Whole;\n ENDIF", "WaitTime 9;")
    assert rows["IF OddFunction() THEN"][0] == "not"
    assert rows["WaitTime 5"] == rows["Whole"] == ("not", {"MB209"})


UNCALLED = """\
MODULE part
  CONST robtarget here:=[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR jointtarget none:=[[9E9,9E9,9E9,9E9,9E9,9E9],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS tooldata fixed:=[FALSE,[[0,0,50],[1,0,0,0]],[1,[0,0,10],[1,0,0,0],0,0,0]];
  PROC main()
    MoveL here,v100,fine,tool0;
    {call}
  ENDPROC
  PROC Old()
    none.extax.eax_a:=5;
    MoveL here,v100,fine,fixed;
  ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("call", ["", "Old;"])
def test_data_without_an_equivalent_go_with_what_nothing_calls(tmp_path: Path, call: str) -> None:
    file = tmp_path / "part.mod"
    file.write_text(UNCALLED.format(call=call), encoding="utf-8")
    done = translate(file, to="melfa-basic-6")
    assert done.ok is (not call)
    assert ("CO015" in {f.code for f in done.findings}) is (not call)
    if not call:
        (text,) = done.files.values()
        assert b"fixed" not in text and b"none" not in text


LOCALS = """\
MODULE part
  PROC main()
    WaitTime 1;
  ENDPROC
  PROC Old()
    VAR num count:=1005;
    CONST num most:=3;
    PERS bool first:=TRUE;
    CONST robtarget here:=[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    CONST speeddata slow:=[80,50,5000,1000];
    VAR num row{2}:=[1,2];
    ! a comment is no statement
    FOR i FROM 1 TO most DO
      OddStatement;
    ENDFOR
  ENDPROC
ENDMODULE
"""


def test_what_nothing_calls_is_reported_with_all_that_it_declares(tmp_path: Path) -> None:
    file = tmp_path / "part.mod"
    file.write_text(LOCALS, encoding="utf-8")
    done = translate(file, to="melfa-basic-6")
    inside = {
        *("PROC Old()", "VAR num count:=1005;", "CONST num most:=3;", "PERS bool first:=TRUE;"),
        *("CONST speeddata slow:=[80,50,5000,1000];", "VAR num row{2}:=[1,2];"),
        *("FOR i FROM 1 TO most DO", "OddStatement"),
    }
    told = {row.text: {f.code for f in row.reasons} for row in done.rows}
    assert all(told[text] >= {"CO015"} for text in inside)
    assert [row.level for row in done.rows if "CONST robtarget" in row.text] == ["partial"]
    assert done.totals == {"supported": 2, "partial": 9, "not": 0}
    assert [f.line for f in done.findings if f.code == "CO015"] == [5]


FORMS = """\
MODULE part
  CONST robtarget here:=[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR num few{{3}}:=[1,2,3];
  VAR num many{{2000}};
  PROC main()
    Add few;
    {more}
  ENDPROC
  PROC Add(VAR num list{{*}})
    MoveJ here,v100,fine,tool0;
    list{{2}}:=list{{1}};
  ENDPROC
  PROC Old()
    Add many;
  ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("more", ["", "OddStatement;"])
def test_a_routine_is_kept_where_only_a_form_of_it_is_not_called(tmp_path: Path, more: str) -> None:
    """`Add` for `many`, which is too long for MELFA-BASIC V, has the span of `Add` for `few`."""
    file = tmp_path / "part.mod"
    file.write_text(FORMS.format(more=more), encoding="utf-8")
    done = translate(file, to="melfa-basic-5", draft=True)
    told = {row.text: {f.code for f in row.reasons} for row in done.rows}
    assert told["PROC Add(VAR num list{*})"] == told["list{2}:=list{1}"] == set()
    assert told["PROC Old()"] == told["Add many"] == {"CO015"}
    (text,) = done.files.values()
    assert done.ok is (not more) and b"MFEW(2)=MFEW(1)" in text and b"Mov " in text

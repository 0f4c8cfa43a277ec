"""What no line of MELFA-BASIC holds, in several: both programs do the same."""

from __future__ import annotations

from pathlib import Path as FilePath

import pytest

from assistant import translate
from assistant.base.diagnostics import Severity
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load_text
from tests.virtual import rapid_words
from tests.virtual.test_translated_cases import HEAD
from tests.virtual.test_translated_rapid import says_the_same

RECORDS = """RECORD side
num number_of_parts;
num height_of_parts;
num length_of_parts;
string label_of_parts;
bool is_heavy;
ENDRECORD
RECORD rack
side left_side;
side right_side;
side upper_side;
ENDRECORD
VAR rack storage;
VAR rack other;
VAR num total;
"""
ROUTINES = """PROC fill(rack from_here,INOUT rack to_there,num factor)
to_there:=from_here;
to_there.left_side.number_of_parts:=to_there.left_side.number_of_parts*factor;
to_there.right_side.height_of_parts:=factor+from_here.upper_side.height_of_parts;
ENDPROC
FUNC num weigh(rack one,rack two)
total:=total+1;
RETURN one.left_side.number_of_parts*two.right_side.height_of_parts
+one.upper_side.height_of_parts-two.upper_side.height_of_parts+StrLen(one.upper_side.label_of_parts)
+one.right_side.height_of_parts+two.left_side.length_of_parts+one.left_side.length_of_parts;
ENDFUNC
FUNC bool is_near(rack one,rack two,num tolerance)
RETURN (Abs(one.left_side.number_of_parts-two.left_side.number_of_parts)<tolerance)
AND (Abs(one.right_side.height_of_parts-two.right_side.height_of_parts)<tolerance)
AND (Abs(one.upper_side.height_of_parts-two.upper_side.height_of_parts)<tolerance)
AND (Abs(one.left_side.length_of_parts-two.left_side.length_of_parts)<tolerance);
ENDFUNC
"""
SET = """storage.left_side.number_of_parts:=3;
storage.right_side.height_of_parts:=5;
storage.upper_side.height_of_parts:=7;
storage.upper_side.label_of_parts:="abc";
storage.left_side.length_of_parts:=2;
"""
MOVE = "MoveL Offs(p10,0,0,n),v100,fine,tGripper;"
NUMBERS = "+tab+".join(
    f"NumToStr(storage.{side}_side.{part}_of_parts,0)"
    for side in ("left", "right", "upper")
    for part in ("number", "height", "length")
)
CASES = {
    "a call with many parameters": f"fill storage,other,2;n:=other.left_side.number_of_parts;{MOVE}"
    f"n:=other.right_side.height_of_parts;{MOVE}",
    "a sum of long calls": "fill storage,other,1;n:=weigh(other,storage)+weigh(storage,other);"
    f"{MOVE}n:=total;{MOVE}",
    "a sum whose calls change where it goes": "fill storage,other,1;total:=100;"
    f"total:=weigh(other,storage)+weigh(storage,other)+total;n:=total/2;{MOVE}",
    "a truth that is given back": f"n:=0;IF is_near(storage,storage,1) n:=n+1;{MOVE}"
    f"IF is_near(storage,other,1) n:=n+2;IF is_near(other,storage,9) n:=n+4;{MOVE}",
    "a long text": f"line:={NUMBERS}+tab+{NUMBERS};n:=StrLen(line);{MOVE}"
    f'IF StrPart(line,3,1)="5" SetDO do1,1;',
    "a text that is added to itself": f'line:="x";line:={NUMBERS}+tab+line+tab+{NUMBERS};'
    f"n:=StrLen(line);{MOVE}",
}


@pytest.mark.parametrize("name", CASES)
def test_it_does_the_same(name: str, tmp_path: FilePath) -> None:
    text = (
        f'{HEAD}{RECORDS}PROC main()\nVAR num n;\nVAR string line;\nVAR string tab:=",";\n'
        f"{SET}{CASES[name]}\nENDPROC\n{ROUTINES}ENDMODULE\n"
    )
    says_the_same((name, text, ({},)), "melfa-basic-6", tmp_path)


def test_what_fits_stays_as_it_is(tmp_path: FilePath) -> None:
    process = tmp_path / "cell.process.toml"
    process.write_text(rapid_words.process_file(), encoding="utf-8")
    text = (
        f"{HEAD}VAR num n;\nPROC main()\nadd n,2,3;\nENDPROC\n"
        "PROC add(INOUT num to_it,num a,num b)\nto_it:=a+b;\nENDPROC\nENDMODULE\n"
    )
    done = translate(
        load_text(SourceText(text), process=process, language="rapid"), to="melfa-basic-6"
    )
    assert "MB223" not in {f.code for f in done.findings}


def test_an_array_remains_a_parameter_beside_those_that_do_not() -> None:
    numbers = ",".join(f"num quantity_of_item_{at}" for at in range(12))
    text = (
        "MODULE shelf\nVAR num total;\n"
        f"PROC sum_up({numbers},INOUT num held{{*}})\n"
        "held{1}:=quantity_of_item_0+quantity_of_item_11;\ntotal:=held{2};\nENDPROC\nENDMODULE\n"
    )
    done = translate(load_text(SourceText(text), language="rapid"), to="melfa-basic-6")
    assert not {f.code for f in done.findings if f.severity is Severity.ERROR} - {"MB245"}
    assert "MB223" in {f.code for row in done.rows for f in row.reasons}


SHELVES = """MODULE shelves
PROC fill(INOUT num held{*},num first)
IF Dim(held,1)<2 RETURN;
spread held,first,Dim(held,1);
ENDPROC
PROC spread(INOUT num to_all{*},num first,num last)
FOR at FROM 1 TO Dim(to_all,1) DO
to_all{at}:=first+at-last;
ENDFOR
ENDPROC
ENDMODULE
"""


def test_a_library_takes_the_sizes_of_its_arrays() -> None:
    done = translate(load_text(SourceText(SHELVES), language="rapid"), to="melfa-basic-6")
    assert not {f.code for f in done.findings if f.severity is Severity.ERROR} - {"MB245"}
    assert not done.totals["not"]
    assert "RA352" in {f.code for row in done.rows for f in row.reasons}
    fill, spread = done.compiled.program.procedures
    assert [q.name for q in fill.parameters] == ["held", "first", "held_count"]
    assert [q.name for q in spread.parameters] == ["to_all", "first", "last", "to_all_count"]


def test_a_program_with_a_main_knows_the_sizes_of_its_arrays(tmp_path: FilePath) -> None:
    called = "VAR num shelf{3};\nPROC main()\nfill shelf,5;\nENDPROC\n"
    text = SHELVES.replace("PROC fill", f"{called}PROC fill")
    done = translate(load_text(SourceText(text), language="rapid"), to="melfa-basic-6")
    assert done.ok and "RA352" not in {f.code for row in done.rows for f in row.reasons}

"""Cell files that say of what components a record is, whose type nobody declares."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.base.diagnostics import Refused
from assistant.compiler import Translation, load, translate
from assistant.compiler.cell_defaults import cell_text, neutral_cell, with_cell_values
from assistant.compiler.motion_proof import Proving
from assistant.sources.cell_values import NO_CELL
from tests.compiler.test_filling import program

USES = """MODULE Cell
  CONST robtarget p10:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST message mNone:=[[7,"go",0],FALSE];
  VAR message m:=[[1,"stop",30],TRUE];
  VAR stamp at;
  PROC main()
    IF m.full rTell m;
    shared{2}.Data.way:=25;
    m.data:=shared{2}.data;
    m.data.word:=m.data.word+"x";
    at.n:=at.n+m.data.way;
    MoveL Offs(p10,m.data.way,at.n,0),v100,fine,tool0;
    other.on:=m.full;
    m:=mNone;
    %m.data.word%;
    IF NOT (m.full OR other.on) MoveL p10,v100,fine,tool0;
    MoveL Offs(p10,0,shared{1}.data.way,m.data.way),v100,fine,tool0;
  ENDPROC
  PROC rTell(VAR message one)
    one.full:=FALSE;
  ENDPROC
  PROC go()
    MoveL Offs(p10,5,0,0),v100,fine,tool0;
  ENDPROC
ENDMODULE
"""
ASKED = (
    """[records.message]
components = ["message_data data", "bool full"]  # type and name of each in their order""",
    """
[records.message_data]
components = ["num way", "string word", "num part_3"]""",
    """
[records.stamp]
components = ["num n"]""",
    """
[records.other_type]
components = ["bool on"]""",
    """
[data.shared]
type = "message"
value = [[[0, "", 0], false], [[0, "", 0], false]]""",
)


def told(folder: Path, cell: str) -> Translation:
    path = folder / "cell.toml"
    path.write_text(cell, encoding="utf-8")
    return translate(program(folder, USES), to="melfa-basic-6", cell=path, proving=Proving())


def test_components_are_asked_for_with_what_their_uses_and_values_tell(tmp_path: Path) -> None:
    text = neutral_cell(load(program(tmp_path, USES)))
    for entry in ASKED:
        assert entry in text, text


@pytest.mark.parametrize("third", [False, True])
def test_with_the_components_of_the_cell_file_it_is_whole_and_proven(
    tmp_path: Path, third: bool
) -> None:
    cell = neutral_cell(load(program(tmp_path, USES)))
    if third:  # as the uses cannot tell
        cell = cell.replace(
            '"num way", "string word", "num part_3"', '"num id", "string word", "num way"'
        )
    done = told(tmp_path, cell)
    assert done.ok, [f"{f.code} {f.message}" for f in done.findings]
    assert done.motion is not None and done.motion.holds


def test_a_place_for_them_tells_what_they_may_be(tmp_path: Path) -> None:
    loaded = with_cell_values(load(program(tmp_path, USES)), NO_CELL, tmp_path / "cell.toml")
    text = cell_text(NO_CELL, loaded.wanting)
    assert 'components = "?"  # type and name of each in their order; perhaps ["num n"]' in text


@pytest.mark.parametrize("components", ["[]", '["num"]', '["num a b"]', "3", '["num 3a"]'])
def test_what_are_no_components_is_told(tmp_path: Path, components: str) -> None:
    with pytest.raises(Refused) as refused:
        told(tmp_path, f"[records.message]\ncomponents = {components}\n")
    assert [finding.line for finding in refused.value.findings] == [2]


def test_uses_that_disagree_with_the_values_are_not_asked_for(tmp_path: Path) -> None:
    text = """MODULE Cell
  VAR odd o:=[1,2];
  VAR same s:=["a"];
  PROC main()
    o.word:="x";
    s.a:="x";
    s.b:="y";
  ENDPROC
ENDMODULE
"""
    assert "records" not in neutral_cell(load(program(tmp_path, text)))


OPEN = """MODULE Cell
  RECORD box
    num width;
    num height;
  ENDRECORD
  VAR box one;
  PROC main()
    one.width:=3;
    one.height:=one.width+1;
    SetGO goSize,one.height;
    SetDO doGrip,1;
  ENDPROC
ENDMODULE
"""


def test_a_draft_that_lacks_a_value_says_all_else_as_the_whole_program_does(
    tmp_path: Path,
) -> None:
    """Records too: what is put in front of a program takes none of its data away."""
    path = tmp_path / "cell.toml"
    done = translate(program(tmp_path, OPEN), to="melfa-basic-6", cell=path)
    assert [one.name for one in done.wanting] == ["doGrip", "goSize"]
    assert done.draft
    assert done.totals["not"] == 0, [row for row in done.rows if row.level == "not"]
    (text,) = (data.decode() for data in done.files.values())
    assert "DRAFT: not for production" in text
    assert text.index("Hlt") < text.index("Mone_width=3") < text.index("Mone_height=")


def test_a_component_whose_uses_tell_no_type_has_that_of_its_values(tmp_path: Path) -> None:
    """Components that are only copied from record to record may be texts."""
    file = tmp_path / "Cell.mod"
    body = "aNow:=aJob;\n    aNow.label:=aJob.label;\n    IF aNow.count>1 SetDO doOn,1;"
    data = '  PERS job aJob:=["weld",2];\n  VAR job aNow;\n'
    text = f"MODULE Cell\n{data}  PROC main()\n    {body}\n  ENDPROC\nENDMODULE\n"
    file.write_text(text, encoding="utf-8")
    asked = neutral_cell(load(file))
    assert 'components = ["string label", "num count"]' in asked

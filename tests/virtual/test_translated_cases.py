"""Small RAPID programs that random ones were cut down to: each did something else once."""

from __future__ import annotations

from pathlib import Path as FilePath

import pytest

import assistant
from assistant import languages
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load_text
from assistant.virtual.events import Moved, Stopped, Switched
from tests.virtual import rapid_words
from tests.virtual.test_translated_rapid import LANGUAGES, run_melfa, says_the_same
from tests.virtual.translating import in_turn

HEAD = f"""MODULE Cell
PERS tooldata tGripper:={rapid_words.TOOLS["tGripper"]};
PERS tooldata tCam:={rapid_words.TOOLS["tCam"]};
PERS wobjdata wobjTable:={rapid_words.FRAMES["wobjTable"]};
CONST robtarget p10:=[[354,0,300],[0,0,1,0],[0,0,0,0],{rapid_words.UNUSED}];
"""
CASES = {
    "turns about several axes that add up": """VAR robtarget pt;
PROC main()
  pt:=p10;
  FOR i FROM 1 TO 40 DO
    pt:=RelTool(pt,0,0,22.25\\Rx:=15\\Rz:=30);
  ENDFOR
  MoveL pt,v100,fine,tGripper;
ENDPROC""",
    "functions that hide those of the controller": """VAR num n:=2;
PROC main()
  MoveL Offs(p10,Max(n,3),Abs(n),Length(n)),v100,fine,tGripper;
  SetGO goSlot,Max(0,Min(n,1));
ENDPROC
FUNC num Max(num a,num b)
  RETURN a*10+b;
ENDFUNC
FUNC num Min(num a,num b)
  RETURN a+b;
ENDFUNC
FUNC num Abs(num a)
  RETURN a-40;
ENDFUNC
FUNC num length(num a)
  RETURN a+7;
ENDFUNC""",
    "a routine reads what its caller has another of": """VAR num nRow;
PROC main()
  VAR num nRow:=4;
  sub;
  MoveL Offs(p10,nRow,0,0),v100,fine,tGripper;
ENDPROC
PROC sub()
  nRow:=nRow+1;
  MoveL Offs(p10,nRow,0,0),v100,fine,tGripper;
ENDPROC""",
    "signals by functions, and high and low": """PROC main()
  SetDO do1,high;
  IF DInput(di1)=high AND DOutput(do1)=1 SetDO doGrip,1;
  SetGO goSlot,GInput(giOrder);
  SetDO do1,low;
ENDPROC""",
    "waits for the robot to stand": """VAR num reg2:=1;
PROC main()
  MoveL p10,v100,z10,tGripper;
  ! there
  WaitRob\\InPos;
  SetDO do1,1;
  MoveL Offs(p10,30,0,0),v100,fine,tGripper;
  arrived;
  MoveL p10,v100,z50\\Inpos:=inpos20,tGripper;
ENDPROC
PROC arrived()
  WaitRob\\ZeroSpeed;
  WaitTime\\InPos,0.5;
ENDPROC""",
    "rows of tables as tools and work objects": f"""
PERS tooldata tAll{{2}}:=[{rapid_words.TOOLS["tPen"]},{rapid_words.TOOLS["tCam"]}];
PERS wobjdata wAll{{1}}:=[{rapid_words.FRAMES["wobjFixture"]}];
PROC main()
  MoveL p10,v100,fine,tAll{{2}};
  MoveL Offs(p10,0,0,30),v100,fine,tAll{{1}}\\WObj:=wAll{{1}};
ENDPROC""",
    "targets turned about several axes of the tool": """VAR num n:=7;
VAR robtarget pt;
PROC main()
  MoveL RelTool(p10,n,0,2*n\\Rx:=15\\Ry:=20\\Rz:=-30),v100,fine,tGripper;
  pt:=RelTool(p10,0,0,-n);
  MoveL RelTool(pt,0,n,5\\Rx:=15\\Rz:=40),v100,fine,tGripper;
  MoveL RelTool(pt,1,2,3\\Rx:=15\\Rz:=40),v100,fine,tGripper;
ENDPROC""",
    "targets a distance along the tool, one within another": """VAR num n:=7;
PROC main()
  MoveL raised(RelTool(p10,0,0,-n)),v100,fine,tGripper;
  MoveL RelTool(RelTool(p10,0,0,-n),0,0,n\\Rz:=0),v100,fine,tGripper;
  MoveL RelTool(raised(RelTool(p10,0,0,n)),0,0,-2*n),v100,fine,tGripper;
ENDPROC
FUNC robtarget raised(robtarget place)
  RETURN Offs(place,0,0,1);
ENDFUNC""",
    "switches of routines": """VAR num n;
PROC main()
  add 1\\twice;
  add 2;
  n:=n+of(n\\less);
  other\\fast;
  MoveL Offs(p10,n,0,0),v100,fine,tGripper;
ENDPROC
PROC other(\\switch fast|switch slow)
  add of(3)\\twice?fast;
  add 1\\twice?slow;
ENDPROC
PROC add(num by\\switch twice)
  VAR num count;
  IF Present(twice) SetDO do1,1;
  count:=by;
  n:=n+count;
  IF Present(twice) n:=n+by;
ENDPROC
FUNC num of(num q\\switch less)
  IF Present(less)=TRUE RETURN q-1;
  RETURN q;
ENDFUNC""",
    "corners, speeds and tools beside a function that moves": """VAR num n;
PROC main()
  MoveL p10,v100,z10,tGripper;
  n:=seen(3);
  MoveL Offs(p10,0,0,20),v100,z10,tGripper;
  MoveL Offs(p10,seen(4),0,0),v100,z10,tGripper;
ENDPROC
FUNC num seen(num q)
  MoveL Offs(p10,0,q,0),v500,z1,tool0;
  RETURN q;
ENDFUNC""",
    "registers that every controller has": """PROC main()
  reg1:=reg1+3;
  FOR i FROM 1 TO reg1 DO
    Incr reg5;
    MoveL Offs(p10,reg5,0,0),v100,fine,tGripper;
  ENDFOR
ENDPROC""",
    "data that is called as a constant is": """VAR num low:=7;
PROC main()
  MoveL Offs(p10,low,0,0),v100,fine,tGripper;
ENDPROC""",
    "an array that is given another one": """PROC main()
  VAR num few{2}:=[1,2];
  VAR num two{2};
  VAR num rows{3,2}:=[[1,2],[3,4],[5,6]];
  VAR num others{3,2};
  two:=few;
  IF two{2}=2 others:=rows;
  few{1}:=9;
  rows{3,2}:=9;
  MoveL Offs(p10,two{1},others{3,2},others{1,1}),v100,fine,tGripper;
ENDPROC""",
    "any number but 0 sets a digital output": """PROC main()
  VAR num n:=2;
  SetDO do1,n;
  n:=n-2;
  SetDO doGrip,1;
  SetDO doGrip,n*2;
  SetDO doVacuum,DOutput(do1);
ENDPROC""",
    "a truth that a function gives back": """FUNC bool isLow(num n,bool wanted)
  IF n<5 THEN
    RETURN wanted;
  ENDIF
  RETURN DOutput(do1)=1;
ENDFUNC
PROC main()
  VAR bool low;
  low:=isLow(3,TRUE);
  IF low SetDO do1,1;
  IF isLow(7,FALSE) AND low SetDO doGrip,1;
ENDPROC""",
    "a truth that a routine is given to change": """VAR bool low;
PROC main()
  Turn low;
  IF low SetDO do1,1;
  MoveL p10,v100,fine,tGripper;
ENDPROC
PROC Turn(INOUT bool what)
  VAR bool other;
  what:=NOT what;
  other:=what;
  IF what Again other;
ENDPROC
PROC Again(INOUT bool what)
  what:=FALSE;
  SetDO doGrip,1;
ENDPROC""",
    "numbers that a group has bits for": """VAR num n:=14;
FUNC num fNext()
  n:=n+1;
  RETURN n;
ENDFUNC
PROC main()
  n:=14;
  SetGO goSlot,n;
  SetGO goSlot,fNext();
  SetGO goProgram,n*2+1;
ENDPROC""",
}
SCENARIOS = ({}, {"di1": 1.0, "giorder": 5.0})


ALSO = {
    ("corners, speeds and tools beside a function that moves", "melfa-basic-6"),
    ("targets a distance along the tool, one within another", "melfa-basic-6"),
    ("numbers that a group has bits for", "melfa-basic-6"),
}


@pytest.mark.parametrize(("name", "language"), in_turn(CASES, [*LANGUAGES], ALSO))
def test_it_does_the_same(name: str, language: str, tmp_path: FilePath) -> None:
    text = f"{HEAD}{CASES[name]}\nENDMODULE\n"
    says_the_same((name, text, SCENARIOS), language, tmp_path)


@pytest.mark.parametrize(("value", "language"), in_turn(["n", "-n", "n-6+n"], [*LANGUAGES]))
def test_what_a_group_has_no_bits_for_stops_the_program(
    value: str, language: str, tmp_path: FilePath
) -> None:
    process = tmp_path / "cell.process.toml"
    process.write_text(rapid_words.process_file(), encoding="utf-8")
    main = f"VAR num n:=16;\nSetGO goSlot,{value};\nMoveL p10,v100,fine,tGripper;"
    text = f"{HEAD}PROC main()\n{main}\nENDPROC\nENDMODULE\n"
    loaded = load_text(SourceText(text), process=process, language="rapid")
    (data,) = assistant.translate(loaded, to=language).files.values()
    written = languages.get(language).decode(data).text
    events = run_melfa(language, written, {}, 1000).events
    assert Stopped() in events
    assert not [event for event in events if isinstance(event, Switched | Moved)]

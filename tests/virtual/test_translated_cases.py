"""Small RAPID programs that random ones were cut down to: each did something else once."""

from __future__ import annotations

from pathlib import Path as FilePath

import pytest

from tests.virtual import rapid_words
from tests.virtual.test_translated_rapid import LANGUAGES, NUMBERS, run_melfa, run_rapid
from tests.virtual.translating import Tally, judge

HEAD = f"""MODULE Cell
PERS tooldata tGripper:={rapid_words.TOOLS["tGripper"]};
PERS tooldata tCam:={rapid_words.TOOLS["tCam"]};
PERS wobjdata wobjTable:={rapid_words.FRAMES["wobjTable"]};
CONST robtarget p10:=[[354,0,300],[0,0,1,0],[0,0,0,0],{rapid_words.UNUSED}];
"""
CASES = {
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
    "data that is called as a constant is": """VAR num low:=7;
PROC main()
  MoveL Offs(p10,low,0,0),v100,fine,tGripper;
ENDPROC""",
}
SCENARIOS = ({}, {"di1": 1.0, "giorder": 5.0})


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("name", CASES)
def test_it_does_the_same(name: str, language: str, tmp_path: FilePath) -> None:
    process = tmp_path / "cell.process.toml"
    process.write_text(rapid_words.process_file(), encoding="utf-8")
    tally = Tally()
    judge(
        tally,
        name,
        f"{HEAD}{CASES[name]}\nENDMODULE\n",
        SCENARIOS,
        source=("rapid", run_rapid),
        target=(language, lambda *given: run_melfa(language, *given)),
        process=process,
        signals=NUMBERS,
    )
    assert tally.kept == []
    assert not tally.reasons
    assert tally.counts["equal"] == 1

"""Speeds and zones that are variables, but hold one value only, cross over as constants."""

from __future__ import annotations

from functools import partial

import pytest

from tests.compiler.proven import crossed_module, moves_the_same

HEAD = """MODULE Cell
CONST robtarget p10:=[[354,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
RECORD pace
  speeddata speed;
  zonedata zone;
ENDRECORD
VAR pace all;
VAR speeddata slow;
VAR zonedata near;
"""
crossed = partial(crossed_module, HEAD, runs=2)


def test_a_speed_that_is_given_one_value_is_that_value() -> None:
    done = crossed("""PROC main()
      begin;
      slow:=v150;
      MoveL p10,all.speed,all.zone,tool0;
      MoveL Offs(p10,0,0,20),slow,fine,tool0;
    ENDPROC
    PROC begin()
      all.speed:=[120,500,5000,1000];
      ! behind the speed
      all.zone:=z20;
    ENDPROC""")
    moves_the_same(done)
    text = b"".join(done.files.values()).decode("ascii")
    assert ("Spd 120" in text, "Cnt 1,20,20" in text, "Spd 150" in text) == (True, True, True)
    told = [row.text for row in done.rows if any(f.code == "RA345" for f in row.reasons)]
    assert told == ["slow:=v150", "all.speed:=[120,500,5000,1000]", "all.zone:=z20"]


@pytest.mark.parametrize(
    "body",
    [
        "slow:=v150; MoveL p10,slow,fine,tool0; slow:=v200; MoveL p10,slow,fine,tool0;",
        "slow:=v150; slow.v_tcp:=slow.v_tcp/2; MoveL p10,slow,fine,tool0;",
        "MoveL p10,slow\\T:=5,fine,tool0; slow:=v150; MoveL p10,slow,fine,tool0;",
        "MoveL p10,v100,near,tool0; near:=z50; MoveL p10,v100,near,tool0;",
        "MoveL p10,slow,near,tool0; slow:=v150; WaitTime 1; near:=z50;",
    ],
    ids=["two values", "a part", "a time", "a zone alone", "a zone set later"],
)
def test_one_that_may_hold_another_is_not_settled(body: str) -> None:
    done = crossed(f"PROC main()\n{body}\nENDPROC")
    texts = [row.text for row in done.rows if any(f.code == "RA345" for f in row.reasons)]
    assert done.ok == ("\\T" not in body and "slow,near" not in body), body
    assert not any(text.startswith("near") for text in texts)
    assert not texts or "near" in body

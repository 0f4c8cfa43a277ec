"""Words of MELFA-BASIC, with arguments that they may have."""

from __future__ import annotations

from functools import cache
from typing import Final

from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.vocabulary import Statement

FORMS: Final[dict[str, tuple[str, ...]]] = {
    "Accel": ("", "50,50", "80,80,100,100", "{v},{v}"),
    "Base": ("{p}", "P_NBase", "{c}"),
    "Cnt": ("0", "1", "1,5,5", "1,10"),
    "Fine": ("100", "0", "30,1", "0.5,P"),
    "JOvrd": ("50", "100", "{v}"),
    "JRC": ("1,1", "+1", "-1", "+1,2"),
    "LoadSet": ("1", "1,1", "0,0"),
    "MvTune": ("1", "2"),
    "Mxt": ("1,1", "2,0,50"),
    "Oadl": ("On", "Off"),
    "Ovrd": ("50", "100", "{v}", "80,50"),
    "Prec": ("On", "Off"),
    "Servo": ("On", "Off", "On,1"),
    "Spd": ("100", "{v}", "M_NSpd", "250.5"),
    "SpdOpt": ("On", "Off"),
    "Tool": ("{p}", "P_NTool", "{c}"),
    "Torq": ("1,50", "4,10"),
    "CavChk": ("On", "Off", "On,1"),
    "Cmp": ("Off", "Pos,&B1", "Tool,&B11", "Jnt,&B100011"),
    "CmpG": ("", "1,1,1", ",,0.5"),
    "ColChk": ("On", "Off", "On,NoErr"),
    "ColLvl": ("", "100,80", ",80"),
    "HClose": ("1", "{h}"),
    "HOpen": ("1", "2", "1,30,20,0.5"),
    "EHMov": ("1,{p}", "1,10"),
    "EHServo": ("On,1", "Off,1"),
    "Fsc": ("On,0,1,1", "Off"),
    "FsHndEst": ("On", "Off"),
    "FsLog": ("On,1", "Off"),
    "FsTest": ("On", "Off"),
    "FsGChg": ("1,2,1", "0,10,101"),
    "Act": ("1=1", "1=0", "0=1"),
    "Dly": ("0.1", "1", "{v}"),
    "Error": ("9000", "9100"),
    "GetM": ("1",),
    "RelM": ("",),
    "Priority": ("1", "3,2"),
    "Wait": ("{q}", "M_In(1)=1", "{q} And {q}"),
    "XClr": ("2",),
    "XLoad": ('2,"JOB"',),
    "XRst": ("2",),
    "XRun": ("2", '2,"JOB"', '3,"JOB",1'),
    "XStp": ("2",),
    "ChrSrch": ('C1$,"a",3',),
    "Clr": ("1", "0"),
    "GpsChk": ("On,1", "Off,1"),
    "Trk": ("On,{p}", "Off"),
    "TrkMv": ("On,{p}", "Off"),
    "TrkFine": ("On,1", "Off"),
    "Title": ('"job"',),
}
"""Word → arguments that it may have: {m} number, {v} numeric variable, {p} position variable,
{c} position constant, {q} condition, {h} hand, {a} three points of an arc."""
LEFT_OUT: Final = frozenset(
    *(("While", "WEnd", "Break", "Default", "Else", "EndIf", "End", "FEnd", "Return", "Skip"),)
)
MOTIONS: Final = {
    "Mov": ("{t}", "{t},{d}", "{j}", "{t}"),
    "Mvs": ("{t}", "{t},{d}", ",{d}", "{t}"),
    "Mvr": ("{a}",),
    "EMvr": ("{a}",),
    "EMvr2": ("{a}",),
    "EMvr3": ("{a}",),
    "EMvc": ("{a}",),
    "EMvSpl": ("{p},50,2",),
    "EMvs": ("{p}",),
    "MvSpl": ("{p},50,2",),
    "Mvr2": ("{a}",),
    "Mvr3": ("{a}",),
    "Mvc": ("{a}",),
    "Mva": ("{p},1", "{p}"),
}


@cache
def commands(level: int) -> tuple[Statement, ...]:
    return tuple(
        one
        for one in vocabulary.statements().values()
        if one.role == "command" and level in one.dialects and one.word not in LEFT_OUT
    )


@cache
def motions(level: int) -> tuple[Statement, ...]:
    return tuple(
        one
        for one in vocabulary.statements().values()
        if one.role == "motion" and level in one.dialects
    )

"""Words of MELFA-BASIC: one place for the parser, the printer, the checks and the docs.

Spellings and versions from the instruction lists of the makers' programming tools.
"""

from __future__ import annotations

from typing import Final

COMMANDS: Final = (
    "Accel", "Act", "Base", "Break", "BrkLock", "CavChk", "ChrSrch", "Clr", "Cmp", "CmpG", "Cnt",
    "ColChk", "ColLvl", "Default", "Dly", "EBRead", "EBWrite", "EHClose", "EHHold", "EHMov",
    "EHOpen", "EHOrg", "EHServo", "EHStop", "EHTbl", "Else", "End", "EndIf", "Error", "FEnd",
    "Fine", "Fsc", "FsCTrg", "FsGChg", "FsGetDat", "FsHndEst", "FsLog", "FsOutLog", "FsTAlgo",
    "FsTBat", "FsTCond", "FsTest", "GetM", "GpsChk", "HClose", "Hlt", "HOpen", "JOvrd", "JRC",
    "LoadSet", "MvTune", "Mxt", "NVClose", "NVIn", "NVLoad", "NVOpen", "NVPst", "NVRun", "NVTrg",
    "Oadl", "Ovrd", "PlChng", "Prec", "Priority", "RelM", "Remove", "Reset Err", "Return",
    "Servo", "SetCalFrm", "SetMoTrg", "Skip", "Spd", "SpdOpt", "SplFWrt", "SplWrt", "Title",
    "Tool", "Torq", "TrBase", "TrChk", "TrClr", "Trk", "TrkArc", "TrkChk", "TrkFine", "TrkMv",
    "TrkTrg", "TrkWait", "TrOut", "TrRd", "TrWrt", "Wait", "WEnd", "While", "XClr", "XLoad",
    "XRst", "XRun", "XStp",
)  # fmt: skip
"""Statements that are a word and a list of arguments, as the tools spell them."""

MOTIONS: Final = (
    "Mov", "Mvs", "Mvr", "Mvr2", "Mvr3", "Mvc", "Mva", "MvSpl", "EMvs", "EMvr", "EMvr2",
    "EMvr3", "EMvc", "EMvSpl",
)  # fmt: skip

OTHERS: Final = (
    "And", "Arch", "As", "ByRef", "ByVal", "CallP", "Case", "Char", "Close", "Com", "Const",
    "Def", "Dim", "Double", "ElseIf", "Exit", "Float", "For", "FPrm", "Function", "GoSub", "GoTo",
    "If", "Include", "Input", "Inte", "Io", "Is", "Jnt", "Long", "Map", "Mod", "Next", "Not",
    "Off", "On", "Open", "Or", "Plt", "Pos", "Print", "Rem", "Select", "Static", "Step", "Then",
    "To", "Type", "Work", "Wth", "WthIf", "Xor",
)  # fmt: skip

FUNCTIONS: Final = (
    "Abs", "ACos", "Align", "Asc", "ASin", "Atn", "Atn2", "Bin", "CalArc", "Chr", "CInt", "CkSum",
    "Cos", "Cvd", "Cvi", "Cvs", "Deg", "Dist", "Dot", "Exp", "Fix", "Fram", "Hex", "Int", "Inv",
    "JtoP", "Left", "Len", "Ln", "Log", "Max", "Mid", "Min", "Mirror", "Mkd", "Mki", "Mks",
    "PCalObtP", "PosCq", "PosMid", "PtoJ", "PVSCal", "PVSDrct", "Rad", "RdFl1", "RdFl2", "Right",
    "Rnd", "SetFl1", "SetFl2", "SetJnt", "SetPos", "Sgn", "Sin", "SplECord", "SplPos", "SplSpd",
    "Sqr", "Str", "StrLwr", "StrPos", "StrUpr", "Tan", "TrPos", "TrWcur", "Val", "Zone", "Zone2",
    "Zone3",
)  # fmt: skip

SPELLING: Final = {word.upper(): word for word in (*OTHERS, *COMMANDS, *MOTIONS)} | {
    "END IF": "EndIf",
    "ELSE IF": "ElseIf",
}
"""Upper case → as the tools spell it."""

RESERVED: Final = frozenset(SPELLING) | {word.upper() for word in FUNCTIONS}
"""Words that no variable or label may be called."""


def spelled(word: str) -> str:
    """A keyword of any case as the tools spell it; words that are not listed stay."""
    plain = " ".join(word.split())
    return SPELLING.get(plain.upper(), plain)


PRECEDENCE: Final = {
    "XOR": 1, "OR": 2, "AND": 3, "NOT": 4,
    "=": 5, "<>": 5, "><": 5, "<": 5, "<=": 5, "=<": 5, ">": 5, ">=": 5, "=>": 5,
    "<<": 6, ">>": 6, "+": 7, "-": 7, "MOD": 8, "\\": 9, "*": 10, "/": 10,
}  # fmt: skip
"""Higher binds tighter (CR1D detailed specifications, order of operations)."""
SIGN_PRECEDENCE: Final = 11
POWER_PRECEDENCE: Final = 12

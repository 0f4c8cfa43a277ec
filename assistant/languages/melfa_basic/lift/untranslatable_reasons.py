"""Reasons why a statement has no equivalent, and what to write instead."""

from __future__ import annotations

from typing import Final

from assistant.languages import vendor_statements as kept
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.statements import Reason

MOVE_TYPE: Final = Reason(
    "the move's `Type` asks for another way than usual", "leave `Type` out, or set points between"
)
COMPUTED_PROGRAM: Final = Reason(
    "which program runs is worked out while it runs",
    "choose with Select Case among CallP statements with names in quotes",
)
FULL_CIRCLE: Final = Reason(
    "a full circle is no statement elsewhere, and its points are set by the program, or on a line",
    "write two arcs with Mvr",
)
BUILT_POSITION: Final = Reason(
    "the place is put together of numbers that the program works out, or of less than six",
    "give a variable the numbers one by one, and name that",
)
NO_PROCEDURE: Final = Reason(
    "it calls lines that are no subroutine: others run or jump into them, or out of them",
    "begin the subroutine with a label of its own behind End, Return or GoTo, end it with Return",
)
NO_LABEL: Final = Reason(
    "it jumps into another subroutine, into a block, or to a line that there is none of",
    "jump to a label of the same subroutine that stands in no block, or call it with GoSub",
)
NO_SUBROUTINE: Final = Reason(
    "it returns from lines that are no subroutine",
    "begin the subroutine with a label that GoSub calls, behind End, Return or GoTo",
)
COMPUTED_SIGNAL: Final = Reason(
    "which input or output it is is worked out while the program runs", "write its number"
)
SLIDING_AXIS: Final = Reason(
    "no program tells whether an additional axis turns or slides",
    "copy its place from another position, or state it in the position's own line",
)
FRACTIONAL_STEP: Final = Reason(
    "a variable of whole numbers counts by what is no whole number",
    "count with a variable of other numbers",
)
DELAYED_ASSIGNMENT: Final = Reason(
    "the assignment comes late, by `Dly`", "put Dly above a plain assignment"
)
_HANDS: Final = Reason(
    "it drives a hand of the maker's with its own motor",
    "open and close with HOpen and HClose, or by signals",
)
_ERRORS: Final = Reason("it raises or clears an error", "set a signal, or stop with Hlt")
_PALLETS: Final = Reason("it counts places of a pallet", "work the positions out with M variables")

_WORDS: Final = {
    kept.INTERRUPTS: "Act",
    kept.TASKS: "GetM Priority RelM XClr XLoad XRst XRun XStp Skip",
    kept.CAMERAS: "EBRead EBWrite NVClose NVIn NVLoad NVOpen NVPst NVRun NVTrg SetCalFrm V3Calc"
    " V3Calib V3Close V3Open V3Run VSCalClr VSRegCD VSSetCP TlCal2D TlCal3D TlClrPt TlSetPt",
    kept.COMPLIANCE: "Cmp CmpG Fsc FsCTrg FsGChg FsGetDat FsHndEst FsLog FsOutLog FsTAlgo FsTBat"
    " FsTCond FsTest",
    kept.CONVEYORS: "TrBase TrClr Trk TrkArc TrkChk TrkFine TrkMv TrkTrg TrkWait TrOut TrRd TrWrt",
    kept.TUNING: "CavChk ColChk ColLvl Fine LoadSet MvTune Mxt Oadl Prec SpdOpt Torq JRC",
    _HANDS: "EHClose EHHold EHMov EHOpen EHOrg EHServo EHStop EHTbl",
    _ERRORS: "Error Reset",
    kept.SERVO: "Servo BrkLock",
    Reason("its condition has no other words", "ask with M variables and signals"): "Wait",
    Reason("its values have no other words", "give one plain number for each"): (
        "Ovrd JOvrd Spd Accel Cnt Tool Base"
    ),
    Reason("which hand is worked out while the program runs", "write its number"): "HOpen HClose",
}
"""Commands by what they are about."""

_BY_WORD: Final = {
    **{word: reason for reason, words in _WORDS.items() for word in words.split()},
    "Mvc": FULL_CIRCLE,
    "Mvr2": Reason("an arc beside a point has no other words", "write the arc with Mvr"),
    "Mvr3": Reason("an arc about a centre has no other words", "write the arc with Mvr"),
    "Mva": Reason("the move jumps over an arch of the controller's", "write its three moves"),
    "MvSpl": Reason("a spline is worked out by the controller", "move with Mvs and Cnt"),
}

_NODES: Final[dict[type, Reason]] = {
    s.DefAct: kept.INTERRUPTS,
    s.OnCom: kept.INTERRUPTS,
    s.Com: kept.INTERRUPTS,
    s.Open: kept.COMMUNICATION,
    s.Close: kept.COMMUNICATION,
    s.Print: kept.COMMUNICATION,
    s.Input: kept.COMMUNICATION,
    s.DefOther: _PALLETS,
    s.FPrm: Reason(
        "a called program's arguments stand in its first line only", "take the arguments there"
    ),
    s.DefIo: Reason("the name stands for masked or unknown signals", "use M_In and M_Out"),
    s.DefFunction: Reason(
        "the function's expression has no other words", "work the value out where it is used"
    ),
    s.Include: Reason("it takes in another file", "put that file's lines here"),
    s.Const: Reason("the constant's value is worked out elsewhere", "give it a plain number"),
    s.Call: Reason(
        "the function takes arrays of several extents, or other arguments, or changes them in a way"
        " that is not known",
        "give arrays of one extent for parameters with (), and mark those ByVal or ByRef",
    ),
    s.Next: Reason("its block does not end where it should", "close the blocks inside one another"),
    s.For: Reason("its block does not end where it should", "close the blocks inside one another"),
    s.Select: Reason("its cases have no other words", "write the choice with If"),
    s.Case: Reason("its Select stays as its text", "see to that first"),
}


def reason_for(node: s.Statement, found: Reason | None) -> Reason:
    """Why a statement stays as its text. found: what the reader of it said."""
    if found is not None:
        return found
    if isinstance(node, s.Motion) and node.append:
        return Reason(
            "something happens while the robot moves, by `Wth` or `WthIf`",
            "put the statement above or below the move",
        )
    if isinstance(node, s.Motion | s.Command):
        return _BY_WORD.get(node.keyword.split()[0], kept.NO_EQUIVALENT)
    if isinstance(node, s.If) and node.then is not None:
        # The first branch with a specific reason determines the reason of the line.
        for branch in (node.then, node.otherwise):
            if branch is not None and not isinstance(branch, s.Target):
                inner = reason_for(branch, None)
                if inner is not kept.NO_EQUIVALENT:
                    return inner
    return _NODES.get(type(node), kept.NO_EQUIVALENT)


def statement_text(statement: s.Statement, dialect: str) -> str:
    """A statement as its dialect writes it."""
    return printer.statement(statement, dialect.endswith("-4"))

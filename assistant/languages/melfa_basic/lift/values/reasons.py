"""Why a statement stays as its text: what it is about, and what to write instead."""

from __future__ import annotations

from typing import Final

from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.statements import Reason

WAYS: Final = Reason(
    "its settings differ with the way that leads here", "set them where the ways meet"
)
PLAIN: Final = Reason("no statement of other languages says it", "say it in plain statements")
TYPE: Final = Reason(
    "the move's `Type` asks for another way than usual", "leave `Type` out, or set points between"
)
COMPUTED_PROGRAM: Final = Reason(
    "which program runs is worked out while it runs",
    "choose with Select Case among CallP statements with names in quotes",
)
NO_PROCEDURE: Final = Reason(
    "it calls lines that are no subroutine: others run or jump into them, or out of them",
    "begin the subroutine with a label of its own behind End, Return or GoTo, end it with Return",
)
NO_LABEL: Final = Reason(
    "it jumps into another subroutine, into a block, or to a line that there is none of",
    "jump to a label of the same subroutine that stands in no block, or call it with GoSub",
)
NOT_FIRST: Final = Reason(
    "it ends a called program from within a subroutine", "set a variable and return, end above"
)
ENDS_CYCLE: Final = Reason(
    "it ends the cycle of the whole program from within a subroutine",
    "set a variable and return, ask for it in the main program, end there",
)
NO_SUBROUTINE: Final = Reason(
    "it returns from lines that are no subroutine",
    "begin the subroutine with a label that GoSub calls, behind End, Return or GoTo",
)
DELAYED: Final = Reason("the assignment comes late, by `Dly`", "put Dly above a plain assignment")
STATUS: Final = Reason(
    "it reads or writes a state of the controller itself", "keep the state in a variable of its own"
)
DEPENDED_ON: Final = Reason(
    "something below depends on this setting and stays as its text",
    "see to that first",
    serves=True,
)
_INTERRUPTS: Final = Reason(
    "it belongs to an interrupt, which works beside the program",
    "write the interrupt in the other language, or ask for the signal where it matters",
)
_TASKS: Final = Reason(
    "it controls programs that run beside this one",
    "let the cell's controller start them, or say it in the other language",
)
_VISION: Final = Reason(
    "it talks to a camera in the maker's own protocol",
    "read the camera over a line in the other language",
)
_LINES: Final = Reason(
    "it talks over a line or to a file", "write the communication in the other language"
)
_SOFT: Final = Reason(
    "it makes the arm soft or asks for force, which each maker does in an own way",
    "use the other robot's soft or force control",
)
_TRACKING: Final = Reason(
    "it follows a conveyor in the maker's own way", "use the other robot's conveyor tracking"
)
_GUARD: Final = Reason(
    "it sets how the controller watches or tunes the arm",
    "leave it out, or set the other's own",
)
_HANDS: Final = Reason(
    "it drives a hand of the maker's with its own motor",
    "open and close with HOpen and HClose, or by signals",
)
_ERRORS: Final = Reason("it raises or clears an error", "set a signal, or stop with Hlt")
_PALLETS: Final = Reason("it counts places of a pallet", "work the positions out with M variables")
_SERVO: Final = Reason("it switches motors or brakes", "leave that to the operator")

_WORDS: Final = {
    _INTERRUPTS: "Act",
    _TASKS: "GetM Priority RelM XClr XLoad XRst XRun XStp Skip",
    _VISION: "EBRead EBWrite NVClose NVIn NVLoad NVOpen NVPst NVRun NVTrg SetCalFrm V3Calc V3Calib"
    " V3Close V3Open V3Run VSCalClr VSRegCD VSSetCP TlCal2D TlCal3D TlClrPt TlSetPt",
    _SOFT: "Cmp CmpG Fsc FsCTrg FsGChg FsGetDat FsHndEst FsLog FsOutLog FsTAlgo FsTBat FsTCond"
    " FsTest",
    _TRACKING: "TrBase TrClr Trk TrkArc TrkChk TrkFine TrkMv TrkTrg TrkWait TrOut TrRd TrWrt",
    _GUARD: "CavChk ColChk ColLvl Fine LoadSet MvTune Mxt Oadl Prec SpdOpt Torq JRC",
    _HANDS: "EHClose EHHold EHMov EHOpen EHOrg EHServo EHStop EHTbl",
    _ERRORS: "Error Reset",
    _SERVO: "Servo BrkLock",
    Reason("its condition has no other words", "ask with M variables and signals"): "Wait",
    Reason("its values have no other words", "give one plain number for each"): (
        "Ovrd JOvrd Spd Accel Cnt Tool Base"
    ),
    Reason("which hand is worked out while the program runs", "write its number"): "HOpen HClose",
}
"""Commands by what they are about."""

_COMMANDS: Final = {word: reason for reason, words in _WORDS.items() for word in words.split()}

_MOTIONS: Final = {
    "Mvc": Reason("a full circle is no statement elsewhere", "write two arcs with Mvr"),
    "Mvr2": Reason("an arc beside a point has no other words", "write the arc with Mvr"),
    "Mvr3": Reason("an arc about a centre has no other words", "write the arc with Mvr"),
    "Mva": Reason("the move jumps over an arch of the controller's", "write its three moves"),
    "MvSpl": Reason("a spline is worked out by the controller", "move with Mvs and Cnt"),
}

_NODES: Final[dict[type, Reason]] = {
    s.DefAct: _INTERRUPTS,
    s.OnCom: _INTERRUPTS,
    s.Com: _INTERRUPTS,
    s.Open: _LINES,
    s.Close: _LINES,
    s.Print: _LINES,
    s.Input: _LINES,
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
    if isinstance(node, s.Motion) and node.append:
        return Reason(
            "something happens while the robot moves, by `Wth` or `WthIf`",
            "put the statement above or below the move",
        )
    if found is not None:
        return found
    if isinstance(node, s.Motion):
        return _MOTIONS.get(node.keyword, PLAIN)
    if isinstance(node, s.Command):
        return _COMMANDS.get(node.keyword.split()[0], PLAIN)
    if isinstance(node, s.If) and node.then is not None:
        for branch in (node.then, node.otherwise):
            if branch is not None and not isinstance(branch, s.Target):
                inner = reason_for(branch, None)
                if inner is not PLAIN:
                    return inner
    return _NODES.get(type(node), PLAIN)


def text_of(statement: s.Statement, dialect: str) -> str:
    """A statement as its dialect writes it."""
    return printer.statement(statement, dialect.endswith("-4"))

"""Names and fixed data of random RAPID programs, as programs of real cells have them."""

from __future__ import annotations

from typing import Final

PROCEDURES: Final = (
    *("rPickPart", "rPlacePart", "rMoveHome", "InitCell", "rGlueSeam", "CheckGripper", "NextLayer"),
    *("rApproach", "up", "sub", "rStackBox", "Palletize", "OpenGripper", "rScan", "CalcRow"),
)
FUNCTIONS: Final = ("fNext", "CalcOffset", "fHeight", "GetRow", "Limit", "fSlot")
NUMBERS: Final = (
    *("nCount", "n", "nLayer", "nRow", "nParts", "reg_a", "nStep", "x", "nTries", "index"),
)
REALS: Final = ("xOffs", "zHeight", "dist", "yShift")
TRUTHS: Final = ("bDone", "bFound", "flag", "partOk")
ARRAYS: Final = ("k", "nHeights", "rows", "nCounts")
TRUTH_ARRAYS: Final = ("bSlots", "isFull")
TARGETS: Final = ("p10", "p20", "p30", "pHome", "pPick", "pPlace", "pApproach", "pWait")
CHANGING: Final = ("pt", "pCurrent", "pTemp", "pStart")
TARGET_ARRAYS: Final = ("pSlots", "pRack")
PARAMETERS: Final = ("q", "nValue", "a", "nTimes", "size", "res")
TRIGGERS: Final = ("trGun", "onSeam", "gunOff")
LOOPS: Final = ("i", "j", "row", "col")

OUTPUTS: Final = {"doGrip": 4, "doVacuum": 5, "do1": 6, "doDone": 10}
INPUTS: Final = {"diPart": 8, "di1": 9, "diReady": 12}
GROUP_OUTPUTS: Final = {"goSlot": (24, 4), "goProgram": (32, 6)}
"""First number and bits; each has its bytes to itself."""
GROUP_INPUTS: Final = {"giOrder": (40, 4)}

TOOLS: Final = {
    "tGripper": "[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]]",
    "tPen": "[TRUE,[[20,-10,80],[0.923879533,0,0,0.382683432]],[1,[0,0,50],[1,0,0,0],0,0,0]]",
    "tCam": "[TRUE,[[30,0,60],[0.707106781,0,0.707106781,0]],[1,[0,0,50],[1,0,0,0],0,0,0]]",
    "tBent": (
        "[TRUE,[[12.347,-8.213,143.621],[0.973585,0.083156,-0.166312,0.131667]],"
        "[1,[0,0,50],[1,0,0,0],0,0,0]]"
    ),
}
POSE: Final = "[[15,-5,120],[0.965925826,0,0,0.258819045]]"
FRAMES: Final = {
    "wobjTable": '[FALSE,TRUE,"",[[400,-100,50],[1,0,0,0]],[[0,0,0],[1,0,0,0]]]',
    "wobjFixture": (
        '[FALSE,TRUE,"",[[300,200,80],[0.707106781,0,0,0.707106781]],[[10,20,0],[1,0,0,0]]]'
    ),
    "wobjRack": (
        '[FALSE,TRUE,"",[[421.337,-87.129,63.718],[0.985,0.0517,-0.0713,0.14848]],'
        "[[3.331,-7.772,1.113],[0.9962,0,0,0.08709]]]"
    ),
}
ORIENTATIONS: Final = (
    "[0,0,1,0]",
    "[0,1,0,0]",
    "[0,0.707106781,0.707106781,0]",
    "[0.258819045,0,0.965925826,0]",
    "[0,0.923879533,0.382683432,0]",
)
SPEEDS: Final = ("v50", "v100", "v200", "v300", "v500", "v1000")
ZONES: Final = ("fine", "fine", "z1", "z5", "z10", "z50")
SETTINGS: Final = (
    *("ConfL\\Off;", "ConfL\\On;", "ConfJ\\On;", "SingArea\\Off;", "SingArea;", "TPErase;"),
    *("GripLoad load0;", "CornerPathWarning FALSE;"),
)
UNUSED: Final = "[9E9,9E9,9E9,9E9,9E9,9E9]"


def process_file() -> str:
    """The signals of the cell, as a process file states them."""
    lines = []
    for name, number in OUTPUTS.items():
        lines += [f"[signals.{name}]", f"number = {number}"]
    for name, number in INPUTS.items():
        lines += [f"[signals.{name}]", 'direction = "input"', f"number = {number}"]
    for groups, direction in ((GROUP_OUTPUTS, "output"), (GROUP_INPUTS, "input")):
        for name, (number, bits) in groups.items():
            lines += [f"[signals.{name}]", 'kind = "group"', f'direction = "{direction}"']
            lines += [f"number = {number}", f"bits = {bits}"]
    return "\n".join(lines) + "\n"


def numbers() -> dict[str, tuple[int, ...]]:
    """The numbers of every signal's bits, the lowest first, by name in lower case."""
    single = {name.lower(): (number,) for name, number in (OUTPUTS | INPUTS).items()}
    groups = GROUP_OUTPUTS | GROUP_INPUTS
    return single | {
        name.lower(): tuple(range(first, first + bits)) for name, (first, bits) in groups.items()
    }

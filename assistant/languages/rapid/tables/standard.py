"""Names of routines that RAPID and its options define: nothing else may take them."""

from __future__ import annotations

from typing import Final

from assistant.languages.rapid.tables.signatures import rows


def _routine_names(word: str, *, options: bool) -> frozenset[str]:
    lines = rows().items()
    return frozenset(n for n, (line, of) in lines if line.startswith(word) and bool(of) == options)


INSTRUCTIONS: Final = _routine_names("PROC", options=False)
FUNCTIONS: Final = _routine_names("FUNC", options=False)
OPTION_ROUTINES: Final = _routine_names("", options=True)
"""Instructions and functions of RobotWare's options, lower case as all of these."""


def _word_set(words: str) -> frozenset[str]:
    return frozenset(words.lower().split())


MOVING: Final = _word_set(
    """
    TriggAbsJ CyclicBrakeCheck StepBwdPath EGMRunJoint EGMRunPose
    IndAMove IndCMove IndDMove IndRMove
    ArcAdaptC ArcAdaptCEnd ArcAdaptL ArcAdaptLEnd ArcAdaptLStart ArcAdaptRepL ArcRepL
    ArcC1 ArcC1End ArcC1Start ArcC2 ArcC2End ArcC2Start ArcCalcC ArcCalcCEnd
    ArcL1 ArcL1End ArcL1Start ArcL2 ArcL2End ArcL2Start ArcCalcL ArcCalcLEnd ArcCalcLStart
    BECheckTcp BESetupToolJ BETcpExtend BEUpdateTcp DaProcMJ DaProcML DispC DispL
    FCPress1LStart FCPressC FCPressL FCPressLEnd FCPressEnd FCRefStart
    PaintC PaintL PaintLDO PaintLSig CSSDeactMoveL ExecEngine PMgrRunMenu
    CalibJ CalibL Calibrate MeasureWearL NutJ NutL SpotJ SpotL SpotMJ SpotML IndGunMove
    TcDropOffTool TcPickupTool
    """
)
"""Instructions that move an axis, or may, though no speed is known to be given to them.

By the RAPID reference manual and the manuals of the options, lower case as all of these.
"""
WAITING: Final = _word_set("Stop Break SystemStopAction SyncMoveOn SyncMoveOff")
"""Instructions that hold the program without a word of waiting or a time in their parameters."""
JUMPING: Final = _word_set("ExitCycle ErrRaise RaiseToUser StartMoveRetry")
"""Instructions behind which the program does not simply go on."""
CALLING: Final = _word_set("CallByVar")
"""Instructions that call routines whose names they are given as texts,"""
NAMING: Final = _word_set("SetDataVal SetAllDataVal")
"""and that change data of such names."""

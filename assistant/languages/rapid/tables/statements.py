"""Instructions of RAPID that the pseudo-program has as well: one row each, both ways."""

from __future__ import annotations

from typing import Final

from assistant.languages.patterns import MotionRow, Row, Rows
from assistant.languages.rapid.tables.words import SPEED_CAP
from assistant.program import expressions as e
from assistant.program import statements as p

_MOTION_ARGUMENTS: Final = r"{speed}, {blend}, {tool} \WObj:={frame:other?} \TLoad:={load?}"
"""A `TLoad` of load0 leaves the load to the tool (RAPID reference manual, MoveL)."""
_TEXT: Final = e.Name("{text}")
_TARGET, _BY = e.Name("{target}"), e.Name("{by}")
_ZERO, _ONE = e.Number(0), e.Number(1)

STATEMENT_ROWS: Final = Rows(
    MotionRow(f"MoveJ {{target:value}}, {_MOTION_ARGUMENTS}", p.Move, kind="joint"),
    MotionRow(f"MoveL {{target:value}}, {_MOTION_ARGUMENTS}", p.Move, kind="linear"),
    MotionRow(f"MoveC {{via}}, {{target:value}}, {_MOTION_ARGUMENTS}", p.MoveCircular),
    MotionRow(f"MoveAbsJ {{target:value}}, {_MOTION_ARGUMENTS}", p.MoveJoints),
    Row("WaitTime {seconds}", p.Wait),
    Row(r"WaitUntil {condition} \MaxTime:={timeout?}", p.WaitUntil),
    Row(r"WaitDI {signal:digital input}, {value} \MaxTime:={timeout?}", p.WaitSignal),
    Row(r"WaitDO {signal:digital output}, {value} \MaxTime:={timeout?}", p.WaitSignal),
    Row(r"WaitGI {signal:group input}, {value} \MaxTime:={timeout?}", p.WaitSignal),
    Row(r"WaitGO {signal:group output}, {value} \MaxTime:={timeout?}", p.WaitSignal),
    Row("SetDO {hand}, 1", p.Gripper, action="open"),
    Row("SetDO {hand}, 0", p.Gripper, action="close"),
    Row("SetDO {signal:digital}, {value}", p.SetSignal),
    Row("SetAO {signal:analog}, {value}", p.SetSignal),
    Row("SetGO {signal:group}, {value}", p.SetSignal),
    Row(r"PulseDO \High \PLength:={pulse=0.2}, {signal}", p.SetSignal, value=_ONE),
    Row("AccSet {acceleration}, 100", p.SetAcceleration, deceleration=e.Name("{acceleration}")),
    Row(f"VelSet {{percent}}, {SPEED_CAP}", p.SetOverride),
    Row("Stop", p.Stop),
    also=(
        MotionRow(rf"MoveAbsJ {{target:robot}} \NoEOffs, {_MOTION_ARGUMENTS}", p.MoveJoints),
        Row("TPWrite {text}", p.Message, parts=(_TEXT,)),
        *(
            Row(
                rf"TPWrite {{text}} \{option}:={{shown}}",
                p.Message,
                parts=(_TEXT, e.Apply("text", (e.Name("{shown}"),))),
            )
            for option in ("Num", "Bool", "Pos", "Orient", "Dnum")
        ),
        Row("Set {hand}", p.Gripper, action="open"),
        Row("Reset {hand}", p.Gripper, action="close"),
        Row("Set {signal}", p.SetSignal, value=_ONE),
        Row("Reset {signal}", p.SetSignal, value=_ZERO),
        Row("Incr {target}", p.Assign, value=e.Binary("+", _TARGET, _ONE)),
        Row("Decr {target}", p.Assign, value=e.Binary("-", _TARGET, _ONE)),
        Row("Add {target}, {by}", p.Assign, value=e.Binary("+", _TARGET, _BY)),
        Row("Clear {target}", p.Assign, value=_ZERO),
    ),
)

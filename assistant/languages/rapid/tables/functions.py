"""Functions of RAPID that the pseudo-program has as well: one row each, both ways."""

from __future__ import annotations

from typing import Final

from assistant.languages.patterns import FunctionRow, Row, Rows, pattern
from assistant.program import expressions as e

FUNCTION_ROWS: Final = Rows(
    FunctionRow("abs", "Abs({x})"),
    FunctionRow("sqrt", "Sqrt({x})"),
    FunctionRow("sin", "Sin({x})"),
    FunctionRow("cos", "Cos({x})"),
    FunctionRow("tan", "Tan({x})"),
    FunctionRow("asin", "ASin({x})"),
    FunctionRow("acos", "ACos({x})"),
    FunctionRow("atan", "ATan({x})"),
    FunctionRow("atan2", "ATan2({y}, {x})"),
    FunctionRow("exp", "Exp({x})"),
    FunctionRow("round", "Round({x})"),
    FunctionRow("trunc", "Trunc({x})"),
    FunctionRow("min", "Min({a}, {b})"),
    FunctionRow("max", "Max({a}, {b})"),
    FunctionRow("text", "ValToStr({x})"),
    FunctionRow("fixed", "NumToStr({x}, {decimals})"),
    FunctionRow("part", "StrPart({text}, {first}, {count})"),
    FunctionRow("length", "StrLen({text})"),
    FunctionRow("code", r"StrToByte(StrPart({text}, 1, 1) \Char)"),
    FunctionRow("character", r"ByteToStr({number} \Char)"),
    FunctionRow("offset", "Offs({point}, {x}, {y}, {z})"),
    FunctionRow("inverse", "PoseInv({pose})"),
    FunctionRow("relative", "RelTool({point}, {x}, {y}, {z})"),
    FunctionRow("relative", r"RelTool({point}, {x}, {y}, {z} \Rx:={rx=0} \Ry:={ry=0} \Rz:={rz=0})"),
    FunctionRow("distance", "Distance({a:position}, {b:position})"),
    FunctionRow("joints_here", "CJointT()"),
    FunctionRow("time_of_day", "CTime()"),
    # of whole numbers up to 52 bits; those of a byte have other names
    FunctionRow("bitand", "DnumToNum(BitAndDnum(NumToDnum({a}), NumToDnum({b})))"),
    FunctionRow("bitor", "DnumToNum(BitOrDnum(NumToDnum({a}), NumToDnum({b})))"),
    FunctionRow("bitxor", "DnumToNum(BitXOrDnum(NumToDnum({a}), NumToDnum({b})))"),
    Row("Pow({left}, {right})", e.Binary, operator="^"),
    Row("PoseMult({left}, {right})", e.Binary, operator="@"),
    *(
        Row(rf"EulerZYX(\{axis}, {{value:turned}})", e.Member, field=name)
        for axis, name in zip("XYZ", e.ANGLES, strict=True)
    ),
    Row("ClkRead({timer})", e.Elapsed),
    Row(r"CRobT(\Tool:={tool} \WObj:={frame})", e.Here),
    also=(Row("TestDI({left})", e.Binary, operator="=", right=e.Number(1)),),
)
CURRENT_TARGET: Final = pattern(r"CRobT(\Tool:={tool?} \WObj:={frame?})")
"""The same where it reads in the tool or frame of the move before (RAPID reference manual)."""

NO_OTHER: Final = frozenset(("dnumtonum", "testdi", "clkread"))
"""Functions with a row that in another form are calls like those of the user's own."""

ORIENTATION: Final = pattern("OrientZYX({about_z}, {about_y}, {about_x})")
ORIENTATION_COMPONENT: Final = "rot"
"""The component of a target or pose that is its orientation."""

ARM_FUNCTIONS: Final = {"flange_at": "CalcRobT", "joints_at": "CalcJointT"}
"""Functions that RAPID gives a tool, here always tool0."""
SIGNAL_FUNCTIONS: Final = frozenset(("dinput", "doutput", "ginput", "goutput", "ainput", "aoutput"))
"""Functions that give what a signal's name says by itself (RAPID reference manual)."""

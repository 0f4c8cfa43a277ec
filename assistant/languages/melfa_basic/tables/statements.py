"""Statements of MELFA-BASIC that the pseudo-program has as well: one row each, both ways."""

from __future__ import annotations

from typing import Final

from assistant.languages.patterns import Row, Rows
from assistant.program import statements as p

STATEMENT_ROWS: Final = Rows(
    Row("Dly {seconds}", p.Wait),
    Row("Ovrd {percent}", p.SetOverride),
    Row("Accel {acceleration=100}, {deceleration=100}", p.SetAcceleration),
    Row("HOpen {hand}", p.Gripper, action="open"),
    Row("HClose {hand}", p.Gripper, action="close"),
    Row("Hlt", p.Stop),
)

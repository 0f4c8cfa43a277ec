"""The modal state of motion: which settings a move needs that do not hold already."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from assistant.languages.melfa_basic.lower.expressions import numeric
from assistant.languages.melfa_basic.lower.names import Names
from assistant.languages.melfa_basic.tables.dialects import Dialect
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.motion import Blend, Speed


@dataclass(slots=True)
class Settings:
    """What holds at a place of the program; None where it is not known."""

    tool: str | None = None
    frame: str | None = None
    tcp: float | None = None
    joint: float | None = None
    blend: Blend | None = None

    def forget(self) -> None:
        self.tool = self.frame = self.tcp = self.joint = self.blend = None


def changes(
    state: Settings,
    speed: Speed,
    blend: Blend,
    tool: str,
    frame: str,
    names: Names,
    dialect: Dialect,
) -> Iterator[s.Command]:
    """The commands that bring the state to what a move needs, and the state with them."""
    yield from places(state, tool, frame, names, dialect)
    if speed.joint is not None and state.joint != speed.joint:
        state.joint = speed.joint
        yield s.Command("JOvrd", (numeric(speed.joint),))
    if speed.joint is None and state.tcp != speed.tcp:  # `Mov` does not depend on it
        state.tcp = speed.tcp
        fastest = math.isinf(speed.tcp)
        yield s.Command("Spd", (_status("M_NSpd", dialect) if fastest else numeric(speed.tcp),))
    if state.blend != blend:
        state.blend = blend
        yield s.Command("Cnt", _corner(blend))


def places(
    state: Settings, tool: str, frame: str, names: Names, dialect: Dialect
) -> Iterator[s.Command]:
    """Those that bring it to the tool and the frame."""
    if state.tool != tool:
        state.tool = tool
        known = names.tools.get(tool.lower())
        yield s.Command("Tool", (s.Variable(known) if known else _status("P_NTool", dialect),))
    if state.frame != frame:
        state.frame = frame
        known = names.frames.get(frame.lower())
        yield s.Command("Base", (s.Variable(known) if known else _status("P_NBase", dialect),))


def _status(name: str, dialect: Dialect) -> s.Variable:
    return s.Variable(name.upper() if dialect.upper else name)


def _corner(blend: Blend) -> tuple[s.Expression, ...]:
    if blend.radius is None:
        return (s.Number(0),)
    if math.isinf(blend.radius):
        return (s.Number(1),)
    leave = blend.radius if blend.exit is None else blend.exit
    return (s.Number(1), numeric(blend.radius), numeric(leave))

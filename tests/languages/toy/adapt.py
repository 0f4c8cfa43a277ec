"""A pseudo-program as the toy language can say it: one pass after the other."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Frame, Target, Tool
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.passes.comments import with_plain_comments
from assistant.program.passes.legalisation import (
    Capabilities,
    Comments,
    NameForm,
    leaving_out,
    pure,
)
from assistant.program.passes.motions import with_stated_motions
from assistant.program.passes.names import with_legal_names
from assistant.program.passes.paths import with_points
from assistant.program.program import identifier

from . import tables


def _legal(name: str) -> str:
    return name if tables.NAME.fullmatch(name) else identifier(name)


def _motion(motion: p.Motion) -> Any:
    """mm/s, and mm of a corner: one without a size is none."""
    match motion:
        case p.Motion(Speed(tcp), Blend(radius)):
            blend = FINE if radius == math.inf else Blend(radius)
            return replace(motion, speed=Speed(tcp), blend=blend)
    return motion


def _frame(frame: Frame) -> Frame:
    return frame if frame.held or frame.mechanism else Frame(frame.pose)


CAN: Final = Capabilities(
    kin=frozenset({"toy"}),
    cannot_say=tables.UNSAYABLE,
    changed=tables.CHANGED,
    comments=Comments(ascii=True),
    names=NameForm(longest=20, legal=_legal, renamed=tables.RENAMED),
)
PASSES: Final = (
    pure(with_points),
    pure(with_stated_motions),
    with_plain_comments,
    leaving_out(
        tables.LEFT_OUT,
        {
            p.Motion: ("more of a motion than mm/s and mm", _motion),
            Tool: ("load of a tool", lambda tool: replace(tool, load=None)),
            Target: ("arm branch of a point", lambda point: replace(point, configuration=None)),
            Frame: ("", _frame),
            e.Truth: ("", lambda truth: e.Number(int(truth.value))),
        },
    ),
    with_legal_names,
)

"""A pseudo-program as the toy language can say it: one pass after the other."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Final

from assistant.languages.ascii_names import in_ascii
from assistant.languages.language import Adapted
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.diagnostics import Findings, Refused
from assistant.program.geometry import Frame, Target, Tool
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.passes.legalising import Capabilities, Legalising, NameForm, legalised, pure
from assistant.program.passes.motions import meant
from assistant.program.passes.names import with_legal_names
from assistant.program.passes.points import with_points
from assistant.program.program import Program, identifier
from assistant.program.rewriting import rewrite
from assistant.program.text import one_line

from . import tables
from .lower import build


def adapt(program: Program) -> Adapted:
    """The program after all passes; what there is no line for even then is an error."""
    findings = Findings()
    program = legalised(Legalising(program, CAN, findings), PASSES)
    try:
        build(program)
    except Refused as refused:
        findings += refused.findings
    return Adapted(program, tuple(dict.fromkeys(findings)))


def with_plain_parts(job: Legalising) -> Program:
    """Each part as its line has it: mm/s and mm of a move, poses of places, texts in ASCII."""
    program = job.program

    def plain(part: Any) -> Any:
        left_out, made = "", part
        match part:
            case e.Truth(value):
                return e.Number(int(value))
            case p.Motion(speed, blend):
                speed, blend = meant(speed, program.speeds), meant(blend, program.blends)
                part = made = replace(part, speed=speed, blend=blend)
                if isinstance(speed, Speed) and isinstance(blend, Blend):
                    left_out = "more of a motion than mm/s and mm"
                    blend = FINE if blend.radius == math.inf else Blend(blend.radius)
                    made = replace(part, speed=Speed(speed.tcp), blend=blend)
            case Tool():
                left_out, made = "load of a tool", replace(part, load=None)
            case Target():
                left_out, made = "arm branch of a point", replace(part, configuration=None)
            case Frame(held=False, mechanism=""):
                return Frame(part.pose)
            case p.Comment(text):
                return replace(part, text=line(text))
        if made != part:
            job.findings.append(tables.LEFT_OUT(what=left_out))
        return made

    def line(text: str) -> str:
        written = in_ascii(one_line(text)).strip()
        if written != text:
            job.findings.append(tables.REWRITTEN(given=text, name=written))
        return written

    comments, robot = tuple(map(line, program.comments)), line(program.robot or "") or None
    program = rewrite(program, plain)
    return replace(program, comments=comments, robot=robot, speeds={}, blends={})


def _legal(name: str) -> str:
    return name if tables.NAME.fullmatch(name) else identifier(name)


CAN: Final = Capabilities(
    kin=frozenset({"toy"}),
    cannot_say=tables.UNSAYABLE,
    names=NameForm(longest=20, legal=_legal, renamed=tables.REWRITTEN),
)
PASSES: Final = (pure(with_points), with_plain_parts, with_legal_names)

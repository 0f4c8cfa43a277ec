"""A pseudo-program as the toy language can say it: one pass after the other."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

from assistant.languages.ascii_names import in_ascii
from assistant.languages.language import Adapted
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.diagnostics import Diagnostic, Refused
from assistant.program.geometry import BASE, FLANGE, Frame, Target, Tool
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.path import Kind
from assistant.program.program import Procedure, Program, identifier
from assistant.program.rewriting import Body, map_bodies, rewrite
from assistant.program.text import one_line

from . import tables
from .lower import build

Found = list[Diagnostic]


def adapt(program: Program) -> Adapted:
    """The program after all passes; what there is no line for even then is an error."""
    findings: Found = []
    for change in PASSES:
        program = change(program, findings)
    try:
        build(program)
    except Refused as refused:
        findings += refused.findings
    return Adapted(program, tuple(dict.fromkeys(findings)))


def with_points(program: Program, _: Found) -> Program:
    """Targets that stand in moves, and those of paths, become points of their own."""
    targets = dict(program.targets)

    def point(target: Target, wanted: str) -> e.Name:
        name = identifier(wanted, set(targets))
        targets[name] = target
        return e.Name(name)

    def moves(node: p.Statement) -> Iterator[p.Statement]:
        match node:
            case p.Move(kind, e.TargetValue(target), motion):
                yield p.Move(kind, point(target, "point"), motion, span=node.span)
            case p.Follow(path) if set(path.kinds.tolist()) <= {Kind.JOINT, Kind.LINEAR}:
                for row, kind in enumerate(path.kinds):
                    to = point(path.target(row), f"{path.name}_{row + 1}")
                    motion = p.Motion(
                        path.speeds[path.speed[row]],
                        path.blends[path.blend[row]],
                        path.tools[path.tool[row]],
                        path.frames[path.frame[row]],
                    )
                    yield p.Move("linear" if kind else "joint", to, motion, span=node.span)
            case _:
                yield map_bodies(node, body)

    def body(given: Body) -> Body:
        return tuple(made for node in given for made in moves(node))

    procedures = tuple(replace(q, body=body(q.body)) for q in program.procedures)
    return replace(program, procedures=procedures, targets=targets)


def with_plain_parts(program: Program, findings: Found) -> Program:
    """Each part as its line has it: mm/s and mm of a move, poses of places, texts in ASCII."""

    def plain(part: Any) -> Any:
        left_out, made = "", part
        match part:
            case e.Truth(value):
                return e.Number(int(value))
            case p.Motion(speed=e.Name(name)) if name in program.speeds:
                return plain(replace(part, speed=program.speeds[name]))
            case p.Motion(blend=e.Name(name)) if name in program.blends:
                return plain(replace(part, blend=program.blends[name]))
            case p.Motion(Speed(tcp), Blend(radius)):
                left_out = "more of a motion than mm/s and mm"
                blend = FINE if radius == math.inf else Blend(radius)
                made = replace(part, speed=Speed(tcp), blend=blend)
            case Tool():
                left_out, made = "load of a tool", replace(part, load=None)
            case Target():
                left_out, made = "arm branch of a point", replace(part, configuration=None)
            case Frame(held=False, mechanism=""):
                return Frame(part.pose)
            case p.Comment(text):
                return replace(part, text=line(text))
        if made != part:
            findings.append(tables.LEFT_OUT(what=left_out))
        return made

    def line(text: str) -> str:
        written = in_ascii(one_line(text)).strip()
        if written != text:
            findings.append(tables.REWRITTEN(given=text, name=written))
        return written

    comments, robot = tuple(map(line, program.comments)), line(program.robot or "") or None
    program = rewrite(program, plain)
    return replace(program, comments=comments, robot=robot, speeds={}, blends={})


NAMES: Final[dict[type, tuple[str, ...]]] = {
    Program: ("name", "entry"),
    Procedure: ("name",),
    p.Motion: ("tool", "frame"),
    p.SetSignal: ("signal",),
    p.WaitSignal: ("signal",),
    p.Call: ("procedure",),
    e.Name: ("name",),
}
"""Kind of record → its fields that are names."""
NAMED: Final = ("tools", "frames", "signals", "targets", "joint_targets")


def with_legal_names(program: Program, findings: Found) -> Program:
    """Names that the language takes, each the same wherever it is used, in any case."""
    legal: dict[str, str] = {}

    def of(given: str) -> str:
        if given.lower() not in legal:
            name = given
            if tables.NAME.fullmatch(given) is None or given.lower() in taken():
                name = identifier(identifier(given)[: tables.STEM], taken())
                findings.append(tables.REWRITTEN(given=given, name=name))
            legal[given.lower()] = name
        return legal[given.lower()]

    def taken() -> set[str]:
        return {name.lower() for name in legal.values()}

    def renamed(part: Any) -> Any:
        fields = NAMES.get(type(part), ())
        return replace(part, **{f: of(getattr(part, f)) for f in fields if getattr(part, f)})

    given = [FLANGE, BASE, *(q.name for q in program.procedures)]
    given += [name for table in NAMED for name in getattr(program, table)]
    for name in sorted(given, key=lambda name: tables.NAME.fullmatch(name) is None):
        of(name)
    rows = {t: {of(n): part for n, part in getattr(program, t).items()} for t in NAMED}
    return rewrite(replace(program, **rows), renamed)


PASSES: Final = (with_points, with_plain_parts, with_legal_names)

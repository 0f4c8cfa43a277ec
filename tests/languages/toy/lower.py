"""Pseudo-program to tree: a line for each part; what has none is refused."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import Blend, Speed
from assistant.program.program import Procedure, Program, Signal, bodies
from assistant.program.pseudo.parts import part_text

from . import tables
from .lift import TABLES
from .tree import File, Line, Value


def build(program: Program) -> File:
    """The tree of an adapted program; raises Refused with all that it cannot say."""
    refused: list[Diagnostic] = []
    lines = tuple(_program(program, refused))
    if refused:
        raise Refused(*refused)
    return File(lines)


def _program(program: Program, refused: list[Diagnostic]) -> Iterator[Line]:
    yield from (Line("#", (text,)) for text in program.comments)
    named = {"program": program.name, "robot": program.robot, "start": program.entry}
    yield from (Line(word, (name,)) for word, name in named.items() if name)
    for word, table in {**TABLES, "signal": "signals", "variable": "variables"}.items():
        for name, part in getattr(program, table).items():
            yield from _tried(refused, part, word, name)
    for part in program.declarations:
        yield from _tried(refused, part)
    for procedure in program.procedures:
        yield from _tried(refused, procedure)
        yield from _body(procedure.body, refused)
        yield Line("end")


def _body(body: tuple[p.Statement, ...], refused: list[Diagnostic]) -> Iterator[Line]:
    for statement in body:
        yield from _tried(refused, statement)
        for row, inner in enumerate(bodies(statement)):
            if row and inner:
                yield Line("else")
            yield from _body(inner, refused)
        if bodies(statement):
            yield Line("end")


def _tried(refused: list[Diagnostic], part: Any, word: str = "", name: str = "") -> Iterator[Line]:
    """The line that a part begins with, none where it is refused."""
    try:
        yield _line(part, word, name)
    except Refused as error:
        refused += (replace(f, span=getattr(part, "span", None)) for f in error.findings)


def _line(part: Any, word: str, name: str) -> Line:
    match part:
        case Tool(pose, None, True) | Frame(pose, Pose((0, 0, 0), (1, 0, 0, 0)), False, ""):
            return Line(word, (name, *_numbers(*pose.position, *pose.quaternion)))
        case Target(pose, None) if part == Target(pose):
            return Line(word, (name, *_numbers(*pose.position, *pose.quaternion)))
        case JointTarget((_, *_) as joints) if part == JointTarget(joints):
            return Line(word, (name, *_numbers(*joints)))
        case Signal("digital", direction, number) if 0 <= (number or 0) <= tables.LARGEST:
            return Line(direction, (name,) if number is None else (name, number))
        case Procedure(parameters=(), result=None, unit=None) if not part.variables:
            return Line("procedure", (part.name,))
        case p.Move(kind, e.Name(to), motion):
            return Line("go" if kind == "joint" else "line", (to, *_motion(motion)))
        case p.MoveJoints(e.Name(to), motion):
            return Line("turn", (to, *_motion(motion)))
        case p.Wait(e.Number(seconds)):
            return Line("wait", _numbers(seconds))
        case p.SetSignal(signal, e.Number(0 | 1 as bit), None):
            return Line("set", (signal, _state(bit)))
        case p.WaitSignal(signal, e.Number(0 | 1 as bit), None):
            return Line("await", (signal, _state(bit)))
        case p.If((p.Branch(e.Binary("=", e.Name(signal), e.Number(0 | 1 as bit))),)):
            return Line("if", (signal, _state(bit)))
        case p.While(e.Binary("=", e.Name(signal), e.Number(0 | 1 as bit))):
            return Line("while", (signal, _state(bit)))
        case p.Call(procedure, (), None):
            return Line("call", (procedure,))
        case p.Stop(end=False):
            return Line("stop")
        case p.Comment(text):
            return Line("#", (text,))
    raise _refusal(part)


def _motion(motion: p.Motion) -> tuple[Value, ...]:
    match motion:
        case p.Motion(Speed(tcp), Blend(radius), tool, frame):
            (speed,) = ("max",) if tcp == math.inf else _numbers(tcp)
            (blend,) = ("fine",) if radius is None else _numbers(radius)
            return speed, blend, tool, frame
    raise _refusal(motion)


def _numbers(*values: float) -> tuple[float, ...]:
    for value in values:
        if not abs(value) <= tables.LARGEST:  # nor is a NaN
            raise _refusal(e.Number(value))
    return tuple(round(float(value), tables.DECIMALS) for value in values)


def _state(bit: float) -> str:
    return "on" if bit else "off"


def _refusal(part: object) -> Refused:
    return Refused(tables.UNSAYABLE(what=part_text(part)))

"""Pseudo-program to tree: a line for each part; what has none is refused."""

from __future__ import annotations

import math
from typing import Any, Final

from assistant.base.diagnostics import Findings, Refused
from assistant.languages.patterns import Slot, Writing
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Frame, JointTarget, Target, Tool
from assistant.program.motion import Blend, Speed
from assistant.program.program import Procedure, Program, Signal, bodies
from assistant.program.pseudo.printer import part_text
from assistant.program.rewriting import Body

from . import tables
from .tree import File, Line, Value


def build(program: Program) -> File:
    """The tree of an adapted program; raises Refused with all that it cannot say."""
    made = _Lines()
    made.lines += (Line("#", (text,)) for text in program.comments)
    named = {"program": program.name, "robot": program.robot, "start": program.entry}
    made.lines += (Line(word, (name,)) for word, name in named.items() if name)
    for word, table in {**tables.TABLES, "signal": "signals", "variable": "variables"}.items():
        for name, part in getattr(program, table).items():
            made.say(part, _declared(part, word, name))
    for part in program.declarations:
        made.say(part, None)
    for procedure in program.procedures:
        plain = Procedure(procedure.name, procedure.body, span=procedure.span)
        made.say(procedure, Line("procedure", (plain.name,)) if plain == procedure else None)
        made.body(procedure.body)
        made.lines.append(Line("end"))
    if made.refused:
        raise Refused(*made.refused)
    return File(tuple(made.lines))


class _Lines:
    def __init__(self) -> None:
        self.lines: list[Line] = []
        self.refused = Findings()

    def say(self, part: Any, line: Line | None) -> None:
        if line is not None:
            self.lines.append(line)
            return
        with self.refused.at(getattr(part, "span", None)):
            self.refused.append(tables.UNSAYABLE(what=part_text(part)))

    def body(self, body: Body) -> None:
        for statement in body:
            self.say(statement, _statement(statement))
            inside = bodies(statement)
            for row, inner in enumerate(inside):
                self.lines += [Line("else")] if row and inner else []
                self.body(inner)
            self.lines += [Line("end")] if inside else []


def _declared(part: Any, word: str, name: str) -> Line | None:
    match part:
        case Tool(pose) | Frame(pose) | Target(pose) if part == tables.PLACED[word](pose):
            return _numbered(word, name, *pose.position, *pose.quaternion)
        case JointTarget((_, *_) as joints) if part == JointTarget(joints):
            return _numbered(word, name, *joints)
        case Signal("digital", direction, number) if 0 <= (number or 0) <= tables.LARGEST:
            return Line(direction, (name,) if number is None else (name, number))
    return None


def _statement(part: p.Statement) -> Line | None:
    match part:
        case p.If((p.Branch(condition),)):
            return _row(condition, "if")
        case p.While(condition):
            return _row(condition, "while")
        case p.Comment(text):
            return Line("#", (text,))
    return _row(part)


def _row(record: Any, word: str = "") -> Line | None:
    called = tables.ROWS.write(record, WRITING)
    return called and Line(word or called.word, tuple(v for v in called.given if v is not None))


def _numbered(word: str, name: str, *values: float) -> Line | None:
    numbers = [rounded for value in values if (rounded := _number(value)) is not None]
    return Line(word, (name, *numbers)) if len(numbers) == len(values) else None


def _number(value: float) -> float | None:
    """None where it is too large to be written, or none."""
    return round(float(value), tables.DECIMALS) if abs(value) <= tables.LARGEST else None


def _written(value: Any, _: Slot) -> Value | None:
    match value:
        case str():
            return value
        case e.Name(name):
            return name
        case e.Number(number):
            return _number(number)
        case Speed(tcp):
            return "max" if tcp == math.inf else _number(tcp)
        case Blend(radius):
            return "fine" if radius is None else _number(radius)
    return None


def _state(value: Any, _: Slot) -> str | None:
    return {0: "off", 1: "on"}.get(value.value) if isinstance(value, e.Number) else None


WRITING: Final[Writing[Value]] = Writing({"value": _written, "state": _state})

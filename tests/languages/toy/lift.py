"""Tree to pseudo-program: what is declared, and the bodies of the procedures."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import chain
from typing import Any, Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import Blend, Speed
from assistant.program.program import Procedure, Program, Signal

from . import tables
from .tree import File, Line, Value

TABLES: Final = {"tool": "tools", "frame": "frames", "point": "targets", "joints": "joint_targets"}
"""Word of a line → the table of a program that it is a row of."""
PLACED: Final = {"tool": Tool, "frame": Frame, "point": Target}


def lift(files: Iterable[File]) -> Program:
    said: dict[str, Any] = {"program": "toy"}
    comments: list[str] = []
    rows: dict[str, dict[str, Any]] = {table: {} for table in (*TABLES.values(), "signals")}
    code = _Code()
    for line in (line for file in files for line in file.lines):
        match line:
            case Line("program" | "start" | "robot", (name,)):
                said[line.word] = name
            case Line("joints", (name, *joints)):
                rows["joint_targets"][name] = JointTarget(tuple(joints))
            case Line("tool" | "frame" | "point" as word, (name, x, y, z, *turn)):
                rows[TABLES[word]][name] = PLACED[word](Pose((x, y, z), tuple(turn)))
            case Line("input" | "output" as direction, (name, *number)):
                rows["signals"][name] = Signal("digital", direction, *number)
            case Line("#", (text,)) if not code.blocks:
                comments.append(text)
            case _:
                code.line(line)
    code.end_all()
    name, start, robot = (said.get(word) for word in ("program", "start", "robot"))
    return Program(name, tuple(code.procedures), start, robot, tuple(comments), **rows)


class _Code:
    """Procedures, put together line by line. blocks: the open ones, with the bodies of each.

    A block that is not whole is a finding of `checks.py`; here its lines still count.
    """

    def __init__(self) -> None:
        self.procedures: list[Procedure] = []
        self.blocks: list[tuple[Line, list[list[p.Statement]]]] = []

    def line(self, line: Line) -> None:
        if line.word == "procedure":
            self.end_all()
        if not self.blocks and line.word in tables.INSIDE:
            self.blocks.append((Line("procedure", ("unnamed",)), [[]]))
        match line.word:
            case "procedure" | "if" | "while" if len(self.blocks) <= tables.MOST_BLOCKS:
                self.blocks.append((line, [[]]))
            case "else" if self.blocks:
                self.blocks[-1][1].append([])
            case "end" if len(self.blocks) > 1:
                self.end()
            case _ if self.blocks:
                self.blocks[-1][1][-1].extend(_statement(line))

    def end(self) -> None:
        line, (first, *others) = self.blocks.pop()
        then, otherwise = tuple(first), tuple(chain(*others))
        match line:
            case Line("procedure", (name,)):
                self.procedures.append(Procedure(name, then + otherwise, span=line.span))
            case Line("if", asked):
                branch = p.Branch(_is(*asked), then)
                self.blocks[-1][1][-1].append(p.If((branch,), otherwise, span=line.span))
            case Line("while", asked):
                loop = p.While(_is(*asked), then + otherwise, span=line.span)
                self.blocks[-1][1][-1].append(loop)

    def end_all(self) -> None:
        while self.blocks:
            self.end()


def _statement(line: Line) -> Iterator[p.Statement]:
    match line:
        case Line("go" | "line", (to, *motion)):
            kind = "joint" if line.word == "go" else "linear"
            yield p.Move(kind, e.Name(to), _motion(*motion), span=line.span)
        case Line("turn", (to, *motion)):
            yield p.MoveJoints(e.Name(to), _motion(*motion), span=line.span)
        case Line("wait", (seconds,)):
            yield p.Wait(e.Number(seconds), span=line.span)
        case Line("set", (signal, state)):
            yield p.SetSignal(signal, _bit(state), span=line.span)
        case Line("await", (signal, state)):
            yield p.WaitSignal(signal, _bit(state), span=line.span)
        case Line("call", (name,)):
            yield p.Call(name, span=line.span)
        case Line("stop"):
            yield p.Stop(span=line.span)
        case Line("#", (text,)):
            yield p.Comment(text, span=line.span)


def _motion(speed: Any, blend: Any, tool: str, frame: str) -> p.Motion:
    tcp = math.inf if speed == "max" else speed
    return p.Motion(Speed(tcp), Blend(None if blend == "fine" else blend), tool, frame)


def _bit(state: Value) -> e.Number:
    return e.Number(int(state == "on"))


def _is(signal: str, state: Value) -> e.Expression:
    return e.Binary("=", e.Name(signal), _bit(state))

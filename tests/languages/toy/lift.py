"""Tree to pseudo-program: what is declared, and the bodies of the procedures."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from itertools import chain, pairwise
from typing import Any, Final

from assistant.languages.line_blocks import Block
from assistant.languages.patterns import Called, Reading
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import JointTarget, Pose
from assistant.program.motion import Blend, Speed
from assistant.program.program import Procedure, Program, Signal
from assistant.program.rewriting import Body

from . import tables
from .tree import File, Line, Value, blocks_of

READING: Final[Reading[Value]] = Reading(
    {
        "value": lambda name, _: name,
        "named": lambda name, _: e.Name(str(name)),
        "number": lambda number, _: e.Number(float(number)),
        "state": lambda state, _: e.Number(int(state == "on")),
        "speed": lambda speed, _: Speed(math.inf if speed == "max" else float(speed)),
        "blend": lambda blend, _: Blend(None if blend == "fine" else float(blend)),
    }
)


def lift(files: Iterable[File]) -> Program:
    said: dict[str, Any] = {"program": "toy"}
    comments: list[str] = []
    rows: dict[str, dict[str, Any]] = {table: {} for table in (*tables.TABLES.values(), "signals")}
    lines = [line for file in files for line in file.lines]
    blocks = blocks_of(lines)
    for at, line in enumerate(lines):
        match line:
            case Line("program" | "start" | "robot", (name,)):
                said[line.word] = name
            case Line("joints", (name, *joints)):
                rows["joint_targets"][name] = JointTarget(tuple(joints))
            case Line("tool" | "frame" | "point" as word, (name, x, y, z, *turn)):
                rows[tables.TABLES[word]][name] = tables.PLACED[word](Pose((x, y, z), tuple(turn)))
            case Line("input" | "output" as direction, (name, *number)):
                rows["signals"][name] = Signal("digital", direction, *number)
            case Line("#", (text,)) if blocks.around[at] is None:
                comments.append(text)
                lines[at] = Line("")
    body = _Bodies(lines, {block.first: block for block in blocks.all}).body
    starts = [at for at, line in enumerate(lines) if line.word == "procedure"]
    procedures = [
        Procedure(str(lines[at].values[0]), body(at + 1, stop), span=lines[at].span)
        for at, stop in pairwise([*starts, len(lines)])
    ]
    if loose := body(0, min([*starts, len(lines)])):
        procedures.insert(0, Procedure("unnamed", loose))
    name, start, robot = (said.get(word) for word in ("program", "start", "robot"))
    return Program(name, tuple(procedures), start, robot, tuple(comments), **rows)


class _Bodies:
    """A block that is not whole is a finding of `checks.py`; here its lines still count.

    blocks: by the place of their first lines.
    """

    def __init__(self, lines: list[Line], blocks: dict[int, Block]) -> None:
        self.lines, self.blocks = lines, blocks

    def body(self, at: int, stop: int) -> tuple[p.Statement, ...]:
        made: list[p.Statement] = []
        while at < stop:
            line, block = self.lines[at], self.blocks.get(at)
            if block and (block.last or stop) < stop and block.depth <= tables.MOST_BLOCKS + 1:
                bodies = (self.body(one + 1, other) for one, other in pairwise(block.words))
                found = _block(line, next(bodies), tuple(chain(*bodies)))
                at = block.words[-1]
            elif line.word == "#":
                found = p.Comment(str(line.values[0]))
            else:
                found = tables.ROWS.read(Called(line.word, line.values), READING)
            made += [] if found is None else [replace(found, span=line.span)]
            at += 1
        return tuple(made)


def _block(line: Line, then: Body, otherwise: Body) -> p.Statement:
    asked = tables.ROWS.read(Called(tables.CONDITION, line.values), READING)
    if line.word == "if":
        return p.If((p.Branch(asked, then),), otherwise)
    return p.While(asked, then)

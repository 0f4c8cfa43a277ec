"""Configurations that are left to the arm, where nothing watches those of straight moves.

There a straight move or an arc goes on in the configuration nearest to the one that it begins in,
whatever its target states.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np

from assistant.program import statements as p
from assistant.program.analysis.uses import names_in
from assistant.program.analysis.ways import LINES, OPEN, MotionStates, StepsOfText
from assistant.program.geometry import Target
from assistant.program.kept import effect_of
from assistant.program.path import Kind, Path, configuration_row
from assistant.program.program import Program, walk
from assistant.program.rewriting import Body, map_bodies, rewrite


def with_open_lines(program: Program, kept: StepsOfText) -> Program:
    """With the targets open that only such straight moves use, for an arm to choose.

    kept: what kept texts do.
    """
    ways = MotionStates(program, _is_straight, kept)
    free = {
        id(node)
        for procedure in program.procedures
        for node in walk(procedure.body)
        if _is_straight(node) and ways.at(procedure, node)[LINES] == {OPEN}
    }
    if not free:
        return program
    uses, open_uses = Counter[str](), Counter[str]()
    for part in (program.procedures, program.variables):
        uses.update(name.lower() for name in names_in(part))
    for declaration in program.declarations:
        uses.update(effect_of(declaration).names)
    for node in program.statements():
        if id(node) in free:
            open_uses.update(name.lower() for name in names_in(node))
    targets = {
        name: replace(target, configuration=None)
        if 0 < uses[name.lower()] == open_uses[name.lower()]
        else target
        for name, target in program.targets.items()
    }

    def opened(body: Body) -> Body:
        return tuple(
            rewrite(node, _opened, ()) if id(node) in free else map_bodies(node, opened)
            for node in body
        )

    procedures = tuple(replace(q, body=opened(q.body)) for q in program.procedures)
    return replace(program, targets=targets, procedures=procedures)


def _is_straight(record: Any) -> bool:
    match record:
        case p.Move(kind="linear") | p.MoveCircular():
            return True
        case p.Follow(path):
            return bool((path.kinds != Kind.JOINT).any())
    return False


def _opened(part: Any) -> Any:
    match part:
        case Target():
            return replace(part, configuration=None)
        case Path():
            rows = part.configurations.copy()
            rows[part.kinds != Kind.JOINT] = np.array(configuration_row(None), rows.dtype)
            return replace(part, configurations=rows)
    return part

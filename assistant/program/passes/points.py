"""Moves to points: paths row by row, and targets under names of their own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Target
from assistant.program.path import Kind, Path
from assistant.program.program import Program, TakenNames, identifier
from assistant.program.rewriting import Body, map_bodies


def motion_at(path: Path, row: int) -> p.Motion:
    """The speed, blend, tool and frame of one row; for the few, never for all of a long path."""
    speed, blend = path.speeds[path.speed[row]], path.blends[path.blend[row]]
    return p.Motion(speed, blend, path.tools[path.tool[row]], path.frames[path.frame[row]])


def move_at(path: Path, row: int, target: e.Expression) -> p.Move:
    """The move to a row of a path that is no part of an arc."""
    kind = path.kinds[row]
    return p.Move("joint" if kind == Kind.JOINT else "linear", target, motion_at(path, row))


def with_points(program: Program) -> Program:
    """The program that moves to declared targets: those in moves and of paths become such.

    For a language without paths and without targets written out. Paths with arcs stay.
    """
    targets = dict(program.targets)
    taken = TakenNames(targets)

    def point(target: Target, wanted: str) -> e.Name:
        name = identifier(wanted, taken)
        taken.add(name)
        targets[name] = target
        return e.Name(name)

    def moves(node: p.Statement) -> Iterator[p.Statement]:
        match node:
            case p.Move(target=e.TargetValue(target)):
                yield replace(node, target=point(target, "point"))
            case p.Follow(path) if set(path.kinds.tolist()) <= {Kind.JOINT, Kind.LINEAR}:
                for row in range(len(path)):
                    to = point(path.target(row), f"{path.name}_{row + 1}")
                    yield replace(move_at(path, row, to), span=node.span)
            case _:
                yield map_bodies(node, body)

    def body(given: Body) -> Body:
        return tuple(made for node in given for made in moves(node))

    procedures = tuple(replace(q, body=body(q.body)) for q in program.procedures)
    return replace(program, procedures=procedures, targets=targets)

"""Targets in the robot's base, for arms whose orientations depend on where they are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from assistant.program import expressions as e
from assistant.program import rotations
from assistant.program import statements as p
from assistant.program.geometry import BASE, Pose, Target
from assistant.program.passes.legalising import Legalisation
from assistant.program.program import Program
from assistant.program.rewriting import rewrite


def in_base(job: Legalisation) -> Program:
    """Targets and paths in robot coordinates: five axes code orientation by position.

    Only what a frame is used for moves; a named target of one frame becomes one in the base.
    """
    program, findings, can = job.program, job.findings, job.can.five_axes
    if can is None:
        return program
    frames = {n.lower(): f.pose for n, f in program.frames.items()}
    used: dict[str, str] = {}
    set_ones = {n.lower() for n in _assigned(program)}
    targets = dict(program.targets)

    def moved(target: Target, pose: Pose) -> Target:
        return replace(target, pose=pose @ target.pose)

    def place(value: e.Expression, frame: str) -> e.Expression:
        match value:
            case e.TargetValue(target=target):
                return e.TargetValue(moved(target, frames[frame]))
            case e.Name(name=name):
                key = next((n for n in targets if n.lower() == name.lower()), None)
                if key is not None and used.setdefault(key, frame) == frame:
                    return value
        job.cannot(
            what=f"a computed or shared target of frame `{frame}` on an arm of five axes",
            cure="give the target in the robot's base",
        )
        return value

    def still(frame: str) -> None:
        if frame in set_ones:
            job.cannot(
                what=f"a move in frame `{frame}`, which the program sets, on an arm of five axes",
                cure="give the frame its place before the program is written",
            )

    def move(node: p.MoveStatement) -> p.Statement:
        frame = node.motion.frame.lower()
        if frame == BASE or frame not in frames:
            if isinstance(node, p.Move) and isinstance(node.target, e.Name):
                used.setdefault(node.target.name, BASE)
            return node
        still(frame)
        findings.append(can.to_base(name=node.motion.frame))
        motion = replace(node.motion, frame=BASE)
        if isinstance(node, p.MoveJoints):
            return replace(node, motion=motion)
        if isinstance(node, p.MoveCircular):
            return replace(
                node, motion=motion, via=place(node.via, frame), target=place(node.target, frame)
            )
        return replace(node, motion=motion, target=place(node.target, frame))

    def follow(node: p.Follow) -> p.Follow:
        path = node.path
        if all(f.lower() == BASE or f.lower() not in frames for f in path.frames):
            return node
        positions, quaternions = path.positions.copy(), path.quaternions.copy()
        for row, name in enumerate(path.frames):
            pose, rows = frames.get(name.lower()), path.frame == row
            if pose is None or name.lower() == BASE or not rows.any():
                continue
            still(name.lower())
            findings.append(can.to_base(name=name))
            positions[rows] = rotations.rotate(pose.quaternion, positions[rows]) + pose.position
            quaternions[rows] = rotations.canonical(
                rotations.multiply(pose.quaternion, quaternions[rows])
            )
        return replace(
            node,
            path=replace(
                path, positions=positions, quaternions=quaternions,
                frames=(BASE,), frame=np.zeros(len(path), dtype=np.int32),
            ),
        )  # fmt: skip

    def visit(node: Any) -> Any:
        match node:
            case p.Move() | p.MoveCircular() | p.MoveJoints():
                return move(node)
            case p.Follow():
                return follow(node)
        return node

    procedures = rewrite(program.procedures, visit)
    for name, frame in used.items():
        if frame != BASE and name in targets:
            targets[name] = moved(targets[name], frames[frame])
    return replace(program, procedures=procedures, targets=targets)


def _assigned(program: Program) -> Iterator[str]:
    """Names that statements assign to, or to a part of."""
    for node in program.statements():
        if isinstance(node, p.Assign):
            place = node.target
            while isinstance(place, e.Member | e.Index):
                place = place.value
            if isinstance(place, e.Name):
                yield place.name

"""Unfolding: a program as the moves and other statements that a controller runs, in their order.

It shares nothing with the forms that it reverses, so that a program in one of them can be compared
with the plain one.
"""

from __future__ import annotations

from dataclasses import field, replace
from typing import Any, Final

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Target
from assistant.program.motion import Blend, Kind, Path, Speed, configuration_row
from assistant.program.passes.paths import COLUMNS
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import map_expressions
from assistant.robots.program_values import Names

_DEEPEST: Final = 64
"""Calls and loops inside each other that are followed."""


class NotUnfolded(ValueError):
    """The order of moves, or a value of one, is known only when the program runs."""


def unfolded(program: Program) -> Program:
    """Return the moves and other statements of a program in the order in which they are run.

    Calls and loops are followed; constants, offsets and arrays have their values. Without an entry,
    the procedures are run one after the other. Raises NotUnfolded for a program with branches or
    with values that change.
    """
    entry = program.procedure(program.entry or "")
    following = _Following(program)
    for procedure in program.procedures if entry is None else (entry,):
        following.body(procedure.body, _DEEPEST)
        following.end_path()
    return Program(
        program.name,
        (Procedure("main", tuple(following.made)),),
        tools=program.tools,
        frames=program.frames,
        signals=program.signals,
    )


@dataclass(slots=True)
class _Rows:
    """Columns of a path, collected move by move."""

    kinds: list[Any] = field(default_factory=list)
    positions: list[Any] = field(default_factory=list)
    quaternions: list[Any] = field(default_factory=list)
    configurations: list[Any] = field(default_factory=list)
    external: list[Any] = field(default_factory=list)
    settings: list[Any] = field(default_factory=list)


class _Following:
    """Follows a program. made: statements in their order. rows: moves since the last other one."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.names = Names(program)
        self.arrays: dict[str, dict[int, Target]] = {}
        for name, variable in program.variables.items():
            if isinstance(variable.initial, e.Aggregate) and variable.type == "position":
                values = enumerate(variable.initial.items, 1)
                self.arrays[name.lower()] = {
                    at: one.target for at, one in values if isinstance(one, e.TargetValue)
                }
        self.speeds = {name.lower(): one for name, one in program.speeds.items()}
        self.blends = {name.lower(): one for name, one in program.blends.items()}
        self.made: list[p.Statement] = []
        self.rows = _Rows()
        self.table: dict[tuple[Any, ...], int] = {}

    def body(self, body: tuple[p.Statement, ...], depth: int) -> None:
        if not depth:
            raise NotUnfolded("procedures call each other without end")
        for node in body:
            self.statement(node, depth)

    def statement(self, node: p.Statement, depth: int) -> None:
        match node:
            case p.Comment():
                return
            case p.Call(name, ()):
                callee = self.program.procedure(name)
                if callee is None or callee.parameters:
                    raise NotUnfolded(f"`{name}` cannot be followed")
                self.body(callee.body, depth - 1)
            case p.For(variable, first, last, inner, step):
                self.loop(variable, (first, last, step), inner, depth)
            case p.Assign(e.Index(e.Name(name), (index,)), e.TargetValue(target)):
                self.arrays.setdefault(name.lower(), {})[self.whole(index)] = target
            case p.Follow(path):
                self.follow(path)
            case p.Move(kind, target, motion, (), None):
                row = Kind.JOINT if kind == "joint" else Kind.LINEAR
                self.row(row, self.target(target), self.setting(motion))
            case p.MoveCircular(via, target, motion, (), None):
                setting = self.setting(motion)
                self.row(Kind.VIA, self.target(via), setting)
                self.row(Kind.END, self.target(target), setting)
            case p.Move() | p.MoveCircular() | p.MoveJoints():
                self.end_path()
                self.made.append(self.alone(node))
            case p.SetSignal() | p.Wait() | p.WaitSignal() | p.WaitUntil() | p.Gripper() | p.Stop():
                self.end_path()
                self.made.append(replace(node, span=None))
            case _:
                raise NotUnfolded(f"a statement of kind {type(node).__name__} is not followed")

    def loop(
        self,
        variable: str,
        bounds: tuple[e.Expression, e.Expression, e.Expression | None],
        inner: tuple[p.Statement, ...],
        depth: int,
    ) -> None:
        first, last = self.whole(bounds[0]), self.whole(bounds[1])
        if bounds[2] is not None and self.whole(bounds[2]) != 1:
            raise NotUnfolded("a loop has a step")
        key = variable.lower()
        before = self.names.own.get(key)
        for value in range(first, last + 1):
            self.names.own[key] = e.Number(value)
            self.body(inner, depth - 1)
        self.names.own.pop(key)
        if before is not None:
            self.names.own[key] = before

    def whole(self, value: e.Expression) -> int:
        number = self.names.number(value)
        if number is None or number != int(number):
            raise NotUnfolded("an index is no constant")
        return int(number)

    def target(self, value: e.Expression) -> Target:
        place = self.names.place(map_expressions(value, self.element))
        if place is None:
            raise NotUnfolded("a target is computed while the program runs")
        return replace(place.target, pose=place.pose)

    def element(self, value: e.Expression) -> e.Expression:
        match value:
            case e.Index(e.Name(name), (index,)) if name.lower() in self.arrays:
                target = self.arrays[name.lower()].get(self.whole(index))
                if target is None:
                    raise NotUnfolded(f"`{name}` has no such element")
                return e.TargetValue(target)
        return value

    def setting(self, motion: p.Motion) -> int:
        return self.settings(motion.speed, motion.blend, motion.tool, motion.frame)

    def settings(self, speed: Any, blend: Any, tool: str, frame: str) -> int:
        if isinstance(speed, e.Name):
            speed = self.speeds.get(speed.name.lower(), speed)
        if isinstance(blend, e.Name):
            blend = self.blends.get(blend.name.lower(), blend)
        if not (isinstance(speed, Speed | e.Name) and isinstance(blend, Blend | e.Name)):
            raise NotUnfolded("a speed is computed while the program runs")
        return self.table.setdefault((speed, blend, tool.lower(), frame.lower()), len(self.table))

    def row(self, kind: Kind, target: Target, setting: int) -> None:
        rows = self.rows
        rows.kinds.append([kind])
        rows.positions.append([target.pose.position])
        rows.quaternions.append([target.pose.quaternion])
        rows.configurations.append([configuration_row(target.configuration)])
        rows.external.append([target.external])
        rows.settings.append([setting])

    def follow(self, path: Path) -> None:
        rows = self.rows
        columns = np.stack([getattr(path, column) for column in COLUMNS], axis=1)
        used, which = np.unique(columns, axis=0, return_inverse=True)
        known = np.array(
            [
                self.settings(
                    path.speeds[speed], path.blends[blend], path.tools[tool], path.frames[frame]
                )
                for speed, blend, tool, frame in used.tolist()
            ],
            dtype=np.int64,
        )
        rows.kinds.append(path.kinds)
        rows.positions.append(path.positions)
        rows.quaternions.append(path.quaternions)
        rows.configurations.append(path.configurations)
        rows.external.append(path.external)
        rows.settings.append(known[which.reshape(-1)])

    def alone(self, node: Any) -> p.Statement:
        """Return a move that sets outputs on its path, or goes to joints, with its values."""
        values = tuple(self.table)
        index = self.setting(node.motion)
        speed, blend, tool, frame = (tuple(self.table) if index >= len(values) else values)[index]
        node = replace(node, motion=p.Motion(speed, blend, tool, frame), span=None)
        if isinstance(node, p.MoveJoints):
            joints = self.names.joints(node.target)
            return node if joints is None else replace(node, target=e.JointValue(joints))
        if isinstance(node, p.MoveCircular):
            node = replace(node, via=e.TargetValue(self.target(node.via)))
        return replace(node, target=e.TargetValue(self.target(node.target)))  # type: ignore[no-any-return]

    def end_path(self) -> None:
        rows = self.rows
        if not rows.kinds:
            return
        self.rows = _Rows()
        table = list(self.table)
        index = np.concatenate(rows.settings)
        speeds, blends, tools, frames = (tuple(x[k] for x in table) for k in range(4))
        path = Path.of(
            f"rows_{len(self.made)}",
            np.concatenate(rows.positions),
            np.concatenate(rows.quaternions),
            kinds=np.concatenate(rows.kinds),
            configurations=np.concatenate(rows.configurations),
            external=np.concatenate(rows.external),
            speeds=speeds, speed=index,
            blends=blends, blend=index,
            tools=tools, tool=index,
            frames=frames, frame=index,
        )  # fmt: skip
        self.made.append(p.Follow(path))

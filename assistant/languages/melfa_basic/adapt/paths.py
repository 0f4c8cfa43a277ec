"""Paths, speeds and sizes as MELFA-BASIC has them: one program holds so many steps."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.languages.melfa_basic import poses, rules
from assistant.languages.melfa_basic.dialects import LAST_STEP
from assistant.program import expressions as e
from assistant.program import rotations
from assistant.program import statements as p
from assistant.program.geometry import BASE, Pose, Target
from assistant.program.motion import MAXIMUM_SPEED, Speed
from assistant.program.path import UNSTATED, Kind, Path
from assistant.program.program import Procedure, Program, identifier, walk
from assistant.robots.configurations import BACK

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.adapt.program import Context
    from assistant.robots import Robot

MOST_TARGETS: Final = 30_000
"""Targets of one program: its steps end at 32767, and the heading takes some."""

MOST_STEPS: Final = LAST_STEP - 700
"""Steps that a path may take of one program."""

NOMINAL_TCP: Final = 5000.0
"""mm/s that 100 percent of joint speed is taken for where no robot is named."""

MISS: Final = 0.05
"""degrees by which an orientation may leave what five axes reach."""
SAME: Final = 1e-6
"""degrees below which it is reached as it is."""
VERTICAL: Final = 1e-4
"""Sine of the tool's tilt below which it counts as straight up or down."""


def plain_speed(speed: Speed) -> tuple[Speed, list[str]]:
    """The speed's tcp and joint parts, and the names of the others if they state anything."""
    usual = MAXIMUM_SPEED
    parts = [
        text
        for name, text in (
            ("rotation", "deg/s of reorientation"),
            ("external_linear", "mm/s of external axes"),
            ("external_rotary", "deg/s of external axes"),
        )
        if getattr(speed, name) != getattr(usual, name)
    ]
    return Speed(speed.tcp, joint=speed.joint), parts


def joint_percent(tcp: float, robot: Robot | None) -> float:
    """Whole percent of joint speed for a speed in mm/s, rounded down, at least 1."""
    most = NOMINAL_TCP if robot is None else robot.tcp_speed
    if math.isinf(tcp):
        return 100.0
    return float(math.floor(min(100.0, max(1.0, 100.0 * tcp / most))))


def plain_path(context: Context, path: Path) -> Path:
    """A path with plain speeds, blends and configurations."""
    numbers = np.concatenate([path.positions, path.quaternions], axis=1)
    wild = np.flatnonzero(~(np.abs(numbers) < 1e6).all(axis=1))
    if len(wild):
        where = f"`{path.name}_{wild[0] + 1}`"
        context.findings.append(rules.NOT_FINITE(where=where, place=path.name))
        return path
    if not np.isnan(path.external[:, 2:]).all():
        context.findings.append(rules.CANNOT_SAY(
            what=f"external axes beyond the second, of `{path.name}`", cure="leave them out"
        ))  # fmt: skip
    after = np.append(path.kinds[1:], np.uint8(Kind.LINEAR))
    torn = (path.kinds == Kind.VIA) != (after == Kind.END)
    if torn.any() or path.kinds[0] == Kind.END:
        context.findings.append(rules.CANNOT_SAY(
            what=f"half an arc in `{path.name}`", cure="give each arc a via point and an end"
        ))  # fmt: skip
        return path
    path = _external(context, path)
    path = _arcs_as_one(path)
    context.unstated += int(np.count_nonzero(path.configurations[:, 0] == UNSTATED))
    if context.five_axis:
        path = _in_reach(context, path)
    path = replace(
        path, configurations=poses.rounded_configurations(path.configurations, context.robot)
    )
    return _with_tables(context, path)


def _external(context: Context, path: Path) -> Path:
    """Every row of a table has the same axes: one that a row leaves out is refused."""
    used = ~np.isnan(path.external[:, :2])
    if (used.any(axis=0) != used.all(axis=0)).any() or (used[:, 1] & ~used[:, 0]).any():
        context.findings.append(rules.CANNOT_SAY(
            what=f"an external axis that only some targets of `{path.name}` have",
            cure="give every target of the path the same external axes, the first one first",
        ))  # fmt: skip
    return path


def _arcs_as_one(path: Path) -> Path:
    """Speed, blend, tool and frame of a via point are those of the arc's end."""
    via = np.flatnonzero(path.kinds[:-1] == Kind.VIA)
    made: dict[str, Any] = {}
    for column in ("speed", "blend", "tool", "frame"):
        values = np.array(getattr(path, column))
        values[via] = values[via + 1]
        made[column] = values
    return replace(path, **made)


def _in_reach(context: Context, path: Path) -> Path:
    from assistant.robots import five_axis

    behind = over_the_back(path.positions, path.quaternions, path.configurations)
    if behind.any():
        first = int(behind.argmax())
        place = f"{int(behind.sum())} targets of {path.name}"
        context.findings.append(rules.OVER_THE_BACK(name=f"{path.name}_{first + 1}", place=place))
    miss = five_axis.miss(path.positions, path.quaternions)
    far = np.flatnonzero(miss > MISS)
    if len(far):
        worst = int(np.argmax(miss))
        name = f"{path.name}_{worst + 1}"
        context.findings.append(
            rules.UNREACHABLE(
                name=name, angle=float(miss[worst]), place=f"{len(far)} targets of {path.name}"
            )
        )
    off = miss > SAME
    if not off.any():
        return path
    quaternions = path.quaternions.copy()
    ab = five_axis.to_ab(path.positions[off], path.quaternions[off])
    quaternions[off] = five_axis.from_ab(path.positions[off], ab)
    return replace(path, quaternions=quaternions)


def over_the_back(
    positions: NDArray[np.float64],
    quaternions: NDArray[np.float64],
    configurations: NDArray[np.int8],
) -> NDArray[np.bool_]:
    """Which poses a five-axis arm takes over its back with a tool that is not vertical (n,).

    Their A and B depend on axis 1, which no source says of this branch; straight down both
    branches show the same.
    """
    from assistant.robots import five_axis

    tilt = five_axis.to_ab(positions, quaternions)[:, 1]
    tilted = np.abs(np.sin(np.radians(tilt))) > VERTICAL
    return np.asarray((configurations[:, BACK] == 1) & tilted)


def _with_tables(context: Context, path: Path) -> Path:
    """Tables of plain values, each once and in the order of their first use."""
    joint = path.kinds == Kind.JOINT
    pairs = path.speed.astype(np.int64) * 2 + joint
    speeds, speed = _table(pairs, lambda i: context.speed(path.speeds[i // 2], bool(i % 2)))
    blends, blend = _table(path.blend, lambda i: context.blend(path.blends[i]))
    tools, tool = _table(path.tool, lambda i: context.tool(path.tools[i]))
    frames, frame = _table(path.frame, lambda i: context.frame(path.frames[i]))
    return replace(
        path, speeds=speeds, speed=speed, blends=blends, blend=blend,
        tools=tools, tool=tool, frames=frames, frame=frame,
    )  # fmt: skip


def _table(
    index: NDArray[Any], value: Callable[[int], Any]
) -> tuple[tuple[Any, ...], NDArray[np.int32]]:
    """The entries that an index column uses, each once and by first use, and their rows."""
    used, first, inverse = np.unique(index, return_index=True, return_inverse=True)
    order = np.argsort(first)
    entries: list[Any] = []
    rows = np.zeros(len(used), dtype=np.int32)
    for i in order:
        entry = value(int(used[i]))
        if entry not in entries:
            entries.append(entry)
        rows[i] = entries.index(entry)
    return tuple(entries), rows[inverse.reshape(-1)]


# ------------------------------------------------------------------------- five axes


def in_base(context: Context, program: Program) -> Program:
    """Targets and paths in robot coordinates: five axes code orientation by position.

    Only what a frame is used for moves; a named target of one frame becomes one in the base.
    """
    frames = {n.lower(): f.pose for n, f in program.frames.items()}
    used: dict[str, str] = {}
    targets = dict(program.targets)
    from assistant.languages.melfa_basic.adapt.program import mapped

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
        context.findings.append(rules.CANNOT_SAY(
            what=f"a computed or shared target of frame `{frame}` on an arm of five axes",
            cure="give the target in the robot's base",
        ))  # fmt: skip
        return value

    def move(node: p.Move | p.MoveCircular | p.MoveJoints) -> p.Statement:
        frame = node.motion.frame.lower()
        if frame == BASE or frame not in frames:
            if isinstance(node, p.Move) and isinstance(node.target, e.Name):
                used.setdefault(node.target.name, BASE)
            return node
        context.findings.append(rules.TO_BASE(name=node.motion.frame))
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
            context.findings.append(rules.TO_BASE(name=name))
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

    procedures = []
    for procedure in program.procedures:
        body = procedure.body
        for kind in (p.Move, p.MoveCircular, p.MoveJoints):
            body = mapped(body, kind, move)
        procedures.append(replace(procedure, body=mapped(body, p.Follow, follow)))
    for name, frame in used.items():
        if frame != BASE and name in targets:
            targets[name] = moved(targets[name], frames[frame])
    return replace(program, procedures=tuple(procedures), targets=targets)


# --------------------------------------------------------------------------- splitting


def split(context: Context, procedure: Procedure, most: int) -> Iterator[Procedure]:
    """The procedure, and one in a unit of its own for each part of a path that is too long."""
    parts: list[Procedure] = []
    taken = {q.name for q in context.program.procedures}
    taken |= {q.unit for q in context.program.procedures if q.unit}
    from assistant.languages.melfa_basic.adapt.program import mapped

    lone = procedure.unit is not None and len(procedure.body) == 1

    def follow(node: p.Follow) -> p.Statement:
        pieces = cuts(node.path, most)
        if len(pieces) < 2 and (lone or not long_together):
            return node
        names: list[str] = []
        for start, stop in pieces:
            name = identifier(f"{node.path.name}_part_{len(names) + 1}", taken)
            taken.add(name)
            names.append(name)
            rows = node.path.rows(start, stop, name)
            parts.append(Procedure(name, (p.Follow(compact(rows)),), unit=name))
        context.findings.append(
            rules.SPLIT(
                name=node.path.name, count=len(node.path), parts=len(pieces), place=procedure.name
            )
        )
        return _Calls(tuple(p.Call(name, unit=name) for name in names))  # type: ignore[return-value]

    sizes = [len(node.path) for node in walk(procedure.body) if isinstance(node, p.Follow)]
    long_together = sum(sizes) > most and len(sizes) > 1
    body = mapped(procedure.body, p.Follow, follow)
    yield replace(procedure, body=_flattened(body))
    yield from parts


class _Calls:
    """Calls in the place of one statement."""

    def __init__(self, calls: tuple[p.Call, ...]) -> None:
        self.calls = calls


def _flattened(body: tuple[p.Statement, ...]) -> tuple[p.Statement, ...]:
    from assistant.program.program import bodies

    made: list[p.Statement] = []
    for node in body:
        if isinstance(node, _Calls):
            made += node.calls
        elif bodies(node):
            made.append(_flat(node))
        else:
            made.append(node)
    return tuple(made)


def _flat(node: p.Statement) -> p.Statement:
    match node:
        case p.If(branches=branches, otherwise=otherwise):
            made = tuple(replace(b, body=_flattened(b.body)) for b in branches)
            return replace(node, branches=made, otherwise=_flattened(otherwise))
        case p.While(body=body) | p.For(body=body):
            return replace(node, body=_flattened(body))
        case p.Switch(cases=cases, otherwise=otherwise):
            cases = tuple(replace(c, body=_flattened(c.body)) for c in cases)
            return replace(node, cases=cases, otherwise=_flattened(otherwise))
    return node


def cuts(path: Path, most: int) -> list[tuple[int, int]]:
    """Ranges of rows that fit one program each; an arc's two rows stay together.

    A part begins with a straight move where one is near, so that no arc starts unknown.
    """
    n = len(path)
    costs = _steps(path)
    if n <= most and int(costs.sum()) <= MOST_STEPS:
        return [(0, n)]
    total = np.concatenate([[0], np.cumsum(costs)])
    pieces, start = [], 0
    while start < n:
        stop = int(np.searchsorted(total, total[start] + MOST_STEPS, side="right")) - 1
        stop = min(n, start + most, max(stop, start + 2))
        if stop < n:
            stop = _good_cut(path, start, stop)
        pieces.append((start, stop))
        start = stop
    return pieces


def _good_cut(path: Path, start: int, stop: int) -> int:
    """The last row up to `stop` that a part may begin with."""
    least = max(start + 1, stop - (stop - start) // 4)
    kinds = path.kinds[least : stop + 1]
    straight = np.flatnonzero((kinds != Kind.VIA) & (kinds != Kind.END))
    if len(straight):
        return least + int(straight[-1])
    whole = np.flatnonzero(path.kinds[start + 1 : stop + 1] != Kind.END)
    return start + 1 + int(whole[-1]) if len(whole) else stop


def _steps(path: Path) -> NDArray[np.int64]:
    """Steps that each row takes at most: its move, and its settings where they change."""
    costs = (path.kinds != Kind.VIA).astype(np.int64)
    costs[0] += 5
    for column, lines in (("speed", 2), ("blend", 1), ("tool", 1), ("frame", 1)):
        values = getattr(path, column)
        costs[1:] += lines * (values[1:] != values[:-1])
    return np.asarray(costs)


def compact(path: Path) -> Path:
    """The path with only those table rows that it uses, in the order of their first use."""
    made: dict[str, Any] = {}
    for column in ("speed", "blend", "tool", "frame"):
        table: tuple[Any, ...] = getattr(path, column + "s")
        made[column + "s"], made[column] = _table(getattr(path, column), table.__getitem__)
    return replace(path, **made)

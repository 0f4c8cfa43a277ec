"""Paths in the form that their rows are read back as."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.lower.adapt.reached import MISS, SAME, over_the_back
from assistant.languages.melfa_basic.tables import poses
from assistant.program.path import UNSTATED, Kind, Path
from assistant.program.subjects import Declared

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lower.adapt.context import Context


def plain_path(context: Context, path: Path) -> Path:
    """A path with plain speeds, blends and configurations."""
    numbers = np.concatenate([path.positions, path.quaternions], axis=1)
    wild = np.flatnonzero(~(np.abs(numbers) < 1e6).all(axis=1))
    if len(wild):
        where = f"`{path.name}_{wild[0] + 1}`"
        context.findings.append(rules.NOT_FINITE(where=where, about=Declared(path.name, "paths")))
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
    from assistant.robots.arms import five_axis

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


def _with_tables(context: Context, path: Path) -> Path:
    """Tables of plain values, each once and in the order of their first use."""
    joint = path.kinds == Kind.JOINT
    pairs = path.speed.astype(np.int64) * 2 + joint
    speeds, speed = table_of(pairs, lambda i: context.speed(path.speeds[i // 2], bool(i % 2)))
    blends, blend = table_of(path.blend, lambda i: context.blend(path.blends[i]))
    tools, tool = table_of(path.tool, lambda i: context.tool(path.tools[i]))
    frames, frame = table_of(path.frame, lambda i: context.frame(path.frames[i]))
    return replace(
        path, speeds=speeds, speed=speed, blends=blends, blend=blend,
        tools=tools, tool=tool, frames=frames, frame=frame,
    )  # fmt: skip


def table_of(
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

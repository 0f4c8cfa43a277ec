"""Paths in the form that their rows are read back as."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from assistant.languages.five_axes import path_in_reach
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.tables import poses
from assistant.program.passes.path_tables import has_half_arcs, table_of, with_whole_arcs
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
        context.job.cannot(
            what=f"external axes beyond the second, of `{path.name}`", cure="leave them out"
        )
    if has_half_arcs(path):
        context.job.cannot(
            what=f"half an arc in `{path.name}`", cure="give each arc a via point and an end"
        )
        return path
    path = _external(context, path)
    path = with_whole_arcs(path)
    context.unstated += int(np.count_nonzero(path.configurations[:, 0] == UNSTATED))
    if context.five_axis is not None:
        path = path_in_reach(path, context.five_axis, context.findings)
    path = replace(
        path, configurations=poses.rounded_configurations(path.configurations, context.robot)
    )
    return _with_tables(context, path)


def _external(context: Context, path: Path) -> Path:
    """Every row of a table has the same axes: one that a row leaves out is refused."""
    used = ~np.isnan(path.external[:, :2])
    if (used.any(axis=0) != used.all(axis=0)).any() or (used[:, 1] & ~used[:, 0]).any():
        context.job.cannot(
            what=f"an external axis that only some targets of `{path.name}` have",
            cure="give every target of the path the same external axes, the first one first",
        )
    return path


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

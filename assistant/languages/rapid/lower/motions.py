"""Motion as RAPID has it: what a move names, and paths as columns of targets and moves."""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.base.diagnostics import Refused
from assistant.languages.rapid import rules
from assistant.languages.rapid.tables.motions import speed_name, zone_name
from assistant.languages.rapid.tables.words import UNUSED
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.runs import (
    CIRCULAR,
    JOINT_PLACES,
    POSITION_PLACES,
    QUATERNION_PLACES,
    MotionNames,
    MoveRun,
    TargetRun,
    moves_text,
    targets_text,
)
from assistant.languages.runs.columns import Entries, Names
from assistant.languages.runs.paths import setting_codes
from assistant.languages.scoped_names import Naming
from assistant.program import expressions as e
from assistant.program.geometry import BASE
from assistant.program.motion import Blend, Kind, Path, Speed
from assistant.robots.configurations import to_confdata

_SHORTEST_RUN: Final = 8
"""Rows of a run; fewer are single declarations or statements, as they are when read."""


def path_targets(path: Path, stem: str, scope: str) -> list[s.TargetRunNode | s.Data]:
    """The declarations of a path's targets, `stem_1` and so on."""
    run = _target_run(path, stem)
    if len(run) >= _SHORTEST_RUN:
        return [s.TargetRunNode(scope, run)]
    return list(verbatim.items(targets_text(run, scope, "", "\n")))  # type: ignore[arg-type]


def path_moves(path: Path, stem: str, names: Naming) -> list[s.StatementNode]:
    """The moves through a path's targets."""
    run = _move_run(path, stem, names)
    if len(run) >= _SHORTEST_RUN:
        return [s.MoveRunNode(run)]
    return list(verbatim.statements(moves_text(run, "", "\n")))


def speed_name_in(names: Naming, speed: Speed | e.Name) -> str:
    """What a program calls a speed."""
    return names.get("speeds", speed.name) if isinstance(speed, e.Name) else speed_name(speed)


def blend_name_in(names: Naming, blend: Blend | e.Name) -> str:
    return names.get("blends", blend.name) if isinstance(blend, e.Name) else zone_name(blend)


def frame_name_in(names: Naming, frame: str) -> str:
    """Empty for the base, which no move names."""
    return "" if frame.lower() == BASE else names.get("frames", frame)


def _target_run(path: Path, stem: str) -> TargetRun:
    """The targets of a path, rounded as they are printed."""
    if not (np.isfinite(path.positions).all() and np.isfinite(path.quaternions).all()):
        raise Refused(rules.NOT_FINITE(what=f"the path `{path.name}`"))
    values = np.empty((len(path), 17))
    np.round(path.positions, POSITION_PLACES, out=values[:, 0:3])
    np.round(path.quaternions, QUATERNION_PLACES, out=values[:, 3:7])
    values[:, 7:11] = to_confdata(path.configurations)
    external = np.where(np.isnan(path.external), UNUSED, path.external)
    np.round(external, JOINT_PLACES, out=values[:, 11:17])
    return TargetRun(_target_names(path, stem), values + 0.0)


def _target_names(path: Path, stem: str) -> Names:
    return Names.numbered(f"{stem}_".encode("ascii"), np.arange(1, len(path) + 1))


def _move_run(path: Path, stem: str, names: Naming) -> MoveRun:
    via = path.kinds == Kind.VIA
    ends = np.flatnonzero(~via)
    _, first, index = np.unique(setting_codes(path)[ends], return_index=True, return_inverse=True)
    table: dict[MotionNames, int] = {}
    rows = []
    for row in ends[first].tolist():
        speed, blend = path.speeds[path.speed[row]], path.blends[path.blend[row]]
        tool, frame = path.tools[path.tool[row]], path.frames[path.frame[row]]
        named = names.get("tools", tool), frame_name_in(names, frame)
        motion = MotionNames(speed_name_in(names, speed), blend_name_in(names, blend), *named)
        rows.append(table.setdefault(motion, len(table)))
    kinds = np.array([0, 1, 0, 2], dtype=np.uint8)[path.kinds[ends]]
    whole, arcs = _target_names(path, stem), kinds == CIRCULAR
    vias = whole.rows(np.flatnonzero(via)).spread(np.flatnonzero(arcs), len(ends))
    motions = Entries(tuple(table), np.array(rows, dtype=np.int32)[index])
    return MoveRun(kinds, whole.rows(ends), vias if arcs.any() else Names.none(len(ends)), motions)

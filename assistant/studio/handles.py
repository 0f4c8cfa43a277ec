"""What can be taken hold of in a scene: targets that the text declares, and a drawing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Final

import numpy as np

from assistant.base.toml_text import key_spans
from assistant.editing.workspace import Document, Workspace
from assistant.program import pseudo
from assistant.program.expressions import Name
from assistant.program.geometry import BASE, IDENTITY, Pose
from assistant.program.program import Program
from assistant.program.statements import Follow, MoveCircular
from assistant.report.track import stops
from assistant.studio.path_rows import NamedRows
from assistant.studio.stages import DRAWING_HANDLE, TARGET_HANDLE, TAUGHT_SUFFIX, Handle, Stage
from assistant.studio.studio import Studio
from assistant.studio.toml_edits import toml_content

MOST_HANDLES: Final = 20_000
"""That a page is told of."""


def handles_of(studio: Studio, stage: Stage) -> list[Handle]:
    """In the order in which the program comes to them, each place of a name once."""
    if stage.loaded is None:
        return []
    found = [*_drawing_handles(stage)]
    known = target_lines(studio, stage)
    seen = set[tuple[object, ...]]()
    for one in _target_handles(stage, NamedRows(studio, stage)):
        at = known.get(one.name.lower())
        key = (one.name.lower(), *(round(value, 3) for value in one.pose.position))
        if at is None or key in seen or len(found) >= MOST_HANDLES:
            continue
        seen.add(key)
        path, line = at
        turns = stage.robot is not None and stage.robot.five_axis
        with_arm = turns and not path.lower().endswith((pseudo.SUFFIX, TAUGHT_SUFFIX))
        found.append(replace(one, path=path, line=line, with_arm=with_arm))
    return found


def _target_handles(stage: Stage, rows: NamedRows) -> Iterator[Handle]:
    assert stage.loaded is not None
    program = stage.loaded.program if stage.solved is None else stage.solved.solution.program
    said = {name.lower(): one.pose for name, one in stage.loaded.program.targets.items()}
    now = {name.lower(): one.pose for name, one in program.targets.items()}
    for stop in stops(program):
        if isinstance(stop.statement, Follow):
            frames = stop.statement.path.frames
            for row, (name, declared) in enumerate(rows.of(stop.statement)):
                frame = _fixed_frame(program, frames[stop.statement.path.frame[row]])
                if frame is not None:
                    world = stage.shown.base @ frame
                    yield Handle(
                        *(
                            TARGET_HANDLE,
                            name,
                            world @ declared,
                            world,
                            stop.procedure,
                            stop.place,
                            row,
                        )
                    )
            continue
        frame = _fixed_frame(program, stop.statement.motion.frame)
        if frame is None:
            continue
        target = stop.statement.target
        via = stop.statement.via if isinstance(stop.statement, MoveCircular) else None
        of_move = (target,) if via is None else (via, target)
        for row, one in enumerate(of_move):
            if not isinstance(one, Name):
                continue
            pose = now.get(one.name.lower())
            if pose is not None and pose == said.get(one.name.lower()):
                world = stage.shown.base @ frame
                yield Handle(
                    *(TARGET_HANDLE, one.name, world @ pose, world, stop.procedure, stop.place, row)
                )


def _fixed_frame(program: Program, name: str) -> Pose | None:
    """None for one that the arm or something else carries."""
    if name == BASE:
        return IDENTITY
    frame = next((f for n, f in program.frames.items() if n.lower() == name.lower()), None)
    return None if frame is None or frame.held or frame.mechanism else frame.pose


def _drawing_handles(stage: Stage) -> Iterator[Handle]:
    if not stage.process or stage.placed is None:
        return
    frame, placement = stage.placed
    world = stage.shown.base @ frame
    pose = world @ placement
    lines = [stage.shown.base.moved(one.points) for one in stage.shown.drawn]
    grip = (0.0, 0.0, 0.0)
    if lines:
        every = np.concatenate(lines)
        x, y, z = (every.min(axis=0) + every.max(axis=0)) / 2.0 - np.array(pose.position)
        grip = (float(x), float(y), float(z))
    yield Handle(DRAWING_HANDLE, stage.path, pose, world, path=stage.process, grip=grip)


def target_lines(studio: Studio, stage: Stage) -> Mapping[str, tuple[str, int]]:
    """Name in lower case → the file that declares a target, and its line from 1."""
    if stage.process:
        return {}
    if stage.path.lower().endswith(TAUGHT_SUFFIX):
        return dict(_taught_lines(stage.path, stage.text))
    workspace = Workspace(studio.folder)
    document = workspace.open(str(studio.place(stage.path)), stage.text)
    found: dict[str, tuple[str, int]] = {}
    implied: dict[str, tuple[str, int]] = {}
    for one in workspace.task(document):
        path = studio.named(FilePath(one.path))
        for line, name, sure in _declared_names(one):
            (found if sure else implied).setdefault(name, (path, line))
    return implied | found


def _declared_names(document: Document) -> Iterator[tuple[int, str, bool]]:
    for number, facts in enumerate(document.facts, start=1):
        for one in facts.declares:
            yield number, one.name.lower(), not one.implied


def _taught_lines(path: str, text: str) -> Iterator[tuple[str, tuple[str, int]]]:
    spans = key_spans(text)
    for name, number in taught_entries(text):
        span = spans[("targets", number, "name")]
        yield name, (path, text.count("\n", 0, span.start) + 1)


def taught_entries(text: str) -> Iterator[tuple[str, str]]:
    """Names of taught targets in lower case, with their numbers as `key_spans` has them."""
    entries = (toml_content(text) or {}).get("targets", [])
    for number, entry in enumerate(entries if isinstance(entries, list) else ()):
        name = entry.get("name") if isinstance(entry, dict) else None
        if isinstance(name, str):
            yield name.lower(), str(number)

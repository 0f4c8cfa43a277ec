"""Stages: programs that the scene shows, and what of them can be moved.

Targets that the text declares, rows of paths by the names that the text gives them, and drawings
have handles. A run of moves through numbered targets is read as one path in columns, which holds
the poses of its rows but not their names.
"""

from __future__ import annotations

import re
import threading
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.base.toml_text import key_spans, toml_content
from assistant.editing.workspace import Document, Workspace
from assistant.program import pseudo
from assistant.program.expressions import Name
from assistant.program.geometry import BASE, IDENTITY, Pose, Vector
from assistant.program.motion import Path
from assistant.program.program import Program, walk
from assistant.program.statements import Follow, MoveCircular
from assistant.report.track import stops
from assistant.studio import rules
from assistant.studio.studio import Studio

if TYPE_CHECKING:
    from assistant.cell.collision.model import Model
    from assistant.compiler.loader import Loaded
    from assistant.compiler.retarget import Solved
    from assistant.robots import Robot
    from assistant.view.page_contents import Shown


_LIVE_KIND: Final = "scenes"
"""Kind of the stages in the live table."""
_MOST_STAGES: Final = 4
"""Scenes that windows may ask about."""
TAUGHT_SUFFIX: Final = ".toml"
DRAWING_HANDLE: Final = "drawing"
_TARGET_HANDLE: Final = "target"


@dataclass(frozen=True, slots=True)
class Handle:
    """Something that can be moved.

    kind: TARGET or DRAWING. pose: in the world. frame: in which the text has it, in the world.
    procedure, place, row: of the motion statement that leads there, and of its target among those
    of the statement. path, line: what declares it, counted from 1; line 0 where nothing does.
    grip: (3,) mm in the world from there to where it is taken hold of. with_arm: whether the text
    says how the tool leans and rolls in the plane of an arm of five axes, which turns with it.
    """

    kind: str
    name: str
    pose: Pose
    frame: Pose
    procedure: str = ""
    place: int = 0
    row: int = 0
    path: str = ""
    line: int = 0
    grip: Vector = (0.0, 0.0, 0.0)
    with_arm: bool = False

    def held_at(self, gripped: Sequence[float]) -> Vector:
        """Return its position in the world if it is held there by its grip."""
        x, y, z = (at - off for at, off in zip(gripped, self.grip, strict=True))
        return x, y, z

    def record(self) -> dict[str, Any]:
        return {
            "kind": self.kind,
            "name": self.name,
            "position": [a + b for a, b in zip(self.pose.position, self.grip, strict=True)],
            "path": self.path,
            "line": self.line,
        }


@dataclass(slots=True, eq=False)
class Stage:
    """One state of a program, ready to be shown and queried.

    path: of its source, as the page names it. process: of the process file of a drawing. text: of
    the file edited by a move. solved: None if no arm runs it. placed: for a drawing, the pose of
    its frame in the robot's base, and its pose in that frame. record: of its page, see `view`.
    handles: objects that can be moved there.
    """

    name: str
    path: str
    process: str
    text: str
    shown: Shown
    solved: Solved | None
    loaded: Loaded | None
    placed: tuple[Pose, Pose] | None = None
    record: dict[str, Any] = field(default_factory=dict)
    handles: Sequence[Handle] = ()
    lock: threading.Lock = field(default_factory=threading.Lock)
    _model: Model | None = None

    @property
    def robot(self) -> Robot | None:
        return None if self.solved is None else self.solved.solution.robot

    def model(self) -> Model | None:
        """Return the collision model of the cell; None without one."""
        from assistant.cell.collision.model import Model

        if self._model is None and self.solved is not None and self.solved.scene is not None:
            self._model = Model(self.shown.scene)
        return self._model


@dataclass(slots=True, eq=False)
class Stages:
    """Those that were shown last, by their names."""

    _known: OrderedDict[str, Stage] = field(default_factory=OrderedDict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def get(self, name: str) -> Stage:
        """Raises Refused for one that is not there any more."""
        found = self.known(name)
        if found is None:
            raise Refused(rules.NO_SCENE(), exit_status=2)
        return found

    def known(self, name: str) -> Stage | None:
        with self._lock:
            return self._known.get(name)

    def keep(self, stage: Stage) -> None:
        with self._lock:
            self._known[stage.name] = stage
            while len(self._known) > _MOST_STAGES:
                self._known.popitem(last=False)


def stages_of(studio: Studio) -> Stages:
    found = studio.live.setdefault(_LIVE_KIND, Stages())
    assert isinstance(found, Stages)
    return found


_NUMBERED_NAME: Final = re.compile(r"(.*?)([0-9]{1,9})", re.DOTALL)
_SAME_POSE: Final = 1e-6
"""Tolerance in mm, and in parts of a quaternion."""


class _NamedRows:
    """Names of the rows of the paths of a stage."""

    def __init__(self, studio: Studio, stage: Stage) -> None:
        self._studio, self._stage = studio, stage

    def of(self, follow: Follow) -> list[tuple[str, Pose]]:
        """Name and pose of each row as its text declares them; none where that is not sure."""
        numbers: dict[str, dict[int, str]] = {}
        for name in self._names_at(follow):
            match = _NUMBERED_NAME.fullmatch(name)
            if match is not None and name in self._declared:
                numbers.setdefault(match[1], {})[int(match[2])] = name
        for of_stem in numbers.values():
            for first in sorted(of_stem):
                names = [of_stem.get(first + row, "") for row in range(len(follow.path))]
                if all(names) and _match_rows([self._declared[n][1] for n in names], follow.path):
                    return [self._declared[name] for name in names]
        return []

    @cached_property
    def _documents(self) -> tuple[Document, ...]:
        workspace = Workspace(self._studio.folder)
        opened = workspace.open(str(self._studio.place(self._stage.path)), self._stage.text)
        return tuple(workspace.task(opened))

    @cached_property
    def _declared(self) -> Mapping[str, tuple[str, Pose]]:
        """Names in lower case → what is declared by them: the name as it is written, the pose."""
        assert self._stage.loaded is not None
        procedures = self._stage.loaded.program.procedures
        follows = [one for q in procedures for one in walk(q.body) if isinstance(one, Follow)]
        names = {name for one in follows for name in self._names_at(one)}
        found: dict[str, tuple[str, Pose]] = {}
        for document in self._documents:
            speaks = document.spoken
            if speaks is None or speaks.editable is None:
                continue
            wanted = frozenset(map(speaks.editable.folded, names))
            text = document.declared(wanted).source(document.path)
            for name, target in speaks.program(text, (), self._stage.robot).targets.items():
                found.setdefault(name.lower(), (name, target.pose))
        return found

    def _names_at(self, follow: Follow) -> Iterator[str]:
        """Names in lower case on the lines of a statement."""
        place = None if follow.span is None else self._stage.shown.places.of(follow.span)
        if place is None or place.path is None:
            return
        path = self._studio.named(FilePath(place.path))
        for document in self._documents:
            if self._studio.named(FilePath(document.path)) == path:
                last = place.line + place.text.rstrip().count("\n")
                for facts in document.facts[place.line - 1 : last]:
                    yield from map(str.lower, facts.names)


def _match_rows(poses: list[Pose], path: Path) -> bool:
    """True if poses are those of the rows of a path."""
    positions = np.array([pose.position for pose in poses])
    turns = np.array([pose.quaternion for pose in poses])
    alike = np.abs(np.sum(turns * path.quaternions, axis=1)) > 1.0 - _SAME_POSE
    return bool(np.abs(positions - path.positions).max() < _SAME_POSE and alike.all())


_MOST_HANDLES: Final = 20_000
"""Most handles sent to a page."""


def handles_of(studio: Studio, stage: Stage) -> list[Handle]:
    """In the order in which the program comes to them, each place of a name once."""
    if stage.loaded is None:
        return []
    found = [*_drawing_handles(stage)]
    known = _target_lines(studio, stage)
    seen = set[tuple[object, ...]]()
    for one in _target_handles(stage, _NamedRows(studio, stage)):
        at = known.get(one.name.lower())
        key = (one.name.lower(), *(round(value, 3) for value in one.pose.position))
        if at is None or key in seen or len(found) >= _MOST_HANDLES:
            continue
        seen.add(key)
        path, line = at
        turns = stage.robot is not None and stage.robot.five_axis
        with_arm = turns and not path.lower().endswith((pseudo.SUFFIX, TAUGHT_SUFFIX))
        found.append(replace(one, path=path, line=line, with_arm=with_arm))
    return found


def _target_handles(stage: Stage, rows: _NamedRows) -> Iterator[Handle]:
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
                            _TARGET_HANDLE,
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
                    *(
                        _TARGET_HANDLE,
                        one.name,
                        world @ pose,
                        world,
                        stop.procedure,
                        stop.place,
                        row,
                    )
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
    drawn = [one for one in stage.shown.drawn if not one.left] or stage.shown.drawn
    lines = [stage.shown.base.moved(one.points) for one in drawn]
    grip = (0.0, 0.0, 0.0)
    if lines:
        every = np.concatenate(lines)
        x, y, z = (every.min(axis=0) + every.max(axis=0)) / 2.0 - np.array(pose.position)
        grip = (float(x), float(y), float(z))
    yield Handle(DRAWING_HANDLE, stage.path, pose, world, path=stage.process, grip=grip)


def _target_lines(studio: Studio, stage: Stage) -> Mapping[str, tuple[str, int]]:
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

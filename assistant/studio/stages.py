"""Stages: programs that the scene shows, ready to be asked what would be if something moved."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Refused
from assistant.program.geometry import Pose, Vector
from assistant.studio import rules
from assistant.studio.studio import Studio

if TYPE_CHECKING:
    from assistant.cell.collision.model import Model
    from assistant.compiler.loader import Loaded
    from assistant.compiler.retarget import Solved
    from assistant.robots import Robot
    from assistant.view.shown import Shown

LIVE_KIND: Final = "scenes"
"""Of what is live."""
MOST_STAGES: Final = 4
"""Scenes that windows may ask about."""
TAUGHT_SUFFIX: Final = ".toml"
DRAWING_HANDLE: Final = "drawing"
TARGET_HANDLE: Final = "target"


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
        """Where it is in the world if it is held there by its grip."""
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
    """One state of a program, ready to be shown and asked about.

    path: of its source, as the page calls it. process: of the process file of a drawing. text: of
    what is edited when something is moved. solved: None where no arm goes through it. placed: of a
    drawing the pose of its frame in the robot's base, and where it stands in that. record: of its
    page, see `view`. handles: what can be moved there.
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
        """What could touch in the cell; None without one."""
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
            while len(self._known) > MOST_STAGES:
                self._known.popitem(last=False)


def stages_of(studio: Studio) -> Stages:
    found = studio.live.setdefault(LIVE_KIND, Stages())
    assert isinstance(found, Stages)
    return found

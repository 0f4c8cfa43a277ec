"""How near the bodies of a cell come to each other while its robots move."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as FilePath

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.blocks.diagrams.block import Block, Port
from assistant.blocks.library.arrays import joints_port
from assistant.blocks.library.rules import NO_ROBOT_IN_CELL
from assistant.cell.cell_file import read_scene
from assistant.cell.collision.model import Model
from assistant.cell.scene import Scene


class CollisionDistance(Block):
    """joints of robots → the least distance in mm of any two bodies that could touch.

    Below 0 by how deep they are in each other as far as that is known, inf where nothing could
    touch. `nearest` names both bodies of the step before. cell: a scene, or its file. robots: names
    of those that have an input, `joints` of one and `NAME` of several; the only one, or the one
    that runs the program, if left out. The others stand at home. Raises Refused for names that the
    cell has not, for a cell that cannot be read, and without coal.
    """

    def __init__(
        self, name: str, cell: Scene | str | FilePath, robots: Sequence[str] | None = None
    ) -> None:
        scene = cell if isinstance(cell, Scene) else read_scene(cell)[0]
        names = [one.name for one in scene.robots]
        chosen = [scene.runs] if robots is None and scene.runs else robots or names
        known = ", ".join(f"`{one}`" for one in names) or "none, as the cell has no robot"
        if robots is None and len(chosen) != 1:
            raise Refused(NO_ROBOT_IN_CELL(name="", block=name, known=known))
        for one in chosen:
            if chosen.count(one) != 1 or one not in names:
                raise Refused(NO_ROBOT_IN_CELL(name=one, block=name, known=known))
        self._places = [names.index(one) for one in chosen if one is not None]
        found = [scene.robots[place] for place in self._places]
        single = len(found) == 1
        ports = [joints_port(one.robot, "joints" if single else one.name) for one in found]
        super().__init__(name, ports, [Port("distance", unit="mm")])
        self.scene, self._model = scene, Model(scene)
        self._joints = [one.robot.home for one in scene.robots]
        self.nearest: tuple[str, str] | None = None

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Raises ValueError for joints that are no numbers: nothing is known of these."""
        del now
        if not all(np.isfinite(one).all() for one in given):
            raise ValueError("joints are no numbers")
        joints = list(self._joints)
        for place, one in zip(self._places, given, strict=True):
            joints[place] = one
        least, which = self._model.nearest(np.concatenate(joints)[None])
        pair = int(which[0])
        self.nearest = None if pair < 0 else self._names(pair)
        return [[least[0]]]

    def _names(self, pair: int) -> tuple[str, str]:
        items = self._model.items
        one, other = (items[int(i[pair])].body.name for i in (self._model.one, self._model.other))
        return one, other

"""What a page is to show of a program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from assistant.base.diagnostics import Diagnostic
from assistant.cell.clearances import Closeness
from assistant.cell.scene import PlacedRobot, Scene
from assistant.compiler.source_map import Places
from assistant.program.geometry import IDENTITY, Pose
from assistant.program.program import Program
from assistant.report.drawn import DrawnLine
from assistant.robots.solved_program import SolvedProgram
from assistant.robots.timing import Simulation
from assistant.view.beside import SideBySide

Marked = tuple[Diagnostic, Closeness | None]
"""A finding, and where in the scene it is."""


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """What is to be seen.

    solution: of the program, simulated on `placed`, one of the robots of the scene; the others
    stand at home. None for both if no arm goes through it: then `program` is drawn as it stands,
    before `placed`, or alone if that is None. places: of the program's texts. findings: in the
    order of the list. drawn: lines of its drawing. live: the name of the controller that the page
    follows, None for none. program: what is drawn without an arm. notes: sentences below the title.
    beside: the text that it was made of, line by line. told, spans: the program that findings tell
    of, and the places of its texts, where it is another. plan: seen from above and from the side
    at first.
    """

    title: str
    solution: SolvedProgram | None
    simulation: Simulation | None
    scene: Scene
    placed: PlacedRobot | None
    places: Places
    findings: Sequence[Marked] = ()
    drawn: Sequence[DrawnLine] = ()
    live: str | None = None
    program: Program | None = None
    notes: Sequence[str] = ()
    beside: SideBySide | None = None
    told: Program | None = None
    spans: Places | None = None
    plan: bool = False

    @property
    def base(self) -> Pose:
        """Where the robot of the program stands in the world."""
        return IDENTITY if self.placed is None else self.placed.base

"""Sheets: programs for the page, each as an arm goes through it if one is known."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import PurePath
from typing import TYPE_CHECKING

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Severity

if TYPE_CHECKING:
    from assistant.cell.clearances import Closeness
    from assistant.cell.scene import PlacedRobot, Scene
    from assistant.compiler.comparison import Comparison
    from assistant.compiler.source_map import Places
    from assistant.program.program import Program
    from assistant.report.contour_plot import DrawnLine
    from assistant.robots import Robot, SolvedProgram
    from assistant.robots.timing import Simulation
    from assistant.view.page_contents import Shown
    from assistant.view.side_by_side import SideBySide

    _Marked = tuple[Diagnostic, Closeness | None]


@dataclass(frozen=True, slots=True)
class Sheet:
    """A program for the page.

    found: its findings. program: None if it could not be read. places: of its texts. arm: that runs
    it, None if unknown. solution: for this arm, if there is one already. told, spans: the program
    of the findings and the places of its texts, if it is another, such as the one that it was made
    of. acceleration: see `simulate`. plan: seen from above and from the side at first; None for
    without a cell.
    """

    title: str
    found: Sequence[Diagnostic]
    program: Program | None = None
    places: Places | None = None
    arm: Robot | None = None
    scene: Scene | None = None
    drawn: Sequence[DrawnLine] = ()
    notes: Sequence[str] = ()
    beside: SideBySide | None = None
    solution: SolvedProgram | None = None
    told: Program | None = None
    spans: Places | None = None
    acceleration: float | None = None
    plan: bool | None = None


def compared_sheet(done: Comparison) -> Sheet:
    """Two compared programs side by side; the arm of the second one is simulated."""
    from assistant.compiler.source_map import Places
    from assistant.view.side_by_side import comparison_side_by_side

    first, second = (PurePath(name).name for name in done.names)
    program, text = done.programs[1].program, done.programs[1].text
    return Sheet(
        f"{first} and {second}: {done.answer}",
        done.located_findings(),
        program,
        Places(program, text),
        done.arm,
        notes=(done.line(),),
        beside=comparison_side_by_side(done),
    )


def shown_sheet(sheet: Sheet) -> Shown:
    """Return the page contents: the motion of a program if an arm runs it, else its targets."""
    from assistant.cell.scene import Scene
    from assistant.compiler.source_map import Places
    from assistant.program.program import Program
    from assistant.view.page_contents import Shown

    scene, stands = _standing(sheet)
    marked: list[_Marked] = [(one, None) for one in sheet.found]
    solution = simulation = None
    if stands is not None and sheet.program is not None and _once(sheet.program):
        try:
            solution, simulation, contacts = _moving(sheet, sheet.program, scene, stands)
            marked = _told_once(marked, contacts)
        except Refused as refused:
            told = {one.message for one, _ in marked}
            marked += ((one, None) for one in refused.findings if one.message not in told)
    worst = list(Severity)
    marked.sort(key=lambda one: worst.index(one[0].severity))  # the page cannot hold all
    return Shown(
        sheet.title,
        solution,
        simulation,
        scene or Scene(),
        stands,
        sheet.places or Places(Program("nothing")),
        marked,
        sheet.drawn,
        program=sheet.program,
        notes=sheet.notes,
        beside=sheet.beside,
        told=sheet.told,
        spans=sheet.spans,
        plan=sheet.scene is None if sheet.plan is None else sheet.plan,
    )


def _once(program: Program) -> bool:
    """True if each procedure has a unique name: otherwise calls are ambiguous."""
    names = [one.name.lower() for one in program.procedures]
    return len(set(names)) == len(names)


def _told_once(marked: Sequence[_Marked], contacts: Sequence[_Marked]) -> list[_Marked]:
    """Contacts with their places instead of the same without, unless some would be lost."""
    before = Counter(one.code for one, _ in marked)
    now = Counter(one.code for one, _ in contacts)
    instead = {code for code, count in now.items() if count >= before[code]}
    kept = (one for one in marked if one[0].code not in instead)
    return [*kept, *(one for one in contacts if one[0].code in instead)]


def _moving(
    sheet: Sheet, program: Program, scene: Scene, stands: PlacedRobot
) -> tuple[SolvedProgram, Simulation, list[_Marked]]:
    """A program as the arm goes through it, and what it touches. Raises Refused if it cannot."""
    from assistant import robots
    from assistant.cell.clearances import CarriedBodies, takeable
    from assistant.checks.clearances import placed_clearances
    from assistant.robots.timing import simulate

    arm = stands.robot
    solution = sheet.solution or robots.solve_program(replace(program, robot=arm.name), arm)
    holding = CarriedBodies.at_first(scene, stands) if takeable(scene) else None
    done = simulate(solution, acceleration=sheet.acceleration, carried=holding)
    near = placed_clearances(solution, sheet.scene, done)
    return solution, done, list(near)


def _standing(sheet: Sheet) -> tuple[Scene, PlacedRobot | None]:
    """Return the scene with the robot that runs the program, None if unknown.

    The robot is alone in the world if no cell is given.
    """
    from assistant.cell.clearances import robot_of
    from assistant.cell.link_bodies import place_robot
    from assistant.cell.scene import Scene

    if sheet.arm is None:
        return sheet.scene or Scene(), None
    if sheet.scene is None:
        alone = place_robot("robot", sheet.arm)
        return Scene(robots=(alone,)), alone
    try:
        return sheet.scene, robot_of(sheet.scene, sheet.arm)
    except LookupError:  # which is a finding of whoever checked it
        return sheet.scene, None

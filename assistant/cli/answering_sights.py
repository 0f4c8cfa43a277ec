"""`answer`: where objects are, for programs that ask as they run."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from assistant.base.termination import is_ctrl_c
from assistant.cli.options import CellOption, RobotOption
from assistant.cli.presentation import print_findings, say

if TYPE_CHECKING:
    from assistant.program.geometry import Pose
    from assistant.sources.process import Trust
    from assistant.sources.sights import Sight
    from assistant.vision.answering import Answer

SIGHT_STATES: Final = {None: "not answered", 0: "not in sight", 1: "found", 2: "doubtful"}


def answer(
    seen: Annotated[Path, typer.Argument(help="Where objects were found; read at each question.")],
    at: Annotated[
        str,
        typer.Option(
            help="listen:ADDRESS:PORT for programs that come here, or HOST:PORT of one that waits.",
        ),
    ],
    process: Annotated[
        Path | None,
        typer.Option("--process", "-p", help="Process file that says how far sights are trusted."),
    ] = None,
    robot: RobotOption = None,
    cell: CellOption = None,
    times: Annotated[int, typer.Option(help="Programs to answer; 0 until Ctrl-C.", min=0)] = 0,
    patience: Annotated[
        float | None, typer.Option(help="Seconds without a word; default for ever.", min=0.1)
    ] = None,
) -> None:
    """Answer programs that ask as they run where objects are. No robot is moved by it."""
    given = AnswerOptions(seen, at, times, math.inf if patience is None else patience)
    raise typer.Exit(run_answer(given, process, robot, cell))


@dataclass(frozen=True, slots=True)
class AnswerOptions:
    """seen: file of what was found. at: the line. times: programs, 0 for any number of them."""

    seen: Path
    at: str
    times: int
    patience: float

    def look(self, name: str) -> Sight | None:
        """As the file says it now."""
        from assistant.sources.sights import read_sights

        sights = {key.casefold(): one for key, one in read_sights(self.seen).items()}
        return sights.get(name.casefold())


def run_answer(
    given: AnswerOptions, process: Path | None, robot: str | None, cell: Path | None
) -> int:
    """0 if all that was asked for was found, else 1."""
    from assistant.sources.process import DEFAULT_TRUST
    from assistant.sources.process.file import read_process
    from assistant.sources.sights import read_sights

    trust = DEFAULT_TRUST if process is None else read_process(process).seen.trust
    base = _robot_base(robot, cell)
    read_sights(given.seen)  # what is wrong in it is told before any program waits
    try:
        return _serve_answers(given, trust, base)
    except KeyboardInterrupt as caught:
        say("ended")
        if not is_ctrl_c(caught):
            raise
    return 0


def _serve_answers(given: AnswerOptions, trust: Trust, base: Pose | None) -> int:
    from assistant.controllers.mitsubishi.data_link import DataLink
    from assistant.vision.answering import answer as answers

    status = done = 0
    link = DataLink(given.at)
    link.prepare()
    say(f"listening for questions at {given.at}" + ("" if given.times else "; end it with Ctrl-C"))
    while not given.times or done < given.times:
        sys.stdout.flush()
        for told in answers(link, given.look, trust=trust, base=base, patience=given.patience):
            status = max(status, _print_answer(told))
        done += 1
    return status


def _print_answer(told: Answer) -> int:
    print_findings(told.findings)
    where = ""
    if told.pose is not None:
        where = " at " + ", ".join(f"{value:.2f}" for value in told.pose.position) + " mm"
    say(f"{told.name or 'a line'}: {SIGHT_STATES[told.state]}{where}")
    sys.stdout.flush()
    return 0 if told.state == 1 else 1


def _robot_base(robot: str | None, cell: Path | None) -> Pose | None:
    """Where the robot stands in the world of a cell; None if that is not known."""
    if cell is None:
        return None
    from assistant.cell.clearances import robot_of as robot_in
    from assistant.compiler.arms import open_cell

    stands = open_cell(cell, robot)
    if stands.scene is None:
        return None
    arm = stands.robot
    if arm is None and len(stands.scene.robots) == 1:
        return stands.scene.robots[0].base
    try:
        return None if arm is None else robot_in(stands.scene, arm).base
    except LookupError:
        return None

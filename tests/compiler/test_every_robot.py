"""Each robot of the catalogue runs a path near its home, in each of its languages."""

from __future__ import annotations

import numpy as np
import pytest

import assistant
from assistant import languages, robots
from assistant.program.motion import Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow
from assistant.robots import Robot

COUNT = 12
CLOSE = 0.05
"""degrees; more than a position of two decimals, as MELFA-BASIC has them, turns a joint here."""

CASES = [(name, language) for name in robots.names() for language in robots.get(name).languages]


def joints_near_home(robot: Robot) -> np.ndarray:
    """(n, a) a way from home towards the middle of the limits, so that none of them is near."""
    way = np.linspace(0.2, 0.4, COUNT)[:, None]
    joints = (1.0 - way) * robot.home + way * robot.limits.mean(axis=1)
    joints[:, 0] += np.linspace(-20.0, 20.0, COUNT)
    return joints


def path_of(program: Program) -> Path:
    (path,) = (
        statement.path for statement in program.statements() if isinstance(statement, Follow)
    )
    return path


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("name", "language"), CASES)
def test_a_path_is_written_with_the_branch_that_it_was_made_of(name: str, language: str) -> None:
    robot = robots.get(name)
    joints = joints_near_home(robot)
    positions, quaternions = robot.fk(joints)
    seam = Path.of("seam", positions, quaternions, speeds=[Speed(100.0)])
    source = Program("prog", (Procedure("main", (Follow(seam),)),))
    compiled = assistant.compile(source, language=language, robot=name)
    assert compiled.ok, compiled.findings

    written = languages.get(language)
    trees = [written.parse(written.decode(data)) for data in compiled.files.values()]
    path = path_of(written.lift(trees))
    back = robot.joints_of(path.positions, path.quaternions, path.configurations)
    assert not np.isnan(back).any()
    # The same branch all along: axes 4 and 6 may have been chosen turned against each other.
    assert back[:, :3] == pytest.approx(joints[:, :3], abs=CLOSE)

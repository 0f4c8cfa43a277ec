"""What languages write of positions: numbers that are none are refused, and told by name."""

from __future__ import annotations

import math

import pytest

from assistant.base.diagnostics import Severity
from assistant.languages import get, names
from assistant.program import statements as p
from assistant.program.geometry import Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import Path, Speed
from assistant.program.program import Procedure, Program
from tests.tables import every_row

WILD = (
    Pose((math.nan, 0.0, 0.0)),
    Pose((0.0, math.inf, 0.0)),
    Pose((0.0, 0.0, 0.0), (math.nan, 0.0, 0.0, 0.0)),
    Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)),
)
"""No place, and no orientation."""


def refused(program: Program, language: str) -> list[str]:
    found = get(language).adapt(program).findings
    return [f.message for f in found if f.severity is Severity.ERROR]


@every_row("language", names())
@every_row("pose", WILD)
def test_a_pose_of_no_numbers_is_refused_by_name(pose: Pose, language: str) -> None:
    for program in (
        Program("job", entry=None, targets={"corner": Target(pose)}),
        Program("job", entry=None, tools={"corner": Tool(pose)}),
        Program("job", entry=None, frames={"corner": Frame(pose)}),
    ):
        assert any("`corner`" in message for message in refused(program, language))


@every_row("language", names())
@every_row("pose", WILD)
def test_a_path_with_such_a_pose_is_refused_at_its_row(pose: Pose, language: str) -> None:
    known = Pose((300.0, 0.0, 200.0), (0.0, 1.0, 0.0, 0.0))
    rows = (known, known, pose, known)
    positions, quaternions = [x.position for x in rows], [x.quaternion for x in rows]
    path = Path.of("seam", positions, quaternions, speeds=[Speed(100.0)])
    program = Program("job", (Procedure("main", (p.Follow(path),)),))
    assert any("`seam_3`" in message for message in refused(program, language))


@pytest.mark.parametrize("language", names())
def test_joints_of_no_numbers_are_refused_by_name(language: str) -> None:
    joints = {"rest": JointTarget((0.0, math.inf, 0.0, 0.0, 0.0, 0.0))}
    program = Program("job", entry=None, joint_targets=joints)
    assert any("`rest`" in message for message in refused(program, language))


@every_row(("count", "errors"), [(6, 0), (7, 1)])
@every_row("language", names())
def test_an_arm_has_six_joints(language: str, count: int, errors: int) -> None:
    joints = {"rest": JointTarget((1.0,) * count)}
    program = Program("job", entry=None, joint_targets=joints)
    assert len(refused(program, language)) == errors

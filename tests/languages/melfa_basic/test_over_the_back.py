"""A five-axis arm that reaches over its back says A and B that no source tells for sure."""

from __future__ import annotations

import pytest

from assistant import languages, robots
from assistant.program.expressions import Name
from assistant.program.geometry import Configuration, Pose, Target
from assistant.program.motion import FINE, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow, Motion, Move

DOWN = (0.0, 1.0, 0.0, 0.0)
FORWARD = (0.5**0.5, 0.0, 0.5**0.5, 0.0)
ARM = robots.get("rv-2aj")


def codes(quaternion: tuple[float, ...], back: bool) -> set[str]:
    pose = Pose((250.0, 0.0, 400.0), quaternion)
    target = Target(pose, Configuration(back=back, flip=True))
    row = [int(back), 0, 1, 0, 0, 0]
    path = Path.of(
        "seam",
        [pose.position] * 2,
        [quaternion] * 2,
        configurations=[row, row],
        speeds=[Speed(50.0)],
    )
    body = (Move("joint", Name("p1"), Motion(Speed(50.0, joint=10.0), FINE)), Follow(path))
    program = Program("p", (Procedure("main", body),), targets={"p1": target})
    return {f.code for f in languages.get("melfa-basic-4").adapt(program, ARM).findings}


@pytest.mark.parametrize(
    ("quaternion", "back", "refused"),
    [(DOWN, False, False), (DOWN, True, False), (FORWARD, False, False), (FORWARD, True, True)],
)
def test_only_a_tilted_tool_over_the_back_is_refused(quaternion, back, refused):
    assert ("MB221" in codes(quaternion, back)) is refused

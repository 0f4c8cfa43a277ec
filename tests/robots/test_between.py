"""What is found on the way between targets that can be reached themselves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, event, given, settings
from hypothesis import strategies as st

from assistant import robots
from assistant.base import rotations
from assistant.program.geometry import Frame, Pose, Tool
from assistant.program.motion import Kind, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.pseudo import parse
from assistant.program.statements import Follow

DOWN = (0.0, 0.0, 1.0, 0.0)
ABB = robots.get("irb1200-7-0.7")
ARC = (Kind.VIA, Kind.END)


def journey_of(positions, kinds, **parts) -> robots.SolvedProgram:
    """Of a path, the first row of which is gone to by a joint move."""
    p = np.asarray(positions, dtype=float)
    q = np.broadcast_to(DOWN, (len(p), 4))
    path = Path.of("seam", p, q, kinds=[Kind.JOINT, *kinds], speeds=[Speed(100.0)], **parts)
    tables = {"tools": {"gun": Tool(Pose((0, 0, 60)))}, "frames": {"jig": Frame(Pose((100, 0, 0)))}}
    program = Program("p", (Procedure("main", (Follow(path),)),), **tables)
    return robots.solve_program(program, ABB)


def found(positions, kinds, **parts):
    """Codes and findings of such a path."""
    findings = journey_of(positions, kinds, **parts).findings
    return [finding.code for finding in findings], findings


def circle(centre, radius: float, angles, q=(1.0, 0.0, 0.0, 0.0)) -> np.ndarray:
    turn = np.radians(np.asarray(angles, dtype=float))
    flat = radius * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=-1)
    return rotations.rotate(np.asarray(q), flat) + np.asarray(centre)


def test_an_arc_that_leaves_the_reach_between_targets_within_it() -> None:
    """The arm comes to about 680 mm there; the second of three arcs goes out to 720."""
    far = circle((620, 0, 300), 100, [-100, -60, 100])
    rows = [[450, -100, 300], [500, -150, 300], far[0], *far[1:], [500, 150, 300], [450, 100, 300]]
    codes, findings = found(rows, [*ARC, *ARC, *ARC])
    assert codes == ["RB113"]
    assert findings[0].place == "seam: 1 of 7 targets (seam_5)"
    assert "on the arc to it" in findings[0].message
    assert "out of reach" in findings[0].message
    assert found(rows, [Kind.LINEAR] * 6)[0] == []
    nearer = np.array(rows) - (60.0, 0.0, 0.0)
    assert found(nearer, [*ARC, *ARC, *ARC])[0] == []


def test_an_arc_that_needs_a_joint_outside_its_limits() -> None:
    points = circle((330, 0, 240), 200, [50, 90, 270])
    codes, findings = found(points, ARC)
    assert "RB113" in codes
    assert "J3 at" in findings[codes.index("RB113")].message


def test_tools_and_frames_count_on_the_way() -> None:
    points = circle((520, 0, 360), 100, [-100, -60, 100])
    named = {"tools": ["gun"], "frames": ["jig"]}
    codes, findings = found(points, ARC, **named)
    assert codes == ["RB113"]
    assert "seam_3" in findings[0].where()
    assert found(points, ARC)[0] == []


@pytest.mark.parametrize(
    ("motion", "way"),
    [("circular via b to c", "arc"), ("linear c", "straight line")],
)
def test_the_way_from_a_move_to_joints_counts(motion: str, way: str) -> None:
    start = {"arc": [620, -95, 300], "straight line": [40, 450, 400]}[way]
    via, end = [665, -80, 300], {"arc": [620, 95, 300], "straight line": [40, -450, 400]}[way]
    (joints,), _ = ABB.ik([start], [DOWN])
    stated = ", ".join(f"{angle:.6f}" for angle in joints[0])
    text = f"""program p
target b {via} [0, 0, 1, 0]
target c {end} [0, 0, 1, 0]
joints a [{stated}]

procedure main
  move absolute a speed 100 mm/s joint 10 % blend fine
  move {motion} speed 100 mm/s blend fine
end
"""
    findings = robots.solve_program(parse(text), ABB).findings
    assert "RB113" in [finding.code for finding in findings]
    assert any(f"on the {way} to it" in finding.message for finding in findings)


def test_an_arc_through_the_wrist_singularity_and_back_winds_nothing_up() -> None:
    rows = [[225, -150, 240], [240, -100, 240], [225, 150, 240]]
    solution = journey_of(rows, ARC)
    assert not [finding for finding in solution.findings if finding.severity == "error"]
    assert np.abs(np.diff(solution.solved_runs[0].joints[:, 5])).max() < 90.0


@settings(derandomize=True)
@given(st.integers(0, 2**31))
def test_arcs_are_sound_where_a_fine_look_finds_them_so(seed) -> None:
    rng = np.random.default_rng(seed)
    centre = rng.uniform((350, -150, 150), (700, 150, 450))
    radius, sweep, part = rng.uniform((20, 60, 0.1), (250, 350, 0.9))
    q = rotations.canonical(rng.normal(size=4))
    rows = circle(centre, radius, [0.0, part * sweep, sweep], q)
    fine = circle(centre, radius, np.linspace(0.0, sweep, 721), q)
    turned = np.tile(DOWN, (len(fine), 1))
    _, valid = ABB.ik(rows, turned[:3])
    assume(valid[:, 0].all())
    joints, excess = ABB.solve(fine, turned)
    low, high = (limit[:, None] for limit in ABB.limits.T)
    beyond = np.maximum(low - joints[:, 0], joints[:, 0] - high).max()
    codes, _ = found(rows, ARC)
    if excess[0].max() == 0.0 and beyond < 0.0 and joints[4, 0].min() > 3.0:
        event("sound")
        assert codes == []
    if excess.max(axis=1).min() > 3.0:
        event("out of reach")
        assert "RB113" in codes

"""Free turns of tools along whole programs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from assistant import robots
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic, Severity, has_errors
from assistant.program.expressions import Apply, Name, Number, Truth
from assistant.program.geometry import Configuration, Pose, Target, Tool
from assistant.program.motion import FINE, Kind, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.pseudo import parse, print_program
from assistant.program.statements import Branch, Follow, If, Motion, Move, Statement
from assistant.robots.free_turns import with_chosen_turns
from assistant.robots.program_solution import solve_program

ARM = robots.get("irb1200-7-0.7")
DOWN = (0.0, 1.0, 0.0, 0.0)
BENT = Tool(Pose((60.0, 0.0, 100.0)), free_turn=True)
"""A nozzle beside the axis of the flange: how it is turned tells where the wrist is."""
SLOW = Motion(Speed(50.0), FINE, "nozzle")


def program(*body: Statement, tool: Tool = BENT, **targets: Target) -> Program:
    main = Procedure("main", body=body)
    return Program("p", tools={"nozzle": tool}, targets=targets, procedures=(main,))


def circle(n: int, radius: float, middle: tuple[float, float, float]) -> Path:
    angle = np.linspace(0.0, 2.0 * math.pi, n)
    x, y, z = middle
    points = np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle), np.full(n, z)], 1)
    kinds = np.full(n, Kind.LINEAR, dtype=np.uint8)
    kinds[0] = Kind.JOINT
    down = np.tile(DOWN, (n, 1))
    speeds, tools = (Speed(50.0),), ("nozzle",)
    return Path.of("ring", points, down, kinds=kinds, speeds=speeds, tools=tools)


def travel(one: Program) -> float:
    """Degrees of all axes together along the first run."""
    return float(np.abs(np.diff(solve_program(one, ARM).solved_runs[0].joints, axis=0)).sum())


def codes(findings: tuple[Diagnostic, ...]) -> list[str]:
    return [finding.code for finding in findings]


def only_path(one: Program) -> Path:
    (follow,) = one.procedures[0].body
    assert isinstance(follow, Follow)
    return follow.path


def spins(path: Path) -> Floats:
    """(n,) degrees that the tool is turned about the vertical, without a break."""
    w, x, y, z = path.quaternions.T
    # Of a tool that points down, its x axis is (x² - y², 2xy).
    assert np.abs(w).max() < 1e-9 and np.abs(z).max() < 1e-9
    return np.degrees(np.unwrap(np.arctan2(2.0 * x * y, x * x - y * y)))


def test_what_is_out_of_limits_as_drawn_is_reached_by_turning() -> None:
    drawn = program(Follow(circle(200, 150.0, (350.0, 0.0, 200.0))))
    assert has_errors(solve_program(drawn, ARM).findings)
    out, findings = with_chosen_turns(drawn, ARM)
    assert codes(findings) == ["RB119"]
    assert "200 targets" in findings[0].message
    solved = solve_program(out, ARM)
    assert not [f for f in solved.findings if f.severity is not Severity.INFO]
    (run,) = solved.solved_runs
    assert len(np.unique(run.configurations[:, :3], axis=0)) == 1
    assert ARM.inside(run.joints).all()
    # The tip is where it was, and points as it did.
    before, after = only_path(drawn), only_path(out)
    assert np.array_equal(before.positions, after.positions)
    rate = np.abs(np.diff(spins(after))) / (2.0 * math.pi * 150.0 / 199.0 / 50.0)
    assert rate.max() <= 45.0 + 1e-6
    assert rate.max() > 1.0


def test_no_constant_turn_takes_the_axes_less_far() -> None:
    path = circle(60, 60.0, (400.0, 100.0, 250.0))
    out, _ = with_chosen_turns(program(Follow(path)), ARM)
    chosen = travel(out)
    for turn in range(0, 360, 20):
        half = math.radians(turn) / 2.0
        quaternions = np.tile((0.0, math.cos(half), math.sin(half), 0.0), (60, 1))
        constant = Path.of(
            "ring",
            path.positions,
            quaternions,
            kinds=path.kinds,
            speeds=path.speeds,
            tools=path.tools,
        )
        one = program(Follow(constant))
        if not has_errors(solve_program(one, ARM).findings):
            assert chosen <= 1.1 * travel(one)


def test_a_mirrored_work_piece_is_gone_along_as_far() -> None:
    far = [travel(with_chosen_turns(program(Follow(ring)), ARM)[0]) for ring in mirrored()]
    assert far[0] == pytest.approx(far[1], rel=1e-3)


def mirrored() -> tuple[Path, Path]:
    ring = circle(40, 80.0, (380.0, 90.0, 200.0))
    flipped = ring.positions * (1.0, -1.0, 1.0)
    other = Path.of(
        "ring", flipped, ring.quaternions, kinds=ring.kinds, speeds=ring.speeds, tools=ring.tools
    )
    return ring, other


def test_closed_contour_comes_back_to_its_own_target() -> None:
    ring = circle(200, 150.0, (350.0, 0.0, 200.0))
    inner = Path.of(
        "inner",
        ring.positions[1:-1],
        ring.quaternions[1:-1],
        speeds=ring.speeds,
        tools=ring.tools,
    )
    above = Apply("relative", (Name("start"), Number(0), Number(0), Number(-50)))
    drawn = program(
        Move("joint", above, SLOW),
        Move("linear", Name("start"), SLOW),
        Follow(inner),
        Move("linear", Name("start"), SLOW),
        Move("linear", above, SLOW),
        start=Target(Pose((500.0, 0.0, 200.0), DOWN)),
    )
    assert has_errors(solve_program(drawn, ARM).findings)
    out, findings = with_chosen_turns(drawn, ARM)
    assert codes(findings) == ["RB119"]
    assert not has_errors(solve_program(out, ARM).findings)
    assert out.targets["start"].pose.position == (500.0, 0.0, 200.0)


def test_a_smaller_turn_than_needed_is_none() -> None:
    """A tool on the axis of the flange, where the turn is that of axis 6 alone: it stays."""
    straight = Tool(Pose((0.0, 0.0, 100.0)), free_turn=True)
    ring = circle(40, 50.0, (400.0, 0.0, 250.0))
    out, _ = with_chosen_turns(program(Follow(ring), tool=straight), ARM)
    (run,) = solve_program(out, ARM).solved_runs
    assert np.abs(np.diff(run.joints[:, 5])).sum() < 25.0


@pytest.mark.parametrize(
    ("first", "second"),
    [
        pytest.param(Name("a"), Target(Pose((400.0, 0.0, 250.0), DOWN), Configuration()), id="its"),
        pytest.param(
            Apply("relative", (Name("a"), Number(20), Number(0), Number(0))),
            Target(Pose((400.0, 0.0, 250.0), DOWN)),
            id="beside",
        ),
    ],
)
def test_what_means_more_than_a_place_is_not_turned(first: Name, second: Target) -> None:
    drawn = program(Move("joint", first, SLOW), Move("joint", Name("a"), SLOW), a=second)
    out, findings = with_chosen_turns(drawn, ARM)
    assert out.targets == drawn.targets
    assert not findings


def test_a_target_of_another_tool_is_not_turned() -> None:
    other = Motion(Speed(50.0), FINE)
    drawn = program(
        Move("joint", Name("a"), SLOW),
        Move("joint", Name("a"), other),
        a=Target(Pose((400.0, 0.0, 350.0), DOWN)),
    )
    out, _ = with_chosen_turns(drawn, ARM)
    assert out.targets == drawn.targets


def test_no_turn_helps() -> None:
    drawn = program(Follow(circle(30, 50.0, (2000.0, 0.0, 200.0))))
    out, findings = with_chosen_turns(drawn, ARM)
    assert codes(findings) == ["RB120"]
    assert only_path(out) == only_path(drawn)
    assert not out.tools["nozzle"].free_turn


def test_the_same_program_gets_the_same_turns() -> None:
    drawn = program(Follow(circle(50, 150.0, (350.0, 0.0, 200.0))))
    assert with_chosen_turns(drawn, ARM) == with_chosen_turns(drawn, ARM)


def test_its_text() -> None:
    drawn = program(Follow(circle(3, 50.0, (400.0, 0.0, 200.0))))
    text = print_program(drawn).text
    assert "tool nozzle tip [60, 0, 100] free turn\n" in text
    assert parse(text) == drawn


@pytest.mark.slow
def test_ten_thousand_targets() -> None:
    drawn = program(Follow(circle(10_000, 150.0, (350.0, 0.0, 200.0))))
    out, findings = with_chosen_turns(drawn, ARM)
    assert "10000 targets" in findings[0].message
    solved = solve_program(out, ARM)
    assert not [f for f in solved.findings if f.severity is not Severity.INFO]
    (run,) = solved.solved_runs
    assert len(np.unique(run.configurations[:, :3], axis=0)) == 1


def test_the_second_branch_of_a_program_begins_where_the_first_does() -> None:
    """What stands in one branch says nothing of where the other one begins."""
    near = Target(Pose((400.0, 0.0, 250.0), DOWN))
    one, other = (Target(Pose((x, y, 250.0), DOWN)) for x, y in ((420.0, 150.0), (420.0, -20.0)))
    chosen = If(
        (Branch(Truth(value=True), (Move("linear", Name("one"), SLOW),)),),
        (Move("linear", Name("other"), SLOW),),
    )
    drawn = program(Move("joint", Name("near"), SLOW), chosen, near=near, one=one, other=other)
    out, findings = with_chosen_turns(drawn, ARM)
    assert codes(findings) == ["RB119"]
    joints = [leg.joints[-1] for leg in solve_program(out, ARM).legs["main"]]
    assert np.abs(joints[2] - joints[0]).max() < 20.0

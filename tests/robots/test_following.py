"""Long lines and arcs beside following every branch densely."""

from __future__ import annotations

import numpy as np
import pytest

from assistant import languages, robots
from assistant.base import rotations
from assistant.base.diagnostics import Severity
from assistant.program.motion import Kind
from tests.robots.following import followed, turning_point
from tests.robots.printed import solve_program

ARMS = [robots.get(name) for name in robots.names() if robots.get(name).arm.spherical]
STRAIGHT = 0.1
"""degrees of axis 5 up to which nothing is claimed."""
BEYOND = 0.01
"""degrees or mm by which a missed limit counts."""


def errors(done) -> list[str]:
    return [f.message for f in done.findings if f.severity is Severity.ERROR]


def test_an_axis_that_turns_beyond_its_limit_between_targets_is_told_of() -> None:
    melfa = languages.get("melfa-basic-5")
    text = (
        "1 Tool P_NTool\n2 Spd 100\n3 Mov P1\n4 Mvs P2\n5 End\n"
        "P1=(225.71,315.49,1729.79,55.34,25.31,-156.04){}\n"
        "P2=(-208.45,-488.30,1228.20,-8.96,17.02,177.96){}\n"
    )
    arm = robots.get("rv-13frl")
    stated = melfa.lift(melfa.parse(text.format("(7,0)", "(7,4096)")))
    (finding,) = robots.configure(stated, arm)[1]
    assert finding.code == "RB113"
    assert "J4 at 207.34 degrees, limit 200" in finding.message


def test_a_branch_that_turns_far_but_goes_all_the_way_is_taken() -> None:
    arm = robots.get("irb120-3-0.58")
    p = np.array([[-13.89, -337.47, 48.93], [-379.92, -347.89, 205.39]])
    q = np.array(
        [[0.196839, 0.487352, -0.658452, -0.538687], [0.428712, 0.542288, -0.669360, 0.272191]]
    )
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    done = solve_program(arm, p, q, None, kinds=Kind.LINEAR)
    assert not errors(done)
    joints = done.solved_runs[0].joints
    assert joints[1, 3] - joints[0, 3] == pytest.approx(-189.6, abs=0.1)


def test_an_arc_that_passes_axis_1_closely_is_followed_there() -> None:
    """In a thousandth of it axis 1 turns by 160 degrees, and axis 6 goes on to turn beyond 400."""
    arm = robots.get("irb1600-10-1.45")
    p = np.array(
        [
            [259.61790907, -1008.35321023, 819.6328839],
            [203.63914635, -339.9942321, 1319.08644802],
            [-61.50724941, 39.45898123, 1717.55598991],
        ]
    )
    q = np.array(
        [
            [0.54764792, 0.03392678, -0.34490861, -0.76155681],
            [0.0, 0.0, 0.0, 0.0],
            [0.60954024, -0.18620156, -0.10591003, 0.76326452],
        ]
    )
    q[1] = rotations.between(q[0], q[2], np.array(turning_point(p[0], p[1], p[2])))
    kinds = np.array([Kind.JOINT, Kind.VIA, Kind.END], dtype=np.uint8)
    assert errors(solve_program(arm, p, q, None, kinds=kinds))


@pytest.mark.parametrize(
    ("name", "p", "q"),
    [
        (
            "rv-1a",
            [
                [-211.52179456631063, 164.4618480410258, -26.58427671319882],
                [18.441983912030146, 289.23236763516365, 442.4231814164238],
            ],
            [
                [0.026215998221476022, 0.8975581604579478, -0.43249595665518387, 0.081543347426468],
                [0.19695230100864086, -0.453657404596395, 0.8177182814789454, 0.29451920568510404],
            ],
        ),
        (
            "rv-6sl",
            [
                [-42.99289108032562, -370.1700004249018, -256.6603646142311],
                [-461.45887047315045, -269.6668856313871, -352.798480150352],
            ],
            [
                [
                    0.15195838034363374,
                    -0.8573739240434142,
                    -0.399740037048543,
                    -0.28640270214187447,
                ],
                [0.09987909145561306, 0.4506388353377603, 0.7685487269352999, -0.4430368624635632],
            ],
        ),
    ],
)
def test_a_line_past_the_singularity_of_the_wrist_is_no_way_through_it(name, p, q) -> None:
    """Axis 5 keeps 1.3 and 0.17 degrees from straight: axis 4 has to turn by a half there."""
    kinds = np.array([Kind.JOINT, Kind.LINEAR], dtype=np.uint8)
    assert errors(solve_program(robots.get(name), np.array(p), np.array(q), None, kinds=kinds))


def test_ends_that_bend_the_wrist_to_opposite_sides_are_no_way_through_its_singularity() -> None:
    """On this line axis 5 keeps 23 degrees from straight and more in every branch."""
    arm = robots.get("irb1200-7-0.7")
    p = np.array(
        [[43.41305976, -95.28176762, 855.44905347], [-275.18829848, 284.33098732, 62.66484943]]
    )
    q = np.array(
        [
            [0.17104763, -0.20473461, 0.94366609, -0.1957569],
            [0.38078807, -0.68160697, 0.35504288, 0.51415653],
        ]
    )
    done = solve_program(arm, p, q, None, kinds=np.array([Kind.JOINT, Kind.LINEAR], dtype=np.uint8))
    assert [f.code for f in done.findings] == ["RB113"]


def compared(arm, count: int, seed: int) -> dict[str, int]:
    """How many long lines and arcs are told of and are quiet; none wrongly."""
    rng = np.random.default_rng(seed)
    low, high = arm.limits.T
    seen = {"told": 0, "quiet": 0}
    while sum(seen.values()) < count:
        p, q = arm.fk(rng.uniform(low, high, (2, len(low))))
        if np.linalg.norm(p[1] - p[0]) < 100.0:
            continue
        via, rows = None, (p, q, np.array([Kind.JOINT, Kind.LINEAR], dtype=np.uint8))
        if rng.random() < 0.3:
            via = p.mean(axis=0) + rng.normal(size=3) * 100.0
            part = turning_point(p[0], via, p[1])
            turned = rotations.between(q[0], q[1], np.array(part))
            kinds = np.array([Kind.JOINT, Kind.VIA, Kind.END], dtype=np.uint8)
            rows = (np.array([p[0], via, p[1]]), np.array([q[0], turned, q[1]]), kinds)
        done = solve_program(arm, rows[0], rows[1], None, kinds=rows[2])
        beyond, bend = followed(arm, (p[0], q[0]), (p[1], q[1]), via).T
        if errors(done):
            assert not ((beyond <= 0.0) & (bend > STRAIGHT)).any(), (p, q, via, errors(done))
            seen["told"] += 1
        else:
            assert (beyond[bend > STRAIGHT] <= BEYOND).any() or (bend <= STRAIGHT).any(), (
                p,
                q,
                via,
            )
            seen["quiet"] += 1
    return seen


@pytest.mark.parametrize("name", ["irb120-3-0.58", "rv-13frl"])
def test_lines_and_arcs_are_told_of_where_no_branch_goes_all_the_way(name) -> None:
    seen = compared(robots.get(name), 20, 1)
    assert min(seen.values()) > 3


@pytest.mark.slow
@pytest.mark.parametrize("at", range(len(ARMS)), ids=[arm.name for arm in ARMS])
def test_many_lines_and_arcs_beside_dense_following(at: int) -> None:
    """About ten thousand over all arms, other ones for each."""
    seen = compared(ARMS[at], 400, 2 + at)
    assert min(seen.values()) > 40

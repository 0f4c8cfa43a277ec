"""Headers of tables: every column says its unit and convention, and nothing is guessed."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant.sources.tables import headers
from assistant.sources.tables.headers import KNOWN, columns_of
from tests.tables import every_row

POSE = ["x_mm", "y_mm", "z_mm", "q_w", "q_x", "q_y", "q_z"]
TEMPTING = [
    "x", "Y", "z", "rx", "ry_deg", "rot_z_rad", "euler_x", "roll", "pitch_deg", "yaw_rad",
    "A", "b_deg", "c", "q0", "q1", "q4", "j1", "joint_6", "axis3", "a2", "e1", "eax_2",
    "euler_zyx_z", "euler_zyz_z1", "fixed_xyz_y", "rotvec_x", "speed", "v", "feed", "blend",
    "zone", "radius", "wait", "dwell",
]  # fmt: skip


@every_row("name", TEMPTING)
def test_an_ambiguous_name_is_refused_and_the_full_names_are_proposed(name: str) -> None:
    _, problems = columns_of([*POSE, name])
    (problem,) = problems
    assert problem.rule is headers.AMBIGUOUS_COLUMN
    assert problem.index == len(POSE)
    proposed = re.findall(r"`([^`]+)`", problem.fields["proposals"])
    assert proposed
    assert set(proposed) <= set(KNOWN), "what is proposed is accepted"


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("speed_mms", "speed_mm_s"),
        ("blend_mmm", "blend_mm"),
        ("euler_zxy_x_deg", "euler_zyx_x_deg"),
        ("tol", "tool"),
        ("moton", "motion"),
    ],
)
def test_the_nearest_name_is_the_cure_for_an_unknown_one(given: str, meant: str) -> None:
    _, problems = columns_of([*POSE, given])
    assert [p.rule for p in problems] == [headers.UNKNOWN_COLUMN]
    assert f"`{meant}`" in problems[0].fields["cure"]


def test_of_many_unknown_names_ten_have_a_finding_each_and_the_rest_one() -> None:
    _, problems = columns_of([*POSE, *(f"c{i}_mm" for i in range(5_000))])
    assert [p.rule for p in problems] == [headers.UNKNOWN_COLUMN] * 10 + [headers.MORE_UNKNOWN]
    assert problems[-1].index == len(POSE) + 10
    assert problems[-1].fields == {"count": 4_990, "name": "`c10_mm`"}


def test_every_group_of_columns_is_documented() -> None:
    documented = set(re.findall(r"`([a-z_0-9]+)`", headers.__doc__ or ""))
    for group in {column.group for column in KNOWN.values()}:
        names = {name for name, column in KNOWN.items() if column.group == group}
        assert names & documented, group


@given(st.lists(st.text(max_size=12) | st.sampled_from(sorted(KNOWN)), min_size=1, max_size=9))
def test_any_header_is_understood_or_has_a_problem_with_a_place(names: list[str]) -> None:
    columns, problems = columns_of(names)
    for problem in problems:
        assert 0 <= problem.index < len(names)
        message = problem.rule(**problem.fields).message
        assert message.isprintable()
    if not problems:
        assert len(columns) == len(names)
        assert all(column.group != "unknown" for column in columns)

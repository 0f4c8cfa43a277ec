"""What is reported or refused before an arm is led: speeds, and places of recordings."""

from __future__ import annotations

from pathlib import Path

from tests.cli.test_commands import run
from tests.cli.test_exploring_arms import WANDER, cell, pace

__all__ = ["cell", "pace"]


def test_a_speed_that_the_controller_cannot_keep_is_reported(capsys, cell) -> None:
    """And a program that has its own: the module of an exchange states how fast the arm goes."""
    status, _, said = run(capsys, *WANDER, "--speed", "5")
    assert status == 2 and "CN652" in said, said
    assert "5 mm/s at most" not in said
    for by, code in (("jog", "CN652"), ("exchange", "CN653")):
        status, _, said = run(capsys, *WANDER, "--speed", "100", "--by", by)
        assert status == 2 and (code in said) == (by == "exchange"), said


def test_a_recording_that_cannot_be_written_is_refused_before_the_arm_moves(capsys, cell) -> None:
    Path("way.csv").write_text("x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n420,60,400,0,0,1,0\n")
    there = "nowhere/log.csv"
    before = cell.state.joints
    for words in (
        (*WANDER, "--log", there),
        ("follow", "cell1", "way.csv", "--by", "data-link", "--log", there),
        ("servo", "cell1", "t.toml", "--cameras", "c.toml", "--by", "jog", "--log", there),
        ("exchange", "follow", "ftp://a@127.0.0.1:1", "way.csv", "--record", there),
    ):
        status, _, said = run(capsys, *words, "--yes")
        assert (status, "CN602" in said) == (2, True), said
    assert cell.state.joints == before

"""The motion of a program or a table that a controller is led along."""

from __future__ import annotations

import numpy as np
import pytest

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.compiler.commanded_motion import trajectory_of_source
from assistant.controllers.states import Position
from assistant.program import pseudo
from assistant.sources import read
from tests.cli.test_follow import FIVE

ARM = robots.get("rv-2aj")
HOME = Position((0.0, 0.0, 90.0, None, 90.0, 0.0), (160.0, 0.0, 478.0), (0.0, 0.0, 1.0, 0.0))


def test_the_motion_begins_wtmp_path_the_arm_is_and_ends_at_the_last_target(tmp_path):
    (tmp_path / "way.csv").write_text(FIVE, encoding="utf-8")
    bent = Position((20.0, 0.0, 90.0, None, 90.0, 0.0), HOME.position, HOME.quaternion)
    found = trajectory_of_source(tmp_path / "way.csv", ARM, bent, 0.05, 100.0)
    assert np.allclose(found.joints[0], (20.0, 0.0, 90.0, 90.0, 0.0))
    assert np.allclose(found.positions[-1], (175.0, 0.0, 470.0))
    assert np.diff(found.seconds).max() <= 0.05 + 1e-9
    slow = trajectory_of_source(tmp_path / "way.csv", ARM, bent, 0.05, 50.0)
    assert slow.seconds[-1] == pytest.approx(2.0 * found.seconds[-1])
    first = trajectory_of_source(tmp_path / "way.csv", ARM, None, 0.05, 100.0)
    assert np.allclose(first.positions[0], (160.0, 0.0, 478.0))
    six = found.numbered(found.joints, np.nan)
    assert six.shape == (len(found.seconds), 6) and np.isnan(six[:, 3]).all()


def test_a_wait_is_a_part_of_the_motion(tmp_path):
    seconds = [
        trajectory_of_source(str(_program(tmp_path, line)), ARM, HOME, 0.05, 100.0).seconds[-1]
        for line in ("# nothing", "wait 1 s")
    ]
    assert seconds[1] - seconds[0] == pytest.approx(1.0, abs=0.01)


def test_a_program_that_does_more_than_move_is_not_followed(tmp_path):
    for line in ("stop", "if 1 = 1\n    stop\n  end"):
        with pytest.raises(Refused) as refused:
            trajectory_of_source(str(_program(tmp_path, line)), ARM, HOME, 0.05, 100.0)
        assert [finding.code for finding in refused.value.findings] == ["CO721"]


def _program(tmp_path, line):
    """A pseudo-program with one more statement behind its moves."""
    (tmp_path / "way.csv").write_text(FIVE, encoding="utf-8")
    text = pseudo.print_program(read(tmp_path / "way.csv").program).text
    file = tmp_path / "way.pseudo"
    file.write_text(text.replace("\nend", f"\n  {line}\nend", 1), encoding="utf-8")
    return file

"""Points and boxes that no arm reaches, and cameras for one place."""

from __future__ import annotations

import numpy as np
import pytest

from assistant.learning.observed_arm import pair_for
from tests.cli.test_commands import run


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (("--point", "1e300,0,0"), "CL524"),
        (("--point", "0,0,-100001"), "CL524"),
        (("--box", "0:1e200,0:1,0:1"), "CL523"),
    ],
)
def test_what_is_farther_than_any_robot_is_refused(capsys, tmp_path, words, code) -> None:
    more = ("--steps", "10", "-o", tmp_path / "map.npz")
    status, _, said = run(capsys, "learn", "rv-2aj", "--tool", "free", *words, *more)
    assert (status, code in said) == (2, True), said
    assert not (tmp_path / "map.npz").exists()


def test_a_pair_of_cameras_is_put_up_for_a_single_place() -> None:
    place = np.array([[300.0, 0.0, 400.0]])
    for camera in pair_for(place):
        assert camera.within(camera.project(place), 0.0).all()

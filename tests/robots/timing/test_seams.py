"""Long ways at a programmed speed, against the bound that `benchmarks.seams` works out itself."""

import numpy as np
import pytest

from benchmarks import seams


@pytest.mark.parametrize("shape", seams.SHAPES)
def test_a_seam_takes_its_way_by_its_speed(shape):
    for speed, most in ((10.0, 1.005), (50.0, 1.005), (500.0, 1.7)):
        assert 1.0 - 1e-4 <= seams.ratios("irb1200-7-0.7", shape, speed) <= most


def test_the_way_of_the_bound_is_that_of_the_shape():
    turn = np.pi / 180.0
    assert seams.way(seams.SHAPES["line of 240 mm"]) == pytest.approx(240.0)
    polygon = 360 * 100.0 * np.sin(turn / 2.0)
    assert seams.way(seams.SHAPES["circle of 360 points"]) == pytest.approx(polygon, rel=1e-4)
    # A right angle: a parabola with legs of z is z · (1 + asinh(1) / √2) long, legs twice z.
    cut = seams.ZONE * (2.0 - 1.0 - np.arcsinh(1.0) / np.sqrt(2.0))
    assert seams.way(seams.SHAPES["rectangle, z5"]) == pytest.approx(510.0 - 3 * cut, rel=1e-5)


def test_it_prints_its_table(capsys, monkeypatch):
    monkeypatch.setattr(seams, "ROBOTS", ("rv-4frl",))
    monkeypatch.setattr(seams, "SPEEDS", (50.0,))
    seams.main()
    assert len(capsys.readouterr().out.splitlines()) == 1 + len(seams.SHAPES)

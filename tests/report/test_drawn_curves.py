"""Pictures and sizes of curves follow a tolerance, however many waves a curve has."""

import json
import math

import ezdxf
import numpy as np
import pytest

from assistant.cli import main
from assistant.report.contour_plot import drawn_lines
from assistant.report.track import arc_points
from assistant.studio.drawn_contours import DrawnContours
from tests.sources.contours.exports import apart


@pytest.fixture
def waves(tmp_path):
    """A spline through 32 waves, 7 mm high, and where it truly runs."""
    x = np.linspace(0.0, 256.0, 32 * 32 + 1)
    points = np.stack([x, 7.0 * np.sin(math.tau * x / 8.0)], axis=1)
    document = ezdxf.new(units=4)
    document.modelspace().add_spline(points, dxfattribs={"layer": "CUT"})
    document.saveas(tmp_path / "a.dxf")
    return tmp_path / "a.dxf", points


def test_the_size_is_that_of_the_curve(waves, capsys):
    path, _ = waves
    with pytest.raises(SystemExit):
        main(["info", str(path), "--format", "json"])
    said = json.loads(capsys.readouterr().out)
    text = json.dumps(said)
    assert "extents" in text
    (layer,) = (one for one in _found(said, "layers") if one["name"] == "CUT")
    low, high = (np.array(layer["extents"][k]) for k in ("from", "to"))
    assert high - low == pytest.approx([256.0, 14.0, 0.0], abs=0.01)


def _found(value, key):
    """The value of a key, wherever it is."""
    if isinstance(value, dict):
        if key in value:
            return value[key]
        value = list(value.values())
    if isinstance(value, list):
        return next((f for v in value if (f := _found(v, key)) is not None), None)
    return None


def test_reports_and_plots_draw_it_within_the_tolerance(waves):
    path, points = waves
    (line,) = drawn_lines(path)
    assert apart(points, line.points[:, :2]).max() <= 0.06
    assert len(line.points) < 4000


def test_the_studio_draws_it_as_far_as_is_seen(waves):
    from assistant.sources.process import NO_PROCESS

    path, points = waves
    (line,) = DrawnContours.of(path, NO_PROCESS).records(numbered=False)["lines"]
    assert apart(points, np.array(line["points"])).max() <= 0.1


@pytest.mark.parametrize("radius", [0.5, 30.0, 2000.0])
def test_arcs_of_a_program_are_drawn_within_the_tolerance(radius):
    angles = np.radians([0.0, 100.0, 200.0])
    three = radius * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    points = np.vstack([three[:1], arc_points(*three)])
    middles = 0.5 * (points[1:] + points[:-1])
    assert radius - np.linalg.norm(middles, axis=1).min() <= 0.051

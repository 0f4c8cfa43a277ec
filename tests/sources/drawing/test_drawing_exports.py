"""Drawings as CAD systems export them: overlaps, gaps, crossings, split splines, bad numbers."""

import math
import re

import ezdxf
import numpy as np
import pytest

import assistant
from assistant.base.diagnostics import Refused
from tests.sources.contours.exports import ways
from tests.tables import every_row

HEAD = "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1015\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n"


def compiled(tmp_path, draw, keys="", layer="CUT"):
    """The ways of a program along what is drawn, and the findings by their codes."""
    document = ezdxf.new(units=4)
    draw(document.modelspace(), {"layer": layer})
    path = tmp_path / "a.dxf"
    document.saveas(path)
    path.with_suffix(".process.toml").write_text(f"[layers.{layer}]\n{keys}\n")
    made = assistant.compile(path, language="rapid")
    text = "".join(text.decode() for text in made.files.values())
    return ways(text), {f.code: f for f in made.findings}


def length(way):
    return float(np.hypot(*np.diff(way.points, axis=0).T).sum())


def lines(*ends):
    def draw(space, on):
        for a, b in ends:
            space.add_line(a, b, dxfattribs=on)

    return draw


BOX = [((100, 0), (100, 80)), ((100, 80), (0, 80)), ((0, 80), (0, 0))]


@pytest.mark.parametrize(
    "base",
    [
        [((0, 0), (60, 0)), ((40, 0), (100, 0))],
        [((0, 0), (60, 0)), ((100, 0), (40, 0))],
        [((0, 0), (100, 0)), ((30, 0), (70, 0))],
        [((30, 0.003), (70, -0.002)), ((100, 0), (0, 0))],
        [((0, 0), (50, 0)), ((20, 0), (80, 0)), ((60, 0), (100, 0))],
    ],
)
def test_lines_on_lines_are_followed_once(base, tmp_path):
    (way,), found = compiled(tmp_path, lines(*BOX, *base))
    assert length(way) == pytest.approx(360.0, abs=0.02)
    assert found["CT106"].severity == "warning"


def test_arcs_on_arcs_are_followed_once(tmp_path):
    def draw(space, on):
        space.add_arc((50, 50), 30, 0, 200, dxfattribs=on)
        space.add_arc((50, 50), 30, 150, 360, dxfattribs=on)

    (way,), found = compiled(tmp_path, draw)
    assert length(way) == pytest.approx(math.tau * 30.0, abs=0.05)
    assert "CT106" in found


def test_neighbours_are_no_overlap(tmp_path):
    spike = [((0, 0), (100, 0)), ((100, 0), (0, 1)), ((0, 1), (0, 0))]
    _, found = compiled(tmp_path, lines(*spike))
    assert "CT106" not in found
    _, found = compiled(tmp_path, lines(*BOX, ((0, 0), (60.03, 0)), ((60, 0), (100, 0))))
    assert "CT106" not in found  # it runs over by less than the tolerance


@pytest.mark.parametrize(("gap", "code"), [(0.04, "CT105"), (0.06, "CT107"), (0.4, "CT107")])
def test_gaps_are_closed_or_told(gap, code, tmp_path):
    (way,), found = compiled(tmp_path, lines(*BOX, ((0, 0), (100 - gap, 0))))
    assert {"CT105", "CT107"} & set(found) == {code}
    closed = np.hypot(*(way.points[0] - way.points[-1])) < 1e-3
    assert closed == (code == "CT105")


def test_far_ends_are_meant(tmp_path):
    _, found = compiled(tmp_path, lines(*BOX, ((0, 0), (90, 0))))
    assert "CT107" not in found


def test_a_figure_of_eight_is_told_without_an_offset_too(tmp_path):
    points = [(0, 0), (40, 40), (40, 0), (0, 40)]

    def draw(space, on):
        space.add_lwpolyline(points, close=True, dxfattribs=on)

    _, found = compiled(tmp_path, draw)
    assert found["CT109"].severity == "warning"
    assert "CT109" not in compiled(tmp_path, lines(*BOX, ((0, 0), (100, 0))))[1]


@pytest.mark.parametrize("sweep", [359.95, 359.999, 359.91])
@pytest.mark.parametrize(("side", "radius"), [("outside", 31.0), ("inside", 29.0)])
def test_an_arc_that_almost_comes_back_is_a_circle(sweep, side, radius, tmp_path):
    def draw(space, on):
        space.add_arc((50, 50), 30, 20, 20 + sweep, dxfattribs=on)

    (way,), found = compiled(tmp_path, draw, f'offset = 1\nside = "{side}"')
    assert "CT213" not in found
    far = np.hypot(*(way.points - [50, 50]).T)
    assert far == pytest.approx(radius, abs=0.01)
    assert length(way) == pytest.approx(math.tau * radius, abs=0.1)


@pytest.mark.parametrize(("jump", "count"), [(20.0, 2), (0.0, 1)])
def test_a_spline_that_jumps_is_two_contours(jump, count, tmp_path):
    def draw(space, on):
        points = [(0, 0), (10, 10), (20, -10), (30, 0)]
        points += [(30 + jump, 0), (40 + jump, 10), (50 + jump, -10), (60 + jump, 0)]
        knots = [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2]
        spline = space.add_spline(dxfattribs={**on, "degree": 3})
        spline.control_points, spline.knots = points, knots

    found, _ = compiled(tmp_path, draw)
    assert len(found) == count
    for way in found:
        assert np.hypot(*np.diff(way.points, axis=0).T).max() < 5.0


@every_row(
    ("given", "cure"),
    [("50,5", "50.5"), ("1,234.5", "1234.5"), ("1.5D+02", "1.5E+02"), ("4O.5", ""), ("12.3.4", "")],
)
@every_row("code", [10, 31, 62, 39, 1040])
def test_a_malformed_number_is_an_error(given, cure, code, tmp_path):
    numbers = {8: "CUT", 10: 0, 20: 0, 30: 0, 11: 50, 21: 0, 31: 0.0, code: given}
    body = "".join(f"{c}\n{v}\n" for c, v in numbers.items())
    path = tmp_path / "a.dxf"
    path.write_text(f"{HEAD}0\nSECTION\n2\nENTITIES\n0\nLINE\n{body}0\nENDSEC\n0\nEOF\n")
    with pytest.raises(Refused) as refused:
        assistant.load(path)
    (finding,) = refused.value.findings
    assert (finding.code, finding.severity) == ("DX010", "error")
    assert path.read_text().splitlines()[finding.line - 1] == given
    assert cure in finding.cure


@pytest.mark.parametrize("given", ["5", " -5.", "+.5", "5e0", "5E+00", "0005.000 "])
def test_numbers_in_every_form_are_read(given, tmp_path):
    body = f"8\nCUT\n10\n{given}\n20\n0\n30\n0\n11\n50\n21\n0\n31\n0\n"
    path = tmp_path / "a.dxf"
    path.write_text(f"{HEAD}0\nSECTION\n2\nENTITIES\n0\nLINE\n{body}0\nENDSEC\n0\nEOF\n")
    assert assistant.load(path)


@pytest.mark.parametrize(
    ("escaped", "name"),
    [
        (r"Au\U+00DFen", "Außen"),
        (r"\U+5207\U+65AD", "切断"),
        (r"a\U+D83D\U+DE00", "a😀"),
        (r"a\U+000Ab", r"a\U+000Ab"),
        (r'say "x" \U+00E9', 'say "x" é'),
    ],
)
def test_escaped_characters_of_layers_are_decoded(escaped, name, tmp_path):
    body = f"8\n{escaped}\n10\n0\n20\n0\n30\n0\n11\n50\n21\n0\n31\n0\n"
    path = tmp_path / "a.dxf"
    path.write_text(f"{HEAD}0\nSECTION\n2\nENTITIES\n0\nLINE\n{body}0\nENDSEC\n0\nEOF\n")
    process = path.with_suffix(".process.toml")
    process.write_text("[layers.OTHER]\n")
    found = {f.code: f for f in assistant.check(path).findings}
    (table,) = re.findall(r"add (\[.*\]) to the process file", found["CT201"].cure)
    process.write_text(table + "\nspeed = 30\n", encoding="utf-8")  # the cure is valid TOML
    assert "CT201" not in {f.code for f in assistant.check(path).findings}
    assert name == escaped or escaped not in table

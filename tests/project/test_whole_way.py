"""From a customer's drawing in an empty folder to a program on a controller, as a user goes."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

from assistant.cli import main
from tests.project.conftest import Home
from tests.project.customer import Points, cuts, write_drawing

KERF = 3.0
LEAD = 4.0
OFF = 0.06
"""mm: the tolerance of 0.05 that the process file states, and a digit of the text."""

JET: Mapping[str, Mapping[str, str]] = {
    "tools.tool": {
        "tip": "[0, 0, 150]",
        "mass": "3.5",
        "centre": "[0, 0, 70]",
        "free_turn": "true",
    },
    "frames.work": {"position": "[1200, -100, 500]"},
    "signals.work_on": {"direction": '"output"', "number": "8"},
    "layers.Default": {
        "on": "{work_on = 1}",
        "off": "{work_on = 0}",
        "offset": f"{KERF / 2}",
        "way_round": '"climb"',
        "lead_in": f"{{arc = {LEAD}}}",
        "lead_out": f"{{arc = {LEAD}}}",
        "travel_kind": '"joint"',
    },
}
"""What the user writes into the process file, table by table."""


def test_a_customers_drawing_is_cut_as_it_should(
    home: Home, capsys: pytest.CaptureFixture[str]
) -> None:
    drawn = write_drawing(home.folder / "plate4711.dxf")
    said(capsys, "init", "plate4711.dxf")
    process = home.folder / "plate4711.process.toml"
    text = process.read_text("utf-8")
    assert 'leave_out = ["BORDER", "CENTER"]' in text
    for table, keys in JET.items():
        text = stated(text, table, keys)
    process.write_text(text, "utf-8")
    project = home.folder / "assistant.toml"
    cell = stated(project.read_text("utf-8"), "controllers.cell1", {"robot": '"irb4600-20-2.50"'})
    project.write_text(cell, "utf-8")
    for command in (["check"], ["build"], ["deploy"], ["verify"]):
        said(capsys, *command)
    (there,) = (home.folder / ".robot-assistant" / "virtual").rglob("plate4711.mod")
    holds_to(there.read_text("latin-1"), drawn)


def said(capsys: pytest.CaptureFixture[str], *words: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(list(words))
    out, err = capsys.readouterr()
    assert (ended.value.code or 0) == 0, out + err


def stated(text: str, table: str, keys: Mapping[str, str]) -> str:
    """The text with keys of a table as somebody writes them: marks taken away, values filled in."""
    head = rf"(?m)^(?:# )?\[{re.escape(table)}\]" if table else r"\A"
    start = re.search(head, text)
    assert start, table
    end = re.compile(r"(?m)^(?:# )?\[\w|\Z").search(text, start.end())
    assert end
    section = text[start.start() : end.start()]
    if table:
        section = section.removeprefix("# ")
    for key, value in keys.items():
        section, count = re.subn(rf"(?m)^(?:# )?{key} = .*$", f"{key} = {value}", section)
        assert count == 1, f"{key} of [{table}]"
    return text[: start.start()] + section + text[end.start() :]


def holds_to(text: str, drawn: dict[str, list[Points]]) -> None:
    """No gouge, each contour cut once and whole, holes before their outline, leads in the scrap."""
    contours = [*((ring, True) for ring in drawn["holes"]), (drawn["outline"][0], False)]
    done = []
    for cut in cuts(text, "work_on"):
        way = cut.way[:, :2]
        apart = [distances(way, ring) for ring, _ in contours]
        on = [np.abs(each - KERF / 2) < OFF for each in apart]
        which = int(np.argmax([each.sum() for each in on]))
        done.append(which)
        ring, hole = contours[which]
        assert apart[which].min() > KERF / 2 - OFF, "gouges"
        assert (inside(way, ring) == hole).all(), "on the wrong side"
        assert apart[which].max() < KERF / 2 + 2 * LEAD, "strays"
        # It comes from where it is not on the contour yet, and leaves where it was whole.
        assert not on[which][0]
        assert not on[which][-1]
        # Rounded corners of the scrap side are as far from a corner as its bisector says.
        assert distances(ring, way[on[which]]).max() < KERF / 2 * 2**0.5 + OFF, "not whole"
        others = [each.min() for i, each in enumerate(apart) if i != which]
        assert min(others) > KERF / 2 - OFF, "gouges another contour"
    assert sorted(done) == list(range(len(contours)))
    assert done[-1] == len(contours) - 1


def distances(points: Points, ring: Points) -> Points:
    """Of each point from the nearest of a dense line."""
    squares = (points**2).sum(axis=1)[:, None] - 2.0 * points @ ring.T + (ring**2).sum(axis=1)
    nearest = np.sqrt(np.maximum(squares.min(axis=1), 0.0))
    return np.array(nearest)


def inside(points: Points, ring: Points) -> NDArray[np.bool_]:
    """Whether each point is inside a closed line: crossings of a ray."""
    a, b = ring, np.roll(ring, -1, axis=0)
    found = []
    for x, y in points:
        over = (a[:, 1] > y) != (b[:, 1] > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            at = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
        found.append(bool((over & (x < at)).sum() % 2))
    return np.array(found)

"""The order of contours: as drawn, and by the numbers that a drawing has beside them."""

import ezdxf
import pytest

from assistant.base.diagnostics import Refused
from assistant.compiler import load
from assistant.program.expressions import Name
from assistant.program.statements import Call, Move


def square(space, x, y, size, layer="CUT"):
    corners = [(x, y), (x + size, y), (x + size, y + size), (x, y + size)]
    space.add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})


def number(space, text, x, y, **attributes):
    space.add_text(text, height=3, dxfattribs={"layer": "CUT", "insert": (x, y), **attributes})


def starts(folder, draw, keys, units=4):
    """Where each contour begins, in the order of the program, and the codes of the findings."""
    document = ezdxf.new()
    document.units = units
    draw(document.modelspace())
    document.saveas(folder / "part.dxf")
    process = folder / "part.process.toml"
    process.write_text(f"[layers.CUT]\n{keys}\n", encoding="utf-8")
    loaded = load(folder / "part.dxf", process=process)
    program = loaded.program
    begun = [
        s.target.name
        for s in program.statements()
        if isinstance(s, Move) and isinstance(s.target, Name) and s.target.name.endswith("_start")
    ]
    places = [program.targets[name].pose.position[:2] for name in dict.fromkeys(begun)]
    return places, [f.code for f in loaded.findings]


def three(space):
    """A part about a hole, and another one far away; drawn from the outside in."""
    square(space, 0, 0, 100)
    square(space, 20, 30, 10)
    square(space, 300, 0, 50)


def test_as_drawn(tmp_path):
    places, codes = starts(tmp_path, three, 'order = "drawing"\ninside_first = false')
    assert places == [(0, 0), (20, 30), (300, 0)]
    assert "CT224" not in codes
    places, codes = starts(tmp_path, three, 'order = "drawing"')
    assert places == [(0, 0), (20, 30), (300, 0)]
    assert "CT224" in codes  # the part falls before its hole is cut


def layer_order(folder, draw, tables):
    """The procedures that `main` calls, and the messages of CT334."""
    document = ezdxf.new()
    document.units = 4
    draw(document.modelspace())
    document.saveas(folder / "part.dxf")
    process = folder / "part.process.toml"
    process.write_text(tables, encoding="utf-8")
    loaded = load(folder / "part.dxf", process=process)
    (main,) = (one for one in loaded.program.procedures if one.name == "main")
    called = [one.procedure for one in main.body if isinstance(one, Call)]
    return called, [f.message for f in loaded.findings if f.code == "CT334"]


LAYERS = ("OUTER", "SLOTS", "HOLES", "SEAL")


def part_on_layers(space):
    """An outline, slots in it and holes in those, a layer for each kind; and a layer beside."""
    square(space, 0, 0, 100, "OUTER")
    square(space, 20, 20, 30, "SLOTS")
    square(space, 30, 30, 5, "HOLES")
    square(space, 300, 0, 10, "SEAL")


def test_layers_inside_those_of_others_come_first(tmp_path):
    tables = "".join(f"[layers.{name}]\n" for name in LAYERS)
    called, told = layer_order(tmp_path, part_on_layers, tables)
    assert (called, told) == (["HOLES", "SLOTS", "OUTER", "SEAL"], [])
    # What a layer in between does not mind, the layer around both still does.
    tables = tables.replace("SLOTS]\n", "SLOTS]\ninside_first = false\n")
    called, told = layer_order(tmp_path, part_on_layers, tables)
    assert (called, told) == (["SLOTS", "HOLES", "OUTER", "SEAL"], [])


def test_layers_that_lie_inside_each_other_are_told(tmp_path):
    def draw(space):
        part_on_layers(space)
        square(space, 60, 60, 30, "OUTER")
        square(space, 70, 70, 4, "SLOTS")
        square(space, 21, 21, 2, "OUTER")

    tables = "[layers.OUTER]\n[layers.SLOTS]\n"
    called, told = layer_order(tmp_path, draw, f'leave_out = ["*"]\n{tables}')
    assert called == ["OUTER", "SLOTS"]
    (message,) = told
    assert message.startswith("layer 'OUTER' is worked before 2 contours of layer 'SLOTS'")
    free = tables.replace("OUTER]\n", "OUTER]\ninside_first = false\n")
    assert not layer_order(tmp_path, draw, f'leave_out = ["*"]\n{free}')[1]


def test_by_the_numbers_beside(tmp_path):
    def draw(space):
        three(space)
        number(space, "3", 2, 50)
        space.add_mtext("(2)", dxfattribs={"layer": "cut", "insert": (33, 35)})
        number(space, "1.", 0, 0, halign=1, align_point=(302, 20))
        number(space, "Ø10 H7", 25, 35)  # no number of a contour

    places, codes = starts(tmp_path, draw, 'order = "text"')
    assert places == [(300, 0), (20, 30), (0, 0)]
    assert not {"CT224", "CT225"} & set(codes)
    _, plain = starts(tmp_path, draw, "speed = 20")
    assert set(plain) - set(codes) == {"CT206"}


def test_numbers_of_a_drawing_in_inches_that_are_in_a_block(tmp_path):
    def draw(space):
        block = space.doc.blocks.new("PART")
        three(block)
        number(block, "2", 2, 50)
        number(block, "1", 33, 35)
        number(block, "3", 302, 20)
        space.add_blockref("PART", (1, 1), dxfattribs={"layer": "0"})

    places, _ = starts(tmp_path, draw, 'order = "text"', units=1)
    expected = [(21 * 25.4, 31 * 25.4), (25.4, 25.4), (301 * 25.4, 25.4)]
    assert [x for place in places for x in place] == pytest.approx(
        [x for place in expected for x in place]
    )


def test_contours_without_a_number_come_last(tmp_path):
    def draw(space):
        three(space)
        number(space, "1", 302, 20)

    places, codes = starts(tmp_path, draw, 'order = "text"\ninside_first = false')
    assert places == [(300, 0), (0, 0), (20, 30)]
    assert "CT225" in codes


@pytest.mark.parametrize(
    ("texts", "code"),
    [
        ([("1", 2, 50), ("2", 2, 60)], "CT226"),
        ([("1", 2, 50), ("1", 33, 35)], "CT227"),
        ([("1", 200, 10)], "CT228"),
    ],
)
def test_numbers_that_do_not_tell_an_order_are_refused(tmp_path, texts, code):
    def draw(space):
        three(space)
        for text, x, y in texts:
            number(space, text, x, y)

    with pytest.raises(Refused) as caught:
        starts(tmp_path, draw, 'order = "text"')
    (finding,) = [f for f in caught.value.findings if f.code == code]
    assert finding.place.startswith("entity ")

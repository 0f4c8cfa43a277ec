"""What contours are called and said to be, and the procedures that a style makes of them."""

import math
import re

import ezdxf
import pytest

import assistant
from assistant.base.diagnostics import Refused
from assistant.compiler.loader import load
from assistant.program.statements import Call, Comment

PROCESS = """\
[motion]
frame = "table"
[frames.table]
position = [450, -75, 300]
[layers.PLATE]
"""


def square(model, low, high, layer="PLATE"):
    (x, y), (u, v) = low, high
    model.add_lwpolyline([(x, y), (u, y), (u, v), (x, v)], close=True, dxfattribs={"layer": layer})


def drawn(folder, draw, process=PROCESS, units=4):
    document = ezdxf.new("R2010", units=units)
    draw(document.modelspace())
    document.saveas(folder / "part.dxf")
    text = (folder / "part.dxf").read_text()
    saved = re.sub(r"(\$TDUPDATE\n +40\n)[0-9.]+", r"\g<1>2461007.75", text)
    (folder / "part.dxf").write_text(saved)
    (folder / "part.process.toml").write_text(process)
    return folder / "part.dxf"


def sheet(model):
    on = {"layer": "PLATE"}
    square(model, (0, 0), (200, 150))
    model.add_circle((125, 110), 3.3, dxfattribs=on)
    slot = [(80, 60, 0), (110, 60, 1), (110, 70, 0), (80, 70, 1)]
    model.add_lwpolyline(slot, format="xyb", close=True, dxfattribs=on)
    square(model, (30, 60), (50, 75))
    model.add_line((150, 70), (180, 110), dxfattribs=on)


def bodies(program):
    return {one.name: one.body for one in program.procedures}


def comments(program):
    found = {name: [s.text for s in body if isinstance(s, Comment)] for name, body in
             bodies(program).items()}  # fmt: skip
    return {name: texts for name, texts in found.items() if texts}


def test_each_contour_is_a_procedure_that_says_what_it_is(tmp_path):
    program = load(drawn(tmp_path, sheet)).program
    assert comments(program) == {
        "PLATE": ["layer PLATE"],
        "hole_1": ["hole dia. 6.6 at 125, 110"],
        "slot_1": ["slot 40 x 10 at 95, 65"],
        "opening_1": ["opening 20 x 15 at 40, 67.5"],
        "outline_1": ["outline 200 x 150"],
        "plate_1": ["PLATE, 50 mm, from 180, 110 to 150, 70"],
    }
    assert [s.procedure for s in bodies(program)["main"]] == ["PLATE"]
    called = [s.procedure for s in bodies(program)["PLATE"] if isinstance(s, Call)]
    assert set(called) == {*bodies(program)} - {"main", "PLATE"}
    assert called[-1] == "outline_1"
    assert program.comments == (
        "drawing part.dxf, in millimetres, saved 2025-11-27",
        "tool tool0, frame table",
        "contours within 0.05 mm; their sizes and positions as drawn, in mm",
    )


def test_sizes_are_those_of_the_drawing_wherever_it_is_placed(tmp_path):
    def draw(model):
        square(model, (0, 0), (4, 2))
        model.add_circle((1, 1), 0.25, dxfattribs={"layer": "PLATE"})

    placed = PROCESS + "[placement]\nposition = [10, 20, 30]\neuler_zyx = [90, 0, 0]\n"
    program = load(drawn(tmp_path, draw, placed, units=1)).program
    assert comments(program)["hole_1"] == ["hole dia. 12.7 at 25.4, 25.4"]
    assert comments(program)["outline_1"] == ["outline 101.6 x 50.8"]


def test_a_part_in_the_hole_of_another_one_has_an_outline(tmp_path):
    def draw(model):
        for half in (50, 30, 20):
            square(model, (-half, -half), (half, half))
        model.add_circle((0, 0), 10, dxfattribs={"layer": "PLATE"})

    program = load(drawn(tmp_path, draw)).program
    said = comments(program)
    assert said["opening_1"] == ["opening 60 x 60 at 0, 0"]
    assert [said[f"outline_{n}"] for n in (1, 2)] == [["outline 40 x 40"], ["outline 100 x 100"]]
    assert said["hole_1"] == ["hole dia. 20 at 0, 0"]


@pytest.mark.parametrize(("sides", "kind"), [(8, "outline"), (64, "circle")])
def test_a_circle_of_chords_is_a_circle_and_an_octagon_none(tmp_path, sides, kind):
    def draw(model):
        corners = [
            (50 + 20 * math.cos(2 * math.pi * k / sides), 20 * math.sin(2 * math.pi * k / sides))
            for k in range(sides)
        ]
        model.add_lwpolyline(corners, close=True, dxfattribs={"layer": "PLATE"})

    (_, texts), *_ = comments(load(drawn(tmp_path, draw)).program).items()
    assert texts[1].startswith(kind)


FIRST = ((0, 0), (50, 0))
RED, HIDDEN = {"color": 1}, {"linetype": "HIDDEN"}


@pytest.mark.parametrize(
    ("others", "lengths"),
    [
        ([((50, 0), (50, 50), {})], ["100"]),
        ([((50, 50), (50, 0), {})], ["100"]),
        ([((0, 50), (0, 0), {})], ["100"]),
        ([((50, 0), (100, 0), {})], ["100"]),
        ([((100, 0), (50.04, 0), {})], ["99.96"]),
        ([((50, 0), (20, 6), {})], ["80.59"]),
        ([((50, 0), (50, 50), RED)], ["100"]),
        ([((50, 50), (50, 0), HIDDEN)], ["100"]),
        ([((50, 50), (0, 50), RED), ((50, 50), (50, 0), {})], ["150"]),
        ([((50.06, 0), (50.06, 50), {})], ["50", "50"]),
        ([((50, 0, 1), (50, 50, 1), {})], ["50", "50"]),
        ([((50, 0), (100, 0), {}), ((50, 0), (50, 50), {})], ["50", "50", "50"]),
        ([((50, 0), (100, 0), {}), ((50, 0), (50, 50), {"layer": "BRANCH"})], ["100"]),
        ([((25, 0), (25, 50), {})], ["50", "50"]),
    ],
)
def test_lines_of_a_layer_are_one_contour_where_two_ends_meet(tmp_path, others, lengths):
    def draw(model):
        model.doc.linetypes.add("HIDDEN", [9.5, 6.3, -3.2])
        for start, end, said in [(*FIRST, {}), *others]:
            model.add_line(start, end, dxfattribs={"layer": "PLATE", **said})

    program = load(drawn(tmp_path, draw)).program
    texts = [text for texts in comments(program).values() for text in texts]
    assert re.findall(r"PLATE, (\S+) mm, from", " ".join(texts)) == lengths


def test_names_of_several_layers_and_of_what_is_there_already(tmp_path):
    def draw(model):
        square(model, (0, 0), (100, 100))
        model.add_circle((50, 50), 5, dxfattribs={"layer": "DRILL"})
        model.add_circle((20, 50), 5, dxfattribs={"layer": "DRILL"})
        model.add_line((0, 0), (5, 5), dxfattribs={"layer": "0"})

    taken = PROCESS + "[layers.DRILL]\n[layers.0]\n[signals.drill_hole_1]\n"
    program = load(drawn(tmp_path, draw, taken)).program
    names = [*bodies(program)]
    assert names == ["main", "DRILL", "drillhole2_1", "drillhole2_2", "layer_0", "PLATE"]
    assert {"plate_outline_1_start", "path_1_start"} <= program.targets.keys()


def test_names_say_once_what_layer_and_contour_are_called_both(tmp_path):
    def draw(model):
        for x, layer in enumerate(("HOLES", "Hole M8")):
            model.add_circle((30 * x + 20, 50), 5, dxfattribs={"layer": layer})
            model.add_circle((30 * x + 20, 20), 5, dxfattribs={"layer": layer})
        square(model, (0, 0), (100, 100), layer="OUTLINE")

    layers = '[layers.HOLES]\n[layers."Hole M8"]\n[layers.OUTLINE]\n'
    program = load(drawn(tmp_path, draw, PROCESS.replace("[layers.PLATE]\n", layers))).program
    assert {"hole_1_start", "hole_m8_1_start", "outline_1_start"} <= program.targets.keys()
    assert {"hole_1", "hole_2", "hole_m8_1", "hole_m8_2"} <= {*bodies(program)}


@pytest.mark.parametrize(
    ("layer", "said", "name"),
    [
        ("0", "layer 0", "path_1"),
        ("3.5", "layer 3.5", "path_1"),
        ("Ø6.6", "layer Ø6.6", "d6_6_1"),
        ("⌀6.6", "layer ⌀6.6", "d6_6_1"),
        ("%%c12", "layer %%c12", "d12_1"),
        ("Kleber 2", "Kleber 2", "kleber_2_1"),
    ],
)
def test_a_layer_that_is_named_by_a_number_is_called_a_layer(tmp_path, layer, said, name):
    def draw(model):
        model.add_line((0, 0), (0, 20), dxfattribs={"layer": layer})

    table = f'[layers."{layer}"]\n'
    program = load(drawn(tmp_path, draw, PROCESS.replace("[layers.PLATE]\n", table))).program
    ((_, text),) = comments(program).values()
    assert text == f"{said}, 20 mm, from 0, 0 to 0, 20"
    assert f"{name}_start" in program.targets


def test_names_keep_the_number_that_tells_layers_apart(tmp_path):
    layers = [
        "Bohrungen Ø12",
        "Bohrungen Ø6.6",
        "Durchgangsbohrungen M8 Ø9",
        "Kleberaupe Nr. 120034",
    ]

    def draw(model):
        for x, layer in enumerate(layers):
            on = {"layer": layer}
            model.add_circle((30 * x, 0), 5, dxfattribs=on)
            model.add_line((30 * x, 10), (30 * x, 20), dxfattribs=on)

    tables = "".join(f'[layers."{layer}"]\n' for layer in layers)
    program = load(drawn(tmp_path, draw, PROCESS.replace("[layers.PLATE]\n", tables))).program
    assert [name for name in bodies(program) if name[-2:] == "_1"] == [
        "bohrunge_d12_circle_1", "bohrungen_d12_1",
        "bohrung_d6_6_circle_1", "bohrungen_d6_6_1",
        "durchgang_d9_circle_1", "durchgangsbohrung_d9_1",
        "klebe_120034_circle_1", "kleberaupe_nr_120034_1",
    ]  # fmt: skip


STYLES = {
    "contour": ["main", "PLATE", "hole_1", "slot_1", "opening_1", "outline_1", "plate_1"],
    "layer": ["main", "PLATE"],
    "none": ["main"],
}


@pytest.mark.parametrize("language", ["rapid", "melfa-basic-5"])
@pytest.mark.parametrize("procedures", [*STYLES])
def test_every_form_is_proven_and_moves_alike(tmp_path, procedures, language):
    style = f'[style]\nprocedures = "{procedures}"\n'
    path = drawn(tmp_path, sheet, PROCESS + style)
    robot = {"rapid": "irb1200-7-0.7", "melfa-basic-5": "rv-7frl"}[language]
    made = assistant.compile(path, language=language, robot=robot)
    assert made.ok, made.findings
    names = {one.name.lower() for one in made.program.procedures}
    assert names == {name.lower() for name in STYLES[procedures]}


LINES = """\
[layers.0]
[layers.RAISED]
approach = 5
retract = 80
[layers.DEEP]
depth = 4
passes = 2
[layers.DRAWN]
order = "drawing"
[layers.BESIDE]
side = "left"
offset = 3
way_round = "conventional"
[layers.LED]
side = "right"
lead_in = {tangent = 2}
lead_out = {arc = 2, angle = 90}
way_round = "climb"
"""
MOVED = re.compile(r"(?:MoveL|MoveC|Mvs|Mvr) (.*)")
PLACED = re.compile(r"(\w+):?=\[?[\[(]([-+\d.]+),([-+\d.]+),")
RUN = re.compile(r"[!'] (.*), 40 mm, from (\S+), (\S+) to (\S+), (\S+)")


def run_lines(text):
    """For each comment on an open contour: its layer, its two points, and the points of the moves
    that are not above the work.
    """
    targets = {name: (float(x), float(y)) for name, x, y in PLACED.findall(text)}
    found = []
    for line in text.splitlines():
        if said := RUN.search(line):
            layer, *points = said.groups()
            ends = [*map(float, points)]
            found.append((layer, tuple(ends[:2]), tuple(ends[2:]), []))
        elif (moved := MOVED.search(line)) and ",-" not in line:
            found[-1][3].append(
                [targets[w] for w in re.findall(r"\w+", moved[1]) if w in targets][-1]
            )
    return found


@pytest.mark.parametrize("language", ["rapid", "melfa-basic-5"])
@pytest.mark.parametrize("procedures", [*STYLES])
def test_ends_of_an_open_contour_are_in_the_order_in_which_it_is_run(
    tmp_path, procedures, language
):
    layers = [line[8:-1] for line in LINES.splitlines() if line.startswith("[layers.")]

    def draw(model):
        for row, layer in enumerate(layers):
            for x in range(20 * row, 20 * row + 20, 10):
                model.add_line((x, 0), (x, 40), dxfattribs={"layer": layer})

    process = PROCESS.replace("[layers.PLATE]\n", LINES) + f'[style]\nprocedures = "{procedures}"\n'
    robot = {"rapid": "irb1200-7-0.7", "melfa-basic-5": "rv-7frl"}[language]
    made = assistant.compile(drawn(tmp_path, draw, process), language=language, robot=robot)
    assert made.ok, made.findings
    (text,) = (raw.decode() for raw in made.files.values())
    ways = {}
    for layer, start, end, points in run_lines(text):
        ways.setdefault(layer, []).append(end[1] - start[1])
        if layer in ("BESIDE", "LED"):
            assert math.dist(points[0], start) < 7 and math.dist(points[-1], end) < 7
        else:
            assert points == [start, end] * (2 if layer == "DEEP" else 1)
    # Each second one against the way it is drawn, unless that is fixed.
    assert ways == {
        "layer 0": [40, -40],
        "RAISED": [40, -40],
        "DEEP": [40, -40],
        "DRAWN": [40, 40],
        "BESIDE": [-40, -40],
        "LED": [-40, -40],
    }


def test_position_numbers_have_the_name_of_their_contour_beside_them(tmp_path):
    path = drawn(tmp_path, sheet)
    for language in ("melfa-basic-5", "melfa-basic-6"):
        made = assistant.compile(path, language=language, robot="rv-7frl")
        assert made.ok, made.findings
        assert "MB217" not in {f.code for f in made.findings}  # each arc names its start
        (text,) = (raw.decode() for raw in made.files.values())
        assert "' slot 40 x 10 at 95, 65" in text
        assert re.search(r"Mvs P\w*slot_?1_?start\r?\n\d+ ' P\d+ to P\d+: slot_1\r?\n", text, re.I)


def test_the_arm_keeps_its_branch_from_contour_to_contour(tmp_path):
    targets = {}
    for procedures in STYLES:
        style = f'[style]\nprocedures = "{procedures}"\n'
        path = drawn(tmp_path, sheet, PROCESS + style)
        made = assistant.compile(path, language="rapid", robot="irb1200-7-0.7")
        targets[procedures] = made.program.targets
    assert targets["contour"] == targets["layer"] == targets["none"]


def test_the_project_states_a_style_and_a_process_file_another(tmp_path):
    (tmp_path / "assistant.toml").write_text('[style]\nprocedures = "layer"\ncomments = false\n')
    program = load(drawn(tmp_path, sheet)).program
    assert [*bodies(program)] == ["main", "PLATE"] and not comments(program)
    own = PROCESS + '[style]\nprocedures = "none"\n'
    program = load(drawn(tmp_path, sheet, own)).program
    assert [*bodies(program)] == ["main"] and not comments(program)


def test_without_any_procedure_there_is_nothing_to_call(tmp_path):
    style = '[style]\nprocedures = "none"\n[program]\nmain = false\n'
    with pytest.raises(Refused) as caught:
        load(drawn(tmp_path, sheet, PROCESS + style))
    assert [f.code for f in caught.value.findings if f.severity == "error"] == ["DX014"]


def test_passes_of_a_contour_are_in_its_procedure(tmp_path):
    keys = "depth = 4\npasses = 2\n"
    program = load(drawn(tmp_path, sheet, PROCESS + keys)).program
    assert comments(program)["hole_1"] == [
        "hole dia. 6.6 at 125, 110", "pass 1 of 2, 2 mm deep", "pass 2 of 2, 4 mm deep",
    ]  # fmt: skip
    assert {"hole_1_pass_1_start", "hole_1_pass_2_start"} <= program.targets.keys()


def circle(model, x, y, radius, layer):
    model.add_circle((x, y), radius, dxfattribs={"layer": layer})


def texts_on(path, layer):
    """The words for the contours of a layer, without their sizes."""
    program = load(path).program
    calls = [s.procedure for s in bodies(program)[layer] if isinstance(s, Call)]
    given = calls or [layer]
    found = [comments(program)[name][-1] for name in given]
    return sorted(re.split(r" (?:dia|[0-9])", text)[0] for text in found)


def test_a_bead_around_a_hole_is_no_edge(tmp_path):
    def draw(model):
        square(model, (0, 0), (180, 120), "RIM")
        circle(model, 60, 60, 20, "RIM")
        square(model, (26, 26), (154, 94), "SEAL")
        circle(model, 120, 60, 9, "SEAL")
        square(model, (40, 40), (44, 44), "R2")

    for rim in ("[layers.RIM]\n", '[layers.RIM]\nprocess = "deburring"\nlead_in = {arc = 2}\n'):
        process = PROCESS.replace("[layers.PLATE]\n", f"{rim}[layers.SEAL]\n[layers.R2]\n")
        path = drawn(tmp_path, draw, process)
        assert texts_on(path, "RIM") == ["hole", "outline"]
        assert texts_on(path, "SEAL") == ["circle", "closed contour"]
        # Nothing says what R2 is: it may be an opening, an engraving or a bead.
        assert texts_on(path, "R2") == ["closed contour"]
        assert "seal_closed_1" in bodies(load(path).program)


@pytest.mark.parametrize(
    ("layer", "keys", "kinds"),
    [
        ("DRILL", "", ["hole", "opening"]),
        ("Bohrungen M8", "", ["hole", "opening"]),
        ("L7", 'process = "milling"', ["hole", "opening"]),
        ("L7", 'lead_in = {arc = 1}\nside = "inside"', ["hole", "opening"]),
        ("GLUE", "offset = 1", ["hole", "opening"]),
        ("L7", "", ["circle", "closed contour"]),
        ("Kleberaupe", "", ["circle", "closed contour"]),
        ("Gravur", "", ["circle", "closed contour"]),
        ("L7", 'process = "sealant bead"', ["circle", "closed contour"]),
        ("密封", 'process = "涂胶"', ["circle", "closed contour"]),
    ],
)
def test_contours_inside_the_outline_of_another_layer(tmp_path, layer, keys, kinds):
    def draw(model):
        square(model, (0, 0), (100, 100), "PLATE")
        circle(model, 30, 30, 8, layer)
        square(model, (60, 60), (80, 80), layer)

    path = drawn(tmp_path, draw, f'{PROCESS}[layers."{layer}"]\n{keys}\n')
    name = next(one for one in bodies(load(path).program) if one not in ("main", "PLATE"))
    assert texts_on(path, name) == kinds
    assert texts_on(path, "PLATE") == ["outline"]


def test_a_bead_along_the_rim_has_holes_inside(tmp_path):
    def draw(model):
        square(model, (0, 0), (100, 100), "GLUE")
        square(model, (20, 20), (80, 80), "CUT")
        circle(model, 50, 50, 10, "CUT")
        circle(model, 10, 10, 2, "CUT")
        circle(model, 90, 10, 2, "L7")

    process = PROCESS.replace("[layers.PLATE]", "[layers.GLUE]\n[layers.CUT]\n[layers.L7]")
    path = drawn(tmp_path, draw, process)
    # What lies in the opening is a part again, as nesting says.
    assert texts_on(path, "CUT") == ["circle", "hole", "opening"]
    assert texts_on(path, "L7") == ["circle"]


def test_a_part_in_the_opening_of_one_on_other_layers_has_an_outline(tmp_path):
    def draw(model):
        square(model, (0, 0), (100, 100), "PLATE")
        square(model, (20, 20), (80, 80), "CUT INSIDE")
        square(model, (30, 30), (70, 70), "CUT ISLAND")

    tables = '[layers."CUT INSIDE"]\n[layers."CUT ISLAND"]\n'
    path = drawn(tmp_path, draw, PROCESS + tables)
    assert texts_on(path, "CUT_INSIDE") == ["opening"]
    assert texts_on(path, "CUT_ISLAND") == ["outline"]


SEALED = """\
[motion]
frame = "table"
blend = "fine"
[frames.table]
position = [450, -75, 300]
[signals.valve]
direction = "output"
[layers.RIM]
[layers.SEAL]
process = "sealant"
on = {valve = 1}
off = {valve = 0}
on_before = {mm = 2}
off_before = {mm = 4}
approach = 15
travel_height = 50
"""


def sealed(model):
    square(model, (0, 0), (180, 120), "RIM")
    square(model, (20, 20), (80, 80), "SEAL")
    square(model, (100, 20), (160, 80), "SEAL")


def test_outputs_on_the_way_are_named_and_set_up_once(tmp_path):
    made = assistant.compile(
        drawn(tmp_path, sealed, SEALED), language="rapid", robot="irb1200-7-0.7"
    )
    assert made.ok, made.findings
    (text,) = (raw.decode() for raw in made.files.values())
    assert re.findall(r"VAR triggdata (\w+);", text) == ["valve_on", "valve_off"]
    assert re.findall(r"TriggIO (\w+),", text) == ["valve_on", "valve_off"]
    layer = text[text.index("PROC SEAL") :].partition("ENDPROC")[0]
    assert (
        layer.index("! sealant") < layer.index("TriggIO valve_on") < layer.index("seal_closed_1;")
    )
    assert text.count("TriggL ") == 4
    # A single height for the travel to the contours and away from them.
    assert "CONST num seal_height:=50;" in text and "seal_retract" not in text


def test_notes_on_the_order_of_layers_and_on_stops(tmp_path):
    def told(process):
        reading = load(drawn(tmp_path, sealed, process))
        return {f.code: f.message for f in reading.findings if f.code in ("CT335", "CT237")}

    found = told(SEALED)
    assert "layer 'RIM' comes first" in found["CT335"] and "2 contours" in found["CT335"]
    assert "at 6 points" in found["CT237"] and "layer 'SEAL'" in found["CT237"]
    without = SEALED.replace("[layers.RIM]", "[layers.RIM]\ninside_first = false")
    assert told(without.replace('blend = "fine"\n', "")) == {}
    assert told(without + 'blend = "fine"\n') == {}

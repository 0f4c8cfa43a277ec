"""Forms of programs of drawings and tables: offsets, arrays and constants, and their proof."""

import itertools
import json
import re

import ezdxf
import pytest

from assistant import languages
from assistant.compiler import compile
from assistant.compiler.program_forms import form_differences, with_form
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Pose, Target
from assistant.program.motion import FINE, Speed
from assistant.program.program import Procedure, Program
from assistant.sources.process import ProgramStyle
from assistant.virtual.events import Moved
from assistant.virtual.proving.comparison import difference
from tests.compiler.same_motion import ran

PLACES = {
    "rapid": ("irb1200-7-0.7", "[420, 20, 280]"),
    "melfa-basic-4": ("rv-2aj", "[220, 20, 180]"),
    "melfa-basic-6": ("rv-4frl", "[330, 20, 200]"),
}
PROCESS = """\
joint_percent = 20
[placement]
position = {place}
[motion]
speed = 200
tool = "torch"
[tools.torch]
tip = [0, 0, 60]
mass = 0.5
centre = [0, 0, 30]
[signals.laser]
kind = "digital"
direction = "output"
number = 3
[layers.CUT]
speed = 35
blend = 0.5
on = {{laser = 1}}
off = {{laser = 0}}
approach = 25
retract = 25
{layer}
[style]
{style}
"""


def sheet(model):
    on = {"layer": "CUT"}
    for at in ((8, 8), (20, 8)):
        model.add_circle(at, 3.0, dxfattribs=on)
    slot = [(8, 20, 0), (20, 20, -1), (20, 26, 0), (8, 26, -1)]
    model.add_lwpolyline(slot, format="xyb", close=True, dxfattribs=on)
    corners = [(4 * k, 32 + (k % 2)) for k in range(13)]
    model.add_lwpolyline(corners, dxfattribs=on)


def compiled(folder, language, style="", draw=sheet, layer="", place=None):
    """The program of a drawing in a style, and its text."""
    robot, usual = PLACES[language]
    document = ezdxf.new("R2010", units=4)
    draw(document.modelspace())
    document.saveas(folder / "part.dxf")
    process = PROCESS.format(place=place or usual, style=style, layer=layer)
    (folder / "part.process.toml").write_text(process)
    made = compile(folder / "part.dxf", language=language, robot=robot)
    assert made.ok, [str(one) for one in made.findings]
    (data,) = made.files.values()
    return made, data.decode("ascii").replace("\r\n", "\n")


def lifted(text, language):
    return languages.get(language).lift(languages.get(language).parse(text))


PLAIN = 'points = "targets"\nconstants = false'


QUICK = [("rapid", "offsets"), ("melfa-basic-6", "arrays")]


@pytest.mark.parametrize(
    ("language", "points"),
    [
        pytest.param(*one, marks=() if one in QUICK else pytest.mark.slow)
        for one in itertools.product(PLACES, ["offsets", "arrays"])
    ],
)
def test_a_form_does_what_the_plain_program_does(language, points, tmp_path):
    _, plain = compiled(tmp_path, language, PLAIN)
    made, formed = compiled(tmp_path, language, f'points = "{points}"')
    assert "CO621" not in {one.code for one in made.findings}
    word = {"offsets": "_start,", "arrays": "points{"}[points]
    assert language != "rapid" or (word in formed and word.rstrip(",") in formed)
    assert len(formed) != len(plain)
    # An arc begins at a place that is written: the arm may still move where it is asked for.
    assert "P_CURR" not in formed.upper()
    # On the virtual controller as well, which reads the text alone.
    first, second = ran(plain, language), ran(formed, language)
    assert (first.ended, second.ended) == ("end", "end"), (first.message, second.message)
    assert len([x for x in first.events if isinstance(x, Moved)]) > 20
    assert difference(first, second) is None


def test_offsets_of_a_contour_are_of_the_one_target_where_it_starts(tmp_path):
    made, text = compiled(tmp_path, "rapid", 'points = "offsets"')
    names = {name for name in made.program.targets if name.startswith("circle_1")}
    assert names == {"circle_1_start"}  # to teach it again moves the whole contour
    assert "MoveC Offs(circle_1_start," in text
    assert "MoveL RelTool(Offs(cut_1_start," in text  # above the other end of the open contour
    assert not any(x.endswith("_end") for x in made.program.targets)


def test_arrays_have_loops_where_rows_are_alike(tmp_path):
    _, short = compiled(tmp_path, "rapid", 'points = "arrays"', outline)
    assert "points{" not in short  # few rows stay targets
    _, text = compiled(tmp_path, "rapid", 'points = "arrays"', zigzag)
    assert "    CONST robtarget cut_1_points{11}:=[\n        [[" in text
    assert "FOR i FROM 1 TO 11 DO" in text
    _, basic = compiled(tmp_path, "melfa-basic-6", 'points = "arrays"', zigzag)
    assert [line.split()[1] for line in basic.splitlines() if "Mi" in line.split()[-1]] == [
        "Mvs",
        "Next",
    ]
    before = basic[: basic.index("For Mi")].splitlines()[-2]
    assert before.split()[1] == "Cnt"  # settings come once, before the loop


def zigzag(model):
    corners = [(4 * k, 3 * (k % 2)) for k in range(13)]
    model.add_lwpolyline(corners, dxfattribs={"layer": "CUT"})


def test_what_is_used_often_has_a_name(tmp_path):
    _, text = compiled(tmp_path, "rapid")
    assert "CONST speeddata cut_speed:=[35,500,5000,1000];" in text
    assert "CONST zonedata cut_zone:=[FALSE,0.5," in text
    assert "CONST num cut_height:=25;" in text
    assert "RelTool(circle_1_start,0,0,-cut_height),v200,fine,torch" in text  # standard names stay
    _, basic = compiled(tmp_path, "melfa-basic-6")
    assert "Mcut_height=25\n" in basic
    assert ",-Mcut_height" in basic


def test_what_is_used_once_or_twice_stays_a_number(tmp_path):
    _, text = compiled(tmp_path, "rapid", draw=zigzag)
    assert "RelTool(cut_1_start,0,0,-25)" in text
    assert "CONST num" not in text


def test_different_heights_are_named_by_what_they_are_for(tmp_path):
    _, text = compiled(tmp_path, "rapid")
    assert "cut_height" in text
    process = (tmp_path / "part.process.toml").read_text()
    (tmp_path / "part.process.toml").write_text(process.replace("retract = 25", "retract = 40"))
    made = compile(tmp_path / "part.dxf", language="rapid", robot="irb1200-7-0.7")
    (data,) = made.files.values()
    assert b"CONST num cut_approach:=25;" in data
    assert b"CONST num cut_retract:=40;" in data


@pytest.mark.parametrize(
    ("into", "back", "named"),
    [
        # The lower one leads to the work, the other one there and back.
        ((25, 40), (40, 40), {"work_approach": 25, "work_height": 40}),
        # Both would have the same word.
        ((25, 40), (25, 40), {}),
    ],
)
def test_heights_are_named_by_what_they_are_for(into, back, named):
    fast, target = p.Motion(Speed(100.0), FINE), e.Name("a")

    def above(height):
        place = e.Apply("relative", (target, *map(e.Number, (0, 0, -height))))
        return p.Move("linear", place, fast)

    work = p.Move("linear", target, fast)
    contour = [one for a, b in zip(into, back, strict=True) for one in (above(a), work, above(b))]
    given = Program("cut", (Procedure("main", (*contour,) * 4),), targets={"a": Target(Pose())})
    made = with_form(given, ProgramStyle(), languages.get("rapid")).program
    assert {name: one.initial.value for name, one in made.variables.items()} == named


MUTATIONS = [
    ("rapid", "offsets", "Offs(circle_1_start,", "Offs(circle_2_start,"),
    ("rapid", "offsets", "circle_1_start:=[[", "circle_1_start:=[[1"),
    ("rapid", "arrays", "FROM 1 TO 11", "FROM 2 TO 11"),
    ("rapid", "arrays", "cut_1_points{i},cut_speed", "cut_1_points{12-i},cut_speed"),
    ("rapid", "targets", "cut_height:=25", "cut_height:=26"),
    ("rapid", "targets", "cut_speed:=[35", "cut_speed:=[36"),
    ("rapid", "targets", "cut_zone:=[FALSE,0.5", "cut_zone:=[FALSE,0.6"),
    ("melfa-basic-6", "offsets", "Pcircle_1_start+(", "Pcircle_2_start+("),
    ("melfa-basic-6", "arrays", "For Mi=1 To 11", "For Mi=1 To 10"),
    ("melfa-basic-6", "arrays", "Pcut_1_points(3)=(", "Pcut_1_points(3)=(1"),
    ("melfa-basic-6", "targets", "Mcut_height=25", "Mcut_height=24"),
]


GROUPS = [
    pytest.param(*group, marks=() if group in QUICK else pytest.mark.slow)
    for group in dict.fromkeys(one[:2] for one in MUTATIONS)
]


@pytest.mark.parametrize(("language", "points"), GROUPS)
def test_a_form_that_does_something_else_is_found(language, points, tmp_path):
    """Each change of a written text, against the plain program: the proof is no tautology."""
    draw = zigzag if points == "arrays" else sheet
    plain, _ = compiled(tmp_path, language, PLAIN, draw)
    _, text = compiled(tmp_path, language, f'points = "{points}"', draw)

    def differences(written):
        return [
            *form_differences(plain.program, lifted(written, language), languages.get(language))
        ]

    assert not differences(text)
    for old, new in (one[2:] for one in MUTATIONS if one[:2] == (language, points)):
        assert old in text, (old, text)
        found = differences(text.replace(old, new, 1))
        assert {one.code for one in found} == {"CO623"}, (old, new)


@pytest.mark.parametrize(
    ("layer", "place", "why"),
    [
        ("tangential = true", None, "the tool turns"),
        ("", "[420, -20, 280]", "changes its configuration"),
    ],
)
def test_offsets_that_would_not_be_the_same_are_refused(layer, place, why, tmp_path):
    _, plain = compiled(tmp_path, "rapid", PLAIN, outline, layer, place)
    made, text = compiled(tmp_path, "rapid", 'points = "offsets"', outline, layer, place)
    (finding,) = [one for one in made.findings if one.code == "CO621"]
    assert why in finding.message
    assert "Offs(" not in text
    assert difference(ran(plain, "rapid"), ran(text, "rapid")) is None


def outline(model):
    corners = [(0, 0), (40, 0), (40, 40), (0, 40)]
    model.add_lwpolyline(corners, close=True, dxfattribs={"layer": "CUT"})


def test_paths_of_a_table_are_procedures_that_say_what_they_are(tmp_path):
    rows = [[420, 20 + 4 * k, 300, 0, 1, 0, 0] for k in range(9)]
    back = [[440, 52 - 4 * k, 300, 0, 1, 0, 0] for k in range(9)]
    content = {"unit": "mm", "paths": {"there": rows, "back": back}}
    (tmp_path / "beads.json").write_text(json.dumps(content))
    made = compile(tmp_path / "beads.json", language="rapid", robot="irb1200-7-0.7")
    assert made.ok, made.findings
    text = next(iter(made.files.values())).decode().replace("\r\n", "\n")
    assert "    PROC main()\n        there;\n        back;\n    ENDPROC\n" in text
    assert "    PROC there()\n        ! there: 9 points, 32 mm\n" in text
    assert "! table beads.json" in text
    (tmp_path / "beads.process.toml").write_text('[style]\nprocedures = "none"\ncomments = false\n')
    made = compile(tmp_path / "beads.json", language="rapid", robot="irb1200-7-0.7")
    text = next(iter(made.files.values())).decode().replace("\r\n", "\n")
    assert text.count("    PROC ") == 1
    assert "table beads.json" not in text


def test_offsets_need_a_contour(tmp_path):
    rows = [[420, 20 + 4 * k, 300, 0, 1, 0, 0] for k in range(9)]
    (tmp_path / "seam.json").write_text(json.dumps({"unit": "mm", "poses": rows}))
    (tmp_path / "seam.process.toml").write_text('[style]\npoints = "offsets"\n')
    made = compile(tmp_path / "seam.json", language="rapid", robot="irb1200-7-0.7")
    assert made.ok
    assert [one.code for one in made.findings if one.code.startswith("CO62")] == ["CO621"]


def test_programs_say_what_heights_are_and_how_many_locations_there_are(tmp_path):
    def draw(model):
        for at in ((0, 0), (30, 0), (30, 30)):
            model.add_point(at, dxfattribs={"layer": "SPOTS"})

    process = PROCESS.replace("[motion]\n", "[motion]\napproach = 30\nretract = 30\n")
    document = ezdxf.new("R2010", units=4)
    draw(document.modelspace())
    document.saveas(tmp_path / "part.dxf")
    given = process.format(place="[420, 20, 280]", style="", layer="")
    (tmp_path / "part.process.toml").write_text(given)
    made = compile(tmp_path / "part.dxf", language="rapid", robot="irb1200-7-0.7")
    text = next(iter(made.files.values())).decode()
    assert "! locations_height: mm above the targets" in text
    assert "! 3 locations: SPOTS_1 to SPOTS_3" in text
    silent = process.format(place="[420, 20, 280]", style="comments = false", layer="")
    (tmp_path / "part.process.toml").write_text(silent)
    made = compile(tmp_path / "part.dxf", language="rapid", robot="irb1200-7-0.7")
    assert b"! 3 locations" not in next(iter(made.files.values()))


def test_targets_are_declared_in_the_order_of_the_moves(tmp_path):
    def draw(model):
        sheet(model)
        on = {"layer": "CUT"}
        model.add_arc((40, 10), 6.0, 200, 340, dxfattribs=on)  # a contour of one arc
        model.add_line((50, 0), (50, 30), dxfattribs=on)

    _, text = compiled(tmp_path, "rapid", draw=draw)
    data, _, code = text.partition("PROC main()")
    declared = re.findall(r"CONST robtarget (\w+):=", data)
    used = [name for name in dict.fromkeys(re.findall(r"\w+", code)) if name in declared]
    assert len(declared) > 20 and declared == used

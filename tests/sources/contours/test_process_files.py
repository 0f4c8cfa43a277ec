"""Process files: what is right is read, and everything wrong is found, with its line."""

import inspect
import math
import re
import string

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant.base.diagnostics import Refused, Severity, Unreadable
from assistant.base.source_text import SourceText
from assistant.base.toml_text import key_spans
from assistant.program.geometry import Frame, Load, Pose, Tool
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.program import Signal
from assistant.program.statements import Motion
from assistant.sources.process import (
    NO_PROCESS,
    ContourTravel,
    Defaults,
    Layer,
    Lead,
    OutputSwitching,
    Shaping,
    SpeedProfile,
    SwitchPoint,
)
from assistant.sources.process import file as process_file
from assistant.sources.process import file as process_layers
from assistant.sources.process.file import parse_process, read_process
from tests.examples import drawn
from tests.tables import every_row


def parse(text):
    return parse_process(SourceText(inspect.cleandoc(text) + "\n", "x.toml"))


def refused(text):
    with pytest.raises(Refused) as caught:
        parse(text)
    assert type(caught.value) is Refused
    return caught.value.findings


def test_the_example_of_the_documentation():
    doc = inspect.getdoc(process_file)
    example = "\n".join(line[4:] for line in doc.splitlines() if line.startswith("    "))
    process = parse(example)
    turned = Pose((400.0, 0.0, 20.0), (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)))
    assert process.defaults == Defaults("linear", Speed(100.0), FINE, "nozzle", "table")
    assert process.tools == {"nozzle": Tool(Pose((0.0, 0.0, 120.5)), Load(1.2, (0.0, 0.0, 60.0)))}
    assert process.frames["table"].user.position == turned.position
    assert process.frames["table"].user.quaternion == pytest.approx(turned.quaternion)
    assert process.signals == {"glue": Signal("digital", "output", 8)}
    assert process.layers == {
        "GLUE": Layer(
            "gluing",
            Motion(Speed(50.0), Blend(1.0), "nozzle", "table"),
            on=(("glue", 1.0),),
            off=(("glue", 0.0),),
            delay=0.2,
            own_blend=True,
            shaping=Shaping(
                offset=3.0,
                way_round="climb",
                lead_in=Lead("arc", 5.0),
                lead_out=Lead("line", 5.0),
                overlap=8.0,
                depth=12.0,
                passes=3,
                allowances=(0.5, 0.0),
            ),
            pace=SpeedProfile(Speed(20.0), start=Speed(30.0), end=Speed(30.0)),
            switching=OutputSwitching(
                on_before=SwitchPoint(seconds=0.03), off_before=SwitchPoint(mm=5.0)
            ),
            above=ContourTravel(None, Blend(10.0), "linear"),
        )
    }
    assert process.home == (0.0, 0.0, 0.0, 0.0, 30.0, 0.0)
    assert process.tags == {"name": "NAME"}
    assert process.findings == ()


def test_every_key_is_in_the_documentation():
    doc = inspect.getdoc(process_file)
    tables = (
        process_file.TOOL_KEYS,
        process_file.FRAME_KEYS,
        process_file.DEFAULT_MOTION_KEYS,
        process_file.SIGNAL_KEYS,
        process_layers.LAYER_KEYS,
    )
    for key in {k for table in tables for k in table} | {"tolerance", *process_file.DRAWING_KEYS}:
        assert re.search(rf"\b{key} = ", doc), key


def test_layers_to_leave_out_are_a_list_of_names():
    assert parse('leave_out = ["BORDER", "Notes"]').leave_out == ("BORDER", "Notes")
    for wrong in ('"BORDER"', "[1]", "true"):
        (finding,) = refused(f"leave_out = {wrong}")
        assert finding.line == 1
        assert "the name of a layer in quotes" in finding.cure


@pytest.mark.parametrize("key", ["kerf", "percent", "pierce"])
def test_a_key_is_not_taken_for_one_of_another_meaning(key):
    (finding,) = refused(f"[layers.GLUE]\n{key} = 1")
    assert finding.cure.startswith("use one of ")


def test_an_empty_table_of_everything_is_no_process():
    assert parse("[motion]\n[tools]\n[layers]") == NO_PROCESS


def test_a_layer_takes_from_motion_what_it_does_not_say():
    process = parse(
        """
        [motion]
        kind = "joint"
        speed = 70
        blend = 2.5
        tool = "TORCH"
        frame = "BASE"
        [tools.torch]
        euler_zyx = [0, 180, 0]
        held = false
        [layers.CUT]
        blend = "fine"
        direction = [0, 0, -3]
        """
    )
    assert process.defaults == Defaults("joint", Speed(70.0), Blend(2.5), "torch", "base")
    assert process.layers["CUT"] == Layer(
        "CUT", Motion(Speed(70.0), FINE, "torch", "base"), own_blend=True
    )
    assert process.tools["torch"].tip.quaternion == pytest.approx((0, 0, 1, 0), abs=1e-12)
    assert not process.tools["torch"].held


def test_euler_angles_turn_about_z_first():
    frame = parse("[frames.f]\neuler_zyx = [90, 0, 90]").frames["f"]
    moved = Frame(frame.user).pose @ Pose((0.0, 0.0, 1.0))
    assert moved.position == pytest.approx((1.0, 0.0, 0.0))


def test_a_quaternion_nearly_of_unit_length_is_repaired_with_a_warning():
    process = parse("[tools.t]\nquaternion = [0.7071, 0.7071, 0, 0]")
    assert math.hypot(*process.tools["t"].tip.quaternion) == pytest.approx(1.0, abs=1e-15)
    (finding,) = process.findings
    assert (finding.code, finding.severity, finding.line) == ("CT351", Severity.WARNING, 2)


def test_truth_values_switch_signals():
    process = parse("[signals.s]\n[layers.L]\non.S = true\noff = {s = false}")
    assert process.layers["L"].on == (("s", 1.0),)
    assert process.layers["L"].off == (("s", 0.0),)


BAD = [
    # text, code, line, in the message, in the cure
    ("tolerance = 0", "CT303", 1, "tolerance", "over 0"),
    ("tolerance = 11.0", "CT303", 1, "11", "at most 10"),
    ("tolerance = 'fine'", "CT303", 1, "a text", "a number of mm"),
    ("tolerance = true", "CT303", 1, "true or false", "a number of mm"),
    ("tolerence = 0.1", "CT302", 1, "tolerence", "`tolerance`"),
    ("layers = 3", "CT304", 1, "`layers` is a number", "[layers]"),
    ("[[layers]]\nspeed = 1", "CT304", 1, "an array", "[layers]"),
    ("[motion]\nspeed = nan", "CT303", 2, "not a finite number", "mm/s"),
    ("[motion]\nspeed = inf", "CT303", 2, "not a finite number", "mm/s"),
    ("[motion]\nspeed = 0", "CT303", 2, "out of range", "over 0"),
    ("[motion]\nspeed = -5.0", "CT303", 2, "-5", "over 0"),
    ("[motion]\nspeed = 1" + "0" * 400, "CT303", 2, "not a finite number", "mm/s"),
    ("[motion]\nspeed = '100 mm/s'", "CT303", 2, "a text", "without quotes or unit"),
    ("[motion]\nspeed = 1979-05-27", "CT303", 2, "a date", "mm/s"),
    ("[motion]\nspede = 3", "CT302", 2, "in [motion]", "`speed`"),
    ("[motion]\nqqqqqq = 3", "CT302", 2, "qqqqqq", "kind, speed, blend, tool, frame"),
    ("[motion]\nkind = 'circular'", "CT303", 2, "circular", '"joint" or "linear"'),
    ("[motion]\nkind = 3", "CT303", 2, "a number", '"joint" or "linear"'),
    ("[motion]\nblend = 1e308", "CT303", 2, "out of range", "at most 1000000"),
    ("[tools.t]\ntip = [1e300, 0, 0]", "CT303", 2, "out of range in entry 1", "3 numbers"),
    ("[motion]\nblend = -1", "CT303", 2, "out of range", "0 or more"),
    ("[motion]\nblend = 'fien'", "CT303", 2, "fien", '"fine"'),
    ("[motion]\nblend = nan", "CT303", 2, "finite", "mm"),
    ("[motion]\ntool = 'my tool'", "CT303", 2, "no name", "my_tool"),
    ("[motion]\ntool = 'nozle'\n[tools.nozzle]", "CT309", 2, "no tool `nozle`", "write nozzle"),
    ("[motion]\ntool = 'x9'", "CT309", 2, "no tool `x9`", "define [tools.x9]"),
    ("[motion]\nframe = 'x9'", "CT309", 2, "no frame `x9`", "define [frames.x9]"),
    ("[tools]\n'a b' = {}", "CT305", 2, "a b", "a_b"),
    ("[tools.tool0]", "CT308", 1, "bare flange", "another name"),
    ("[frames.base]", "CT308", 1, "own base", "another name"),
    ("[tools.a]\n[tools.A]", "CT313", 2, "A and a", "one of them"),
    ("[tools]\na = 5", "CT304", 2, "a number", "[tools.a]"),
    ("[tools.a]\ntip = 3", "CT303", 2, "a number", "3 numbers in mm"),
    ("[tools.a]\ntip = [1, 2]", "CT303", 2, "2 entries", "3 numbers in mm"),
    ("[tools.a]\ntip = [1, 'x', 3]", "CT303", 2, "a text in entry 2", "3 numbers in mm"),
    ("[tools.a]\ntip = [1, nan, 3]", "CT303", 2, "entry 2", "3 numbers in mm"),
    ("[tools.a]\nquaternion = [1, 1, 0, 0]", "CT303", 2, "length 1.41421", "length 1"),
    ("[tools.a]\nquaternion = [0, 0, 0, 0]", "CT303", 2, "length 0", "length 1"),
    ("[tools.a]\nquaternion = [1, 0, 0]", "CT303", 2, "3 entries", "4 numbers"),
    ("[tools.a]\nquaternion = [1e300, 1e300, 0, 0]", "CT303", 2, "length", "length 1"),
    ("[tools.a]\nquaternion = [1,0,0,0]\neuler_zyx = [0,0,0]", "CT306", 3, "twice", "either"),
    ("[tools.a]\neuler = [0, 0, 0]", "CT302", 2, "euler", "`euler_zyx`"),
    ("[tools.a]\nmass = 0", "CT303", 2, "out of range", "kg"),
    ("[tools.a]\ncentre = [0, 0, 1]", "CT307", 2, "no mass", "mass"),
    ("[tools.a]\nheld = 'yes'", "CT303", 2, "a text", "true or false"),
    ("[frames.a]\ntip = [0, 0, 0]", "CT302", 2, "tip", "position"),
    ("[signals.s]\nkind = 'analogue'", "CT303", 2, "analogue", '"analog"'),
    ("[signals.s]\ndirection = 'out'", "CT303", 2, "out", '"output"'),
    ("[signals.s]\nnumber = 1.5", "CT303", 2, "a number", "whole number"),
    ("[signals.s]\nnumber = -1", "CT303", 2, "out of range", "0 to"),
    ("[signals.s]\nkind = 'group'\nbits = 33", "CT303", 3, "out of range", "1 to 32"),
    ("[signals.s]\nbits = 4", "CT312", 2, "digital", "group"),
    ("[layers.L]\non = {glu = 1}\n[signals.glue]", "CT309", 2, "no signal `glu`", "write glue"),
    ("[layers.L]\non = 'glue'", "CT303", 2, "a text", "{signal = 1}"),
    ("[layers.L]\non = {s = 'x'}\n[signals.s]", "CT303", 2, "signal s", "number"),
    ("[layers.L]\non = {s = nan}\n[signals.s]", "CT303", 2, "signal s", "number"),
    ("[layers.L]\non = {s = 2}\n[signals.s]", "CT311", 2, "cannot be 2", "0 to 1"),
    ("[layers.L]\non.s = 0.5\n[signals.s]", "CT311", 2, "cannot be 0.5", "0 to 1"),
    ("[layers.L.off]\ns = 8\n[signals.s]\nkind='group'\nbits=3", "CT311", 2, "group", "0 to 7"),
    ("[layers.L]\non = {s=1}\n[signals.s]\ndirection='input'", "CT310", 2, "an input", "output"),
    ("[layers.L]\napproach = -1", "CT303", 2, "out of range", "0 or more"),
    ("[layers.L]\nretract = 'x'", "CT303", 2, "a text", "mm"),
    ("[layers.L]\ntravel = 0", "CT303", 2, "out of range", "mm/s"),
    ("[layers.L]\ndelay = -0.1", "CT303", 2, "out of range", "seconds"),
    ("[layers.L]\ndirection = [0, 0, 0]", "CT303", 2, "points nowhere", "not all zero"),
    ("[layers.L]\ndirection = [0, 0, inf]", "CT303", 2, "entry 3", "numbers"),
    ("[layers.L]\ntangential = 1", "CT303", 2, "a number", "true or false"),
    ("[layers.L]\nprocess = ''", "CT303", 2, "empty", "a text"),
    ("[layers.L]\nprocess = 7", "CT303", 2, "a number", "a text"),
    ("[layers.L]\ntool = 'gone'", "CT309", 2, "no tool `gone`", "define [tools.gone]"),
    ("[layers.glue]\n[layers.'GLUE']", "CT313", 2, "GLUE and glue", "one of them"),
    ("[tags]\nnam = 'X'", "CT302", 2, "nam", "`name`"),
    ("[tags]\nname = 3", "CT303", 2, "a number", "a text"),
    ("[layer.L]", "CT302", 1, "layer", "`layers`"),
    ("[layers.\"a\\nb\"]\nspeeed = 1", "CT302", 2, "a?b", "`speed`"),
]  # fmt: skip


@every_row(("text", "code", "line", "message", "cure"), BAD)
def test_what_is_wrong_is_said_with_line_and_cure(text, code, line, message, cure):
    (finding,) = refused(text)
    assert (finding.code, finding.severity) == (code, Severity.ERROR)
    assert finding.path == "x.toml"
    assert finding.line == line
    assert finding.excerpt == text.splitlines()[line - 1]
    assert message in finding.message
    assert cure in finding.cure
    assert finding.message.isprintable()
    assert finding.cure.isprintable()


def test_all_that_is_wrong_is_found_at_once_in_order_of_lines():
    findings = refused(
        """
        [layers.L]
        speed = -1
        blend = "soft"   # a comment with = and [brackets]
        tool = "gone"
        [motion]
        speed = nan
        spede = 1
        [tools.t]
        tip = [
            1,
            2,
        ]
        """
    )
    assert [(f.code, f.line) for f in findings] == [
        ("CT303", 2),
        ("CT303", 3),
        ("CT309", 4),
        ("CT303", 6),
        ("CT302", 7),
        ("CT303", 9),
    ]
    assert [f.column for f in findings] == [1] * 6


@every_row(
    ("text", "line"),
    [
        ("[motion", 1),
        ("a = 1\nb = = 2", 2),
        ("[motion]\nspeed = 1,5", 2),
        ("[motion]\n[motion]", 2),
        ("{\\rtf1}", 1),
        ("a = [1,\n", 2),
        ("a = " + "[" * 5000, 1),
        ("b = 1\na = 1" + "0" * 4999, 2),
    ],
)
def test_what_is_no_toml_is_unreadable(text, line):
    with pytest.raises(Unreadable) as caught:
        parse_process(SourceText(text, "x.toml"))
    (finding,) = caught.value.findings
    assert (finding.code, finding.line, finding.path) == ("CT301", line, "x.toml")
    assert finding.message.isprintable()


def test_files_that_cannot_be_read(tmp_path):
    cases = {"IN001": tmp_path / "none.toml", "IN002": tmp_path, "IN005": tmp_path / "empty.toml"}
    cases["IN005"].write_bytes(b"")
    cases["IN006"] = tmp_path / "binary.toml"
    cases["IN006"].write_bytes(b"\xff\xfe\x00\x81")
    for code, path in cases.items():
        with pytest.raises(Unreadable) as caught:
            read_process(path)
        assert caught.value.findings[0].code == code


def test_a_byte_order_mark_and_windows_line_ends(tmp_path):
    path = tmp_path / "p.toml"
    path.write_bytes(b"\xef\xbb\xbf[motion]\r\nspeed = 12\r\n[layers.'L\xc3\x9c']\r\nspeed = 0\r\n")
    with pytest.raises(Refused) as caught:
        read_process(path)
    assert (caught.value.findings[0].line, caught.value.findings[0].column) == (4, 1)
    assert caught.value.findings[0].excerpt == "speed = 0"


def test_keys_are_found_wherever_toml_lets_them_stand():
    text = inspect.cleandoc(
        '''
        top = """
        not.a = "key"
        """ # [no.table]
        "quo\\u0074ed".'x y' = 1
        list = ["a = 1", [1, {inner = 2}], # b = 2
          '\\', "]"]
        when = 1979-05-27 07:32:00
        [ a . "b.c" ]
        d.e = {f = {g = 1}, h = [1, 2]}
        [[ many ]]
        k = \'\'\'it's\'\'\'\'
        [[many]]
        k = -1e5
        '''
    )
    spans = key_spans(text)
    source = SourceText(text)
    lines = {
        path: source.line_column(span.start)[0]
        for path, span in spans.items()
        if not any(part.isdigit() for part in path)
    }
    assert lines == {
        ("top",): 1,
        ("quoted",): 4,
        ("quoted", "x y"): 4,
        ("list",): 5,
        ("when",): 7,
        ("a",): 8,
        ("a", "b.c"): 8,
        ("a", "b.c", "d"): 9,
        ("a", "b.c", "d", "e"): 9,
        ("a", "b.c", "d", "e", "f"): 9,
        ("a", "b.c", "d", "e", "f", "g"): 9,
        ("a", "b.c", "d", "e", "h"): 9,
        ("many",): 10,
    }
    assert source.line_column(spans["many", "1", "k"].start)[0] == 13
    assert source.line_column(spans["list", "1", "1", "inner"].start)[0] == 5


@settings(max_examples=drawn(300), deadline=None)
@given(st.text(string.ascii_letters + string.digits + " \n\t.=[]{}\"'#,_-:+", max_size=80))
def test_no_text_ever_gives_another_error(text):
    try:
        parse_process(SourceText(text, "x.toml"))
    except Refused as error:
        assert error.findings
        assert all(f.line and f.path == "x.toml" for f in error.findings)


values = st.one_of(
    st.integers(-5, 5).map(str),
    st.sampled_from(["nan", "inf", "1e999", '"fine"', "'t'", "true", "[]", "[1, 2, 3]", "{}"]),
    st.sampled_from(["{t = 1}", "{t = {}}", "[[1]]", "07:32:00", '"\\u0000"', '""']),
)
keys = st.sampled_from(
    [
        *process_file.TOP_TABLES,
        *process_layers.LAYER_KEYS,
        *process_file.TOOL_KEYS,
        *process_file.SIGNAL_KEYS,
        "t",
        "x-y",
    ]
)


@settings(max_examples=drawn(400), deadline=None)
@given(st.lists(st.tuples(st.lists(keys, min_size=1, max_size=3), values), max_size=5))
def test_no_value_anywhere_gives_another_error(entries):
    text = "\n".join(f"{'.'.join(key)} = {value}" for key, value in entries)
    try:
        parse_process(SourceText(text, "x.toml"))
    except Refused as error:
        assert error.findings
        assert all(f.message.isprintable() and f.cure.isprintable() for f in error.findings)


GLUE = "[signals.glue]\n[motion]\nspeed = 50\n[layers.GLUE]\non = {glue = 1}\noff = {glue = 0}\n"


@every_row(
    ("keys", "code", "named"),
    [
        ("on_before = {mm = 60}", "CT342", "`on_before` is 60 mm"),
        ("on_before = {seconds = 1.1}", "CT342", "55 mm of the way at 50 mm/s"),
        ("on_before = {mm = 45}\ntravel_blend = 10", "CT342", "40 mm: `travel_blend` takes 10 mm"),
        ("off_after = {mm = 51}", "CT342", "`retract` leaves 50 mm"),
        ("off_after = {mm = 31}\ntravel_height = 30", "CT342", "`travel_height` leaves 30 mm"),
        ("on_before = {mm = 5}\non_after = {mm = 5}", "CT340", "`on_before` and `on_after`"),
        ("off_before = {mm = 5}\noff_after = {mm = 5}", "CT340", "`off_before` and `off_after`"),
        ("on_after = {mm = 5}\ndelay = 0.1", "CT340", "`on_after` and `delay`"),
        ("off_after = {mm = 5, seconds = 1}", "CT340", "`mm` and `seconds`"),
        ("retract = 20\ntravel_height = 30", "CT340", "`retract` and `travel_height`"),
        ("corner_angle = 20", "CT341", "without `corner_speed`"),
        ("corner_radius = 5", "CT341", "without `corner_speed`"),
        ("end_length = 5", "CT341", "without `end_speed`"),
        ('travel_kind = "joint"\nretract = 0', "CT343", "joint moves"),
        ("travel_blend = 60", "CT344", "50 mm above the work"),
        ("travel_blend = 60\ntravel_height = 55", "CT344", "55 mm above the work"),
        ("on_before = 5", "CT303", "is a number"),
        ("on_before = {inch = 5}", "CT303", "has `inch`"),
        ("on_before = {mm = -5}", "CT303", "has `mm`, which is -5"),
        ("on_before = {}", "CT303", "says no place"),
        ("on_after = {seconds = 1}", "CT303", "has `seconds`"),
        ('order = "random"', "CT303", 'is "random"'),
        ("corner_speed = 0", "CT303", "out of range"),
        ("travel_height = 0", "CT303", "out of range"),
    ],
)
def test_what_does_not_fit_the_way_along_a_contour_is_told(keys, code, named):
    (finding,) = refused(GLUE + keys)
    assert finding.code == code
    assert named in finding.message
    assert finding.line in (7, 8)
    assert finding.cure


def test_keys_of_outputs_need_the_outputs():
    for key, other in (("on_before", "on"), ("on_after", "on"), ("off_before", "off")):
        (finding,) = refused(f"[layers.GLUE]\n{key} = {{mm = 5}}")
        assert (finding.code, finding.line) == ("CT341", 2)
        assert f"without `{other}`" in finding.message


def test_the_kind_of_travel_is_not_stated_where_ways_are_planned():
    (finding,) = refused('[motion]\nkind = "travel"\n[layers.GLUE]\ntravel_kind = "linear"')
    assert (finding.code, finding.line) == ("CT345", 4)


def test_home_is_a_number_for_each_axis():
    assert parse("home = [0, 0, 90, 0, 90, 0]").home == (0.0, 0.0, 90.0, 0.0, 90.0, 0.0)
    for wrong in ("0", "[]", "[1]", "[0, 0, 0, 0, 0, 0, 0, 0]", '["a", 1]'):
        (finding,) = refused(f"home = {wrong}")
        assert (finding.code, finding.line) == ("CT303", 1)
        assert "number" in finding.cure

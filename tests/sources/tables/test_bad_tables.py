"""Tables that are wrong or damaged: refused with a place and a cure, never a crash."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from assistant import sources
from assistant.base.diagnostics import Refused
from assistant.program.program import Signal
from assistant.sources.process import Defaults, Process
from tests.examples import drawn
from tests.sources.tables.test_csv_tables import CELL, POSE, read
from tests.tables import every_row

SIGNALS = Process(
    signals={
        "glue": Signal("digital", "output", 8),
        "force": Signal("analog", "output", 3),
    }
)
BAD = {
    "decimal comma": (POSE.replace(",", ";") + "\n1,5;2;3;1;0;0;0\n", "TB121", 2, "`1,5`"),
    "quoted comma": (POSE + '\n"1,5",2,3,1,0,0,0\n', "TB121", 2, "decimal comma"),
    "bare comma": (POSE + "\n1,5,2,3,1,0,0,0\n", "TB115", 2, "8 cells"),
    "nan": (POSE + "\n1,2,3,1,0,0,0\n1,nan,3,1,0,0,0\n", "TB122", 3, "`nan`"),
    "inf": (POSE + "\n1,-Infinity,3,1,0,0,0\n", "TB122", 2, "Infinity"),
    "overflow": (POSE + "\n1,1e999,3,1,0,0,0\n", "TB201", 2, "inf"),
    "formula": (POSE + "\n=A1+2,2,3,1,0,0,0\n", "TB123", 2, "formula"),
    "unit": (POSE + "\n1 mm,2,3,1,0,0,0\n", "TB124", 2, "`1 mm`"),
    "word": (POSE + "\n1,2,three,1,0,0,0\n", "TB125", 2, "`three`"),
    "two numbers": (POSE + "\n1,2,3 4,1,0,0,0\n", "TB125", 2, "`3 4`"),
    "two points": (POSE + "\n1,2,1.2.3,1,0,0,0\n", "TB125", 2, "`1.2.3`"),
    "underscore": (POSE + "\n1,2,1_000,1,0,0,0\n", "TB125", 2, "`1_000`"),
    "bracket": (POSE + "\n1,2,(5),1,0,0,0\n", "TB125", 2, "`(5)`"),
    "empty cell": (POSE + "\n1,2,,1,0,0,0\n", "TB126", 2, "empty"),
    "no target": ("name," + POSE + "\np,,,,,,,\n", "TB131", 2, "neither"),
    "ragged": (POSE + "\n1,2,3,1,0,0,0\n1,2,3\n", "TB114", 3, "3 cells"),
    "header only": (POSE + "\n", "TB113", 1, "no row"),
    "blank": ("\n \n", "TB112", None, "blank"),
    "binary": (b"\x89PNG\0\0", "TB111", None, "zero bytes"),
    "no header": ("1,2,3,1,0,0,0\n1,2,3,1,0,0,0\n", "TB106", 1, "names no columns"),
    "missing z": (POSE.replace("z_mm,", "") + "\n1,2,1,0,0,0\n", "TB104", 1, "`z_mm`"),
    "missing part": (POSE.replace(",q_z", "") + "\n1,2,3,1,0,0\n", "TB104", 1, "`q_z`"),
    "no orientation": ("x_mm,y_mm,z_mm\n1,2,3\n", "TB104", 1, "orientation"),
    "unknown column": (POSE + ",sped_mm_s\n1,2,3,1,0,0,0,9\n", "TB101", 1, "`sped_mm_s`"),
    "no unit": ("x,y_mm,z_mm,q_w,q_x,q_y,q_z\n1,2,3,1,0,0,0\n", "TB102", 1, "unit"),
    "no convention": ("x_mm,y_mm,z_mm,rx,ry,rz\n1,2,3,1,0,0\n", "TB102", 1, "convention"),
    "twice": (POSE + ",x_m\n1,2,3,1,0,0,0,1\n", "TB103", 1, "`x_m`"),
    "two orientations": (
        POSE + ",rotvec_x_deg,rotvec_y_deg,rotvec_z_deg\n1,2,3,1,0,0,0,1,1,1\n",
        "TB107", 1, "twice",
    ),
    "nameless column": (POSE + ",\n1,2,3,1,0,0,0,\n", "TB105", 1, "column 8"),
    "wait of a waypoint": (POSE + ",wait_s\n1,2,3,1,0,0,0,1\n", "TB108", 1, "`wait_s`"),
    "long quaternion": (POSE + "\n1,2,3,1.002,0,0,0\n", "TB203", 2, "1.002"),
    "zero quaternion": (POSE + "\n1,2,3,0,0,0,0\n", "TB203", 2, "0 long"),
    "a kilometre": (POSE + "\n1,2,1.1e6,1,0,0,0\n", "TB202", 2, "1.1e+06"),
    "metres of kilometres": (
        "x_m,y_m,z_m,q_w,q_x,q_y,q_z\n1,2,1.1e3,1,0,0,0\n", "TB202", 2, "1.1e+06",
    ),
    "unknown tool": (POSE + ",tool\n1,2,3,1,0,0,0,tolo\n", "TB301", 2, "`tolo`"),
    "unknown frame": (POSE + ",frame\n1,2,3,1,0,0,0,desk\n", "TB302", 2, "`desk`"),
    "unknown motion": (POSE + ",motion\n1,2,3,1,0,0,0,straight\n", "TB304", 2, "straight"),
    "no speed": (POSE + ",speed_mm_s\n1,2,3,1,0,0,0,0\n", "TB305", 2, "is 0"),
    "more than all": (POSE + ",joint_percent\n1,2,3,1,0,0,0,101\n", "TB202", 2, "101"),
    "negative blend": (POSE + ",blend_mm\n1,2,3,1,0,0,0,-1\n", "TB306", 2, "-1"),
    "blend of no number": (
        POSE + ",blend_mm\n1,2,3,1,0,0,0,fine\n1,2,3,1,0,0,0,z10\n", "TB125", 3, "`z10`",
    ),
    "via at the start": (
        POSE + ",motion\n1,2,3,1,0,0,0,via\n1,2,3,1,0,0,0,end\n", "TB308", 2, "start from",
    ),
    "via alone": (
        POSE + ",motion\n1,2,3,1,0,0,0,linear\n1,2,3,1,0,0,0,via\n", "TB308", 3, "no `end`",
    ),
    "end alone": (POSE + ",motion\n1,2,3,1,0,0,0,end\n", "TB308", 2, "no `via`"),
    "wait at via": (
        "name," + POSE + ",motion,wait_s\na,1,2,3,1,0,0,0,linear,\n"
        "b,1,2,3,1,0,0,0,via,1\nc,1,2,3,1,0,0,0,end,1\n",
        "TB311", 3, "`wait_s`",
    ),
    "half a branch": (
        POSE + ",back,down,flip,quadrant1,quadrant4,quadrant6\n1,2,3,1,0,0,0,1,,,,,\n",
        "TB134", 2, "arm branch",
    ),
    "joints by a line": ("name,j1_deg,motion\np,1,linear\n", "TB135", 2, "linear"),
    "both": (POSE + ",j1_deg\n1,2,3,1,0,0,0,5\n", "TB132", 2, "pose and joints"),
    "mixed": (POSE + ",j1_deg\n1,2,3,1,0,0,0,\n,,,,,,,5\n", "TB133", 3, "mix"),
    "same name": (
        "name," + POSE + "\np,1,2,3,1,0,0,0\nP,1,2,3,1,0,0,0\n", "TB309", 3, "line 2",
    ),
    "no name": ("name," + POSE + "\n,1,2,3,1,0,0,0\n", "TB310", 2, "no name"),
    "undeclared signal": (
        "name," + POSE + ",set_spray\np,1,2,3,1,0,0,0,1\n", "TB303", 1, "`spray`",
    ),
    "half a digital signal": (
        "name," + POSE + ",set_glue\np,1,2,3,1,0,0,0,\nq,1,2,3,1,0,0,0,0.5\n",
        "TB312", 3, "`glue`",
    ),
    "endless signal": (
        "name," + POSE + ",set_force\nq,1,2,3,1,0,0,0,1e999\n", "TB201", 2, "`set_force`",
    ),
    "stray quote": ('name,' + POSE + '\n5" pipe,1,2,3,1,0,0,0\n', "TB116", 2, "quotation"),
    "stray quote before a blank": (
        'name,' + POSE + '\nx" ,1,2,3,1,0,0,"0"\n', "TB116", 2, "quotation",
    ),
    "text after a quote": ('name,' + POSE + '\n"a"b,1,2,3,1,0,0,0\n', "TB116", 2, "quotation"),
    "unclosed quote": ('name,' + POSE + '\n"pipe,1,2,3,1,0,0,0\n', "TB117", 2, "never closed"),
}  # fmt: skip


@every_row("case", list(BAD))
def test_bad_input_is_refused_with_its_place_and_a_cure(case: str) -> None:
    text, code, line, words = BAD[case]
    with pytest.raises(Refused) as refused:
        read(text, SIGNALS)
    found = [f for f in refused.value.findings if f.code == code]
    assert found, refused.value.findings
    finding = found[0]
    assert finding.path == "part.csv"
    assert finding.line == line
    assert words in finding.message
    assert finding.cure
    assert "\n" not in finding.message


def test_every_wrong_column_of_a_table_is_reported_at_once() -> None:
    with pytest.raises(Refused) as refused:
        read(POSE + "\na,b,3,1,0,0,0\n")
    assert [f.place for f in refused.value.findings] == ["column `x_mm`", "column `y_mm`"]
    with pytest.raises(Refused) as refused:
        read(POSE + ",tool,motion\n2e6,0,3,1.1,0,0,0,drill,fly\n")
    assert {f.code for f in refused.value.findings} == {"TB202", "TB203", "TB301", "TB304"}


def test_the_line_of_a_bad_cell_counts_line_feeds_in_quoted_cells() -> None:
    with pytest.raises(Refused) as refused:
        read("name," + POSE + '\n"a\n\nb",1,2,3,1,0,0,0\nc,1,x,3,1,0,0,0\n')
    assert refused.value.findings[0].line == 5


def test_the_bad_cell_in_many_rows_is_found() -> None:
    rows = ["1,2,3,1,0,0,0"] * 70_000
    rows[65_123] = "1,2,3,1,0,0,0.0.0"
    with pytest.raises(Refused) as refused:
        read("\n".join([POSE, *rows]))
    (finding,) = refused.value.findings
    assert (finding.line, finding.place) == (65_125, "column `q_z`")


def test_too_many_different_speeds_are_refused() -> None:
    rows = [f"1,2,3,1,0,0,0,{100 + i * 0.01}" for i in range(1001)]
    with pytest.raises(Refused) as refused:
        read("\n".join([POSE + ",speed_mm_s", *rows]))
    assert refused.value.findings[0].code == "TB307"


def test_an_undeclared_default_tool_is_refused() -> None:
    with pytest.raises(Refused) as refused:
        read(POSE + "\n1,2,3,1,0,0,0\n", Process(defaults=Defaults(tool="torch")))
    assert refused.value.findings[0].code == "TB301"


GOOD = ("name," + POSE + ",speed_mm_s,blend_mm,motion,comment\n").encode() + (
    b'pick,1,2.5,-3,0,1,0,0,250,fine,joint,"a, b"\nplace,4,5,6,1,0,0,0,,10,linear,\n'
)


@given(
    st.lists(
        st.tuples(st.integers(0, len(GOOD)), st.integers(0, 3), st.binary(max_size=3)), max_size=4
    )
)
@settings(deadline=None, max_examples=drawn(300))
def test_damaged_tables_are_read_or_refused_never_crash(
    edits: list[tuple[int, int, bytes]],
) -> None:
    data = GOOD
    for at, gone, put in edits:
        data = data[:at] + put + data[at + gone :]
    try:
        program = read(data).program
    except Refused as refused:
        assert refused.findings
        assert all(f.path == "part.csv" and f.code for f in refused.findings)
    else:
        assert all(np.isfinite(t.pose.position).all() for t in program.targets.values())


@given(st.binary(max_size=60))
@settings(deadline=None, max_examples=drawn(200))
def test_any_bytes_are_read_or_refused(data: bytes) -> None:
    try:
        read(data)
    except Refused as refused:
        assert all(f.path == "part.csv" for f in refused.findings)


@given(name=st.text(min_size=1, max_size=30))
@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_any_name_survives_as_an_identifier(name: str) -> None:
    cell = '"' + name.replace('"', '""') + '"'
    try:
        program = read(f"name,{POSE}\n{cell},1,2,3,1,0,0,0\n".encode("utf-8", "replace")).program
    except Refused as refused:
        assert {f.code for f in refused.findings} <= {"TB310", "TB111"}
    else:
        (target,) = program.targets
        assert target.isascii()
        assert target.replace("_", "").isalnum()
        assert target[0].isalpha()


@pytest.mark.parametrize("kind", ["missing", "empty", "folder"])
def test_what_cannot_be_read_at_all(kind: str, tmp_path: FilePath) -> None:
    path = tmp_path / "part.csv"
    if kind == "empty":
        path.touch()
    elif kind == "folder":
        path.mkdir()
    with pytest.raises(Refused) as refused:
        sources.read(path)
    assert refused.value.exit_status == 2


def test_a_value_that_is_no_number_is_told_of_at_its_own_signal() -> None:
    text = "name," + POSE + ",set_glue,set_flow\np,1,2,3,1,0,0,0,1,1e999\n"
    analog = Signal("analog", "output", 2)
    cell = replace(CELL, signals={**CELL.signals, "flow": analog})
    with pytest.raises(Refused) as refused:
        read(text, cell)
    (found,) = refused.value.findings
    assert found.place == "column `set_flow`"


def found_in(text: str) -> list[tuple[str, int | None, str]]:
    with pytest.raises(Refused) as caught:
        read(text)
    return [(one.code, one.line, one.message) for one in caught.value.findings]


def test_all_rows_that_are_wrong_are_reported_at_once() -> None:
    lines = [
        POSE + ",blend_mm",
        "1,a,3,1,0,0,0,5",
        "1,b,3,1,0,0,0,5",
        '1,"1,5",3,1,0,0,0,x',
        "1,2,3,1,0,0,0.4,5",
        "1e9,2,3,1,0,0,0,-4",
        "1,,3,1,0,0,0,5",
    ]
    found = found_in("\n".join(lines) + "\n")
    assert [(code, line) for code, line, _ in found] == [
        ("TB125", 2), ("TB121", 4), ("TB125", 4), ("TB126", 7), ("TB202", 6), ("TB203", 5),
        ("TB306", 6),
    ]  # fmt: skip
    assert found[0][2].endswith("(2 such rows: lines 2, 3)")


def test_of_many_rows_that_are_wrong_the_first_are_named() -> None:
    ((code, line, message),) = found_in(POSE + "\n1,2,3,1,0,0,0\n" + "1,2,z,1,0,0,0\n" * 300)
    assert (code, line) == ("TB125", 3)
    assert "(300 such rows: lines 3, 4, " in message and message.endswith("22 and 280 more)")
    ((code, line, message),) = found_in(POSE + "\n" + "1,2,3\n1,2,3,1,0,0,0\n" * 2)
    assert (code, line) == ("TB114", 2) and message.endswith("(2 such rows: lines 2, 4)")


def test_a_row_that_cannot_be_read_breaks_no_arc() -> None:
    rows = "".join(f"{x},2,3,1,0,0,0,{kind}\n" for x, kind in ((1, "linear"), ("a", "via")))
    ((code, _, _),) = found_in(f"{POSE},motion\n{rows}5,2,3,1,0,0,0,end\n")
    assert code == "TB125"

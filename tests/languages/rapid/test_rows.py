"""Long tables are read into columns as the grammar alone would read them, damaged or not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid.reading.parser import find_runs, parse
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.syntax import FEWEST_IN_RUN
from tests.examples import drawn

RAPID = languages.get("rapid")

NUMBER = st.one_of(
    st.integers(-999, 9999).map(str),
    st.decimals(-500, 500, places=3).map(str),
    st.floats(-1e5, 1e5, allow_nan=False).map(repr),
    st.sampled_from(["9E9", "9E+09", "1e-05", ".5", "5.", "-.25", "+3", "0.12345678901234567890"]),
)
BLANK = st.sampled_from(["", "", "", " ", "\t", "  "])


@st.composite
def values(draw: st.DrawFn) -> str:
    blank = draw(BLANK)
    parts = [
        "[" + f",{blank}".join(draw(st.lists(NUMBER, min_size=n, max_size=n))) + "]"
        for n in (3, 4, 4, 6)
    ]
    return f"[{','.join(parts)}]"


@st.composite
def rows(draw: st.DrawFn) -> str:
    """A table of declarations, of moves by name or of moves to written targets."""
    kind = draw(st.sampled_from(["declared", "named", "written"]))
    written = draw(st.lists(values(), min_size=1, max_size=3))
    end = draw(st.sampled_from(["", "", " "])) + draw(st.sampled_from(["\n", "\r\n"]))
    lines = []
    for i in range(draw(st.integers(FEWEST_IN_RUN - 1, 2 * FEWEST_IN_RUN + 3))):
        value = written[i % len(written)]
        stem = draw(st.sampled_from(["p", "p", "p", "seam_", "x0"]))
        tail = draw(
            st.sampled_from([",v100,z1,tool0;", ",e5,fine,t\\WObj:=w;", ",v5,z1,t,\\WObj:=w;"])
        )
        match kind:
            case "declared":
                line = f"CONST robtarget {stem}{i}:={value};"
            case "named":
                line = (
                    draw(st.sampled_from(["MoveL ", "MoveJ ", f"MoveC q{i},"])) + f"{stem}{i}{tail}"
                )
            case _:
                line = draw(st.sampled_from(["MoveL ", "MoveJ "])) + value + tail
        lines.append(f"  {line}{end}")
        if draw(st.integers(0, 14)) == 0:
            lines.append(draw(st.sampled_from(["! note\n", "\n", "! a; b\n"])))
    return "".join(lines)


def module(declarations: str, body: str) -> str:
    return f"MODULE m\n{declarations}PROC p()\n{body}ENDPROC\nENDMODULE\n"


def placed(table: str) -> str:
    return module(table, "") if "robtarget" in table else module("", table)


def seen(finding: Diagnostic) -> tuple[object, ...]:
    return finding.code, finding.message, finding.cure, finding.span, finding.line, finding.column


def alike(text: str) -> None:
    fast, slow = parse(text), parse(text, runs=False)
    assert fast == slow
    assert [seen(f) for f in fast.findings] == [seen(f) for f in slow.findings]


@settings(max_examples=drawn(25), deadline=None)
@given(rows())
def test_whole_tables_are_read_alike(table: str) -> None:
    text = placed(table)
    alike(text)
    tree = parse(text)
    assert not tree.findings
    assert RAPID.render(tree) == text
    assert parse(RAPID.format(tree)) == tree


@settings(max_examples=drawn(40), deadline=None)
@given(rows(), st.sampled_from(["drop", "double", "swap", "cut"]), st.data())
def test_damaged_tables_are_read_alike(table: str, damage: str, data: st.DataObject) -> None:
    at = data.draw(st.integers(0, len(table) - 2))
    match damage:
        case "drop":
            table = table[:at] + table[at + 1 :]
        case "double":
            table = table[: at + 1] + table[at:]
        case "swap":
            table = table[:at] + table[at + 1] + table[at] + table[at + 2 :]
        case _:
            table = table[:at] + table[max(table.find("\n", at), at) :]
    alike(placed(table))


TARGET = "[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"


@pytest.mark.parametrize(
    ("line", "odd"),
    [
        (f"MoveL {TARGET},v100,z1,tool0;", f"MoveL {TARGET},v100,to,tool0;"),
        (f"MoveL {TARGET},v100,z1,tool0;", f"MoveL {TARGET}],v100,z1,tool0;"),
        (f"MoveL {TARGET},v100,z1,tool0;", f"MoveL {TARGET.replace('3', '3 3')},v100,z1,tool0;"),
        ("MoveL p1,v100,z1,tool0;", "MoveL if,v100,z1,tool0;"),
        ("MoveL p1,v100,z1,tool0;", "MoveL p1,v100,z1,not;"),
    ],
)
def test_an_odd_row_in_a_table_is_left_to_the_grammar(line: str, odd: str) -> None:
    text = module("", "\n".join([*[line] * 20, odd, *[line] * 20, ""]))
    alike(text)
    assert parse(text).findings[0].line == 23


def test_a_row_of_another_form_is_left_to_the_grammar() -> None:
    line, odd = f"MoveL {TARGET},v100,z1,tool0;\n", "MoveL [[1,2],[3,1,0,0,0],[0,0]],v1,z1,t;\n"
    text = module("", line * 20 + odd + line * 20)
    alike(text)
    (routine,) = parse(text).modules[0].items
    assert isinstance(routine, s.Routine)
    kinds = [type(node) for node in routine.body]
    assert kinds == [s.MoveRunNode, s.ProcedureCall, s.MoveRunNode]


def test_written_targets_become_columns() -> None:
    n = 3000
    lines = "".join(
        f"  MoveL [[{i}.5, -{i},0],[1,0,0,0],[0,-1,0,0],[9E+09,9E9,9E9,9E9,9E9,9E9]],v{i % 3}00,z1,"
        f"tool0,\\WObj:=w;\r\n"
        for i in range(1, n + 1)
    )
    (module_,) = parse(module("", lines)).modules
    (routine,) = module_.items
    assert isinstance(routine, s.Routine)
    (node,) = routine.body
    assert isinstance(node, s.MoveRunNode)
    assert node.run.values is not None
    assert np.array_equal(node.run.values[:, 0], np.arange(1, n + 1) + 0.5)
    assert [m.speed for m in node.run.motions.table] == ["v100", "v200", "v000"]
    assert {m.frame for m in node.run.motions.table} == {"w"}


def test_written_targets_lift_as_single_moves_do() -> None:
    line = "MoveJ [[1,2,3],[0,1,0,0],[0,-1,0,0],[5,9E9,9E9,9E9,9E9,9E9]],v100,z1,tool0\\WObj:=w;\n"
    (few,) = RAPID.lift(parse(module("", line))).procedures
    (many,) = RAPID.lift(parse(module("", line * 2 * FEWEST_IN_RUN))).procedures
    assert many.body == few.body * 2 * FEWEST_IN_RUN


def test_a_row_that_cannot_be_read_costs_its_neighbours_nothing() -> None:
    good = f"CONST robtarget p1:={TARGET};\n"
    text = good * 100 + good.replace("3", "3-3") + good * 100
    assert sum(len(found.node.run) for found in find_runs(text)) >= 200 - 2 * FEWEST_IN_RUN

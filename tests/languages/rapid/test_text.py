"""Text of RAPID to the tree and back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.diagnostics import Refused
from assistant.languages.rapid.reading.parser import parse
from assistant.languages.rapid.reading.scanner import grammar
from assistant.languages.rapid.tables.constants import RESERVED
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.syntax import FEWEST_IN_RUN
from tests.examples import drawn
from tests.tables import every_row

RAPID = languages.get("rapid")
LINES = (Path(__file__).parent / "identity.txt").read_text(encoding="utf-8").splitlines()


def test_the_grammar_reserves_the_same_words_as_the_tables() -> None:
    name = grammar().terminals["NAME"].pattern
    assert set(name.removeprefix("(?!(?:").partition(")")[0].split("|")) == RESERVED


@every_row("line", [line.replace("¶", "\n") for line in LINES])
def test_every_construct_comes_back(line: str) -> None:
    tree = RAPID.parse(line)
    assert not tree.findings, tree.findings
    assert RAPID.render(tree) == line
    canonical = RAPID.format(tree)
    again = RAPID.parse(canonical)
    assert not again.findings, canonical
    assert again == tree
    assert RAPID.format(again) == canonical


def test_comments_keep_their_places() -> None:
    text = (
        "MODULE m ! behind the module\n ! above\n VAR num a; ! behind a\n PROC p() ! behind p\n"
        "  ! before\n  a:=1; ! behind it\n  IF a=1 THEN ! behind THEN\n  ENDIF ! behind ENDIF\n"
        " ENDPROC\nENDMODULE\n"
    )
    tree = RAPID.parse(text)
    assert not tree.findings
    printed = RAPID.format(tree)
    assert RAPID.parse(printed) == tree
    for word in ("module", "above", "a", "p", "before", "it", "THEN", "ENDIF"):
        assert any(line.endswith(" " + word) for line in printed.split("\n"))


@pytest.mark.parametrize("character", ["\u2028", "\u2029"])
def test_a_string_that_would_end_its_line_is_not_printed(character: str) -> None:
    tree = RAPID.parse('MODULE m\n  CONST string a:="x";\nENDMODULE\n')
    (module,) = tree.modules
    (data,) = module.items
    assert isinstance(data, s.Data)
    for text, fits in ((f"x{character}", False), ("x\x85\u4e2d", True)):
        changed = replace(data, value=s.StringLiteral(text))
        one = replace(tree, parts=(replace(module, items=(changed,)),))
        if fits:
            assert RAPID.parse(RAPID.render(one)) == one
            continue
        with pytest.raises(Refused) as refused:
            RAPID.render(one)
        assert [f.code for f in refused.value.findings] == ["RA305"]


def test_an_unchanged_module_beside_a_changed_one_keeps_its_text() -> None:
    text = "MODULE  a   ENDMODULE\nMODULE  b  ENDMODULE\n"
    tree = RAPID.parse(text)
    first, second = tree.modules
    changed = replace(tree, parts=(first, replace(second, name="c")))
    assert RAPID.render(changed) == "MODULE  a   ENDMODULE\nMODULE  c  ENDMODULE\n"


NUMBER = st.one_of(
    st.integers(-9999, 9999).map(str),
    st.decimals(-500, 500, places=3).map(str),
    st.floats(-1e5, 1e5, allow_nan=False).map(repr),
    st.sampled_from(["9E9", "9E+09", "1e-05", ".5", "5.", "-.25"]),
)
DAMAGE = st.sampled_from(["", "--5", "1,2", "x", "1.2.3", "+", "1 2", "1e", "1-2", "1E999", "[1]"])


def declaration(name: str, values: list[str], blank: str) -> str:
    parts = [values[0:3], values[3:7], values[7:11], values[11:17]]
    inner = ",".join("[" + ("," + blank).join(part) + "]" for part in parts)
    return f"{blank}CONST robtarget {name}:=[{inner}];"


@st.composite
def tables(draw: st.DrawFn) -> str:
    rows = []
    for number in range(draw(st.integers(FEWEST_IN_RUN - 2, 2 * FEWEST_IN_RUN + 3))):
        values = draw(st.lists(NUMBER, min_size=17, max_size=17))
        stem = draw(st.sampled_from(["p", "seam_", "x0", "q_1_"]))
        rows.append(declaration(f"{stem}{number}", values, draw(st.sampled_from(["", " "]))))
        if draw(st.integers(0, 9)) == 0:
            rows.append(draw(st.sampled_from(["", "! comment", "VAR num v" + str(number) + ";"])))
    return "MODULE m\n" + "\n".join(rows) + "\nENDMODULE\n"


@settings(max_examples=drawn(25), deadline=None)
@given(tables())
def test_columns_and_grammar_read_tables_alike(text: str) -> None:
    fast, slow = parse(text), parse(text, runs=False)
    assert not fast.findings
    assert fast == slow
    assert RAPID.parse(RAPID.format(fast)) == fast


@settings(max_examples=drawn(25), deadline=None)
@given(tables(), DAMAGE, st.data())
def test_columns_and_grammar_see_the_same_damage(
    text: str, damage: str, data: st.DataObject
) -> None:
    lines = text.splitlines(keepends=True)
    row = data.draw(st.integers(0, len(lines) - 1))
    pieces = lines[row].split(",")
    pieces[data.draw(st.integers(0, len(pieces) - 1))] = damage
    lines[row] = ",".join(pieces)
    if not lines[row].endswith("\n"):
        lines[row] += "\n"
    fast, slow = parse("".join(lines)), parse("".join(lines), runs=False)
    assert fast == slow
    assert [(f.code, f.line, f.column) for f in fast.findings] == [
        (f.code, f.line, f.column) for f in slow.findings
    ]


MOVE = st.builds(
    lambda kind, via, name, v, z, t, w, blank: (
        f"{blank}{kind} {via + ',' if kind == 'MoveC' else ''}{name},{blank}{v},{z},{t}"
        + (f"\\WObj:={w}" if w else "")
        + ";"
    ),
    st.sampled_from(["MoveL", "MoveJ", "MoveC", "movel"]),
    st.sampled_from(["a1", "b"]),
    st.sampled_from(["p1", "p2", "seam_10", "p007", "home"]),
    st.sampled_from(["v100", "v5"]),
    st.sampled_from(["fine", "z1"]),
    st.sampled_from(["tool0", "GRIPPER"]),
    st.sampled_from(["", "part"]),
    st.sampled_from(["", " ", "   "]),
)
BETWEEN = st.sampled_from(["", "IF a\n", "! note\n", "b:=1;\n", "IF a THEN\n", "lab:\n", "Stop\n"])


@settings(max_examples=drawn(80), deadline=None)
@given(
    st.lists(st.tuples(BETWEEN, st.lists(MOVE, min_size=1, max_size=14)), min_size=1, max_size=4)
)
def test_columns_and_grammar_read_moves_alike(parts: list[tuple[str, list[str]]]) -> None:
    body = "".join(before + "\n".join(moves) + "\n" for before, moves in parts)
    text = f"MODULE m\nPROC p()\n{body}ENDPROC\nENDMODULE\n"
    fast, slow = parse(text), parse(text, runs=False)
    assert fast == slow
    assert [(f.code, f.line, f.column) for f in fast.findings] == [
        (f.code, f.line, f.column) for f in slow.findings
    ]


def test_a_long_table_is_one_node() -> None:
    n = 20_000
    rows = "\n".join(
        f"CONST robtarget p_{i}:=[[{i},0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
        for i in range(1, n + 1)
    )
    moves = "\n".join(f"MoveL p_{i},v100,z10,tool0;" for i in range(1, n + 1))
    tree = RAPID.parse(f"MODULE m\n{rows}\nPROC main()\n{moves}\nENDPROC\nENDMODULE\n")
    (module,) = tree.modules
    table, routine = module.items
    assert isinstance(table, s.TargetRunNode)
    assert len(table.run) == n
    assert isinstance(routine, s.Routine)
    assert [type(node) for node in routine.body] == [s.MoveRunNode]


@every_row(
    ("text", "line", "cure"),
    [
        ("", 1, "MODULE"),
        (" \n\n", 1, "MODULE"),
        ("hello", 1, "MODULE"),
        ("MODULE m\nPROC p()\n a=1;\nENDPROC\nENDMODULE", 3, ":="),
        ("MODULE m\nPROC p()\n a:=1\n b:=2;\nENDPROC\nENDMODULE", 3, ";"),
        ("MODULE m\nPROC p()\n a:=b AND NOT c;\nENDPROC\nENDMODULE", 3, "parentheses"),
        ("MODULE m\nPROC p()\n a:=b*-1;\nENDPROC\nENDMODULE", 3, "parentheses"),
        ("MODULE m\nPROC p()\n IF a==1 b;\nENDPROC\nENDMODULE", 3, "single"),
        ('MODULE m\nPROC p()\n TPWrite "abc;\nENDPROC\nENDMODULE', 3, "string"),
        ("MODULE m\nPROC p()\n q(1,2);\nENDPROC\nENDMODULE", 3, "without parentheses"),
        ("MODULE m\nPROC p()\n IF a THEN\nENDPROC\nENDMODULE", 3, "ENDIF"),
        ("MODULE m\nPROC p()\nENDPROC\n", 3, "ENDMODULE"),
        ("MODULE m\n\x02\nENDMODULE", 2, "delete"),
        ("MODULE m\nVAR num a:=" + "(" * 500 + "1" + ")" * 500 + ";\nENDMODULE", 2, "simplify"),
    ],
)
def test_a_mistake_has_a_place_and_a_cure(text: str, line: int, cure: str) -> None:
    (finding,) = RAPID.parse(text).findings
    assert finding.line == line
    assert cure in finding.cure
    assert RAPID.render(RAPID.parse(text)) == text


WORDS = st.sampled_from(
    (
        *("MODULE", "ENDMODULE", "PROC", "ENDPROC", "p()", "IF", "THEN", "ENDIF", "FOR", "FROM"),
        *("TO", "DO", "ENDFOR", "TEST", "CASE", "DEFAULT", "ENDTEST", "NOT", "AND", "VAR", "num"),
        *("CONST", "robtarget", "MoveL", "a", "b", "1", "2.5", '"x"', "<SMT>"),
        *"()[]{}=;,.\\%!:\n",
        ":=",
    )
)


@settings(max_examples=drawn(150), deadline=None)
@given(st.lists(WORDS, max_size=40))
def test_no_words_raise(words: list[str]) -> None:
    text = "MODULE m PROC p() " + " ".join(words) + " ENDPROC ENDMODULE"
    tree = RAPID.parse(text)
    assert RAPID.render(tree) == text
    if not tree.findings:
        assert RAPID.parse(RAPID.format(tree)) == tree

"""Findings know what they are about, so that drafts and reports need not read their words."""

from __future__ import annotations

from pathlib import Path

from assistant.base.diagnostics import Declared
from assistant.compiler import Translation, load, translate
from assistant.program import statements as p
from assistant.program.comparison import compare
from assistant.program.program import Procedure, Program, Variable

VALUES = """MODULE Values
    VAR num variable:=nElsewhere;
    PROC main()
        CONST num variable:=nNowhere;
        TPErase;
    ENDPROC
ENDMODULE
"""
ARRAYS = """MODULE Arrays
    VAR num far:=1;
    PROC main()
        VAR num near;
        other;
        near:=far;
    ENDPROC
    PROC other()
        VAR num far{2,2,2,2};
        TPErase;
    ENDPROC
ENDMODULE
"""
WORDS = """MODULE Words
    RECORD list
        num array;
    ENDRECORD
    VAR list lOne;
    PROC first()
        lOne.array:=1;
    ENDPROC
    PROC Use(num array{*,*})
        array{1,1}:=1;
    ENDPROC
ENDMODULE
"""


def translated(folder: Path, text: str) -> Translation:
    file = folder / "cell.mod"
    file.write_text(text, encoding="utf-8", newline="\n")
    return translate(file, to="melfa-basic-5", draft=True)


def test_a_finding_of_a_first_value_tells_table_owner_and_name(tmp_path: Path) -> None:
    found = [f for f in translated(tmp_path, VALUES).compiled.found if f.code == "MB229"]
    assert {(f.about, f.missing) for f in found} == {
        (Declared("variable", "variables", in_full=True), "nElsewhere"),
        (Declared("variable", "variables", "main", in_full=True), "nNowhere"),
    }
    assert {f.place for f in found} == {"variable variable", "procedure main variable variable"}


def test_a_draft_leaves_out_the_first_values_alone(tmp_path: Path) -> None:
    """Although the name of the variables is a word of the places that are shown."""
    found = translated(tmp_path, VALUES)
    assert found.draft, found.written.findings
    written = found.written.program
    assert written.variables["variable"].initial is None
    (data,) = found.files.values()
    for line, value in ((2, b"nElsewhere"), (4, b"nNowhere")):
        _, _, quoted = data.partition(b"not translated, line %d:" % line)
        assert value in quoted.splitlines()[1]
    assert {row.place.line for row in found.rows if row.level == "not"} == {2, 4}


def test_a_draft_leaves_out_what_a_procedure_has_itself(tmp_path: Path) -> None:
    """And not what the program has by the same name."""
    found = translated(tmp_path, ARRAYS)
    assert found.draft, found.written.findings
    (data,) = found.files.values()
    assert b"not translated, line 9:" in data
    assert {row.place.line for row in found.rows if row.level == "not"} == {9}
    assert "far" in {name.lower() for name in found.written.program.variables}


def test_a_name_in_a_message_is_not_one_that_is_missing(tmp_path: Path) -> None:
    """A draft leaves out a record with a component `array`, which is also a parameter's name."""
    rows = {row.place.line: row for row in translated(tmp_path, WORDS).rows}
    (line,) = (at for at, row in rows.items() if row.text.startswith("PROC Use"))
    assert "MB209" in [reason.code for reason in rows[line].reasons]
    assert "CO007" not in [reason.code for reason in rows[line].reasons]


def test_a_mismatch_tells_what_it_is_a_part_of() -> None:
    def program(size: tuple[int, ...]) -> Program:
        variables = {"n": Variable("number", size=size)}
        return Program("p", (Procedure("main", (), variables=variables),), variables=variables)

    mismatches = compare(program((2,)), program((3,))).mismatches
    assert [m.about.declared for m in mismatches] == [
        Declared("n", "variables"),
        Declared("n", "variables", "main"),
    ]
    assert [str(m.about) for m in mismatches] == [
        "variables n size 1",
        "procedure main variables n size 1",
    ]


def test_spans_count_on_from_one_text_to_the_next(tmp_path: Path) -> None:
    """So that a span alone tells in which file of a program something is."""
    files = {
        "MAIN.prg": '1 Dly 1\n2 CallP "SUB"\n3 End\n',
        "SUB.prg": "1 Dly 2\n2 Dly 3\n3 End\n",
        "a.mod": "MODULE a\nPROC main()\nWaitTime 4;\nENDPROC\nENDMODULE\n",
        "b.mod": "MODULE b\nPROC other()\nWaitTime 5;\nENDPROC\nENDMODULE\n",
        "cell.pgf": "<Program><Module>a.mod</Module><Module>b.mod</Module></Program>\n",
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8", newline="\n")
    for name, waits in (("MAIN.prg", ["1", "2", "3"]), ("cell.pgf", ["4", "5"])):
        program = load(tmp_path / name).program
        assert program.origin is not None
        whole = "\n".join(tree.source.text for tree in program.origin.trees)
        spans = [x.span for x in program.statements() if isinstance(x, p.Wait) and x.span]
        assert [whole[s.start : s.end].strip(" ;\n")[-1] for s in spans] == waits


def test_a_name_is_told_to_lack_a_declaration_only_where_it_does(tmp_path: Path) -> None:
    text = (
        "MODULE cell\nVAR wzstationary zone;\nVAR num n;\n"
        "PROC main()\nn:=nowhere;\nn:=zone;\nENDPROC\nENDMODULE\n"
    )
    found = [f for f in translated(tmp_path, text).findings if f.code == "MB229"]
    said = {f.line: f.message for f in found}
    assert "`nowhere` is declared in none of the files" in said[5]
    assert "`zone` is declared, with a type that nothing in MELFA-BASIC is like" in said[6]

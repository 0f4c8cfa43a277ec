"""Damaged programs: every mistake has one finding, at its place, with a cure."""

from __future__ import annotations

import random
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.languages.rapid.reading.parser import parse
from assistant.languages.rapid.reading.recovery import MISTAKES
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.recovery.reader import MOST_FINDINGS
from tests.examples import drawn
from tests.languages.rapid.mistakes import FURTHER
from tests.tables import every_row

RAPID = languages.get("rapid")
PLACE = "¦"
ITEMS = {"VAR", "PERS", "CONST", "PROC", "FUNC", "TRAP", "RECORD"}


def framed(example: str) -> str:
    """An example as a whole file; one that ends with a line end is a file already."""
    word = re.match(r"\W*(\w*)", example)
    first = word[1].upper() if word else ""
    if first == "MODULE" or example.endswith("\n") or example == PLACE:
        return example
    if first in ITEMS:
        return f"MODULE m\n  {example}\nENDMODULE\n"
    return f"MODULE m\nPROC p()\n{example}\nENDPROC\nENDMODULE\n"


@every_row(
    ("cure", "example"),
    [
        *((mistake.cure, mistake.example) for mistake in MISTAKES),
        *((cure, example) for cure, examples in FURTHER.items() for example in examples),
    ],
)
def test_a_usual_mistake_has_one_finding_with_its_cure(cure: str, example: str) -> None:
    marked = framed(example)
    text = marked.replace(PLACE, "")
    (finding,) = RAPID.parse(text).findings
    assert finding.span is not None
    assert finding.span.start == marked.index(PLACE)
    assert finding.cure == cure
    assert finding.excerpt == text.split("\n")[(finding.line or 0) - 1]
    assert RAPID.render(RAPID.parse(text)) == text


@every_row(
    ("example", "right"),
    [
        ("FOR i FROM 1 TO 3 DO\n  b;\n¦NEXT i", "ENDFOR"),
        ("WHILE a DO\n  b;\n¦WEND", "ENDWHILE"),
        ("IF a THEN\n  b;\n¦END", "ENDIF"),
        ("¦SWITCH a\nCASE 1:\n  b;\nENDTEST", "TEST"),
        ("TEST a\nCASE 1:\n  b;\n¦ENDSWITCH", "ENDTEST"),
        ("MODULE m\n¦SUB q()\n  b;\nENDPROC\nENDMODULE", "PROC"),
        ("MODULE m\n¦PROCEDURE q()\n  b;\nENDPROC\nENDMODULE", "PROC"),
        ("MODULE m\nPROC q()\n  b;\n¦END SUB\nENDMODULE", "ENDPROC"),
        ("MODULE m\n¦FUNCTION num q()\n  RETURN 1;\nENDFUNC\nENDMODULE", "FUNC"),
    ],
)
def test_a_word_of_another_language_is_told_the_one_of_rapid(example: str, right: str) -> None:
    marked = framed(example)
    (finding,) = RAPID.parse(marked.replace(PLACE, "")).findings
    assert finding.span is not None
    assert finding.span.start == marked.index(PLACE)
    assert finding.cure == f"write `{right}`"


WHOLE = """\
MODULE cell(SYSMODULE)
  ! what is taught
  CONST robtarget home:=[[600,0,800],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS tooldata gripper:=[TRUE,[[0,0,120],[1,0,0,0]],[1.5,[0,0,60],[1,0,0,0],0,0,0]];
  VAR num count:=0;
  LOCAL VAR bool ready{4}:=[FALSE,FALSE,FALSE,FALSE];

  PROC main()
    VAR num row;
    AccSet 50,50;
    MoveAbsJ [[0,0,0,0,90,0],[9E9,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs,v100,fine,tool0;
    FOR i FROM 1 TO 10 STEP 2 DO
      count:=count+i*(2-row);
      IF count>20 AND (NOT ready{2}) THEN
        pick Offs(home,0,0,100),\\Slow;
        TPWrite "row "\\Num:=i;
      ELSEIF count=7 THEN
        GOTO again;
      ELSE
        WaitDI di_part,1\\MaxTime:=5;
      ENDIF
    ENDFOR
    again:
    WHILE count<30 DO
      Incr count;
      IF count=25 RETURN;
    ENDWHILE
    TEST count
    CASE 1,2:
      Stop;
    DEFAULT:
      MoveL home,v200,z10,gripper\\WObj:=wobj0;
    ENDTEST
  ERROR
    IF ERRNO=ERR_WAIT_MAXTIME THEN
      TRYNEXT;
    ENDIF
  ENDPROC

  PROC pick(robtarget at\\switch Slow|switch Fast,VAR num shots{*})
    MoveJ at,v500,z50,gripper;
    Set do_close;
    shots{1}:=shots{1}+distance(at.trans);
  ENDPROC

  FUNC num distance(pos p)
    RETURN Sqrt(p.x*p.x+p.y*p.y);
  ENDFUNC

  TRAP halt
    StopMove;
    count:=-1;
  ENDTRAP
ENDMODULE
"""
WORDS = re.compile(r'"[^"\n]*"|![^\n]*|:=|<=|>=|<>|\w+(?:\.\d+)?|[^\s\w]')


def damaged(text: str, kind: str, row: int) -> tuple[str, int]:
    """The text with one word dropped, doubled or swapped with the next, and the line of it."""
    words = [m for m in WORDS.finditer(text) if not m[0].startswith("!")]
    word, further = words[row % (len(words) - 1)], words[row % (len(words) - 1) + 1]
    line = text.count("\n", 0, word.start()) + 1
    if kind == "dropped":
        return text[: word.start()] + text[word.end() :], line
    if kind == "doubled":
        return f"{text[: word.end()]} {text[word.start() :]}", line
    between = text[word.end() : further.start()]
    return (
        f"{text[: word.start()]}{further[0]} {between}{word[0]} {text[further.end() :]}",
        line,
    )


def test_damage_is_found_where_it_is() -> None:
    chosen = random.Random(3)
    rows = sorted(chosen.sample(range(400), 60))
    seen = near = cascades = 0
    for kind in ("dropped", "doubled", "swapped"):
        for row in rows:
            text, line = damaged(WHOLE, kind, row)
            tree = RAPID.parse(text)
            assert RAPID.render(tree) == text
            if tree.findings:
                seen += 1
                near += any(abs((f.line or 0) - line) <= 2 for f in tree.findings)
                cascades += len(tree.findings) > 2
    assert seen > 90
    assert near >= 0.95 * seen
    assert cascades <= 0.05 * seen


def test_reading_goes_on_behind_each_mistake() -> None:
    text = WHOLE.replace("AccSet 50,50;", "AccSet 50,50").replace("Stop;", "Stop(1,2);")
    text = text.replace("RETURN Sqrt(", "RETURN Sqrt((").replace("ENDTRAP", "END TRAP")
    tree = RAPID.parse(text)
    lines = [finding.line for finding in tree.findings]
    words = ("AccSet", "Stop(", "Sqrt(", "END TRAP")
    assert lines == [text[: text.index(word)].count("\n") + 1 for word in words]
    (module,) = tree.modules
    routines = [item for item in module.items if isinstance(item, s.Routine)]
    assert [routine.name for routine in routines] == ["main", "pick", "distance", "halt"]
    assert [len(r.body) for r in routines] == [len(r.body) for r in _routines(WHOLE)]
    assert RAPID.render(tree) == text
    assert RAPID.format(tree) == text


def _routines(text: str) -> list[s.Routine]:
    (module,) = RAPID.parse(text).modules
    return [item for item in module.items if isinstance(item, s.Routine)]


def test_the_mended_tree_is_that_of_the_whole_text() -> None:
    for dropped in (";\n    MoveAbsJ", " THEN\n        pick", " DO\n      Incr", "ENDFOR\n"):
        text = WHOLE.replace(dropped, dropped.lstrip(";").removeprefix(" THEN").removeprefix(" DO"))
        text = text.replace("ENDFOR\n", "") if dropped == "ENDFOR\n" else text
        tree = RAPID.parse(text)
        assert len(tree.findings) == 1, (dropped, tree.findings)
        assert len(_routines(text)) == 4


def test_a_cut_file_ends_too_early() -> None:
    (finding,) = RAPID.parse("MODULE m\n  VAR num a:=1;\n  VAR num b{\n").findings
    assert finding.line == 3
    assert "the end of the text" in finding.message


def test_findings_are_capped() -> None:
    text = "MODULE m\nPROC p()\n" + "a = 1;\n" * 3 * MOST_FINDINGS + "ENDPROC\nENDMODULE\n"
    findings = RAPID.parse(text).findings
    assert len(findings) == MOST_FINDINGS + 1
    assert findings[-1].code == "RA104"


@pytest.mark.parametrize("before", ["a:=1", "q", "IF a", "a:=(1;", "b(1,2);", "IF a=1 THEN x y;"])
def test_columns_and_grammar_mend_alike(before: str) -> None:
    moves = "".join(f"  MoveL p{i},v100,z10,tool0;\n" for i in range(12))
    text = f"MODULE m\nPROC p()\n{before}\n{moves}ENDPROC\nENDMODULE\n"
    fast, slow = parse(text), parse(text, runs=False)
    assert fast == slow
    assert fast.findings == slow.findings


SNIPPETS = st.sampled_from([line for line in WHOLE.split("\n") if line.strip()])


@settings(max_examples=drawn(60), deadline=None)
@given(st.lists(SNIPPETS, max_size=25))
def test_lines_in_any_order_are_read(lines: list[str]) -> None:
    text = "\r\n".join(lines)
    tree = RAPID.parse(text)
    assert RAPID.render(tree) == text
    assert len(tree.findings) <= MOST_FINDINGS + 1
    assert all(f.line and f.excerpt is not None for f in tree.findings)
    assert parse(text, runs=False) == tree


@pytest.mark.parametrize(
    "expression",
    ["+".join("1" * 400), "a" + ".b" * 400, '"a"' + '+"b"' * 400, "f(1)" + "+f(1)" * 400],
)
def test_an_endless_row_of_operators_is_refused(expression: str) -> None:
    tree = RAPID.parse(f"MODULE m\nPROC main()\nx:={expression};\nENDPROC\nENDMODULE\n")
    (finding,) = RAPID.check([tree])
    assert (finding.code, finding.line) == ("RA108", 3)


def test_long_rows_of_operators_are_read() -> None:
    table = ",".join("-1.5" for _ in range(400))
    text = f"MODULE m\nCONST num t{{400}}:=[{table}];\nPROC main()\nx:={'+'.join('1' * 140)};\n"
    tree = RAPID.parse(text + "ENDPROC\nENDMODULE\n")
    assert not tree.findings
    again = RAPID.lower(RAPID.lift(tree))
    assert again == tree
    assert not [f for f in RAPID.check([tree]) if f.severity == "error"]


def test_a_mistake_on_the_next_line_is_one_of_its_own() -> None:
    body = "MoveL p1,v100,fine,tool0\nIF reg1 == 2 THEN\nSet do1;\nEND IF\n"
    tree = RAPID.parse(f"MODULE m\nPROC main()\n{body}ENDPROC\nENDMODULE\n")
    assert [finding.line for finding in tree.findings] == [3, 4, 6]
